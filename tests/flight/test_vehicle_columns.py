"""Position, load factor, dynamic pressure, engines and control moments of the history, compared with plain JSBSim.

hale is flown again in plain JSBSim by the positions of the history, without this package, and asked for its own values.
"""

from __future__ import annotations

import functools
import sys
import textwrap

import numpy as np
import pytest

from flying import flown
from plain import INPUTS, at_trim, reported
from uavftc.core.signals import MORE_COLUMNS, column
from uavftc.flight.build import build_flight
from uavftc.flight.fly import fly_to_memory
from uavftc.flight.recorder import published
from uavftc.scenario.load import load_scenario

FOOT, POUND, G0 = 0.3048, 4.4482216152605, 9.80665  # m, N, m/s^2
POUND_FOOT = POUND * FOOT  # N m
RADIUS = 637_100_000.0  # m, of hale's planet
TURN = ("duration_s=8", "faults=[{surface: left_aileron, start_s: 2, effectiveness: 0.5}]", "reference.psi_deg=20")
SEEN = [
    "position/lat-geod-rad", "position/long-gc-rad", "position/h-sl-ft",
    "velocities/v-north-fps", "velocities/v-east-fps", "aero/qbar-psf",
    *(f"attitude/{x}-rad" for x in ("phi", "theta")), *(f"velocities/{x}-rad_sec" for x in "pqr"),
    *(f"velocities/{x}-fps" for x in "uvw"), *(f"accelerations/{x}dot-ft_sec2" for x in "uvw"),
    "accelerations/gravity-ft_sec2", *(f"accelerations/N{x}" for x in "xyz"),
    "propulsion/engine/thrust-lbs", "propulsion/engine[1]/thrust-lbs",
    "fcs/throttle-pos-norm[0]", "fcs/throttle-pos-norm[1]",
]  # fmt: skip


@functools.cache
def both(*more: str):
    """Return the history of a turn with half an aileron, and what plain JSBSim reports on the same positions."""
    flight, records, outcome = flown("scenario1", "jsbsim", None, (*TURN, *more))
    assert outcome.completed
    history = published(records, flight.columns)
    values, _ = reported(history, flight.model.trim, SEEN)
    return history, dict(zip(SEEN, values.T, strict=True))


def test_the_position_is_that_of_latitude_and_longitude():
    # on hale's sphere, in the plane that touches it at the start, at the height of the start
    history, theirs = both()
    r = RADIUS + FOOT * theirs["position/h-sl-ft"]
    lat, lon = theirs["position/lat-geod-rad"], theirs["position/long-gc-rad"]
    assert history["east_m"][-1] > 10.0
    np.testing.assert_allclose(history["north_m"], r * np.sin(lat), rtol=0, atol=1e-6)
    np.testing.assert_allclose(history["east_m"], r * np.cos(lat) * np.sin(lon), rtol=0, atol=1e-6)


def test_the_position_is_the_integral_of_the_velocity():
    # by the trapezoidal rule; JSBSim's is Adams-Bashforth
    history, theirs = both()
    for name, velocity in (("north_m", "velocities/v-north-fps"), ("east_m", "velocities/v-east-fps")):
        v = FOOT * theirs[velocity]
        path = np.concatenate([[0.0], np.cumsum(0.005 * (v[1:] + v[:-1]) / 2.0)])
        np.testing.assert_allclose(history[name], path, rtol=0, atol=1e-4)


def test_the_load_factor_is_what_is_left_of_the_acceleration_without_gravity():
    # du/dt + w x v - g, JSBSim's own of the same moment, on a planet that does not turn
    history, theirs = both()
    phi, theta = theirs["attitude/phi-rad"], theirs["attitude/theta-rad"]
    down = np.array([-np.sin(theta), np.sin(phi) * np.cos(theta), np.cos(phi) * np.cos(theta)])
    w, v, dv = ([theirs[name.format(x)] for x in names] for name, names in (
        ("velocities/{}-rad_sec", "pqr"), ("velocities/{}-fps", "uvw"), ("accelerations/{}dot-ft_sec2", "uvw"),
    ))  # fmt: skip
    specific = np.array(dv) + np.cross(w, v, axis=0) - theirs["accelerations/gravity-ft_sec2"] * down
    shown = np.array([history[f"load_factor_{x}"] for x in "xyz"])
    assert np.ptp(shown[1]) > 0.01
    np.testing.assert_allclose(shown, specific * FOOT / G0, rtol=0, atol=1e-9)
    np.testing.assert_array_equal(history["load_factor"], -history["load_factor_z"])  # 1 in level flight
    assert history["load_factor"][0] == pytest.approx(1.0, abs=1e-5)


