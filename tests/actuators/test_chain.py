"""The chain on the surfaces as the flight assembles it: delay, saturation, effectiveness, bias, stops."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from uavftc import actuators
from uavftc.control import allocation
from uavftc.core.given import Given
from uavftc.core.program import Program
from uavftc.core.signals import SURFACES, as_records, empty_rows
from uavftc.flight.build import chain_blocks
from uavftc.flight.timing import timing_of
from uavftc.scenario.schema import Scenario

TRIM = np.array([0.0, -0.1, 0.05])  # rad
STOPS = np.radians([25.0, 25.0, 25.0])  # hale's, either side of neutral
ABOUT_TRIM = np.column_stack([-STOPS - TRIM, STOPS - TRIM])
LOW, HIGH = np.array([-0.05, -0.02, -np.inf]), np.array([0.1, 0.3, np.inf])
SATURATION = {"aileron": {"min_rad": -0.05, "max_rad": 0.1}, "elevator": {"min_rad": -0.02, "max_rad": 0.3}}
FAULTS = [{"surface": surface, "bias_deg": 0} for surface in SURFACES]


def chain(v2, *, omega=1.0, bias=0.0, delay_s=0.0, saturation=SATURATION, substeps=None):
    """The rows after the chain; v2 and the faults are those of each row."""
    scenario = Scenario.model_validate(
        {
            "name": "c",
            "duration_s": 1,
            "saturation": saturation,
            "faults": FAULTS,
            "controller": {"delay_s": delay_s},
            "simulation": {"substeps": substeps},
        }
    )
    timing = timing_of(scenario)
    given_ = Given(
        h=timing.h,
        plant_step=timing.plant_step,
        steps=scenario.steps,
        seed=0,
        effectors=SURFACES,
        stops_rad=ABOUT_TRIM,
        mixing=np.eye(3),
        design=SimpleNamespace(),
    )
    allocate, gather = allocation.blocks(given_)
    plant_step = [allocate, *chain_blocks(actuators.CHAIN, scenario, given_), gather]
    rows = empty_rows(len(v2))
    records = as_records(rows)
    records["v2"], records["effectors"]["effectiveness"], records["effectors"]["bias"] = v2, omega, bias
    assert Program([], plant_step, substeps=timing.substeps).run(rows, 0, len(v2)) == len(v2)
    return records


VECTOR = st.lists(st.floats(-2.0, 2.0), min_size=3, max_size=3).map(np.array)


@settings(deadline=None)  # the first example compiles
@given(v2=VECTOR, omega=VECTOR, bias=VECTOR)
def test_order_is_saturate_then_fault_then_stop(v2, omega, bias):
    # eq. (7): the bias lies outside the saturation; the stops, counted from neutral and not from trim, come last
    records = chain(v2[None], omega=omega, bias=bias)
    expected = np.clip(omega * np.clip(v2, LOW, HIGH) + bias, -STOPS - TRIM, STOPS - TRIM)
    np.testing.assert_allclose(records["u2"][0], expected, rtol=0, atol=1e-15)
    np.testing.assert_array_equal(records["effectors"]["deflection"], records["u2"])


def test_bias_moves_a_saturated_surface_beyond_the_saturation():
    # a fault is not the controller's to limit: 0.1 rad of limit, halved, plus 0.2 rad of bias
    records = chain(np.array([[9.0, 9.0, 0.0]]), omega=[0.5, 1.0, 1.0], bias=[0.2, 0.0, 0.0])
    np.testing.assert_allclose(records["u2"][0], [0.25, 0.3, 0.0], rtol=1e-14)


def test_surface_ends_at_its_mechanical_stop_whatever_the_fault():
    # deflection about trim, plus trim, never leaves the stops: 25 deg either side
    for sign in (-1.0, 1.0):
        records = chain(np.full((1, 3), sign * 50.0), bias=sign * 50.0, saturation=None)
        np.testing.assert_allclose(records["u2"][0] + TRIM, sign * np.radians(25.0), rtol=1e-9)


@pytest.mark.parametrize("substeps", [None, 1])
def test_delay_comes_before_limits_and_the_fault_is_that_of_the_present(substeps):
    # 12.5 ms at 200 Hz are two samples and a half: the old command meets the effectiveness of now. On two plant steps a
    # sample the row keeps the first, which still has the older command; on one it is the mean of the two, limited
    v2 = np.linspace(-0.2, 0.2, 20)[:, None] * np.ones(3)
    omega, bias = np.linspace(1.0, 0.2, 20)[:, None] * np.ones(3), np.linspace(0.0, 0.1, 20)[:, None] * np.ones(3)
    records = chain(v2, omega=omega, bias=bias, delay_s=0.0125, substeps=substeps)
    older, newer = (np.concatenate([np.zeros((n, 3)), v2])[:20] for n in (3, 2))
    old = older if substeps is None else 0.5 * (older + newer)
    np.testing.assert_allclose(records["u2"], omega * np.clip(old, LOW, HIGH) + bias, rtol=0, atol=1e-15)


@pytest.mark.parametrize("field", ["v2", "omega", "bias"])
def test_nan_passes_through_the_whole_chain(field):
    # neither the saturation nor the stops may turn a nan into a deflection
    values = {"v2": np.zeros((1, 3)), "omega": np.ones((1, 3)), "bias": np.zeros((1, 3))}
    values[field][0, 1] = np.nan
    records = chain(values["v2"], omega=values["omega"], bias=values["bias"])
    np.testing.assert_array_equal(np.isnan(records["u2"][0]), [False, True, False])


def test_command_itself_is_left_as_it_was():
    # v2 is published as the controller gave it, and so is the command of each effector: the chain works on deflections
    v2 = np.array([[5.0, -5.0, 5.0]])
    records = chain(v2, bias=0.1)
    np.testing.assert_array_equal(records["v2"], v2)
    np.testing.assert_array_equal(records["effectors"]["command"], v2)
