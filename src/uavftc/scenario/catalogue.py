"""What is shipped: scenarios and campaigns, by the names that commands take."""

from __future__ import annotations

from typing import NamedTuple

from uavftc.config import shipped
from uavftc.scenario.campaign import FOLDER
from uavftc.scenario.load import read_document

SCENARIO, CAMPAIGN = "scenario", "campaign"


class Entry(NamedTuple):
    """A shipped file."""

    name: str
    """As commands take it."""
    kind: str
    """`scenario` or `campaign`."""
    file: str
    description: str


def catalogue() -> list[Entry]:
    """Return all of them: the paper's scenarios first, then those of each group, then campaigns."""
    folder = shipped.scenario_dir()
    names = [*shipped.scenario_names(), *(name for group in shipped.GROUPS for name in shipped.scenario_names(group))]
    found = [(name, SCENARIO, folder / f"{name}.yaml") for name in names]
    found += [(file.stem, CAMPAIGN, file) for file in sorted((folder / FOLDER).glob("*.yaml"))]
    entries = []
    for name, kind, file in found:
        text = str(read_document(file, kind).data.get("description") or "")
        entries.append(Entry(name, kind, str(file), " ".join(text.split())))
    return entries
