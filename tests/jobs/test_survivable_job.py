"""Whether a steady state exists with what is left: closed forms on the rotational model, JSBSim, and flights."""

from __future__ import annotations

import functools
import math
import re
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from rich.console import Console

from flying import flown
from uavftc.actuators.at_rest import Reach
from uavftc.core.signals import attitude_error
from uavftc.jobs.survivable.document import STATE
from uavftc.jobs.survivable.job import draw, survivable
from uavftc.jobs.survivable.phases import part_of, phases_of
from uavftc.report.survivable_text import print_survivable
from uavftc.scenario.load import load_scenario
from uavftc.scenario.schema import Scenario

B_M = np.array([[10.0, 0.0, 0.225], [0.0, 7.5, 0.0], [1.125, 0.0, 6.75]])  # of the paper, 1/s^2
A_L = np.array([[-8.5, 1.2, -3.5], [-1.5, -1.5, -1.0], [-0.02, 0.0, -2.0]])
STOP = 0.436332312999  # rad, of hale
DEG = math.pi / 180.0
CONTROLLERS = ("nndondi-l1", "nndondi-mrac", "pid", "lqi")


def analytic(**keys) -> Scenario:
    return Scenario.model_validate({"name": "s", "duration_s": 4, "plant": "analytic", **keys})


def acceleration(p=0.0, q=0.0, r=0.0, **window) -> dict:
    return {"kind": "angular-acceleration", "p_degps2": p, "q_degps2": q, "r_degps2": r, **window}


@functools.cache
def of(name: str, *overrides: str, sweep: bool = False) -> dict:
    return survivable(load_scenario(name, overrides=overrides), sweep=sweep)


def axes_of(phase: dict) -> np.ndarray:
    """Return the deflections of the three axes, rad."""
    d = phase["deflections_rad"]
    return np.array([0.5 * (d["left_aileron"] - d["right_aileron"]), d["elevator"], d["rudder"]])


def test_phases_lie_between_the_edges_of_what_acts():
    scenario = analytic(
        faults=[
            {"surface": "aileron", "effectiveness": 0.5, "start_s": 1, "end_s": 2},
            {"surface": "rudder", "effectiveness": 0.5, "start_s": 1.5},
            {"surface": "elevator", "effectiveness": 0.5, "start_s": 9},
            {"surface": "elevator", "effectiveness": 0.5, "start_s": 3.001, "end_s": 3.002},
        ],
        damage=[{"start_s": 0.5, "end_s": 1, "control_power": {"elevator": 0.5}}],
        disturbances=[acceleration(1.0, start_s=0, end_s=3)],
    )
    found = phases_of(scenario)
    assert [(p.start_s, p.end_s) for p in found] == [
        (0.0, 0.5), (0.5, 1.0), (1.0, 1.5), (1.5, 2.0), (2.0, 3.0), (3.0, 3.001), (3.002, 4.0),
    ]  # fmt: skip
    assert [(p.first, p.last) for p in found][:2] == [(0, 99), (100, 199)]
    assert [key for key, _ in found[3].active] == ["faults[0]", "faults[1]"]
    assert [key for key, _ in found[1].active] == ["damage[0]"]
    assert found[-1].last == scenario.steps


def test_on_the_rotational_model_the_balance_is_the_inverse_of_B():
    # B_m u + d2 = 0, d2 constant: u = -B_m^-1 d2, and of each axis what the inverse leaves until a stop
    d2 = np.array([20.0, -60.0, 30.0]) * DEG
    phase = survivable(analytic(disturbances=[acceleration(20, -60, 30)]))["phases"][0]
    assert phase["level"] == "steady"
    u = -np.linalg.solve(B_M, d2)
    np.testing.assert_allclose(axes_of(phase), u, rtol=0.0, atol=1e-9)
    ways = np.linalg.inv(B_M)
    for i, axis in enumerate(("roll", "pitch", "yaw")):
        up = np.min((np.where(ways[:, i] > 0.0, STOP, -STOP) - u)[ways[:, i] != 0.0] / ways[ways[:, i] != 0.0, i])
        down = np.min((np.where(ways[:, i] > 0.0, -STOP, STOP) - u)[ways[:, i] != 0.0] / -ways[ways[:, i] != 0.0, i])
        left = phase["authority"][axis]
        assert left["positive_radps2"] == pytest.approx(up, rel=1e-6)
        assert left["negative_radps2"] == pytest.approx(-down, rel=1e-6)


