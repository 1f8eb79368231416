"""The report of a campaign as a page in Markdown, with its figures."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from uavftc.report.campaign_text import (
    broken_text,
    headline,
    interval_text,
    metric_text,
    p_text,
    percent,
    sensitivity_text,
    short,
    success_line,
)

FIGURES = {
    "success": "How often each holds, and how its flights end",
    "margins": "Margins, and how they differ on the same cases",
    "map": "The margin over two inputs, and where it passes 0",
    "sensitivity": "What the margin depends on",
    "metrics": "The metrics",
}


def page(document: Mapping[str, Any], figures: Sequence[str]) -> str:
    """Return the page; `figures` are paths of those that were drawn, from where the page stands."""
    return "\n".join(_lines(document, figures)) + "\n"


def _lines(document: Mapping[str, Any], figures: Sequence[str]) -> Iterator[str]:
    of = {name: path for path in figures for name in FIGURES if path.endswith(f"/{name}.png")}
    yield f"# {headline(document)}"
    yield ""
    if document["description"]:
        yield document["description"]
        yield ""
    yield f"{success_line(document).capitalize()}. Base `{document['base']}`, design {document['design']}, "
    yield f"seed {document['seed']}. Intervals are those of 95 %."
    yield ""
    yield from _listed(document["notes"])
    yield from ["## How often each holds", ""]
    yield from success_rows(document)
    yield from _figure(of, "success")
    if document["pairs"]:
        yield from ["## On the same cases", ""]
        yield from pair_rows(document)
    yield from _figure(of, "margins")
    if any(document["sensitivity"]["variants"].values()):
        yield from ["## What matters", ""]
        yield from sensitivity_rows(document)
    yield from _figure(of, "sensitivity")
    yield from _figure(of, "map")
    yield from ["## Metrics", "", "Median / 95 % quantile of the flights that have the metric.", ""]
    yield from metric_rows(document)
    yield from _figure(of, "metrics")
    yield from ["## The worst flights", ""]
    for name, worst in document["worst_of"].items():
        yield from _worst(name, worst)
    yield "## Of what"
    yield ""
    yield from _listed(f"{name} {version}" for name, version in document["provenance"].items())


def success_rows(document: Mapping[str, Any]) -> Iterator[str]:
    """Yield the table of success, for this page or another."""
    yield "| controller | flights | success, % | 95 % interval, % | margin: 5 %, median, 95 % | margin below 0 by |"
    yield "|---|---|---|---|---|---|"
    for one in document["variants"]:
        margin = ", ".join(short(one["margin"][key]) for key in ("p05", "median", "p95"))
        share, ends = percent(one["success"]), interval_text(one["interval"])
        yield f"| `{one['name']}` | {one['flights']} | {share} | {ends} | {margin} | {broken_text(one)} |"
    yield ""


def pair_rows(document: Mapping[str, Any]) -> Iterator[str]:
    """Yield the table of pairs."""
    yield f"p is that of McNemar's exact test, times the {len(document['pairs'])} pairs. Margins: first minus second."
    yield ""
    yield "| first | second | only first | only second | both | p | mean, 95 % interval | 5 %, median, 95 % | better |"
    yield "|---|---|---|---|---|---|---|---|---|"
    for one in document["pairs"]:
        margin = one["margin"]
        ends = margin["mean_interval"]
        mean = short(margin["mean"]) + (f" ({ends[0]:.3g} to {ends[1]:.3g})" if ends else "")
        spread = ", ".join(short(margin[key]) for key in ("p05", "median", "p95"))
        better = "-" if margin["first_better"] is None else f"{100 * margin['first_better']:.0f} %"
        yield (
            f"| `{one['first']}` | `{one['second']}` | {one['only_first']} | {one['only_second']} | {one['both']} "
            f"| {p_text(one['p_adjusted'])} | {mean} | {spread} | {better} |"
        )
    yield ""


def sensitivity_rows(document: Mapping[str, Any]) -> Iterator[str]:
    """Yield the table of sensitivity."""
    said = document["sensitivity"]["variants"]
    if document["sensitivity"]["method"] is None:
        yield "Rank correlation (Spearman) of the margin with each key."
    else:
        yield "PAWN index of the margin, 0 to 1; two dots where it is no more than chance gives."
        yield "+ and -: the margin goes up or down with the key."
    yield ""
    yield "| key | " + " | ".join(f"`{name}`" for name in said) + " |"
    yield "|---|" + "---|" * len(said)
    for key in document["sensitivity"]["order"]:
        cells = (sensitivity_text((one or {}).get(key)).strip() for one in said.values())
        yield f"| `{key}` | " + " | ".join(cells) + " |"
    yield ""


def metric_rows(document: Mapping[str, Any]) -> Iterator[str]:
    """Yield the table of metrics."""
    names = [one["name"] for one in document["variants"]]
    yield "| axis | metric | " + " | ".join(f"`{name}`" for name in names) + " |"
    yield "|---|---|" + "---|" * len(names)
    for one in document["metrics"]:
        cells = " | ".join(metric_text(one["variants"][name]) for name in names)
        yield f"| {one['axis']} | {one['label']}, {one['unit']} | {cells} |"
    yield ""


def _worst(name: str, worst: Sequence[Mapping[str, Any]]) -> Iterator[str]:
    if not worst:
        return
    yield f"`{name}`:"
    yield ""
    yield "| case | margin | outcome | limited by |"
    yield "|---|---|---|---|"
    for one in worst:
        yield f"| {one['case']} | {one['margin']:.4f} | {one['outcome']} | {one['limiting']} |"
    yield ""
    yield "```sh"
    for one in worst:
        if one["command"] is not None:
            yield one["command"]
    yield "```"
    yield ""


def _listed(lines: Any) -> Iterator[str]:
    some = [f"- {line}" for line in lines]
    yield from [*some, ""] if some else []


def _figure(of: Mapping[str, str], name: str) -> Iterator[str]:
    if name in of:
        yield f"![{FIGURES[name]}]({of[name]})"
        yield ""
