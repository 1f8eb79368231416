"""The trimmed model of an aircraft: what the project knows of it beyond its XML, measured on JSBSim.

Trim, linear model, surface limits and signs, inertia. It is measured in a child process, because some aircraft crash
the process that loads them, and kept in the user's cache under the checksum of the aircraft's files and of this code.
"""

from __future__ import annotations

import contextlib
import functools
import hashlib
import json
import os
import signal
import subprocess
import sys
from collections.abc import Callable, Mapping, Sequence
from importlib import metadata
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np

from uavftc.aircraft import definition as aircraft_module
from uavftc.aircraft.definition import Aircraft
from uavftc.aircraft.effectors import Measured
from uavftc.analysis import authority, modes
from uavftc.core.cache import cache_folder
from uavftc.errors import InputError
from uavftc.plants.jsbsim import strict

TIMEOUT_S = 120.0
FRAME_S = 0.005  # the trim does not depend on the rate at which it is flown
NOMINAL_RAD = 0.35  # stands for the deflection at full command of a surface that reports none
ALTITUDE_M = 1500.0  # where nothing says otherwise
SPEEDS_MPS = (
    5.0, 6.0, 7.0, 8.5, 10.0, 12.0, 15.0, 20.0, 25.0, 30.0, 35.0, 42.0, 51.0, 62.0, 75.0, 90.0, 110.0, 130.0, 155.0,
    185.0, 220.0, 260.0,
)  # fmt: skip


class NoTrimError(InputError):
    """There is no trim at a condition."""


class TrimmedModel(NamedTuple):
    """An aircraft at one trim; SI, radians, deflections u about trim, positive u for a positive moment."""

    trim: dict[str, Any]
    """Fields of `trim.Trim`."""
    mass_kg: float
    inertia_kgm2: list[list[float]]
    engines: int
    rad_per_command: list[float]
    """(3,) deflection u, rad, per unit of the surface's command; negative where JSBSim's sign is the other."""
    measured_rad: list[bool]
    """(3,) whether the aircraft reports the deflection, or `NOMINAL_RAD` stands for it."""
    limits_rad: list[list[float]]
    """(3, 2) least and greatest u about trim, from the range of the command."""
    A: list[list[float]]
    """(8, 8) over `analysis.modes.STATES`, engines settled."""
    A_at_once: list[list[float]]
    """(3, 3) over p, q, r, 1/s, engines at the speed of the trim: what laws and rotational plants are made from."""
    B: list[list[float]]
    """(6, 3) change of u_dot, v_dot, w_dot, m/s^2, and p_dot, q_dot, r_dot, rad/s^2, per rad of u."""
    throttle_mps2: float
    """Change of u_dot, m/s^2, per unit of throttle."""
    nonlinearity: list[float]
    """(3,) relative difference of each surface's response about its axis between two step sizes."""
    effectors: Sequence[Measured] = ()
    """Surfaces, in their order in a row. The fields above named of three surfaces are those of the three gangs."""
    mixing: Sequence[Sequence[float]] = ()
    """(n, 3) deflection of each effector, rad, per rad of axis command."""
    gangs: Mapping[str, Mapping[str, float]] = MappingProxyType({})
    """Effectors of each axis and their weights; what a fault or a limit on `aileron` acts on."""
    axes: Sequence[bool] = (True, True, True)
    """Whether roll, pitch and yaw answer to any effector."""
    reach_rad: Sequence[Sequence[float]] = ()
    """(3, 2) what each axis can do to either side, as the deflection that would do it by the slope: its authority."""
    frame_s: float = FRAME_S
    """Longest plant step that its engines and its step check allow, s."""
    step: Mapping[str, Any] = MappingProxyType({})
    """The step check at this trim, as `step_check.check` returns it; empty where it was not made."""
    engine_names: Sequence[str] = ()
    """Names of the engines, as the companion file has them."""
    engine_order: Sequence[str] = ()
    """The same in the order of the XML, so that the place of an engine is its number in JSBSim."""
    declared: Sequence[str] = ()
    """Properties that the aircraft reads and nothing defines; they are 0."""

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the effectors."""
        return tuple(e.name for e in self.effectors)

    @property
    def A_rates(self) -> np.ndarray:
        """Rotational block of A over p, q, r, shape (3, 3), 1/s, engines settled."""
        index = [5, 2, 6]
        return np.array(self.A)[np.ix_(index, index)]

    @property
    def B_rates(self) -> np.ndarray:
        """Change of p_dot, q_dot, r_dot with aileron, elevator and rudder, shape (3, 3), 1/s^2 per rad."""
        return np.array(self.B)[3:]


def notes(aircraft: Aircraft, model: TrimmedModel) -> list[str]:
    """Return what is worth knowing about the aircraft's files, one line each."""
    lines = strict.warnings(aircraft)
    commanded = {name for _, name in aircraft.properties()}
    if held := [name for name in model.declared if name not in commanded]:
        lines.append(f"{aircraft.xml.name} reads what nothing defines, taken as 0: {', '.join(held)}")
    if (reason := finer_because(model)) is not None:
        usual = f"where {FRAME_S * 1e3:g} ms are usual"
        lines.append(f"{aircraft.name} needs plant steps of at most {model.frame_s * 1e3:g} ms, {usual}: {reason}")
    if model.trim["method"] == "glide" and model.engine_names:
        lines.append(f"{aircraft.name} glides: no throttle moves the thrust of its engines")
    return lines


