"""Doubles between two pieces of memory and properties, without a loop (it costs 0.5 us a frame more)."""

from __future__ import annotations

import struct
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

Setter = Callable[[float], object]
Getter = Callable[[], float]


class Below(NamedTuple):
    """A getter that is called where another of the same reading is not above a value; else it is 0."""

    getter: Getter
    other: int
    """Place of the other among the getters, before this one."""
    value: float


Source = Getter | Below | None
"""Where a number comes from; 0 where that is None."""

Fly = Callable[[Callable[[int, int], int], int, int], int]
"""fly(program, first, last): see `looper`."""


def writer(memory: np.ndarray, setters: Sequence[Sequence[Setter]]) -> Callable[[], None]:
    """Return a function that hands the i-th double of `memory` to each of `setters[i]`.

    Its body is written out for so many: ``v0, v1, ... = unpack(memory)``, then ``f0(v0)`` and so on.
    """
    made: Callable[[], None] = _made(*_writing(memory, setters))
    return made


def reader(memory: np.ndarray, getters: Sequence[Source]) -> Callable[[], None]:
    """Return a function that fetches the i-th double of `memory` from `getters[i]`.

    Its body is written out for so many: ``pack(memory, 0, g0(), g1(), ...)``.
    """
    made: Callable[[], None] = _made(*_reading(memory, getters))
    return made


def looper(
    out: np.ndarray,
    setters: Sequence[Sequence[Setter]],
    step: Callable[[], object],
    into: np.ndarray,
    getters: Sequence[Source],
) -> Fly:
    """Return fly(program, first, last), which for each row runs the program, writes, takes a step and reads.

    It writes as `writer` does and reads as `reader` does, all in one function without a call of another. It returns the
    row at which the program returned the row itself, or `last`.
    """
    (writing, set_by), (reading, got_by) = _writing(out, setters), _reading(into, getters)
    row = ["if program(k, k + 1) == k: return k", *writing, "step()", *reading]
    lines = ["for k in range(first, last):", *(f" {line}" for line in row), "return last"]
    made: Fly = _made(lines, {**set_by, **got_by, "step": step}, "program, first, last")
    return made


def _writing(memory: np.ndarray, setters: Sequence[Sequence[Setter]]) -> tuple[list[str], dict[str, Any]]:
    if not setters:
        return [], {}
    calls = [(f"f{i}_{j}", i, setter) for i, group in enumerate(setters) for j, setter in enumerate(group)]
    values = ", ".join(f"v{i}" for i in range(len(setters)))
    unpack = struct.Struct(f"{len(setters)}d").unpack_from
    lines = [f"{values}, = unpack(written)", *(f"{name}(v{i})" for name, i, _ in calls)]
    return lines, {"unpack": unpack, "written": memory.data.cast("B"), **{name: setter for name, _, setter in calls}}


def _reading(memory: np.ndarray, getters: Sequence[Source]) -> tuple[list[str], dict[str, Any]]:
    called = {f"g{i}": _getter(source) for i, source in enumerate(getters) if source is not None}
    asked = {source.other for source in getters if isinstance(source, Below)}
    values = ", ".join(_value(i, source, i in asked) for i, source in enumerate(getters))
    pack = struct.Struct(f"{len(getters)}d").pack_into
    return [f"pack(read, 0, {values})"], {"pack": pack, "read": memory.data.cast("B"), **called}


def _getter(source: Getter | Below) -> Getter:
    return source.getter if isinstance(source, Below) else source


def _value(i: int, source: Source, asked: bool) -> str:
    """Return the i-th value as it is read; one that another asks for has a name."""
    if source is None:
        return "0.0"
    if isinstance(source, Below):
        return f"0.0 if r{source.other} > {source.value!r} else g{i}()"
    return f"(r{i} := g{i}())" if asked else f"g{i}()"


def _made(lines: list[str], names: dict[str, Any], arguments: str = "") -> Any:
    """Return a function of these lines, with the names as its closure."""
    body = "\n  ".join(lines) or "pass"
    scope: dict[str, Callable[..., Any]] = {}
    exec(f"def make({', '.join(names)}):\n def made({arguments}):\n  {body}\n return made\n", scope)
    return scope["make"](**names)
