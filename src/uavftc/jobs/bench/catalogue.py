"""All figures by name, with their bars, and the run over them."""

from __future__ import annotations

import os
import platform
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

from uavftc.jobs.bench import campaigns, growth, loop, parts, peers, processes, solvers
from uavftc.jobs.bench.measure import Bar, Figure, Figures, NotMeasuredError
from uavftc.results.summary import provenance

Progress = Callable[[int, int, str], None]
"""Called with the figures done, the figures in all, and the name of the one being measured."""

_AT_LEAST_50 = Bar(50.0, at_least=True)


class Entry(NamedTuple):
    """One figure, or several of one kind, of the benchmark."""

    measure: Callable[[int], Figures]
    """Given the number of rounds."""
    bar: Bar | dict[str, Bar] | None = None


CATALOGUE: dict[str, Entry] = {
    "closed_loop_over_bare_jsbsim": Entry(
        loop.closed_loop_over_bare_jsbsim, {"hale": Bar(1.45), "c172p": Bar(1.37), "737": Bar(1.4)}
    ),
    "controller_step_us": Entry(parts.controller_step_us, Bar(3.0)),
    "bridge_io_us": Entry(parts.bridge_io_us),
    "record_us": Entry(parts.record_us),
    "analytic_step_us": Entry(loop.analytic_step_us, Bar(6.0)),
    "analytic_flight_ms": Entry(loop.analytic_flight_ms, Bar(25.0)),
    "analytic_over_solve_ivp": Entry(solvers.analytic_over_solve_ivp, dict.fromkeys(solvers.SOLVERS, _AT_LEAST_50)),
    "flights_per_second": Entry(loop.flights_per_second),
    "margin_over_flight": Entry(loop.margin_over_flight, {"analytic": Bar(1.05), "jsbsim": Bar(1.05)}),
    "campaign_case_over_loop": Entry(campaigns.campaign_case_over_loop, {"analytic": Bar(2.0), "jsbsim": Bar(1.3)}),
    "process_warm_s": Entry(processes.process_warm_s),
    "warm_over_imports": Entry(processes.warm_over_imports, Bar(1.7)),
    "process_cold_s": Entry(processes.process_cold_s, Bar(12.0)),
    "process_first_s": Entry(processes.process_first_s),
    "time_growth": Entry(growth.time_growth, {"analytic": Bar(1.05), "jsbsim": Bar(1.05)}),
    "memory_growth_mb": Entry(processes.memory_growth_mb, Bar(500.0)),
    "campaign_memory_growth_mb": Entry(campaigns.campaign_memory_growth_mb, Bar(50.0)),
    "peers": Entry(peers.peers),
}
"""In the order in which they are measured and shown."""


def run(names: Sequence[str], rounds: int, advance: Progress) -> dict[str, Any]:
    """Measure the figures named, and return the document of `uavftc bench --json`."""
    document: dict[str, Any] = {}
    where = machine()  # now: the benchmark itself is a load
    for done, name in enumerate(names):
        advance(done, len(names), name)
        document[name] = measured(CATALOGUE[name], rounds)
    advance(len(names), len(names), "")
    return {**document, "rounds": rounds, "machine": where}


def measured(entry: Entry, rounds: int) -> dict[str, Any]:
    """Return the figures of an entry as the document has them."""
    try:
        found = entry.measure(rounds)
    except NotMeasuredError as reason:
        found = Figure([], reason=str(reason))
    bar = entry.bar
    if isinstance(found, Figure):
        return found.document(None if isinstance(bar, dict) else bar)
    return {name: figure.document(bar.get(name) if isinstance(bar, dict) else bar) for name, figure in found.items()}


def machine() -> dict[str, Any]:
    """Return what the figures were measured on."""
    versions = provenance(seed=None, scenario_sha256="", aircraft_sha256=None)
    load = os.getloadavg()[0] if hasattr(os, "getloadavg") else None
    return {
        **{name: versions[name] for name in ("uavftc", "jsbsim", "numpy", "numba", "python")},
        "system": f"{platform.system()} {platform.machine()}",
        "cores": os.cpu_count(),
        "load_average": load,
    }