def test_a_stuck_elevator_leaves_its_moment_and_nothing_else_stands_in_the_way():
    # 7.5 (3 deg) = 0.393 rad/s^2, which no other surface has
    scenario = analytic(faults=[{"kind": "stuck", "surface": "elevator", "at_deg": 3, "start_s": 2}])
    document = survivable(scenario)
    first, phase = document["phases"]
    assert (first["survivable"], phase["survivable"], document["survivable"]) == (True, False, False)
    assert document["limiting"] == 1
    assert phase["level"] == "none"
    assert phase["held"] == ["elevator"]
    (unmet,) = phase["unmet"]
    assert (unmet["equation"], unmet["alone"], unmet["unit"]) == ("pitch moment", True, "rad/s^2")
    assert unmet["residual"] == pytest.approx(7.5 * 3.0 * DEG, rel=1e-6)
    # at any share but none the moment is there: a tolerance of 1e-6 rad/s^2 is 2.5e-6 of it
    assert document["severity"]["ends_between"][0] == 0.0


def test_the_severity_at_which_an_effectiveness_is_not_enough_is_found():
    # saturated at 0.1 rad, pitch needs 0.3/7.5 = 0.04: enough until 1 - 0.9 s = 0.4, s = 2/3
    scenario = analytic(
        saturation={"min_rad": -0.1, "max_rad": 0.1},
        faults=[{"surface": "elevator", "effectiveness": 0.1}],
        disturbances=[acceleration(q=0.3 / DEG)],
    )
    low, high = survivable(scenario)["severity"]["ends_between"]
    assert low <= 2.0 / 3.0 <= high
    assert high - low == pytest.approx(0.1 / 2**7)


def test_what_a_disturbance_takes_is_its_share_of_what_the_surfaces_can_do():
    # about a mean of 0: 50 deg/s^2 of 7.5 (25 deg) = 187.5
    phase = survivable(analytic(disturbances=[acceleration(q="50*sin(2*pi*t)")]), sweep=False)["phases"][0]
    assert phase["disturbance"]["share"] == pytest.approx(50.0 / 187.5, rel=1e-3)
    too_much = survivable(analytic(disturbances=[acceleration(q="200*sin(2*pi*t)")]), sweep=False)["phases"][0]
    assert too_much["level"] == "steady"
    assert not too_much["survivable"]


def test_a_disturbance_of_the_attitude_is_met_by_rates_and_they_by_the_surfaces():
    # level: x2 = -d1, and u = -B^-1 (A x2 + coupling); of one rate alone there is no coupling but the plant's
    d1 = np.array([0.0, 2.0, 0.0]) * DEG
    scenario = analytic(disturbances=[{"kind": "attitude-rate", "theta_degps": 2}])
    phase = survivable(scenario, sweep=False)["phases"][0]
    np.testing.assert_allclose(axes_of(phase), -np.linalg.solve(B_M, A_L @ -d1), rtol=0.0, atol=1e-9)


def test_a_surface_stuck_where_it_is_stays_where_the_phase_before_had_it():
    scenario = analytic(
        faults=[{"kind": "stuck", "surface": "elevator", "start_s": 2}], disturbances=[acceleration(q=30)]
    )
    first, second = survivable(scenario, sweep=False)["phases"]
    assert second["survivable"]
    assert second["deflections_rad"]["elevator"] == first["deflections_rad"]["elevator"]
    assert first["deflections_rad"]["elevator"] == pytest.approx(-30.0 * DEG / 7.5)


