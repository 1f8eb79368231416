"""Errors of a sensor that are not random: misalignment, scale factor, quantisation, delay, stuck; and their order."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from sensors.shown import shown

ANGLES = st.lists(st.floats(-60.0, 60.0), min_size=3, max_size=3)
RNG = np.random.default_rng(5)
X1 = RNG.uniform(-1.2, 1.2, (200, 3)) * [2.0, 1.0, 8.0]  # headings of more than a turn
X2 = RNG.normal(size=(200, 3))


class TestMisalignment:
    @settings(deadline=None, max_examples=25)  # the first example compiles
    @given(mounted=ANGLES, x2=ANGLES)
    def test_a_turned_gyro_measures_along_its_own_axes(self, mounted, x2):
        # scipy turns the sensor by yaw, pitch, roll; a vector's components in its axes are those of the inverse
        records = shown({"gyro_misalignment_deg": mounted}, x2=[x2])
        expected = Rotation.from_euler("ZYX", mounted[::-1], degrees=True).inv().apply(x2)
        np.testing.assert_allclose(records["x2_meas"][0], expected, rtol=0, atol=1e-12)
        assert not records["x1_meas"].any()

    @settings(deadline=None, max_examples=25)
    @given(mounted=ANGLES)
    def test_a_turned_attitude_sensor_shows_its_own_attitude(self, mounted):
        # the sensor's attitude is the vehicle's, then its own; the heading stays near that of the vehicle, in turns too
        records = shown({"attitude_misalignment_deg": mounted}, x1=X1)
        sensor = Rotation.from_euler("ZYX", X1[:, ::-1]) * Rotation.from_euler("ZYX", mounted[::-1], degrees=True)
        found = Rotation.from_euler("ZYX", records["x1_meas"][:, ::-1])
        assert (found * sensor.inv()).magnitude().max() < (2e-8 if any(mounted) else 1e-15)
        assert np.abs(records["x1_meas"][:, 2] - X1[:, 2]).max() <= np.pi + 1e-9
        np.testing.assert_array_equal(records["x2_meas"], records["x2"])

    def test_a_small_angle_is_added_to_its_own_axis_in_level_flight(self):
        # 0.1 deg about each axis: to second order the angle itself
        records = shown({"attitude_misalignment_deg": 0.1}, x1=np.zeros((1, 3)))
        np.testing.assert_allclose(np.degrees(records["x1_meas"][0]), 0.1, rtol=2e-3)


def test_scale_factor_error_scales_each_axis():
    config = {"gyro_scale_factor_error": [0.02, -0.05, 0], "attitude_scale_factor_error": [0, 0.01, -0.1]}
    records = shown(config, X1, X2)
    np.testing.assert_allclose(records["x1_meas"], X1 * [1.0, 1.01, 0.9], rtol=1e-15)
    np.testing.assert_allclose(records["x2_meas"], X2 * [1.02, 0.95, 1.0], rtol=1e-15)


class TestQuantisation:
    def test_the_nearest_step_is_shown(self):
        # within half a step; 0 is none; a signal over many steps leaves an error of q / sqrt(12)
        x2 = RNG.uniform(-1.0, 1.0, (100_000, 3))
        records = shown({"gyro_quantisation_degps": [1, 0.5, 0], "attitude_quantisation_deg": [0, 0, 2]}, X1[0], x2)
        q = np.radians([1.0, 0.5])
        steps = records["x2_meas"][:, :2] / q
        np.testing.assert_allclose(steps, np.round(steps), atol=1e-10)
        error = records["x2_meas"] - x2
        assert (np.abs(error[:, :2]).max(axis=0) <= 0.5 * q * (1.0 + 1e-12)).all()
        np.testing.assert_allclose(error[:, :2].std(axis=0), q / np.sqrt(12.0), rtol=0.01)
        np.testing.assert_array_equal(error[:, 2], 0.0)
        np.testing.assert_allclose(records["x1_meas"][0, 2], np.radians(2) * np.round(X1[0, 2] / np.radians(2)))

    def test_a_half_is_rounded_upward_and_zero_is_a_step(self):
        q = np.radians(1.0)
        x2 = np.array([[0.25, 0.5, -0.5], [1.5, -1.5, -0.25]]) * q
        shown_steps = shown({"gyro_quantisation_degps": 1}, x2=x2)["x2_meas"] / q
        np.testing.assert_allclose(shown_steps, [[0, 1, 0], [2, -1, 0]], atol=1e-12)


class TestDelay:
    def test_whole_samples_change_no_bit(self):
        # each axis its own; before the flight it was as at its start
        records = shown({"gyro_delay_s": [0, 0.005, 0.05], "attitude_delay_s": [0.015, 0, 0]}, X1, X2)
        np.testing.assert_array_equal(records["x2_meas"][:, 0], X2[:, 0])
        for field, i, d, truth in (("x2_meas", 1, 1, X2), ("x2_meas", 2, 10, X2), ("x1_meas", 0, 3, X1)):
            np.testing.assert_array_equal(records[field][d:, i], truth[:-d, i])
            np.testing.assert_array_equal(records[field][:d, i], truth[0, i])
        np.testing.assert_array_equal(records["x1_meas"][:, 1:], X1[:, 1:])

    @pytest.mark.parametrize("delay", [0.0012, 0.005, 0.0173, 0.1])
    def test_any_delay_of_a_ramp_is_exact_and_of_a_sine_as_good_as_a_line(self, delay):
        # x(t - delay) in closed form: the line between two samples is off by at most h^2 / 8 of the second derivative
        t = np.arange(400) * 0.005
        x2 = np.column_stack([0.3 * t, np.sin(t), np.sin(20.0 * t)])
        found = shown({"gyro_delay_s": delay}, x2=x2)["x2_meas"]
        late = t - delay
        settled = late >= 0.0
        exact = np.column_stack([0.3 * late, np.sin(late), np.sin(20.0 * late)])
        error = np.abs(found - exact)[settled].max(axis=0)
        assert error[0] < 1e-14
        assert error[1] < 0.005**2 / 8 * 1.0 * (1 + 1e-6) + 1e-15
        assert error[1] < 4e-6
        assert error[2] < 0.005**2 / 8 * 400.0
        assert not found[late <= -0.005].any()

    def test_one_longer_than_the_flight_shows_its_start(self):
        records = shown({"attitude_delay_s": 599.0}, X1, X2)
        np.testing.assert_array_equal(records["x1_meas"], np.broadcast_to(X1[0], X1.shape))
        np.testing.assert_array_equal(records["x2_meas"], X2)

    @pytest.mark.parametrize(("part", "share"), [(0.25, 0.7906), (0.5, 0.7071), (1.0, 1.0)])
    def test_noise_between_two_samples_is_the_mean_of_theirs(self, part, share):
        # sqrt((1 - f)^2 + f^2) of the standard deviation, as the module says
        noise = {"gyro_noise_density_degps_per_rthz": 0.01}
        whole = shown(noise, n=100_000)["x2_meas"].std()
        assert shown(noise | {"gyro_delay_s": part * 0.005}, n=100_000)["x2_meas"].std() / whole == pytest.approx(
            share, rel=0.005
        )


class TestStuck:
    T = np.arange(200) * 0.005

    def test_it_holds_what_it_showed_last_to_the_bit(self):
        # also of the biased measurement, and from the first sample at or after end_s on the truth is shown again
        config = {"gyro_bias_degps": 1, "gyro_stuck": [{"axis": "pitch", "start_s": 0.2, "end_s": 0.5}]}
        records = shown(config, X1, X2)
        expected = X2 + np.radians(1.0)
        expected[40:100, 1] = expected[39, 1]
        np.testing.assert_array_equal(records["x2_meas"], expected)
        np.testing.assert_array_equal(records["x1_meas"], X1)

    def test_at_a_given_value_and_on_every_axis(self):
        config = {"attitude_stuck": [{"start_s": 0.5, "at_deg": 3}], "gyro_stuck": [{"axis": "roll", "at_degps": -2}]}
        records = shown(config, X1, X2)
        np.testing.assert_array_equal(records["x1_meas"][:100], X1[:100])
        np.testing.assert_array_equal(records["x1_meas"][100:], np.radians(3.0))
        np.testing.assert_array_equal(records["x2_meas"][:, 0], np.radians(-2.0))
        np.testing.assert_array_equal(records["x2_meas"][:, 1:], X2[:, 1:])

    def test_from_the_start_it_holds_the_first_sample(self):
        records = shown({"attitude_stuck": [{"axis": "yaw", "end_s": 0.1}]}, X1, X2)
        np.testing.assert_array_equal(records["x1_meas"][:20, 2], X1[0, 2])
        np.testing.assert_array_equal(records["x1_meas"][20:], X1[20:])


class TestOrder:
    Q, B, K = np.radians(1.0), np.radians(0.3), 0.1

    def test_scale_comes_before_bias_and_both_before_the_converter(self):
        # (1 + k) x + b and not (1 + k) (x + b), rounded as a whole
        config = {"gyro_scale_factor_error": self.K, "gyro_bias_degps": 0.3}
        found = shown(config, x2=X2)["x2_meas"]
        np.testing.assert_allclose(found, (1.0 + self.K) * X2 + self.B, rtol=1e-14, atol=1e-15)
        found = shown(config | {"gyro_quantisation_degps": 1}, x2=X2)["x2_meas"]
        expected = self.Q * np.floor(((1.0 + self.K) * X2 + self.B) / self.Q + 0.5)
        np.testing.assert_allclose(found, expected, atol=1e-12)

    def test_noise_is_added_before_the_converter_and_walk_and_misalignment_before_that(self):
        config = {
            "gyro_noise_density_degps_per_rthz": 0.05, "gyro_random_walk_degps_per_rts": 1,
            "gyro_misalignment_deg": [0, 0, 90], "gyro_scale_factor_error": [0, self.K, 0],
        }  # fmt: skip
        smooth = shown(config, x2=X2)["x2_meas"]
        rounded = shown(config | {"gyro_quantisation_degps": 1}, x2=X2)["x2_meas"]
        np.testing.assert_allclose(rounded, self.Q * np.floor(smooth / self.Q + 0.5), atol=1e-12)
        # the y axis of a gyro turned by 90 deg about z meets -p, and its own scale factor acts on that
        noise = shown({k: v for k, v in config.items() if "noise" in k or "walk" in k}, n=len(X2))["x2_meas"]
        np.testing.assert_allclose((smooth - noise)[:, 1], -(1.0 + self.K) * X2[:, 0], atol=1e-12)

    def test_what_is_rounded_is_delayed_then_lost_then_stuck(self):
        config = {
            "gyro_quantisation_degps": 1,
            "gyro_delay_s": 0.01,
            "gyro_dropout": [{"start_s": 0.3, "end_s": 0.6, "mode": "zero"}],
            "gyro_stuck": [{"axis": "yaw", "start_s": 0.5}],
        }
        found = shown(config, x2=X2)["x2_meas"]
        rounded = shown({"gyro_quantisation_degps": 1}, x2=X2)["x2_meas"]
        np.testing.assert_array_equal(found[2:60], rounded[:58])
        assert not found[60:120, :2].any()
        np.testing.assert_array_equal(found[120:, :2], rounded[118:-2, :2])
        np.testing.assert_array_equal(found[100:, 2], 0.0)  # stuck at what was shown of the lost one, beyond its return
