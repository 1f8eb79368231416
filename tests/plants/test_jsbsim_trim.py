"""Trim and start of a JSBSim flight, against the published figures of hale and the equations of level flight."""

from __future__ import annotations

import shutil

import numpy as np
import pytest
from scipy.optimize import brentq

from flying import bare, jsbsim_plant
from uavftc.aircraft.definition import load_aircraft
from uavftc.core.signals import as_records, empty_rows
from uavftc.errors import InputError
from uavftc.flight.build import build_flight
from uavftc.flight.fly import fly_to_memory
from uavftc.plants.jsbsim.load import load, mass_properties
from uavftc.plants.jsbsim.model import trimmed_model
from uavftc.scenario.load import load_scenario

B_M = np.array([[10.0, 0.0, 0.225], [0.0, 7.5, 0.0], [1.125, 0.0, 6.75]])  # paper, section 4

# aircraft/hale/README.md; its table is what tools/hale_aircraft.py computes, and --check repeats
MASS, WING, CHORD = 425.0, 80.0, 1.634
CL_0, CL_ALPHA, CD_0, K = 0.104143, 5.83765, 0.01, 0.0149541
CM_ALPHA, CM_DE = -0.525389, 0.724163
SHAFT_POWER = 50e3  # W, both motors
PROP_DIAMETER = 2.0  # m
PROP_J, PROP_CT, PROP_CP = np.array(  # aircraft/hale/engine/hale_prop.xml
    [(0.0, 0.13, 0.095), (0.5, 0.105, 0.095), (1.0, 0.065, 0.08), (1.5, 0.01, 0.03), (2.0, -0.05, -0.03)]
).T


def density(altitude):
    """Return the density of the International Standard Atmosphere below 11 km, kg/m^3, from its definition."""
    h = 6356766.0 * altitude / (6356766.0 + altitude)  # geopotential
    T = 288.15 - 0.0065 * h
    p = 101325.0 * (T / 288.15) ** (9.80665 / (287.05287 * 0.0065))
    return p / (287.05287 * T)


def gravity(altitude):
    """Return that of the flat planet: a sphere of a hundred Earth radii, m/s^2."""
    return 9.80665 * (637.1e6 / (637.1e6 + altitude)) ** 2


def level_flight(airspeed, altitude):
    """Return alpha, elevator (rad) and drag (N) of level flight: lift and the thrust's vertical part carry the weight.

    Thrust acts along the body's x axis, so T cos(alpha) = D and L + D tan(alpha) = m g.
    """
    qS = 0.5 * density(altitude) * airspeed**2 * WING

    def drag(alpha):
        return qS * (CD_0 + K * (CL_0 + CL_ALPHA * alpha) ** 2)

    def surplus(alpha):
        return qS * (CL_0 + CL_ALPHA * alpha) + drag(alpha) * np.tan(alpha) - MASS * gravity(altitude)

    alpha = brentq(surplus, -0.1, 0.5, xtol=1e-14)
    return alpha, -CM_ALPHA * alpha / CM_DE, drag(alpha)


def level_throttle(airspeed, altitude):
    """Return the throttle at which two propellers pull the drag of level flight at alpha = 0."""
    rho, D = density(altitude), PROP_DIAMETER
    _, _, drag = level_flight(airspeed, altitude)

    def surplus(n):  # revolutions a second
        return 2.0 * np.interp(airspeed / (n * D), PROP_J, PROP_CT) * rho * n**2 * D**4 - drag

    n = brentq(surplus, 5.0, 30.0, xtol=1e-14)
    return 2.0 * np.interp(airspeed / (n * D), PROP_J, PROP_CP) * rho * n**3 * D**5 / SHAFT_POWER


def plant_at(hale, airspeed=30.0, altitude=1000.0, wind_n=(0.0, 0.0, 0.0)):
    wind = np.array(wind_n)
    return jsbsim_plant(hale, airspeed=airspeed, altitude=altitude, wind_n=wind, has_wind=bool(wind.any()))


def hands_off(plant, seconds, wind_n=(0.0, 0.0, 0.0)):
    """Fly at the trim commands, autothrottle on; return the records."""
    rows = empty_rows(round(seconds * 200) + 1, 4)
    as_records(rows)["wind_n"] = wind_n
    plant.run(bare(plant), rows, 0, len(rows))
    return as_records(rows)


def accelerations(fdm):
    """Return u', v', w' in m/s^2 and p', q', r' in rad/s^2."""
    linear = [0.3048 * fdm[f"accelerations/{x}dot-ft_sec2"] for x in "uvw"]
    return np.array(linear), np.array([fdm[f"accelerations/{x}dot-rad_sec2"] for x in "pqr"])


