"""Render the tables of docs/scenarios.md and docs/custom-controller.md from the code: keys, chain, what a step is told.

    python tools/scenario_reference.py            # write them
    python tools/scenario_reference.py --check    # exit code 1 if a page is not what the code says

Each table stands between ``<!-- keys: NAME -->`` and ``<!-- end -->``; what is between them is written here.
"""

from __future__ import annotations

import argparse
import re
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from pydantic import BaseModel
from pydantic_core import PydanticUndefined

from uavftc import sensors
from uavftc.actuators import CHAIN
from uavftc.actuators.saturation import Limits
from uavftc.config.described import descriptions
from uavftc.config.effect import Effect, configs, default_kind
from uavftc.config.explain import unit_of
from uavftc.config.values import Signal
from uavftc.control.custom.known import parameters_of
from uavftc.control.custom.measured import MEASURED
from uavftc.control.custom.own_signals import UNITS
from uavftc.control.rbf import Rbf
from uavftc.environment import KINDS, gust_train, shear, turbulence
from uavftc.scenario import damage, requirements, schema, uncertainty
from uavftc.scenario.controllers import LOOPS, Controller, CustomController
from uavftc.sensors import dropout, stuck

DOCS = Path(__file__).parents[1] / "docs"
PAGES = [DOCS / "scenarios.md", DOCS / "custom-controller.md"]


def shown(value: Any) -> str:
    """Return a default as a scenario file would have it."""
    if value is PydanticUndefined:
        return "required"
    if isinstance(value, Signal):
        value = value.written
    if isinstance(value, bool) or value is None:
        return f"`{str(value).lower() if value is not None else 'null'}`"
    if isinstance(value, BaseModel):
        kind = getattr(value, "kind", None)
        return f"`kind: {kind}`" if isinstance(kind, str) else ""
    if isinstance(value, float):
        return f"`{value:g}`"
    if isinstance(value, tuple):
        return f"`[{', '.join(shown(item).strip('`') for item in value)}]`"
    return f"`{value}`" if value != "" else '`""`'


def default_of(field: Any) -> str:
    """Return the default of a field, from its factory where it has one."""
    return shown(field.get_default(call_default_factory=True))


def one_line(text: str | None) -> str:
    """Return a text on one line."""
    return " ".join((text or "").split())


def table(*models: type[BaseModel], kinds: bool = False, without: tuple[str, ...] = ()) -> list[str]:
    """Return the table of the keys of one section, or of the kinds of one, each key once."""
    rows: dict[str, list[str]] = {}
    having: dict[str, list[str]] = {}
    for model in models:
        meanings = descriptions(model)
        for name, field in model.model_fields.items():
            if name in without:
                continue
            having.setdefault(name, []).append(default_kind(model) if kinds else "")
            if name == "kind" and kinds:
                each = [f"`{default_kind(m)}`: {descriptions(m)['kind']}" for m in models]
                rows[name] = ["`kind`", "", "", "; ".join(each)]
            else:
                rows.setdefault(name, [f"`{name}`", unit_of(name), default_of(field), meanings[name]])
    head = ["key", "unit", "default", *(["kinds"] if kinds else []), "meaning"]
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    for name, row in sorted(rows.items(), key=lambda item: item[0] != "kind"):
        if kinds:
            all_of_them = len(having[name]) == len(models)
            row.insert(3, "all" if all_of_them else ", ".join(f"`{kind}`" for kind in having[name]))
        lines.append("| " + " | ".join(row).replace("|  |", "| |").replace("|  |", "| |") + " |")
    return lines


def by_kind(models: Sequence[type[BaseModel]]) -> list[str]:
    """Return the table of the kinds of an entry: the keys of all first, then each kind with those of its own."""
    common = set.intersection(*(set(model.model_fields) for model in models)) - {"kind"}
    rows = [
        ("all", name, unit_of(name), default_of(field), descriptions(models[0])[name])
        for name, field in models[0].model_fields.items()
        if name in common
    ]
    for model in models:
        meanings = descriptions(model)
        kind = f"`{default_kind(model)}`"
        rows.append((kind, "", "", "", meanings["kind"]))
        own = [name for name in model.model_fields if name not in common and name != "kind"]
        rows += [(kind, name, unit_of(name), default_of(model.model_fields[name]), meanings[name]) for name in own]
    lines = ["| kind | key | unit | default | meaning |", "|---|---|---|---|---|"]
    for kind, name, unit, default, meaning in rows:
        cells = [kind, f"`{name}`" if name else "", unit, default, meaning]
        lines.append(f"| {' | '.join(cells)} |".replace("|  |", "| |").replace("|  |", "| |"))
    return lines


def chain() -> list[str]:
    """Return the effects on an effector in their order, each with the first sentence of its module."""
    command = "1. command: the controller's output v2 mapped to the effector, a deflection about trim, rad;"
    return [command, *in_order(CHAIN, 2)]


def in_order(effects: Sequence[Effect], start: int = 1) -> list[str]:
    """Return a numbered list of effects in their order, each with the first sentence of its module."""
    lines = []
    for i, effect in enumerate(effects, start=start):
        name = effect.__name__.rpartition(".")[2].replace("_", " ")
        first = one_line((effect.__doc__ or "").split("\n\n")[0]).rstrip(".")
        lines.append(f"{i}. {name}: {first[0].lower()}{first[1:]}{'.' if effect is effects[-1] else ';'}")
    return lines


