"""The curves of one flight on its page: attitude, rates, effectors, air and way, estimates, a controller's own."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping

import numpy as np

from uavftc.core.signals import ANGLES, AXES, RATES, SURFACES
from uavftc.report.page.packed import Curve, Group, Panel
from uavftc.report.series import column, deg, wound_up
from uavftc.results.context import FigureContext

History = Mapping[str, np.ndarray]
TURN = 360.0
IDLE_DEGPS = 1e-3  # an observer whose estimate stays below is idle


def groups_of(history: History, context: FigureContext) -> list[Group]:
    """Return the groups of panels of a flight, without those that have nothing in them.

    Parameters
    ----------
    history
        Published columns, name to shape (n,), SI and rad, NaN where there is none.
    context
        Limits, effectors, windows, own signals; a twin is drawn where it is sampled at the same times.
    """
    flight = _Flight(history, context)
    found = [
        Group("attitude", "Attitude", list(flight.attitude())),
        Group("effectors", "Effectors", list(flight.effectors())),
        Group("rates", "Body rates", list(flight.rates())),
        Group("engines", "Engines", list(flight.engines())),
        Group("air", "Air and way", list(flight.air())),
        Group("estimates", "Estimates", list(flight.estimates())),
        Group("own", "The controller's own signals", list(flight.own())),
    ]
    return [group for group in found if group.panels]


def others_of(history: History, context: FigureContext) -> list[str]:
    """Return the effectors in a history that are not the one surface of an axis, in their order."""
    own = {name for signal in context.signals for name in signal.columns}
    named = (name.removesuffix("_cmd_rad") for name in history if name.endswith("_cmd_rad") and name not in own)
    return [name for name in named if name not in SURFACES]


class _Flight:
    """What makes the panels of a flight."""

    def __init__(self, history: History, context: FigureContext) -> None:
        self._history, self._context = history, context
        self._n = len(history["time_s"])

    def attitude(self) -> Iterator[Panel]:
        for i, angle in enumerate(ANGLES):
            controlled = self._context.controlled[i]
            turn = TURN if angle == "psi" and controlled else None

            def read(history: History, angle: str = angle, controlled: bool = controlled) -> np.ndarray:
                values = deg(history, f"{angle}_rad")
                return values if controlled else np.unwrap(values, period=TURN)

            curves = self._with_twin(read, turn)
            if controlled:
                curves += self._measured(f"{angle}_meas_rad", turn)
                curves.append(Curve("reference", "reference", deg(self._history, f"{angle}_ref_rad")))
            title = f"{AXES[i]} angle" + ("" if controlled else ", not controlled")
            yield self._panel(title, "deg", curves, angle, least=0.5)

    def rates(self) -> Iterator[Panel]:
        for i, rate in enumerate(RATES):
            curves = self._with_twin(_deg(f"{rate}_radps"))
            curves += self._measured(f"{rate}_meas_radps")
            if self._context.controlled[i]:
                curves.append(Curve("commanded", "reference", deg(self._history, f"{rate}_ref_radps")))
            yield self._panel(f"{AXES[i]} rate", "deg/s", curves, rate, least=0.2)

    def effectors(self) -> Iterator[Panel]:
        for i, surface in enumerate(SURFACES):
            if self._context.controlled[i]:
                yield self._effector(surface)
        for name in others_of(self._history, self._context):
            yield self._effector(name)

    def engines(self) -> Iterator[Panel]:
        engines = [name.removesuffix("_thrust_n") for name in self._history if name.endswith("_thrust_n")]
        for part, unit, scale in (("throttle", "-", 0.1), ("thrust_n", "N", 10.0)):
            curves = [
                Curve(name.replace("_", " "), f"several{k % 6}", column(self._history, f"{name}_{part}"))
                for k, name in enumerate(engines)
            ]
            if curves:
                yield self._panel(part.removesuffix("_n"), unit, curves, "throttle", least=scale)

    def _effector(self, name: str) -> Panel:
        commanded = deg(self._history, f"{name}_cmd_rad")
        reached = self._with_twin(_deg(f"{name}_rad"), name="reached", look="deflection")
        curves = [Curve("command", "command", commanded), *reached]
        if f"{name}_servo_rad" in self._history:
            curves.append(Curve("servo", "measured", deg(self._history, f"{name}_servo_rad")))
        bounds = [float(np.rad2deg(v)) for v in self._context.limits_rad.get(name) or () if np.isfinite(v)]
        drawn = [curve.y for curve in reached]
        shown = [*wound_up(commanded, drawn, bounds), *drawn]
        title = name.replace("_", " ")
        if name in SURFACES:
            title += ", about trim"
        return self._panel(title, "deg", curves, name, least=0.2, limits=bounds, shown=shown)

    def air(self) -> Iterator[Panel]:
        if not np.isfinite(column(self._history, "airspeed_mps")).any():
            return
        for name, unit, least in (("airspeed", "m/s", 1.0), ("altitude", "m", 2.0)):
            curves = self._with_twin(_plain(f"{name}_{unit.replace('/', 'p')}"))
            yield self._panel(name, unit, curves, name, least=least)
        for name, title in (("alpha", "angle of attack α"), ("beta", "sideslip β")):
            yield self._panel(title, "deg", self._with_twin(_deg(f"{name}_rad")), name, least=0.5)
        if "load_factor" in self._history:
            yield self._panel("load factor", "g", self._with_twin(_plain("load_factor")), "altitude", least=0.2)
        if not any(name.endswith("_thrust_n") for name in self._history):
            yield self._panel("throttle", "-", self._with_twin(_plain("throttle")), "throttle", least=0.1)
        if "air" in self._context.has:
            parts = [
                Curve(part, f"several{k}", column(self._history, f"wind_{part}_mps"))
                for k, part in enumerate(("north", "east", "down"))
            ]
            yield self._panel("wind", "m/s", parts, "wind", least=0.5)
            parts = [
                Curve(AXES[k], f"several{k}", deg(self._history, f"{rate}_gust_radps")) for k, rate in enumerate(RATES)
            ]
            yield self._panel("rotation of the air", "deg/s", parts, "wind", least=0.5)

    def estimates(self) -> Iterator[Panel]:
        outer = [
            (f"d1_hat_{angle}_radps", f"d1_{angle}_radps", f"d1_{angle}", f"outer loop, {axis}")
            for angle, axis in zip(ANGLES, AXES, strict=True)
        ]
        inner = [
            (f"f_hat_{rate}_radps2", f"d2_{rate}_radps2", f"f_{rate}", f"inner loop, {axis}")
            for rate, axis in zip(RATES, AXES, strict=True)
        ]
        for kind, unit, least in ((outer, "deg/s", 0.1), (inner, "deg/s²", 1.0)):
            for estimate, truth, concerns, title in kind:
                estimated = deg(self._history, estimate)
                if not np.isfinite(estimated).any():
                    continue
                remark = ""
                if kind is outer and float(np.nanmax(np.abs(estimated))) < IDLE_DEGPS:
                    remark = "observer idle"
                curves = [
                    Curve("estimate", "estimate", estimated),
                    Curve("true disturbance", "reference", deg(self._history, truth)),
                ]
                yield self._panel(title, unit, curves, concerns, least=least, remark=remark)
        for i, surface in enumerate(SURFACES):
            effect = column(self._history, f"effectiveness_{surface}")
            if self._context.controlled[i] and np.any(effect[np.isfinite(effect)] != 1.0):
                curves = [Curve("true effectiveness", "truth", effect)]
                shown = [effect, np.array([0.0, 1.0])]
                yield self._panel(f"effectiveness of the {surface}", "-", curves, surface, least=1.0, shown=shown)

    def own(self) -> Iterator[Panel]:
        for signal in self._context.signals:
            labels = signal.labels or (signal.name,)
            curves = [
                Curve(label, f"several{k % 6}", column(self._history, name))
                for k, (label, name) in enumerate(zip(labels, signal.columns, strict=True))
            ]
            unit = "-" if signal.unit == "1" else signal.unit
            yield self._panel(signal.name, unit, curves, least=0.0)

    def _with_twin(
        self, read: Callable[[History], np.ndarray], turn: float | None = None, name: str = "actual", look: str = ""
    ) -> list[Curve]:
        curves = [Curve(name, look or "actual", read(self._history), turn)]
        twin = self._context.twin
        if twin is not None:
            values = read(twin)[: self._n]
            padded = np.concatenate([values, np.full(self._n - len(values), np.nan)])
            curves.insert(0, Curve("without faults", "twin", padded, turn))
        return curves

    def _measured(self, name: str, turn: float | None = None) -> list[Curve]:
        if "sensor" not in self._context.has or name not in self._history:
            return []
        return [Curve("as measured", "measured", deg(self._history, name), turn)]

    def _panel(
        self,
        title: str,
        unit: str,
        curves: list[Curve],
        *concerns: str,
        least: float,
        limits: list[float] | None = None,
        shown: list[np.ndarray] | None = None,
        remark: str = "",
    ) -> Panel:
        numbers = [number for number, _ in self._context.concerning(*concerns)]
        return Panel(title, unit, curves, numbers, limits or (), least, shown, remark)


def _plain(name: str) -> Callable[[History], np.ndarray]:
    return lambda history: column(history, name)


def _deg(name: str) -> Callable[[History], np.ndarray]:
    return lambda history: deg(history, name)
