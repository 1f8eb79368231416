"""Custom controllers: both forms flown, what they are given, what is recorded, and how they may fail."""

from __future__ import annotations

import re
import sys
import textwrap
import tomllib
from pathlib import Path

import numpy as np
import pytest

from uavftc.control.custom.module import GROUP, SHIPPED, registered
from uavftc.core.program import STEP_FAILED, Program
from uavftc.core.signals import as_records, empty_rows
from uavftc.core.stage import PythonBlock, Stage, StepFailed, law
from uavftc.errors import InputError
from uavftc.flight.build import build_flight
from uavftc.flight.fly import fly_to_memory
from uavftc.scenario.load import load_scenario, scenario_text

ROOT = Path(__file__).parents[2]

PLAIN = """
import numpy as np

def create(design, h, options):
    B_inverse = np.linalg.inv(design.B)
    def step(t, x1_c, x1, x2):
        v1 = 0.5 * (x1_c - x1)
        return B_inverse @ (4.0 * (v1 - x2)), {"v1": v1}
    return step
"""

COMPILED = """
import numpy as np
from uavftc.core.stage import Stage, law, params_of

PARAMS = np.dtype([("B_inverse", "f8", (3, 3))])
STATE = np.dtype([("e", "f8", (3,))])

def params(design, h, options):
    return params_of(PARAMS, B_inverse=np.linalg.inv(design.B))

@law
def step(p, s, row):
    for i in range(3):
        row.v1[i] = 0.5 * (row.x1_c[i] - row.x1_meas[i])
        s.e[i] = 4.0 * (row.v1[i] - row.x2_meas[i])
    for i in range(3):
        row.v2[i] = p.B_inverse[i, 0] * s.e[0] + p.B_inverse[i, 1] * s.e[1] + p.B_inverse[i, 2] * s.e[2]

stage = Stage(step, PARAMS, STATE)
"""

EARLIER = COMPILED.replace("from uavftc.core.stage import", "from uavftc.stage import carray,").replace(
    "stage = Stage(step, PARAMS, STATE)",
    "@Stage(PARAMS, STATE)\ndef stage(p, s, row):\n    step(carray(p, 1)[0], carray(s, 1)[0], carray(row, 1)[0])",
)
"""The same law, written for an earlier version."""

EARLIER_RAW = """
import numpy as np
from uavftc.stage import RAW, Stage, carray, law, params_of

PARAMS = np.dtype([("B_inverse", "f8", (3, 3))])
STATE = RAW

def params(design, h, options):
    return params_of(PARAMS, B_inverse=np.linalg.inv(design.B))

def state(design, h, options):
    return np.zeros(4)

@law
def command(p, e, row):
    for i in range(3):
        row.v1[i] = 0.5 * (row.x1_c[i] - row.x1_meas[i])
        e[1 + i] = 4.0 * (row.v1[i] - row.x2_meas[i])
    for i in range(3):
        row.v2[i] = p.B_inverse[i, 0] * e[1] + p.B_inverse[i, 1] * e[2] + p.B_inverse[i, 2] * e[3]

@Stage(PARAMS, STATE)
def stage(p, s, row):
    command(carray(p, 1)[0], carray(s, 4), carray(row, 1)[0])
"""


@pytest.fixture
def fly(tmp_path):
    """Write a controller, fly it, return (flight, records, outcome)."""

    def _fly(source, plant="analytic", *overrides, scenario="scenario3", name="mine.py"):
        (tmp_path / name).write_text(textwrap.dedent(source), encoding="utf-8")
        loaded = load_scenario(scenario, plant=plant, controller=str(tmp_path / name), overrides=overrides)
        flight = build_flight(loaded)
        return flight, *fly_to_memory(flight)

    return _fly


def python_of(body: str) -> str:
    """Return the source of a controller whose step has this body; it remembers `n`, the number of earlier calls."""
    head = "def create(design, h, options):\n    n = [0]\n    def step(t, x1_c, x1, x2):\n"
    return head + textwrap.indent(textwrap.dedent(body), " " * 8) + "\n    return step\n"


