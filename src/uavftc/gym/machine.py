"""A stack machine for the margins of a sample: formulas as code that one compiled function runs on rows.

A formula is evaluated once with `Code` in place of numbers (`Formula.made_of`); what comes out is its own arithmetic as
instructions. So there is one reading of formulas, and nothing is compiled for a new one.
"""

from __future__ import annotations

import ast
import functools
import operator
from collections.abc import Callable
from math import nan, pi
from typing import Any, NamedTuple

import numba
import numpy as np
from numba import types

from uavftc.config.expression import Arithmetic
from uavftc.core.compile_cache import compile_cache
from uavftc.core.stage import COMPILED

CONST, ROW, HEADING, GROW, NEGATE, ABS, SIN, COS, TAN, EXP, SQRT, TANH, ADD, SUB, MUL, DIV, POW, MIN, MAX, ASK = range(
    20
)
"""Instructions, each with two numbers: the constant; the place in a row; places of a heading and its reference; place
of a memory and factor, of what grows; none of operations; first and last sample of a requirement."""

DEPTH = 256
"""Numbers on the stack at most; a formula has at most 1000 characters."""
GROWS, LAST, LEAST, GREATEST, SUM, NEXT, RING = range(7)
"""In a memory of what grows: rows of its window, the value before, limits (nan: it travels), sum, place, sums."""


class Code(NamedTuple):
    """Instructions that leave one number on the stack."""

    steps: tuple[tuple[float, float, float], ...]

    def then(self, op: int, other: Code | None = None) -> Code:
        """Return it, another behind it, and the operation on both."""
        return Code((*self.steps, *(other.steps if other is not None else ()), (op, 0.0, 0.0)))

    def __add__(self, other: Any) -> Code:
        return self.then(ADD, code(other))

    def __sub__(self, other: Any) -> Code:
        return self.then(SUB, code(other))

    def __mul__(self, other: Any) -> Code:
        return self.then(MUL, code(other))

    def __truediv__(self, other: Any) -> Code:
        return self.then(DIV, code(other))

    def __pow__(self, other: Any) -> Code:
        return self.then(POW, code(other))

    def __neg__(self) -> Code:
        return self.then(NEGATE)

    def __abs__(self) -> Code:
        return self.then(ABS)

    def __float__(self) -> float:
        """Return the value of a constant."""
        stack = np.zeros(DEPTH)
        table = np.array([*self.steps, (ASK, -1.0, 1.0)])
        with np.errstate(all="ignore"):
            return _evaluate(table, 0, len(self.steps), np.zeros(0), np.zeros(0), stack)


def code(value: Any) -> Code:
    """Return a number as code, and code as it is."""
    return value if isinstance(value, Code) else Code(((CONST, float(value), 0.0),))


def _unary(op: int) -> Callable[[Code], Code]:
    return lambda a: a.then(op)


def _binary(op: int) -> Callable[[Code, Code], Code]:
    return lambda a, b: a.then(op, code(b))


SYMBOLS = Arithmetic(
    code,
    {
        ast.Add: operator.add,
        ast.Sub: operator.sub,
        ast.Mult: operator.mul,
        ast.Div: operator.truediv,
        ast.Pow: operator.pow,
    },
    {
        **{"sin": _unary(SIN), "cos": _unary(COS), "tan": _unary(TAN), "exp": _unary(EXP), "sqrt": _unary(SQRT)},
        **{"abs": abs, "tanh": _unary(TANH), "min": _binary(MIN), "max": _binary(MAX)},
    },
)
"""The arithmetic of code."""


@numba.njit(error_model="numpy")
def _grown(memory, at, value, factor):
    """Return what a sum has grown by over its window, `derived.Behind` number by number, and keep it."""
    n = int(memory[at + GROWS])
    if not np.isnan(memory[at + LEAST]):  # limits: whether it is at one
        more = 1.0 if value <= memory[at + LEAST] or value >= memory[at + GREATEST] else 0.0
    else:
        last = memory[at + LAST]
        more = 0.0 if np.isnan(last) else abs(value - last)
    memory[at + LAST] = value
    total = memory[at + SUM] + more
    place = at + RING + int(memory[at + NEXT])
    behind, memory[place] = memory[place], total
    memory[at + SUM] = total
    memory[at + NEXT] = (memory[at + NEXT] + 1.0) % n
    return factor * (total - behind)


@numba.njit(error_model="numpy")
def _evaluate(table, first, last, row, memory, stack):
    """Return the number that instructions first to last - 1 leave."""
    top = -1
    for i in range(first, last):
        op, a, b = int(table[i, 0]), table[i, 1], table[i, 2]
        if op <= HEADING:
            top += 1
            if op == CONST:
                stack[top] = a
            elif op == ROW:
                stack[top] = row[int(a)]
            else:
                psi, reference = row[int(a)], row[int(b)]
                stack[top] = psi - 2.0 * pi * np.round((psi - reference) / (2.0 * pi))
        elif op == GROW:
            stack[top] = _grown(memory, int(a), stack[top], b)
        elif op < ADD:
            x = stack[top]
            if op == NEGATE:
                stack[top] = -x
            elif op == ABS:
                stack[top] = abs(x)
            elif op == SIN:
                stack[top] = np.sin(x)
            elif op == COS:
                stack[top] = np.cos(x)
            elif op == TAN:
                stack[top] = np.tan(x)
            elif op == EXP:
                stack[top] = np.exp(x)
            elif op == SQRT:
                stack[top] = np.sqrt(x)
            else:
                stack[top] = np.tanh(x)
        else:
            top -= 1
            x, y = stack[top], stack[top + 1]
            if op == ADD:
                stack[top] = x + y
            elif op == SUB:
                stack[top] = x - y
            elif op == MUL:
                stack[top] = x * y
            elif op == DIV:
                stack[top] = x / y
            elif op == POW:
                stack[top] = x**y
            elif op == MIN:
                stack[top] = x if x <= y or np.isnan(x) else y  # what is not a number stays
            else:
                stack[top] = x if x >= y or np.isnan(x) else y
    return stack[0] if top >= 0 else nan


def _judge(table, memory, stack, rows, first, last):
    """Return the sum of the margins of rows first to last - 1."""
    total = 0.0
    for k in range(first, last):
        worst = np.inf
        begin = 0
        for i in range(len(table)):
            if table[i, 0] == ASK:
                rho = _evaluate(table, begin, i, rows[k], memory, stack)
                begin = i + 1
                if table[i, 1] <= k <= table[i, 2]:
                    rho = -np.inf if np.isnan(rho) else rho
                    worst = min(worst, rho)
        if worst >= 0.0:
            total += min(1.0, worst)
        else:
            total += worst / (1.0 - worst) if np.isfinite(worst) else -1.0
    return total


@functools.cache
def judge() -> Callable[..., float]:
    """Return judge(table, memory, stack, rows, first, last): the sum of the margins of rows first to last - 1.

    Of instructions, shape (m, 3), each requirement ending with ASK; and the memories of what grows.
    """
    if not COMPILED:
        return _judge
    flat, table = types.float64[::1], types.float64[:, ::1]
    signature = types.float64(table, flat, flat, table, types.int64, types.int64)
    with compile_cache():
        compiled: Callable[..., float] = numba.njit(signature, cache=True, error_model="numpy")(_judge)
    return compiled
