"""The list of aircraft for reading: one line each, in 80 columns."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Sequence
from typing import Any

WIDTH = 80
HEADER = f"{'aircraft':<23}{'kg':>7}{'span m':>7}{'eng.':>5} {'trim':<16}can be flown"
_UNKNOWN = f"{'-':>7}{'-':>7}{'-':>5} "
_SHORTER = (
    (r"no steady flight[:;] .*", "no steady flight found"),
    (r"JSBSim cannot initialise it: .*The property (\S+) does not exist", r"no property \1"),
    (r"JSBSim does not finish loading and trimming it within", "does not load and trim within"),
    (r"JSBSim does not load it: (.* \| )?", "not loaded: "),
    (r"no small-signal (\w+) response: [^;]*", r"no \1 response"),
    (r"no (\w+) response; no (\w+) response", r"no \1 or \2 response"),
    (r"the (\w+) response is not linear in the small.*", r"\1 response is not linear"),
)


def lines(rows: Sequence[dict[str, Any]], width: int = WIDTH) -> list[str]:
    """Return header, a line a row of `jobs.design.fleet.fleet`, and the count.

    What is longer than `width` goes on in the next line, indented.
    """
    body = [part for row in rows for part in _folded(line(row), width, " " * 43)]
    return [HEADER, "-" * min(width, WIDTH), *body, "", *count(rows).splitlines()]


def line(row: dict[str, Any]) -> str:
    """Return one row in words."""
    start = f"{row['aircraft']:<23}"
    if not row["measured"]:
        return f"{start}{_UNKNOWN}not measured yet"
    if not row["trims"]:
        return f"{start}{_UNKNOWN}{shorter(row['reason'])}"
    start += f"{row['mass_kg']:>7.0f}" if row["mass_kg"] >= 100 else f"{row['mass_kg']:>7.1f}"
    start += f"{'-' if row['span_m'] is None else format(row['span_m'], '.1f'):>7}{row['engines']:>5}"
    trim = f"{row['method']} {row['airspeed_mps']:g} m/s"
    if row["flyable"]:
        lacking = "".join(f", no {surface}" for surface in row["without"])
        verdict = f"yes ({row['weakest_axis']} {times(row['ratio'])}{lacking})"
    elif row["ratio"] is not None and row["ratio"] < 1.0:
        verdict = f"no: {row['weakest_axis']} has {row['ratio']:.2f} of its need"
    else:
        verdict = f"no: {shorter(row['reason'])}"
    return f"{start} {trim:<16}{verdict}"


def times(ratio: float) -> str:
    """Return a ratio with three digits."""
    return f"{ratio:.0f} times" if ratio >= 100 else f"{ratio:.3g} times"


def shorter(reason: str) -> str:
    """Return a reason of refusal in fewer words; `--json` has all of them."""
    for pattern, words in _SHORTER:
        reason = re.sub(pattern, words, reason)
    return " ".join(reason.split())


def count(rows: Sequence[dict[str, Any]]) -> str:
    """Return how many there are of each kind."""
    known = [row for row in rows if row["measured"]]
    flyable = sum(row["flyable"] for row in known)
    trimmed = sum(row["trims"] for row in known)
    text = f"{len(rows)} aircraft: {flyable} can be flown, {trimmed - flyable} trim but cannot be flown"
    text += f", {len(known) - trimmed} do not trim or load"
    return text if len(known) == len(rows) else f"{text},\n  {len(rows) - len(known)} not measured yet"


def _folded(text: str, width: int, indent: str) -> list[str]:
    if len(text) <= width:
        return [text]
    last = text.rfind(" ", 0, width + 1)  # the columns before are kept as they are
    return [text[:last].rstrip(), *textwrap.wrap(text[last:], width, initial_indent=indent, subsequent_indent=indent)]
