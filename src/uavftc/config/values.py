"""The kinds of value a scenario file holds: numbers, lists of three, matrices, signals of t.

Numbers are finite floats; a boolean or a text is not a number. Units are those of the key's suffix.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Annotated, Any, ClassVar, NamedTuple

import numpy as np
from pydantic import (
    AfterValidator,
    AllowInfNan,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    GetCoreSchemaHandler,
    GetJsonSchemaHandler,
    Strict,
    ValidationInfo,
    WithJsonSchema,
    field_validator,
)
from pydantic_core import CoreSchema, PydanticCustomError, PydanticKnownError, core_schema

from uavftc.config.expression import KNOWN, MAX_LENGTH, TOKENS, Expression


class Model(BaseModel):
    """Base of every section: immutable, unknown keys are errors."""

    model_config = ConfigDict(frozen=True, extra="forbid", arbitrary_types_allowed=True)

    remedies: ClassVar[dict[str, str]] = {}
    """What to do about a key that a user may write here and that does not belong here, by its name."""


class Problem(NamedTuple):
    """One error in a scenario that concerns several keys: where it is reported, and the three things a user needs."""

    key: tuple[str | int, ...]
    found: str
    expected: str
    remedy: str


def refusal(problems: list[Problem]) -> PydanticCustomError:
    """Return the validation error that carries `problems`, with keys relative to the section that raises it."""
    text = "; ".join(f"{key_text(p.key)}: found {p.found}, expected {p.expected}" for p in problems)
    return PydanticCustomError("problems", "{text}", {"text": text, "problems": problems})


def key_text(key: tuple[str | int, ...]) -> str:
    """Return a key path as a user writes it: ``faults[0].effectiveness``."""
    text = ""
    for part in key:
        name = part if isinstance(part, int) or (part.isprintable() and len(part) <= 60) else repr(part[:60])
        text += f"[{name}]" if isinstance(part, int) else f".{name}" if text else str(name)
    return text


def is_number(value: object) -> bool:
    """Return whether `value` is a number in a scenario; True and False are not."""
    return isinstance(value, int | float) and not isinstance(value, bool)


Number = Annotated[float, Strict(), AllowInfNan(False)]
Positive = Annotated[Number, Field(gt=0)]
NonNegative = Annotated[Number, Field(ge=0)]
Whole = Annotated[int, Strict()]
Flag = Annotated[bool, Strict()]


def three(value: Any) -> Any:
    """Broadcast a number to [roll, pitch, yaw]; refuse anything that is not a list of three."""
    if is_number(value):
        return (value,) * 3
    if not isinstance(value, list | tuple) or len(value) != 3:
        raise PydanticCustomError(
            "shape", "{expected}", {"expected": "a number, or a list of three: [roll, pitch, yaw]"}
        )
    return tuple(value)


def list_of(n: int, expected: str) -> BeforeValidator:
    """Return the validator that admits only a list of `n`; the message says what is `expected`."""

    def check(value: Any) -> Any:
        if not isinstance(value, list | tuple) or len(value) != n:
            raise PydanticCustomError("shape", "{expected}", {"expected": expected})
        return tuple(value)

    return BeforeValidator(check)


def _matrix(value: Any) -> Any:
    rows = value if isinstance(value, list | tuple) else ()
    if len(rows) != 3 or any(not isinstance(row, list | tuple) or len(row) != 3 for row in rows):
        expected = "a 3x3 matrix: a list of three rows of three numbers"
        raise PydanticCustomError("shape", "{expected}", {"expected": expected})
    return tuple(tuple(row) for row in rows)


def three_schema(item: dict[str, Any]) -> WithJsonSchema:
    """Return the JSON Schema of what `three` admits, each number as `item` says."""
    return WithJsonSchema({"anyOf": [item, {"type": "array", "items": item, "minItems": 3, "maxItems": 3}]})


Vector3 = Annotated[tuple[Number, Number, Number], BeforeValidator(three), three_schema({"type": "number"})]
PositiveVector3 = Annotated[
    tuple[Positive, Positive, Positive],
    BeforeValidator(three),
    three_schema({"type": "number", "exclusiveMinimum": 0}),
]
NonNegativeVector3 = Annotated[
    tuple[NonNegative, NonNegative, NonNegative],
    BeforeValidator(three),
    three_schema({"type": "number", "minimum": 0}),
]
_Row = tuple[Number, Number, Number]
Matrix3 = Annotated[tuple[_Row, _Row, _Row], BeforeValidator(_matrix)]


@dataclass(frozen=True, slots=True)
class Signal:
    """A number, or an expression of t read once; unit as the key that holds it."""

    value: float | Expression

    @property
    def constant(self) -> float | None:
        """The number, or None for an expression."""
        return None if isinstance(self.value, Expression) else self.value

    @property
    def text(self) -> str:
        """The number in short, or the expression, as a message shows it."""
        return self.value.text if isinstance(self.value, Expression) else f"{self.value:g}"

    @property
    def written(self) -> float | str:
        """The number or the text as the file has it."""
        return self.value.text if isinstance(self.value, Expression) else self.value

    def sample(self, t: np.ndarray) -> np.ndarray:
        """Return the values at the times `t`, s, same shape, float64."""
        t = np.asarray(t, dtype=np.float64)
        return self.value(t) if isinstance(self.value, Expression) else np.full(t.shape, self.value)

    @classmethod
    def of(cls, value: object) -> Signal:
        """Return the signal of a number or a text.

        Raises
        ------
        ValueError
            For anything else, a number that is not finite, or a text that is not an expression.
        """
        if isinstance(value, Signal):
            return value
        if isinstance(value, str):
            return cls(Expression(value))
        if not is_number(value):
            raise ValueError("this is neither a number nor an expression of t")
        try:
            number = float(value)  # type: ignore[arg-type]
        except OverflowError:
            number = np.inf
        if not np.isfinite(number):
            raise ValueError("the number is not finite")
        return cls(number)

    @classmethod
    def __get_pydantic_core_schema__(cls, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        return core_schema.no_info_plain_validator_function(
            cls._validate, serialization=core_schema.plain_serializer_function_ser_schema(lambda s: s.written)
        )

    @classmethod
    def __get_pydantic_json_schema__(cls, schema: CoreSchema, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        text = {"type": "string", "pattern": TOKENS, "maxLength": MAX_LENGTH, "description": f"expression: {KNOWN}"}
        return {"anyOf": [{"type": "number"}, text]}

    @classmethod
    def _validate(cls, value: object) -> Signal:
        try:
            return cls.of(value)
        except ValueError as error:
            raise PydanticCustomError("signal", "{problem}", {"problem": str(error)}) from None


ZERO = Signal(0.0)


def _surface(name: str) -> str:
    if len(name) > 60 or re.fullmatch(r"[A-Za-z][A-Za-z0-9_]*", name) is None:
        raise PydanticCustomError("name", "the name of a surface: letters, digits and _, beginning with a letter")
    return name


SurfaceName = Annotated[
    str,
    Strict(),
    AfterValidator(_surface),
    WithJsonSchema({"type": "string", "pattern": "^[A-Za-z][A-Za-z0-9_]*$", "maxLength": 60}),
]
"""An effector of the aircraft, or the gang of an axis; which there are is known when the flight is built."""


def own_section(value: Any) -> Any:
    """Admit a section, or null, under a name that is not a key; a number or a text there is an unknown key."""
    if value is None or isinstance(value, dict | BaseModel):
        return value
    raise PydanticKnownError("extra_forbidden")


class AtLeast(NamedTuple):
    """Annotates a signal that may not fall below a value: what is expected then, and how to fix it."""

    low: float
    expected: str
    remedy: str


class Window(Model):
    """Something that acts on [start_s, end_s), s; `end_s` null means till the end of the flight."""

    start_s: NonNegative = 0.0
    """beginning of the window"""
    end_s: Number | None = None
    """end of the window, which does not belong to it; `null` is the end of the flight"""

    @field_validator("end_s")
    @classmethod
    def _after_start(cls, end_s: float | None, info: ValidationInfo) -> float | None:
        start_s = info.data.get("start_s")
        if end_s is not None and start_s is not None and end_s <= start_s:
            raise PydanticCustomError("window", "after start_s, {start_s} s", {"start_s": f"{start_s:g}"})
        return end_s


def window_of(entry: Any, t: np.ndarray) -> slice:
    """Return which of the times t, s, rising, lie in [start_s, end_s) of an entry."""
    end = np.inf if entry.end_s is None else entry.end_s
    return slice(int(np.searchsorted(t, entry.start_s)), int(np.searchsorted(t, end)))
