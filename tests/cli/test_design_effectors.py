"""`uavftc design` of an aircraft with other effectors than one an axis."""

from __future__ import annotations

import json
import math

import pytest
from typer.testing import CliRunner

import v_tail
from uavftc.cli.app import umbrella
from uavftc.report import effectors_text


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return v_tail.write(tmp_path_factory.mktemp("aircraft"))


def run(*arguments: object):
    done = CliRunner().invoke(umbrella, ["design", *map(str, arguments)])
    assert done.exit_code == 0, done.output
    return done


@pytest.fixture(scope="module")
def document(folder):
    return json.loads(run(folder, "--json", "--airspeed-mps", "20").stdout)


def test_each_effector_is_listed_with_its_measured_effect_and_its_servo(document):
    # Effects from the coefficients of the XML: qbar S b C / I, without products of inertia; 1.0581 kg/m^3 at 1500 m.
    scale = 0.5 * 1.0581 * 20.0**2 * 0.6
    by_name = {e["name"]: e for e in document["effectors"]}
    assert list(by_name) == list(v_tail.EFFECTORS)
    for name, e in by_name.items():
        assert e["B"]["p_dot"] == pytest.approx(scale * 2.0 * v_tail.C_L[name] / 0.15, rel=2e-3)
        assert e["B"]["q_dot"] == pytest.approx(scale * 0.3 * v_tail.C_M[name] / 0.2, rel=2e-3)
        assert e["B"]["r_dot"] == pytest.approx(scale * 2.0 * v_tail.C_N[name] / 0.33, rel=2e-3)
        assert e["servo"] == v_tail.SERVO
        assert [e["trim_rad"] + limit for limit in e["limits_rad"]] == pytest.approx(
            [-v_tail.STOP_RAD, v_tail.STOP_RAD], abs=1e-6
        )
    assert document["gangs"]["aileron"] == {"ail_l": 1.0, "ail_r": -1.0}
    assert document["propulsion"]["throttles"] == ["fcs/throttle-cmd-norm[0]"]


def test_the_trim_of_an_axis_is_what_its_effectors_share(document):
    # both tail surfaces up by the same angle is an elevator of that angle, and no rudder
    tail = [e["trim_rad"] for e in document["effectors"] if e["name"].startswith("tail")]
    trim = document["trim"]
    assert trim["elevator_rad"] == pytest.approx(-sum(tail) / 2.0)
    assert trim["rudder_rad"] == pytest.approx((tail[1] - tail[0]) / 2.0, abs=1e-12)
    assert list(trim["surface_commands"]) == list(v_tail.EFFECTORS)


def test_the_text_has_a_line_an_effector_and_one_for_the_servos(folder):
    text = run(folder, "--airspeed-mps", "20").stdout
    assert [line.split()[0] for line in text.splitlines() if line.startswith(("ail_", "tail_"))] == [*v_tail.EFFECTORS]
    assert "servo: lag 40 rad/s, delay 20 ms, backlash 1 deg (all)" in text


def test_the_figure_has_a_panel_of_effectors(folder, tmp_path):
    file = tmp_path / "design.svg"
    run(folder, "--airspeed-mps", "20", "--figure", file)
    assert file.stat().st_size > 0


def test_servos_that_differ_and_full_commands_that_do_less_are_named():
    one = {"name": "left", "servo": {"rate_radps": math.radians(60.0)}, "full_response": [1.0, 0.5]}
    two = {"name": "right", "servo": {}, "full_response": [1.01, 0.99]}
    assert effectors_text.servo_lines([one, two]) == ["servo: rate 60 deg/s (left)"]
    (line,) = effectors_text.full_lines([one, two])
    assert line.startswith("left: full command does 1.00 and 0.50")


def test_weights_and_effects_keep_the_digits_that_mean_something():
    assert [effectors_text.weight_text(w) for w in (1.0, -1.0, 0.4631, 0.001)] == ["1", "-1", "0.46", "-"]
    assert [effectors_text.effect_text(b, 100.0) for b in (123.4, 0.05, -1.737)] == ["123", "0", "-1.74"]
