"""Hostile scenario files and options: each is refused in one complete message, or loads and its text round-trips.

    pytest -n 0 -m slow -s tests/hostile/test_hostile_scenarios.py       # prints its counts

Never another exception, never more than two seconds of the processor, and what loads is built and flown for a moment.
"""

from __future__ import annotations

import os
import subprocess
import sys
import time
from pathlib import Path
from typing import NamedTuple

import pytest

from hostile.beyond_files import beyond_cases
from hostile.scenario_files import MALFORMED, OPTION_KEYS, Case, option_cases, scenario_cases
from uavftc.errors import CombinedInputError, InputError
from uavftc.flight.build import build_flight
from uavftc.flight.fly import fly_to_memory
from uavftc.scenario.load import load_scenario, scenario_text, warnings
from uavftc.scenario.schema import Scenario

pytestmark = pytest.mark.slow

SEED = 437
MAX_S = 2.0  # of processor time, to load
MAX_LINES = 40
SHORT_S = 0.05  # at every rate that is a multiple of 20 Hz a whole number of samples
COMMANDS = 48  # cases given to the command line


class Result(NamedTuple):
    """What became of one case."""

    case: Case
    loaded: Scenario | None
    defect: str | None


def problem_of(error: InputError) -> str | None:
    """Return what is wrong with a message, or None."""
    text = str(error)
    for part in error.errors if isinstance(error, CombinedInputError) else (error,):
        for name in ("where", "found", "expected", "remedy"):
            value = getattr(part, name)
            if not isinstance(value, str) or not value.strip():
                return f"{name} is empty"
    try:
        text.encode("utf-8")
    except UnicodeEncodeError:
        return "a surrogate in the message"
    lines = text.split("\n")
    if len(lines) > MAX_LINES:
        return f"{len(lines)} lines"
    if bad := next((line for line in lines if not line.isprintable()), None):
        return f"not printable: {bad!r}"
    return None


def loaded(path: Path, overrides: tuple[str, ...] = ()) -> tuple[Scenario | None, str | None]:
    """Load a file; return the scenario or None, and the defect or None."""
    started = time.process_time()
    scenario = defect = None
    try:
        scenario = load_scenario(path, overrides=overrides)
        warnings(scenario)
    except InputError as error:
        defect = problem_of(error)
    except Exception as error:
        defect = f"{type(error).__name__}: {error}"
    took = time.process_time() - started
    return scenario, defect or (f"{took:.1f} s" if took > MAX_S else None)


def tried(case: Case, folder: Path) -> Result:
    """Load one case, and what it loads to once more from its text."""
    path = folder / "case.yaml"
    path.write_bytes(case.content)
    scenario, defect = loaded(path, case.overrides)
    if scenario is not None and defect is None:
        again = folder / "again.yaml"
        again.write_text(scenario_text(scenario), encoding="utf-8")
        back, defect = loaded(again)
        if back is None:
            defect = f"its text is refused ({defect})"
        elif back != scenario:
            defect = "its text gives another scenario"
    return Result(case, scenario, defect)


def flown(scenario: Scenario) -> str | None:
    """Build and fly the first moments of a scenario; return the defect, or None."""
    try:
        short = Scenario.model_validate(scenario.model_dump() | {"duration_s": SHORT_S})
    except ValueError:  # no whole number of samples, or a signal that is not finite there
        return None
    try:
        records, outcome = fly_to_memory(build_flight(short))
    except InputError as error:
        return problem_of(error)
    except Exception as error:
        return f"{type(error).__name__}: {error}"
    return None if outcome.rows == len(records) else "rows are missing"


def report(what: str, results: list[Result], defects: list[str]) -> None:
    """Print the counts, and fail on a defect."""
    good = sum(t.loaded is not None for t in results)
    print(f"\n{what}: {len(results)} cases, {good} load, {len(results) - good} refused, {len(defects)} defects")
    assert not defects, "\n".join(defects[:60])


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> list[Result]:
    folder = tmp_path_factory.mktemp("files")
    return [tried(case, folder) for case in scenario_cases(SEED)]


@pytest.fixture(scope="module")
def beyond(tmp_path_factory: pytest.TempPathFactory) -> list[Result]:
    folder = tmp_path_factory.mktemp("beyond")
    return [tried(case, folder) for case in beyond_cases(SEED)]


def test_every_hostile_fault_servo_sensor_damage_or_air_is_refused_or_round_trips(beyond: list[Result]) -> None:
    assert len(beyond) >= 2000
    defects = [f"{t.case.name}: {t.defect}" for t in beyond if t.defect]
    report("hostile faults, servos, sensors, damage, air", beyond, defects)
    assert 0.1 < sum(t.loaded is not None for t in beyond) / len(beyond) < 0.9


def test_what_loads_of_them_is_built_and_flown_or_refused(beyond: list[Result]) -> None:
    some = [t for t in beyond if t.loaded is not None]
    report("flown for a moment", some, [f"{t.case.name}: {d}" for t in some if t.loaded and (d := flown(t.loaded))])


def test_every_hostile_file_is_refused_in_one_message_or_round_trips(files: list[Result]) -> None:
    assert len(files) >= 2700
    report("hostile scenario files", files, [f"{t.case.name}: {t.defect}" for t in files if t.defect])
    # both ends are reached: files that are all refused, or all loaded, try nothing
    assert 0.1 < sum(t.loaded is not None for t in files) / len(files) < 0.9


def test_every_hostile_option_is_refused_in_one_message_or_round_trips(tmp_path: Path) -> None:
    results = [tried(case, tmp_path) for case in option_cases(SEED)]
    assert len(results) == 8 * len(OPTION_KEYS) == 8 * len(MALFORMED) == 216
    report("hostile options", results, [f"{t.case.name} {t.case.overrides}: {t.defect}" for t in results if t.defect])


def test_what_loads_is_built_and_flown_or_refused(files: list[Result]) -> None:
    some = [t for t in files if t.loaded is not None]
    report("flown for a moment", some, [f"{t.case.name}: {d}" for t in some if t.loaded and (d := flown(t.loaded))])


def test_the_command_line_ends_with_2_and_writes_nothing(files: list[Result], tmp_path: Path) -> None:
    refused = [t for t in files if t.loaded is None]
    some = refused[:: max(1, len(refused) // COMMANDS)][:COMMANDS]
    defects = []
    for results in some:
        (tmp_path / "case.yaml").write_bytes(results.case.content)
        command = [sys.executable, "-m", "uavftc", "fly", "case.yaml"]
        done = subprocess.run(command, cwd=tmp_path, capture_output=True, check=False, timeout=60, env=os.environ)
        text = done.stderr.decode("utf-8")
        wrong = done.returncode != 2 or "remedy:" not in text or "Traceback" in text or b"\x1b" in done.stderr
        if wrong or done.stdout or sorted(p.name for p in tmp_path.iterdir()) != ["case.yaml"]:
            defects.append(f"{results.case.name}: exit {done.returncode}, {text[-300:]!r}")
    report("command line", some, defects)