def test_shares_of_a_reach_are_between_none_of_the_fault_and_all():
    no, yes = np.zeros(3, dtype=bool), np.array([True, False, False])
    free = Reach(np.full(3, -0.4), np.full(3, 0.4), np.zeros(3), np.zeros(3), no)
    whole = Reach(np.array([0.2, -0.1, 0.0]), np.array([0.2, 0.3, 0.0]), np.array([0.5, 0, 0]), np.zeros(3), yes)
    half = part_of(whole, free, 0.5)
    np.testing.assert_allclose(half.low, [0.1, -0.25, -0.2])
    np.testing.assert_allclose(half.high, [0.1, 0.35, 0.2])
    np.testing.assert_allclose(half.by_alpha, [0.25, 0.0, 0.0])
    for share, expected in ((0.0, free), (1.0, whole)):
        np.testing.assert_allclose(part_of(whole, free, share).low, expected.low, rtol=0.0, atol=1e-15)
        np.testing.assert_allclose(part_of(whole, free, share).high, expected.high, rtol=0.0, atol=1e-15)


def error_at_the_end_of(phase: dict, name: str, controller: str) -> float:
    """Return the largest attitude error in the last quarter of a phase, deg; infinite of a vehicle lost before."""
    _, records, outcome = flown(name, controller=controller)
    if not outcome.completed and outcome.ended_at_s < phase["end_s"]:
        return math.inf
    since = phase["end_s"] - 0.25 * (phase["end_s"] - phase["start_s"])
    those = (records["t"] >= since) & (records["t"] <= phase["end_s"])
    return float(np.degrees(np.abs(attitude_error(records[those]))).max())


@pytest.mark.slow
@pytest.mark.parametrize(
    "name", ["beyond/fault-hardover-stop", "beyond/fault-stuck-elevator", "damage/fin-off", "damage/rudder-off"]
)
def test_where_there_is_none_no_controller_holds(name):
    document = of(name)
    assert not document["survivable"]
    phase = document["phases"][document["limiting"]]
    for controller in CONTROLLERS:
        assert error_at_the_end_of(phase, name, controller) > 1.0, controller


def test_a_rudder_at_its_stop_leaves_yaw_and_nothing_to_hold_instead():
    # Cn_dr 25 deg qbar S b / izz, with the product of inertia; at 5 deg of bank at any sideslip, wing or nose
    phase = of("beyond/fault-hardover-stop")["phases"][1]
    assert [u["equation"] for u in phase["unmet"]] == ["yaw moment"]
    qbar_S_b = 0.5 * 1.1117 * 30.0**2 * 80.0 * 50.0
    assert phase["unmet"][0]["residual"] == pytest.approx(0.1973 * STOP * qbar_S_b / 58771.0, rel=0.05)
    assert set(phase["instead"].values()) == {None}
    assert phase["deflections_rad"]["rudder"] == pytest.approx(STOP)


def test_without_the_rudder_it_is_wings_level_or_a_turn():
    phase = of("damage/rudder-off")["phases"][1]
    assert {u["equation"] for u in phase["unmet"]} >= {"yaw moment", "side force"}
    assert phase["instead"]["bank"]["state"]["bank_rad"] == pytest.approx(0.0, abs=1e-4)
    # a coordinated turn: g tan(bank)/V to a few per cent, for some sideslip is left
    turn = phase["instead"]["turn"]["state"]["turn_radps"]
    assert turn == pytest.approx(9.80665 * math.tan(5.0 * DEG) / 30.0, rel=0.15)
    assert phase["instead"]["pitch"] is None


