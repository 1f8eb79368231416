"""The page of a comparison: the flights of one scenario over each other, and their tables next to each other."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from uavftc.analysis.metrics import CONVERGENCE_BAND_DEG, METRICS
from uavftc.core.signals import ANGLES, AXES, SURFACES
from uavftc.report import palette
from uavftc.report.page.flight import columns, happened, plots
from uavftc.report.page.html import budget_bytes, listed, render
from uavftc.report.page.looks import LOOKS, on_page
from uavftc.report.page.packed import Curve, Group, Panel
from uavftc.report.page.signals import TURN
from uavftc.report.page.tables import Printed, Table, facts, ratio, shown, typeset
from uavftc.report.series import column, deg, finite, wound_up
from uavftc.report.side_by_side import PLACES, distance_rows, title_of, variant_lines
from uavftc.report.verdict import margin_text
from uavftc.results.context import FigureContext
from uavftc.results.summary import ending_of

Key = tuple[str, str]
"""(plant, controller)."""
History = Mapping[str, np.ndarray]
_ERROR_FLOOR_DEG = 1e-3


def comparison_page(
    histories: Mapping[Key, History],
    context: FigureContext,
    document: dict[str, Any],
    scenario: str,
    *,
    printed: Mapping[str, Printed] | None = None,
    remarks: Sequence[str] = (),
    files: Sequence[str] = ("summary.json", "scenario.yaml", "comparison.csv", "comparison.md"),
) -> str:
    """Return the page of a comparison as HTML.

    Parameters
    ----------
    histories
        By plant and controller, published columns sampled at the same times; a flight may end early.
    context
        Limits and windows of the scenario.
    document
        Of `summary.json`.
    scenario
        The text of `scenario.yaml`, that of the first flight.
    printed
        By controller, what the paper prints of it; None where it has no such scenario.
    remarks, files
        As `flight.flight_page` takes them.
    """
    context = replace(context, limiting=None, twin=None)
    looked = palette.looks(list(histories))
    t = max((history["time_s"] for history in histories.values()), key=len)
    names = {key: look["label"] for key, look in looked.items()}
    own = {f"flight{i}": on_page(look) for i, look in enumerate(looked.values())}
    groups = list(_groups(histories, context, list(names.values())))
    end = float(t[-1]) if len(t) else 0.0
    data = {
        "kind": "comparison",
        **plots(groups, t, budget_bytes(), LOOKS | own),
        **happened(context, end),
    }
    flights = document["combinations"]
    return render(
        "comparison.html",
        data,
        title=title_of(document),
        flights=[(f"{one['plant']}, {one['controller']}", *ending_of(one)) for one in flights],
        variants=variant_lines(document),
        windows=data["windows"],
        columns=columns(groups),
        metrics=side_by_side(flights, printed or {}),
        has_paper=bool(printed),
        distances=[
            Table(["", *PLACES], [[row[0], *map(typeset, row[1:])] for row in rows], f"Distance, {plants}")
            for plants, rows in distance_rows(document).items()
        ],
        warnings=[*document["warnings"], *remarks],
        scenario=scenario,
        facts=facts(document["provenance"]),
        files=listed(files),
    )


def _groups(histories: Mapping[Key, History], context: FigureContext, names: Sequence[str]) -> Iterator[Group]:
    """Yield attitude, its error, commands, deflections and air of all flights."""

    def curves(read: Callable[[History], np.ndarray], turn: float | None = None) -> list[Curve]:
        return [
            Curve(name, f"flight{i}", read(history), turn)
            for i, (name, history) in enumerate(zip(names, histories.values(), strict=True))
        ]

    def panel(title: str, unit: str, drawn: list[Curve], concerns: str, **more: Any) -> Panel:
        return Panel(title, unit, drawn, [number for number, _ in context.concerning(concerns)], **more)

    longest = max(histories.values(), key=lambda history: len(history["time_s"]))
    attitude, errors, commands, reached = [], [], [], []
    for i, (angle, surface) in enumerate(zip(ANGLES, SURFACES, strict=True)):
        turn = TURN if angle == "psi" else None
        drawn = curves(lambda h, a=angle: _from_first(deg(h, f"{a}_rad"), deg(h, f"{a}_rad")), turn)  # type: ignore[misc]
        if context.controlled[i]:
            reference = _from_first(deg(longest, f"{angle}_ref_rad"), deg(longest, f"{angle}_rad"))
            drawn.append(Curve("reference", "reference", reference))
            off = curves(lambda h, a=angle: np.abs(deg(h, f"{a}_ref_rad") - deg(h, f"{a}_rad")))  # type: ignore[misc]
            log: Any = {"log": True, "floor": _ERROR_FLOOR_DEG, "limits": (CONVERGENCE_BAND_DEG,)}
            errors.append(panel(f"{AXES[i]}, |error|", "deg", off, angle, **log))
            asked = curves(lambda h, s=surface: deg(h, f"{s}_cmd_rad"))  # type: ignore[misc]
            got = curves(lambda h, s=surface: deg(h, f"{s}_rad"))  # type: ignore[misc]
            bounds = [float(np.rad2deg(v)) for v in context.limits_rad.get(surface) or () if np.isfinite(v)]
            now = [part for one in asked for part in wound_up(one.y, [other.y for other in got], bounds)]
            limited: Any = {"least": 0.2, "limits": bounds}
            commands.append(panel(f"{surface}, commanded", "deg", asked, surface, shown=now, **limited))
            reached.append(panel(f"{surface}, reached", "deg", got, surface, **limited))
        title = f"{AXES[i]} angle, from trim" + ("" if context.controlled[i] else ", not controlled")
        attitude.append(panel(title, "deg", drawn, angle, least=0.5))
    air = [
        panel(name, unit, curves(lambda h, c=key: column(h, c)), name, least=least)  # type: ignore[misc]
        for name, key, unit, least in (("airspeed", "airspeed_mps", "m/s", 1.0), ("altitude", "altitude_m", "m", 2.0))
        if any(np.isfinite(column(history, key)).any() for history in histories.values())
    ]
    all_of = {"Attitude": attitude, "Commands": commands, "Errors": errors, "Deflections": reached, "Air": air}
    yield from (Group(title.lower(), title, panels) for title, panels in all_of.items() if panels)


def _from_first(values: np.ndarray, actual: np.ndarray) -> np.ndarray:
    """Return angles less the first one flown."""
    found = finite([actual])
    return values - (found[0] if found.size else 0.0)


def side_by_side(flights: Sequence[Mapping[str, Any]], printed: Mapping[str, Printed]) -> Table:
    """Return verdicts and metrics of all flights, one column each; behind one what the paper prints of it."""
    header, cells = [""], []
    for flight in flights:
        header.append(f"{flight['plant']}, {flight['controller']}" + ("" if flight["completed"] else " (lost)"))
        if flight["controller"] in printed:
            header += ["paper", "ratio"]
        verdict = flight["verdict"]
        if verdict is None:
            cells.append(["–"] * 3)
        else:
            cells.append([verdict["outcome"], typeset(margin_text(verdict["margin"])), verdict["limiting"] or "–"])
    rows: list[list[str]] = []
    for i, label in enumerate(("verdict", "margin", "limited by")):
        row = [label]
        for flight, words in zip(flights, cells, strict=True):
            row += [words[i], "", ""] if flight["controller"] in printed else [words[i]]
        rows.append(row)
    bold = []
    for axis in AXES:
        bold.append(len(rows))
        rows.append([axis, *[""] * (len(header) - 1)])
        for metric in METRICS:
            row = [metric.title.replace("^2", "²")]
            for flight in flights:
                value = flight["axes"][axis][metric.name]
                row.append(shown(metric, value))
                if flight["controller"] in printed:
                    paper = printed[flight["controller"]].get((axis, metric.name))
                    row += [shown(metric, paper), ratio(value, paper)]
            rows.append(row)
    return Table(header, rows, "Verdict and metrics of each flight", bold)
