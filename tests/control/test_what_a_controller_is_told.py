"""What a step may ask for: positions, air, and what is known of faults; what it does not ask for costs nothing.

Each quantity is compared with what the history has of it: the controller is shown the flight, not a copy of its model.
"""

from __future__ import annotations

import sys
import textwrap

import numpy as np
import pytest

from flying import given_of
from tails import v_tail, with_servo
from uavftc.analysis.metrics import metrics_of
from uavftc.control.custom.known import fields_of
from uavftc.control.custom.measured import MEASURED, STANDARD_GRAVITY, Aboard, readers
from uavftc.core.layout import shares
from uavftc.core.signals import COLUMNS, as_records, empty_rows
from uavftc.errors import InputError
from uavftc.flight.build import build_flight
from uavftc.flight.fly import fly_to_memory
from uavftc.flight.recorder import published
from uavftc.plants.interface import Timing
from uavftc.results.flight import FlightResult, notes_of, origin_of
from uavftc.scenario.load import load_scenario
from uavftc.scenario.schema import FAULTS

FAULT = "faults=[{surface: aileron, start_s: 0.2, end_s: 0.9, effectiveness: '0.5 + 0.1*sin(9*t)', bias_deg: 0.3}]"
SEEN = """
    import numpy as np
    seen = []
    def create(design, h, options):
        B_inverse = np.linalg.pinv(design.B)
        created.append(design)
        def step(t, x1_c, x1, x2, *, {names}):
            seen.append((t, {{{pairs}}}))
            v1 = 0.5 * (x1_c - x1)
            return B_inverse @ (4.0 * (v1 - x2)), {{"v1": v1}}
        return step
    created = []
    """


def that_sees(*names: str) -> str:
    """Return a controller that keeps what it is given, copied: (t, {name: value}) of each sample."""
    pairs = ", ".join(
        f"{n!r}: np.copy({n})" if n in ("positions", "u2", "accelerations") else f"{n!r}: {n}" for n in names
    )
    return SEEN.format(names=", ".join(names), pairs=pairs)


def module_of(name: str):
    """Return the module of a controller's file by its stem, the one that was loaded last."""
    return [module for key, module in sys.modules.items() if key.startswith(f"custom_controller_{name}_")][-1]


class Flown:
    """A flight of a controller, and what its step was given."""

    def __init__(self, folder, source, plant="analytic", *overrides, scenario="scenario3", aircraft=None, name="told"):
        file = folder / f"{name}.py"
        file.write_text(textwrap.dedent(source), encoding="utf-8")
        overrides = ("duration_s=1.5", *overrides)
        loaded = load_scenario(scenario, plant=plant, aircraft=aircraft, controller=str(file), overrides=overrides)
        self.flight = build_flight(loaded)
        self.tried = len(getattr(module_of(name), "seen", ()))
        self.records, self.outcome = fly_to_memory(self.flight)
        assert self.outcome.completed, self.outcome.ended_because
        self.history = published(self.records, self.flight.columns)
        self.module = module_of(name)

    @property
    def seen(self):
        """What it was given, at each sample of the flight."""
        return [more for _, more in self.module.seen[self.tried :]]

    def of(self, name):
        """Return one quantity over the flight."""
        return np.array([more[name] for more in self.seen])


CASES = {
    "analytic": ("analytic", ("left_aileron_rad", "right_aileron_rad", "elevator_rad", "rudder_rad")),
    "jsbsim": (
        "jsbsim", ("left_aileron_rad", "right_aileron_rad", "elevator_position_rad", "rudder_position_rad")
    ),
}  # fmt: skip


@pytest.mark.parametrize("substeps", [1, 4])
@pytest.mark.parametrize("case", CASES)
def test_positions_are_those_of_the_row_before_to_the_bit(tmp_path, case, substeps):
    # under a fault, limits and a delay; at the first sample everything is at its trim
    plant, columns = CASES[case]
    flown = Flown(
        tmp_path, that_sees("positions", "u2"), plant, FAULT, f"simulation.substeps={substeps}",
        "controller.delay_s=0.01", "saturation={min_rad: -0.03, max_rad: 0.02}",
    )  # fmt: skip
    positions, design = flown.of("positions"), flown.module.created[-1]
    shown = np.column_stack([flown.history[name] for name in columns])
    assert np.ptp(shown, axis=0).min() > 1e-4  # every effector moved
    np.testing.assert_array_equal(positions[1:], shown[:-1])
    np.testing.assert_array_equal(positions[0], design.positions_trim_rad)
    np.testing.assert_array_equal(flown.of("u2")[1:], flown.records["u2"][:-1])
    assert not flown.of("u2")[0].any()


