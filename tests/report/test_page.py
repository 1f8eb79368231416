"""What a page is made of: thinned curves, the moving view, tables, escaped texts."""

from __future__ import annotations

import base64
import json
import re
from dataclasses import replace

import numpy as np
import pytest

from flying import flown
from uavftc.flight.recorder import published
from uavftc.report import palette
from uavftc.report.page import html
from uavftc.report.page.campaign import campaign_page
from uavftc.report.page.flight import flight_page
from uavftc.report.page.packed import MAX_POINTS, Curve, Group, Panel, points_within
from uavftc.report.page.tables import metric_table
from uavftc.report.page.view import Sketch, view_of
from uavftc.results.context import FigureContext
from uavftc.results.windows import FlightWindow

TYPES = {"f4": "<f4", "u2": "<u2", "u4": "<u4"}


def unpacked(one: dict[str, str]) -> np.ndarray:
    return np.frombuffer(base64.b64decode(one["data"]), dtype=TYPES[one["type"]])


def data_of(page: str) -> dict:
    return json.loads(re.search(r'<script type="application/json" id="data">(.*?)</script>', page, re.S)[1])


def test_a_long_curve_has_at_most_its_points_and_keeps_the_spikes_and_the_ends():
    y = np.sin(np.arange(100_000) / 700.0)
    y[4_321], y[77_777] = 50.0, -40.0
    sent = Curve("a", "actual", y).packed(MAX_POINTS)
    rows, values = unpacked(sent["rows"]), unpacked(sent["y"])
    assert len(rows) == len(values) <= MAX_POINTS
    assert (rows[0], rows[-1]) == (0, 99_999)
    assert (values.max(), values.min()) == (50.0, -40.0)
    np.testing.assert_array_equal(values, y[rows].astype("f4"))


def test_a_constant_costs_two_points_and_a_step_four():
    assert unpacked(Curve("a", "actual", np.full(4001, 5.0)).packed(MAX_POINTS)["rows"]).tolist() == [0, 4000]
    step = np.repeat([0.0, 1.0], 500)
    assert unpacked(Curve("a", "actual", step).packed(MAX_POINTS)["rows"]).tolist() == [0, 499, 500, 999]
    assert unpacked(Curve("a", "actual", np.full(50, np.nan)).packed(MAX_POINTS)["rows"]).tolist() == [0, 49]


def test_a_heading_that_wraps_has_a_gap_there():
    sent = Curve("a", "actual", np.array([179.0, 179.5, -179.5, -179.0]), 360.0).packed(MAX_POINTS)
    assert np.isnan(unpacked(sent["y"])).tolist() == [False, False, True, False, False]


def test_many_curves_share_what_a_page_may_have():
    panel = Panel("a", "deg", [Curve("a", "actual", np.zeros(3))] * 10)
    assert points_within([Group("a", "A", [panel])], 1e6) == MAX_POINTS
    assert points_within([Group("a", "A", [panel] * 50)], 1e6) == 250  # 500 curves of 8 bytes a point


def test_a_panel_says_what_it_does_not_show():
    wound_up = Curve("command", "command", np.array([0.0, 1.0, 80.0]))
    shown = Panel("a", "deg", [wound_up], limits=[5.0, 90.0], shown=[np.array([0.0, 1.0])]).packed(MAX_POINTS)
    assert shown["remark"] == "off scale: to +80; off scale: limit +5, +90"
    assert shown["range"][1] < 2.0
    assert Panel("a", "deg", [wound_up]).packed(MAX_POINTS)["remark"] == ""


def test_surfaces_of_the_view_turn_as_the_moment_of_their_axis_asks():
    # given a flight on hale that rolls to the right and pitches up from trim: the first commands are positive moments
    flight, records, _ = flown("scenario1")
    history = published(records, flight.columns)
    view = view_of(history, (), Sketch(flight.layout, 16.0))
    moments = np.diag(flight.layout.moments)
    k = 40  # 0.2 s
    asked = [history[f"{name}_rad"][k] * moments[i] for i, name in enumerate(("aileron", "elevator", "rudder"))]
    assert min(asked) > 0.0  # rolls right, pitches up, yaws right
    place = int(np.searchsorted(unpacked(view["t"]), history["time_s"][k]))
    angle = {name: unpacked(part["angle"])[place] for name, part in view["parts"].items()}
    assert angle["left_aileron"] > 0.0 > angle["right_aileron"]  # left down, right up
    assert angle["left_elevator"] < 0.0  # up
    assert angle["right_elevator"] < 0.0
    assert angle["rudder"] > 0.0  # to the right
    size = np.rad2deg(abs(history["aileron_rad"][place * 2]))
    np.testing.assert_allclose([angle["left_aileron"], -angle["right_aileron"]], size, rtol=0.02)


