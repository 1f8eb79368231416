"""The kinds of result folder: which files each may hold, and whether a folder on disk is one of them."""

from __future__ import annotations

import json
import os
import re
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple, get_args

from uavftc.scenario.overrides import CONTROLLERS
from uavftc.scenario.schema import Scenario

PLANTS: tuple[str, ...] = get_args(Scenario.model_fields["plant"].annotation)


class Kind(NamedTuple):
    """A kind of result folder."""

    name: str
    files: frozenset[str]
    """Every file it may hold, as a path inside it; `summary.json` is one of them."""

    @property
    def folders(self) -> frozenset[str]:
        """Every folder it may hold."""
        return frozenset(name.rpartition("/")[0] for name in self.files if "/" in name)


FLIGHT = Kind(
    "flight",
    frozenset(
        ["summary.json", "history.parquet", "scenario.yaml", "report.html"]
        + [f"figures/{name}.png" for name in ("tracking", "control", "estimates", "air")]
    ),
)
COMPARISON = Kind(
    "comparison",
    frozenset(
        ["summary.json", "scenario.yaml", "comparison.md", "comparison.csv"]
        + [f"figures/{name}.png" for name in ("tracking", "commands", "difference")]
        + [f"histories/{plant}-{controller}.parquet" for plant in PLANTS for controller in CONTROLLERS]
    ),
)
REPRODUCTION = Kind(
    "reproduction",
    frozenset(
        ["summary.json", "reproduction.md", "reproduce.json", "tables.csv", "improvements.csv"]
        + [
            f"figures/{plant}-figure-{n:02d}.{kind}"
            for plant in PLANTS
            for n in range(2, 12)
            for kind in ("png", "pdf")
        ]
    ),
)
KINDS = (FLIGHT, COMPARISON, REPRODUCTION)


def kind_of(folder: Path) -> Kind:
    """Return the kind that most files of `folder` belong to; whether all do, `foreign_entry` tells."""
    return max(KINDS, key=lambda kind: sum(os.path.lexists(folder / name) for name in kind.files))


def files_of(folder: Path, kind: Kind) -> frozenset[str]:
    """Return every file that this folder may hold: a comparison may have the histories of its own controllers too.

    Their names stand in its summary; only such as `controller_name` gives count.
    """
    if kind is not COMPARISON or not is_ours(folder):
        return kind.files
    named = json.loads((folder / "summary.json").read_text(encoding="utf-8")).get("controllers")
    names = named if isinstance(named, list) else []
    own = [name for name in names if isinstance(name, str) and re.fullmatch(r"[A-Za-z0-9][A-Za-z0-9_-]{0,103}", name)]
    return kind.files | {f"histories/{plant}-{name}.parquet" for plant in PLANTS for name in own}


def foreign_entry(folder: Path, kind: Kind) -> str | None:
    """Return the path inside `folder` of something that is not of this kind, or None; a symbolic link never is."""
    files_of_kind, folders_of_kind = files_of(folder, kind), kind.folders
    for root, folders, files in os.walk(folder):
        inside = os.path.relpath(root, folder)
        for name in sorted([*folders, *files]):
            path = name if inside == "." else f"{inside}/{name}".replace(os.sep, "/")
            known = path in (folders_of_kind if name in folders else files_of_kind)
            if not known or os.path.islink(os.path.join(root, name)):
                return path
    return None


def is_ours(folder: Path) -> bool:
    """Tell whether `folder` holds a summary.json written by uavftc."""
    try:
        provenance = json.loads((folder / "summary.json").read_text(encoding="utf-8"))["provenance"]
        return isinstance(provenance, dict) and "uavftc" in provenance
    except (OSError, ValueError, KeyError, TypeError):
        return False


def remove_ours(folder: Path, kind: Kind) -> None:
    """Remove the files of this kind and then the folders, which stay if anything else is in them."""
    for name in files_of(folder, kind):
        with suppress(OSError):
            (folder / name).unlink()
    for name in [*sorted(kind.folders, reverse=True), ""]:
        with suppress(OSError):
            (folder / name).rmdir()
