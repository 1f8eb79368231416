"""A comparison as a value: one scenario flown by several controllers or on both plants."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from uavftc.api.flight import Flight, no_figure, picture, shown
from uavftc.api.tables import table
from uavftc.jobs.compare import Key, document_of, drawn, write_comparison
from uavftc.report.side_by_side import markdown, title_of
from uavftc.results.flight import FlightResult

if TYPE_CHECKING:
    from matplotlib.figure import Figure


class Comparison(Mapping[str | Key, Flight]):
    """Flights of one scenario side by side: from `uavftc.compare`, or read by `uavftc.load`.

    ``comparison["pid"]`` is the flight of a controller; on two plants ``comparison["jsbsim", "pid"]``.
    """

    def __init__(self, flown: Mapping[Key, FlightResult], variants: Mapping[str, Mapping[str, Any]]) -> None:
        self._flown, self._variants = dict(flown), dict(variants)

    @property
    def summary(self) -> dict[str, Any]:
        """The document of `summary.json`."""
        return document_of(self._flown, self._variants)

    def __getitem__(self, key: str | Key) -> Flight:
        found = [k for k in self._flown if key in (k, k[1])]
        if len(found) != 1:
            there = ", ".join(map(repr, self))
            raise KeyError(f"{'no' if not found else 'more than one'} flight {key!r}; there are {there}")
        return Flight(self._flown[found[0]])

    def __iter__(self) -> Iterator[str | Key]:
        several = len({plant for plant, _ in self._flown}) > 1
        return iter(self._flown) if several else (controller for _, controller in self._flown)

    def __len__(self) -> int:
        return len(self._flown)

    def plot(self, figure: str = "tracking") -> Figure:
        """Return one of the comparison's figures: `tracking`, `commands`, or of two plants `difference`.

        Raises
        ------
        InputError
            If it has no such figure.
        """
        from uavftc.report.backend import load_matplotlib  # noqa: PLC0415 - matplotlib takes most of a second

        load_matplotlib()
        from uavftc.report import overlays, panels  # noqa: PLC0415

        there = overlays.drawings(*drawn(self._flown, title_of(self.summary)))
        if figure not in there:
            raise no_figure(figure, list(there))
        with panels.style():
            return shown(there[figure]())

    def save(self, folder: str | os.PathLike[str], *, figures: bool = True) -> Path:
        """Write the result folder that `uavftc compare --out` writes, and return it.

        Raises
        ------
        InputError
            If the folder cannot be written; nothing is written then.
        """
        write_comparison(self._flown, self._variants, Path(folder), figures=figures)
        return Path(folder)

    def __repr__(self) -> str:
        return markdown(self.summary)

    def _repr_html_(self) -> str:
        names = [" on ".join(reversed(key)) if isinstance(key, tuple) else key for key in self]
        rows = []
        for name, result in zip(names, self._flown.values(), strict=True):
            verdict = result.verdict
            judged = ("", None, "") if verdict is None else (verdict.outcome, verdict.margin, verdict.limiting or "")
            rows.append([name, *judged, *(axis["iae"] for axis in result.axes.values())])
        axes = [f"IAE {axis} [rad s]" for axis in next(iter(self._flown.values())).axes]
        shown_as = table(["controller", "verdict", "margin", "limited by", *axes], rows, title_of(self.summary))
        return shown_as + picture(self.plot())
