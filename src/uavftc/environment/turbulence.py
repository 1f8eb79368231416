"""Turbulence: a kind that is known by name but not available; the message says what to use instead."""

from __future__ import annotations

from typing import Any, ClassVar, Literal

import numpy as np
from pydantic import model_validator

from uavftc.config.effect import default_kind
from uavftc.config.values import Model, Problem, refusal
from uavftc.core.layout import Targets
from uavftc.environment import air

ENTRY_OF = "disturbances"
FIELD, REFUSED_ON = air.FIELD, air.REFUSED_ON


class Config(Model):
    """A kind that is known by name but not available."""

    kind: Literal["turbulence"] = "turbulence"

    refused: ClassVar[bool] = True

    @model_validator(mode="before")
    @classmethod
    def _refuse(cls, data: Any) -> Any:
        from uavftc.environment import KINDS  # noqa: PLC0415 - which this file is one of

        kinds = (kind.Config for kind in KINDS if not getattr(kind.Config, "refused", False))
        expected = f"one of {', '.join(map(default_kind, kinds))}"
        fix = 'use kind: gust, or kind: wind with an expression of t such as "2*sin(3*t) + sin(7*t)"'
        raise refusal([Problem(("kind",), "turbulence, which is not available yet", expected, fix)])


def prescribe(entry: Config, t: np.ndarray, records: np.ndarray, targets: Targets) -> None:
    """Nothing: such an entry never gets here."""
