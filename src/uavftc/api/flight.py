"""A flight as a value: verdict, metrics, history, figures; saved to a result folder and loaded from one."""

from __future__ import annotations

import base64
import html
import io
import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from uavftc.analysis.verdict import Verdict
from uavftc.api.history import History
from uavftc.api.metrics import FlightMetrics
from uavftc.errors import InputError
from uavftc.jobs.fly import write_flight
from uavftc.results.flight import FlightResult
from uavftc.results.summary import ending_of, title_of
from uavftc.scenario.schema import Scenario

if TYPE_CHECKING:
    from matplotlib.figure import Figure

NOTEBOOK_DPI = 90  # of what a notebook keeps


class Flight:
    """A flight that is over: from `uavftc.fly`, or read by `uavftc.load` from the folder that it was saved to.

    ``flight["phi_rad"]`` is a column of its history, a NumPy array. It can be pickled.
    """

    def __init__(self, result: FlightResult) -> None:
        self._result = result

    @property
    def scenario(self) -> Scenario:
        """What was flown, with every default filled in."""
        return self._result.scenario

    @property
    def verdict(self) -> Verdict | None:
        """Outcome, margin, what limits it, and each requirement; None where the flight was interrupted."""
        return self._result.verdict

    @property
    def metrics(self) -> FlightMetrics:
        """Metrics by axis and name: ``metrics["pitch"].iae``."""
        return FlightMetrics(self._result.axes)

    @property
    def history(self) -> History:
        """Every recorded signal at every sample (docs/history.md)."""
        assert self._result.history is not None
        return History(self._result.history)

    @property
    def completed(self) -> bool:
        """Whether it reached its end."""
        return self._result.outcome.completed

    @property
    def ended_because(self) -> str | None:
        """Why it ended early; None of a flight that reached its end."""
        return self._result.outcome.ended_because

    @property
    def warnings(self) -> tuple[str, ...]:
        """What is worth knowing about it, one line each."""
        return tuple(self.summary["warnings"])

    @property
    def summary(self) -> dict[str, Any]:
        """The document of `summary.json`."""
        return self._result.summary()

    def __getitem__(self, column: str) -> np.ndarray:
        return self.history[column]

    def _ipython_key_completions_(self) -> list[str]:
        return list(self._result.history or ())

    def plot(self, figure: str = "overview") -> Figure:
        """Return one of the flight's figures, as docs/figures.md explains them.

        Parameters
        ----------
        figure
            `overview`, `tracking`, `control`, `estimates`, `air`, or `custom` where its controller has signals.

        Raises
        ------
        InputError
            If the flight has no such figure.
        """
        from uavftc.report.backend import load_matplotlib  # noqa: PLC0415 - matplotlib takes most of a second

        load_matplotlib()
        from uavftc.report import figures  # noqa: PLC0415

        history, context = self._result.history or {}, self._result.figure_context()
        there = figures.drawings(history, context)
        if figure not in there:
            raise no_figure(figure, list(there))
        return shown(there[figure].draw())

    def save(self, folder: str | os.PathLike[str], *, figures: bool = True) -> Path:
        """Write the result folder that `uavftc-fly --out` writes, and return it.

        An older folder is replaced only if uavftc wrote it and nothing in it was changed.

        Raises
        ------
        InputError
            If the folder cannot be written; nothing is written then.
        """
        write_flight(self._result, Path(folder), figures=figures)
        return Path(folder)

    def __repr__(self) -> str:
        document = self.summary
        return f"{title_of(document)}: {ending_of(document)[1]}"

    def _repr_html_(self) -> str:
        return f"<p>{html.escape(repr(self))}</p>{picture(self.plot())}"


def no_figure(name: str, there: list[str]) -> InputError:
    """Return the error of a figure that does not exist."""
    return InputError(
        f"plot({name!r})", found=f"no figure {name}", expected=f"one of {', '.join(there)}", remedy="choose one of them"
    )


def shown(figure: Figure) -> Figure:
    """Return a figure that a notebook shows, whatever its backend."""
    figure._repr_png_ = lambda: _png(figure)  # type: ignore[attr-defined]
    return figure


def picture(figure: Figure) -> str:
    """Return a figure as an HTML image."""
    return f'<img style="max-width: 100%" src="data:image/png;base64,{base64.b64encode(_png(figure)).decode()}">'


def _png(figure: Figure) -> bytes:
    data = io.BytesIO()
    figure.savefig(data, format="png", dpi=NOTEBOOK_DPI)
    return data.getvalue()
