"""Formulas: what they admit, what they refuse, and their robustness at a sample."""

import pickle
import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from uavftc.config.formula import Formula

A, B = np.array([0.5, 3.0, -2.0]), np.array([1.0, -4.0, 0.0])


def rho(text, scale=None):
    formula = Formula(text)
    return formula.robustness({name: {"a": A, "b": B}[name] for name in formula.names}, scale)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("a <= 2", (2 - A) / 2),
        ("a < 2", (2 - A) / 2),
        ("a >= -4", (A + 4) / 4),
        ("2 >= a", (2 - A) / 2),
        ("abs(a) <= 2", (2 - np.abs(A)) / 2),
        ("-1 <= a <= 2", np.minimum(A + 1, (2 - A) / 2)),
        ("not a <= 2", -(2 - A) / 2),
        ("a <= 2 and b >= 5", np.minimum((2 - A) / 2, (B - 5) / 5)),
        ("a <= 2 or b >= 5", np.maximum((2 - A) / 2, (B - 5) / 5)),
        ("a <= 2 implies b >= 5", np.maximum(-(2 - A) / 2, (B - 5) / 5)),
        ("2*a + b <= 2*pi", (2 * np.pi - 2 * A - B) / (2 * np.pi)),
        ("max(a, b) <= sqrt(4)", (2 - np.maximum(A, B)) / 2),
    ],
)
def test_robustness_is_the_distance_to_the_limit_over_the_limit(text, expected):
    np.testing.assert_allclose(rho(text), expected, rtol=1e-15, atol=0)


def test_a_scale_takes_the_place_of_the_limit_in_every_comparison():
    np.testing.assert_array_equal(rho("a <= 2 and b >= -5", scale=4.0), np.minimum((2 - A) / 4, (B + 5) / 4))
    np.testing.assert_array_equal(rho("a <= b", scale=0.5), (B - A) / 0.5)


@pytest.mark.parametrize(
    ("text", "same"),
    [
        ("a<=1 or b<=1 and a>=2", "a<=1 or (b<=1 and a>=2)"),
        ("a<=1 implies b<=1 or a>=2", "a<=1 implies (b<=1 or a>=2)"),
        ("a<=1 implies b<=1 implies a>=2", "a<=1 implies (b<=1 implies a>=2)"),
        ("not a<=1 and b<=1", "(not a<=1) and b<=1"),
        ("(a<=1 implies b<=1) and a>=2", "(not a<=1 or b<=1) and a>=2"),
    ],
)
def test_words_bind_not_and_or_implies(text, same):
    np.testing.assert_array_equal(rho(text), rho(same))


def test_names_are_those_of_signals_in_the_order_of_the_text():
    assert Formula("abs(q) <= pi and max(p, q, t) >= 1").names == ("q", "p", "t")


@pytest.mark.parametrize(
    ("text", "unscaled"),
    [("a <= 0", "a <= 0"), ("a <= 1 and b >= a", "b >= a"), ("a <= 1 - 1", "a <= 1 - 1"), ("abs(a) <= 1", None)],
)
def test_a_comparison_without_a_scale_is_named(text, unscaled):
    assert Formula(text).unscaled == unscaled


def test_not_a_number_is_broken_without_bound():
    assert Formula("sqrt(a) <= 1").robustness({"a": np.array([-1.0])}) == [-np.inf]
    assert Formula("not sqrt(a) <= 1").robustness({"a": np.array([-1.0])}) == [-np.inf]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "empty"),
        ("a", "no <= or >="),
        ("a + 1", "no <= or >="),
        ("1 <= 2", "no signal"),
        ("a == 1", "only <=, >=, < and >"),
        ("a = 1", "not a formula"),
        ("a <= 1 and", "not a formula"),
        ("a <= 1 if b <= 1 else a >= 1", "the word 'if' is not allowed"),
        ("a is 1", "the word 'is' is not allowed"),
        ("a <= None", "the word 'None' is not allowed"),
        ("a <= 1/0", "not a finite number"),
        ("a <= 1e999", "too large"),
        ("a.b <= 1", "'.' is not allowed"),
        ("a[0] <= 1", "'[' is not allowed"),
        ("exec(a) <= 1", "'exec' is not a function"),
        ("sin <= 1", "'sin' is a function"),
        ("(a <= 1) + 1 <= 2", "not allowed"),
        ("a <= 'x'", "not allowed"),
        ("(" * 400 + "a <= 1" + ")" * 400, "too many nested"),
        ("not " * 240 + "a <= 1", "nested too deeply"),
        ("a <= 1 " * 200, "characters"),
        ("\N{LATIN SMALL LIGATURE FI} <= 1", "unknown name"),
        (":= a <= 1", "not allowed"),
        ("implies", "not a formula"),
    ],
)
def test_what_is_no_formula_is_refused_with_the_place(text, message):
    with pytest.raises(ValueError, match=re.escape(message)):
        Formula(text)


def test_the_place_of_an_error_behind_implies_is_that_of_the_text():
    with pytest.raises(ValueError, match="only") as error:
        Formula("a <= 1 implies b == 2")
    assert str(error.value).splitlines()[2].index("^") - 4 == "a <= 1 implies b".index("b") + 1


def test_a_formula_is_a_value():
    formula = Formula("a <= 2 implies b >= 5")
    again = pickle.loads(pickle.dumps(formula))
    assert again == formula
    assert hash(again) == hash(formula)
    np.testing.assert_array_equal(again.robustness({"a": A, "b": B}), formula.robustness({"a": A, "b": B}))


@given(st.text(alphabet="ab<>=()+-*/ ,.0123456789notandorimpliesif\n\t#'\"[]{}:;@\\%&|~^!", max_size=60))
def test_any_text_is_a_formula_or_a_value_error(text):
    try:
        formula = Formula(text)
    except ValueError:
        return
    values = {name: np.zeros(3) for name in formula.names}
    assert formula.robustness(values, 1.0).shape in ((3,), ())