@pytest.mark.parametrize("plant", ["analytic", "jsbsim"])
def test_both_forms_of_a_law_fly_the_same(fly, plant):
    # the form is a matter of speed: the same numbers up to the order of a sum
    _, plain, one = fly(PLAIN, plant)
    _, compiled, two = fly(COMPILED, plant, name="law.py")
    assert one.completed
    assert two.completed
    for field in ("x1", "x2", "v1", "v2", "u2"):
        np.testing.assert_allclose(plain[field], compiled[field], rtol=0, atol=1e-9)
    assert np.all(np.isnan(plain["d1_hat"]))  # what a controller does not report is missing, not zero
    assert np.all(np.isnan(compiled["f_hat"]))
    np.testing.assert_array_equal(plain["v1"], 0.5 * (plain["x1_c"] - plain["x1_meas"]))


@pytest.mark.parametrize("source", [EARLIER, EARLIER_RAW], ids=["records", "memory of its own"])
def test_a_law_written_for_an_earlier_version_flies_the_same_bits(fly, source):
    # a compiled controller of an earlier version still flies: its entry and its imports mean the same law
    for plant in ("analytic", "jsbsim"):
        _, new, one = fly(COMPILED, plant, name="law.py")
        _, earlier, two = fly(source, plant, name="earlier.py")
        assert one.completed
        assert two.completed
        assert earlier.tobytes() == new.tobytes()


@pytest.mark.parametrize("source", [PLAIN, COMPILED])
def test_flown_again_from_its_own_text_it_is_identical_to_the_bit(fly, source, tmp_path):
    flight, first, _ = fly(source, "jsbsim", "duration_s=4")
    (tmp_path / "elsewhere").mkdir()
    file = tmp_path / "elsewhere" / "scenario.yaml"
    file.write_text(scenario_text(flight.scenario), encoding="utf-8")
    again, _ = fly_to_memory(build_flight(load_scenario(file)))
    assert first.tobytes() == again.tobytes()


def test_the_examples_of_the_page_fly(fly):
    # documentation that does not run is worse than none
    text = (ROOT / "docs" / "custom-controller.md").read_text(encoding="utf-8")
    examples = re.findall(r"`(\w+\.py)`[^`]*\n\n```python\n(.*?)```", text, flags=re.S)
    assert [name for name, _ in examples] == ["my_controller.py", "my_law.py"]
    for name, source in examples:
        for plant in ("analytic", "jsbsim"):
            _, records, outcome = fly(source, plant, scenario="scenario1", name=name)
            assert outcome.completed
            error = np.degrees(np.abs(records["x1_c"] - records["x1"]))[-1].max()
            assert error < (3.0 if plant == "jsbsim" else 0.5)  # the page says 2 deg, for want of an integral
            assert np.all(np.isfinite(records["v1"]))


def test_what_create_is_given(fly):
    source = """
        import numpy as np
        def create(design, h, options):
            assert h == 0.01 and options == {"gain": 2, "list": [1, "a"]} and design.name == "hale"
            assert design.A.shape == design.B.shape == (3, 3) and design.x1_trim.shape == (3,)
            np.testing.assert_allclose(design.B, [[10, 0, 0.225], [0, 7.5, 0], [1.125, 0, 6.75]])
            np.testing.assert_allclose(design.limits_rad[0], [-0.05, 0.1])
            np.testing.assert_allclose(design.limits_rad[2], [-0.436332312999, 0.436332312999])
            options["list"].append("changed"); design.B[:] = 0  # copies: the next flight does not see it
            return lambda t, x1_c, x1, x2: (0, 0.0, np.float32(0))
        """
    limits = "saturation={aileron: {min_rad: -0.05, max_rad: 0.1}}"
    overrides = ("controller.rate_hz=100", "controller.options={gain: 2, list: [1, a]}", limits, "duration_s=0.1")
    _, records, outcome = fly(source, "analytic", *overrides)
    assert outcome.completed
    assert np.all(records["v2"] == 0.0)


def test_what_step_is_given_are_copies_of_what_the_sensors_show(fly):
    body = """
        seen.append((t, x1_c, x1, x2)); result = (x1 - x2) * 0.1
        x1 += 99; x2[:] = 99; x1_c *= 0
        return result
        """
    source = "seen = []\n" + python_of(body)
    bias = "sensors.gyro_bias_degps=[1, 2, 3]"
    _, records, outcome = fly(source, "analytic", bias, "duration_s=0.5")
    assert outcome.completed
    np.testing.assert_array_equal(records["v2"], (records["x1_meas"] - records["x2_meas"]) * 0.1)
    np.testing.assert_allclose((records["x2_meas"] - records["x2"])[5], np.radians([1, 2, 3]), rtol=1e-9)
    np.testing.assert_allclose(records["x1_c"][0], np.radians(5))