def test_jsbsims_load_factors_are_those_of_the_frame_before():
    # why the forces are read in their place; Nz counts against z
    history, theirs = both()
    for x, sign in (("x", 1.0), ("y", 1.0), ("z", -1.0)):
        late = sign * theirs[f"accelerations/N{x}"]
        np.testing.assert_allclose(history[f"load_factor_{x}"][:-1], late[1:], rtol=0, atol=1e-10)


def test_dynamic_pressure_thrust_and_throttle_are_jsbsims():
    history, theirs = both()
    pairs = [("dynamic_pressure_pa", "aero/qbar-psf", POUND / FOOT**2)]
    for name, i in (("left_motor", "0"), ("right_motor", "1")):
        engine = f"propulsion/engine{'' if i == '0' else '[1]'}/thrust-lbs"
        pairs += [(f"{name}_thrust_n", engine, POUND), (f"{name}_throttle", f"fcs/throttle-pos-norm[{i}]", 1.0)]
    for ours, name, unit in pairs:
        np.testing.assert_allclose(history[ours], unit * theirs[name], rtol=1e-9, err_msg=ours)
    assert np.ptp(history["right_motor_thrust_n"]) > 1.0
    np.testing.assert_array_equal(history["throttle"], history["left_motor_throttle"])


@pytest.mark.parametrize("substeps", [1, 3])
def test_a_lost_engine_is_seen_in_its_own_columns(substeps):
    over = (f"simulation.substeps={substeps}", "duration_s=7")
    flight, records, _ = flown("beyond/engine-loss", "jsbsim", None, over)
    history = published(records, flight.columns)
    lost = history["time_s"] > 5.0
    assert np.all(history["left_motor_throttle"][lost] == 0.0)
    assert np.all(history["left_motor_throttle"][~lost] == history["right_motor_throttle"][~lost])
    assert np.all(history["left_motor_thrust_n"][history["time_s"] > 6.0] <= 0.0)
    assert np.all(history["right_motor_thrust_n"] > 100.0)


def row_by_row(scenario: str, aircraft: str, *overrides: str) -> tuple[np.ndarray, np.ndarray]:
    """Return records, and JSBSim's load factors after the frame of each row: those of its state."""
    flight = build_flight(load_scenario(scenario, aircraft=aircraft, overrides=overrides))
    seen, plant = [], flight.plant
    fly = plant.run

    def run(program, rows, first, last):
        for k in range(first, last):
            if (done := fly(program, rows, k, k + 1)) == k:
                return done
            seen.append([plant.fdm[f"accelerations/N{x}"] for x in "xyz"])
        return last

    plant.run = run
    records, outcome = fly_to_memory(flight)
    assert outcome.completed
    return records, np.array(seen) * (1.0, 1.0, -1.0)


@pytest.mark.parametrize(
    ("scenario", "aircraft", "overrides"),
    [
        ("scenario1", "hale", ["damage=[{start_s: 0.5, end_s: 1, mass_kg: -100}]"]),
        ("scenario1", "jsbsim:c172p", ["saturation=null"]),  # on an Earth that turns
        ("gust", "hale", ["disturbances=[{kind: gust, start_s: 0.5, ramp_s: 0.2, down_mps: -3}]"]),
    ],
)
def test_the_load_factor_knows_the_mass_of_the_moment(scenario, aircraft, overrides):
    # JSBSim's load factors after the next frame are the specific force of this row, with the mass that it had then
    records, theirs = row_by_row(scenario, aircraft, "duration_s=1.5", *overrides)
    np.testing.assert_allclose(records["load_factor"], theirs, rtol=1e-12, atol=1e-13)


def test_flown_in_one_go_the_load_factor_is_the_same():
    # the mass is read again after what changes it, wherever a slice of the flight begins
    over = ("duration_s=1.5", "damage=[{start_s: 0.5, end_s: 1, mass_kg: -100}]")
    records, _ = row_by_row("scenario1", "hale", *over)
    _, whole, _ = flown("scenario1", "jsbsim", None, over)
    np.testing.assert_array_equal(whole["load_factor"], records["load_factor"])


def moments_of_plain_jsbsim(flight, step: float = 1e-3) -> np.ndarray:
    """Return moments, N m, per rad of aileron, elevator and rudder at hale's trim in plain JSBSim, shape (3, 3)."""
    trim = flight.model.trim
    fdm = at_trim(trim["throttle"], trim["alpha"], trim["surfaces"][2])
    left, right, elevator, rudder = INPUTS.values()
    moved = ({left: 1.0, right: -1.0}, {elevator: 1.0}, {rudder: 1.0})
    columns = []
    for surfaces in moved:
        at = {name: fdm[name] for name in surfaces}
        ends = []
        for sign in (1.0, -1.0):
            for name, weight in surfaces.items():
                fdm[name] = at[name] + sign * step * weight
            for _ in range(3):
                fdm.run()
            ends.append([fdm[f"moments/{x}-aero-lbsft"] for x in "lmn"])
        for name, value in at.items():
            fdm[name] = value
        columns.append(POUND_FOOT * np.subtract(*ends) / (2.0 * step))
    return np.transpose(columns)


