"""The metrics of a flight by axis and name: ``metrics["pitch"].iae``."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from uavftc.analysis import metrics
from uavftc.api.tables import table

Number = float | None


class AxisMetrics(Mapping[str, Number]):
    """The metrics of one axis, by name as items and as attributes; None where one does not apply."""

    def __init__(self, axis: str, values: Mapping[str, Number]) -> None:
        self._axis, self._values = axis, dict(values)

    def __getitem__(self, name: str) -> Number:
        return self._values[name]

    def __getattr__(self, name: str) -> Number:
        if not name.startswith("_") and name in self._values:
            return self._values[name]
        raise AttributeError(f"no metric {name}; there are {', '.join(self.__dict__.get('_values', ()))}")

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *self._values]

    def __iter__(self) -> Iterator[str]:
        return iter(self._values)

    def __len__(self) -> int:
        return len(self._values)

    def __repr__(self) -> str:
        return f"{self._axis}: " + ", ".join(
            f"{name} {'-' if value is None else format(value, '.4g')}" for name, value in self._values.items()
        )


class FlightMetrics(Mapping[str, AxisMetrics]):
    """The metrics of a flight, by axis: roll, pitch, yaw."""

    def __init__(self, axes: Mapping[str, Mapping[str, Number]]) -> None:
        self._axes = {axis: AxisMetrics(axis, values) for axis, values in axes.items()}

    def __getitem__(self, axis: str) -> AxisMetrics:
        return self._axes[axis]

    def __iter__(self) -> Iterator[str]:
        return iter(self._axes)

    def __len__(self) -> int:
        return len(self._axes)

    def __repr__(self) -> str:
        return "\n".join(map(repr, self._axes.values()))

    def _repr_html_(self) -> str:
        rows = [[m.title, *(axis.get(m.name) for axis in self._axes.values())] for m in metrics.METRICS]
        return table(["", *self._axes], rows)
