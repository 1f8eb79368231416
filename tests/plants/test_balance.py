"""An aircraft that is held: its accelerations are those of plain JSBSim in the same state, and of closed forms."""

from __future__ import annotations

from pathlib import Path

import jsbsim
import numpy as np
import pytest

from uavftc.actuators.engine import Change
from uavftc.aircraft.definition import load_aircraft
from uavftc.analysis.equilibrium import System, solve
from uavftc.plants.interface import State
from uavftc.plants.jsbsim.balance import Held, path_axes
from uavftc.plants.jsbsim.engine_faults import EngineChange
from uavftc.plants.jsbsim.load import FLAT_PLANET
from uavftc.plants.jsbsim.model import trimmed_model
from uavftc.plants.jsbsim.settle import accelerations
from uavftc.plants.jsbsim.trim import INTEGRATORS
from uavftc.scenario.damage import Damage

FT = 0.3048
HALE = Path(__file__).parents[2] / "aircraft" / "hale"


@pytest.fixture(scope="module")
def hale():
    aircraft = load_aircraft("hale")
    return aircraft, trimmed_model(aircraft, 30.0, 1000.0)


def steady(held: Held, bank: float, pitch: float, airspeed: float) -> tuple[np.ndarray, np.ndarray]:
    """Return state and deflections of the steady state at an attitude, all free."""
    n, k = len(held.trim.surfaces), State.COUNT
    low = np.array([1.0, -0.2, -0.4, -1.0, -1.0, -1.0, 0.0, *np.full(n, -0.4)])
    high = np.array([99.0, 0.3, 0.4, 1.0, 1.0, 1.0, 1.0, *np.full(n, 0.4)])
    system = System(lambda x: held.accelerations(x[:k], x[k:]), low, high, np.full(k + n, 0.1), np.ones(6),
                    np.full(6, 1e-8))  # fmt: skip
    t = held.trim
    start = np.array([airspeed, t.alpha, t.beta, bank, pitch, 0.0, t.throttle, *np.zeros(n)])
    found = solve(system, [start], [State.ALPHA, State.BETA, State.THROTTLE, *range(k, k + n)], range(6))
    assert found.met
    return found.x[:k], found.x[k:]


def plain(folder: Path, root: Path, planet: Path) -> jsbsim.FGFDMExec:
    """Return an aircraft loaded by JSBSim and nothing of ours, frozen."""
    fdm = jsbsim.FGFDMExec(str(root))
    fdm.set_debug_level(0)
    fdm.set_aircraft_path(str(folder.parent))
    fdm.set_engine_path(str(folder / "engine" if (folder / "engine").is_dir() else root / "engine"))
    fdm.set_systems_path(str(folder / "systems" if (folder / "systems").is_dir() else root / "systems"))
    fdm.set_dt(0.005)
    assert fdm.load_model(folder.name)
    assert fdm.load_planet(str(planet), False)
    for name in INTEGRATORS:
        fdm[name] = 0
    return fdm


def put(fdm: jsbsim.FGFDMExec, state: np.ndarray, altitude: float) -> None:
    airspeed, alpha, beta, bank, pitch, _, _ = map(float, state)
    for name, value in {
        "h-sl-ft": altitude / FT, "vt-fps": airspeed / FT, "alpha-rad": alpha, "beta-rad": beta, "theta-rad": pitch,
        "phi-rad": bank, "psi-true-rad": 0.0, "lat-geod-deg": 0.0,
    }.items():  # fmt: skip
        fdm[f"ic/{name}"] = value
    fdm.run_ic()
    fdm["propulsion/set-running"] = -1


def test_a_steady_state_of_hale_is_one_of_plain_jsbsim(hale):
    # 5 deg of bank at a constant heading, climbing: all six accelerations below 1e-6, m/s^2 and rad/s^2
    held = Held(*hale)
    state, deflections = steady(held, np.radians(5.0), np.radians(5.0), 30.0)
    fdm = plain(HALE, HALE, HALE / "flat_planet.xml")
    put(fdm, state, 1000.0)
    for e, u in zip(hale[1].effectors, deflections, strict=True):
        fdm[e.command] = e.trim_command + u / e.rad_per_command
    for name in held.trim.throttles:
        fdm[name] = float(state[State.THROTTLE])
    for _ in range(1000):
        fdm.run()
    assert np.max(np.abs(accelerations(fdm))) < 1e-6
    assert [fdm[f"velocities/{rate}-rad_sec"] for rate in "pqr"] == pytest.approx([0.0] * 3, abs=1e-12)


def test_a_steady_state_of_a_cessna_is_one_of_plain_jsbsim():
    # a piston engine, whose speed takes seconds: what is told of it is where it comes to rest
    aircraft = load_aircraft("jsbsim:c172p")
    model = trimmed_model(aircraft, 51.0, 1500.0)
    held = Held(aircraft, model)
    state, deflections = steady(held, np.radians(4.0), held.trim.theta + np.radians(1.0), 51.0)
    root = Path(jsbsim.get_default_root_dir())
    fdm = plain(root / "aircraft" / "c172p", root, FLAT_PLANET)
    for name in ("gear/gear-cmd-norm", "gear/gear-pos-norm"):
        fdm[name] = 0.0
    fdm["propulsion/fuel_freeze"] = 1
    put(fdm, state, 1500.0)
    trims = ("fcs/roll-trim-cmd-norm", "fcs/pitch-trim-cmd-norm", "fcs/yaw-trim-cmd-norm")
    for name, value in zip(trims, held.trim.trim_commands, strict=True):
        fdm[name] = value
    for e, u in zip(model.effectors, deflections, strict=True):
        fdm[e.command] = e.trim_command + u / e.rad_per_command
    for name in held.trim.throttles:
        fdm[name] = float(state[State.THROTTLE])
    for _ in range(6000):
        fdm.run()
    assert np.max(np.abs(accelerations(fdm))) < 1e-6


