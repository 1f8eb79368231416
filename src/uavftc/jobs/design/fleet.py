"""The aircraft at hand, ours and JSBSim's: does each trim, and can the controller fly it?

Each is measured in a child process (`plants/jsbsim/model.py`), several at a time, and its row is kept in the user's
cache under the checksum of its files and of the code that judged it.
"""

from __future__ import annotations

import contextlib
import functools
import hashlib
import json
import os
import threading
from collections.abc import Callable, Sequence
from concurrent.futures import FIRST_COMPLETED, ThreadPoolExecutor, wait
from pathlib import Path
from typing import Any

import numpy as np

from uavftc.aircraft.definition import STOCK, load_aircraft, stock_names
from uavftc.analysis import authority
from uavftc.config import shipped as resources
from uavftc.core.cache import cache_folder
from uavftc.core.signals import AXES, SURFACES
from uavftc.errors import InputError
from uavftc.flight import condition
from uavftc.jobs.design import trimmed
from uavftc.jobs.design.document import DEFAULT_SCENARIO
from uavftc.plants.jsbsim.model import cache_dir
from uavftc.plants.jsbsim.span import span
from uavftc.scenario import controllers
from uavftc.scenario.load import load_scenario

Row = dict[str, Any]
Progress = Callable[[int], None]


def names() -> list[str]:
    """Return the names of all aircraft at hand, as `load_aircraft` takes them."""
    return [*resources.aircraft_names(), *(f"{STOCK}{name}" for name in stock_names())]


def fleet(
    names: Sequence[str],
    *,
    quick: bool = False,
    workers: int | None = None,
    progress: Progress | None = None,
) -> list[Row]:
    """Return one row an aircraft, in their order.

    Parameters
    ----------
    names
        Names as `load_aircraft` takes them.
    quick
        Measure nothing: what is not in the cache has `measured` false, and nothing else.
    workers
        Aircraft measured at a time; by default as many as cores.
    progress
        Called with the number of rows known, now and then.
    """
    rows = {name: cached(name) for name in names}
    missing = [name for name, row in rows.items() if row is None]
    if not quick and missing:
        with ThreadPoolExecutor(workers or os.cpu_count() or 1) as pool:
            stopped = threading.Event()
            pending = {pool.submit(_uninterrupted, name, stopped): name for name in missing}
            try:
                while pending:
                    done, _ = wait(pending, timeout=0.5, return_when=FIRST_COMPLETED)
                    for future in done:
                        name = pending.pop(future)
                        rows[name] = row = future.result()
                        _keep(name, row)
                    if progress is not None:
                        progress(len(rows) - len(pending))
            except BaseException:
                stopped.set()
                pool.shutdown(wait=False, cancel_futures=True)
                raise
    return [rows[name] or _row(name, measured=False) for name in names]


def _uninterrupted(name: str, stopped: threading.Event) -> Row:
    """Return `row_of`, unless Ctrl-C has ended its child: nothing more is begun then."""
    if not stopped.is_set():
        row = row_of(name)
        if "(SIGINT)" not in (row["reason"] or ""):
            return row
        stopped.set()
    raise KeyboardInterrupt


def row_of(name: str) -> Row:
    """Return the row of one aircraft, measured: what `fleet` keeps."""
    try:
        aircraft = load_aircraft(name)
        scenario = load_scenario(DEFAULT_SCENARIO, aircraft=name)
        model = trimmed.design_model(scenario, aircraft)
    except InputError as error:
        return _row(name, measured=True, reason=error.found)
    reasons = condition.reasons_against(scenario, model)
    section = trimmed.authority_section(scenario, model)
    ratios = {axis: section[axis]["ratio"] for axis in AXES if section[axis] is not None}
    weakest = min(ratios, key=lambda axis: ratios[axis]) if ratios else None
    return _row(
        name,
        measured=True,
        mass_kg=model.mass_kg,
        span_m=span(aircraft),
        engines=model.engines,
        trims=True,
        method=model.trim["method"],
        airspeed_mps=model.trim["airspeed"],
        altitude_m=model.trim["altitude"],
        flyable=not reasons,
        weakest_axis=weakest,
        ratio=float(ratios[weakest]) if weakest and np.isfinite(ratios[weakest]) else None,
        reason="; ".join(reasons) or None,
        without=[name for name, own in zip(SURFACES, trimmed.held_axes(model), strict=True) if not own],
    )


def _row(name: str, *, measured: bool, **known: Any) -> Row:
    row: Row = {
        "aircraft": name, "measured": measured, "mass_kg": None, "span_m": None, "engines": None,
        "trims": False if measured else None, "method": None, "airspeed_mps": None, "altitude_m": None,
        "flyable": False if measured else None, "weakest_axis": None, "ratio": None, "reason": None, "without": [],
    }  # fmt: skip
    return row | known


# --- the cache -------------------------------------------------------------------------------------------------------


def cached(name: str) -> Row | None:
    """Return the row of an aircraft from the cache, None where there is none."""
    with contextlib.suppress(OSError, ValueError, InputError):
        row = json.loads(_file(name).read_text(encoding="utf-8"))
        if isinstance(row, dict) and row.keys() == _row(name, measured=True).keys():
            return row
    return None


def remember(name: str) -> None:
    """Put the row of an aircraft that was just designed into the cache, if it is one of the list and not there yet."""
    if name in names() and cached(name) is None:
        _keep(name, row_of(name))


def _keep(name: str, row: Row) -> None:
    if row["reason"] and "does not finish" in row["reason"]:  # the machine may have been busy
        return
    with contextlib.suppress(OSError, InputError):
        file = _file(name)
        partial = file.with_suffix(f".{os.getpid()}")
        partial.write_text(json.dumps(row), encoding="utf-8")
        partial.replace(file)


def _file(name: str) -> Path:
    return cache_folder("fleet", _code()) / f"{load_aircraft(name).sha256()[:32]}.json"


@functools.cache
def _code() -> str:
    """Return the checksum of what a row depends on next to the aircraft."""
    digest = hashlib.sha256(cache_dir().name.encode())
    for module in (__file__, trimmed.__file__, condition.__file__, authority.__file__, controllers.__file__):
        digest.update(Path(module).read_bytes())
    digest.update((resources.scenario_dir() / f"{DEFAULT_SCENARIO}.yaml").read_bytes())
    return digest.hexdigest()[:16]
