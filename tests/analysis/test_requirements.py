"""Requirements: their robustness against rtamt and by brute force, the margin, and streaming."""

import importlib
import math
import warnings

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from uavftc.analysis.derived import Window, known_signals
from uavftc.analysis.requirements import LEAST, Monitor, Requirement, margin_of
from uavftc.analysis.verdict import verdict_of
from uavftc.config.formula import Formula
from uavftc.core.signals import COLUMNS, as_records, empty_rows

RATE_HZ = 10.0
LIMITS = {"aileron": (-0.1, 0.2), "elevator": (-0.1, 0.1), "rudder": (-math.inf, math.inf)}


def flight(n, seed=0):
    """Return random rows."""
    records = as_records(empty_rows(n))
    rng = np.random.default_rng(seed)
    for name in ("x1", "x2", "x1_c", "v2", "u2", "airspeed", "alpha"):
        records[name] = rng.normal(size=records[name].shape)
    records["t"] = np.arange(n) / RATE_HZ
    return records


def robustness(one, records, chunks=1):
    monitor = Monitor([one], known_signals(COLUMNS, LIMITS), RATE_HZ)
    for piece in np.array_split(records, chunks):
        monitor.take(piece)
    return monitor.robustness()[one.name]


def test_always_is_the_smallest_and_eventually_the_largest_within_its_samples():
    records = flight(30)
    rho = (1.0 - records["x2"][:, 0]) / 1.0
    formula = Formula("p_radps <= 1")
    assert robustness(Requirement("r", formula, 3, 11), records) == rho[3:12].min()
    assert robustness(Requirement("r", formula, 3, 11, always=False), records) == rho[3:12].max()
    assert robustness(Requirement("r", formula, 3), records) == rho[3:].min()


@pytest.mark.parametrize("hold", [0, 1, 2, 5, 6, 28, 29])
@pytest.mark.parametrize(("first", "last"), [(0, None), (4, 12), (4, 40), (0, 0)])
def test_a_hold_begins_within_its_samples_and_is_not_cut_short(hold, first, last):
    records = flight(30)
    rho = 1.0 - records["x2"][:, 0]
    begins = [k for k in range(first, min(29, 40 if last is None else last) + 1) if k + hold <= 29]
    expected = max((rho[k : k + hold + 1].min() for k in begins), default=None)
    one = Requirement("r", Formula("p_radps <= 1"), first, last, False, hold)
    for chunks in (1, 4, 30):
        assert robustness(one, records, chunks) == expected


COMPARISONS = ["abs(phi_rad) <= 1", "p_radps >= -0.5", "airspeed_mps <= 2", "alpha_rad <= 0.3", "q_radps >= 0.7"]
PREDICATES = [
    lambda r: 1.0 - np.abs(r["x1"][:, 0]),
    lambda r: (r["x2"][:, 0] + 0.5) / 0.5,
    lambda r: (2.0 - r["airspeed"]) / 2.0,
    lambda r: (0.3 - r["alpha"]) / 0.3,
    lambda r: (r["x2"][:, 1] - 0.7) / 0.7,
]


def random_formula(rng, depth):
    """Return the text of a formula, and that of the same in rtamt's language over x0 to x4."""
    kind = rng.integers(5) if depth else 0
    if kind == 0:
        i = rng.integers(5)
        return COMPARISONS[i], f"(x{i} >= 0)"
    a, a_other = random_formula(rng, depth - 1)
    if kind == 1:
        return f"not ({a})", f"(not({a_other}))"
    b, b_other = random_formula(rng, depth - 1)
    word = ("and", "or", "implies")[kind - 2]
    return f"({a}) {word} ({b})", f"({a_other} {word} {b_other})"