def test_with_one_motor_the_attitude_holds_and_the_airspeed_where_it_is_said_to():
    phase = of("beyond/engine-loss")["phases"][1]
    assert (phase["level"], phase["survivable"]) == ("attitude", True)
    assert phase["state"]["throttle"] == 1.0
    assert phase["residual"]["thrust and drag"] < -0.1
    pitch = phase["instead"]["pitch"]["state"]["pitch_rad"] / DEG
    speeds = {}
    for theta in (pitch - 0.3, 5.0):  # less than the trim has is no matter: it is near 0
        _, records, outcome = flown("beyond/engine-loss", overrides=(f"reference.theta_deg={theta}",))
        assert outcome.completed
        speeds[theta] = records["airspeed"][-1]
    held, falls = speeds.values()
    assert held == pytest.approx(30.0, abs=0.1)
    assert falls < 29.0


def test_of_a_heavier_vehicle_the_incidence_carries_the_weight():
    # lift in proportion: CL = CL_0 + CL_alpha alpha of the XML, 1.2 times that of the trim
    factor = 1.2
    state = [
        of("scenario1", "reference.phi_deg=0", "reference.theta_deg=0", "reference.psi_deg=0", *more)["phases"][0][
            "state"
        ]
        for more in ((), (f"uncertainty.mass_factor={factor}",))
    ]
    lift = [0.104143 + 5.83765 * s["alpha_rad"] for s in state]
    assert lift[1] / lift[0] == pytest.approx(factor, rel=1e-3)


def test_what_has_nothing_wrong_is_steady_with_all_its_authority():
    document = of("scenario1", "saturation=null")
    (phase,) = document["phases"]
    assert (phase["level"], document["survivable"], phase["active"]) == ("steady", True, [])
    assert max(abs(value) for value in phase["residual"].values()) < 1e-6
    assert all(left[f"{side}_share"] == pytest.approx(1.0) for left in phase["authority"].values()
               for side in ("negative", "positive"))  # fmt: skip


def keys_of(value) -> set[str]:
    if isinstance(value, dict):
        return set(value).union(*map(keys_of, value.values()))
    return set().union(*map(keys_of, value)) if isinstance(value, list) else set()


def test_every_key_of_the_document_is_described(tmp_path):
    page = (Path(__file__).parents[2] / "docs" / "survivable.md").read_text(encoding="utf-8")
    named = set(re.findall(r"[a-z_0-9]+", page))
    found = [of("damage/rudder-off"), survivable(analytic(faults=[{"surface": "rudder", "effectiveness": 0.5}]))]
    for document in found:
        own = {key: value for key, value in document.items() if key != "provenance"}
        for phase in own["phases"]:
            one = {**phase, "deflections_rad": None, "residual": None}
            own = {**own, "phases": [one]}
            assert keys_of(own) - {"roll", "pitch", "yaw"} <= named | set(STATE)


def test_the_text_says_what_matters_and_fits(capsys):
    document = of("damage/rudder-off")
    console = Console(width=80, color_system=None)
    print_survivable(console, document, None)
    text = capsys.readouterr().out
    assert max(map(len, text.splitlines())) <= 80
    said = " ".join(text.split())
    assert "no steady state was found at the reference" in said
    assert "yaw moment by" in said
    assert "could be held, giving up the bank: bank 0 deg" in said


def test_the_figure_is_drawn_with_and_without_a_flow(tmp_path):
    document = survivable(analytic(faults=[{"surface": "rudder", "effectiveness": 0.5}]))
    draw(tmp_path / "figures", document)
    with Image.open(tmp_path / "figures" / "survivable.png") as image:
        assert image.size[0] > 1500
        assert len(image.convert("RGB").getcolors(1 << 24)) > 50
    point = {**document["severity"]["points"][0], "bank_rad": [[-0.1, 0.2]], "pitch_rad": []}
    scan = [{"airspeed_mps": v, "level": None, "survivable": False, "level_without_faults": "steady",
             "survivable_without_faults": True} for v in (20.0, 30.0)]  # fmt: skip
    document = {**document, "severity": {**document["severity"], "points": [point] * 3},
                "airspeeds": {"phase": 0, "points": scan}, "airspeed_mps": 30.0}  # fmt: skip
    draw(tmp_path / "more", document)
    assert (tmp_path / "more" / "survivable.png").stat().st_size > 10_000
