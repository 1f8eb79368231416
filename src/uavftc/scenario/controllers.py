"""The `controller` section: an outer law on the attitude, an inner law on the body rates; or a custom module.

The kinds are those of `control.outer.KINDS` and `control.inner.KINDS`, each with its `Config`. Defaults are the
paper's (section 4); lists of three mean [phi, theta, psi] in the outer law and [roll, pitch, yaw] or [aileron,
elevator, rudder] in the inner one.
"""

from __future__ import annotations

import math
from functools import reduce
from operator import or_
from typing import Annotated, Any, ClassVar

from pydantic import BeforeValidator, Discriminator, Field, Tag, WithJsonSchema, model_validator

from uavftc.actuators import CHAIN
from uavftc.config.effect import configs, default_kind
from uavftc.config.values import Model, Number, Problem, refusal
from uavftc.control import inner, outer

LOOPS = {"outer": outer, "inner": inner}
"""The two loops by their key in a scenario; each has `KINDS` and a `DEFAULT`."""


Rate = Annotated[Number, Field(ge=1, le=10_000)]
"""Controller steps a second; below 1 a sample would hide hundreds of plant steps."""


def kinds(loop: str) -> dict[str, Any]:
    """Return the laws of a loop by their kind."""
    return {default_kind(law.Config): law for law in LOOPS[loop].KINDS}


def spelling(outer_kind: str, inner_kind: str) -> str:
    """Return the name of a pair of kinds: nndo-ndi and l1 are ``nndondi-l1``."""
    return f"{outer_kind.replace('-', '')}-{inner_kind}"


CONTROLLERS = {spelling(o, i): (o, i) for o in kinds("outer") for i in kinds("inner")}
"""Controller names as `--controller` takes them, with the kinds of the outer and inner loop."""


def _any_of(loop: str) -> Any:
    """Return the type of any of a loop's sections; without a kind it is the default one's."""
    return reduce(or_, [law.Config for law in LOOPS[loop].KINDS])


_LOOP_KEYS = tuple(reversed(configs(CHAIN, "KEYS_IN", "controller")))


class _Loops(Model):
    outer: Annotated[_any_of("outer"), Field(discriminator="kind")] = outer.DEFAULT.Config()  # type: ignore[valid-type]
    """law on the attitude"""
    inner: Annotated[_any_of("inner"), Field(discriminator="kind")] = inner.DEFAULT.Config()  # type: ignore[valid-type]
    """law on the body rates"""
    rate_hz: Rate = 200.0
    """rate at which both run, 1 to 10000"""


class Controller(*_LOOP_KEYS, _Loops):  # type: ignore[misc]
    """Both loops, the rate at which they run, Hz, and what lies between a command and a surface."""

    remedies: ClassVar[dict[str, str]] = {
        "options": "remove it, or name the module of your custom controller with kind (docs/custom-controller.md)"
    }

    @model_validator(mode="before")
    @classmethod
    def _default_kinds(cls, data: Any) -> Any:
        """A loop written without its kind has the default one."""
        if not isinstance(data, dict):
            return data
        data = {key: value for key, value in data.items() if not (key in LOOPS and value is None)}
        for part, loop in LOOPS.items():
            if isinstance(data.get(part), dict) and "kind" not in data[part]:
                data[part] = {"kind": default_kind(loop.DEFAULT.Config), **data[part]}
        return data


def _plain(value: Any, key: tuple[str | int, ...]) -> list[Problem]:
    """Return what of an option cannot be written to a file and read back the same."""
    if isinstance(value, dict):
        return [problem for name, item in value.items() for problem in _plain(item, (*key, name))]
    if isinstance(value, list | tuple):
        return [problem for i, item in enumerate(value) for problem in _plain(item, (*key, i))]
    if value is None or isinstance(value, bool | str):
        return []
    if isinstance(value, int) and abs(value) < 2**63:
        return []
    if isinstance(value, float) and math.isfinite(value):
        return []
    expected = "a finite number, whole ones within 64 bits, a text, true, false, null, a list or a map"
    return [Problem(key, str(value)[:40], expected, "write it as one of these, such as a text")]


class _Module(Model):
    kind: Annotated[str, Field(min_length=1, max_length=4096)]
    """`pid` or `lqi`, which are shipped; the path of a `.py` file; `my_package.my_module`; or the name of an entry
    point"""
    options: Annotated[
        dict[str, Any],
        BeforeValidator(lambda value: {} if value is None else value),
        WithJsonSchema({"type": ["object", "null"]}),
    ] = Field(default_factory=dict)
    """handed to the module: finite numbers, texts, `true`, `false`, `null`, lists and maps"""
    rate_hz: Rate = 200.0
    """rate at which it runs, 1 to 10000"""
    timeout_s: Annotated[Number, Field(ge=0.001, le=86_400)] = 10.0
    """longest time that one step in plain Python may take, wall-clock, 0.001 to 86400; a longer step ends the flight,
    also one that blocks (on the main thread of Linux and macOS; elsewhere, and in calls into compiled code, the time is
    checked after the step returns); compiled controllers have no limit"""


class CustomController(*_LOOP_KEYS, _Module):  # type: ignore[misc]
    """A custom controller in place of both loops: a module (docs/custom-controller.md) and its options."""

    remedies: ClassVar[dict[str, str]] = dict.fromkeys(
        LOOPS, "remove it: a controller with a kind takes the place of both loops (as --controller does)"
    )

    @model_validator(mode="after")
    def _options(self) -> CustomController:
        if problems := _plain(self.options, ("options",)):
            raise refusal(problems)
        return self


def _custom_or_loops(value: Any) -> str:
    custom = isinstance(value, CustomController) or (isinstance(value, dict) and "kind" in value)
    return "CustomController" if custom else "Controller"


AnyController = Annotated[
    Annotated[Controller, Tag("Controller")] | Annotated[CustomController, Tag("CustomController")],
    Discriminator(_custom_or_loops),
]
