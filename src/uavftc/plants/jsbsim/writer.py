"""Doubles from one piece of memory into properties, without a loop (it costs 0.5 us a frame more)."""

from __future__ import annotations

import struct
from collections.abc import Callable, Sequence

import numpy as np

Setter = Callable[[float], object]


def writer(memory: np.ndarray, setters: Sequence[Sequence[Setter]]) -> Callable[[], None]:
    """Return a function that hands the i-th double of `memory` to each of `setters[i]`.

    Its body is written out for so many: ``v0, v1, ... = unpack(memory)``, then ``f0(v0)`` and so on.
    """
    if not setters:
        return lambda: None
    calls = [(f"f{i}_{j}", i, setter) for i, group in enumerate(setters) for j, setter in enumerate(group)]
    values = ", ".join(f"v{i}" for i in range(len(setters)))
    body = [f"{values}, = unpack(memory)", *(f"{name}(v{i})" for name, i, _ in calls)]
    names = ["unpack", "memory", *(name for name, _, _ in calls)]
    source = f"def make({', '.join(names)}):\n def write():\n  " + "\n  ".join(body) + "\n return write\n"
    scope: dict[str, Callable[..., Callable[[], None]]] = {}
    exec(source, scope)
    unpack = struct.Struct(f"{len(setters)}d").unpack_from
    return scope["make"](unpack, memory.data.cast("B"), *(setter for _, _, setter in calls))
