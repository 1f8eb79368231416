"""The page of a flight."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from uavftc.report.page.html import budget_bytes, listed, render
from uavftc.report.page.looks import LOOKS, SHADES
from uavftc.report.page.packed import Group, points_within
from uavftc.report.page.signals import groups_of
from uavftc.report.page.tables import Printed, facts, metric_table, requirement_table, typeset
from uavftc.report.page.view import Sketch, view_of
from uavftc.report.verdict import margin_text
from uavftc.results.context import FigureContext
from uavftc.results.summary import ending_of, title_of
from uavftc.results.windows import FlightWindow

_VIEW_BYTES = 250_000  # of the moving view


def flight_page(
    history: Mapping[str, np.ndarray],
    context: FigureContext,
    document: Mapping[str, Any],
    scenario: str,
    *,
    sketch: Sketch,
    printed: Printed | None = None,
    remarks: Sequence[str] = (),
    files: Sequence[str] = ("history.parquet", "summary.json", "scenario.yaml"),
) -> str:
    """Return the page of a flight as HTML.

    Parameters
    ----------
    history
        Published columns, name to shape (n,), SI and rad, NaN where there is none.
    context
        Limits, effectors, windows and what else figures show next to the history.
    document
        Of `summary.json`.
    scenario
        The text of `scenario.yaml`.
    sketch
        How the moving view draws the aircraft.
    printed
        What the paper prints of this flight; None where it has no such flight.
    remarks
        What the page itself is worth a warning for.
    files
        Of the result folder, to link to.
    """
    groups = groups_of(history, context)
    end = float(history["time_s"][-1]) if len(history["time_s"]) else 0.0
    verdict = document["verdict"]
    outcome, ending = ending_of(document)
    data = {
        "kind": "flight",
        **plots(groups, history["time_s"], budget_bytes() - _VIEW_BYTES, LOOKS),
        **happened(context, end),
        "view": view_of(history, context.windows, sketch),
    }
    return render(
        "flight.html",
        data,
        title=title_of(document),
        outcome=outcome,
        ending=ending,
        margin=None if verdict is None else typeset(margin_text(verdict["margin"])),
        limiting=context.limiting,
        windows=data["windows"],
        columns=columns(groups),
        requirements=requirement_table(verdict),
        metrics=metric_table(document["axes"], printed),
        has_paper=printed is not None,
        has_way="north" in data["view"],
        warnings=[*document["warnings"], *remarks],
        scenario=scenario,
        facts=facts(document["provenance"]),
        end=end,
        files=listed(files),
    )


def columns(groups: Sequence[Group]) -> list[list[Group]]:
    """Return the groups in two columns about as long as each other, in their order."""
    found: list[list[Group]] = [[], []]
    lengths = [0, 0]
    for group in groups:
        shorter = int(lengths[1] < lengths[0])
        found[shorter].append(group)
        lengths[shorter] += len(group.panels) + 1
    return found


def plots(groups: Sequence[Group], t: np.ndarray, budget: float, looks: Mapping[str, Any]) -> dict[str, Any]:
    """Return what the scripts draw of groups of panels over one clock, in about so many bytes."""
    points = points_within(groups, budget)
    step = (float(t[-1]) - float(t[0])) / (len(t) - 1) if len(t) > 1 else 0.0
    return {
        "clock": {"start": float(t[0]) if len(t) else 0.0, "step": step, "rows": len(t)},
        "groups": [{"key": group.key, "panels": [panel.packed(points) for panel in group.panels]} for group in groups],
        "looks": dict(looks),
    }


def happened(context: FigureContext, end: float) -> dict[str, Any]:
    """Return the windows of a flight as a page has them, and the limiting moment."""
    return {
        "windows": [window_document(number, window, end) for number, window in enumerate(context.windows, 1)],
        "shades": SHADES,
        "limiting": None if context.limiting is None else {"name": context.limiting[0], "at": context.limiting[1]},
    }


def window_document(number: int, window: FlightWindow, end: float) -> dict[str, Any]:
    """Return one window: its number, kind, name, when it begins and ends within the flight, and when it is known."""
    known = window.known_from_s
    return {
        "number": number,
        "kind": window.kind,
        "name": window.name,
        "start": window.start_s,
        "end": min(window.end_s, end) if end > 0.0 else window.end_s,
        "known": None if known is None or known > end else known,
    }
