"""Doubles between two pieces of memory and properties, without a loop (it costs 0.5 us a frame more)."""

from __future__ import annotations

import struct
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

Setter = Callable[[float], object]
Getter = Callable[[], float]


def writer(memory: np.ndarray, setters: Sequence[Sequence[Setter]]) -> Callable[[], None]:
    """Return a function that hands the i-th double of `memory` to each of `setters[i]`.

    Its body is written out for so many: ``v0, v1, ... = unpack(memory)``, then ``f0(v0)`` and so on.
    """
    return _made(*_writing(memory, setters))


def reader(memory: np.ndarray, getters: Sequence[Getter | None]) -> Callable[[], None]:
    """Return a function that fetches the i-th double of `memory` from `getters[i]`, or leaves 0 where that is None.

    Its body is written out for so many: ``pack(memory, 0, g0(), g1(), ...)``.
    """
    return _made(*_reading(memory, getters))


def stepper(
    out: np.ndarray,
    setters: Sequence[Sequence[Setter]],
    step: Callable[[], object],
    into: np.ndarray,
    getters: Sequence[Getter | None],
) -> Callable[[], None]:
    """Return a function that writes as `writer` does, takes a step, and reads as `reader` does: one call, not three."""
    (writing, set_by), (reading, got_by) = _writing(out, setters), _reading(into, getters)
    return _made([*writing, "step()", *reading], {**set_by, **got_by, "step": step})


def _writing(memory: np.ndarray, setters: Sequence[Sequence[Setter]]) -> tuple[list[str], dict[str, Any]]:
    if not setters:
        return [], {}
    calls = [(f"f{i}_{j}", i, setter) for i, group in enumerate(setters) for j, setter in enumerate(group)]
    values = ", ".join(f"v{i}" for i in range(len(setters)))
    unpack = struct.Struct(f"{len(setters)}d").unpack_from
    lines = [f"{values}, = unpack(written)", *(f"{name}(v{i})" for name, i, _ in calls)]
    return lines, {"unpack": unpack, "written": memory.data.cast("B"), **{name: setter for name, _, setter in calls}}


def _reading(memory: np.ndarray, getters: Sequence[Getter | None]) -> tuple[list[str], dict[str, Any]]:
    called = {f"g{i}": getter for i, getter in enumerate(getters) if getter is not None}
    values = ", ".join(f"g{i}()" if getter is not None else "0.0" for i, getter in enumerate(getters))
    pack = struct.Struct(f"{len(getters)}d").pack_into
    return [f"pack(read, 0, {values})"], {"pack": pack, "read": memory.data.cast("B"), **called}


def _made(lines: list[str], names: dict[str, Any]) -> Callable[[], None]:
    """Return a function of these lines, with the names as its closure."""
    body = "\n  ".join(lines) or "pass"
    scope: dict[str, Callable[..., Callable[[], None]]] = {}
    exec(f"def make({', '.join(names)}):\n def made():\n  {body}\n return made\n", scope)
    return scope["make"](**names)
