"""Figures 2 to 11 of the paper, from our flights: the same panels, ready for print at 170 mm.

Angles in deg, body rates in deg/s, deflections in rad (the paper's limits are), estimates in deg/s and deg/s^2.
Importing this module imports matplotlib (0.7 s), so import it where figures are drawn.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

from uavftc.jobs.campaign.pool import Flown
from uavftc.jobs.paper.captions import CAPTIONS, HEADINGS
from uavftc.jobs.paper.drawing import Curve, Key, Panel, control, estimates, figure_2, tracking
from uavftc.jobs.paper.plan import L1, MRAC, NDI_L1
from uavftc.report import panels
from uavftc.report.palette import BLUE, DASHDOT, DASHED, GREEN, VERMILLION

__all__ = ["CAPTIONS", "PRINT", "draw", "figure_2", "write_figures"]

_NAMES = {L1: "NNDONDI-L1", NDI_L1: "NDI-L1", MRAC: "NNDONDI-MRAC"}
PRINT = {
    "figure.dpi": 200, "savefig.dpi": 200, "pdf.fonttype": 42, "font.family": "sans-serif", "font.size": 8,
    "axes.titlesize": 8, "axes.titlepad": 4, "axes.labelsize": 8, "xtick.labelsize": 7.5, "ytick.labelsize": 7.5,
    "legend.fontsize": 8, "lines.linewidth": 1.2, "axes.linewidth": 0.6, "grid.linewidth": 0.4,
    "xtick.major.width": 0.6, "ytick.major.width": 0.6, "xtick.major.size": 2.5, "ytick.major.size": 2.5,
}  # fmt: skip
"""Settings of matplotlib for print, over those of `report.panels`; fonts are embedded as TrueType."""

_BARE, _LIMITED = ("scenario1-unsaturated", L1), ("scenario1", L1)
_FLIGHTS = (_BARE, _LIMITED, *((scenario, name) for scenario in ("scenario2", "scenario3") for name in _NAMES))
_SCENARIO1 = (
    Panel(_BARE, False, "Outer loop, without saturation"),
    Panel(_LIMITED, False, "Outer loop, with saturation"),
    Panel(_BARE, True, "Inner loop, without saturation"),
    Panel(_LIMITED, True, "Inner loop, with saturation"),
)


def write_figures(folder: Path, flown: Mapping[Key, Flown], *, prefix: str = "") -> list[Path]:
    """Write `<prefix>figure-02` to `<prefix>figure-11`, each as .png (200 dpi) and .pdf; return their paths.

    Parameters
    ----------
    folder
        Where to write; made if it is missing (its parent must exist).
    flown
        (scenario, controller) to flight, with history, all on one plant: scenario1 and scenario1-unsaturated by
        nndondi-l1; scenario2 and scenario3 by nndondi-l1, ndi-l1 and nndondi-mrac.
    prefix
        Put before the file names.

    Raises
    ------
    KeyError
        If one of these flights is missing.
    """
    if missing := [key for key in _FLIGHTS if key not in flown]:
        raise KeyError(f"no flight of {', '.join(' by '.join(key) for key in missing)}")
    folder.mkdir(exist_ok=True)
    paths = []
    with panels.style(PRINT):
        for number in CAPTIONS:
            figure = draw(number, flown)
            figure.draw_without_rendering()  # laid out once, for both files
            figure.set_layout_engine("none")
            title = {"Title": f"Figure {number}. {HEADINGS[number]}"}
            for kind, more in (("png", {}), ("pdf", {"Subject": CAPTIONS[number], "CreationDate": None})):
                paths.append(folder / f"{prefix}figure-{number:02d}.{kind}")
                figure.savefig(paths[-1], metadata=title | more)
    return paths


def draw(number: int, flown: Mapping[Key, Flown]) -> Figure:
    """Return one figure, to be drawn and saved in this module's style."""
    if number == 2:
        return figure_2()
    if number == 3:
        saturation = [
            Curve(_BARE, "without saturation", {"color": BLUE, "linewidth": 2.2}),
            Curve(_LIMITED, "with saturation", {"color": VERMILLION, "linestyle": DASHED}),
        ]
        return tracking(3, flown, saturation)
    if number in (4, 5):
        return (control if number == 4 else estimates)(number, flown, _SCENARIO1)
    scenario = "scenario2" if number < 9 else "scenario3"
    if number in (6, 9):
        looks: tuple[dict[str, Any], ...] = (
            {"color": BLUE, "linewidth": 2.2},
            {"color": VERMILLION, "linestyle": DASHED},
            {"color": GREEN, "linestyle": DASHDOT, "linewidth": 1.0},
        )
        keys = [(scenario, name) for name in _NAMES]
        return tracking(
            number, flown, [Curve(key, _NAMES[key[1]], look) for key, look in zip(keys, looks, strict=True)]
        )
    two = tuple(
        Panel((scenario, name), inner, f"{'Inner' if inner else 'Outer'} loop, {_NAMES[name]}")
        for name in (L1, MRAC)
        for inner in (False, True)
    )
    return (control if number in (7, 10) else estimates)(number, flown, two)
