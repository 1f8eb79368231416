"""A controller's own signals: declared with units, recorded under names that say the unit, drawn; and how not to."""

from __future__ import annotations

import json
import textwrap

import numpy as np
import pytest
from PIL import Image

from uavftc.core.signals import COLUMNS
from uavftc.errors import InputError
from uavftc.flight.build import build_flight
from uavftc.flight.fly import fly_to_memory
from uavftc.flight.recorder import published
from uavftc.jobs.fly import fly_mission
from uavftc.results.flight import notes_of
from uavftc.results.history import read_history
from uavftc.scenario.load import load_scenario

SOURCE = """
    import numpy as np
    def create(design, h, options):
        B_inverse = np.linalg.pinv(design.B)
        n = [0]
        def step(t, x1_c, x1, x2):
            v1 = 0.5 * (x1_c - x1)
            n[0] += 1
            more = {"v1": v1, "sample": n[0], "e": x1_c - x1, "x2_tilde": (v1 - x2).tolist(), "q_rad": x1[1]}
            if t >= 0.5:
                del more["e"]
            return B_inverse @ (4.0 * (v1 - x2)), more
        return step, {"sample": "1", "e": ("rad", ("phi", "theta", "psi")), "x2_tilde": ("rad/s", 3), "q_rad": "rad",
                      "never": "m/s^2"}
    """
BARE = SOURCE.split("        return step,", maxsplit=1)[0] + "        return step\n"
"""The same without its declaration."""
OWN = [
    "sample", "e_phi_rad", "e_theta_rad", "e_psi_rad", "x2_tilde_1_radps", "x2_tilde_2_radps", "x2_tilde_3_radps",
    "q_rad", "never_mps2",
]  # fmt: skip


@pytest.fixture
def scenario(tmp_path):
    """Write a controller and return the scenario that flies it."""

    def _scenario(source=SOURCE, plant="analytic", *overrides):
        (tmp_path / "mine.py").write_text(textwrap.dedent(source), encoding="utf-8")
        overrides = ("duration_s=1", *overrides)
        return load_scenario("scenario3", plant=plant, controller=str(tmp_path / "mine.py"), overrides=overrides)

    return _scenario


@pytest.mark.parametrize("plant", ["analytic", "jsbsim"])
def test_what_is_declared_is_in_the_history_behind_the_others(scenario, plant):
    flight = build_flight(scenario(plant=plant))
    records, outcome = fly_to_memory(flight)
    assert outcome.completed
    history = published(records, flight.columns)
    assert list(history)[-len(OWN) :] == OWN
    assert list(history)[: len(COLUMNS)] == [c.name for c in COLUMNS]
    np.testing.assert_array_equal(history["sample"], np.arange(1, 202))  # a count of the flight, not of the trial
    np.testing.assert_array_equal(history["x2_tilde_2_radps"], (records["v1"] - records["x2_meas"])[:, 1])
    early = records["t"] < 0.5
    np.testing.assert_array_equal(history["e_psi_rad"][early], (records["x1_c"] - records["x1_meas"])[early, 2])
    assert np.isnan(history["e_psi_rad"][~early]).all()  # what it does not return is missing, not zero
    assert np.isnan(history["never_mps2"]).all()
    assert notes_of(flight) == notes_of(build_flight(scenario(plant=plant)))  # all is declared: no remark


def test_the_flight_is_the_same_to_the_bit_without_its_signals(scenario):
    flown = []
    for source in (SOURCE, BARE):
        records, _ = fly_to_memory(build_flight(scenario(source, "jsbsim")))
        flown.append(records)
    for field in ("x1", "x2", "v1", "v2", "u2", "effectors"):
        assert flown[0][field].tobytes() == flown[1][field].tobytes()
    assert flown[1].dtype["signals"].shape == (0,)


def test_a_mission_writes_and_draws_them(scenario, tmp_path):
    document, _ = fly_mission(scenario(plant="jsbsim"), tmp_path / "out", figures=True)
    history = read_history(tmp_path / "out" / "history.parquet")
    assert list(history)[-len(OWN) :] == OWN
    assert np.isnan(history["e_phi_rad"][-1])
    assert "figures/custom.png" in document["files"]
    with Image.open(tmp_path / "out" / "figures" / "custom.png") as image:
        assert image.size[0] == 1650
    json.dumps(document)


def test_a_controller_without_signals_has_no_such_figure(scenario, tmp_path):
    document, _ = fly_mission(scenario(BARE), tmp_path / "out")
    assert "figures/custom.png" not in document["files"]
    (line,) = [w for w in document["warnings"] if "declar" in w]
    assert line == (
        "the controller returned 'e', 'q_rad', 'sample', 'x2_tilde' without declaring it: not recorded "
        "(docs/custom-controller.md)"
    )


