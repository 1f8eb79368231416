"""Why a flight was lost: the first cause is named, by a flight that is known and by rows made up."""

import numpy as np
import pytest

from uavftc.core.signals import AXES, as_records, empty_rows
from uavftc.flight.build import build_flight
from uavftc.flight.departure import departure
from uavftc.flight.fly import fly_to_memory
from uavftc.scenario.load import load_scenario


@pytest.fixture(scope="module")
def flight():
    return build_flight(load_scenario("scenario1"))


def rows(flight, n=400):
    records = as_records(empty_rows(n, flight.shape), flight.shape)
    records["t"] = np.arange(n) / 200.0
    return records


@pytest.mark.parametrize(("axis", "name"), list(enumerate(AXES)))
def test_the_axis_and_the_moment_after_the_last_small_error(flight, axis, name):
    records = rows(flight)
    records["x1"][50:60, axis] = 0.1  # away and back again
    records["x1"][200:, axis] = 0.1  # 5.7 deg
    assert departure(flight, records) == f"departed in {name} from 1.00 s"


def test_of_several_axes_the_first_counts(flight):
    records = rows(flight)
    records["x1"][300:, 0] = 0.5
    records["x1"][250:, 2] = 0.5
    assert departure(flight, records) == "departed in yaw from 1.25 s"


def test_what_was_at_its_stop_by_then_is_named_and_what_came_later_is_not(flight):
    records = rows(flight)
    records["x1"][200:, 2] = 0.5
    rudder, elevator = (flight.given.effectors.index(name) for name in ("rudder", "elevator"))
    records["effectors"]["deflection"][150:, rudder] = flight.given.stops_rad[rudder][1]
    records["effectors"]["deflection"][380:, elevator] = flight.given.stops_rad[elevator][0]
    assert departure(flight, records) == "departed in yaw from 1.00 s, rudder at its stop from 0.75 s"


def test_an_end_with_a_small_error_has_not_departed(flight):
    assert departure(flight, rows(flight)) is None


def test_a_hardover_is_named_with_the_end():
    _, outcome = fly_to_memory(build_flight(load_scenario("beyond/fault-hardover-stop")))
    assert outcome.ended_because.startswith(
        "departed in yaw from 6.55 s, under faults[0] (hardover of rudder) since 6 s, "
    )
    assert "rudder at its stop from" in outcome.ended_because
    assert "; ended by airspeed outside the envelope" in outcome.ended_because
