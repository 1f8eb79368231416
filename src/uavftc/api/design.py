"""The design of an aircraft's inner loop as a value: what `uavftc design` prints, as NumPy arrays."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from uavftc.api.flight import picture, shown

if TYPE_CHECKING:
    from matplotlib.figure import Figure


class Design:
    """Trim, linear model, modes, authority, gains, L1 norms and bounds of an aircraft.

    Each key of the document of ``uavftc design --json`` is an attribute; matrices are NumPy arrays, with NaN for an
    axis that is not controlled, and what does not exist is None. ``document`` says why.
    """

    def __init__(self, document: dict[str, Any]) -> None:
        self.document = document

    def __getattr__(self, name: str) -> Any:
        document = self.__dict__.get("document", {})
        if name not in document:
            raise AttributeError(f"no {name} in this design; there are {', '.join(document)}")
        return _array(document[name])

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *self.document]

    def plot(self) -> Figure:
        """Return the figure that ``uavftc design --figure`` draws: poles, authority, what moves what."""
        from uavftc.report.backend import load_matplotlib  # noqa: PLC0415 - matplotlib takes most of a second

        load_matplotlib()
        from uavftc.report import panels  # noqa: PLC0415
        from uavftc.report.design_figure import design_figure  # noqa: PLC0415

        with panels.style():
            return shown(design_figure(self.document))

    def __repr__(self) -> str:
        trim = self.document["trim"]
        at = f"{trim['airspeed_mps']:g} m/s, {trim['altitude_m']:g} m"
        return f"Design of {self.document['aircraft']} at {at}: {self.document['verdict']}"

    def _repr_html_(self) -> str:
        return picture(self.plot())


def _array(value: Any) -> Any:
    """Return a list of numbers, or of such lists, as an array; anything else as it is."""
    if not isinstance(value, list) or not value:
        return value
    try:
        return np.array(value, dtype=float)  # None becomes NaN
    except (TypeError, ValueError):
        return value
