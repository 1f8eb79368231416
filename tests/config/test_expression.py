"""Expressions of t: their values, and that nothing but arithmetic gets in."""

from __future__ import annotations

import math
import pickle
import re
import time

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from uavftc.config.expression import MAX_DEPTH, MAX_LENGTH, Expression

T = np.array([0.0, 0.25, 1.0, 7.5, 20.0])


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("t", lambda t: t),
        ("3", lambda t: 3.0),
        ("-t + +2", lambda t: 2 - t),
        ("0.1 + 0.5*sin(t)", lambda t: 0.1 + 0.5 * math.sin(t)),
        ("3*cos(0.1*t)", lambda t: 3 * math.cos(0.1 * t)),
        ("2**3**2", lambda t: 512.0),  # right to left, as in mathematics
        ("-2**2", lambda t: -4.0),  # the power binds tighter than the sign
        ("10 - 4 - 3", lambda t: 3.0),  # left to right
        ("8 / 4 / 2", lambda t: 1.0),
        ("1 + 2*3", lambda t: 7.0),
        ("(1 + 2)*3", lambda t: 9.0),
        ("2*pi", lambda t: 2 * math.pi),
        ("tan(0.01*t)", lambda t: math.tan(0.01 * t)),
        ("exp(-t)", lambda t: math.exp(-t)),
        ("sqrt(t)", math.sqrt),
        ("abs(3 - t)", lambda t: abs(3 - t)),
        ("tanh(t - 1)", lambda t: math.tanh(t - 1)),
        ("min(t, 5)", lambda t: min(t, 5.0)),
        ("max(t, 5, 10)", lambda t: max(t, 5.0, 10.0)),
        ("1e-3*t + .5 + 2.", lambda t: 1e-3 * t + 2.5),
        ("1\n  + t", lambda t: 1 + t),  # a folded line of YAML
    ],
)
def test_values_are_those_of_the_formula(text, expected):
    np.testing.assert_allclose(Expression(text)(T), [expected(t) for t in T], rtol=1e-14)


def test_a_constant_takes_the_shape_of_t_and_may_be_written_to():
    values = Expression("2")(np.zeros((3, 2)))
    values[0, 0] = 7.0  # a broadcast view would refuse, or change every element
    assert values.shape == (3, 2)
    assert values.sum() == 7 + 5 * 2


def test_identity_does_not_hand_out_the_times_themselves():
    t = np.array([1.0, 2.0])
    Expression("t")(t)[0] = 9.0
    assert t[0] == 1.0


@given(a=st.floats(-1e6, 1e6), b=st.floats(-1e6, 1e6), t=st.floats(-100, 100))
def test_numbers_are_read_without_loss(a, b, t):
    assert Expression(f"({a!r}) + ({b!r})*t")(np.array([t]))[0] == a + b * t


def test_a_tower_of_powers_is_infinite_at_once():
    start = time.perf_counter()
    assert np.isposinf(Expression("9**9**9**9")(T)).all()  # as whole numbers it would fill the memory
    assert time.perf_counter() - start < 1.0


def test_what_is_not_finite_warns_nobody():
    assert np.isposinf(Expression("1/t")(np.array([0.0]))).all()  # warnings are errors here
    assert np.isnan(Expression("sqrt(0 - t)")(np.array([1.0]))).all()


@pytest.mark.parametrize(
    ("text", "part"),
    [
        ("__import__('os')", "__import__"),
        ("__import__('os').system('true')", "__import__"),
        ("().__class__.__bases__", "'.'"),
        ("t.real", "'.'"),
        ("t.__class__", "'.'"),
        ("lambda: 1", "lambda"),
        ("[t]", "'['"),
        ("{t}", "'{'"),
        ("'a'", '"\'"'),
        ('"a"', "'\"'"),
        ("t < 1", "'<'"),
        ("t if t else 1", "'if'"),
        ("t and 1", "'and'"),
        ("not t", "'not'"),
        ("True", "'True'"),
        ("None", "'None'"),
        ("nan", "'nan'"),
        ("inf", "'inf'"),
        ("e", "'e'"),
        ("x", "'x'"),
        ("log(t)", "'log'"),
        ("open(1)", "'open'"),
        ("eval(1)", "'eval'"),
        ("sin(t=1)", "'='"),
        ("(t := 1)", "':'"),
        ("t; t", "';'"),
        ("t # hi", "'#'"),
        ("t // 2", "t // 2"),
        ("t % 2", "'%'"),
        ("t @ t", "'@'"),
        ("~t", "'~'"),
        ("t ^ 2", "'^'"),
        ("3j", "3j"),
        ("2t", "2t"),
        ("1_000", "1_"),
        ("0x10", "0x"),
        ("1e999", "1e999"),
        ("9" * 400, "too large"),
        ("sin", "'sin' is a function"),
        ("sin + 1", "'sin' is a function"),
        ("t(1)", "'t' is not a function"),
        ("pi(1)", "'pi' is not a function"),
        ("sin(t)(t)", "sin(t)(t)"),
        ("sin()", "exactly one argument"),
        ("sin(t, t)", "exactly one argument"),
        ("min(t)", "two or more"),
        ("max(*t, 1)", "*t"),
        ("max(**t)", "max(**t)"),
        ("(t, 1)", "(t, 1)"),
        ("()", "()"),
        ("1 +", "not an expression"),
        ("sin(t", "not an expression"),
        ("t t", "not an expression"),
        ("010", "not an expression"),
        ("", "empty"),
        (" \n", "empty"),
        ("ｓｉｎ(t)", "ｓｉｎ"),  # Python itself would read it as sin
        ("t\x00", "\\x00"),
        ("١", "'١'"),
    ],
)
def test_everything_else_is_refused_by_name(text, part):
    with pytest.raises(ValueError, match=re.escape(part)):
        Expression(text)


@pytest.mark.parametrize(
    "text",
    [
        "(" * 400 + "t" + ")" * 400,
        "-" * 999 + "t",
        "+".join("t" * 500),
        "**".join("t" * 300),
        "t" * (MAX_LENGTH + 1),
        "1" + " " * 100_000_000,
    ],
    ids=["parentheses", "signs", "sum", "powers", "name", "blanks"],
)
def test_size_is_bounded_without_exhausting_the_stack(text):
    with pytest.raises(ValueError, match=r"nested|at most|unknown name"):
        Expression(text)


def test_what_is_admitted_can_also_be_sampled():
    # the stack must bear every expression that is admitted
    assert Expression("-" * MAX_DEPTH + "t")(np.array([2.0]))[0] == 2.0
    assert Expression("abs(" * 150 + "t" + ")" * 150)(np.array([2.0]))[0] == 2.0


def test_the_error_marks_the_place():
    with pytest.raises(ValueError, match="unknown name 'foo'") as error:
        Expression("1 + foo*t")
    lines = str(error.value).splitlines()
    assert lines[2].index("^") == lines[1].index("foo")


def test_equality_and_pickling_go_by_the_text():
    one = Expression("0.2*t")
    again = pickle.loads(pickle.dumps(one))  # flights run in worker processes
    assert again == one
    assert hash(again) == hash(one)
    assert again != Expression("0.2 * t")
    np.testing.assert_array_equal(again(T), one(T))
