"""Formulas over named signals, as a requirement has them: ``abs(phi_error_deg) <= 1 and load_factor <= 3.8``.

A formula is made of comparisons of expressions (`expression.py`, with the names of signals next to `t`), joined by
`not`, `and`, `or` and `implies`, which bind in this order, the first the closest; ``a implies b implies c`` is
``a implies (b implies c)``, and ``-1 <= a <= 2`` is both comparisons. Its robustness is a number at each sample:

    value <= limit    (limit - value) / scale        not a          - a
    value >= limit    (value - limit) / scale        a and b        min(a, b)
                                                     a or b         max(a, b)
                                                     a implies b    max(-a, b)

after A. Donze and O. Maler, "Robust satisfaction of temporal logic over real-valued signals", FORMATS 2010. It is above
0 where the formula holds, below 0 where it does not, 0 at the limit. `<` is as `<=`. The scale is |limit|, or one for
the whole formula. What is not a number counts as broken without bound.
"""

from __future__ import annotations

import ast
import keyword
import re
from collections.abc import Callable, Collection, Mapping
from functools import lru_cache, reduce
from typing import Any

import numpy as np
from pydantic import GetCoreSchemaHandler, GetJsonSchemaHandler
from pydantic_core import CoreSchema, PydanticCustomError, core_schema

from uavftc.config.expression import (
    ARRAYS,
    FUNCTIONS,
    MAX_DEPTH,
    MAX_LENGTH,
    Arithmetic,
    build,
    check_tokens,
    fail,
)

WORDS = ("and", "or", "not", "implies")
KNOWN = (
    f"names of the history's columns, numbers, + - * / ** ( ), {' '.join(FUNCTIONS)}, <= >= < >, and {' '.join(WORDS)}"
)
_IMPLIES = "if 0 else"  # Python's operator that binds least, and to the right

_Values = Mapping[str, Any]
_Robustness = Callable[[_Values, "float | None"], Any]


