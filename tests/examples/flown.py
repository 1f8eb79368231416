"""Fly a scenario with a custom effect: all it takes is the line that puts it into its chain.

    python flown.py uavftc.actuators CHAIN soft_linkage effectiveness CONTROLLER FOLDER

puts the module `soft_linkage` before `effectiveness` (- is at the end), flies FOLDER/scenario.yaml and writes what
the tests look at to FOLDER. In a process of its own, because a chain is read once, when the schema is made of it.
"""

from __future__ import annotations

import importlib
import json
import sys
from pathlib import Path

import numpy as np


def main(package: str, chain: str, name: str, before: str, controller: str, folder: Path) -> None:
    home = importlib.import_module(package)
    effects = list(getattr(home, chain))
    names = [effect.__name__.rpartition(".")[2] for effect in effects]
    effects.insert(len(effects) if before == "-" else names.index(before), importlib.import_module(name))
    setattr(home, chain, tuple(effects))  # the one line

    from uavftc.errors import InputError
    from uavftc.flight.build import build_flight
    from uavftc.flight.fly import fly_to_memory
    from uavftc.scenario.load import controller_name, load_scenario, scenario_text, warnings
    from uavftc.scenario.schema import Scenario

    chosen = None if controller == "-" else controller
    scenario = load_scenario(folder / "scenario.yaml", controller=chosen)
    flight = build_flight(scenario)
    records, outcome = fly_to_memory(flight)
    text = scenario_text(flight.scenario)
    (folder / "as-flown.yaml").write_text(text, encoding="utf-8")
    refused = {}
    for file in sorted(folder.glob("wrong-*.yaml")):
        try:
            load_scenario(file)
        except InputError as error:
            refused[file.stem] = str(error)
    found = {
        "completed": outcome.completed,
        "because": outcome.ended_because,
        "blocks": flight.program.names,
        "controller": controller_name(flight.scenario),
        "text": text,
        "same": load_scenario(folder / "as-flown.yaml") == flight.scenario,
        "schema": Scenario.model_json_schema(),
        "refused": refused,
        "warnings": warnings(flight.scenario),
        "B": flight.given.design.B.tolist(),
        "plant_step": flight.given.plant_step,
    }
    np.save(folder / "records.npy", records)
    (folder / "found.json").write_text(json.dumps(found), encoding="utf-8")


if __name__ == "__main__":
    main(*sys.argv[1:6], Path(sys.argv[6]))