def test_a_position_is_shown_as_the_aircraft_counts_it():
    # one that counts against its deflection, as a tail that reports its trailing edge up as positive
    given = given_of(Timing(0.005, 1), 1)
    aboard = Aboard(given, np.array([1.0, -1.0, 1.0]), None, frozenset())
    rows = empty_rows(1)
    as_records(rows)["effectors"]["position"] = [0.1, 0.2, 0.3]
    ((_, read),) = readers(("positions",), aboard)
    np.testing.assert_array_equal(read(rows[0]), [0.1, -0.2, 0.3])


@pytest.mark.parametrize("substeps", [1, 3])
def test_positions_that_jsbsim_reports_are_those_of_the_row_before_too(tmp_path, substeps):
    # the rudder lags by a servo in the XML; its position is read, and the axis gets what is read
    folder = with_servo(tmp_path / "servo")
    over = ("simulation.substeps=" + str(substeps), "reference.psi_deg=4", FAULT)
    flown = Flown(tmp_path, that_sees("positions", "u2"), "jsbsim", *over, aircraft=str(folder))
    assert flown.flight.layout.read.tolist() == [False, False, False, True]
    np.testing.assert_array_equal(flown.of("positions")[1:, 3], flown.history["rudder_position_rad"][:-1])
    np.testing.assert_array_equal(flown.of("positions")[1:, 0], flown.history["left_aileron_rad"][:-1])
    np.testing.assert_array_equal(flown.of("u2")[1:], flown.records["u2"][:-1])
    assert np.abs(flown.history["rudder_position_rad"] - flown.history["rudder_cmd_rad"]).max() > 1e-4


def test_effectors_that_serve_two_axes_are_shown_each(tmp_path):
    # positions as the aircraft counts them; u2 follows from them by the mixing that the design tells
    flown = Flown(
        tmp_path,
        that_sees("positions", "u2"),
        "jsbsim",
        "reference.theta_deg=3",
        "faults=[]",
        aircraft=str(v_tail(tmp_path / "vee")),
    )
    design = flown.module.created[-1]
    names = flown.flight.layout.names
    assert design.effectors == names
    shown = np.column_stack([flown.history[f"{name}_rad"] for name in names if f"{name}_rad" in flown.history])
    places = [j for j, name in enumerate(names) if f"{name}_rad" in flown.history]
    np.testing.assert_array_equal(flown.of("positions")[1:, places], shown[:-1])
    expected = (flown.of("positions") - design.positions_trim_rad) @ shares(design.mixing)
    np.testing.assert_allclose(flown.of("u2"), expected, rtol=0, atol=1e-15)
    np.testing.assert_array_equal(flown.of("u2")[1:], flown.records["u2"][:-1])


def test_a_position_that_changes_inside_a_sample_is_shown_as_it_is_at_the_sample(tmp_path):
    # delay of 1.5 samples at 2 plant steps: in the second half of sample k the command of k - 1 arrives, so at t_k
    # the effector stands where the command of k - 2 has brought it; the row before, at its first plant step, has k - 3
    over = ("simulation.substeps=2", "controller.delay_s=0.0075", "saturation=null", "faults=[]")
    flown = Flown(tmp_path, that_sees("positions"), "analytic", *over)
    commands = flown.history["aileron_cmd_rad"]
    np.testing.assert_array_equal(flown.of("positions")[2:, 0], commands[:-2])
    np.testing.assert_array_equal(flown.history["aileron_rad"][2:], commands[:-2])


def test_air_is_what_the_history_has(tmp_path):
    names = ("airspeed", "alpha", "beta", "throttle", "altitude", "dynamic_pressure", "accelerations")
    flown = Flown(tmp_path, that_sees(*names), "jsbsim")
    for name, column in (
        ("airspeed", "airspeed_mps"), ("alpha", "alpha_rad"), ("beta", "beta_rad"), ("throttle", "throttle"),
        ("altitude", "altitude_m"),
    ):  # fmt: skip
        np.testing.assert_array_equal(flown.of(name), flown.history[column])
    np.testing.assert_array_equal(flown.of("dynamic_pressure"), flown.records["qbar"])
    np.testing.assert_array_equal(flown.of("accelerations"), STANDARD_GRAVITY * flown.records["load_factor"])


