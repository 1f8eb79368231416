"""Where the shipped aircraft and scenarios are.

An installed package carries them as `uavftc/data`; in a checkout they are the folders `aircraft/` and `scenarios/` at
the top, read where they stand.
"""

from __future__ import annotations

from pathlib import Path

_PACKAGE = Path(__file__).resolve().parents[1]
_CHECKOUT = _PACKAGE.parents[1]


def _folder(name: str) -> Path:
    installed = _PACKAGE / "data" / name
    return installed if installed.is_dir() else _CHECKOUT / name


def aircraft_dir() -> Path:
    """Return the folder of the shipped aircraft, one folder each."""
    return _folder("aircraft")


def scenario_dir() -> Path:
    """Return the folder of the shipped scenarios, one YAML file each."""
    return _folder("scenarios")


def aircraft_names() -> list[str]:
    """Return the names of the shipped aircraft, sorted."""
    folder = aircraft_dir()
    return sorted(p.name for p in folder.iterdir() if p.is_dir() and p.name[0] not in "._") if folder.is_dir() else []


GROUPS = ("beyond", "damage")
"""Folders of the shipped scenarios, which are part of the names in them."""


def scenario_names(group: str | None = None) -> list[str]:
    """Return the names of the shipped scenarios, sorted, without `.yaml`; of a group such as ``beyond/stuck``."""
    folder = scenario_dir() / (group or "")
    return sorted(f"{group}/{p.stem}" if group else p.stem for p in folder.glob("*.yaml"))
