"""The paper's three scenarios, NNDONDI-L1, D = 0.5 1/s.

What is verified                                           bar
 1 controller at 200 Hz against 1 kHz, scenarios 1 and 2     3 %   (both plants)
 2 controller at 200 Hz against 1 kHz, scenario 3            5 %   (both plants)
 3 analytic plant against JSBSim, scenarios 1 and 2          6 %
 4 scenario 2 on the analytic plant against known values     2 %
 5 analytic plant, half the integration step               0.1 %
 6 JSBSim, half the frame time                               1 %
Each on IAE, ISE, ITAE and ITSE of every axis.
"""

from __future__ import annotations

import numpy as np
import pytest

from flying import flown, integrals, largest_difference

PLANTS = ("analytic", "jsbsim")
AT_1_KHZ = ("controller.rate_hz=1000",)


@pytest.mark.parametrize("plant", PLANTS)
@pytest.mark.parametrize(("scenario", "bar"), [("scenario1", 0.03), ("scenario2", 0.03), ("scenario3", 0.05)])
def test_a_controller_at_200_hz_performs_as_at_1_khz(scenario: str, bar: float, plant: str) -> None:
    assert largest_difference(integrals(scenario, plant), integrals(scenario, plant, AT_1_KHZ)) < bar


@pytest.mark.parametrize("scenario", ["scenario1", "scenario1-unsaturated", "scenario2"])
def test_analytic_model_and_jsbsim_agree(scenario: str) -> None:
    # The inner loop makes both follow the same reference model, whatever their aerodynamics.
    assert largest_difference(integrals(scenario, "analytic"), integrals(scenario, "jsbsim")) < 0.06


def test_scenario_2_comes_out_at_its_continuous_limit() -> None:
    # IAE, ISE, ITAE of roll, pitch, yaw, from an integration of the continuous loop independent of this code.
    known = np.array([[0.1727, 0.0076, 0.341], [0.1769, 0.0092, 0.294], [0.1733, 0.0095, 0.261]])
    assert largest_difference(integrals("scenario2", "analytic")[:, :3], known) < 0.02


@pytest.mark.parametrize("scenario", ["scenario1", "scenario2", "scenario3"])
def test_halving_the_analytic_step_changes_nothing(scenario: str) -> None:
    halved = integrals(scenario, "analytic", ("simulation.substeps=2",))
    assert largest_difference(integrals(scenario, "analytic"), halved) < 1e-3


@pytest.mark.parametrize("scenario", ["scenario1", "scenario2", "scenario3"])
def test_halving_the_jsbsim_frame_changes_little(scenario: str) -> None:
    halved = integrals(scenario, "jsbsim", ("simulation.substeps=2",))
    assert largest_difference(integrals(scenario, "jsbsim"), halved) < 0.01


def test_saturation_does_not_bind_in_scenario_1() -> None:
    # The paper's Table 2 shows the same figures with and without; here the reason: 0.05 rad is never asked for.
    _, records, _ = flown("scenario1-unsaturated", "analytic")
    assert np.min(records["v2"]) > -0.05
    assert np.max(records["v2"]) < 0.1
    np.testing.assert_array_equal(integrals("scenario1", "analytic"), integrals("scenario1-unsaturated", "analytic"))


def test_the_aircraft_keeps_its_airspeed_and_altitude_band_in_scenario_3() -> None:
    _, records, _ = flown("scenario3")
    assert np.max(np.abs(records["airspeed"] - 30.0)) < 0.5  # autothrottle
    assert np.degrees(np.max(np.abs(records["beta"]))) < 3.0  # 5 deg of bank at constant heading


def test_the_observer_removes_the_error_of_a_biased_gyro() -> None:
    # Without it a bias of 0.3 deg/s leaves 0.3 / D = 0.6 deg (up to the coupling of the axes).
    bias = ("sensors.gyro_bias_degps=0.3",)
    for plant in PLANTS:
        _, with_observer, _ = flown("scenario1", plant, "nndondi-l1", bias)
        _, without, _ = flown("scenario1", plant, "ndi-l1", bias)
        error, bare = (np.degrees(np.abs(r["x1_c"][-1] - r["x1"][-1])) for r in (with_observer, without))
        assert np.all(bare > 0.5)
        assert np.all(error < 0.03)
        fall = 1 - integrals("scenario1", plant, bias) / integrals("scenario1", plant, bias, "ndi-l1")
        assert np.all(fall[:, 0] > 0.35)  # IAE


def test_the_gust_is_flown_through() -> None:
    _, records, outcome = flown("gust")
    assert outcome.completed
    late = records["t"] > 19.0
    error = np.degrees(np.abs(records["x1_c"] - records["x1"]))
    assert np.max(np.abs(records["wind_n"])) > 1.0  # it was there
    assert np.max(error[records["t"] > 10.0]) < 1.0
    assert np.max(error[late]) < 0.02  # back inside the paper's band