def test_at_the_trial_the_air_is_that_of_the_trim(tmp_path):
    # a controller scheduled with airspeed divides by it: the trial must not show zeros
    names = ("airspeed", "alpha", "dynamic_pressure", "accelerations", "altitude", "positions", "faults")
    flown = Flown(tmp_path, that_sees(*names), "jsbsim")
    (_, first), (_, second) = flown.module.seen[:2]
    assert first["airspeed"] == second["airspeed"] == flown.flight.model.trim["airspeed"]
    assert first["altitude"] == pytest.approx(flown.history["altitude_m"][0], abs=0.01)
    assert first["alpha"] == pytest.approx(flown.history["alpha_rad"][0], abs=1e-4)
    assert 300 < first["dynamic_pressure"] < 700
    np.testing.assert_allclose(np.linalg.norm(first["accelerations"]), 9.80665)
    np.testing.assert_array_equal(first["positions"], flown.of("positions")[0])
    assert first["faults"] == ()


def test_what_is_asked_for_changes_no_bit_of_the_flight_and_is_a_copy(tmp_path):
    plain = Flown(tmp_path, that_sees("faults"), "jsbsim", FAULT, name="plain")
    source = that_sees("positions", "u2", "airspeed", "accelerations").replace(
        "            v1 =", "            positions += 9; u2 -= 9; accelerations *= 0\n            v1 ="
    )
    nosy = Flown(tmp_path, source, "jsbsim", FAULT, name="nosy")
    assert nosy.of("positions").shape == (301, 4)
    assert plain.records.tobytes() == nosy.records.tobytes()


@pytest.mark.parametrize("plant", ["analytic", "jsbsim"])
def test_what_is_not_asked_for_is_no_block_of_the_flight(tmp_path, plant):
    # the same blocks as ever; positions and u2 add the two that keep them, air and faults none
    plain = Flown(
        tmp_path, that_sees("faults").replace(", *, faults", "").replace("'faults': faults", ""), plant, name="plain"
    )
    names = plain.flight.program.names
    assert not {"recall", "keep"} & set(names)
    knowing = Flown(tmp_path, that_sees("faults"), plant, name="knowing")
    assert knowing.flight.program.names == names
    nosy = Flown(tmp_path, that_sees("positions"), plant, name="nosy")
    assert [name for name in nosy.flight.program.names if name not in names] == ["recall", "keep"]
    assert plain.flight.shape.signals == 0


# faults


def known(tmp_path, faults, plant="analytic", *overrides):
    flown = Flown(tmp_path, that_sees("faults"), plant, f"faults={faults}", *overrides)
    return flown, [more["faults"] for more in flown.seen]


def test_nothing_is_known_of_a_fault_that_does_not_say_so(tmp_path):
    flown, faults = known(tmp_path, "[{surface: aileron, start_s: 0.5, effectiveness: 0.5}]")
    assert faults == [()] * len(flown.records)


def test_a_known_fault_is_a_record_from_its_detection_to_that_of_its_end(tmp_path):
    # window [0.5, 1.0), detected 0.2 s late: [0.7, 1.2); 0.1 + 0.2 s is the sample at 0.3 s
    text = (
        "[{surface: elevator, start_s: 0.1, effectiveness: 0.9, known: true, known_after_s: 0.2}, "
        "{surface: aileron, start_s: 0.5, end_s: 1, effectiveness: '1 - 0.5*t', bias_deg: 3, known: true, "
        "known_after_s: 0.2}]"
    )
    flown, faults = known(tmp_path, text, "jsbsim")
    t = flown.records["t"]
    elevator = [next((f for f in now if f.surface == "elevator"), None) for now in faults]
    assert [f is not None for f in elevator] == (t >= 0.3).tolist()
    aileron = [next((f for f in now if f.surface == "aileron"), None) for now in faults]
    assert [f is not None for f in aileron] == ((t >= 0.7) & (t < 1.2)).tolist()
    record = elevator[-1]
    assert record == (  # a named tuple: immutable, equal by value
        "effectiveness", "elevator", ("elevator",), 0.1, 0.9, 0.0,
    )  # fmt: skip
    assert record._fields == ("kind", "surface", "effectors", "since_s", "effectiveness", "bias_rad")
    assert elevator[100] is elevator[-1]  # what does not change is made once
    at = aileron[200]  # t = 1.0: what was true at 0.8
    assert at.effectiveness == pytest.approx(1 - 0.5 * 0.8)
    assert at.bias_rad == pytest.approx(np.radians(3))
    assert at.effectors == ("left_aileron", "right_aileron")
    with pytest.raises(AttributeError):
        at.effectiveness = 1.0


