"""The figures that the paper prints, carried as package data: Tables 2, 3 and 5, and the percentages of 4 and 6.

They are only compared with computed figures; nothing that computes ours reads this module.
Source: Zhou et al., Actuators 2025, 14(9), 437, CC BY 4.0.
"""

from __future__ import annotations

import csv
import functools
from importlib.resources import files
from typing import NamedTuple


class Printed(NamedTuple):
    """One printed figure of Table 2, 3 or 5."""

    table: int
    scenario: str
    controller: str
    saturation: str
    """`saturated` or `unsaturated`."""
    axis: str
    metric: str
    """Spelled as in `summary.json`; it names the unit."""
    value: float | None
    """None where the paper prints a dash: not converged within 20 s."""

    @property
    def shipped(self) -> str:
        """Name of the shipped scenario that flies it."""
        return f"{self.scenario}-unsaturated" if self.saturation == "unsaturated" else self.scenario


class PrintedImprovement(NamedTuple):
    """One printed percentage of Table 4 or 6: how much lower NNDONDI-L1 is than another controller."""

    table: int
    scenario: str
    axis: str
    metric: str
    over: str
    percent: float


def _rows(name: str) -> list[dict[str, str]]:
    text = (files(__package__) / name).read_text(encoding="utf-8")
    return list(csv.DictReader(text.splitlines()))


@functools.cache
def tables() -> tuple[Printed, ...]:
    """Return all figures of Tables 2, 3 and 5, in the order of print."""
    return tuple(
        Printed(
            int(row["table"]),
            row["scenario"],
            row["controller"],
            row["saturation"],
            row["axis"],
            row["metric"],
            float(row["value"]) if row["value"] else None,
        )
        for row in _rows("tables.csv")
    )


@functools.cache
def improvements() -> tuple[PrintedImprovement, ...]:
    """Return all percentages of Tables 4 and 6, in the order of print."""
    return tuple(
        PrintedImprovement(
            int(row["table"]), row["scenario"], row["axis"], row["metric"], row["over"], float(row["percent"])
        )
        for row in _rows("improvements.csv")
    )
