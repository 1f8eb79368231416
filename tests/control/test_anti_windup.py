"""`anti_windup: limited`: what the law believes it commanded is what a healthy surface can do."""

from __future__ import annotations

import numpy as np
import pytest

import paper
from uavftc.control.inner import l1, mrac
from uavftc.core.given import ControlDesign
from uavftc.flight.build import build_flight
from uavftc.flight.fly import fly_to_memory
from uavftc.scenario.load import load_scenario

LAWS = (l1, mrac)
PUSH = "disturbances=[{kind: angular-acceleration, start_s: 5, end_s: 8, p_degps2: 60}]"
LOW, HIGH = -0.05, 0.1  # rad, of the paper's scenarios


def pushed(controller: str, *overrides: str) -> np.ndarray:
    """Scenario 1 on JSBSim, pushed in roll for 3 s by more than the aileron can hold: 60 deg/s^2 against 29."""
    scenario = load_scenario("scenario1", controller=controller, overrides=[PUSH, *overrides])
    records, outcome = fly_to_memory(build_flight(scenario))
    assert outcome.completed
    return records


def time_on_stop(records: np.ndarray) -> float:
    """How long after the push the aileron is still at its lower limit, s."""
    after = records[records["t"] >= 8.0]
    return float(after["t"][np.argmax(after["u2"][:, 0] > LOW)] - 8.0)


@pytest.mark.parametrize("law", LAWS)
def test_the_command_is_cut_off_and_v_ad_is_what_is_left_of_it(law):
    # v2 = clip(v_ad - K_0' x2), v_ad = v2 + K_0' x2: the equations of predictor.py, with every channel at a limit
    K_0 = np.arange(9.0).reshape(3, 3) / 10.0
    gain = np.linalg.inv(paper.B_M) @ paper.A_M
    x2, low, high = np.array([0.1, -0.2, 0.3]), np.full(3, -0.05), np.full(3, 0.1)
    given = paper.inner_params(law.PARAMS, Gamma=0.0, K_0=K_0, v_min=low, v_max=high)
    free, held = paper.Law(law.stage, paper.inner_params(law.PARAMS, Gamma=0.0, K_0=K_0)), paper.Law(law.stage, given)
    for each in (free, held):
        each()
        each(x2_meas=x2, v1=-np.linalg.solve(gain, [5.0, -5.0, 5.0]))  # K r of 5 rad on every channel
    asked = free.row["v2"].copy()
    assert ((asked < low) | (asked > high)).all()
    np.testing.assert_array_equal(held.row["v2"], np.clip(asked, low, high))
    np.testing.assert_allclose(held.state["v_ad"], held.row["v2"] + K_0.T @ x2, rtol=1e-15)


def test_the_filter_goes_on_from_what_was_applied():
    # at the limit for 100 samples, then the command turns round: one step from the limit, not from far beyond it
    law = paper.Law(l1.stage, paper.inner_params(l1.PARAMS, Gamma=0.0, v_min=np.full(3, LOW), v_max=np.full(3, HIGH)))
    gain = np.linalg.inv(paper.B_M) @ paper.A_M
    for _ in range(100):
        law(v1=-np.linalg.solve(gain, np.ones(3)))  # asks for 1 rad
    np.testing.assert_array_equal(law.row["v2"], HIGH)
    law(v1=np.zeros(3))
    np.testing.assert_allclose(law.row["v2"], HIGH * np.exp(-paper.BANDWIDTH * 0.005), rtol=1e-12)


@pytest.mark.parametrize("law", LAWS)
def test_the_limits_are_saturation_and_stops_whichever_is_closer_and_none_by_default(law):
    limits = np.array([[-0.05, 0.1], [-0.2, 0.05], [-np.inf, 0.3]])
    given = paper.flight_of()
    design = ControlDesign(given.design.A, given.design.B, limits, given.design.x1_trim, "paper")
    config = law.Config(B_m=tuple(map(tuple, paper.B_M)))
    for asked, expected in (("limited", limits), ("none", paper.UNLIMITED)):
        (block,) = law.blocks(config.model_copy(update={"anti_windup": asked}), given._replace(design=design))
        np.testing.assert_array_equal(np.column_stack([block.params["v_min"][0], block.params["v_max"][0]]), expected)
    assert config.anti_windup == "none"


def test_L1_as_printed_winds_up_and_with_the_limits_inside_it_does_not():
    # as printed: the command runs to some 10 rad, a hundred times the limit, and the aileron stays there for seconds
    printed = pushed("nndondi-l1")
    assert np.abs(printed["v2"][:, 0]).max() == pytest.approx(10.4, rel=0.05)
    assert time_on_stop(printed) == pytest.approx(3.76, abs=0.2)
    limited = pushed("nndondi-l1", "controller.inner.anti_windup=limited")
    assert limited["v2"][:, 0].min() >= LOW
    assert limited["v2"][:, 0].max() <= HIGH
    assert time_on_stop(limited) <= 0.015  # three samples


def test_MRAC_leaves_the_stop_at_once_too():
    assert time_on_stop(pushed("nndondi-mrac")) == pytest.approx(2.2, abs=0.3)
    assert time_on_stop(pushed("nndondi-mrac", "controller.inner.anti_windup=limited")) <= 0.015


@pytest.mark.parametrize("controller", ["nndondi-l1", "nndondi-mrac"])
def test_nothing_changes_to_the_bit_while_no_limit_is_reached(controller):
    # K_0 not zero: v_ad is not rounded by taking the feedback off and on again; hale's stops are at 0.436 rad
    same = ["saturation=null", "controller.inner.K_0=[[0.01, 0, 0], [0, 0.02, 0], [0, 0, 0.03]]"]
    flown = []
    for kind in ("none", "limited"):
        changes = [*same, f"controller.inner.anti_windup={kind}"]
        scenario = load_scenario("scenario1", plant="analytic", controller=controller, overrides=changes)
        flown.append(fly_to_memory(build_flight(scenario))[0]["v2"])
    assert np.abs(flown[0]).max() < 0.43
    np.testing.assert_array_equal(*flown)
