"""A campaign as a value: its table of flights, how often each controller held, and the report on it."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from uavftc.api.history import to_pandas
from uavftc.api.tables import table
from uavftc.jobs.campaign.table import TABLE, content
from uavftc.results.loaded import read_document
from uavftc.scenario.campaign import find_campaign, load_campaign


class CampaignResult:
    """A campaign that was flown into a folder: from `uavftc.sweep`, or read by `uavftc.load`."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    @property
    def summary(self) -> dict[str, Any]:
        """The document of `summary.json`: how the flights ended, by controller."""
        return read_document(self.folder)

    @property
    def flights(self) -> Any:
        """The table, a row a flight, as a `pyarrow.Table` (docs/campaigns.md lists its columns)."""
        return content(self.folder)

    def to_pandas(self) -> Any:
        """Return the table as a `pandas.DataFrame`.

        Raises
        ------
        InputError
            If pandas is not installed.
        """
        return to_pandas(self.flights.to_pydict(), "CampaignResult.to_pandas")

    def report(self) -> dict[str, Any]:
        """Return what ``uavftc sweep-report --json`` prints: intervals, pairs, sensitivity, the worst cases.

        Raises
        ------
        InputError
            If the folder holds no table.
        """
        from uavftc.jobs.sweep_report.job import sweep_report  # noqa: PLC0415 - what most campaigns do not need

        return sweep_report(self.folder)[1]

    def __repr__(self) -> str:
        document = self.summary
        return f"{document['campaign']}: {document['flights']} flights in {self.folder / TABLE}"

    def _repr_html_(self) -> str:
        rows = self.flights.group_by("controller").aggregate([("success", "mean"), ("margin", "min")]).to_pylist()
        cells = [(row["controller"], row["success_mean"], row["margin_min"]) for row in rows]
        return table(["controller", "success", "lowest margin"], cells, repr(self))


def sweep(
    campaign: str | os.PathLike[str],
    *,
    set: Mapping[str, Any] | None = None,
    workers: int | None = None,
    cluster: str | None = None,
    until_width: float | None = None,
    resume: bool = False,
    out: str | os.PathLike[str] | None = None,
) -> CampaignResult:
    """Fly a campaign into a folder and return its result.

    A script calls it below ``if __name__ == "__main__":``, because worker processes read the script, too.

    Parameters
    ----------
    campaign
        The file of a campaign, or the name of a shipped one.
    set
        Values by dotted key of the campaign: ``{"cases": 60}``.
    workers
        Processes; None is as many as cores. The table does not depend on it.
    cluster
        Address of a Dask scheduler that flies instead.
    until_width
        Width of every interval of success with which it ends before all cases are flown.
    resume
        Go on with what a campaign that was interrupted left.
    out
        The folder; None is ``results/sweep-NAME``.

    Raises
    ------
    InputError
        If anything is wrong with the campaign or the folder; nothing is written then.
    KeyboardInterrupt
        On Ctrl-C; what was finished is kept, and `resume` goes on.
    """
    from uavftc.jobs.campaign.sweep import Sweep, ready  # noqa: PLC0415 - which knows the version of this package

    made = ready(load_campaign(os.fspath(campaign), set=set))
    folder = Path("results") / f"sweep-{made.campaign.name}" if out is None else Path(out)
    inputs = (find_campaign(os.fspath(campaign)), made.campaign.base_file)
    Sweep(made, folder, resume=resume, inputs=inputs, until_width=until_width).fly(workers=workers, cluster=cluster)
    return CampaignResult(folder)
