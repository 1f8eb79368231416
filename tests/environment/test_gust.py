"""The 1-cosine gust against its closed form and against JSBSim's own cosine gust, flown."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import trapezoid

from flying import jsbsim_plant
from uavftc.aircraft.definition import load_aircraft
from uavftc.core.program import Program
from uavftc.core.signals import as_records, empty_rows
from uavftc.environment.gust import one_minus_cosine
from uavftc.flight.build import build_flight
from uavftc.flight.fly import fly_to_memory
from uavftc.scenario.schema import Scenario

FT = 0.3048


@pytest.mark.parametrize(("start", "ramp", "hold"), [(2.0, 1.0, 3.0), (0.0, 0.7, 0.0), (1.3, 2.5, 0.4)])
class TestProfile:
    def test_peak_half_height_and_rest(self, start, ramp, hold):
        # 0 until the start, 1/2 at half the ramp, 1 over the hold, 1/2 and 0 on the way down.
        times = [start - 1.0, start, start + ramp / 2, start + ramp, start + ramp + hold / 2]
        times += [start + ramp + hold, start + 1.5 * ramp + hold, start + 2 * ramp + hold, start + 2 * ramp + hold + 9]
        profile = one_minus_cosine(np.array(times), start=start, ramp=ramp, hold=hold)
        np.testing.assert_allclose(profile, [0, 0, 0.5, 1, 1, 1, 0.5, 0, 0], atol=1e-12)

    def test_area_is_ramp_plus_hold(self, start, ramp, hold):
        # Each ramp encloses half its length: the displacement of the air is peak * (ramp + hold).
        end = start + 2 * ramp + hold
        t = np.linspace(start, end, 200_001)
        area = trapezoid(one_minus_cosine(t, start=start, ramp=ramp, hold=hold), t)
        assert area == pytest.approx(ramp + hold, rel=1e-9)

    def test_is_symmetric_about_its_middle(self, start, ramp, hold):
        # It falls as it rose.
        x = np.linspace(0.0, ramp + hold, 1001)
        middle = start + ramp + hold / 2
        before, after = (one_minus_cosine(middle + sign * x, start=start, ramp=ramp, hold=hold) for sign in (-1.0, 1.0))
        np.testing.assert_allclose(before, after, atol=1e-12)

    def test_is_smooth(self, start, ramp, hold):
        # Value and slope are continuous, also at the four joints: no step excites what a gust would not.
        t = np.arange(start - 0.1, start + 2 * ramp + hold + 0.1, 1e-4)
        slope = np.diff(one_minus_cosine(t, start=start, ramp=ramp, hold=hold)) / 1e-4
        steepest, bend = np.pi / (2 * ramp), np.pi**2 / (2 * ramp**2)  # derivatives of the cosine
        assert np.max(np.abs(slope)) == pytest.approx(steepest, rel=1e-6)
        assert np.max(np.abs(np.diff(slope))) < 1.01 * bend * 1e-4


def test_rise_is_the_printed_cosine():
    # (1 - cos(pi tau / ramp)) / 2, evaluated with another identity: sin^2(pi tau / (2 ramp)).
    tau = np.linspace(0.0, 1.6, 100)
    profile = one_minus_cosine(5.0 + tau, start=5.0, ramp=1.6, hold=1.0)
    np.testing.assert_allclose(profile, np.sin(np.pi * tau / 3.2) ** 2, atol=1e-12)


def jsbsims_gust(start, ramp, hold, velocity, seconds):
    """Fly hale hands off through JSBSim's own cosine gust; return the total wind, m/s, at each row, and the rows."""
    plant = jsbsim_plant(load_aircraft("hale"))
    fdm = plant.fdm
    speed = np.linalg.norm(velocity)
    settings = {
        "startup-duration-sec": ramp,
        "steady-duration-sec": hold,
        "end-duration-sec": ramp,
        "magnitude-ft_sec": speed / FT,
        "frame": 3,  # local: north, east, down
        "X-velocity-ft_sec": velocity[0] / FT,
        "Y-velocity-ft_sec": velocity[1] / FT,
        "Z-velocity-ft_sec": velocity[2] / FT,
    }
    for name, value in settings.items():
        fdm[f"atmosphere/cosine-gust/{name}"] = value
    n = round(seconds * 200)
    rows = empty_rows(n, 4)
    program = Program([*plant.before(), *plant.given(), *plant.after()])
    wind = np.empty((n, 3))
    for k in range(n):
        if k == round(start * 200):
            fdm["atmosphere/cosine-gust/start"] = 1
        plant.run(program, rows, k, k + 1)
        wind[k] = [FT * fdm[f"atmosphere/total-wind-{x}-fps"] for x in ("north", "east", "down")]
    return wind, as_records(rows)


