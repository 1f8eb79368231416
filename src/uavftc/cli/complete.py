"""What a shell offers after Tab: scenarios, campaigns, aircraft, controllers, keys of the scenario at hand."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from typing import Any

import typer

Offer = Callable[[typer.Context, str], list[str]]


def _beginning(names: list[str], incomplete: str) -> list[str]:
    return [name for name in names if name.startswith(incomplete)]


def scenario(ctx: typer.Context, incomplete: str) -> list[str]:
    """Offer the shipped scenarios; the shell offers files by itself."""
    from uavftc.config import shipped  # noqa: PLC0415

    grouped = [name for group in shipped.GROUPS for name in shipped.scenario_names(group)]
    return _beginning([*shipped.scenario_names(), *grouped], incomplete)


def campaign(ctx: typer.Context, incomplete: str) -> list[str]:
    """Offer the shipped campaigns."""
    from uavftc.config import shipped  # noqa: PLC0415

    return _beginning(sorted(p.stem for p in (shipped.scenario_dir() / "campaigns").glob("*.yaml")), incomplete)


def aircraft(ctx: typer.Context, incomplete: str) -> list[str]:
    """Offer the shipped aircraft and JSBSim's."""
    from uavftc.aircraft.definition import stock_names  # noqa: PLC0415
    from uavftc.config import shipped  # noqa: PLC0415

    return _beginning([*shipped.aircraft_names(), *(f"jsbsim:{name}" for name in stock_names())], incomplete)


def controller(ctx: typer.Context, incomplete: str) -> list[str]:
    """Offer the controllers that have a name."""
    return _beginning(_controllers(), incomplete)


def controllers(ctx: typer.Context, incomplete: str) -> list[str]:
    """Offer the next controller of a list with commas."""
    before, comma, last = incomplete.rpartition(",")
    taken = before.split(",")
    return [f"{before}{comma}{name}" for name in _beginning(_controllers(), last) if name not in taken]


def _controllers() -> list[str]:
    from uavftc.control.custom.module import registered  # noqa: PLC0415
    from uavftc.scenario.controllers import CONTROLLERS  # noqa: PLC0415

    return [*CONTROLLERS, *registered()]


def plant(ctx: typer.Context, incomplete: str) -> list[str]:
    """Offer both plants."""
    return _beginning(["jsbsim", "analytic"], incomplete)


def key(ctx: typer.Context, incomplete: str) -> list[str]:
    """Offer the keys of the scenario that the command names, level by level."""
    from uavftc.errors import InputError  # noqa: PLC0415
    from uavftc.scenario.load import load_scenario  # noqa: PLC0415

    if "=" in incomplete:
        return []
    with suppress(InputError):
        loaded = load_scenario(ctx.params.get("scenario") or "scenario3")
        return _next_level(list(_keys(loaded.model_dump(), "")), incomplete)
    return []


def _next_level(keys: list[str], incomplete: str) -> list[str]:
    """Return the keys that begin so; where there are many, up to their next dot."""
    found = _beginning(keys, incomplete)
    if len(found) <= 12:
        return found
    cut = {key[: key.index(".", len(incomplete)) + 1] if "." in key[len(incomplete) :] else key for key in found}
    return sorted(cut)


def _keys(value: Any, path: str) -> Iterator[str]:
    """Yield the dotted key of each value, with = behind it."""
    if isinstance(value, Mapping):
        for name, item in value.items():
            yield from _keys(item, f"{path}.{name}" if path else str(name))
    elif isinstance(value, list | tuple) and any(isinstance(item, Mapping) for item in value):
        for i, item in enumerate(value):
            yield from _keys(item, f"{path}[{i}]")
    else:
        yield f"{path}="
