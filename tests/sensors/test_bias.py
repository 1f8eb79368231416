"""What the controller sees: the exact measurement, and the bias of a sensor on it."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from uavftc import sensors
from uavftc.core.program import Program
from uavftc.core.signals import ROW, as_records, empty_rows
from uavftc.core.stage import params_of
from uavftc.scenario.schema import Sensors
from uavftc.sensors import bias, exact

VECTOR = st.lists(st.floats(-10.0, 10.0), min_size=3, max_size=3).map(np.array)


def measured(attitude, gyro) -> Program:
    return Program([exact.stage.block(), bias.stage.block(params_of(bias.PARAMS, attitude=attitude, gyro=gyro))])


@settings(deadline=None)  # the first example compiles
@given(x1=VECTOR, x2=VECTOR, attitude=VECTOR, gyro=VECTOR)
def test_bias_is_added_to_the_measurement_and_to_nothing_else(x1, x2, attitude, gyro):
    # the vehicle's own attitude and rates are untouched
    rows = empty_rows(1)
    row = as_records(rows)[0]
    row["x1"], row["x2"] = x1, x2
    measured(attitude, gyro).run(rows, 0, 1)
    np.testing.assert_array_equal(row["x1_meas"], x1 + attitude)
    np.testing.assert_array_equal(row["x2_meas"], x2 + gyro)
    np.testing.assert_array_equal(row["x1"], x1)
    np.testing.assert_array_equal(row["x2"], x2)
    others = [name for name in ROW.names if name not in ("x1", "x2", "x1_meas", "x2_meas")]
    assert all((row[name] == 0.0).all() for name in others)
    assert not any(row["effectors"][name].any() for name in row["effectors"].dtype.names)


def test_measurement_follows_the_vehicle_row_by_row():
    # no lag and no memory: the bias stays what it is
    rows = empty_rows(50)
    records = as_records(rows)
    records["x2"] = np.random.default_rng(12).normal(size=(50, 3))
    measured(0.0, [0.1, -0.2, 0.3]).run(rows, 0, 50)
    np.testing.assert_array_equal(records["x2_meas"], records["x2"] + [0.1, -0.2, 0.3])


def test_every_flight_has_the_exact_measurement_first_and_a_bias_only_where_there_is_one():
    # an error works on a measurement that is there; what does nothing costs nothing
    assert sensors.CHAIN[0] is exact
    assert [block.name for block in exact.blocks(None, None)] == ["exact"]
    assert [block for effect in sensors.CHAIN[1:] for block in effect.blocks(Sensors(), None)] == []
    (block,) = bias.blocks(bias.Config(gyro_bias_degps=(0.0, -3.0, 0.0)), None)
    np.testing.assert_allclose(block.params["gyro"], [[0.0, -np.pi / 60.0, 0.0]], rtol=1e-15)
    (block,) = bias.blocks(bias.Config(attitude_bias_deg=(0.0, 0.0, 18.0)), None)
    np.testing.assert_allclose(block.params["attitude"], [[0.0, 0.0, np.pi / 10.0]], rtol=1e-15)
