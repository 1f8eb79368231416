"""What a scenario leaves to the aircraft, and what it is filled in with."""

from __future__ import annotations

import numpy as np
import pytest

from uavftc.aircraft.definition import load_aircraft
from uavftc.control.inner import l1
from uavftc.flight.defaults import NOMINAL_AIRSPEED_MPS, resolved
from uavftc.plants.jsbsim.model import ALTITUDE_M, TrimmedModel
from uavftc.scenario.schema import Scenario

B = np.vstack([np.zeros((3, 3)), [[3.0, 0.1, 0.2], [0.3, 4.0, 0.4], [0.5, 0.6, 5.0]]])


def model(airspeed=62.0, altitude=1500.0):
    """A trimmed model with what a scenario takes from it: its condition and its control matrix."""
    return TrimmedModel(
        trim={"airspeed": airspeed, "altitude": altitude},
        mass_kg=1.0, inertia_kgm2=np.eye(3).tolist(), engines=1, rad_per_command=[1.0] * 3, measured_rad=[True] * 3,
        limits_rad=[[-0.3, 0.3]] * 3, A=np.zeros((8, 8)).tolist(), A_at_once=np.zeros((3, 3)).tolist(),
            B=B.tolist(), throttle_mps2=1.0,
        nonlinearity=[0.0] * 3,
    )  # fmt: skip


def scenario(**sections):
    return Scenario.model_validate({"name": "d", "duration_s": 1, **sections})


@pytest.fixture(scope="module")
def stock():
    """An aircraft without a companion file: it has neither an airspeed nor a control matrix."""
    return load_aircraft("jsbsim:c172p")


@pytest.fixture(scope="module")
def hale():
    return load_aircraft("hale")


def test_what_is_given_stays(hale):
    # The aircraft fills gaps; it never overrules a scenario.
    matrix = ((1.0, 0.0, 0.0), (0.0, 2.0, 0.0), (0.0, 0.0, 3.0))
    given = scenario(
        initial={"airspeed_mps": 25, "altitude_m": 800},
        envelope={"min_airspeed_mps": 0, "max_airspeed_mps": 90},
        controller={"inner": {"B_m": matrix}},
    )
    assert resolved(given, hale, model()) == given


def test_the_condition_of_the_model_fills_an_open_one(stock):
    # The flight begins at the trim that was found, and the envelope is half and twice its airspeed.
    found = resolved(scenario(), stock, model(62.0, 1500.0))
    assert (found.initial.airspeed_mps, found.initial.altitude_m) == (62.0, 1500.0)
    assert (found.envelope.min_airspeed_mps, found.envelope.max_airspeed_mps) == (31.0, 124.0)
    assert found.envelope.bank_deg == scenario().envelope.bank_deg


def test_without_a_model_the_aircrafts_own_condition_counts(hale):
    # hale on the analytic plant is flown without a trim: its companion file says where.
    found = resolved(scenario(plant="analytic"), hale, None)
    assert (found.initial.airspeed_mps, found.initial.altitude_m) == (30.0, 1000.0)


def test_without_any_condition_there_is_a_nominal_one(hale):
    # A rotational model has no airspeed; the envelope must still have limits.
    found = resolved(scenario(plant="analytic"), hale.model_copy(update={"initial": None}), None)
    assert (found.initial.airspeed_mps, found.initial.altitude_m) == (NOMINAL_AIRSPEED_MPS, ALTITUDE_M)
    assert found.envelope.max_airspeed_mps == 2.0 * NOMINAL_AIRSPEED_MPS


@pytest.mark.parametrize("kind", ["l1", "mrac"])
def test_the_control_matrix_is_the_companion_files_or_else_the_one_measured(hale, stock, kind):
    # A controller designed on another B_m than its aircraft's would be a silent fault.
    open_ = scenario(controller={"inner": {"kind": kind}})
    assert hale.analytic is not None
    assert resolved(open_, hale, model()).controller.inner.B_m == hale.analytic.B_m
    np.testing.assert_array_equal(resolved(open_, stock, model()).controller.inner.B_m, B[3:])


def test_a_filled_scenario_is_of_the_same_kind_and_filling_it_again_changes_nothing(stock):
    # What is written to disk as flown must load and fly the same.
    found = resolved(scenario(), stock, model())
    assert isinstance(found.controller.inner, l1.Config)
    assert resolved(found, stock, model(99.0)) == found
    assert Scenario.model_validate(found.model_dump()).initial == found.initial


def test_a_custom_controller_has_no_control_matrix_to_fill(stock):
    # It is designed from the flight itself; its section stays as it is written.
    given = scenario(controller={"kind": "pid", "options": {"rate_bandwidth": 2.0}})
    assert resolved(given, stock, model()).controller == given.controller
