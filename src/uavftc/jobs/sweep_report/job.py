"""The job of `uavftc sweep-report`: a report in the campaign's folder, or in one of its own.

    report/summary.json     everything that is said, as `--json` prints it
    report/report.md        the same to read, with the figures
    report/figures/
    report/worst/           the worst flights of each variant as scenarios, which fly alone to the same margin

The report of a finished campaign stands in its folder, next to the table, and the campaign's `summary.json` lists it:
the folder is still known as ours as a whole, and a new campaign may replace it.
"""

from __future__ import annotations

from collections.abc import Collection
from pathlib import Path
from typing import Any

from uavftc.jobs.campaign.scenarios import command
from uavftc.jobs.sweep_report.document import document_of
from uavftc.jobs.sweep_report.read import Flown
from uavftc.report.campaign_page import FIGURES, page
from uavftc.results import manifest
from uavftc.results.folder import ResultFolder
from uavftc.results.hold import Hold
from uavftc.results.lock import Lock
from uavftc.results.summary import write_json
from uavftc.scenario.changed import changed
from uavftc.scenario.load import load_scenario
from uavftc.scenario.text import scenario_text

REPORT = "report"
PAGE = "report.md"
WORST = "worst"


def sweep_report(folder: Path, on_axes: str | None = None) -> tuple[Flown, dict[str, Any]]:
    """Return the flights of a campaign's folder and the document of its report; nothing is written.

    Raises
    ------
    InputError
        If there is no campaign, nothing was flown, or the keys of the map do not vary.
    """
    flown = Flown(folder)
    return flown, document_of(flown, on_axes)


def write_report(flown: Flown, document: dict[str, Any], out: Path | None, *, figures: bool = True) -> dict[str, Any]:
    """Write the report into a result folder, whole or not at all, and return what its `summary.json` holds.

    Parameters
    ----------
    out
        The folder; None for `report` in that of the campaign, which must be finished.

    Raises
    ------
    InputError
        If it cannot be written, or holds something that is not ours.
    """
    target = out if out is not None else flown.folder / REPORT
    with ResultFolder(target) as result:
        drawn: list[str] = []
        if figures:
            missing = result.figures(lambda folder: drawn.extend(draw(folder, flown, document)))
            if missing is not None:
                document["figures_missing"] = missing
                drawn = []
        _write_worst(result.path, target if out is None else out, flown, document)
        text = page(document, [f"figures/{name}" for name in drawn])
        (result.path / PAGE).write_text(text, encoding="utf-8", newline="\n")
        written = result.write_summary(document)
    if out is None:
        _list_report(flown.folder)
    return written


def _write_worst(folder: Path, shown: Path, flown: Flown, document: dict[str, Any]) -> None:
    """Write the worst flights as scenarios, and let their commands fly these."""
    for one in [*document["worst"], *(one for worst in document["worst_of"].values() for one in worst)]:
        scenario = flown.scenario(flown.names.index(one["variant"]))
        if scenario is None:
            continue
        name = f"{one['case']:06d}-{one['variant']}.yaml"
        text = scenario_text(changed(load_scenario(scenario), one["values"]))
        (folder / WORST).mkdir(exist_ok=True)
        (folder / WORST / name).write_text(text, encoding="utf-8", newline="\n")
        one["command"] = command(shown / WORST / name, {})


def draw(folder: Path, flown: Flown, document: dict[str, Any], only: Collection[str] = tuple(FIGURES)) -> list[str]:
    """Draw the figures of these names into a new folder, as far as there are any, and return the files' names."""
    from uavftc.report.backend import load_matplotlib  # noqa: PLC0415 - matplotlib takes most of a second

    load_matplotlib()
    from uavftc.report.campaign_figures import Data, write_figures  # noqa: PLC0415

    keys = document["map"] or []
    inputs = {key: flown.input(key) for key in keys}
    kinds = {key: flown.campaign.vary[key].kind for key in keys}
    folder.mkdir()
    return write_figures(folder, document, Data(flown.numbers, inputs, kinds), only)


def _list_report(folder: Path) -> None:
    """List the files of the report in the campaign's summary, so that the folder is ours as a whole."""
    lock = Lock(folder)
    lock.take()
    try:
        summary = manifest.read_summary(folder)
        if summary is None:
            return
        inside = {f"{REPORT}/{name}": sha for name, sha in manifest.checksums(folder / REPORT).items()}
        inside[f"{REPORT}/{manifest.SUMMARY}"] = manifest.checksum(folder / REPORT / manifest.SUMMARY)
        others = {name: sha for name, sha in summary["files"].items() if not name.startswith(f"{REPORT}/")}
        summary["files"] = dict(sorted((others | inside).items()))
        summary[manifest.OWN_CHECKSUM] = manifest.own_checksum(summary)
        partial = folder / f".{manifest.SUMMARY}"
        with Hold():
            write_json(partial, summary)
            partial.replace(folder / manifest.SUMMARY)
    finally:
        lock.release()