class Formula:
    """A formula, given as text.

    Parameters
    ----------
    text
        At most `expression.MAX_LENGTH` characters.

    Raises
    ------
    ValueError
        If the text is not a formula as described above. The message names the offending part.
    """

    __slots__ = ("_node", "names", "text", "unscaled")

    names: tuple[str, ...]
    """Signals in it, in the order of the text."""
    unscaled: str | None
    """The first comparison that has no scale: its limit is 0, or both of its sides change; None where all have one."""

    def __init__(self, text: str) -> None:
        if len(text) > MAX_LENGTH:
            raise ValueError(f"the formula has {len(text)} characters, at most {MAX_LENGTH} are allowed")
        if not text.strip():
            raise ValueError("the formula is empty")
        self.text = text
        line = _blanks(text)
        check_tokens(line, None, " +-*/(),<>=")
        for word in re.finditer(r"[^\W\d]\w*", line):
            if keyword.iskeyword(word.group()) and word.group() not in WORDS:
                raise fail(f"the word '{word.group()}' is not allowed", line, word.start(), len(word.group()))
        tree = _parse(line)
        calls = {id(node.func) for node in ast.walk(tree) if isinstance(node, ast.Call)}
        found = sorted(
            (node.col_offset, node.id)
            for node in ast.walk(tree)
            if isinstance(node, ast.Name) and id(node) not in calls
        )
        self.names = tuple(dict.fromkeys(name for _, name in found if name not in (*FUNCTIONS, "pi")))
        self.unscaled = None
        self._node = self._formula(tree, line, 0)

    def robustness(self, values: Mapping[str, np.ndarray], scale: float | None = None) -> np.ndarray:
        """Return the robustness at each sample.

        Parameters
        ----------
        values
            Of each name, shape (n,), as the formula counts it.
        scale
            Of every comparison; None is |limit| of each.

        Returns
        -------
        Shape (n,); -inf where it is not a number.
        """
        with np.errstate(all="ignore"):
            found = self._node(values, scale)
            if np.isnan(np.min(found, initial=np.inf)):
                found = np.where(np.isnan(found), -np.inf, found)
        return found

    def made_of(self, of: Arithmetic) -> _Robustness:
        """Return its robustness over values of another arithmetic, given by name, and a scale."""
        line = _blanks(self.text)
        return self._formula(_parse(line), line, 0, of)

    def __repr__(self) -> str:
        return f"Formula({self.text!r})"

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Formula) and self.text == other.text

    def __hash__(self) -> int:
        return hash(self.text)

    def __reduce__(self) -> tuple[type[Formula], tuple[str]]:  # the tree is made of closures: rebuild it
        return Formula, (self.text,)

    def _formula(self, node: ast.expr, line: str, depth: int, of: Arithmetic = ARRAYS) -> _Robustness:
        if depth > MAX_DEPTH:
            raise ValueError(f"the formula is nested too deeply: at most {MAX_DEPTH} operations within each other")
        match node:
            case ast.IfExp(body=left, orelse=right):
                a, b = self._formula(left, line, depth + 1, of), self._formula(right, line, depth + 1, of)
                most = of.functions["max"]
                return lambda values, scale: most(-a(values, scale), b(values, scale))
            case ast.BoolOp(op=op, values=parts):
                joined = of.functions["min" if isinstance(op, ast.And) else "max"]
                nodes = [self._formula(part, line, depth + 1, of) for part in parts]
                return lambda values, scale: reduce(joined, [n(values, scale) for n in nodes])
            case ast.UnaryOp(op=ast.Not(), operand=operand):
                inner = self._formula(operand, line, depth + 1, of)
                return lambda values, scale: -inner(values, scale)
            case ast.Compare(left=left, ops=ops, comparators=others):
                sides = [left, *others]
                pairs = zip(sides, ops, sides[1:], strict=False)
                found = [self._comparison(a, op, b, line, depth + 1, of) for a, op, b in pairs]
                least = of.functions["min"]
                return lambda values, scale: reduce(least, [n(values, scale) for n in found])
        start, length = node.col_offset, (node.end_col_offset or 0) - node.col_offset
        raise fail("this has no <= or >=, so nothing says when it holds", line, start, length)

    def _comparison(
        self, left: ast.expr, op: ast.cmpop, right: ast.expr, line: str, depth: int, of: Arithmetic
    ) -> _Robustness:
        if not isinstance(op, ast.LtE | ast.GtE | ast.Lt | ast.Gt):
            raise fail("only <=, >=, < and > can be here", line, left.end_col_offset or 0, 2)
        less, greater = (left, right) if isinstance(op, ast.LtE | ast.Lt) else (right, left)
        low, high = build(less, line, depth, self.names, of), build(greater, line, depth, self.names, of)
        limits = [side for side in (less, greater) if not _changes(side)]
        if len(limits) == 2:
            start, length = left.col_offset, (right.end_col_offset or 0) - left.col_offset
            raise fail("no signal is in this comparison", line, start, length)
        limit = None
        if limits:
            with np.errstate(all="ignore"):
                limit = abs(float((low if limits[0] is less else high)({})))
            if not np.isfinite(limit):
                raise fail("this limit is not a finite number", line, limits[0].col_offset)
        if not limit and self.unscaled is None:
            self.unscaled = line[left.col_offset : right.end_col_offset]
        return lambda values, scale: (high(values) - low(values)) / (scale or limit or np.nan)

    @classmethod
    def __get_pydantic_core_schema__(cls, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        return core_schema.no_info_plain_validator_function(
            cls._validate, serialization=core_schema.plain_serializer_function_ser_schema(lambda s: s.text)
        )

    @classmethod
    def __get_pydantic_json_schema__(cls, schema: CoreSchema, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        return {"type": "string", "description": f"formula: {KNOWN}"}

    @classmethod
    def _validate(cls, value: object) -> Formula:
        if isinstance(value, Formula):
            return value
        if not isinstance(value, str):
            raise PydanticCustomError("formula", "{problem}", {"problem": "this is not a formula"})
        try:
            return formula_of(value)
        except ValueError as error:
            raise PydanticCustomError("formula", "{problem}", {"problem": str(error)}) from None


def _blanks(text: str) -> str:
    """Return a text on one line."""
    return re.sub(r"[ \t\r\n]", " ", text).strip(" ")


@lru_cache(maxsize=1000)
def formula_of(text: str) -> Formula:
    """Return `Formula(text)`, read once however many scenarios have it."""
    return Formula(text)


def _changes(node: ast.expr) -> bool:
    names = [n.id for n in ast.walk(node) if isinstance(n, ast.Name)]
    return bool(_signals(names))


def _signals(names: Collection[str]) -> list[str]:
    return [name for name in names if name not in FUNCTIONS and name != "pi"]


def _parse(line: str) -> ast.expr:
    """Return the syntax tree, its columns those of `line`; an `IfExp` is an implication."""
    text, at = "", []  # the text that Python reads, and the column in `line` of each of its characters
    for part in re.finditer(r"\bimplies\b|.", line):
        new = _IMPLIES if part.group() == "implies" else part.group()
        text += new
        at += [part.start()] * len(new)
    at.append(len(line))
    try:
        tree = ast.parse(text, mode="eval").body
    except SyntaxError as error:
        position = at[min(max(0, (error.offset or 1) - 1), len(text))]
        message = "" if "if" in error.msg else f" ({error.msg})"
        raise fail(f"this is not a formula{message}", line, position) from None
    except (ValueError, MemoryError, RecursionError):
        raise ValueError("the formula is nested too deeply") from None
    for node in ast.walk(tree):
        if isinstance(node, ast.expr):
            node.col_offset = at[node.col_offset]
            last = (node.end_col_offset or 1) - 1
            node.end_col_offset = at[last] + 1
    return tree