def test_robustness_is_that_of_rtamt_on_a_thousand_random_traces_and_formulas():
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)
        try:
            rtamt = importlib.import_module("rtamt")
        except Exception as error:  # it depends on a parser that not every Python can import
            pytest.skip(f"rtamt does not import: {error}")
        rng = np.random.default_rng(12)
        for case in range(1000):
            n = int(rng.integers(5, 40))
            records = flight(n, case)
            ours, theirs = random_formula(rng, int(rng.integers(4)))
            hold = int(rng.integers(0, n // 2))
            first = int(rng.integers(0, n - hold))
            last = int(rng.integers(first, n - hold))
            always = bool(rng.integers(2))
            hold = 0 if always else hold
            spec = rtamt.StlDiscreteTimeSpecification()
            for i in range(5):
                spec.declare_var(f"x{i}", "float")
            held = theirs if always else f"(always[0:{hold}]{theirs})"
            spec.spec = f"{'always' if always else 'eventually'}[{first}:{last}]{held}"
            spec.parse()
            values = {f"x{i}": of(records).tolist() for i, of in enumerate(PREDICATES)}
            expected = spec.evaluate({"time": list(range(n)), **values})[0][1]
            found = robustness(Requirement("r", Formula(ours), first, last, always, hold), records, 1 + case % 3)
            assert found == pytest.approx(expected, rel=1e-12, abs=1e-12), (ours, spec.spec)


WATCHED = [
    "abs(phi_error_deg) <= 1",
    "aileron_travel_radps <= 1 and aileron_cmd_travel_degps <= 50",
    "aileron_saturated_share <= 0.5",
    "rudder_saturated_share <= 0.5 implies elevator_saturated_share <= 0.1",
]


@pytest.mark.parametrize("text", WATCHED)
@pytest.mark.parametrize("always", [True, False])
def test_the_chunks_in_which_a_flight_comes_change_no_bit(text, always):
    records = flight(97)
    one = Requirement("r", Formula(text), 3, 90, always, 0 if always else 4, window=Window(13, 1.3))
    whole = robustness(one, records)
    for chunks in (2, 5, 20, 97):
        assert robustness(one, records, chunks) == whole


def test_memory_does_not_grow_with_the_flight():
    monitor = Monitor(
        [Requirement("r", Formula(WATCHED[1]), always=False, hold=4, window=Window(13, 1.3))],
        known_signals(COLUMNS, LIMITS),
        RATE_HZ,
    )
    records = flight(50)
    sizes = []
    for _ in range(20):
        monitor.take(records)
        (source,) = {id(s): s for s in monitor._sources.values() if hasattr(s, "_sums")}.values()
        sizes.append(len(source._sums) + len(monitor._asked[0][2]._tail))
    assert set(sizes) == {13 + 4}


def test_travel_is_the_way_within_the_window_over_its_length():
    records = as_records(empty_rows(40))
    records["u2"][:, 0] = 0.1 * (-1.0) ** np.arange(40)  # 0.2 rad a step, 2 rad/s
    signals = known_signals(COLUMNS, LIMITS)
    values = signals["aileron_travel_radps"].make(Window(10, 1.0)).take(records)
    np.testing.assert_allclose(values[:11], 0.2 * np.arange(11), rtol=1e-12)
    np.testing.assert_allclose(values[10:], 2.0, rtol=1e-12)
    degrees = signals["aileron_travel_degps"].make(Window(10, 1.0)).take(records)
    np.testing.assert_allclose(degrees, np.degrees(values), rtol=1e-15)


def test_saturated_share_counts_the_commands_at_or_beyond_a_limit():
    records = as_records(empty_rows(8))
    records["v2"][:, 0] = [0.0, 0.2, 0.3, -0.1, 0.1, 0.0, 0.0, 0.0]
    share = known_signals(COLUMNS, LIMITS)["aileron_saturated_share"].make(Window(4, 0.4)).take(records)
    np.testing.assert_allclose(share, [0, 0.25, 0.5, 0.75, 0.75, 0.5, 0.25, 0])


def test_the_heading_error_is_within_half_a_turn():
    records = as_records(empty_rows(1))
    records["x1"][:, 2], records["x1_c"][:, 2] = math.radians(358), math.radians(3)
    error = known_signals(COLUMNS, LIMITS)["psi_error_deg"].make(Window(1, 0.1)).take(records)
    assert error[0] == pytest.approx(5.0)


@pytest.mark.parametrize(
    ("rho", "margin"), [(3.0, 1.0), (1.0, 1.0), (0.25, 0.25), (0.0, 0.0), (-1.0, -0.5), (-3.0, -0.75)]
)
def test_margins_are_those_of_the_definition(rho, margin):
    assert margin_of(rho) == margin


@given(st.floats(-1e300, 1e300), st.floats(-1e300, 1e300))
def test_a_margin_is_bounded_and_never_falls_where_robustness_rises(a, b):
    low, high = sorted((a, b))
    assert -1.0 < LEAST <= margin_of(low) <= margin_of(high) <= 1.0
    assert margin_of(-math.inf) == LEAST


@given(st.integers(0, 1000), st.sampled_from(WATCHED))
def test_negation_turns_the_sign_and_always_into_eventually(seed, text):
    records = flight(25, seed)
    window = Window(5, 0.5)
    always = robustness(Requirement("r", Formula(text), 2, 20, window=window), records)
    never = robustness(Requirement("r", Formula(f"not ({text})"), 2, 20, always=False, window=window), records)
    assert always == -never


@given(st.integers(0, 1000), st.integers(0, 10))
def test_a_shift_in_time_shifts_the_moment_and_keeps_the_robustness(seed, shift):
    records = flight(25, seed)
    later = np.concatenate([records[:1]] * shift + [records])
    formula = Formula("p_radps <= 1 or q_radps >= 0.3")
    for always in (True, False):
        one = Requirement("r", formula, 2, 20, always, 0 if always else 3)
        moved = one._replace(first=2 + shift, last=20 + shift)
        monitors = []
        for asked, rows in ((one, records), (moved, later)):
            monitor = Monitor([asked], known_signals(COLUMNS, LIMITS), RATE_HZ)
            monitor.take(rows)
            monitors.append(monitor)
        assert monitors[0].robustness() == monitors[1].robustness()
        (first,), (second,) = (monitor.found() for monitor in monitors)
        assert second.at_s == pytest.approx(first.at_s + shift / RATE_HZ)


@given(st.integers(0, 1000), st.floats(0.0, 2.0))
def test_a_wider_limit_never_lowers_robustness(seed, wider):
    records = flight(25, seed)
    tight, wide = (robustness(Requirement("r", Formula(f"p_radps <= {x}"), scale=1.0), records) for x in (1, 1 + wider))
    assert wide >= tight


def judged(records):
    monitor = Monitor(
        [
            Requirement("small", Formula("abs(phi_deg) <= 300")),
            Requirement("large", Formula("abs(p_radps) <= 0.001")),
            Requirement("late", Formula("abs(p_radps) <= 100"), first=1000),
        ],
        known_signals(COLUMNS, LIMITS),
        RATE_HZ,
    )
    monitor.take(records)
    return monitor.found()


def test_the_verdict_is_the_smallest_margin_and_its_name():
    small, large, late = judged(flight(50))
    completed = verdict_of([small], completed=True, ended_at_s=None, duration_s=4.9)
    assert (completed.outcome, completed.margin, completed.limiting) == ("survived", small.margin, "small")
    broken = verdict_of([small, large], completed=True, ended_at_s=None, duration_s=4.9)
    assert (broken.outcome, broken.margin, broken.limiting) == ("degraded", large.margin, "large")
    assert broken.at_s == large.at_s
    assert -1.0 < broken.margin < 0.0
    assert late == ("late", None, False, None)


@pytest.mark.parametrize(("ended", "margin"), [(0.0, -2.0), (5.0, -1.5), (10.0, -1.0)])
def test_a_lost_flight_is_the_lower_the_earlier(ended, margin):
    lost = verdict_of(judged(flight(50)), completed=False, ended_at_s=ended, duration_s=10.0)
    assert (lost.outcome, lost.margin, lost.limiting, lost.at_s) == ("lost", margin, "flown", ended)
    numerical = verdict_of([], completed=False, ended_at_s=ended, duration_s=10.0, numerical=True)
    assert (numerical.outcome, numerical.margin) == ("numerical", margin)


def test_without_requirements_a_flight_that_reached_its_end_has_the_whole_margin():
    verdict = verdict_of([], completed=True, ended_at_s=None, duration_s=10.0)
    assert (verdict.outcome, verdict.margin, verdict.limiting, verdict.requirements) == ("survived", 1.0, None, ())
