"""The step check against the stability limit of the integrator, and of what needs no finer steps.

JSBSim integrates the rates by Adams-Bashforth of order 3, which is stable for a real pole -L up to h L = 6/11 (its
characteristic polynomial has the root -1 there). The roll mode is such a pole.
"""

import numpy as np
import pytest

from stiff import stiff
from uavftc.aircraft.definition import load_aircraft
from uavftc.plants.jsbsim import step_check
from uavftc.plants.jsbsim.engines import FRAMES_S
from uavftc.plants.jsbsim.model import finer_because, notes, stepped, trimmed_model
from uavftc.plants.jsbsim.step_check import FRACTION, GROUPS, RATIO, Motion, judged

AB3_LIMIT = 6.0 / 11.0


def test_the_limit_of_adams_bashforth():
    # x_n+1 = x_n - a (23 x_n - 16 x_n-1 + 5 x_n-2) / 12: a root of size one at a = 6/11, by its polynomial alone
    def largest(a):
        return max(abs(np.roots([1.0, -1.0 + 23.0 * a / 12.0, -16.0 * a / 12.0, 5.0 * a / 12.0])))

    assert largest(AB3_LIMIT) == pytest.approx(1.0, abs=1e-12)
    assert largest(0.99 * AB3_LIMIT) < 1.0 < largest(1.01 * AB3_LIMIT)


@pytest.mark.parametrize(("factor", "frame_s"), [(6.0, 5e-3), (8.0, 2.5e-3), (20.0, 1e-3), (25.0, 1e-3), (50.0, 5e-4)])
def test_a_fast_roll_mode_is_stepped_within_the_limit(tmp_path, factor, frame_s):
    model = trimmed_model(load_aircraft(str(stiff(tmp_path / "stiff", factor))), 30.0, 1000.0)
    pole = max(abs(np.linalg.eigvals(np.array(model.A_at_once))))
    stable = [f for f in FRAMES_S if f * pole < AB3_LIMIT]
    assert (model.frame_s, model.step["passed"]) == (stable[0], True)
    assert stable[0] == frame_s
    assert [t["frame_s"] for t in model.step["tried"]] == list(FRAMES_S[: FRAMES_S.index(frame_s) + 1])
    assert [t["passed"] for t in model.step["tried"]] == [f == frame_s for f in FRAMES_S if f >= frame_s]


@pytest.mark.parametrize(
    ("name", "airspeed"),
    [("hale", 30.0), ("jsbsim:c172p", 62.0), ("jsbsim:737", 185.0), ("jsbsim:A4", 130.0), ("jsbsim:f16", 260.0),
     ("jsbsim:SGS", 25.0)],
)  # fmt: skip
def test_what_is_sound_at_5_ms_stays_there(name, airspeed):
    # forces are held over a step, so a sound motion converges at first order: half the step, half the difference
    model = trimmed_model(load_aircraft(name), airspeed, 1000.0)
    assert model.frame_s == 5e-3
    assert model.step["passed"]
    assert len(model.step["tried"]) == 1
    assert model.step["ratio"] == pytest.approx(0.5, abs=0.01)
    assert model.step["first_difference"] < FRACTION / 3.0
    assert finer_because(model) is None


def test_a_finer_step_is_said_with_its_reason(tmp_path):
    aircraft = load_aircraft(str(stiff(tmp_path / "stiff", 8.0)))
    model = trimmed_model(aircraft, 30.0, 1000.0)
    (line,) = (line for line in notes(aircraft, model) if "plant steps" in line)
    assert "at most 2.5 ms, where 5 ms are usual: the step check fails at 5 ms (body rates differs" in line
    by_engines = model._replace(frame_s=1e-3, step={"tried": [{"frame_s": 1e-3, "passed": True}]})
    assert finer_because(model._replace(step={**model.step, "passed": False})) is None  # the flight says it
    assert finer_because(by_engines) == "the thrust of its engines is another at longer ones"


def test_one_of_many_is_checked_once_it_is_flown(hale):
    # of the airspeeds that are tried only the one that is flown is checked, and with the same answer as one alone
    alone = trimmed_model(hale, 30.0, 1000.0)
    of_many = alone._replace(step={})
    assert stepped(hale, of_many) == alone
    assert stepped(hale, alone) is alone
    assert step_check.check(hale, of_many) == alone.step


# --- the criterion, on motions in closed form ---------------------------------------------------------------------


def motion(rates):
    """A motion of the body rates alone."""
    still = np.zeros((len(rates), 1))
    groups = {"body rates": np.asarray(rates)[:, None], "airspeed": still + 30.0}
    return Motion(tuple(groups.get(name, still) for name in GROUPS), 1.0)


T = np.linspace(0.0, 2.0, 401)


def verdict(of_step, h=5e-3):
    return judged(lambda dt: motion(of_step(dt)), h)


def test_first_order_within_the_fraction_passes():
    # sin(t) + k dt t: D1 = k (h/2) 2 s over a motion of about one
    found = verdict(lambda dt: np.sin(T) + 2.0 * dt * T)
    assert found["passed"]
    assert found["first_difference"] == pytest.approx(2.0 * 2.5e-3 * 2.0, rel=0.01)
    assert found["ratio"] == pytest.approx(0.5, rel=1e-6)


def test_an_impulse_in_proportion_to_h_is_caught_by_the_fraction():
    # its ratio is a half, as that of a sound motion
    found = verdict(lambda dt: np.sin(T) + 400.0 * dt * np.exp(-T))
    assert found["ratio"] == pytest.approx(0.5, rel=1e-6)
    assert found["first_difference"] > FRACTION
    assert not found["passed"]
    assert found["worst"] == "body rates"


def test_a_difference_that_does_not_shrink_is_caught_by_the_ratio():
    found = verdict(lambda dt: np.sin(T) + 0.02 * np.cos(T / dt))
    assert found["first_difference"] <= FRACTION
    assert found["ratio"] > RATIO
    assert not found["passed"]


def test_rounding_is_no_difference():
    noise = {h: 1e-9 * np.random.default_rng(i).normal(size=len(T)) for i, h in enumerate((5e-3, 2.5e-3, 1.25e-3))}
    assert verdict(lambda dt: np.sin(T) + noise[dt])["passed"]


def test_what_is_not_finite_has_no_difference():
    found = verdict(lambda dt: np.where(T > 1.0, np.nan, T) if dt == 5e-3 else T)
    assert not found["passed"]
    assert found["first_difference"] is None
    assert found["worst"] == "a value that is not finite"