def finer_because(model: TrimmedModel) -> str | None:
    """Return why an aircraft takes finer plant steps than usual, or None where it does not or none is fine enough."""
    if model.frame_s >= FRAME_S or not model.step.get("passed", True):
        return None
    tried = model.step.get("tried", [])
    if not tried or tried[0]["frame_s"] == model.frame_s:
        return "the thrust of its engines is another at longer ones"
    missed = next(t for t in reversed(tried) if not t["passed"])
    return f"the step check fails at {missed['frame_s'] * 1e3:g} ms ({missed_by(missed)})"


def missed_by(tried: Mapping[str, Any]) -> str:
    """Return in words by what a frame does not pass the step check."""
    if tried["first_difference"] is None:
        return str(tried["worst"])
    return (
        f"{tried['worst']} differs by {tried['first_difference']:.2g} of its motion from half that step, "
        f"and that by {tried['second_difference']:.2g} from a quarter"
    )


# --- measured once, in a child process ------------------------------------------------------------------------------


def trimmed_model(aircraft: Aircraft, airspeed: float, altitude: float) -> TrimmedModel:
    """Return the trimmed model at an airspeed, m/s, and altitude, m, from the cache or measured in a child process.

    Raises
    ------
    InputError
        If the aircraft crashes JSBSim, does not load, or has no trim there.
    """
    strict.refuse(aircraft)
    return _cached(aircraft, aircraft.sha256(), (airspeed,), altitude)[0]


def trimmed_models(aircraft: Aircraft, altitude: float) -> tuple[TrimmedModel, ...]:
    """Return the trimmed models at those of `SPEEDS_MPS` at which there is a trim.

    Raises
    ------
    InputError
        If the aircraft crashes JSBSim, does not load, or trims at none of the speeds.
    """
    strict.refuse(aircraft)
    return _cached(aircraft, aircraft.sha256(), SPEEDS_MPS, altitude)


def stepped(aircraft: Aircraft, model: TrimmedModel) -> TrimmedModel:
    """Return the model with its step check, from the cache or made in a child process.

    A model that was measured at one airspeed has it already; of those at many, only the one that is flown needs it.

    Raises
    ------
    InputError
        If the aircraft crashes JSBSim or does not load.
    """
    if model.step:
        return model
    return with_step(model, _step(aircraft, aircraft.sha256(), json.dumps(written(model))))


@functools.lru_cache(maxsize=256)
def _step(aircraft: Aircraft, checksum: str, model: str) -> dict[str, Any]:
    name = f"{checksum[:32]}-step-{hashlib.sha256(model.encode()).hexdigest()[:32]}"
    step: dict[str, Any] = _answer(name, lambda: _child(aircraft, ["step"], model))["step"]
    return step


def with_step(model: TrimmedModel, step: Mapping[str, Any]) -> TrimmedModel:
    """Return the model with a step check, and the steps that it allows."""
    return model._replace(step=step, frame_s=step["frame_s"])


