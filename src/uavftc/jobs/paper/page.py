"""`reproduction.md`: the tables with printed value, ours and ratio, the claims, the findings, in Markdown."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from uavftc.core.signals import AXES
from uavftc.jobs.paper.findings import Finding
from uavftc.jobs.paper.tables import CONFIRMED, NOT_CONFIRMED, TIED, Claim, Row, ratio, score, scored

LABELS = {
    "steady_state_error_deg": "steady-state error [deg]",
    "convergence_time_s": "convergence time [s]",
    "iae": "IAE [rad s]",
    "ise": "ISE [rad² s]",
    "itae": "ITAE [rad s²]",
    "itse": "ITSE [rad² s²]",
}
TITLES = {
    2: "Table 2. Scenario 1: input saturation only",
    3: "Table 3. Scenario 2: saturation and disturbances",
    5: "Table 5. Scenario 3: saturation, disturbances and actuator faults",
}


def table(header: Sequence[str], rows: Iterable[Sequence[Any]]) -> str:
    """Return a Markdown table."""
    lines = ["| " + " | ".join(header) + " |", "|" + "---|" * len(header)]
    lines += ["| " + " | ".join(str(cell) for cell in row) + " |" for row in rows]
    return "\n".join(lines) + "\n"


def _value(value: float | None) -> str:
    return "-" if value is None else f"{value:.4g}"


def _ratio(row: Row) -> str:
    r = ratio(row)
    return "" if r is None else f"{r:.2f}"


def paper_table(rows: Sequence[Row], number: int, plant: str) -> str:
    """Return Table 2, 3 or 5 of one plant: for each axis and metric printed, ours and ratio of each column."""
    mine = [r for r in rows if r["table"] == number and r["plant"] == plant]
    columns = list(dict.fromkeys((r["controller"], r["saturation"]) for r in mine))
    cells = {(r["axis"], r["metric"], r["controller"], r["saturation"]): r for r in mine}
    header = ["angle", "metric"]
    for controller, saturation in columns:
        name = saturation if number == 2 else controller
        header += [f"{name}, printed", "ours", "ratio"]
    body = []
    for axis in AXES:
        for metric, label in LABELS.items():
            line = [axis, label]
            for controller, saturation in columns:
                row = cells[axis, metric, controller, saturation]
                line += [_value(row["printed"]), _value(row["ours"]), _ratio(row)]
            body.append(line)
    return table(header, body)


def claims_table(claims: Sequence[Claim], number: int) -> str:
    """Return Table 4 or 6: printed percentage, recomputed, ours, the answer, and what each condition gives."""
    mine = [c for c in claims if c.improvement.table == number]
    names = list(dict.fromkeys(name for c in mine for name in c.conditions))
    header = ["angle", "metric", "lower than", "printed [%]", "from the printed tables [%]", "ours [%]", "answer"]
    body = []
    for c in mine:
        i = c.improvement
        ours = "-" if i.ours is None else f"{i.ours:.1f}"
        line = [i.axis, i.metric.upper(), i.over, f"{i.printed:g}", f"{i.recomputed:.1f}", ours, c.answer]
        line += ["" if c.conditions.get(n) is None else f"{c.conditions[n]:.1f}" for n in names]
        body.append(line)
    return table([*header, *(f"with {name} [%]" for name in names)], body)


def claims_summary(claims: Sequence[Claim]) -> str:
    """Return how many claims have each answer, and how many only a named condition confirms."""
    answers = [claim.answer.split(";")[0] for claim in claims]
    counts = ", ".join(f"{answers.count(a)} {a}" for a in (CONFIRMED, TIED, NOT_CONFIRMED))
    conditional = sum("only with" in claim.answer for claim in claims)
    return f"{counts}; {conditional} of those not confirmed outright are confirmed only under a named condition"


def finding_text(finding: Finding) -> str:
    """Return one finding as a section."""
    return (
        f"### {finding.title} ({finding.plant})\n\n{finding.statement}\n\n{table(finding.header, finding.rows)}\n"
        f"Shown by `{finding.command}`.\n"
    )


VERDICTS = (
    "What the flights behind the tables are worth by the default requirements (docs/requirements.md): flown "
    "to the end, error at most 1 deg in the last quarter and 5 deg after 5 s, surfaces calm, within the envelope.\n"
)


def verdict_table(verdicts: Sequence[Mapping[str, Any]]) -> str:
    """Return the verdict on each flight, one line a scenario and controller, with the plants next to each other."""
    plants = list(dict.fromkeys(v["plant"] for v in verdicts))
    by_case = {(v["scenario"], v["controller"], v["plant"]): v for v in verdicts}
    rows = []
    for scenario, controller in dict.fromkeys((s, c) for s, c, _ in by_case):
        cells = (by_case[scenario, controller, plant] for plant in plants)
        rows.append([scenario, controller, *(f"{v['outcome']}, {v['margin']:.2f} ({v['limiting']})" for v in cells)])
    return table(["scenario", "controller", *plants], rows)


def score_table(scores: dict[str, dict[str, dict[str, float]]]) -> str:
    """Return the scores of each plant: with the literal units and with the fitted scale of the additive fault."""
    body = []
    for plant, kinds in scores.items():
        for kind, values in kinds.items():
            body.append([plant, kind, *(f"{values[k]:.3f}" for k in ("all", "table 2", "table 3", "table 5"))])
    return table(["plant", "units", f"all {scored()}", "Table 2", "Table 3", "Table 5"], body)


def scores_of(rows: Sequence[Row]) -> dict[str, float]:
    """Return the score over all tables and of each."""
    return {"all": score(rows), **{f"table {n}": score(rows, n) for n in TITLES}}


def page(
    rows: Sequence[Row],
    claims: dict[str, Sequence[Claim]],
    found: Sequence[Finding],
    scores: dict[str, dict[str, dict[str, float]]],
    figures: Sequence[str],
    captions: dict[int, str],
    verdicts: Sequence[Mapping[str, Any]] = (),
) -> str:
    """Return the whole page.

    Parameters
    ----------
    rows
        As in `reproduce.json`.
    claims
        For each plant, the answers to Tables 4 and 6.
    found
        All findings.
    scores
        For each plant and units, the values of `scores_of`.
    figures
        Paths of the figures' PNG files, relative to the page.
    captions
        Caption of each figure, by number.
    verdicts
        As `verdicts.verdicts_of` returns them.
    """
    plants = list(scores)
    parts = [
        "# Section 4 of the paper, flown again\n",
        "Zhou, Liu, Li, Liu: *Neural Network Disturbance Observer-Based Adaptive Fault-Tolerant Attitude Tracking "
        "Control for UAVs with Actuator Faults, Input Saturation, and External Disturbances*. Actuators 2025, 14(9), "
        "437. Every number of ours on this page was computed from the flights of this run.\n",
        "## Score\n",
        f"Root mean square of ln(ours / printed) over the {scored()} integral metrics of NNDONDI-L1 in Tables 2, 3 and "
        "5: 0.1 is 10 %.\n",
        score_table(scores),
    ]
    for number in (2, 3, 5):
        parts.append(f"## {TITLES[number]}\n")
        for plant in plants:
            parts += [f"On the {plant} plant:\n", paper_table(rows, number, plant)]
        if number == 2:
            continue
        parts.append(f"## Table {number + 1}. What Table {number} says of the controllers\n")
        for plant in plants:
            mine = [c for c in claims[plant] if c.improvement.table == number + 1]
            parts += [
                f"On the {plant} plant: NNDONDI-L1 lower than the other, by how many percent. "
                f"{claims_summary(mine)}.\n",
                claims_table(claims[plant], number + 1),
            ]
    if verdicts:
        parts += ["## Verdicts\n", VERDICTS, verdict_table(verdicts)]
    parts.append("## Findings\n")
    parts += [finding_text(f) for f in found]
    if figures:
        parts.append("## Figures\n")
        for path in figures:
            number = int(path.rsplit("figure-", 1)[1][:2])
            parts.append(f"![Figure {number}. {captions[number]}]({path})\n\n*{captions[number]}*\n")
    return "\n".join(parts)