def test_a_fault_known_at_once_is_known_from_its_first_sample_to_its_last(tmp_path):
    flown, faults = known(
        tmp_path, "[{surface: rudder, start_s: 0.33333, end_s: 0.5, effectiveness: 0.2, known: true}]"
    )
    t = flown.records["t"]
    assert [len(now) == 1 for now in faults] == ((t >= 0.33333) & (t < 0.5)).tolist()
    assert [f.effectiveness for now in faults for f in now] == flown.records["effectiveness"][
        [len(n) == 1 for n in faults], 2
    ].tolist()


def test_a_mistake_in_what_is_read_of_a_fault_is_found_at_the_trial(tmp_path):
    # 20 minutes into a flight is late for a typing error
    source = stepping("t, x1_c, x1, x2, faults").replace("return 0", "[f.effectivness for f in faults]; return 0")
    overrides = "faults=[{surface: aileron, start_s: 1, effectiveness: 0.5, known: true}]"
    with pytest.raises(InputError, match="effectivness"):
        Flown(tmp_path, source, "analytic", overrides)
    Flown(tmp_path, source, "analytic", overrides.replace(", known: true", ""))  # it is never told of this one


@pytest.mark.parametrize("kind", FAULTS, ids=lambda kind: kind.model_fields["kind"].default)
def test_the_record_of_every_kind_of_fault_is_in_radians_and_leaves_out_the_windows(kind):
    fields = fields_of(kind)
    assert fields[0] == "kind"
    assert "since_s" in fields
    assert not [name for name in fields if "_deg" in name or name in ("start_s", "end_s", "known")]
    assert len(set(fields)) == len(fields)


def test_the_figures_are_told_what_was_known(tmp_path):
    text = (
        "[{surface: rudder, start_s: 0.5, end_s: 1, effectiveness: 0.2, known: true, known_after_s: 0.25}, "
        "{surface: elevator, start_s: 0.5, effectiveness: 0.2}]"
    )
    flown, _ = known(tmp_path, text)
    axes = metrics_of(flown.records)
    origin = origin_of(flown.flight)
    result = FlightResult(flown.flight.scenario, flown.outcome, axes, None, origin, (), flown.flight.layout)
    by_name = {w.what: w for w in result.figure_context().windows}
    assert (by_name["rudder"].known_from_s, by_name["rudder"].known_until_s) == (0.75, 1.25)
    assert (by_name["elevator"].known_from_s, by_name["elevator"].known_until_s) == (None, None)


# how it is asked


def stepping(arguments: str) -> str:
    return f"def create(d, h, o):\n    def step({arguments}):\n        return 0, 0, 0\n    return step"


@pytest.mark.parametrize(
    "arguments",
    [
        "t, x1_c, x1, x2, positions, faults",
        "time, ref, att, rates, *, faults, positions",
        "t, x1_c, x1, x2, /, *, positions, faults=None",
        "*args, positions, faults",
    ],
)
def test_it_is_given_by_its_name_wherever_it_stands(tmp_path, arguments):
    flown = Flown(tmp_path, stepping(arguments), "analytic")
    assert "recall" in flown.flight.program.names


@pytest.mark.parametrize(
    "arguments", ["t, x1_c, x1, x2, **everything", "*args", "*args, **kwargs", "t, x1_c, x1, x2, gain=3"]
)
def test_stars_and_defaults_ask_for_nothing(tmp_path, arguments):
    flown = Flown(tmp_path, stepping(arguments), "analytic")
    assert "recall" not in flown.flight.program.names


REFUSED = {
    "t, x1_c, x1, x2, airspede": ("airspede", "did you mean airspeed?"),
    "t, x1_c, x1, x2, *, airspede=None": ("airspede", "did you mean airspeed?"),
    "t, x1_c, x1, x2, qbar": ("qbar", "did you mean dynamic_pressure?"),
    "t, x1_c, x1, x2, *, specific_force": ("specific_force", "did you mean accelerations?"),
    "t, x1_c, x1, x2, banana": ("banana", "or give it a default"),
}