@functools.lru_cache(maxsize=256)
def _cached(aircraft: Aircraft, checksum: str, speeds: tuple[float, ...], altitude: float) -> tuple[TrimmedModel, ...]:
    name = repr(speeds[0]) if len(speeds) == 1 else "all"
    answer = _answer(f"{checksum[:32]}-{name}-{altitude!r}", lambda: _in_child(aircraft, speeds, altitude))
    return tuple(read(model) for model in answer["models"])


def _answer(name: str, child: Callable[[], str]) -> dict[str, Any]:
    """Return the answer of that name in the cache, or else the child's.

    Raises
    ------
    InputError
        If it is a refusal.
    """
    file = cache_dir() / f"{name}.json"
    answer: dict[str, Any] | None = None
    with contextlib.suppress(OSError, ValueError):
        answer = json.loads(file.read_text(encoding="utf-8"))
    if answer is None:
        answer = json.loads(child())
        if answer["lasting"]:
            _keep(file, answer)
    if "error" in answer:
        fields = dict(answer["error"])
        raise InputError(fields.pop("where"), **fields)
    return answer


def written(model: TrimmedModel) -> dict[str, Any]:
    """Return a model as JSON takes it."""
    effectors = [e._asdict() for e in model.effectors]
    return {**model._asdict(), "effectors": effectors, "gangs": dict(model.gangs), "step": dict(model.step)}


def read(model: dict[str, Any]) -> TrimmedModel:
    """Return the model that `written` wrote."""
    return TrimmedModel(**{**model, "effectors": [Measured(**e) for e in model["effectors"]]})


def _keep(file: Path, answer: dict[str, Any]) -> None:
    """Write an answer to the cache; where it cannot be written, it is measured again."""
    with contextlib.suppress(OSError):
        file.parent.mkdir(parents=True, exist_ok=True)
        partial = file.with_suffix(f".{os.getpid()}")
        partial.write_text(json.dumps(answer), encoding="utf-8")
        partial.replace(file)


def cache_dir() -> Path:
    """Return the folder of trimmed models for exactly this code, this planet and this JSBSim."""
    digest = hashlib.sha256(metadata.version("jsbsim").encode())
    here = Path(__file__).parent
    for source in (
        Path(aircraft_module.__file__),
        Path(authority.__file__),
        Path(modes.__file__),
        *sorted(here.rglob("*.py")),
        *sorted(here.glob("*.xml")),
    ):
        digest.update(source.read_bytes())
    return cache_folder("models", digest.hexdigest()[:16])


def _in_child(aircraft: Aircraft, speeds: tuple[float, ...], altitude: float) -> str:
    return _child(aircraft, [repr(altitude), *map(repr, speeds)])


def _child(aircraft: Aircraft, arguments: Sequence[str], text: str = "") -> str:
    """Return the last line that a child process with these arguments, and `text` on its input, prints."""
    command = [sys.executable, "-m", "uavftc.plants.jsbsim.child", aircraft.reference, *arguments]
    with subprocess.Popen(
        command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as child:
        try:
            stdout, stderr = child.communicate(text, timeout=TIMEOUT_S)
        except BaseException as error:  # Ctrl-C too leaves no child behind
            child.kill()
            child.wait()
            if isinstance(error, subprocess.TimeoutExpired):
                found = f"JSBSim does not finish loading and trimming it within {TIMEOUT_S:g} s"
                raise _crash(aircraft, found, "") from None
            raise
    if child.returncode < 0:
        name = signal.Signals(-child.returncode).name
        raise _crash(aircraft, f"JSBSim crashes while loading or trimming it ({name})", stderr)
    if child.returncode != 0 or not stdout.strip():
        raise _crash(aircraft, "the process that loads it ended abnormally", stderr)
    return stdout.strip().splitlines()[-1]


def _crash(aircraft: Aircraft, found: str, stderr: str) -> InputError:
    lines = [line.split("what():")[-1].strip() for line in stderr.splitlines() if "what():" in line]
    lines = lines or [line for line in stderr.splitlines()[-1:] if line.strip()]
    return InputError(
        f"aircraft {aircraft.name}, {aircraft.xml}",
        found=": ".join([found, *lines[:1]]),
        expected="an aircraft that JSBSim loads and runs",
        remedy="look for a name that does not exist or a function that uses itself, in the part you changed last",
    )
