"""The signal row and the columns published from it."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from uavftc.core import signals
from uavftc.core.signals import (
    COLUMNS,
    EFFECTOR,
    ROW,
    ROW_WIDTH,
    Shape,
    as_records,
    attitude_error,
    column,
    empty_rows,
    row_type,
)

ANGLE = st.floats(-20.0, 20.0)


WIDTH = ROW_WIDTH + 3 * EFFECTOR.itemsize // 8


def test_row_is_a_flat_buffer_of_float64():
    # laws take a row as a record, the recorder and the loop take it as numbers: the layout has no gap
    for dtype in (ROW, EFFECTOR):
        assert all(dtype[name].base == np.dtype("f8") for name in dtype.names)
        assert dtype.itemsize == 8 * sum(int(np.prod(dtype[name].shape)) for name in dtype.names)
    assert ROW.itemsize == 8 * ROW_WIDTH
    rows = empty_rows(4)
    assert rows.shape == (4, WIDTH)
    assert rows.flags.c_contiguous
    assert not rows.any()


@pytest.mark.parametrize("effectors", [1, 3, 7])
def test_a_row_ends_with_one_record_for_each_effector(effectors):
    # the head is the same in every flight, so a law that knows it flies every aircraft
    rows = empty_rows(5, effectors)
    assert rows.shape == (5, ROW_WIDTH + effectors * len(EFFECTOR.names))
    assert row_type(Shape(effectors)).itemsize == 8 * rows.shape[1]
    rows[:] = np.arange(rows.size).reshape(rows.shape)
    records = as_records(rows)
    assert records["effectors"].shape == (5, effectors)
    head = rows[:, :ROW_WIDTH].copy().view(ROW)[:, 0]
    for name in ROW.names:
        np.testing.assert_array_equal(records[name], head[name])
    for j in range(effectors):
        for i, name in enumerate(EFFECTOR.names):
            np.testing.assert_array_equal(
                records["effectors"][name][:, j], rows[:, ROW_WIDTH + j * len(EFFECTOR.names) + i]
            )


def test_records_are_the_same_memory():
    # what a law writes under a name is in the row, and the other way round
    rows = empty_rows(3)
    records = as_records(rows)
    assert records.shape == (3,)
    records["x1"][1] = [1.0, 2.0, 3.0]
    start = ROW.fields["x1"][1] // 8
    np.testing.assert_array_equal(rows[1, start : start + 3], [1.0, 2.0, 3.0])
    rows[2] = np.arange(WIDTH)
    assert records["x1"][2, 0] == start
    assert as_records(rows[1:])["x1"][0, 1] == 2.0  # of a slice as well
    records["effectors"]["deflection"][0, 2] = 4.0
    assert rows[0, ROW_WIDTH + 2 * len(EFFECTOR.names) + EFFECTOR.names.index("deflection")] == 4.0


def test_columns_are_unique_exist_and_carry_their_unit():
    # names are the interface to whoever reads the history
    names = [c.name for c in COLUMNS]
    assert len(set(names)) == len(names)
    assert names[0] == "time_s"
    unitless = {"effectiveness_aileron", "effectiveness_elevator", "effectiveness_rudder", "throttle"}
    endings = ("_s", "_rad", "_radps", "_radps2", "_mps", "_m")
    assert {n for n in names if not n.endswith(endings)} == unitless
    for c in COLUMNS:
        assert ROW[c.field].shape == (() if c.component is None else (3,))


def test_column_takes_the_field_and_index_it_names():
    # each row element holds its own position: no column may be crossed with another
    rows = np.arange(2 * WIDTH, dtype=float).reshape(2, WIDTH)
    records = as_records(rows)
    for c in COLUMNS:
        if c.name in ("psi_rad", "psi_meas_rad"):  # wrapped
            continue
        position = ROW.fields[c.field][1] // 8 + (c.component or 0)
        np.testing.assert_array_equal(column(records, c.name), [position, position + WIDTH], err_msg=c.name)
    for name, field, component in (
        ("q_ref_radps", "v1", 1),
        ("rudder_cmd_rad", "v2", 2),
        ("aileron_rad", "u2", 0),
        ("theta_meas_rad", "x1_meas", 1),
        ("r_meas_radps", "x2_meas", 2),
    ):
        np.testing.assert_array_equal(column(records, name), records[field][:, component])
    with pytest.raises(KeyError):
        column(records, "no_such_column")


@pytest.mark.parametrize(("name", "field"), [("psi_rad", "x1"), ("psi_meas_rad", "x1_meas")])
@settings(deadline=None)
@given(psi=ANGLE, psi_c=ANGLE)
def test_heading_is_published_within_half_a_turn_of_its_reference(name, field, psi, psi_c):
    # psi is continuous in the row; in the history it is next to its reference, whole turns away; measured too
    records = as_records(empty_rows(1))
    records[field][0, 2], records["x1_c"][0, 2] = psi, psi_c
    (published,) = column(records, name)
    assert abs(published - psi_c) <= np.pi + 1e-9
    turns = (published - psi) / (2 * np.pi)
    assert turns == pytest.approx(round(turns), abs=1e-9)
    assert records[field][0, 2] == psi  # the row itself is left alone


@settings(deadline=None)
@given(x1=st.tuples(ANGLE, ANGLE, ANGLE), x1_c=st.tuples(ANGLE, ANGLE, ANGLE))
def test_attitude_error_is_command_minus_attitude(x1, x1_c):
    # bank and pitch as they are, the heading the short way round: equal sine and cosine, at most half a turn
    records = as_records(empty_rows(1))
    records["x1"], records["x1_c"] = x1, x1_c
    (error,) = attitude_error(records)
    plain = np.array(x1_c) - x1
    np.testing.assert_array_equal(error[:2], plain[:2])
    assert abs(error[2]) <= np.pi + 1e-9
    np.testing.assert_allclose(np.exp(1j * error[2]), np.exp(1j * plain[2]), atol=1e-13)


def test_names_of_axes_and_surfaces_match_the_order_of_the_vectors():
    # lists of three in scenarios and summaries count in this order
    assert signals.AXES == ("roll", "pitch", "yaw")
    assert signals.SURFACES == ("aileron", "elevator", "rudder")
