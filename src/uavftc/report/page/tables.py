"""Tables of a page: cells of text, made here so that templates only write them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from uavftc.analysis.metrics import METRICS, Metric
from uavftc.core.signals import AXES
from uavftc.report.table import number
from uavftc.report.verdict import margin_text

Printed = Mapping[tuple[str, str], float | None]
"""By axis and metric what the paper prints; None where it prints a dash."""


class Table(NamedTuple):
    """A table: heading and cells, all of them text; the first column names the rows."""

    header: Sequence[str]
    rows: Sequence[Sequence[str]]
    caption: str = ""
    bold: Sequence[int] = ()
    """Rows that stand for a heading."""


def typeset(text: str) -> str:
    """Return a number or unit with its proper signs."""
    return text.replace("^2", "²").replace("-", "\N{MINUS SIGN}")


def shown(metric: Metric, value: float | None) -> str:
    """Return a metric as a page shows it."""
    return "–" if value is None else typeset(number(value, metric.digits))


def metric_table(axes: Mapping[str, Mapping[str, float | None]], printed: Printed | None) -> Table:
    """Return the metrics of a flight; next to each, where there is such a flight in the paper, what it prints."""
    header = ["metric"]
    for axis in AXES:
        header += [axis] if printed is None else [axis, "paper", "ratio"]
    rows = []
    for metric in METRICS:
        row = [metric.title.replace("^2", "²")]
        for axis in AXES:
            value = axes[axis][metric.name]
            row.append(shown(metric, value))
            if printed is not None:
                paper = printed.get((axis, metric.name))
                row += [shown(metric, paper), ratio(value, paper)]
        rows.append(row)
    return Table(header, rows, "Metrics of each axis")


def ratio(ours: float | None, paper: float | None) -> str:
    """Return ours over the paper's."""
    return "" if ours is None or not paper else f"{ours / paper:.2f}"


def requirement_table(verdict: Mapping[str, Any] | None) -> list[dict[str, Any]]:
    """Return each requirement of a verdict: name, margin as text, as the length of a bar in per cent, met, moment."""
    return [
        {
            "name": one["name"],
            "margin": typeset(margin_text(one["margin"])),
            "bar": 0.0 if one["margin"] is None else 100.0 * min(abs(one["margin"]), 1.0),
            "met": one["met"],
            "at_s": one["at_s"],
            "limiting": one["name"] == verdict["limiting"],
        }
        for one in (verdict or {}).get("requirements", ())
        if verdict is not None
    ]


def facts(provenance: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Return a provenance as names and texts, nested keys with dots between them."""
    found: list[tuple[str, str]] = []
    for key, value in provenance.items():
        if isinstance(value, Mapping):
            found += [(f"{key}.{inner}", text) for inner, text in facts(value)]
        else:
            found.append((key, "–" if value is None else str(value)))
    return found