def test_the_trial_leaves_no_trace_in_the_flight(fly):
    _, records, _ = fly(python_of("n[0] += 1\nreturn [n[0] * 1e-6] * 3"), "analytic", "duration_s=0.1")
    np.testing.assert_allclose(records["v2"][:, 0], 1e-6 * np.arange(1, 22))


def test_an_object_may_be_the_controller_and_is_made_with_its_folder_on_the_path(fly, tmp_path):
    (tmp_path / "gains_of_mine.py").write_text("K = 0.25\n")
    source = """
        from gains_of_mine import K
        class create:
            def __init__(self, design, h, options): self.k = K
            def __call__(self, t, x1_c, x1, x2): return self.k * (x1_c - x1)
        """
    before = list(sys.path)
    _, records, _ = fly(source, "analytic", "duration_s=0.1")
    assert sys.path == before
    assert not list(tmp_path.rglob("__pycache__"))
    np.testing.assert_array_equal(records["v2"], 0.25 * (records["x1_c"] - records["x1"]))


def test_an_exception_during_the_flight_ends_it_with_the_history_up_to_there(fly, tmp_path):
    source = python_of("if t > 1.0:\n    return 1 / 0\nreturn 0, 0, 0")
    for plant in ("analytic", "jsbsim"):
        _, records, outcome = fly(source, plant)
        assert not outcome.completed
        assert not outcome.interrupted
        place = f"{tmp_path / 'mine.py'}, line 5"
        assert outcome.ended_because == (
            f"the controller failed: ZeroDivisionError: division by zero; {place}: return 1 / 0, at t = 1.005 s"
        )
        assert outcome.ended_at_s == 1.005
        assert records["t"][-1] == 1.0
        assert np.all(np.isfinite(records["v2"]))


HOSTILE = "type('A', (), {'__array__': lambda s, *a, **k: 1 / 0, '__repr__': lambda s: 1 / 0})()"
RESULTS = [
    "(0, 0)",
    "None",
    "5.0",
    "[0, 'x', 0]",
    "(0, 0, 0), {'v1': [1, 2]}",
    "[0j, 0j, 0j]",
    "['1', '2', '3']",
    "'123'",
]
RESULTS += ["{0: 1, 1: 1, 2: 1}", "[10**400, 0, 0]", "[True] * 3", HOSTILE, f"[0, 0, 0], {{'v1': {HOSTILE}}}"]


@pytest.mark.parametrize("result", RESULTS)
def test_a_result_that_turns_wrong_in_flight_ends_it(fly, result):
    _, records, outcome = fly(python_of(f"return ({result}) if t > 0.5 else (0, 0, 0)"), "analytic")
    assert "expected three numbers" in outcome.ended_because
    assert "mine.py" in outcome.ended_because
    assert records["t"][-1] == 0.5


@pytest.mark.parametrize("result", RESULTS)
def test_a_result_is_refused_at_the_trial_as_in_flight(fly, result):
    with pytest.raises(InputError, match="three numbers"):
        fly(python_of(f"return ({result})"), "analytic")


ENDS = [
    "raise KeyboardInterrupt",
    "raise SystemExit(0)",
    "raise GeneratorExit",
    "raise ValueError(chr(0xd800) + chr(27))",
]


@pytest.mark.parametrize("body", ENDS)
def test_whatever_a_step_raises_is_the_controllers_failure_and_can_be_printed(fly, body):
    with pytest.raises(InputError, match="line 4") as error:
        fly(python_of(body), "analytic")
    assert error.value.found.isprintable()
    _, records, outcome = fly(python_of(f"if t > 0.5: {body}\nreturn 0, 0, 0"), "analytic", name="later.py")
    assert outcome.ended_because.startswith("the controller failed: ")
    assert outcome.ended_because.isprintable()
    assert records["t"][-1] == 0.5


def test_a_step_that_blocks_ends_the_flight_at_its_time_limit(fly):
    body = "if t > 0.5:\n    import time; time.sleep(3600)\nreturn 0, 0, 0"
    _, records, outcome = fly(python_of(body), "jsbsim", "controller.timeout_s=0.2")
    assert "took longer than controller.timeout_s, 0.2 s; " in outcome.ended_because
    assert "mine.py, line 5" in outcome.ended_because
    assert records["t"][-1] == 0.5
    with pytest.raises(InputError, match=r"raise controller\.timeout_s"):
        fly(python_of("import time; time.sleep(3600)"), "analytic", "controller.timeout_s=0.2")


