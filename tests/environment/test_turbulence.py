"""Turbulence: its filters against the printed spectra, its intensities, signs, frames and seeds; alone and flown."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.signal import lfilter
from scipy.spatial.transform import Rotation
from spectra import air, model, variance

from flying import given_of
from uavftc.aircraft.definition import load_aircraft
from uavftc.config.shipped import scenario_names
from uavftc.core.program import Program
from uavftc.core.signals import as_records, empty_rows
from uavftc.environment import mil_f_8785c, turbulence
from uavftc.environment.mil_f_8785c import FT_M, KT_MPS, scales
from uavftc.flight import fly
from uavftc.flight.build import build_flight
from uavftc.flight.fly import fly_to_memory
from uavftc.plants.interface import Timing
from uavftc.plants.jsbsim.span import span
from uavftc.scenario.load import load_scenario
from uavftc.scenario.schema import Scenario

GIVEN = {"sigma_mps": [1.0, 0.8, 0.6], "length_m": [40.0, 30.0, 20.0]}
SIGMA, LENGTH = GIVEN["sigma_mps"], GIVEN["length_m"]


def transfer(sections, omega_hat: np.ndarray) -> np.ndarray:
    """Return |H|^2 of sections over omega L/V."""
    s = 1j * omega_hat
    return np.abs(np.prod([(1 + lead * s) / (1 + lag * s) for lag, lead in sections], axis=0)) ** 2


class TestSections:
    OMEGA_HAT = np.geomspace(1e-3, 2900.0, 2000)

    def spectra(self, form):
        # sigma = L = V = 1: omega is omega L/V, the span does not come in
        u, v, *_ = model(form, self.OMEGA_HAT, 1.0, [1.0] * 3, [1.0] * 3, 1.0)
        return u, v

    def test_drydens_are_exact(self):
        # Phi_u = (2/pi) |H_u|^2, Phi_v = (1/pi) |H_v|^2
        u, v = self.spectra("dryden")
        np.testing.assert_allclose(2 / np.pi * transfer(turbulence.DRYDEN["u"], self.OMEGA_HAT), u, rtol=1e-12)
        np.testing.assert_allclose(1 / np.pi * transfer(turbulence.DRYDEN["v"], self.OMEGA_HAT), v, rtol=1e-12)

    def test_von_karmans_are_within_0_17_db(self):
        # of the power that no finite filter has, over six decades
        u, v = self.spectra("von-karman")
        for name, factor, spectrum in (("u", 2.0, u), ("v", 1.0, v)):
            ratio = factor / np.pi * transfer(turbulence.VON_KARMAN[name], self.OMEGA_HAT) / spectrum
            assert 0.1 < np.max(np.abs(10 * np.log10(ratio))) < 0.17

    @pytest.mark.parametrize("form", ["dryden", "von-karman"])
    @pytest.mark.parametrize(("V", "height", "b"), [(30.0, 1000.0, 50.0), (55.0, 200.0, 11.0), (20.0, 60.0, 3.0)])
    def test_all_six_are_within_half_a_db_of_the_printed_ones_at_200_hz(self, form, V, height, b):
        # the filters, sampled exactly at 200 Hz, so folded there; from 0.05 to 5 rad/s. The same for light and severe
        curve, length = mil_f_8785c.SIGMA_MPS["light"], mil_f_8785c.LENGTH_M[form]
        sigma_v, sigma_w, L_v, L_w = scales(height, 15 * KT_MPS, curve, length)
        sigma, L = np.array([sigma_v, sigma_v, sigma_w]), np.array([L_v, L_v, L_w])
        sections = turbulence.DRYDEN if form == "dryden" else turbulence.VON_KARMAN

        def filters(omega):
            u, v, w = (
                factor * s**2 * size / (np.pi * V) * transfer(sections[name], omega * size / V)
                for name, factor, s, size in zip("uvv", (2, 1, 1), sigma, L, strict=True)
            )
            p = model(form, omega, V, sigma, L, b)[3]  # one section, that is its spectrum
            q, r = ((omega / V) ** 2 / (1 + (part * b * omega / (np.pi * V)) ** 2) for part in (4, 3))
            return np.array([u, v, w, p, q * w, r * v])

        omega, rate = np.geomspace(0.05, 5.0, 60), 2 * np.pi * 200
        sampled = filters(omega)
        for k in range(1, 2000):
            sampled += filters(k * rate + omega) + filters(k * rate - omega)
        error = np.abs(10 * np.log10(sampled / model(form, omega, V, sigma, L, b))).max(axis=1)
        assert error[:4].max() < 0.17
        assert error.max() < 0.5


class TestMilF8785C:
    def by_severity(self, height_ft, severity, form="dryden"):
        length = mil_f_8785c.LENGTH_M[form]
        wind, curve = mil_f_8785c.WIND_20_FT_MPS[severity], mil_f_8785c.SIGMA_MPS[severity]
        return np.array(scales(height_ft * FT_M, wind, curve, length))

    @pytest.mark.parametrize(("severity", "knots"), [("light", 15), ("moderate", 30), ("severe", 45)])
    def test_low_altitude(self, severity, knots):
        # the formulas, at 200 ft; at 1000 ft the three are one
        sigma_v, sigma_w, L_v, L_w = self.by_severity(200, severity)
        assert sigma_w == pytest.approx(0.1 * knots * KT_MPS)
        assert sigma_v == pytest.approx(sigma_w / (0.177 + 0.000823 * 200) ** 0.4)
        assert (L_v, L_w) == pytest.approx((200 / (0.177 + 0.000823 * 200) ** 1.2 * FT_M, 200 * FT_M))
        sigma_v, sigma_w, L_v, L_w = self.by_severity(1000, severity)
        assert (sigma_v, L_v, L_w) == pytest.approx((sigma_w, 1000 * FT_M, 1000 * FT_M))

    @pytest.mark.parametrize(("severity", "sigma"), [("light", 6.7), ("moderate", 10.1), ("severe", 23.6)])
    def test_high_altitude(self, severity, sigma):
        # a point of figure 7, and half way to the next
        following = {"light": 4.6, "moderate": 8.0, "severe": 22.1}[severity]
        np.testing.assert_allclose(self.by_severity(7500, severity)[:2], sigma * FT_M)
        np.testing.assert_allclose(self.by_severity(11250, severity)[:2], (sigma + following) / 2 * FT_M)
        assert self.by_severity(1e5, severity)[0] == pytest.approx(5.1 * FT_M if severity == "severe" else 0.0)

    def test_lengths_aloft(self):
        np.testing.assert_allclose(self.by_severity(2000, "light")[2:], 1750 * FT_M)
        np.testing.assert_allclose(self.by_severity(2000, "light", "von-karman")[2:], 2500 * FT_M)

    def test_between_1000_and_2000_ft_it_is_linear(self):
        # without a step at either end
        ends = [self.by_severity(h, "moderate") for h in (1000, 2000)]
        np.testing.assert_allclose(self.by_severity(1250, "moderate"), 0.75 * ends[0] + 0.25 * ends[1])
        for h in (1000, 2000):
            np.testing.assert_allclose(self.by_severity(h - 1e-6, "severe"), self.by_severity(h + 1e-6, "severe"))

    def test_near_the_ground_it_is_that_of_10_ft(self):
        for h in (-5.0, 0.0, 3.0):
            np.testing.assert_array_equal(self.by_severity(h, "light"), self.by_severity(10, "light"))


class TestAlone:
    @pytest.mark.parametrize("form", ["dryden", "von-karman"])
    @pytest.mark.parametrize("h", [0.1, 2.0])
    def test_variances_do_not_depend_on_the_rate(self, form, h):
        # a step of 2 s is longer than L/V = 1.3 s: held white noise would keep a third of it. 5000 correlation times
        found = np.mean([(air(1500.0, h, 30.0, 0.0, seed=k, model=form, span=5.0, **GIVEN) ** 2).mean(axis=0)
                         for k in range(4)], axis=0)  # fmt: skip
        np.testing.assert_allclose(found, variance(form, 30.0, SIGMA, LENGTH, 5.0), rtol=0.07)

    def test_it_begins_in_its_stationary_state(self):
        # the first sample of 600 seeds has the variance of all others: four standard errors of it are 23 %
        first = np.array([air(0.02, 0.02, 30.0, 0.0, seed=k, span=5.0, **GIVEN)[0] for k in range(600)])
        np.testing.assert_allclose((first**2).mean(axis=0), variance("dryden", 30.0, SIGMA, LENGTH, 5.0), rtol=0.23)

    def test_the_spread_stays_while_airspeed_and_height_change(self):
        # half the noise at the speed and the height of the moment: sigma_w as printed at each, by 400 seeds
        t = np.arange(40) * 0.5
        V, height = 30.0 + 20.0 * np.sin(t), 100.0 + 50.0 * np.cos(0.7 * t)
        w = np.array([air(20.0, 0.5, V, height, seed=k, severity="light")[:, :3] for k in range(400)])
        expected = [scales(h, 15 * KT_MPS, mil_f_8785c.SIGMA_MPS["light"], 533.0)[:2] for h in height]
        np.testing.assert_allclose(w[:, :, 1].std(axis=0), [v for v, _ in expected], rtol=0.15)
        np.testing.assert_allclose(w[:, :, 2].std(axis=0), [w for _, w in expected], rtol=0.15)

    def test_rates_are_the_lagged_slopes_with_their_signs(self):
        # q_g = -dw/dx, r_g = +dv/dx behind first-order lags of 4b/(pi V) and 3b/(pi V), here by the trapezoidal rule
        h, V, b = 0.002, 30.0, 5.0
        found = air(40.0, h, V, 0.0, span=b, **GIVEN)
        k = 3000  # what the lag began with is gone
        for rate, velocity, sign, part in ((4, 2, -1.0, 4.0), (5, 1, 1.0, 3.0)):
            lag = part * b / (np.pi * V)
            expected = lfilter([2 / V, -2 / V], [h + 2 * lag, h - 2 * lag], sign * found[:, velocity])
            np.testing.assert_allclose(found[k:, rate], expected[k:], atol=0.02 * expected.std())

    def test_an_updraught_ahead_turns_the_air_nose_up(self):
        # the air at x ahead moves as omega x r does: w = -q_g x; of many samples, those of falling w_g have q_g > 0
        found = air(600.0, 0.02, 30.0, 0.0, span=5.0, **GIVEN)
        slope = np.diff(found[:, 2])
        assert np.corrcoef(slope, found[1:, 4])[0, 1] < -0.3
        assert np.corrcoef(np.diff(found[:, 1]), found[1:, 5])[0, 1] > 0.3

    def test_the_roll_rate_and_the_velocities_are_independent(self):
        # each of its own stream: correlations of 1500 s are below four standard errors of some 1000 independent samples
        found = air(1500.0, 0.05, 30.0, 0.0, span=5.0, **GIVEN)[:, :4]
        np.testing.assert_allclose(np.corrcoef(found.T), np.eye(4), atol=0.13)

    def test_without_rates_there_are_none(self):
        given = given_of(Timing(0.01, 1), 100)._replace(span_m=None)
        (block,) = turbulence.blocks((turbulence.Config(**GIVEN, rotational=False),), given)
        rows = empty_rows(100)
        records = as_records(rows)
        records["t"], records["airspeed"] = np.arange(100) * 0.01, 30.0
        Program([block]).run(rows, 0, 100)
        assert records["wind_n"][-1].all()
        assert not records["gust_rates"].any()
        assert not records["d2"].any()

    def test_it_fades_in_and_out(self):
        # by (1 - cos)/2 of the same air without fading, and nothing outside the window
        h, window = 0.01, {"start_s": 1.0, "end_s": 6.0}
        whole = air(8.0, h, 30.0, 0.0, **window, **GIVEN)
        faded = air(8.0, h, 30.0, 0.0, fade_s=2.0, **window, **GIVEN)
        t = np.arange(800) * h
        ramp = np.clip(np.minimum(t - 1.0, 6.0 - t) / 2.0, 0.0, 1.0)
        np.testing.assert_allclose(faded, np.sin(np.pi / 2 * ramp)[:, None] ** 2 * whole, atol=1e-12)
        np.testing.assert_array_equal(whole.any(axis=1), (t >= 1.0) & (t < 6.0))

    @pytest.mark.parametrize("field", ["airspeed", "height"])
    def test_a_vehicle_that_is_no_number_ends_no_program(self, field):
        # the watch ends such a flight; a law that hangs on it would not let it
        given = {"airspeed": 30.0, "height": 100.0} | {field: np.nan}
        air(0.5, 0.01, given["airspeed"], given["height"], severity="light")


def test_velocities_are_turned_from_body_axes():
    # by the attitude of each sample: against scipy's rotations
    x1 = np.random.default_rng(3).uniform(-1.2, 1.2, (50, 3))
    rows = empty_rows(50)
    records = as_records(rows)
    records["t"], records["airspeed"], records["x1"] = np.arange(50) * 0.01, 30.0, x1
    (block,) = turbulence.blocks(
        (turbulence.Config(**GIVEN, fade_s=0),), given_of(Timing(0.01, 1), 50)._replace(span_m=5.0)
    )
    Program([block]).run(rows, 0, 50)
    body = air(0.5, 0.01, 30.0, 0.0, span=5.0, **GIVEN)
    turned = Rotation.from_euler("ZYX", x1[:, ::-1]).apply(body[:, :3])
    np.testing.assert_allclose(records["wind_n"], turned, atol=1e-12)
    np.testing.assert_array_equal(records["gust_rates"], body[:, 3:])


def test_an_aircraft_without_a_span_is_told_what_to_do():
    given, entry = SimpleNamespace(span_m=None, design=SimpleNamespace(name="bird")), turbulence.Config(**GIVEN)
    (problem,) = turbulence.problems(entry, given)
    assert problem.key == ("rotational",)
    assert "bird" in problem.expected
    assert "rotational: false" in problem.remedy
    assert turbulence.problems(turbulence.Config(**GIVEN, rotational=False), given) == []


def test_the_span_is_found_in_a_file_that_the_aircraft_includes(tmp_path):
    # as the models of the University of Minnesota are written
    main = '<fdm_config name="bird"><metrics file="Metrics.xml"/></fdm_config>'
    (tmp_path / "bird").mkdir()
    (tmp_path / "bird" / "bird.xml").write_text(main)
    (tmp_path / "bird" / "Metrics.xml").write_text('<metrics><wingspan unit="IN">50</wingspan></metrics>')
    assert span(load_aircraft(str(tmp_path / "bird"))) == pytest.approx(1.27, rel=1e-12)


SCENARIO = {
    "name": "rough", "duration_s": 12, "seed": 5, "reference": {"phi_deg": 5, "theta_deg": 3},
    "disturbances": [
        {"kind": "turbulence", "severity": "light"},
        {"kind": "turbulence", "model": "von-karman", "start_s": 3, "end_s": 9, **GIVEN},
    ],
}  # fmt: skip


class TestFlown:
    def flown(self, **changed):
        flight = build_flight(Scenario.model_validate(SCENARIO | changed))
        records, outcome = fly_to_memory(flight)
        assert outcome.completed
        return flight, records

    def test_the_same_seed_gives_the_same_bits_however_it_is_cut(self, monkeypatch):
        _, records = self.flown()
        monkeypatch.setattr(fly, "CHUNK_ROWS", 777)
        monkeypatch.setattr(fly, "SLICE_ROWS", 100)
        _, again = self.flown()
        assert records.tobytes() == again.tobytes()
        _, other = self.flown(seed=6)
        assert np.abs(records["wind_n"] - other["wind_n"]).max() > 1.0

    def test_what_is_flown_is_the_air_alone_at_the_airspeed_and_height_of_each_row(self):
        # the law once more over the recorded rows, without a plant: the same wind, to the bit; so spectra of the air
        # alone are those of a flight
        flight, records = self.flown()
        rows = empty_rows(len(records), flight.shape)
        again = as_records(rows, flight.shape)
        for name in ("t", "x1", "airspeed", "height"):
            again[name] = records[name]
        entries = tuple(flight.scenario.disturbances)
        Program(turbulence.blocks(entries, flight.given)).run(rows, 0, len(rows))
        for name in ("wind_n", "gust_rates", "d2"):
            assert again[name].tobytes() == records[name].tobytes()
        assert np.ptp(records["airspeed"]) > 1.0

    def test_the_rates_turn_the_vehicle_by_its_damping(self):
        # d2 = -A [p_g q_g r_g]: what a vehicle that turns against still air at those rates is given by its damping
        flight, records = self.flown()
        expected = -records["gust_rates"] @ np.array(flight.model.A_at_once).T
        np.testing.assert_allclose(records["d2"], expected, atol=1e-13)
        assert np.degrees(records["d2"]).std(axis=0).min() > 0.5

    def test_an_entry_changes_nothing_of_another(self):
        # adding the second one leaves the first one's noise: before it begins the flights are the same to the bit
        _, both = self.flown()
        _, first = self.flown(disturbances=SCENARIO["disturbances"][:1])
        before = both["t"] < 3.0
        assert both["wind_n"][before].tobytes() == first["wind_n"][before].tobytes()
        assert both["x1"][before].tobytes() == first["x1"][before].tobytes()
        assert np.abs(both["wind_n"] - first["wind_n"])[both["t"] > 4.0].max() > 0.3

    def test_nothing_is_struck_at_the_start(self):
        # a light aircraft in severe turbulence, 6.6 m/s rms: it fades in, and the first tenth of a second is still
        _, records = self.flown(disturbances=[{"kind": "turbulence", "severity": "severe"}], reference={})
        np.testing.assert_allclose(records["airspeed"][:20], 30.0, atol=0.1)
        assert np.abs(np.degrees(records["x2"][:20])).max() < 0.1
        assert np.ptp(records["airspeed"]) > 5.0

    def test_the_history_has_the_rates_of_the_air(self):
        from uavftc.core.signals import column

        _, records = self.flown(duration_s=4)
        for i, name in enumerate(("p_gust_radps", "q_gust_radps", "r_gust_radps")):
            np.testing.assert_array_equal(column(records, name), records["gust_rates"][:, i])
            assert column(records, name).std() > 1e-3


def test_there_is_a_scenario_of_each_kind_of_air_on_hale_and_on_a_stock_aircraft():
    names = [name.removeprefix("beyond/air-") for name in scenario_names("beyond") if name.startswith("beyond/air-")]
    stock = {name.removesuffix("-c172p") for name in names if name.endswith("-c172p")}
    assert stock == {"dryden-moderate", "von-karman", "gust", "gust-train", "shear-linear", "shear-power", "wind"}
    assert stock - {"gust"} <= set(names)  # the gust on hale is scenarios/gust.yaml
    assert "gust" in scenario_names()


@pytest.mark.parametrize("name", [name for name in scenario_names("beyond") if name.startswith("beyond/air-")])
def test_every_shipped_kind_of_air_is_flown(name):
    # to its end, on hale and on a c172p; the air moves, and the vehicle feels it
    records, outcome = fly_to_memory(build_flight(load_scenario(name)))
    assert outcome.completed
    assert np.ptp(records["wind_n"], axis=0).max() > 0.05
    assert np.ptp(records["airspeed"]) > 0.05