def test_mass_properties_are_the_papers(hale):
    # Mass, J, S, b and c of section 4, in SI, to 1e-6 of each: units and the sign of J13 are where aircraft go wrong.
    fdm = load(hale, 0.005)
    fdm.run_ic()
    loaded = {name: np.asarray(value[0]) for name, value in mass_properties(hale, fdm).items()}
    paper = {
        "mass": 425.0,
        "inertia": [[52723.0, 0.0, -8435.0], [0.0, 6314.0, 0.0], [-8435.0, 0.0, 58771.0]],
        "wing area": 80.0,
        "span": 50.0,
        "chord": 1.634,
    }
    for name, value in paper.items():
        np.testing.assert_allclose(loaded[name], value, rtol=1e-6, atol=1e-6, err_msg=name)


def test_level_trim_leaves_no_acceleration(hale):
    # At 30 m/s and 1000 m the start of the flight stands still in every component, forces and moments.
    linear, angular = accelerations(plant_at(hale).fdm)
    assert np.max(np.abs(linear)) < 1e-6
    assert np.max(np.abs(angular)) < 1e-9


def test_trim_is_alpha_zero_at_the_papers_condition(hale):
    # CL_0 was chosen so that alpha = theta = 0 is the level trim; the throttle follows from the propeller's table.
    trim = trimmed_model(hale, 30.0, 1000.0).trim
    assert trim["alpha"] == pytest.approx(0.0, abs=1e-6)
    assert trim["surfaces"] == pytest.approx([0.0, 0.0, 0.0, 0.0], abs=1e-6)
    assert trim["throttle"] == pytest.approx(level_throttle(30.0, 1000.0), abs=1e-5)


def test_control_matrix_at_trim_is_the_papers(hale):
    # The aircraft was derived from B_m: central differences on the loaded aircraft must give it back.
    np.testing.assert_allclose(trimmed_model(hale, 30.0, 1000.0).B_rates, B_M, rtol=1e-3, atol=1e-3)


@pytest.mark.parametrize(("airspeed", "altitude"), [(25.0, 1000.0), (35.0, 500.0), (40.0, 2000.0), (30.0, 8000.0)])
class TestOtherConditions:
    def test_trim_is_that_of_the_published_coefficients(self, hale, airspeed, altitude):
        # Lift = weight and Cm = 0, solved here from the README's table, ISA density and the planet's gravity.
        trim = trimmed_model(hale, airspeed, altitude).trim
        alpha, elevator, _ = level_flight(airspeed, altitude)
        assert trim["alpha"] == pytest.approx(alpha, abs=1e-6)
        assert trim["surfaces"] == pytest.approx([0.0, 0.0, elevator, 0.0], abs=1e-6)

    def test_thrust_is_the_drag_of_the_published_polar(self, hale, airspeed, altitude):
        # The throttle found must make the propellers pull D / cos(alpha) in JSBSim.
        plant = plant_at(hale, airspeed, altitude)
        alpha, _, drag = level_flight(airspeed, altitude)
        thrust = 4.4482216152605 * sum(plant.fdm[f"propulsion/engine[{i}]/thrust-lbs"] for i in (0, 1))
        assert thrust == pytest.approx(drag / np.cos(alpha), rel=1e-4)

    def test_start_leaves_no_acceleration(self, hale, airspeed, altitude):
        # Away from the aircraft's default condition too: switching the autothrottle on must not cause a jump.
        linear, angular = accelerations(plant_at(hale, airspeed, altitude).fdm)
        assert np.max(np.abs(linear)) < 1e-6
        assert np.max(np.abs(angular)) < 1e-9

    def test_stays_in_trim_hands_off(self, hale, airspeed, altitude):
        # 20 s at the trim commands: all that is left is the numerical residue of the trim.
        records = hands_off(plant_at(hale, airspeed, altitude), 20.0)
        assert records["airspeed"][0] == pytest.approx(airspeed, abs=1e-9)
        assert np.max(np.abs(records["airspeed"] - airspeed)) < 1e-4
        assert np.max(np.abs(records["altitude"] - altitude)) < 0.01
        assert np.max(np.abs(records["x1"] - records["x1"][0])) < 1e-5
        assert np.max(np.abs(records["x2"])) < 1e-6


def test_stays_in_trim_hands_off_at_the_papers_condition(hale):
    # The flat, non-rotating planet leaves no drift either: heading and bank are constant to rounding.
    records = hands_off(plant_at(hale), 20.0)
    assert np.max(np.abs(records["airspeed"] - 30.0)) < 1e-5
    assert np.max(np.abs(records["altitude"] - 1000.0)) < 1e-3
    assert np.max(np.abs(records["x1"])) < 1e-5
    assert np.max(np.abs(records["x1"][:, (0, 2)])) < 1e-12


