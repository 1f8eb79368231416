"""A chattering curve is drawn as its mean over a band; any other as it is."""

from __future__ import annotations

import numpy as np
import pytest
from matplotlib.figure import Figure

from uavftc.report.chatter import chatter, chattering
from uavftc.report.panels import cut, name_off_scale

T = np.arange(4001) / 200.0


@pytest.mark.parametrize("period", [2, 3, 4, 6])
def test_a_chatter_is_a_band_of_its_amplitude_around_its_mean(period):
    y = 1.0 + 0.2 * T + np.where((T >= 5) & (T <= 10), 0.5 * np.sin(2 * np.pi * np.arange(4001) / period + 0.4), 0.0)
    ax = Figure().subplots()
    busy = chattering(y)
    assert busy[1010:1990].all()
    assert not busy[:980].any()
    assert not busy[2020:].any()
    chatter(ax, T, y, color="red", label="command")
    (line,) = ax.lines
    inside = slice(1020, 1980)
    np.testing.assert_allclose(line.get_ydata()[inside], 1.0 + 0.2 * T[inside], atol=1e-3)
    np.testing.assert_array_equal(line.get_ydata()[~busy], y[~busy])
    (path,) = ax.collections[0].get_paths()
    assert path.get_extents().ymin == pytest.approx(y[busy].min())
    assert path.get_extents().ymax == pytest.approx(y[busy].max())
    assert ax.get_legend_handles_labels()[1] == ["command", "range of chatter"]


@pytest.mark.parametrize(
    "y",
    [
        np.sin(3 * T),
        np.where(T > 8, 1.0, 0.0),
        np.where(T < 0.1, (-1.0) ** np.arange(4001) * np.exp(-50 * T), np.exp(-T)),  # rings after a step
        np.exp(-T) + 1e-3 * (-1.0) ** np.arange(4001),  # thinner than a line
        np.zeros(4001),
        np.full(4001, np.nan),
        np.zeros(1),
        np.zeros(0),
    ],
    ids=["sine", "step", "ringing", "hair", "zero", "nothing", "one row", "no row"],
)
def test_anything_else_is_drawn_as_it_is(y):
    ax = Figure().subplots()
    chatter(ax, T[: len(y)], y, color="red")
    np.testing.assert_array_equal(ax.lines[0].get_ydata(), y)
    assert not ax.collections


def test_the_axis_reaches_one_span_beyond_the_limits_and_says_what_does_not_fit():
    ax = Figure().subplots()
    ax.plot([0, 1, 2], [-0.06, 1.62, 0.0])
    ax.set_ylim(-0.1, 1.7)
    cut(ax, [-0.05, 0.1])
    name_off_scale(ax)
    assert ax.get_ylim() == pytest.approx((-0.1, 0.25))
    assert ax.get_title(loc="right") == "off scale: to +1.62"
    ax.set_ylim(-0.1, 0.2)
    cut(ax, [-0.05, 0.1])
    assert ax.get_ylim() == (-0.1, 0.2)