def test_a_fault_of_one_aileron_is_on_that_side_of_the_view():
    flight, records, _ = flown("scenario1")
    window = FlightWindow("fault", "left aileron", "stuck", 1.0, 2.0, frozenset({"left_aileron", "phi"}))
    view = view_of(published(records, flight.columns), (window,), Sketch(flight.layout))
    assert {name: part["windows"] for name, part in view["parts"].items() if part["windows"]} == {"left_aileron": [1]}


def test_the_paper_stands_next_to_a_metric_and_a_dash_where_it_prints_none():
    axes = {axis: {m: 0.2 for m in METRICS} for axis in ("roll", "pitch", "yaw")}
    table = metric_table(axes, {("roll", "iae"): 0.1, ("roll", "convergence_time_s"): None})
    row = next(row for row in table.rows if row[0] == "IAE [rad s]")
    assert row[:4] == ["IAE [rad s]", "0.2000", "0.1000", "2.00"]
    assert row[4:] == ["0.2000", "–", "", "0.2000", "–", ""]
    assert list(metric_table(axes, None).header) == ["metric", "roll", "pitch", "yaw"]


METRICS = (
    "steady_state_error_deg", "convergence_time_s", "iae", "ise", "itae", "itse", "control_activity_rad"
)  # fmt: skip
HOSTILE = '</script><script>window.hacked = 1</script><img src=x onerror="window.hacked = 2"> & <b>bold</b>'


def hostile_page() -> str:
    """Return the page of a short flight all of whose texts are hostile."""
    flight, records, _ = flown("scenario1", overrides=("duration_s=2",))
    history = published(records, flight.columns)
    window = FlightWindow("fault", "aileron", HOSTILE, 0.5, 1.5, frozenset({"phi", "aileron"}))
    context = FigureContext(HOSTILE, windows=(window,), limiting=(HOSTILE, 1.0))
    requirement = {"name": HOSTILE, "margin": 0.5, "met": True, "at_s": 1.0}
    document = {
        "scenario": HOSTILE, "controller": HOSTILE, "aircraft": HOSTILE, "plant": "jsbsim", "completed": True,
        "ended_because": None, "ended_at_s": None, "warnings": [HOSTILE], "provenance": {HOSTILE: HOSTILE},
        "verdict": {"outcome": "survived", "margin": 0.5, "limiting": HOSTILE, "requirements": [requirement]},
        "axes": {axis: {m: 0.2 for m in METRICS} for axis in ("roll", "pitch", "yaw")},
    }  # fmt: skip
    return flight_page(history, context, document, HOSTILE, sketch=Sketch(flight.layout), files=[HOSTILE])


def test_every_text_of_the_users_is_escaped():
    page = hostile_page()
    assert "window.hacked = 1</script>" not in page
    assert "<img src=x" not in page
    assert "<b>bold</b>" not in page
    assert page.count("<script") == html_scripts() + 2  # the data and plotly.js
    assert data_of(page)["windows"][0]["name"] == f"aileron: {HOSTILE}"


def html_scripts() -> int:
    return len(html._SCRIPTS)


def test_a_page_loads_nothing():
    page = hostile_page().replace(html.plotly_js(), "")
    assert not re.search(r"""(?:src|href)=["']?(?:https?:)?//""", page)
    assert "default-src 'none'" in page