def compiled_that(action):
    """Return the source of a compiled law that does this at last."""
    return COMPILED.replace("\nstage =", f"    {action}\n\nstage =").replace("\n\n    ", "\n    ")


@pytest.mark.parametrize("status", ["7", "2", "-1", "-250", "np.nan"])
def test_a_compiled_law_may_not_set_the_status(fly, status):
    # it says how a vehicle is lost: any other number had no words, and these had the wrong ones
    with pytest.raises(InputError, match=r"writes row.status"):
        fly(compiled_that(f"row.status = {status}"), "analytic")
    later = compiled_that(f"if row.t > 0.501: row.status = {status}")
    _, records, outcome = fly(later, "analytic", name="later.py")
    assert outcome.ended_because.startswith("the controller set row.status")
    assert records["t"][-1] == 0.5


def test_a_compiled_law_that_raises_is_reported_with_its_line_at_the_trial_and_its_name_in_flight(fly):
    with pytest.raises(InputError, match="ValueError: enough") as error:
        fly(compiled_that("raise ValueError('enough')"), "analytic")
    assert "raise ValueError('enough')" in error.value.found
    later = compiled_that("if row.t > 0.501: raise ValueError('enough')")
    _, records, outcome = fly(later, "jsbsim", name="later.py")
    assert outcome.ended_because == "the law custom raised an exception, at t = 0.505 s"
    assert records["t"][-1] == 0.5


def test_a_module_whose_getattr_raises_is_reported_with_its_line(fly):
    with pytest.raises(InputError, match="RuntimeError: no create") as error:
        fly("def __getattr__(name):\n    raise RuntimeError(f'no {name}')", "analytic")
    assert error.value.remedy == "correct line 2"


def test_a_result_that_is_no_number_any_more_is_the_watchs(fly):
    _, _, outcome = fly(python_of("return [float('nan')] * 3 if t > 0.5 else [0] * 3"), "analytic")
    assert outcome.ended_because.startswith("a state or command is not a number")


def test_a_failure_at_the_first_sample_is_a_flight_of_no_rows(fly):
    _, records, outcome = fly(python_of("assert x1_c[0] < 0.05\nreturn 0, 0, 0"), "analytic")
    assert len(records) == outcome.rows == 0
    assert "AssertionError" in outcome.ended_because


WRONG = {
    "no function": ("create = 5", ["create: 5", "create(design, h, options)"]),
    "nothing in it": ("x = 1", ["neither create nor PARAMS"]),
    "arguments of create": ("def create(design):\n    pass", ["mine.py, create", "create(design)", "too many"]),
    "arguments of step": (
        "def create(d, h, o):\n    return lambda t, x: 0",
        ["mine.py, step", "(t, x)", "x1_c, x1, x2"],
    ),
    "create returns nothing": ("def create(d, h, o):\n    pass", ["what create", "None", "return a function step"]),
    "an exception in create": (
        "def create(d, h, o):\n    x = 1\n    return o['gain']",
        ["KeyError: 'gain'", "mine.py, line 3: return o['gain']", "correct line 3"],
    ),
    "an exception in step": (python_of("return undefined"), ["NameError", "line 4: return undefined", "step(t, x1_c"]),
    "exit in step": (python_of("raise SystemExit(7)"), ["SystemExit: 7", "line 4"]),
    "an exception at the top": ("import numpy\n1 / 0", ["ZeroDivisionError", "line 2: 1 / 0"]),
    "a module that is not there": ("import nowhere_to_be_found", ["nowhere_to_be_found", "line 1"]),
    "syntax": ("def create(:\n", ["SyntaxError", "line 1"]),
    "two numbers": (python_of("return 0, 0"), ["(0, 0)", "three numbers", "aileron, elevator, rudder"]),
    "a column": (python_of("import numpy\nreturn numpy.zeros((3, 1))"), ["shape (3, 1)"]),
    "texts": (python_of("return ['1', '2', '3']"), ["['1', '2', '3']"]),
    "not finite": (python_of("return [0, 0, float('nan')]"), ["nan", "three numbers"]),
    "telemetry": (python_of("return (0, 0, 0), {'v1': 3}"), ["three numbers as v1", "found:    3"]),
    "a compiled law without params": (COMPILED.replace("def params", "def parameters"), ["no function params"]),
    "a compiled law without STATE": (
        COMPILED.replace("STATE = ", "ST = ").replace("PARAMS, STATE)", "PARAMS, ST)"),
        ["no dtype STATE", "define STATE"],
    ),
    "params of another type": (
        COMPILED.replace("return params_of(PARAMS, B_inverse=np.linalg.inv(design.B))", "return design.B"),
        ["params(design, h, options)", "shape (3, 3)", "params_of"],
    ),
    "a law that does not compile": (
        COMPILED.replace("row.v1[i] = 0.5", "row.v9[i] = 0.5"),
        ["mine.py, stage", "v9", "numba can compile"],
    ),
    "a law that commands nan": (COMPILED.replace("row.v2[i] =", "row.v2[i] = np.nan *"), ["finite command"]),
    "a compiled law whose stage is none": (
        COMPILED.replace("stage = Stage(step, PARAMS, STATE)", "stage = step"),
        ["expected: stage, a uavftc.core.stage.Stage", "define stage = Stage(step, PARAMS, STATE)"],
    ),
    "both forms": (COMPILED + PLAIN, ["both create and stage"]),
}


