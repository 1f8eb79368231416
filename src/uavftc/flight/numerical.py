"""Whether a flight ended for its numbers rather than for its vehicle: the outcome `numerical`.

Two things say so. The step check of the trim passes at no step, and the scenario gives none of its own; then nothing
is flown. Or the vehicle was lost at plant steps of h, and the deflections, wind and disturbing moments of its rows,
flown again from the same start, lose it at h but neither at h/2 nor at h/4.

A replay counts as lost once it has gone `NEAR` of the way from the trim to a limit of the envelope, by the time that
the flight was lost: a vehicle that is really lost crosses a limit a little earlier or later at another step, and is
near it all the same. The airspeed hold acts in a replay as it does in flight. A flight into the ground is not replayed.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from uavftc.core.program import Program
from uavftc.core.signals import as_records, empty_rows
from uavftc.flight import envelope
from uavftc.flight.build import Flight, make_plant
from uavftc.plants.interface import Timing
from uavftc.plants.jsbsim.model import missed_by

MAX_ROWS = 200_000  # recorded for a replay, about 0.1 kB each
MAX_PLANT_STEPS = 2_000_000  # of the finest replay; half a minute
NEAR = 0.9
FINER = (2, 4)
SLICE_ROWS = 256  # rows replayed between two calls of `stop`


def unsound(flight: Flight) -> str | None:
    """Return why no step is fine enough for the aircraft at its trim, or None."""
    model, scenario = flight.model, flight.scenario
    if scenario.plant != "jsbsim" or scenario.simulation.substeps is not None or model is None:
        return None
    if model.step.get("passed", True):
        return None
    return (
        f"numerical: the step check passes at no plant step down to {model.frame_s * 1e3:g} ms "
        f"({missed_by(model.step)}); set simulation.substeps to fly it all the same"
    )


class Tape:
    """The commands of a flight, as far as a replay needs them; a recorder."""

    def __init__(self, flight: Flight) -> None:
        self._kept = flight.scenario.plant == "jsbsim"
        self._chunks: list[dict[str, np.ndarray]] = []
        self.rows = 0

    def take(self, records: np.ndarray) -> None:
        """Keep what was commanded in the next rows, while there are at most `MAX_ROWS`."""
        self.rows += len(records)
        if self.rows > MAX_ROWS:
            self._chunks.clear()
        elif self._kept:
            kept = {name: records[name].copy() for name in ("t", "d2", "wind_n")}
            self._chunks.append({**kept, "deflection": records["effectors"]["deflection"].copy()})

    def __getitem__(self, name: str) -> np.ndarray:
        """Return a field of all rows: t, d2, wind_n or deflection."""
        return np.concatenate([chunk[name] for chunk in self._chunks])


def verdict(
    flight: Flight, tape: Tape, lost: np.void, reason: str, stop: Callable[[], bool] | None
) -> tuple[bool, str, tuple[str, ...]]:
    """Return whether a lost flight is numerical, why it ended in words, and remarks.

    Parameters
    ----------
    flight, tape
        The flight and its commands, all rows before the lost one at least.
    lost
        The row at which it was lost, of dtype `signals.ROW` or longer.
    reason
        Why, in words.
    stop
        Asked now and then; if it returns true, nothing more is found out.
    """
    steps = round(flight.given.h / flight.given.plant_step)
    rows = round(float(lost["t"]) / flight.given.h)
    if flight.scenario.plant != "jsbsim" or not 0.0 < lost["status"] < envelope.GROUND or rows < 1:
        return False, reason, ()
    if tape.rows > MAX_ROWS or rows * steps * FINER[-1] > MAX_PLANT_STEPS:
        return False, reason, (f"too long to be flown again at finer steps ({rows} rows): it may be numerical",)
    if any(replay(flight, tape, rows, n, stop) is not False for n in FINER) or not replay(flight, tape, rows, 1, stop):
        return False, reason, ()
    h, *finer = (f"{flight.given.plant_step / n * 1e3:.4g} ms" for n in (1, *FINER))
    said = f"numerical: lost at plant steps of {h} ({reason}), and not at {' and '.join(finer)} with the same commands"
    allowed = math.ceil(flight.given.h / flight.model.frame_s - 1e-9) if flight.model is not None else 1
    return True, f"{said}; set simulation.substeps to {max(FINER[0] * steps, allowed)} or more", ()


def replay(flight: Flight, tape: Tape, rows: int, finer: int, stop: Callable[[], bool] | None) -> bool | None:
    """Return whether the recorded commands lose the vehicle by the row `rows`; None if `stop` ended the replay.

    finer: how many times as many plant steps are taken as in the flight.
    """
    timing = Timing(flight.given.h, finer * round(flight.given.h / flight.given.plant_step))
    plant: Any = make_plant(flight.scenario, flight.aircraft, flight.model, timing, flight.inputs, flight.layout)
    watch = envelope.stage.block(nearer(flight))
    program = Program([*plant.before(), watch, *plant.given()], plant.after(), substeps=plant.program_substeps)
    recorded = {name: tape[name][:rows] for name in ("t", "d2", "wind_n", "deflection")}
    for first in range(0, rows + 1, SLICE_ROWS):
        if stop is not None and stop():
            return None
        n = min(SLICE_ROWS, rows + 1 - first)
        given = empty_rows(n, flight.shape)
        records = as_records(given, flight.shape)
        for name in ("t", "d2", "wind_n"):
            part = recorded[name][first : first + n]
            records[name][: len(part)] = part
        part = recorded["deflection"][first : first + n]
        records["effectors"]["deflection"][: len(part)] = part
        if plant.run(program, given, 0, n) < n:
            return True
    return False


def nearer(flight: Flight) -> np.ndarray:
    """Return the envelope with each limit moved towards the trim, one record of `envelope.PARAMS`."""
    assert flight.model is not None  # every JSBSim aircraft is flown from a trimmed model
    trim = flight.model.trim
    limits = flight.envelope.copy()
    for name in ("bank_max", "pitch_max"):
        limits[name] *= NEAR
    for name in ("airspeed_min", "airspeed_max"):
        limits[name] = trim["airspeed"] + NEAR * (limits[name] - trim["airspeed"])
    return limits