def test_every_colour_of_a_curve_is_seen_on_a_dark_ground():
    # contrast of WCAG 2.1, 3 to 1 for graphics, against the ground of theme.js
    def luminance(colour: str) -> float:
        parts = [int(colour[i : i + 2], 16) / 255.0 for i in (1, 3, 5)]
        r, g, b = (c / 12.92 if c <= 0.03928 else ((c + 0.055) / 1.055) ** 2.4 for c in parts)
        return 0.2126 * r + 0.7152 * g + 0.0722 * b

    ground = luminance("#1b1d21")
    looks = (palette.ACTUAL, palette.REFERENCE, palette.MEASURED, palette.COMMAND, palette.ESTIMATE, palette.TWIN)
    for look in (*looks, palette.LIMIT, *palette.SEVERAL):
        colour = palette.ON_DARK.get(look["color"], look["color"])
        assert (luminance(colour) + 0.05) / (ground + 0.05) >= 3.0, colour


def campaign_columns(n: int) -> dict[str, list]:
    margins = np.random.default_rng(1).uniform(-1.0, 1.0, n)
    return {
        "case": list(range(n)), "controller": ["pid"] * n, "faults[0].effectiveness": [k / n for k in range(n)],
        "outcome": ["survived" if m >= 0.0 else "degraded" for m in margins],
        "success": [bool(m >= 0.0) for m in margins], "margin": margins.tolist(), "limiting": ["tracking"] * n,
        "reason": [None] * n,
    }  # fmt: skip


def campaign(n: int) -> str:
    document = {"campaign": "c", "cases": n, "flights": n, "provenance": {}}
    said = {"campaign": {"vary": [{"key": "faults[0].effectiveness"}], "success": None}}
    return campaign_page(campaign_columns(n), document, said)


def test_a_campaign_has_the_interval_of_success_and_its_worst_flight_first():
    flights = campaign_columns(100)
    page = campaign(100)
    k = sum(flights["success"])
    p, z = k / 100, 1.959964
    middle, half = (
        (p + z * z / 200) / (1 + z * z / 100),
        z / (1 + z * z / 100) * (p * (1 - p) / 100 + z * z / 4e4) ** 0.5,
    )
    assert f"<td>{middle - half:.3f} to {middle + half:.3f}</td>" in page  # Wilson's, by its formula
    worst = int(np.argmin(flights["margin"]))
    assert re.search(r'class="worst">.*?<tbody>\s*<tr><th scope="row">(\d+)', page, re.S)[1] == str(worst)


def test_of_a_large_campaign_the_worst_flights_are_all_drawn():
    page = campaign(9_000)
    drawn = unpacked(data_of(page)["scatter"]["margin"])
    assert len(drawn) == 4_000
    margins = np.sort(np.array(campaign_columns(9_000)["margin"], dtype="f4"))
    np.testing.assert_array_equal(np.sort(drawn)[:1000], margins[:1000])
    assert "4000 of 9000 flights are drawn" in page


def test_a_controller_without_a_figure_is_no_obstacle():
    # given a flight lost at its first sample, which has no number at all
    flight, records, _ = flown("scenario1", overrides=("duration_s=2",))
    history = {name: values[:1] for name, values in published(records, flight.columns).items()}
    document = {
        "scenario": "a", "controller": "b", "aircraft": "c", "plant": "jsbsim", "completed": False,
        "ended_because": "ground contact", "ended_at_s": 0.0, "warnings": [], "provenance": {}, "verdict": None,
        "axes": {axis: dict.fromkeys(METRICS) for axis in ("roll", "pitch", "yaw")},
    }  # fmt: skip
    page = flight_page(history, FigureContext("a"), document, "", sketch=Sketch(flight.layout))
    assert "ended at 0.0 s: ground contact" in page
    assert data_of(page)["clock"]["rows"] == 1
    assert "without faults" in flight_page(
        history, replace(FigureContext("a"), twin=history), document, "", sketch=Sketch(flight.layout)
    )


@pytest.mark.parametrize("package", ["plotly", "jinja2"])
def test_a_missing_extra_is_named_with_what_installs_it(package, monkeypatch):
    from uavftc.errors import InputError

    found = html.util.find_spec
    monkeypatch.setattr(html.util, "find_spec", lambda name: None if name == package else found(name))
    with pytest.raises(InputError, match=r"pip install 'uavftc\[report\]'") as caught:
        html.require_extra("--report")
    assert caught.value.found == f"no package {package}"
