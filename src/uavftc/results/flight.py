"""What is kept of a flight, and what is written and drawn of it: the same for a single flight and for one of many."""

from __future__ import annotations

import hashlib
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from uavftc.actuators.saturation import axis_limits, effector_limits
from uavftc.analysis.metrics import controlled_of
from uavftc.analysis.requirements import Met
from uavftc.analysis.verdict import Verdict, verdict_of
from uavftc.control.custom.module import checksum
from uavftc.core.axes import left_to_the_airframe
from uavftc.core.layout import Layout
from uavftc.core.signals import SURFACES
from uavftc.flight import named, requirements, servos, uncertain
from uavftc.flight.build import Flight
from uavftc.flight.fly import CHUNK_ROWS, Outcome
from uavftc.plants.jsbsim.model import notes
from uavftc.results.context import FigureContext
from uavftc.results.history import write_history
from uavftc.results.summary import ending_of, provenance, summary, title_of
from uavftc.results.windows import windows_of
from uavftc.scenario.controllers import CustomController
from uavftc.scenario.load import controller_name, scenario_text, warnings
from uavftc.scenario.schema import Scenario


class FlightResult(NamedTuple):
    """A flight that is over; it can be sent from one process to another."""

    scenario: Scenario
    """As flown."""
    outcome: Outcome
    axes: dict[str, dict[str, float | None]]
    """The metrics, as in `summary.json`."""
    history: dict[str, np.ndarray] | None
    """Published columns, shape (N + 1,) each; None where they are not kept, or on disk."""
    origin: dict[str, Any]
    """Its provenance, from `origin_of`."""
    remarks: tuple[str, ...] = ()
    """What the flight itself is worth a warning for, one line each; next to those of its scenario."""
    layout: Layout = Layout()
    """The effectors of the aircraft."""
    met: tuple[Met, ...] = ()
    """How each requirement fared."""

    @property
    def verdict(self) -> Verdict | None:
        """What came of it; None where the user ended it."""
        if self.outcome.interrupted:
            return None
        return verdict_of(
            self.met,
            completed=self.outcome.completed,
            ended_at_s=self.outcome.ended_at_s,
            duration_s=self.scenario.duration_s,
            numerical=self.outcome.numerical,
        )

    @property
    def settings(self) -> dict[str, Any]:
        """How the plant was integrated and started."""
        settings: dict[str, Any] = self.origin["plant_settings"]
        return settings

    def summary(self) -> dict[str, Any]:
        """Return the document of `summary.json`."""
        scenario, outcome = self.scenario, self.outcome
        steps = max(outcome.rows - 1, 0)
        return summary(
            scenario=scenario.name,
            aircraft=scenario.aircraft,
            plant=scenario.plant,
            controller=controller_name(scenario),
            completed=outcome.completed,
            ended_because=outcome.ended_because,
            ended_at_s=outcome.ended_at_s,
            numerical=outcome.numerical,
            verdict=None if self.verdict is None else self.verdict.document(),
            axes=self.axes,
            timing={
                "flight_wall_s": outcome.wall_s,
                "controller_steps": steps,
                "us_per_controller_step": 1e6 * outcome.wall_s / max(steps, 1),
            },
            provenance=self.origin,
            warnings=[*warnings(scenario), *self.remarks, *outcome.remarks],
        )

    def figure_context(self) -> FigureContext:
        """Return what the figures of this flight show next to its history."""
        outcome = self.outcome
        document = self.summary()
        title = title_of(document)
        if not outcome.completed:
            title += f"\nLOST: {outcome.ended_because}" if outcome.ended_because else "\nLOST"
        return FigureContext(
            title=title,
            ending=ending_of(document),
            limits_rad=self._limits(),
            effectors={surface: tuple(members) for surface, members in self.layout.gangs.items()},
            windows=windows_of(self.scenario, self.layout),
            controlled=controlled_of(self.axes),
            signals=self.layout.signals,
            limiting=self._limiting(),
        )

    def _limiting(self) -> tuple[str, float] | None:
        """Return the requirement of the smallest margin, and when that was; None where it has no moment."""
        verdict = self.verdict
        if verdict is None or verdict.limiting is None or verdict.at_s is None:
            return None
        return verdict.limiting, verdict.at_s

    def _limits(self) -> dict[str, tuple[float, float] | None]:
        """Return the limits of each axis, and of each effector that has a name of its own."""
        layout = self.layout
        each = effector_limits(self.scenario.saturation, layout.mixing, layout.targets)
        limits = dict(zip(SURFACES, axis_limits(each, layout.mixing), strict=True))
        for j, name in enumerate(layout.names):
            if name not in SURFACES:
                limits[name] = np.sort((layout.position_sign[j] or 1.0) * (layout.trim_rad[j] + each[j]))
        return {
            name: (float(pair[0]), float(pair[1])) if np.isfinite(pair).any() else None for name, pair in limits.items()
        }

    def write_history(self, path: Path) -> None:
        """Write `history.parquet`, to the byte as a flight streams it; the history must have been kept."""
        assert self.history is not None
        write_history(path, self.history, metadata_of(self.scenario, self.origin), chunk=CHUNK_ROWS)

    def history_bytes(self) -> bytes:
        """Return what `write_history` would write."""
        import pyarrow as pa  # noqa: PLC0415

        assert self.history is not None
        sink = pa.BufferOutputStream()
        write_history(sink, self.history, metadata_of(self.scenario, self.origin), chunk=CHUNK_ROWS)
        content: bytes = sink.getvalue().to_pybytes()
        return content