def returning(signals: str, telemetry: str = "{}") -> str:
    step = f"lambda t, x1_c, x1, x2: ((0, 0, 0), {telemetry})"
    return f"def create(design, h, options):\n    return {step}, {signals}\n"


def nested(n: int) -> str:
    return "{" + ", ".join(f"'s{i}': ('1', 3)" for i in range(n)) + "}"


WRONG = {
    "no map": ("5", ["signals", "found:    5", "a map of names to units"]),
    "a list": ("['omega']", ["['omega']", "a map of names to units"]),
    "an unknown unit": ("{'w': 'rads'}", ["w: 'rads'", "rad/s", "did you mean rad"]),
    "no unit": ("{'w': None}", ["w: None", '"1" is for what has none']),
    "a unit of another type": ("{'w': 3}", ["w: 3"]),
    "a name that is no name": ("{'w hat': '1'}", ["'w hat'", "letters, digits and _"]),
    "a name that is no text": ("{3: '1'}", ["the name 3"]),
    "a long name": ("{'w' * 61: '1'}", ["at most 60"]),
    "a column of every flight": ("{'throttle': '1'}", ["throttle", "a column of every flight", "own_throttle"]),
    "one of the aircraft": ("{'left_aileron': 'rad'}", ["left_aileron_rad is a column of every flight"]),
    "by its unit": ("{'phi': 'rad'}", ["phi, whose column phi_rad"]),
    "two of one column": ("{'a': ('1', 2), 'a_1': '1'}", ["a_1, whose column a_1 is one of a"]),
    "recorded already": ("{'v1': ('rad/s', 3)}", ["the name v1", "recorded already"]),
    "none": ("{'a': ('1', 0)}", ["a: ('1', 0)", "n from 1 to 256"]),
    "a count that is none": ("{'a': ('1', 2.5)}", ["a: ('1', 2.5)"]),
    "labels that are none": ("{'a': ('1', ('x', ''))}", ["a: ('1', ('x', ''))"]),
    "far too many": (nested(100), ["300 numbers", "at most 256"]),
    "a huge vector": ("{'a': ('1', 10**12)}", ["n from 1 to 256"]),
    "a tuple of three": ("{}, 1", ["what create(design, h, options) returned", "map of its signals"]),
}


@pytest.mark.parametrize("case", WRONG)
def test_a_declaration_that_is_wrong_is_refused_with_what_is_right(scenario, case):
    signals, words = WRONG[case]
    with pytest.raises(InputError) as error:
        build_flight(scenario(returning(signals)))
    message = str(error.value)
    assert "mine.py" in message
    for word in words:
        assert word in message, message


VALUES = {
    "a number too few": ("{'a': ('1', 3)}", "{'a': [1, 2]}", "three numbers as a"),
    "no vector": ("{'a': ('1', 2)}", "{'a': 1.0}", "2 numbers as a"),
    "no number": ("{'a': '1'}", "{'a': 'x'}", "a number as a"),
    "a vector": ("{'a': '1'}", "{'a': [1.0]}", "a number as a"),
    "a truth value": ("{'a': '1'}", "{'a': True}", "a number as a"),
}


@pytest.mark.parametrize("case", VALUES)
def test_a_value_that_is_none_is_refused_at_the_trial_and_ends_a_flight(scenario, case):
    signals, telemetry, words = VALUES[case]
    with pytest.raises(InputError, match=words):
        build_flight(scenario(returning(signals, telemetry)))
    _, outcome = fly_to_memory(build_flight(scenario(returning(signals, f"{telemetry} if t > 0.5 else {{}}"))))
    assert f"expected {words}" in outcome.ended_because
    assert outcome.ended_at_s == 0.505


@pytest.mark.parametrize("value", ["np.float32(2)", "np.array(2)", "2", "2.0", "np.int8(2)"])
def test_numbers_of_every_sort_are_numbers(scenario, value):
    source = "import numpy as np\n" + returning("{'a': '1', 'b': ('1', 2)}", f"{{'a': {value}, 'b': [{value}, 1]}}")
    flight = build_flight(scenario(source))
    records, _ = fly_to_memory(flight)
    np.testing.assert_array_equal(published(records, flight.columns)["a"], 2.0)


def test_signals_that_change_between_the_trial_and_the_flight_are_refused(scenario):
    source = (
        "n = [0]\ndef create(d, h, o):\n    n[0] += 1\n    return (lambda t, a, b, c: (0, 0, 0)), {f's{n[0]}': '1'}\n"
    )
    with pytest.raises(InputError, match="other signals"):
        build_flight(scenario(source))