@pytest.mark.parametrize("case", WRONG)
def test_what_is_wrong_with_a_controller_is_reported_before_the_flight(fly, case):
    source, words = WRONG[case]
    with pytest.raises(InputError) as error:
        fly(source, "analytic")
    message = str(error.value)
    assert "mine.py" in message
    for word in words:
        assert word in message, message


def test_a_compiled_law_is_compiled_anew_when_it_or_its_neighbour_changes(fly, tmp_path):
    # numba looks at the file of the entry only; a stale law would fly silently
    source = COMPILED.replace("from uavftc", "from neighbour import gain\nfrom uavftc", 1)
    source = source.replace("s.e[i] = 4.0", "s.e[i] = gain() * 4.0")
    for factor in (1.0, 0.5):
        (tmp_path / "neighbour.py").write_text(
            f"from uavftc.core.stage import law\n@law\ndef gain():\n    return {factor}\n"
        )
        sys.modules.pop("neighbour", None)
        for name in [name for name in sys.modules if name.startswith("custom_controller_mine")]:
            del sys.modules[name]  # as in a new process
        _, records, _ = fly(source, "analytic", "duration_s=0.1")
        expected = factor * np.linalg.solve(np.array([[10, 0, 0.225], [0, 7.5, 0], [1.125, 0, 6.75]]), np.full(3, 2.0))
        np.testing.assert_allclose(records["v2"][0], expected * np.radians(5), rtol=1e-9)
    sys.modules.pop("neighbour", None)
    _, halved, _ = fly(source.replace("gain() * 4.0", "gain() * 2.0"), "analytic", "duration_s=0.1")
    np.testing.assert_allclose(halved["v2"][0], 0.5 * records["v2"][0], rtol=1e-9)


@law
def doubled(p, s, row):
    row.v2[0] *= 2.0


def test_python_steps_run_in_their_place_between_compiled_ones():
    # the order of the blocks is the order of the loop, whatever each is written in; a failure ends the row there
    def add(row):
        as_records(row[None, :])["v2"] += 4.0

    def doubling(name):
        return Stage(doubled).block(name=name)

    rows = empty_rows(5)
    as_records(rows)["v2"] = 1.0
    blocks = [doubling("first"), PythonBlock("one", add), doubling("second"), PythonBlock("two", add)]
    assert Program(blocks).run(rows, 1, 4) == 4
    np.testing.assert_array_equal(as_records(rows)["v2"][:, 0], [1, 16, 16, 16, 1])

    def fail(row):
        if row[0] == 2.0:
            raise StepFailed("enough")

    rows = empty_rows(5)
    as_records(rows)["t"] = range(5)
    program = Program([PythonBlock("fails", fail), PythonBlock("adds", add)])
    assert program.run(rows, 0, 5) == 2
    assert program.failure == program.why(STEP_FAILED) == "enough"
    assert as_records(rows)["status"][2] == STEP_FAILED
    np.testing.assert_array_equal(as_records(rows)["v2"][:, 0], [4, 4, 0, 0, 0])


def test_the_shipped_controllers_are_entry_points_of_this_project():
    # the table that serves a checkout without metadata says what pyproject says
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert project["entry-points"][GROUP] == SHIPPED
    assert set(SHIPPED) <= set(registered())
