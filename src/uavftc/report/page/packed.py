"""Curves as a page carries them: thinned, in 32 bits, in base64, and as few as fit into the page."""

from __future__ import annotations

import base64
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from uavftc.report.series import extremes, finite, signed, span

MAX_POINTS = 2_000
"""Points of a curve at most; the least and the greatest value of each stretch are among them."""
_POINT_BYTES = 8.0  # of a point in base64: two or four bytes say which sample it is, four its value
_LEAST_POINTS = 200


@dataclass(frozen=True)
class Curve:
    """One curve over the samples of a flight."""

    name: str
    look: str
    """How it looks: a key of `looks.LOOKS`, or of those of the page."""
    y: np.ndarray
    """Shape (n,), in the unit of its panel, NaN where there is none."""
    turn: float | None = None
    """Where it jumps by more than half of this there is no line."""

    def packed(self, points: int) -> dict[str, Any]:
        """Return it as the page has it, with about so many points at most."""
        y = np.asarray(self.y, dtype=float)
        rows = np.arange(len(y)) if len(y) <= points else extremes(y, points // 2 - 1)
        rows = rows[_bends(y[rows])]
        values = y[rows]
        if self.turn is not None:
            wraps = np.flatnonzero(np.abs(np.diff(values)) > 0.5 * self.turn) + 1
            rows, values = np.insert(rows, wraps, rows[wraps]), np.insert(values, wraps, np.nan)
        index = rows.astype("<u2" if len(y) <= 1 << 16 else "<u4")
        return {"name": self.name, "look": self.look, "rows": packed(index), "y": packed(values.astype("<f4"))}


@dataclass(frozen=True)
class Panel:
    """One panel of a group."""

    title: str
    unit: str
    curves: Sequence[Curve]
    windows: Sequence[int] = ()
    """Numbers of the windows that it shades."""
    limits: Sequence[float] = ()
    """Limits to draw, in its unit."""
    least: float = 0.0
    """Least length of the y-axis, in its unit."""
    shown: Sequence[np.ndarray] | None = None
    """What the y-axis is to show; None: all curves."""
    remark: str = ""
    log: bool = False
    floor: float = 0.0
    """Of a logarithmic axis."""

    def packed(self, points: int) -> dict[str, Any]:
        """Return it as the page has it."""
        drawn = [np.asarray(curve.y, dtype=float) for curve in self.curves]
        values, now = finite(drawn), finite(drawn if self.shown is None else self.shown)
        reach = 2.0 * float(np.ptp(now)) if now.size else 0.0
        near = [v for v in self.limits if now.size and float(np.abs(now - v).min()) <= reach]
        low, high = span(drawn if self.shown is None else self.shown, self.least, [np.array(near)])
        remarks = [self.remark] if self.remark else []
        if self.log:
            low, high = self.floor, 2.0 * max(float(values.max(initial=self.floor)), 10.0 * self.floor)
        elif values.size:
            slack = 1e-9 * (high - low)
            least, most = float(values.min()), float(values.max())
            beyond = [signed(v) for v, off in ((least, least < low - slack), (most, most > high + slack)) if off]
            remarks += [f"off scale: to {' and '.join(beyond)}"] if beyond else []
        off = [signed(v) for v in self.limits if v not in near]
        remarks += [f"off scale: limit {', '.join(off)}"] if off else []
        return {
            "title": self.title,
            "unit": self.unit,
            "curves": [curve.packed(points) for curve in self.curves],
            "windows": list(self.windows),
            "limits": near,
            "range": [low, high],
            "remark": "; ".join(remarks).replace("-", "\N{MINUS SIGN}"),
            "log": self.log,
        }


@dataclass(frozen=True)
class Group:
    """Panels that stand together under a heading."""

    key: str
    """Of the place in the page."""
    title: str
    panels: Sequence[Panel] = field(default_factory=list)


def packed(values: np.ndarray) -> dict[str, str]:
    """Return an array of shape (n,) as a page reads it: its type, little-endian, and its bytes in base64."""
    kind = values.dtype.newbyteorder("<")
    text = base64.b64encode(np.ascontiguousarray(values, dtype=kind).tobytes()).decode("ascii")
    return {"type": kind.str[1:], "data": text}


def points_within(groups: Sequence[Group], budget_bytes: float) -> int:
    """Return how many points a curve may have, so that all of them take about so many bytes."""
    curves = sum(len(panel.curves) for group in groups for panel in group.panels)
    return int(min(MAX_POINTS, max(_LEAST_POINTS, budget_bytes / (_POINT_BYTES * max(curves, 1)))))


def _bends(y: np.ndarray) -> np.ndarray:
    """Return the places of the samples that a curve needs: not those within a stretch of one and the same value."""
    if len(y) < 3:
        return np.arange(len(y))
    same = (y[1:] == y[:-1]) | (np.isnan(y[1:]) & np.isnan(y[:-1]))
    return np.flatnonzero(~np.concatenate([[False], same[1:] & same[:-1], [False]]))
