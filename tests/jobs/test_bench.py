"""`uavftc bench`: what it prints and how. No time is asserted: a test's machine is never quiet."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest
from typer.testing import CliRunner, Result

from uavftc.cli.app import umbrella
from uavftc.flight.build import build_flight
from uavftc.jobs.bench import continuous
from uavftc.jobs.bench.catalogue import CATALOGUE, measured
from uavftc.jobs.bench.flights import flown, scenario
from uavftc.jobs.bench.measure import Bar, Figure, alternately
from uavftc.jobs.bench.table import figures_of

QUICK = (
    "closed_loop_over_bare_jsbsim",
    "controller_step_us",
    "bridge_io_us",
    "record_us",
    "analytic_step_us",
    "analytic_flight_ms",
    "margin_over_flight",
    "flights_per_second",
    "campaign_case_over_loop",
    "peers",
)


def bench(*arguments: str) -> Result:
    return CliRunner().invoke(umbrella, ["bench", *arguments])


@pytest.fixture(scope="module")
def document():
    done = bench("--json", "--rounds", "1", "--only", ",".join(QUICK))
    assert done.exit_code == 0, done.output

    def refuse(name):
        raise AssertionError(f"{name} is not JSON")

    return json.loads(done.stdout, parse_constant=refuse)


def test_the_document_holds_what_was_asked_for(document):
    assert set(document) == {*QUICK, "rounds", "machine"}
    assert set(document["closed_loop_over_bare_jsbsim"]) == {"hale", "c172p", "737"}
    assert set(document["record_us"]) == {"memory", "parquet"}
    assert set(document["flights_per_second"]) == {"analytic", "jsbsim"}
    assert document["rounds"] == 1
    assert {"jsbsim", "numba", "python", "cores"} <= set(document["machine"])


def test_every_figure_is_a_positive_number_or_says_why_not(document):
    figures = dict(figures_of(document))
    assert len(figures) == 17
    for name, figure in figures.items():
        if figure["median"] is None:
            assert figure["reason"], name
            assert name == "peers.jsbgym"  # the only one that may not be there
            continue
        assert math.isfinite(figure["median"]), name
        assert figure["median"] > 0.0, name
        low, high = figure["spread"]
        assert low <= figure["median"] <= high, name


def test_a_ratio_is_that_of_its_parts(document):
    hale = document["closed_loop_over_bare_jsbsim"]["hale"]
    assert hale["median"] == pytest.approx(hale["closed_us"]["median"] / hale["bare_us"]["median"])  # one round
    assert hale["at_most"] == 1.45
    assert hale["met"] == (hale["median"] <= hale["at_most"])


def test_the_property_loop_does_as_much_as_the_bridge(document):
    # attitude, rates, airspeed, altitude, alpha, beta, throttle, ground; place, forces, dynamic pressure, thrust;
    # three surfaces, three moments, one throttle
    peer = document["peers"]["jsbsim_property_loop"]
    assert (peer["reads_a_frame"], peer["writes_a_frame"]) == (19, 7)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--rounds", "0"), "--rounds 0"),
        (("--only", "controler_step_us"), "did you mean controller_step_us?"),
        (("--only", ""), "names of figures"),
    ],
)
def test_wrong_options_are_refused(arguments, message):
    done = bench(*arguments)
    assert done.exit_code == 2
    assert message in " ".join(done.stderr.split())
    assert done.stdout == ""


def test_the_table_names_every_figure_and_its_bar():
    done = bench("--rounds", "1", "--only", "analytic_step_us,record_us")
    assert done.exit_code == 0, done.output
    for text in ("analytic_step_us", "record_us.memory", "record_us.parquet", "<= 6"):
        assert text in done.stdout


def test_a_round_measures_all_jobs_in_alternating_order():
    order: list[str] = []

    def job(name, seconds):
        def do():
            order.append(name)
            return seconds

        return do

    assert alternately(2, job("a", 1.0), job("b", 2.0)) == [[1.0, 1.0], [2.0, 2.0]]
    assert "".join(order) == "ab" + "ab" + "ba"  # warm-up, first round, second round


def test_a_figure_shows_median_spread_and_bar():
    assert Figure([3.0, 1.0, 2.0]).document(Bar(1.5)) == {
        "median": 2.0, "spread": [1.0, 3.0], "at_most": 1.5, "met": False,
    }  # fmt: skip
    assert Figure([60.0]).document(Bar(50.0, at_least=True))["met"] is True
    assert Figure([], reason="why").document(Bar(1.0)) == {"median": None, "spread": None, "reason": "why"}


def test_what_cannot_be_measured_says_why(monkeypatch):
    from uavftc.jobs.bench.measure import NotMeasuredError

    def lost(rounds):
        raise NotMeasuredError("the flight did not reach its end: bank angle")

    figure = measured(CATALOGUE["analytic_step_us"]._replace(measure=lost), 1)
    assert figure == {"median": None, "spread": None, "reason": "the flight did not reach its end: bank angle"}


def test_the_continuous_loop_is_given_the_scenarios_disturbance():
    records = flown("scenario2", "analytic")
    for t, d2 in zip(records["t"], records["d2"], strict=True):
        np.testing.assert_allclose(continuous.d2_of(t), d2, rtol=1e-12, atol=1e-15)


def test_the_continuous_loop_has_the_derivative_of_the_sampled_one_at_the_start():
    # given: scenario 2 at rest; then: only d2 and the filtered command move it, x2' = d2 and v_ad' = -k K v1
    records = flown("scenario2", "analytic")
    loop = continuous.loop_of(build_flight(scenario("scenario2", plant="analytic")), records["x1_c"][0])
    rate = continuous.right_hand_side(0.0, continuous.start(records["x1"][0]), loop)
    np.testing.assert_allclose(rate[:3], 0.0, atol=1e-15)
    np.testing.assert_allclose(rate[3:6], records["d2"][0], rtol=1e-12)
    np.testing.assert_allclose(rate[15:18], -60.0 * loop["inner"]["K"][0] @ records["v1"][0], rtol=1e-12)
