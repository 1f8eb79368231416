"""The page of a reproduction: the paper's tables next to ours, their ratios drawn, claims, verdicts and findings."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from uavftc.analysis.metrics import METRICS
from uavftc.core.signals import AXES
from uavftc.report import palette
from uavftc.report.page.html import listed, render
from uavftc.report.page.looks import on_page
from uavftc.report.page.tables import Table, facts, ratio, shown, typeset
from uavftc.report.verdict import margin_text

Row = Mapping[str, Any]
_BY_NAME = {metric.name: metric for metric in METRICS}
_HEIGHT = 380  # of a chart, pixels


def reproduction_page(rows: Sequence[Row], document: Mapping[str, Any], *, files: Sequence[str] = ()) -> str:
    """Return the page of a reproduction as HTML.

    Parameters
    ----------
    rows
        Of `reproduce.json`: each printed figure with ours.
    document
        Of `summary.json`.
    files
        Of the result folder, to link to.
    """
    numbers = sorted({row["table"] for row in rows})
    plants = document["plants"]
    charts: list[dict[str, Any]] = []
    looks: dict[str, Any] = {}
    for number in numbers:
        chart, own = _ratios([row for row in rows if row["table"] == number], number, len(plants) > 1)
        charts.append(chart)
        looks |= own
    return render(
        "reproduction.html",
        {"kind": "reproduction", "charts": charts, "looks": looks},
        title="Section 4 of the paper, flown again",
        flights=document["flights"],
        plants=plants,
        scores=_scores(document["scores"]),
        parts_of=[
            {
                "key": f"table{number}",
                "title": f"Table {number}: {_scenarios(rows, number)}",
                "tables": [_printed_table(rows, number, plant) for plant in plants],
            }
            for number in numbers
        ],
        claims=_claims(document["claims"]),
        verdicts=_verdicts(document["verdicts"]),
        findings=[
            {**one, "table": Table(one["header"], [[str(cell) for cell in row] for row in one["rows"]], one["title"])}
            for one in document["findings"]
        ],
        facts=facts(document["provenance"]),
        files=listed(files),
    )


def _scenarios(rows: Sequence[Row], number: int) -> str:
    return ", ".join(dict.fromkeys(row["scenario"] for row in rows if row["table"] == number))


def _series(row: Row, several: bool) -> str:
    """Return what a column of a table of the paper is called."""
    name = str(row["controller"]) + (", unsaturated" if row["saturation"] == "unsaturated" else "")
    return f"{row['plant']}, {name}" if several else name


def _ratios(rows: Sequence[Row], number: int, several: bool) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return a chart of ours over the paper's for each figure of a table, and how its series look."""
    names = list(dict.fromkeys(_series(row, several) for row in rows))
    looked = palette.in_order(names)
    places = [(axis, name) for axis in AXES for name in _BY_NAME if any(_at(row, axis, name) for row in rows)]
    series = []
    for i, name in enumerate(names):
        mine = [row for row in rows if _series(row, several) == name and row["printed"] and row["ours"]]
        series.append(
            {
                "name": name,
                "look": f"t{number}s{i}",
                "marks": ("circle", "square", "triangle-up", "diamond", "triangle-down", "cross")[i % 6],
                "x": [places.index((row["axis"], row["metric"])) for row in mine],
                "y": [row["ours"] / row["printed"] for row in mine],
                "text": [
                    f"{name}, {row['axis']}, {_BY_NAME[row['metric']].title}: ours {row['ours']:.4g}, "
                    f"paper {row['printed']:.4g}"
                    for row in mine
                ],
            }
        )
    chart = {
        "key": f"table{number}",
        "series": series,
        "x": {
            "texts": [f"{axis}: {_BY_NAME[name].label}" for axis, name in places],
            "range": [-0.5, len(places) - 0.5],
        },
        "y": {"title": "ours / paper", "type": "log"},
        "level": 1.0,
        "height": _HEIGHT,
    }
    return chart, {f"t{number}s{i}": on_page(looked[name]) for i, name in enumerate(names)}


def _at(row: Row, axis: str, name: str) -> bool:
    return (row["axis"], row["metric"]) == (axis, name)


def _printed_table(rows: Sequence[Row], number: int, plant: str) -> Table:
    """Return a table of the paper on a plant: printed, ours and ratio of each of its columns."""
    mine = [row for row in rows if (row["table"], row["plant"]) == (number, plant)]
    names = list(dict.fromkeys(_series(row, False) for row in mine))
    cells = {(row["axis"], row["metric"], _series(row, False)): row for row in mine}
    header = [""]
    for name in names:
        header += [f"{name}, paper", "ours", "ratio"]
    found: list[list[str]] = []
    bold = []
    for axis in AXES:
        bold.append(len(found))
        found.append([axis, *[""] * (len(header) - 1)])
        for metric in METRICS:
            if not any((axis, metric.name, name) in cells for name in names):
                continue
            line = [metric.title.replace("^2", "²")]
            for name in names:
                row = cells.get((axis, metric.name, name))
                values = (None, None) if row is None else (row["printed"], row["ours"])
                line += [shown(metric, values[0]), shown(metric, values[1]), ratio(values[1], values[0])]
            found.append(line)
    return Table(header, found, f"On the {plant} plant", bold)


def _scores(scores: Mapping[str, Mapping[str, Mapping[str, float]]]) -> Table:
    kinds = list(next(iter(next(iter(scores.values())).values())))
    rows = [
        [plant, units, *(f"{values[kind]:.3f}" for kind in kinds)]
        for plant, by_units in scores.items()
        for units, values in by_units.items()
    ]
    caption = "Root mean square of ln(ours / printed) over the integral metrics of NNDONDI-L1: 0.1 is 10 %"
    return Table(["plant", "units", *kinds], rows, caption)


def _claims(claims: Sequence[Mapping[str, Any]]) -> Table:
    header = ["table", "plant", "axis", "metric", "lower than", "printed [%]", "ours [%]", "answer"]
    rows = [
        [
            str(one["table"]), one["plant"], one["axis"], one["metric"].upper(), one["over"], _percent(one["printed"]),
            _percent(one["ours"]), one["answer"],
        ]
        for one in claims
    ]  # fmt: skip
    return Table(header, rows, "By how much NNDONDI-L1 is lower than another controller")


def _percent(value: float | None) -> str:
    return "–" if value is None else typeset(f"{value:.1f}")


def _verdicts(verdicts: Sequence[Mapping[str, Any]]) -> Table:
    rows = [
        [one["scenario"], one["controller"], one["plant"], one["outcome"], typeset(margin_text(one["margin"])),
         one["limiting"] or "–"]
        for one in verdicts
    ]  # fmt: skip
    return Table(["scenario", "controller", "plant", "verdict", "margin", "limited by"], rows, "Verdict on each flight")
