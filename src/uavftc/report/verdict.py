"""The verdict on a flight, in words and as a table."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from rich import box
from rich.table import Table
from rich.text import Text

COLOURS = {"survived": "bold green", "degraded": "bold yellow", "lost": "bold red", "numerical": "bold magenta"}
DIGITS = 2  # of a margin


def margin_text(margin: float | None) -> str:
    """Return a margin as shown; one below 0 never as 0."""
    if margin is None:
        return "-"
    text = f"{margin:.{DIGITS}f}"
    return f"{margin:.0e}" if margin < 0.0 and float(text) == 0.0 else text


def verdict_line(verdict: Mapping[str, Any]) -> Text:
    """Return outcome, margin, and what limits it and when, from the `verdict` of a `summary.json` document."""
    limiting = next((one for one in verdict["requirements"] if one["name"] == verdict["limiting"]), None)
    at = "" if limiting is None or limiting["at_s"] is None else f", {limiting['name']} at {limiting['at_s']:.2f} s"
    margin = f", margin {margin_text(verdict['margin'])}{at}"
    text = Text.assemble((verdict["outcome"], COLOURS[verdict["outcome"]]), margin)
    if others := [one["name"] for one in broken(verdict) if one["name"] != verdict["limiting"]]:
        text.append(f"; also broken: {', '.join(others)}")
    return text


def broken(verdict: Mapping[str, Any]) -> Sequence[Mapping[str, Any]]:
    """Return the requirements that were judged and not met."""
    return [one for one in verdict["requirements"] if not one["met"] and one["margin"] is not None]


def twin_table(twin: Mapping[str, Any]) -> Table:
    """Return what each fault and damage did by itself, from the `twin` of a `summary.json` document."""
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    table.add_column(Text("peak deviation [deg],\nrecovered after [s]"))
    for axis in ("roll", "pitch", "yaw"):
        table.add_column(axis, justify="right")
    for one in twin["isolated"]:
        for event in ("onset", "removal"):
            if (found := one[event]) is not None:
                table.add_row(Text(f"{one['key']}, {event}"), *(Text(_recovery(found[axis])) for axis in found))
    return table


def _recovery(found: Mapping[str, float | None]) -> str:
    after = found["recovered_after_s"]
    return f"{found['peak_deg']:.2f}, {'never' if after is None else f'{after:.2f}'}"


def requirement_table(verdict: Mapping[str, Any]) -> Table:
    """Return margin and moment of each requirement."""
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    table.add_column("requirement")
    table.add_column("margin", justify="right")
    table.add_column(Text("at [s]"), justify="right")
    for one in verdict["requirements"]:
        style = "" if one["met"] else "red" if one["margin"] is not None else "dim"
        at = "-" if one["at_s"] is None else f"{one['at_s']:.2f}"
        table.add_row(Text(one["name"]), Text(margin_text(one["margin"]), style=style), at)
    return table
