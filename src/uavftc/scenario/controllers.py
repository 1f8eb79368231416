"""The `controller` section: an outer law on the attitude, an inner law on the body rates; or a module of one's own.

Defaults are the paper's (section 4); lists of three mean [phi, theta, psi] in the outer law and [roll, pitch, yaw] or
[aileron, elevator, rudder] in the inner one.
"""

from __future__ import annotations

import math
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, BeforeValidator, Discriminator, Field, Tag, model_validator
from pydantic_core import PydanticCustomError

from uavftc.config.values import (
    Matrix3,
    Model,
    NonNegative,
    Number,
    Positive,
    PositiveVector3,
    Problem,
    list_of,
    refusal,
)
from uavftc.control.inner.matrices import hurwitz, invertible, positive_definite

A_M = ((-8.5, 1.2, -3.5), (-1.5, -1.5, -1.0), (-0.02, 0.0, -2.0))  # 1/s, paper section 4
IDENTITY = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
ZEROS = ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
BOUNDS = "[lower, upper] with 0 < lower <= 1 <= upper and lower < upper"


def _bounds(value: tuple[float, float]) -> tuple[float, float]:
    """The estimate of the effectiveness starts at 1, so 1 must lie within its bounds."""
    if not 0 < value[0] <= 1 <= value[1] or value[0] == value[1]:
        raise PydanticCustomError("shape", "{wanted}", {"wanted": BOUNDS})
    return value


class Rbf(Model):
    """Radial basis network "6-5-1": five Gaussians over the six inputs [x1; x2], rad and rad/s."""

    centres: Annotated[
        tuple[Number, Number, Number, Number, Number],
        list_of(5, "a list of five numbers, one centre for each hidden node"),
    ] = (-0.2, -0.1, 0.0, 0.1, 0.2)
    width: Positive = 0.4


class NdiOuter(Model):
    """Nonlinear dynamic inversion, v1 = g1^-1 D (x1c - x1); `bandwidth` is the diagonal of D, rad/s."""

    kind: Literal["ndi"] = "ndi"
    bandwidth: PositiveVector3 = (0.5, 0.5, 0.5)


class NndoNdiOuter(Model):
    """NDI with the neural network disturbance observer, eqs. (8)-(16): `sigma` in 1/s, `gamma` the learning gain."""

    kind: Literal["nndo-ndi"] = "nndo-ndi"
    bandwidth: PositiveVector3 = (0.5, 0.5, 0.5)
    sigma: PositiveVector3 = (0.5, 0.5, 0.5)
    gamma: Positive = 0.05
    rbf: Rbf = Rbf()


class _AdaptiveInner(Model):
    """What L1 and MRAC share: state predictor and adaptive laws of eqs. (28)-(31)."""

    adaptation_gain: Positive = 1e5
    A_m: Matrix3 = A_M
    K_1: Matrix3 = IDENTITY
    Q: Matrix3 = IDENTITY
    B_m: Matrix3 | None = None
    K_0: Matrix3 = ZEROS
    effectiveness_bounds: Annotated[tuple[Number, Number], list_of(2, BOUNDS), AfterValidator(_bounds)] = (0.1, 2.0)
    weight_bound: Positive = 50.0
    offset_bound: Positive = 50.0
    reference_gain: Literal["plant", "printed"] = "plant"
    integration: Literal["implicit", "explicit"] = "implicit"
    rbf: Rbf = Rbf()

    @model_validator(mode="after")
    def _matrices(self) -> _AdaptiveInner:
        problems = [*hurwitz(self.A_m, self.K_1), *positive_definite(self.Q), *invertible(self.B_m)]
        if problems:
            raise refusal(problems)
        return self


class L1Inner(_AdaptiveInner):
    """L1 adaptive control, eqs. (28)-(35); `filter_bandwidth` in rad/s."""

    kind: Literal["l1"] = "l1"
    filter_bandwidth: Positive = 60.0


class MracInner(_AdaptiveInner):
    """Model reference adaptive control: the same predictor and laws without the low-pass filter."""

    kind: Literal["mrac"] = "mrac"


OUTER = {"ndi": NdiOuter, "nndo-ndi": NndoNdiOuter}
INNER = {"l1": L1Inner, "mrac": MracInner}
DEFAULT_OUTER, DEFAULT_INNER = "nndo-ndi", "l1"


class Controller(Model):
    """Both loops, the rate at which they run, Hz, and a delay between command and surface, s."""

    outer: Annotated[NdiOuter | NndoNdiOuter, Field(discriminator="kind")] = NndoNdiOuter()
    inner: Annotated[L1Inner | MracInner, Field(discriminator="kind")] = L1Inner()
    rate_hz: Annotated[Positive, Field(le=10_000)] = 200.0
    delay_s: NonNegative = 0.0

    @model_validator(mode="before")
    @classmethod
    def _default_kinds(cls, data: Any) -> Any:
        """A loop written without its kind has the default one."""
        if not isinstance(data, dict):
            return data
        data = {key: value for key, value in data.items() if not (key in ("outer", "inner") and value is None)}
        for part, kind in (("outer", DEFAULT_OUTER), ("inner", DEFAULT_INNER)):
            if isinstance(data.get(part), dict) and "kind" not in data[part]:
                data[part] = {"kind": kind, **data[part]}
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


class OwnController(Model):
    """A controller of one's own in the place of both loops: a module (docs/custom-controller.md) and its options."""

    kind: Annotated[str, Field(min_length=1, max_length=4096)]
    options: Annotated[dict[str, Any], BeforeValidator(lambda value: {} if value is None else value)] = Field(
        default_factory=dict
    )
    rate_hz: Annotated[Positive, Field(le=10_000)] = 200.0
    delay_s: NonNegative = 0.0

    @model_validator(mode="after")
    def _options(self) -> OwnController:
        if problems := _plain(self.options, ("options",)):
            raise refusal(problems)
        return self


def _own_or_loops(value: Any) -> str:
    own = isinstance(value, OwnController) or (isinstance(value, dict) and "kind" in value)
    return "OwnController" if own else "Controller"


AnyController = Annotated[
    Annotated[Controller, Tag("Controller")] | Annotated[OwnController, Tag("OwnController")],
    Discriminator(_own_or_loops),
]
