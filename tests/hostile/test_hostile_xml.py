"""Every typing error in hale's XML is refused with one message, or flies to the same bits; the rest is named."""

from __future__ import annotations

import faulthandler
import hashlib
import json
import multiprocessing
import os
import shutil
from collections import Counter
from collections.abc import Sequence
from multiprocessing.connection import wait
from pathlib import Path

import pytest

from hostile.xml_mutants import Mutant, mutants
from uavftc.config.shipped import aircraft_dir
from uavftc.errors import InputError
from uavftc.flight.build import build_flight
from uavftc.flight.fly import fly_to_memory
from uavftc.plants.jsbsim import measure, model, step_check
from uavftc.scenario.load import load_scenario

HALE = aircraft_dir() / "hale"
LIMIT_S = 60.0


def flown(folder: Path) -> str:
    """Return a checksum of the trimmed model and of 2 s of scenario 1, flown in this process."""
    overrides = (f"aircraft={folder}", "duration_s=2")
    flight = build_flight(load_scenario("scenario1", plant="jsbsim", overrides=overrides))
    records, _ = fly_to_memory(flight)
    return hashlib.sha256(records.tobytes() + repr(flight.model).encode()).hexdigest()


def measured_here(aircraft, speeds, altitude):
    """Stand in for the child process that measures a model: each mutant is in one already."""
    models = measure.models_of(aircraft, tuple(speeds), altitude)
    stepped = [model.with_step(m, step_check.check(aircraft, m)) for m in models]
    return json.dumps({"models": [model.written(m) for m in stepped], "lasting": False})


def trial(mutant: Mutant | None, place: Path, pipe, as_a_user: bool) -> None:
    """Fly a mutant and send (outcome, detail); runs in a process of its own."""
    faulthandler.disable()
    os.dup2(os.open(os.devnull, os.O_WRONLY), 2)  # what JSBSim says as it aborts
    model._keep = lambda file, answer: None
    if not as_a_user:
        model._in_child = measured_here
    folder = place / "hale"
    shutil.copytree(HALE, folder)
    if mutant is not None:
        path = folder / mutant.file
        path.write_text(mutant.applied(path.read_text(encoding="utf-8")), encoding="utf-8")
    try:
        answer = ("flown", flown(folder))
    except InputError as error:
        answer = ("refused", str(error))
    except BaseException as error:
        answer = ("raised", repr(error))
    pipe.send(answer)
    pipe.close()
    shutil.rmtree(place)
    os._exit(0)  # some aircraft crash JSBSim as it is taken down


def trials(todo: Sequence[Mutant | None], place: Path, *, as_a_user: bool = False) -> list[tuple[str, str]]:
    """Fly all, each in a process of its own, as many at once as there are cores."""
    context = multiprocessing.get_context("fork")
    answers: list[tuple[str, str]] = [("", "")] * len(todo)
    running: dict = {}
    queue = list(enumerate(todo))[::-1]
    while queue or running:
        while queue and len(running) < (os.cpu_count() or 1):
            index, mutant = queue.pop()
            ours, theirs = context.Pipe(duplex=False)
            child = context.Process(target=trial, args=(mutant, place / str(index), theirs, as_a_user))
            child.start()
            theirs.close()
            running[ours] = (index, child)
        ready = wait(list(running), timeout=LIMIT_S)
        assert ready, f"nothing ended within {LIMIT_S} s: {[todo[i] for i, _ in running.values()]}"
        for pipe in ready:
            index, child = running.pop(pipe)
            try:
                answers[index] = pipe.recv()
            except EOFError:
                answers[index] = ("crashed", "")
            child.join()
            pipe.close()
    return answers


# What cannot be told from a model that is meant so, with the number of mutants of hale: docs/trust.md says why.
LEGAL = {
    ("child dropped", "aerodynamics/axis"): 2,
    ("child dropped", "axis/function"): 15,
    ("child dropped", "product/pow"): 1,
    ("child dropped", "product/property"): 57,
    ("child dropped", "product/value"): 17,
    ("child dropped", "thruster/sense"): 1,
    ("child dropped", "pid/ki"): 1,
    ("child dropped", "pid/kp"): 1,
    ("child dropped", "pid/trigger"): 1,
    ("child dropped", "summer/input"): 4,
    ("child dropped", "channel/summer"): 1,  # JSBSim then hands a throttle command on by itself
    ("child dropped", "summer/output"): 2,
    ("child dropped", "switch/test"): 2,
    ("child dropped", "system/channel"): 1,
}


@pytest.mark.slow
def test_every_typing_error_in_the_xml_is_refused_or_harmless(tmp_path, capsys):
    # A mutant that is flown to other bits was misread in silence. Trim, linear model and 2 s of flight are compared.
    model._cached.cache_clear()
    flown(HALE)  # compiles the laws once, before the processes part
    todo = list(mutants(HALE))
    assert len(todo) >= 870
    (first, second), answers = trials([None, None], tmp_path / "original"), trials(todo, tmp_path / "mutants")
    assert first == second
    assert first[0] == "flown"
    # an abort is what a user's command sees as the end of the child process that measures the aircraft
    crashed = [i for i, (outcome, _) in enumerate(answers) if outcome == "crashed"]
    again = trials([todo[i] for i in crashed], tmp_path / "again", as_a_user=True)
    for i, answer in zip(crashed, again, strict=True):
        answers[i] = answer
    outcomes = Counter()
    legal, defects = Counter(), []
    for mutant, (ending, detail) in zip(todo, answers, strict=True):
        outcome = ending
        if ending == "flown":
            outcome = "same bits" if detail == first[1] else "other bits"
        outcomes[mutant.kind, outcome] += 1
        if outcome == "other bits" and (mutant.kind, mutant.role) in LEGAL:
            legal[mutant.kind, mutant.role] += 1
        elif outcome not in ("refused", "same bits"):
            defects.append(f"{mutant.name}: {outcome} {detail}")
        elif outcome == "refused" and not all(part in detail for part in ("found: ", "expected: ", "remedy: ")):
            defects.append(f"{mutant.name}: {detail}")
    with capsys.disabled():
        print(f"\n{len(todo)} mutants, {len(crashed)} of which abort JSBSim, {len(defects)} defects")
        for (kind, outcome), count in sorted(outcomes.items()):
            print(f"  {kind:18} {outcome:10} {count:5}")
    assert not defects, "\n".join(defects)
    assert dict(legal) == LEGAL
