"""Peak deviation and time to recover of each fault: on made-up histories whose answers are known."""

import numpy as np
import pytest

from uavftc.analysis.isolated import Window, isolated
from uavftc.jobs.twin import unfaulted
from uavftc.scenario.load import load_scenario

T = np.arange(0, 20.001, 0.01)


def history(**angles):
    zero = np.zeros(len(T))
    return {"time_s": T, "phi_rad": zero, "theta_rad": zero, "psi_rad": zero} | angles


def test_a_decaying_deviation_has_its_peak_at_the_onset_and_recovers_by_its_closed_form():
    phi = np.where(T >= 5.0, np.radians(2.0) * np.exp(-(T - 5.0)), 0.0)
    (one,) = isolated(history(phi_rad=phi), history(), [Window("faults[0]", 5.0, None)])
    roll = one["onset"]["roll"]
    assert roll["peak_deg"] == pytest.approx(2.0)
    assert roll["peak_at_s"] == pytest.approx(5.0)
    assert roll["recovered_after_s"] == pytest.approx(np.log(20.0), abs=0.01)  # 2 exp(-t) = 0.1
    assert one["onset"]["yaw"] == {"peak_deg": 0.0, "peak_at_s": 5.0, "recovered_after_s": 0.0}
    assert one["removal"] is None


def test_each_event_counts_to_the_next_one():
    theta = np.select([(T >= 5) & (T < 8), (T >= 8) & (T < 12)], [np.radians(1.0), np.radians(-3.0)], 0.0)
    windows = [Window("faults[0]", 5.0, 8.0), Window("faults[1]", 8.0, 12.0)]
    first, second = isolated(history(theta_rad=theta), history(), windows)
    assert first["onset"]["pitch"]["peak_deg"] == pytest.approx(1.0)
    assert first["onset"]["pitch"]["recovered_after_s"] is None
    assert first["removal"] == second["onset"]
    assert second["onset"]["pitch"]["peak_deg"] == pytest.approx(3.0)
    assert second["removal"]["pitch"]["recovered_after_s"] == 0.0


def test_a_heading_deviates_the_short_way_round():
    there = history(psi_rad=np.full(len(T), np.radians(179.0)))
    (one,) = isolated(there, history(psi_rad=np.full(len(T), np.radians(-179.0))), [Window("f", 0.0, None)])
    assert one["onset"]["yaw"]["peak_deg"] == pytest.approx(2.0)


def test_a_lost_flight_counts_to_its_end_and_what_came_later_not_at_all():
    short = {name: values[:601] for name, values in history().items()}
    first, second = isolated(short, history(), [Window("a", 2.0, None), Window("b", 7.0, None)])
    assert first["onset"]["roll"]["recovered_after_s"] == 0.0
    assert second == {"key": "b", "onset": None, "removal": None}


def test_the_twin_has_no_faults_and_no_damage_and_keeps_the_rest():
    scenario = load_scenario("scenario3")
    twin = unfaulted(scenario)
    assert (twin.faults, twin.damage) == ((), ())
    assert twin.disturbances == scenario.disturbances
    assert twin.saturation == scenario.saturation
