"""The figure of a whole flight: all of it on one page, of one size, with what happened and how it ended."""

from __future__ import annotations

import io
from functools import cache

import numpy as np
import pytest
from matplotlib.colors import to_hex
from PIL import Image

from uavftc.jobs.campaign.pool import fly_one
from uavftc.report import panels
from uavftc.report.overview import STYLE, overview
from uavftc.report.palette import COMMAND, DEFLECTION, THREE
from uavftc.results.context import FigureContext
from uavftc.results.flight import FlightResult
from uavftc.results.summary import ending_of
from uavftc.scenario.load import load_scenario


@cache
def result_of(scenario: str, *overrides: str, plant: str = "jsbsim", controller: str | None = None) -> FlightResult:
    return fly_one(load_scenario(scenario, plant=plant, controller=controller, overrides=list(overrides)))


def drawn(result: FlightResult):
    assert result.history is not None
    with panels.style(STYLE):
        return overview(result.history, result.figure_context())


def titled(figure, begins: str):
    (found,) = (ax for ax in figure.axes if ax.get_title(loc="left").startswith(begins))
    return found


def curves(ax) -> dict[str, np.ndarray]:
    """Return what is drawn in a panel, by label and colour."""
    found = {}
    for line in ax.lines:
        if len(line.get_xdata()) > 2:
            found[line.get_label(), to_hex(line.get_color())] = np.asarray(line.get_ydata())
    return found


def test_it_has_one_size_whatever_the_flight():
    result = result_of("scenario3", "duration_s=2")
    for context in (result.figure_context(), FigureContext("a title\nand a second line")):
        with panels.style(STYLE), io.BytesIO() as file:
            overview(result.history, context).savefig(file)
            assert Image.open(file).size == (900, 600)


@pytest.mark.parametrize("rows", [0, 1, 2])
def test_a_flight_lost_at_once_is_drawn(make_history, rows):
    with panels.style(STYLE), io.BytesIO() as file:
        overview(make_history(rows), FigureContext("nothing")).savefig(file)


def test_commands_and_deflections_of_both_ailerons_are_in_degrees():
    # as each of them counts, trim included, from the columns of the history
    result = result_of("beyond/fault-stuck", "duration_s=4")
    found = curves(titled(drawn(result), "ailerons [deg]"))
    left, right = DEFLECTION["color"].lower(), str(THREE[2]["color"]).lower()
    for key, column in (
        (("command", COMMAND["color"].lower()), "left_aileron_cmd_rad"),
        (("reached", left), "left_aileron_rad"),
        (("reached, right", right), "right_aileron_rad"),
    ):
        np.testing.assert_array_equal(found[key], np.degrees(result.history[column]))
    assert np.ptp(found["reached", left][201:]) == 0.0  # stuck from 1 s on


def test_an_aircraft_of_one_surface_an_axis_has_it_about_trim():
    result = result_of("beyond/fault-hardover-c172p", "duration_s=2")
    found = curves(titled(drawn(result), "aileron [deg]"))
    np.testing.assert_array_equal(
        found["reached", DEFLECTION["color"].lower()], np.degrees(result.history["aileron_rad"])
    )


def test_what_happened_is_listed_and_numbered_in_the_panels_that_it_concerns():
    result = result_of("scenario3", "duration_s=10")
    figure = drawn(result)
    text = [entry.get_text() for entry in figure.texts]
    windows = result.figure_context().windows
    assert text[0] == "scenario3: nndondi-l1 on hale, jsbsim"
    assert [number for number in text if number.isdigit()] == ["1", "2", "3", "4"]
    assert text[-1].endswith(f"(and {len(windows) - 4} more)")
    numbers = {w.label: str(i) for i, w in enumerate(windows, 1)}
    elevator = {t.get_text() for t in titled(figure, "elevator").texts}
    assert elevator == {numbers[w.label] for w in windows if "elevator" in w.concerns}


def test_how_it_ended_is_at_the_top():
    lost = result_of("beyond/fault-hardover-stop")
    texts = [entry.get_text() for entry in drawn(lost).texts]
    assert "lost at 8.7 s, margin \N{MINUS SIGN}1.56" in texts  # -1 - (20 - 8.7)/20
    assert any(text.startswith("departed in yaw from ") for text in texts)
    nobody = FigureContext("a flight")
    with panels.style(STYLE):
        assert [entry.get_text() for entry in overview(lost.history, nobody).texts] == ["a flight"]


def test_the_air_is_drawn_where_it_moves_and_thrust_where_an_engine_fails():
    windy = drawn(result_of("gust", "duration_s=2", "disturbances[0].start_s=0.5"))
    assert {label for label, _ in curves(titled(windy, "airspeed")) if len(label) == 1} == {"N", "E", "D"}
    assert titled(windy, "flow angles")
    engine = result_of("beyond/engine-loss", "duration_s=2", "faults[0].start_s=0.5")
    found = curves(titled(drawn(engine), "thrust [N]"))
    left = next(y for (label, _), y in found.items() if label == "left motor")
    np.testing.assert_array_equal(left, engine.history["left_motor_thrust_n"])


def test_the_way_is_drawn_over_that_to_the_north():
    result = result_of("scenario3", "duration_s=2")
    ax = titled(drawn(result), "way flown [m]")
    up, east = ax.lines[:2]
    for line, y in (
        (up, result.history["altitude_m"] - result.history["altitude_m"][0]),
        (east, result.history["east_m"]),
    ):
        np.testing.assert_array_equal(line.get_xdata(), result.history["north_m"])
        np.testing.assert_array_equal(line.get_ydata(), y)


def test_a_plant_of_rotation_alone_shows_its_rates_in_the_place_of_the_air():
    figure = drawn(result_of("scenario3", "duration_s=2", plant="analytic"))
    assert [ax.get_title(loc="left") for ax in figure.axes][2::3] == [
        "roll rate [deg/s]", "pitch rate [deg/s]", "yaw rate [deg/s]"
    ]  # fmt: skip


JUDGED = {"completed": True, "ended_because": None, "ended_at_s": None, "verdict": None}
LOST = {"completed": False, "ended_because": "airspeed outside the envelope: 9 m/s, at t = 8.700 s", "ended_at_s": 8.7}


@pytest.mark.parametrize(
    ("document", "expected"),
    [
        ({}, ("completed", "completed")),
        (LOST, ("ended", "ended at 8.7 s: airspeed outside the envelope: 9 m/s")),
        (
            {"verdict": {"outcome": "survived", "margin": 0.414, "limiting": "tracking"}},
            ("survived", "survived, margin 0.41 (tracking)"),
        ),
        (
            {"verdict": {"outcome": "survived", "margin": 1.0, "limiting": None}},
            ("survived", "survived, margin 1.00"),
        ),
        (
            LOST | {"verdict": {"outcome": "lost", "margin": -1.565, "limiting": "flown"}},
            ("lost", "lost at 8.7 s, margin −1.56: airspeed outside the envelope: 9 m/s"),
        ),
    ],
)
def test_the_line_on_how_it_ended(document, expected):
    assert ending_of(JUDGED | document) == expected