def origin_of(flight: Flight) -> dict[str, Any]:
    """Return the provenance of a flight that is built: versions, seed, checksums, and how the plant was set up."""
    scenario = flight.scenario
    origin = provenance(
        seed=scenario.seed,
        scenario_sha256=hashlib.sha256(scenario_text(scenario).encode()).hexdigest(),
        aircraft_sha256=flight.aircraft.sha256(),
        plant_settings=flight.plant.settings,
    )
    if isinstance(scenario.controller, CustomController):
        origin["controller_sha256"] = checksum(scenario.controller.kind)
    return origin


def notes_of(flight: Flight) -> tuple[str, ...]:
    """Return what is worth knowing about the aircraft, its axes, servos and files where read, one line each."""
    files = () if flight.model is None else tuple(notes(flight.aircraft, flight.model))
    asked = (*named.remarks(flight.scenario, flight.given), *servos.remarks(flight.scenario, flight.given))
    asked = (*asked, *requirements.remarks(flight.scenario, flight.layout, flight.signals))
    differs = uncertain.remarks(flight.scenario, flight.plant.settings.get("uncertainty"))
    return (*differs, *left_to_the_airframe(flight.given.axes), *coarse(flight), *asked, *flight.remarks(), *files)


def coarse(flight: Flight) -> list[str]:
    """Return a line where the scenario's own `simulation.substeps` make plant steps longer than the step check's."""
    model, step, name = flight.model, flight.given.plant_step, flight.aircraft.name
    substeps = flight.scenario.simulation.substeps
    if model is None or flight.scenario.plant != "jsbsim" or substeps is None:
        return []
    if not model.step.get("passed", True):
        return [f"simulation.substeps: {substeps}, and the step check of {name} passes at no plant step"]
    if step <= model.frame_s * (1.0 + 1e-9):
        return []
    taken = f"simulation.substeps: {substeps} makes plant steps of {step * 1e3:.4g} ms"
    return [f"{taken}, where {name} needs at most {model.frame_s * 1e3:g} ms"]


def metadata_of(scenario: Scenario, origin: dict[str, Any]) -> dict[str, str]:
    """Return the text kept in the metadata of a `history.parquet`: the scenario as flown, and its provenance."""
    return {"scenario": scenario_text(scenario), **{key: str(value) for key, value in origin.items()}}
