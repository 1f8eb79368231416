"""What figures and messages call an entry of a scenario: short, as it was written, with its unit."""

from __future__ import annotations

from collections.abc import Mapping

from uavftc.config.values import Signal


def parts(values: Mapping[str, Signal | float], unit: str) -> str:
    """Return the components that are not zero, in their order: ``north 3, down -15 m/s``; ``0 m/s`` where all are."""
    written = {name: value.written if isinstance(value, Signal) else value for name, value in values.items()}
    said = [f"{name} {_number(value)}" for name, value in written.items() if value not in (0, "0")]
    return f"{', '.join(said) or 0} {unit}"


def each(values: tuple[float, ...], unit: str) -> str:
    """Return a vector in short: one number where all are the same, else all of them."""
    said = [_number(value) for value in (values[:1] if len(set(values)) == 1 else values)]
    return f"{', '.join(said)} {unit}".rstrip()


def _number(value: float | str) -> str:
    return value if isinstance(value, str) else f"{value:g}"