def test_moments_asked_and_given_are_those_of_the_deflections_in_plain_jsbsim():
    flight, records, _ = flown("scenario1", "jsbsim", None, TURN)
    history, per_rad = published(records, flight.columns), moments_of_plain_jsbsim(flight)
    for kind, surfaces in (("asked", "_cmd_rad"), ("given", "_rad")):
        u = np.array([history[f"{name}{surfaces}"] for name in ("aileron", "elevator", "rudder")])
        shown = np.array([history[f"{axis}_moment_{kind}_nm"] for axis in ("roll", "pitch", "yaw")])
        np.testing.assert_allclose(shown, per_rad @ u, rtol=1e-6, atol=1e-6 * np.abs(shown).max())
    damaged = history["time_s"] >= 2.0
    given, asked = history["roll_moment_given_nm"], history["roll_moment_asked_nm"]
    assert np.abs(given - asked)[damaged].max() > 10.0  # N m; before they differ by the limits alone


def test_moments_on_the_analytic_plant_are_those_of_the_papers_numbers():
    # J B_m by hand: J = [52723, 0, -8435; 0, 6314, 0; -8435, 0, 58771] kg m^2, B_m = [10, 0, 0.225; 0, 7.5, 0; ...]
    flight, records, _ = flown("scenario3", "analytic", None, ("duration_s=2",))
    history, (a, e, r) = published(records, flight.columns), records["v2"].T
    np.testing.assert_allclose(
        history["roll_moment_asked_nm"], (527230 - 8435 * 1.125) * a + (52723 * 0.225 - 8435 * 6.75) * r, rtol=1e-12
    )
    np.testing.assert_allclose(history["pitch_moment_asked_nm"], 6314 * 7.5 * e, rtol=1e-12)
    np.testing.assert_allclose(
        history["yaw_moment_asked_nm"], (-84350 + 58771 * 1.125) * a + (-8435 * 0.225 + 58771 * 6.75) * r, rtol=1e-12
    )
    # the scenario's elevator has 0.7 of its effect, behind a limit of -0.05 and 0.1 rad
    given = 6314 * 7.5 * 0.7 * np.clip(e, -0.05, 0.1)
    np.testing.assert_allclose(history["pitch_moment_given_nm"], given, rtol=1e-12)


def test_the_analytic_plant_has_no_place_and_no_air():
    flight, records, _ = flown("scenario3", "analytic", None, ("duration_s=2",))
    for c in MORE_COLUMNS:
        assert np.isnan(column(records, c)).all(), c.name
    assert flight.layout.engines == ()


SHOWN = """
    import numpy as np
    seen = []
    def create(design, h, options):
        B_inverse = np.linalg.inv(design.B)
        def step(t, x1_c, x1, x2, *, dynamic_pressure, accelerations):
            seen.append((t, dynamic_pressure, *accelerations))
            return B_inverse @ (4.0 * (0.5 * (x1_c - x1) - x2))
        return step
    """


def test_a_custom_controller_is_shown_jsbsims_dynamic_pressure_and_specific_force(tmp_path):
    # as plain JSBSim has them at t_k on the positions of the flight
    file = tmp_path / "shown_air.py"
    file.write_text(textwrap.dedent(SHOWN), encoding="utf-8")
    flight = build_flight(load_scenario("scenario1", controller=str(file), overrides=["duration_s=3"]))
    records, outcome = fly_to_memory(flight)
    assert outcome.completed
    history = published(records, flight.columns)
    forces = [f"forces/fb{x}-total-lbs" for x in "xyz"]
    theirs, _ = reported(history, flight.model.trim, ["aero/qbar-psf", *forces, "inertia/mass-slugs"])
    module = next(m for name, m in sys.modules.items() if name.startswith("custom_controller_shown_air_"))
    seen = np.array(module.seen[-len(records) :])
    np.testing.assert_array_equal(seen[:, 0], records["t"])
    np.testing.assert_allclose(seen[:, 1], theirs[:, 0] * POUND / FOOT**2, rtol=1e-9)
    np.testing.assert_allclose(seen[:, 2:], FOOT * theirs[:, 1:4] / theirs[:, 4:], rtol=0, atol=1e-9)
    assert seen[0, 4] == pytest.approx(-9.8, abs=0.01)