def test_differences_before_engines_change_speed_are_those_of_a_vehicle_at_rest(hale):
    held = Held(*hale)
    state, deflections = steady(held, 0.0, held.trim.theta, 30.0)
    moved = deflections + np.array([1e-3, 0.0, -2e-3, 3e-3])
    difference = held.nearby(state, moved) - held.nearby(state, deflections)
    settled = held.accelerations(state, moved) - held.accelerations(state, deflections)
    np.testing.assert_allclose(difference, settled, rtol=0.0, atol=1e-6 * np.max(np.abs(settled)))


def test_a_turn_about_the_vertical_has_the_rates_that_keep_the_attitude(hale):
    # phi' = theta' = 0 and psi' = turn, by the kinematics of JSBSim
    held = Held(*hale)
    held.accelerations(np.array([30.0, 0.01, 0.02, 0.3, 0.1, 0.05, 0.4]), np.zeros(4))
    found = [held.fdm[f"velocities/{name}-rad_sec"] for name in ("phidot", "thetadot", "psidot")]
    np.testing.assert_allclose(found, [0.0, 0.0, 0.05], rtol=0.0, atol=1e-12)


def test_side_and_lift_are_across_the_path():
    # orthonormal, the first along the velocity [cos a cos b, sin b, sin a cos b]
    axes = path_axes(0.2, -0.3)
    np.testing.assert_allclose(axes @ axes.T, np.eye(3), atol=1e-15)
    along = [np.cos(0.2) * np.cos(-0.3), np.sin(-0.3), np.sin(0.2) * np.cos(-0.3)]
    np.testing.assert_allclose(axes @ along, [1.0, 0.0, 0.0], atol=1e-15)


def test_damage_and_disturbances_act_as_in_a_flight(hale):
    # a force of 425 N on 425 kg is 1 m/s^2; without a tenth of the mass 1/0.9; d2 is a moment of the whole inertia
    state = np.array([30.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.3])
    clean = Held(*hale).accelerations(state, np.zeros(4))
    pushed = Held(*hale, damage=[Damage(force_n=(0.0, 425.0, 0.0), moment_nm=(0.0, 0.0, 5877.1))])
    extra = pushed.accelerations(state, np.zeros(4)) - clean
    np.testing.assert_allclose(extra[:3], [0.0, 1.0, 0.0], rtol=0.0, atol=1e-7)
    J = np.array(hale[1].inertia_kgm2)
    np.testing.assert_allclose(extra[3:], np.linalg.solve(J, [0.0, 0.0, 5877.1]), rtol=0.0, atol=1e-7)
    light = Held(*hale, damage=[Damage(inertia_kgm2={"ixx_kgm2": -5000.0})])
    now = J + np.diag([-5000.0, 0.0, 0.0])
    np.testing.assert_allclose(light.turned, np.linalg.solve(now, J), rtol=1e-6, atol=1e-9)
    np.testing.assert_allclose(pushed.turned, np.eye(3), rtol=0.0, atol=1e-12)


def test_a_lost_motor_pulls_no_more_whatever_the_throttle(hale):
    # left motor lost: half the thrust, and it yaws to the left
    state = np.array([30.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.8])
    both = Held(*hale).accelerations(state, np.zeros(4))
    lost = Held(*hale, engines=[EngineChange(0, Change(gain=0.0, stopped=True), 3.0, 9.0)])
    one = lost.accelerations(state, np.zeros(4))
    idle = np.where(np.arange(7) == State.THROTTLE, 0.0, state)
    none = Held(*hale).accelerations(idle, np.zeros(4))
    assert one[0] - none[0] == pytest.approx(0.5 * (both[0] - none[0]), rel=1e-6)
    assert one[5] < both[5] - 0.01
    stuck = Held(*hale, engines=[EngineChange(0, Change(gain=0.0, held=None), 3.0, None)], throttles=[0.8])
    np.testing.assert_allclose(stuck.accelerations(state, np.zeros(4)), both, rtol=0.0, atol=1e-7)


def test_what_is_not_a_number_leaves_no_trace(hale):
    # one nan, and JSBSim would give nan for good
    held = Held(*hale)
    state = np.array([30.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.3])
    before = held.accelerations(state, np.zeros(4))
    assert np.isnan(held.accelerations(state * np.nan, np.zeros(4))).all()
    held.fdm[held.trim.throttles[0]] = np.nan
    for _ in range(100):  # the speed of a propeller is not a number, and stays so
        held.fdm.run()
    assert np.isnan(held.accelerations(state, np.zeros(4))).all()
    np.testing.assert_allclose(held.accelerations(state, np.zeros(4)), before, rtol=0.0, atol=1e-8)