@pytest.mark.parametrize("arguments", REFUSED)
def test_an_unknown_name_is_refused_with_the_nearest_and_all(tmp_path, arguments):
    name, remedy = REFUSED[arguments]
    with pytest.raises(InputError) as error:
        Flown(tmp_path, stepping(arguments), "jsbsim")
    assert error.value.where.endswith("told.py, step")
    assert error.value.found == f"the argument {name}"
    assert error.value.expected.endswith(", ".join(MEASURED))
    assert remedy in error.value.remedy


def test_air_on_the_analytic_plant_is_refused_unless_it_has_a_default(tmp_path):
    # nan would reach the command and end the flight with words that do not name it
    with pytest.raises(InputError, match="the argument airspeed on plant: analytic") as error:
        Flown(tmp_path, stepping("t, x1_c, x1, x2, airspeed"), "analytic")
    assert "airspeed=None" in error.value.remedy
    assert "positions, u2, faults" in error.value.expected
    source = stepping("t, x1_c, x1, x2, airspeed=30.0").replace("return 0, 0, 0", "return [1e-3 * (airspeed - 30)] * 3")
    flown = Flown(tmp_path, source, "analytic")
    assert not flown.records["v2"].any()
    flown = Flown(tmp_path, source, "jsbsim")
    np.testing.assert_array_equal(flown.records["v2"][:, 0], 1e-3 * (flown.records["airspeed"] - 30))


# compiled

LAW = """
    import numpy as np
    from uavftc.core.stage import NOTHING, Stage, law, params_of
    PARAMS, STATE = np.dtype([("B_inverse", "f8", (3, 3))]), np.dtype([("seen", "f8", (3,))])
    def params(design, h, options):
        return params_of(PARAMS, B_inverse=np.linalg.pinv(design.B))
    @law
    def step(p, s, row):
        for i in range(3):
            row.v1[i] = 0.5 * (row.x1_c[i] - row.x1_meas[i])
            row.f_hat[i] = row.u2[i]
        for i in range(3):
            row.v2[i] = 0.0
            for j in range(3):
                row.v2[i] += p.B_inverse[i, j] * 4.0 * (row.v1[j] - row.x2_meas[j])
    stage = Stage(step, PARAMS, STATE, reads=["x1_c", "x1_meas", "x2_meas", "u2"], writes=["v1", "v2", "f_hat"])
    """


@pytest.mark.parametrize("plant", ["analytic", "jsbsim"])
def test_a_compiled_law_that_says_so_reads_what_the_axes_got_in_the_row_before(tmp_path, plant):
    flown = Flown(tmp_path, LAW, plant, FAULT, name="law")
    np.testing.assert_array_equal(flown.records["f_hat"][1:], flown.records["u2"][:-1])
    assert np.ptp(flown.records["u2"]) > 1e-3
    source = LAW.split("    stage =", maxsplit=1)[0] + "    stage = Stage(step, PARAMS, STATE)\n"
    silent = Flown(tmp_path, source, plant, FAULT, name="silent")
    assert "recall" not in silent.flight.program.names
    assert not silent.records["f_hat"].any()  # of this row nothing is known yet


def test_a_compiled_law_may_not_say_that_it_reads_the_truth(tmp_path):
    with pytest.raises(InputError, match="reads: effectiveness") as error:
        Flown(tmp_path, LAW.replace('"x2_meas", "u2"', '"x2_meas", "effectiveness"'), name="cheat")
    assert "x2_meas, u2, airspeed" in error.value.expected


def test_remarks_of_a_controller_are_among_those_of_its_flight(tmp_path):
    # names that were not declared, once, also of telemetry that comes late
    source = """
        def create(design, h, options):
            return lambda t, x1_c, x1, x2: ([0, 0, 0], {"omega": 1, "late": 2} if t > 1 else {"v1": x1})
        """
    flown = Flown(tmp_path, source)
    (line,) = [line for line in notes_of(flown.flight) if "declar" in line]
    assert "'late', 'omega' without declaring it: not recorded" in line
    assert {c.name for c in COLUMNS} <= set(flown.history)
