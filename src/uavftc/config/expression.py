"""Safe expressions of time, as scenario files use them: ``0.1 + 0.5*sin(t)``.

An expression knows ``t`` (s), numbers, ``+ - * / **``, parentheses, ``pi`` and the functions below, and nothing else.
The text is read once into a tree of NumPy operations; it is never evaluated as Python. Everything is float64, so
``9**9**9**9`` is infinite at once rather than an integer that fills the memory.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Callable, Collection, Mapping
from functools import reduce
from typing import Any, NamedTuple

import numpy as np

MAX_LENGTH = 1000  # characters; the longest expression of the paper has 16
MAX_DEPTH = 200  # nested operations; each costs one Python frame when sampled

FUNCTIONS: dict[str, np.ufunc] = {
    "sin": np.sin,
    "cos": np.cos,
    "tan": np.tan,
    "exp": np.exp,
    "sqrt": np.sqrt,
    "abs": np.abs,
    "min": np.minimum,
    "max": np.maximum,
    "tanh": np.tanh,
}
"""Functions of one argument; `min` and `max` take two or more."""

KNOWN = "t, pi, numbers, + - * / ** ( ) and " + " ".join(FUNCTIONS)

TOKENS = (
    r"^(?:[ \t\r\n+\-*/(),]|(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?(?![\w.])|"
    rf"(?:t|pi|{'|'.join(FUNCTIONS)})(?!\w))+$"
)
"""What an expression is made of, as a regular expression for editors; it knows nothing of their order."""

_BINARY: dict[type[ast.operator], np.ufunc] = {
    ast.Add: np.add,
    ast.Sub: np.subtract,
    ast.Mult: np.multiply,
    ast.Div: np.divide,
    ast.Pow: np.power,
}

_NUMBER = re.compile(r"(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?")
_NAME = re.compile(r"[^\W\d]\w*")
_BLANK = " \t\r\n"

Node = Callable[[Mapping[str, Any]], Any]
"""Given the values of the names, such as arrays of one shape, returns those of the expression."""


class Expression:
    """A function of time, given as text.

    Parameters
    ----------
    text
        The expression; at most `MAX_LENGTH` characters.

    Raises
    ------
    ValueError
        If the text is not an expression as described above. The message names the offending part.
    """

    __slots__ = ("_node", "text")

    def __init__(self, text: str) -> None:
        if len(text) > MAX_LENGTH:
            raise ValueError(f"the expression has {len(text)} characters, at most {MAX_LENGTH} are allowed")
        if not text.strip():
            raise ValueError("the expression is empty")
        self.text = text
        line = re.sub(f"[{_BLANK}]", " ", text).strip(" ")
        check_tokens(line)
        self._node = build(_parse(line), line, 0, ("t",))

    def __call__(self, t: np.ndarray) -> np.ndarray:
        """Return the values at the times `t`, s, as float64 of the same shape; not necessarily finite."""
        t = np.asarray(t, dtype=np.float64)
        with np.errstate(all="ignore"):
            values = self._node({"t": t})
        return np.array(np.broadcast_to(values, t.shape), dtype=np.float64)

    def __repr__(self) -> str:
        return f"Expression({self.text!r})"

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Expression) and self.text == other.text

    def __hash__(self) -> int:
        return hash(self.text)

    def __reduce__(self) -> tuple[type[Expression], tuple[str]]:  # the tree is made of closures: rebuild it
        return Expression, (self.text,)


def fail(problem: str, line: str, start: int, length: int = 1) -> ValueError:
    """Return the error with the offending part marked under the text."""
    lead, shown = max(0, start - 60), line[max(0, start - 60) : start + 60]
    return ValueError(f"{problem}\n    {shown}\n    {' ' * (start - lead)}{'^' * max(1, min(length, 60))}")


def check_tokens(line: str, names: Collection[str] | None = ("t",), marks: str = " +-*/(),") -> None:
    """Refuse, before any parsing, every character and word that is not in the language; `names` None admits any.

    Raises
    ------
    ValueError
        The message names the offending part.
    """
    position = 0
    while position < len(line):
        if line[position] in marks:
            position += 1
        elif number := _NUMBER.match(line, position):
            position = number.end()
            if not np.isfinite(float(number.group())):
                raise fail(f"the number {number.group()[:20]} is too large", line, number.start(), len(number.group()))
            if position < len(line) and (line[position] in "._" or line[position].isalnum()):
                raise fail(f"'{line[number.start() : position + 1][-20:]}' is not a number", line, position)
        elif name := _NAME.match(line, position):
            known = names is None or name.group() in (*FUNCTIONS, *names, "pi")
            if not known or not name.group().isascii():
                raise fail(f"unknown name '{name.group()[:40]}'", line, position, len(name.group()))
            position = name.end()
        else:
            raise fail(f"the character {line[position]!r} is not allowed", line, position)


def _parse(line: str) -> ast.expr:
    try:
        return ast.parse(line, mode="eval").body
    except SyntaxError as error:
        position = min(max(0, (error.offset or 1) - 1), len(line))
        raise fail(f"this is not an expression ({error.msg})", line, position) from None
    except (ValueError, MemoryError, RecursionError):
        raise ValueError("the expression is nested too deeply") from None


class Arithmetic(NamedTuple):
    """What an expression is made of: arrays, or whatever else has these operations."""

    constant: Callable[[float], Any]
    binary: Mapping[type[ast.operator], Callable[..., Any]]
    functions: Mapping[str, Callable[..., Any]]


ARRAYS = Arithmetic(lambda number: np.array(number, dtype=np.float64), _BINARY, FUNCTIONS)


def build(node: ast.expr, line: str, depth: int, names: Collection[str], of: Arithmetic = ARRAYS) -> Node:
    """Return the function of a syntax tree that may name `names`; `line` is pure ASCII, so columns are positions.

    Raises
    ------
    ValueError
        If there is something else in it. The message names the offending part.
    """
    if depth > MAX_DEPTH:
        raise ValueError(f"the expression is nested too deeply: at most {MAX_DEPTH} operations within each other")
    start, length = node.col_offset, (node.end_col_offset or 0) - node.col_offset

    match node:
        case ast.Constant(value=int() | float() as number):
            constant = of.constant(number)
            return lambda given: constant
        case ast.Name(id="pi"):
            pi = of.constant(np.pi)
            return lambda given: pi
        case ast.Name(id=name) if name in names:
            return lambda given: given[name]
        case ast.Name(id=name):
            raise fail(f"'{name}' is a function: write {name}(...)", line, start, length)
        case ast.UnaryOp(op=ast.UAdd(), operand=operand):
            return build(operand, line, depth + 1, names, of)
        case ast.UnaryOp(op=ast.USub(), operand=operand):
            inner = build(operand, line, depth + 1, names, of)
            return lambda given: -inner(given)
        case ast.BinOp(op=op, left=left, right=right) if type(op) in _BINARY:
            operation = of.binary[type(op)]
            a, b = build(left, line, depth + 1, names, of), build(right, line, depth + 1, names, of)
            return lambda given: operation(a(given), b(given))
        case ast.Call(func=ast.Name(id=name), args=args, keywords=[]) if name in FUNCTIONS:
            variadic = name in ("min", "max")
            if (len(args) < 2) if variadic else (len(args) != 1):
                expected = "two or more arguments" if variadic else "exactly one argument"
                raise fail(f"{name} takes {expected}, not {len(args)}", line, start, length)
            return _call(of.functions[name], [build(a, line, depth + 1, names, of) for a in args])
        case ast.Call(func=ast.Name(id=name)) if name not in FUNCTIONS:
            raise fail(f"'{name}' is not a function", line, start, len(name))
    raise fail(f"'{line[start : start + length][:40]}' is not allowed", line, start, length)


def _call(function: Callable[..., Any], args: list[Node]) -> Node:
    if len(args) == 1:
        argument = args[0]
        return lambda given: function(argument(given))
    return lambda given: reduce(function, [a(given) for a in args])