def disturbances() -> list[str]:
    """Return the table of the kinds of disturbance."""
    lines = ["| kind | keys | unit | plant | meaning |", "|---|---|---|---|---|"]
    for effect in KINDS:
        config = effect.Config
        keys = [name for name in config.model_fields if name not in ("kind", "end_s") and config.model_fields[name]]
        keys = [name for name in keys if name != "start_s" or "end_s" not in config.model_fields]
        units = ", ".join(dict.fromkeys(unit_of(name) for name in keys if unit_of(name)))
        refused = set(getattr(effect, "REFUSED_ON", {}))
        plants = "" if not keys else ", ".join(f"`{p}`" for p in ("jsbsim", "analytic") if p not in refused)
        names = ", ".join(f"`{name}`" for name in keys)
        row = [f"`{default_kind(config)}`", names, units, plants, one_line(config.__doc__)]
        lines.append("| " + " | ".join(row) + " |")
    return lines


def measured() -> list[str]:
    """Return the table of what a step in plain Python may ask for."""
    lines = ["| argument | shape | unit | plant | meaning |", "|---|---|---|---|---|"]
    for name, quantity in MEASURED.items():
        plant = "`jsbsim`" if quantity.field else ""
        cells = [f"`{name}`", quantity.shape, quantity.unit, plant, quantity.meaning]
        lines.append(f"| {' | '.join(cells)} |".replace("|  |", "| |").replace("|  |", "| |"))
    return lines


def known_faults() -> list[str]:
    """Return the table of the fields that the record of a known fault has of its kind."""
    lines = ["| kind | on | field | unit | meaning |", "|---|---|---|---|---|"]
    for config in schema.FAULTS:
        meanings = descriptions(config)
        on = "engine" if "engine" in config.model_fields else "surface"
        for key, field in parameters_of(config).items() or [("", "")]:
            meaning = re.sub(r"^signal[,:] ", "", meanings[key]) if key else meanings["kind"]
            meaning = re.sub(r"_deg(p?s?2?)`", r"_rad\1`", meaning).replace("`null`", "`None`")
            cells = [f"`{default_kind(config)}`", on, f"`{field}`" if field else "", unit_of(field), meaning]
            lines.append(f"| {' | '.join(cells)} |".replace("|  |", "| |").replace("|  |", "| |"))
    return lines


def units() -> list[str]:
    """Return the units of a controller's own signals and how their columns end."""
    return ["; ".join(f"{unit} `{ending}`" if ending else f"{unit} (none)" for unit, ending in UNITS.items()) + "."]


TABLES: dict[str, Callable[[], list[str]]] = {
    "scenario": lambda: table(schema.Scenario),
    "initial": lambda: table(schema.Initial),
    "reference": lambda: table(schema.Reference),
    "controller": lambda: table(Controller),
    "custom controller": lambda: table(CustomController),
    "outer": lambda: table(*(law.Config for law in LOOPS["outer"].KINDS), kinds=True),
    "inner": lambda: table(*(law.Config for law in LOOPS["inner"].KINDS), kinds=True),
    "rbf": lambda: table(Rbf),
    "limits": lambda: table(Limits),
    "actuators": lambda: table(schema.Actuator),
    "faults": lambda: by_kind([kind for kind in schema.FAULTS if "engine" not in kind.model_fields]),
    "engine faults": lambda: by_kind([kind for kind in schema.FAULTS if "engine" in kind.model_fields]),
    "chain": chain,
    "requirements": lambda: table(requirements.Requirement),
    "damage": lambda: table(damage.Damage),
    "inertia": lambda: table(damage.Inertia),
    "lift lost": lambda: table(damage.LiftLost),
    "uncertainty": lambda: table(uncertainty.Uncertainty),
    "disturbances": disturbances,
    "air": lambda: by_kind([kind.Config for kind in (shear, gust_train, turbulence)]),
    "order of sensors": lambda: in_order(sensors.CHAIN),
    "dropout": lambda: table(dropout.Dropout),
    "stuck": lambda: table(stuck.StuckAttitude),
    "sensors": lambda: table(*configs(sensors.CHAIN, "KEYS_IN", "sensors")),
    "envelope": lambda: table(schema.Envelope),
    "measured": measured,
    "known faults": known_faults,
    "units of signals": units,
    "simulation": lambda: table(schema.Simulation),
}


def rendered(page: str) -> str:
    """Return the page with every table written anew.

    Raises
    ------
    KeyError
        If the page names a table that does not exist.
    """
    pattern = re.compile(r"<!-- keys: ([\w ]+) -->\n.*?<!-- end -->", re.DOTALL)
    return pattern.sub(
        lambda found: "\n".join([f"<!-- keys: {found[1]} -->", *TABLES[found[1]](), "<!-- end -->"]), page
    )


def main() -> None:
    """Write the pages, or check them."""
    parser = argparse.ArgumentParser(description="Render the tables of two pages in docs from the code.")
    parser.add_argument("--check", action="store_true", help="write nothing; exit code 1 if a page is out of date")
    arguments = parser.parse_args()
    pages = {path: path.read_text(encoding="utf-8") for path in PAGES}
    missing = [name for name in TABLES if not any(f"<!-- keys: {name} -->" in page for page in pages.values())]
    for path, page in pages.items():
        new = rendered(page)
        if arguments.check and (new != page or missing):
            print(f"{path.name} is out of date{f', without {missing}' if missing else ''}: run {Path(__file__).name}")
            sys.exit(1)
        if not arguments.check:
            path.write_text(new, encoding="utf-8", newline="\n")


if __name__ == "__main__":
    main()
