"""The linear form of PID and LQI is the law itself about the trim, as long as no limit acts."""

import numpy as np
import pytest

from uavftc.control.whole import lqi, pid
from uavftc.core.signals import as_records, empty_rows
from uavftc.flight.build import build_flight
from uavftc.scenario.load import load_scenario

H = 0.005


@pytest.fixture(scope="module")
def design():
    # scenario 1: trim at no bank, so that the angles of an attitude add up; limits far off what is asked
    return build_flight(load_scenario("scenario1", overrides=["saturation=null"])).given.design


def answer(linear, y):
    """Return what a linear law answers to y, shape (n, 6)."""
    x, found = np.zeros(len(linear.A)), []
    for measured in y:
        found.append(linear.C @ x + linear.D @ measured)
        x = linear.A @ x + linear.B @ measured
    return np.array(found)


def small(n=200):
    return 1e-7 * np.random.default_rng(3).normal(size=(n, 6))


def test_pid(design):
    y = small()
    step = pid.create(design, H, {})
    flown = np.array([step(0.0, design.x1_trim, design.x1_trim + m[:3], m[3:])[0] for m in y])
    np.testing.assert_allclose(flown, answer(pid.linear(design, H, {}), y), rtol=0, atol=1e-12)


def test_lqi(design):
    y = small()
    state, rows = np.zeros(1, lqi.STATE), as_records(empty_rows(1))
    params = lqi.params(design, H, {})
    flown = []
    for measured in y:
        rows[0]["x1_c"] = design.x1_trim
        rows[0]["x1_meas"], rows[0]["x2_meas"] = design.x1_trim + measured[:3], measured[3:]
        lqi.stage.step.py_func(params.view(np.recarray)[0], state.view(np.recarray)[0], rows.view(np.recarray)[0])
        flown.append(rows[0]["v2"].copy())
    np.testing.assert_allclose(flown, answer(lqi.linear(design, H, {}), y), rtol=0, atol=1e-12)
