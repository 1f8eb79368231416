"""`summary.json`: what came of a flight, in the shape other tools build on.

A number that does not apply is null, never NaN. Wall-clock figures are under `timing`, the only part that may differ
between two runs of the same flight.
"""

from __future__ import annotations

import functools
import math
import platform
from collections.abc import Mapping, Sequence
from importlib import metadata
from pathlib import Path
from typing import Any

from uavftc.analysis import metrics
from uavftc.core.signals import AXES
from uavftc.results.manifest import text_of

_PACKAGES = ("uavftc", "jsbsim", "numpy", "numba")


def summary(
    *,
    scenario: str,
    aircraft: str,
    plant: str,
    controller: str,
    completed: bool,
    ended_because: str | None,
    ended_at_s: float | None = None,
    numerical: bool = False,
    verdict: Mapping[str, Any] | None = None,
    axes: Mapping[str, Mapping[str, float | None]],
    timing: Mapping[str, float | int],
    provenance: Mapping[str, Any],
    warnings: Sequence[str] = (),
) -> dict[str, Any]:
    """Return the document of `summary.json`.

    Parameters
    ----------
    scenario, aircraft, plant, controller
        Names, as on the command line.
    completed
        Whether the flight reached its end.
    ended_because, ended_at_s
        Reason and time (s) of an early end; None when completed.
    numerical
        Whether it ended for its plant step and not for the vehicle.
    verdict
        As `analysis.verdict.Verdict.document` returns it; None where the user ended the flight.
    axes
        For roll, pitch and yaw, every metric of `analysis.metrics.METRICS`; None or NaN where one does not apply.
    timing
        At least `flight_wall_s`, `controller_steps` and `us_per_controller_step`.
    provenance
        As from `provenance`.
    warnings
        Remarks for the user, one sentence each.

    Raises
    ------
    KeyError
        If an axis or one of its metrics is missing.
    """
    return {
        "scenario": scenario,
        "aircraft": aircraft,
        "plant": plant,
        "controller": controller,
        "completed": bool(completed),
        "ended_because": ended_because,
        "ended_at_s": plain(ended_at_s),
        "numerical": bool(numerical),
        "verdict": plain(verdict),
        "axes": {axis: {m.name: plain(axes[axis][m.name]) for m in metrics.METRICS} for axis in AXES},
        "timing": plain(timing),
        "warnings": list(warnings),
        "provenance": plain(provenance),
    }


def provenance(
    *, seed: int | None, scenario_sha256: str, aircraft_sha256: str | None, **extra: object
) -> dict[str, Any]:
    """Return what the flight was made from: versions, seed, checksums, and everything else that is given.

    A package that is not installed has the version None. None of them is imported for it.
    """
    return {
        **_versions(),
        "python": platform.python_version(),
        "seed": seed,
        "scenario_sha256": scenario_sha256,
        "aircraft_sha256": aircraft_sha256,
        **extra,
    }


@functools.cache
def _versions() -> dict[str, str | None]:
    versions: dict[str, str | None] = {}
    for package in _PACKAGES:
        try:
            versions[package] = metadata.version(package)
        except metadata.PackageNotFoundError:
            versions[package] = None
    return versions


def title_of(document: Mapping[str, Any]) -> str:
    """Return what was flown, in one line; of an aircraft given as a path its folder's name."""
    return "{scenario}: {controller} on {name}, {plant}".format(**document, name=Path(document["aircraft"]).name)


def ending_of(document: Mapping[str, Any]) -> tuple[str, str]:
    """Return how a flight ended: its outcome, or `completed` where nobody judged it, and a short line that says it."""
    verdict, ended = document["verdict"], document["ended_at_s"]
    at = "" if document["completed"] or ended is None else f" at {ended:.1f} s"
    because = ""
    if not document["completed"]:
        because = ": " + str(document["ended_because"] or "for an unknown reason").partition(", at t =")[0]
    if verdict is None:
        outcome = "completed" if document["completed"] else "ended"
        return outcome, f"{outcome}{at}{because}"
    text = f"{verdict['outcome']}{at}, margin {verdict['margin']:.2f}".replace("-", "\N{MINUS SIGN}")
    limiting = f" ({verdict['limiting']})" if document["completed"] and verdict["limiting"] else ""
    return verdict["outcome"], f"{text}{limiting}{because}"


def write_json(path: Path, data: Mapping[str, Any]) -> None:
    """Write `data` as JSON, indented by 2, keys in the order given.

    Raises
    ------
    ValueError
        If there is a NaN or an infinity in it; nothing is written then.
    """
    path.write_text(text_of(data), encoding="utf-8", newline="\n")


def plain(value: Any) -> Any:
    """Return `value` as JSON knows it: NumPy numbers and arrays as Python's, what is not finite as None."""
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    if hasattr(value, "tolist"):
        value = value.tolist()
    if isinstance(value, (list, tuple)):
        return [plain(item) for item in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
