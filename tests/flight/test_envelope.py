"""The watch: which limit it names, in which words, and what it must not take for a loss."""

from __future__ import annotations

import numpy as np
import pytest

from uavftc.core.program import Program
from uavftc.core.signals import as_records, empty_rows
from uavftc.core.stage import params_of
from uavftc.flight import envelope

LIMITS = params_of(
    envelope.PARAMS, bank_max=np.radians(60.0), pitch_max=np.radians(30.0), airspeed_min=15.0, airspeed_max=60.0
)


def good_rows(n=1):
    rows = empty_rows(n)
    records = as_records(rows)
    records["t"] = np.arange(n) * 0.005
    records["airspeed"], records["height"] = 30.0, 1000.0
    return rows, records


def watched(n=1, **fields):
    """Status and record of the one row after the watch."""
    rows, records = good_rows()
    records["t"] = 1.2345
    for name, value in fields.items():
        records[name] = value
    Program([envelope.stage.block(LIMITS)]).run(rows, 0, n)
    return int(records[0]["status"]), records[0]


LOST = [
    ({"x1": [np.radians(60.1), 0, 0]}, envelope.BANK, "attitude outside the envelope: bank 60.1 deg, limit 60 deg"),
    ({"x1": [np.radians(-75), 0, 0]}, envelope.BANK, "attitude outside the envelope: bank -75.0 deg, limit 60 deg"),
    ({"x1": [0, np.radians(31), 0]}, envelope.PITCH, "attitude outside the envelope: pitch 31.0 deg, limit 30 deg"),
    ({"x1": [0, np.radians(-31), 0]}, envelope.PITCH, "attitude outside the envelope: pitch -31.0 deg, limit 30 deg"),
    ({"airspeed": 14.99}, envelope.SLOW, "airspeed outside the envelope: 14.99 m/s, lower limit 15 m/s"),
    ({"airspeed": 60.01}, envelope.FAST, "airspeed outside the envelope: 60.01 m/s, upper limit 60 m/s"),
    ({"height": 0.0}, envelope.GROUND, "ground contact"),
    ({"height": -3.0}, envelope.GROUND, "ground contact"),
    ({"contact": -1.0}, envelope.GROUND, "ground contact"),  # the gear touches above the height of the ground
    ({"x1": [0, 0, np.nan]}, envelope.NOT_A_NUMBER, "a state or command is not a number"),
    ({"x2": [0, np.inf, 0]}, envelope.NOT_A_NUMBER, "a state or command is not a number"),
    ({"v2": [0, 0, -np.inf]}, envelope.NOT_A_NUMBER, "a state or command is not a number"),
]


@pytest.mark.parametrize(("fields", "code", "words"), LOST)
def test_each_limit_has_its_code_and_its_words(fields, code, words):
    # the user reads why and when; the sign shows which way it went
    status, row = watched(**fields)
    assert status == code
    assert envelope.reason(LIMITS[0], row) == f"{words}, at t = 1.234 s"


@pytest.mark.parametrize("index", [0, 1, 2])
@pytest.mark.parametrize("field", ["x1", "x2", "v2"])
@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_any_state_or_command_that_is_not_a_number_is_a_loss(field, index, value):
    # each of the nine elements is looked at
    vector = np.zeros(3)
    vector[index] = value
    assert watched(**{field: vector})[0] == envelope.NOT_A_NUMBER


@pytest.mark.parametrize("field", ["airspeed", "height", "altitude", "alpha", "beta", "throttle", "wind_n"])
def test_air_data_that_a_plant_lacks_never_trips(field):
    # the rotational model has none: nan there is absence, not loss
    assert watched(**{field: np.nan})[0] == 0


def test_at_the_limits_it_still_flies():
    # the limits belong to the envelope; heading has none
    x1 = [LIMITS["bank_max"][0], -LIMITS["pitch_max"][0], 1000.0]
    assert watched(x1=x1, airspeed=15.0, height=1e-9)[0] == 0
    assert watched(airspeed=60.0)[0] == 0


def test_not_a_number_comes_before_every_other_reason():
    # its row is not recorded, so it must not hide behind a limit that is also broken
    assert watched(x1=[3.0, np.nan, 0.0], airspeed=1.0, height=-1.0)[0] == envelope.NOT_A_NUMBER
    assert watched(x1=[3.0, 3.0, 0.0], airspeed=1.0)[0] == envelope.BANK


def test_no_limit_is_expressed_by_infinity():
    # half a turn of bank, any airspeed
    open_ = params_of(envelope.PARAMS, bank_max=np.inf, pitch_max=np.inf, airspeed_min=-np.inf, airspeed_max=np.inf)
    rows, records = good_rows()
    records["x1"], records["airspeed"] = [3.0, 1.5, 9.0], 1e6
    Program([envelope.stage.block(open_)]).run(rows, 0, 1)
    assert records[0]["status"] == 0


def test_flight_stops_at_the_first_row_outside():
    # rows after the loss are not flown
    rows, records = good_rows(20)
    records["airspeed"][7:9] = 5.0
    assert Program([envelope.stage.block(LIMITS)]).run(rows, 0, 20) == 7
    np.testing.assert_array_equal(records["status"], np.where(np.arange(20) == 7, envelope.SLOW, 0))