@pytest.mark.parametrize("wind_n", [(5.0, 0.0, 0.0), (0.0, 8.0, 0.0), (-6.0, -7.0, 0.0)])
def test_level_wind_from_the_start_is_not_felt(hale, wind_n):
    # Newton's laws do not see a uniform stream: the flight relative to the air is that in still air, for 20 s.
    plant = plant_at(hale, wind_n=wind_n)
    records = hands_off(plant, 20.0, wind_n)
    still = hands_off(plant_at(hale), 20.0)
    for field in ("airspeed", "alpha", "beta", "altitude", "x1", "x2"):
        bound = 2e-3 if field == "altitude" else 1e-5  # m; m/s, rad, rad/s
        np.testing.assert_allclose(records[field], still[field], atol=bound, err_msg=field)
    ground = [0.3048 * plant.fdm[f"velocities/v-{x}-fps"] for x in ("north", "east", "down")]
    np.testing.assert_allclose(ground, np.array([30.0, 0.0, 0.0]) + wind_n, atol=1e-3)


@pytest.mark.parametrize("down", [2.0, -2.0])
def test_vertical_wind_from_the_start_carries_the_aircraft(hale, down):
    # In air that sinks at 2 m/s the aircraft sinks with it. Only the density it meets on the way changes the trim:
    # over 40 m by 0.4 %, so alpha moves by CL_0 / CL_alpha * 0.4 % = 7e-5 rad.
    plant = plant_at(hale, wind_n=(0.0, 0.0, down))
    records = hands_off(plant, 20.0, (0.0, 0.0, down))
    assert records["altitude"][-1] - 1000.0 == pytest.approx(-20.0 * down, rel=0.01)
    assert np.max(np.abs(records["airspeed"] - 30.0)) < 5e-3
    expected = level_flight(30.0, float(records["altitude"][-1]))[0]
    assert records["alpha"][-1] == pytest.approx(expected, abs=0.2 * abs(expected))
    assert np.max(np.abs(records["beta"])) < 1e-6


@pytest.mark.parametrize("airspeed", [60.0, 200.0])
def test_no_trim_where_the_power_does_not_suffice(hale, airspeed):
    # Drag times speed exceeds all shaft power at any efficiency: refused, with the condition and the remedy.
    assert level_flight(airspeed, 1000.0)[2] * airspeed > SHAFT_POWER
    with pytest.raises(InputError, match=f"trim at {airspeed:g} m/s and 1000 m") as error:
        plant_at(hale, airspeed)
    assert "initial.airspeed_mps" in error.value.remedy
    assert "30 m/s" in error.value.remedy


def test_no_trim_where_the_wing_does_not_carry(hale):
    # At 3 m/s the elevator at its stop of 0.436 rad holds alpha = 0.6 rad: lift and all thrust cannot carry the weight.
    alpha = hale.effectors["elevator"].stop_rad * CM_DE / -CM_ALPHA
    lift = 0.5 * density(1000.0) * 3.0**2 * WING * (CL_0 + CL_ALPHA * alpha)
    disc = 2.0 * 3.1416 * 1.0**2  # of both propellers, m^2
    most_thrust = (2.0 * density(1000.0) * disc * SHAFT_POWER**2) ** (1.0 / 3.0)  # momentum theory, at rest
    assert lift + most_thrust * np.sin(alpha) < MASS * gravity(1000.0)
    with pytest.raises(InputError, match="trim at 3 m/s"):
        plant_at(hale, 3.0)


def test_a_throttle_without_a_position_is_flown_and_its_command_recorded(tmp_path):
    # no need for a position where the aircraft has none: what the trim sets is what the history shows
    folder = shutil.copytree(load_aircraft("hale").folder, tmp_path / "kite")
    (folder / "hale.xml").rename(folder / "kite.xml")
    text = (folder / "uavftc.yaml").read_text(encoding="utf-8")
    kept = [line for line in text.splitlines() if "_motor: " not in line]
    assert len(kept) == len(text.splitlines()) - 2
    kept.append('throttle: {command: ["fcs/throttle-cmd-norm[0]", "fcs/throttle-cmd-norm[1]"]}')
    (folder / "uavftc.yaml").write_text("\n".join(kept), encoding="utf-8")
    assert load_aircraft(str(folder)).throttle.position is None
    scenario = load_scenario("scenario1", aircraft=str(folder), overrides=["duration_s=1"])
    records, outcome = fly_to_memory(build_flight(scenario))
    assert outcome.completed
    np.testing.assert_allclose(records["throttle"], 0.29099, atol=1e-5)