VELOCITY = np.array([3.0, -4.0, -1.0])
START, RAMP, HOLD = 1.0, 1.5, 2.0


def test_equals_jsbsims_cosine_gust():
    # The same gust by JSBSim's own model, started in the frame that flies row t = START: the winds flown are the same.
    wind, _ = jsbsims_gust(START, RAMP, HOLD, VELOCITY, 8.0)
    t = np.arange(len(wind)) / 200.0
    ours = one_minus_cosine(t, start=START, ramp=RAMP, hold=HOLD)[:, None] * VELOCITY
    np.testing.assert_allclose(wind, ours, atol=1e-9)  # a frame of offset would be 0.02 m/s
    np.testing.assert_allclose(wind.max(axis=0), [3.0, 0.0, 0.0], atol=1e-9)
    np.testing.assert_allclose(wind.min(axis=0), [0.0, -4.0, -1.0], atol=1e-9)


def test_flies_like_jsbsims_cosine_gust():
    # Given the gust as rows of wind, the aircraft answers as to JSBSim's own: airspeed, sideslip and bank within what
    # one frame of the profile amounts to.
    _, theirs = jsbsims_gust(START, RAMP, HOLD, VELOCITY, 8.0)
    plant = jsbsim_plant(load_aircraft("hale"), has_wind=True)
    rows = empty_rows(len(theirs), 4)
    t = np.arange(len(rows)) / 200.0
    as_records(rows)["wind_n"] = one_minus_cosine(t, start=START, ramp=RAMP, hold=HOLD)[:, None] * VELOCITY
    plant.run(Program([*plant.before(), *plant.given(), *plant.after()]), rows, 0, len(rows))
    ours = as_records(rows)
    frame = 0.005 * np.pi / (2 * RAMP)  # part of the peak that the profile moves in a frame
    for field, size in (("airspeed", 5.0), ("beta", 5.0 / 30.0), ("x1", 0.3)):
        assert np.ptp(theirs[field]) > 0.2 * size, field
        np.testing.assert_allclose(ours[field], theirs[field], atol=2 * frame * size, err_msg=field)


def test_a_scenarios_gust_is_the_wind_of_its_rows():
    # From the scenario to the history: the recorded wind is peak times the closed form, and the aircraft feels it.
    gust = {"kind": "gust", "start_s": 1, "ramp_s": 1.5, "hold_s": 2, "north_mps": 3, "down_mps": -1}
    flight = build_flight(Scenario.model_validate({"name": "gust", "duration_s": 8, "disturbances": [gust]}))
    records, outcome = fly_to_memory(flight)
    assert outcome.completed
    profile = np.sin(np.pi / 3.0 * np.clip(np.minimum(records["t"] - 1.0, 6.0 - records["t"]), 0.0, 1.5)) ** 2
    np.testing.assert_allclose(records["wind_n"], profile[:, None] * [3.0, 0.0, -1.0], atol=1e-12)
    assert np.all(records["airspeed"][:200] == pytest.approx(30.0, abs=1e-3))
    assert 27.0 < records["airspeed"].min() < 29.0  # a tail wind of 3 m/s in 1.5 s, less what the throttle makes up
