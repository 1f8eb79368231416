"""Errors of a sensor that are random: noise by its density, random walk, dropout; and streams of their own."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import welch

from sensors.shown import shown

LONG = 400_000  # samples: the density of a third of the band is estimated to 0.3 %

NOISE = {
    "gyro_noise_density_degps_per_rthz": [0.005, 0.01, 0.02],
    "attitude_noise_density_deg_per_rthz": [0.002, 0, 0.03],
}
WALK = {"gyro_random_walk_degps_per_rts": [0.1, 0.2, 0], "attitude_random_walk_deg_per_rts": [0, 0.3, 0.4]}


@pytest.mark.parametrize("rate", [50.0, 200.0])
def test_the_sampled_density_is_the_stated_one_at_every_rate(rate):
    # one-sided, in deg/s/sqrt(Hz), within 2 % in each third of the band: white up to half the rate
    records = shown(NOISE, n=LONG, h=1.0 / rate)
    for field, stated in (("x2_meas", (0.005, 0.01, 0.02)), ("x1_meas", (0.002, 0.0, 0.03))):
        f, power = welch(np.degrees(records[field]), fs=rate, nperseg=1024, axis=0)
        for low, high in ((0.0, 1.0 / 3.0), (1.0 / 3.0, 2.0 / 3.0), (2.0 / 3.0, 1.0)):
            band = (f > low * rate / 2.0) & (f < high * rate / 2.0)
            np.testing.assert_allclose(np.sqrt(power[band].mean(axis=0)), stated, rtol=0.02, atol=0.0)


def test_the_noise_of_a_data_sheet_has_its_standard_deviation():
    # 0.005 deg/s/sqrt(Hz) over the 100 Hz that 200 samples a second hold is 0.05 deg/s rms; its mean is zero
    noise = np.degrees(shown({"gyro_noise_density_degps_per_rthz": 0.005}, n=LONG)["x2_meas"])
    np.testing.assert_allclose(noise.std(axis=0), 0.05, rtol=5.0 / np.sqrt(2 * LONG))
    assert np.abs(noise.mean(axis=0)).max() < 4.0 * 0.05 / np.sqrt(LONG)
    assert np.abs(np.corrcoef(noise.T) - np.eye(3)).max() < 4.0 / np.sqrt(LONG)  # an axis tells nothing of another


@pytest.mark.parametrize("rate", [50.0, 200.0])
def test_a_random_walk_spreads_with_the_root_of_time_at_every_rate(rate):
    # from zero on; over any time T without overlap its increments have the standard deviation K sqrt(T)
    records = shown(WALK, n=LONG, h=1.0 / rate)
    for field, stated in (("x2_meas", (0.1, 0.2, 0.0)), ("x1_meas", (0.0, 0.3, 0.4))):
        walk = np.degrees(records[field])
        assert not walk[0].any()
        for seconds in (1.0 / rate, 1.0, 4.0):
            steps = np.diff(walk[:: round(seconds * rate)], axis=0)
            expected = np.array(stated) * np.sqrt(seconds)
            np.testing.assert_allclose(steps.std(axis=0), expected, rtol=4.0 / np.sqrt(2 * len(steps)))


class TestDropout:
    X1 = np.random.default_rng(3).normal(size=(400, 3))
    X2 = np.random.default_rng(4).normal(size=(400, 3))

    def test_a_window_is_held_or_zero_and_then_passes_unchanged(self):
        config = {
            "gyro_dropout": [{"start_s": 0.5, "end_s": 1.0}],
            "attitude_dropout": [{"start_s": 0.498, "end_s": 1.002, "axis": "pitch", "mode": "zero"}],
        }
        records = shown(config, self.X1, self.X2)
        x1, x2 = self.X1.copy(), self.X2.copy()
        x2[100:200] = x2[99]
        x1[100:201, 1] = 0.0
        np.testing.assert_array_equal(records["x2_meas"], x2)
        np.testing.assert_array_equal(records["x1_meas"], x1)

    def test_lost_from_the_start_the_first_sample_is_held_and_windows_act_in_their_order(self):
        config = {"gyro_dropout": [{"end_s": 0.1}, {"start_s": 0.05, "end_s": 0.2, "mode": "zero"}]}
        expected = self.X2.copy()
        expected[:20] = expected[0]
        expected[10:40] = 0.0
        np.testing.assert_array_equal(shown(config, x2=self.X2)["x2_meas"], expected)

    @pytest.mark.parametrize(("lost", "between"), [(0.05, 0.2), (0.02, 0.01), (0.001, 0.5)])
    def test_random_losses_have_their_share_and_their_lengths(self, lost, between):
        # a telegraph process read at the samples: the share of time lost, and the probability of a change from one
        # sample to the next, in closed form
        h, n = 0.005, 400_000
        entry = {"mean_lost_s": lost, "mean_between_s": between, "mode": "zero"}
        gone = shown({"gyro_dropout": [entry]}, x2=np.ones((n, 3)), h=h)["x2_meas"] == 0.0
        assert (gone == gone[:, :1]).all()  # all axes at once
        gone = gone[:, 0]
        a, b = 1.0 / between, 1.0 / lost
        share, change = a / (a + b), 1.0 - np.exp(-(a + b) * h)
        error = np.sqrt(share * (1 - share) / n * (2 - change) / change)  # of a mean over a correlated record
        assert gone.mean() == pytest.approx(share, abs=4 * error)
        for state, probability in ((False, change * share), (True, change * (1 - share))):
            here = gone[:-1] == state
            changed = (gone[1:] != state)[here].mean()
            assert changed == pytest.approx(probability, abs=4 * np.sqrt(probability / here.sum()))

    def test_random_losses_hold_what_arrived_last_and_only_in_their_window(self):
        entry = {"start_s": 0.5, "end_s": 1.5, "mean_lost_s": 0.02, "mean_between_s": 0.02, "axis": "yaw"}
        found = shown({"attitude_dropout": [entry]}, self.X1)["x1_meas"]
        np.testing.assert_array_equal(found[:, :2], self.X1[:, :2])
        held = found[:, 2] != self.X1[:, 2]
        assert 60 < held.sum() < 140
        assert not held[:100].any()
        assert not held[300:].any()
        last = np.maximum.accumulate(np.where(held, 0, np.arange(400)))
        np.testing.assert_array_equal(found[:, 2], self.X1[last, 2])


EVERYTHING = {
    **NOISE, **WALK, "gyro_delay_s": 0.0137,
    "gyro_dropout": [{"mean_lost_s": 0.02, "mean_between_s": 0.1}, {"mean_lost_s": 0.02, "mean_between_s": 0.1}],
    "attitude_dropout": [{"mean_lost_s": 0.02, "mean_between_s": 0.1, "axis": "roll"}],
    "attitude_stuck": [{"axis": "yaw", "start_s": 0.7, "end_s": 1.1}],
}  # fmt: skip


def test_how_a_flight_is_cut_into_pieces_changes_no_bit():
    x2 = np.random.default_rng(9).normal(size=(500, 3))
    whole = shown(EVERYTHING, x2, x2)
    pieces = shown(EVERYTHING, x2, x2, pieces=(1, 2, 37, 150, 499))
    assert whole.tobytes() == pieces.tobytes()
    assert whole.tobytes() == shown(EVERYTHING, x2, x2).tobytes()
    assert not np.array_equal(whole["x2_meas"], shown(EVERYTHING, x2, x2, seed=1)["x2_meas"])


def test_another_effect_or_axis_disturbs_no_stream():
    # the gyro noise is the same number for number whatever else is random
    alone = shown({"gyro_noise_density_degps_per_rthz": [0, 0.01, 0]}, n=500)["x2_meas"][:, 1]
    among = {key: value for key, value in EVERYTHING.items() if key.startswith("attitude")}
    with_others = shown(among | {"gyro_noise_density_degps_per_rthz": [0.3, 0.01, 0.1]}, n=500)
    np.testing.assert_array_equal(with_others["x2_meas"][:, 1], alone)
    # and the losses of one sensor are not those of the other, nor are two entries lost together
    entry = {"mean_lost_s": 0.1, "mean_between_s": 0.1, "mode": "zero"}
    config = {"gyro_dropout": [entry], "attitude_dropout": [entry]}
    records = shown(config, np.ones((4000, 3)), 1.0)
    assert abs(np.corrcoef(records["x1_meas"][:, 0], records["x2_meas"][:, 0])[0, 1]) < 0.3
    both = shown({"gyro_dropout": [entry, entry]}, x2=np.ones((4000, 3)))["x2_meas"][:, 0]
    assert both.mean() == pytest.approx(0.25, abs=0.08)
