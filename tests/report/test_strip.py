"""What happened is seen in every figure: listed by number, in a strip above the panels, shaded where it concerns."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure

from uavftc.core.layout import OwnSignal
from uavftc.report import figures, palette, panels
from uavftc.report.air_figure import air
from uavftc.report.overlays import commands, tracking, write_overlays
from uavftc.report.overview import overview
from uavftc.report.palette import looks
from uavftc.report.signals_figure import custom
from uavftc.report.strip import TOLD, mark, new_figure
from uavftc.results.context import FigureContext
from uavftc.results.windows import ENGINE, VEHICLE, FlightWindow

FAULT = FlightWindow("fault", "aileron", "ω = 0.5", 2.0, 6.0, frozenset({"aileron", "phi", "p", "f_p"}))
NEXT = FAULT._replace(label="ω = 0.8", start_s=6.0, end_s=8.0, known_from_s=6.5, known_until_s=8.5)
BROKEN = FlightWindow("damage", "damage", "left tip", 12.0, 20.0, VEHICLE)
GUST = FlightWindow("air", "", "gust, down -4 m/s", 9.0, 10.0, VEHICLE | {"wind"})
ENGINE_LOST = FlightWindow("engine", "engine 1", "lost", 15.0, 20.0, ENGINE)
NOISE = FlightWindow("sensor", "gyro", "bias 0.3 deg/s", 0.0, 20.0)
ALL = (NOISE, FAULT, NEXT, GUST, BROKEN, ENGINE_LOST)
SIGNAL = OwnSignal("sigma", "rad", ("sigma_rad",))


def drawn(history, context) -> dict[str, Figure]:
    history = history | {"sigma_rad": np.zeros_like(history["time_s"])}
    draw = {"tracking": figures.tracking, "control": figures.control, "estimates": figures.estimates, "air": air}
    with panels.style():
        return {name: one(history, context) for name, one in draw.items()} | {
            "custom": custom(history, replace(context, signals=[SIGNAL])),
            "overlay": tracking({("jsbsim", "pid"): history}, context),
            "commands": commands({("jsbsim", "pid"): history}, context),
        }


def parts(figure: Figure) -> tuple[list, list, list]:
    """Return the panels of a figure, the list of its windows and its strips."""
    labelled = [ax for ax in figure.axes if ax.get_title("left") or ax.get_title("center")]
    rest = [ax for ax in figure.axes if ax not in labelled and ax.get_visible()]
    return labelled, rest[:1], rest[1:]


def texts(ax) -> list[str]:
    return [text.get_text().replace("\N{NO-BREAK SPACE}", " ") for text in ax.texts]


def shaded(ax) -> list[tuple[float, float]]:
    return [(p.get_x(), p.get_x() + p.get_width()) for p in ax.patches if p.get_x() > -1e-9]


def test_every_figure_lists_every_window_with_its_time(make_history):
    for name, figure in drawn(make_history(4001), FigureContext("x", windows=ALL)).items():
        _, (listed,), strips = parts(figure)
        assert set(texts(listed)[1::2]) == {
            "gyro: bias 0.3 deg/s (all flight)",
            "aileron: ω = 0.5 (2 to 6 s)",
            "aileron: ω = 0.8 (6 to 8 s, known from 6.5 s)",
            "gust, down -4 m/s (9 to 10 s)",
            "damage: left tip (from 12 s)",
            "engine 1: lost (from 15 s)",
        }, name
        assert len(texts(listed)) == 2 * len(ALL), name  # a number and a text each
        for strip in strips:
            assert sorted(shaded(strip)) == sorted((w.start_s, w.end_s) for w in ALL), name
            assert {text.split("  ")[0] for text in texts(strip)} == {"1", "2", "3", "4", "5", "6"}, name


def test_a_panel_shades_what_concerns_it_and_numbers_it(make_history):
    both = [(2.0, 6.0), (6.0, 8.0)]
    whole = [(9.0, 10.0), (12.0, 20.0)]
    figure = drawn(make_history(4001), FigureContext("x", windows=ALL))
    roll, _, pitch = figure["tracking"].axes[:3]
    assert shaded(roll) == [*both, *whole]
    assert texts(roll) == ["2", "3", "4", "5"]
    assert shaded(pitch) == whole
    rate, aileron, _, elevator = figure["control"].axes[:4]
    assert shaded(rate) == [*both, *whole]
    assert (shaded(aileron), texts(aileron)) == (both, ["2: ω = 0.5", "3"])  # the second has no room
    assert shaded(elevator) == []
    speed, height, flow, throttle, wind = figure["air"].axes[:5]
    assert shaded(speed) == shaded(height) == [*whole, (15.0, 20.0)]
    assert (shaded(flow), shaded(throttle), shaded(wind)) == (whole, [(15.0, 20.0)], [(9.0, 10.0)])
    assert shaded(figure["custom"].axes[0]) == [*both, *whole, (15.0, 20.0)]  # which signals it is about, nobody knows
    assert shaded(figure["commands"].axes[0]) == both


def test_consecutive_windows_differ_in_shade_and_an_edge_is_between_them(make_history):
    ax = drawn(make_history(4001), FigureContext("x", windows=ALL))["control"].axes[1]
    first, second = ax.patches[:2]
    assert first.get_facecolor()[:3] == second.get_facecolor()[:3]  # one kind, one colour
    assert second.get_facecolor()[3] == 2.0 * first.get_facecolor()[3]
    edges = [
        line.get_xdata()[0] for line in ax.lines if len(set(line.get_xdata())) == 1 and line.get_linestyle() == "-"
    ]
    assert sorted(set(edges)) == [2.0, 6.0, 8.0]


def test_the_moment_at_which_the_controller_is_told_is_marked(make_history):
    figure = drawn(make_history(4001), FigureContext("x", windows=ALL))["control"]
    (mark_,) = [line for line in figure.axes[1].lines if line.get_label() == TOLD]
    assert list(mark_.get_xdata()) == [6.5]
    assert TOLD in [text.get_text() for legend in figure.legends for text in legend.get_texts()] + [
        text.get_text() for ax in figure.axes if ax.get_legend() for text in ax.get_legend().get_texts()
    ]
    strip = parts(figure)[2][0]
    spans = [tuple(line.get_xdata()) for line in strip.lines]
    assert spans == [(6.5, 8.5)]  # it knows of the end as late as of the beginning


def test_windows_at_the_same_time_stand_in_lanes_and_the_panel_makes_room_for_their_numbers(make_history):
    late = FAULT._replace(start_s=3.0)
    with panels.style():
        one = figures.tracking(make_history(4001), FigureContext("x", windows=[FAULT])).axes[0]
        two = figures.tracking(make_history(4001), FigureContext("x", windows=[FAULT, late])).axes[0]
    heights = [text.get_position()[1] for text in two.texts]
    assert heights[0] > heights[1]
    assert two.get_ylim()[1] > one.get_ylim()[1] > 5.0


def test_a_figure_of_many_windows_lists_as_many_as_have_room_and_says_how_many_more():
    windows = [FAULT._replace(start_s=0.5 * i, end_s=0.5 * i + 0.4) for i in range(30)]
    with panels.style():
        fig, _ = new_figure(FigureContext("x", windows=windows), np.linspace(0.0, 20.0, 9), 1, 1, (11.0, 4.0))
    (listed,) = [ax for ax in fig.axes if "and 15 more windows: scenario.yaml" in texts(ax)]
    assert len(listed.texts) == 2 * 16


def test_windows_outside_what_was_flown_are_neither_listed_nor_drawn(make_history):
    with panels.style():
        figure = figures.tracking(make_history(1001), FigureContext("x", windows=ALL))  # 5 s of it
    _, (listed,), strips = parts(figure)
    assert [text.split(":")[0] for text in texts(listed)[1::2]] == ["gyro", "aileron"]
    assert shaded(strips[0]) == [(0.0, 5.0), (2.0, 5.0)]
    assert shaded(figure.axes[0]) == [(2.0, 5.0)]


def test_a_flight_in_which_nothing_happens_has_neither_list_nor_strip(make_history):
    with panels.style():
        assert len(figures.tracking(make_history(100), FigureContext("x")).axes) == 6


def test_the_limiting_moment_is_named_and_marked_in_every_panel_of_every_figure(make_history):
    context = FigureContext("x", limiting=("tracking", 12.4))
    found = drawn(make_history(4001), context)
    for name in ("tracking", "control", "estimates", "air", "custom"):
        figure = found[name]
        named = [ax for ax in figure.axes if "limiting: tracking (12.4 s)" in texts(ax)]
        assert len(named) == 1, name
        for ax in figure.axes:
            if ax is not named[0] and ax.get_visible():
                assert [12.4, 12.4] in [list(line.get_xdata()) for line in ax.lines], name


def test_the_twin_is_not_named_in_the_legend_of_one_panel(make_history):
    twin = make_history(4001)
    with panels.style():
        found = [air(twin, FigureContext("x", twin=twin)), overview(twin, FigureContext("x", twin=twin))]
    for figure in found:
        named = [t.get_text() for ax in figure.axes if ax.get_legend() for t in ax.get_legend().get_texts()]
        assert panels.WITHOUT not in named
        beneath = [t.get_text() for legend in figure.legends for t in legend.get_texts()]
        assert beneath.count(panels.WITHOUT) == 1


def test_the_twin_lies_beneath_every_signal_and_may_be_longer(make_history, tmp_path: Path):
    history, twin = make_history(2001), make_history(4001)
    twin = {name: values + (0.0 if name == "time_s" else 1e-3) for name, values in twin.items()}
    found = drawn(history, FigureContext("x", twin=twin | {"sigma_rad": np.full(4001, 0.1)}))
    counts = {"tracking": 6, "control": 6, "estimates": 6, "air": 5, "custom": 1}
    for name, count in counts.items():
        beneath = [line for ax in found[name].axes for line in ax.lines if len(line.get_xdata()) == 4001]
        assert len(beneath) == count, name
        for line in beneath:
            assert line.get_color() == palette.TWIN["color"]
            assert line.get_zorder() < 2.0  # that of a curve
        assert found[name].axes[0].get_xlim() == (0.0, 10.0), name
    line = next(line for line in found["tracking"].axes[0].lines if len(line.get_xdata()) == 4001)
    np.testing.assert_allclose(line.get_ydata(), np.degrees(twin["phi_rad"]), rtol=1e-12)
    names = [t.get_text() for ax in found["tracking"].axes if ax.get_legend() for t in ax.get_legend().get_texts()]
    assert panels.WITHOUT in names
    # those of one flight are not shown in a comparison
    with panels.style():
        keys = {("jsbsim", "pid"): history, ("jsbsim", "lqi"): history}
        write_overlays(tmp_path / "figures", keys, FigureContext("x", twin=twin, limiting=("a", 1.0)))


# --- curves ----------------------------------------------------------------------------------------------------------


def test_no_line_is_drawn_where_a_heading_wraps(make_history):
    history = make_history(4001)
    t = history["time_s"]
    history["psi_rad"] = np.radians((30.0 * t + 180.0) % 360.0 - 180.0)  # once around in 12 s
    history["psi_ref_rad"] = 0.0 * t
    with panels.style():
        psi = figures.tracking(history, FigureContext("x")).axes[4].lines[0]
        over = tracking({("jsbsim", "pid"): history}, FigureContext("x")).axes[4].lines[0]
    for line in (psi, over):
        x, y = line.get_xdata(), line.get_ydata()
        assert list(x[np.isnan(y)]) == [6.0, 18.0]  # at +180 deg, after 6 s and one turn later
        steps = np.abs(np.diff(y))
        assert np.nanmax(steps) < 1.0
        assert len(y) == 4001 + 2  # not a sample is lost


def test_a_roll_through_more_than_half_a_turn_in_a_sample_is_drawn(make_history):
    history = make_history(100) | {"phi_rad": np.where(np.arange(100) < 50, 0.0, 3.3)}
    with panels.style():
        assert not np.isnan(figures.tracking(history, FigureContext("x")).axes[0].lines[0].get_ydata()).any()


def test_a_spike_is_named_off_scale_and_does_not_hide_the_rest(make_history):
    history = make_history(4001)
    history["f_hat_q_radps2"] = np.radians(np.sin(history["time_s"]))
    history["f_hat_q_radps2"][2000:2008] = np.radians(400.0)  # 0.2 per cent of the flight
    with panels.style():
        ax = figures.estimates(history, FigureContext("x")).axes[4]
    assert ax.get_title("right") == "off scale: to +400"
    assert ax.get_ylim()[1] < 10.0


def test_what_lasts_longer_than_a_spike_is_shown_whole(make_history):
    history = make_history(4001)
    history["f_hat_q_radps2"] = np.radians(np.sin(history["time_s"]))
    history["f_hat_q_radps2"][2000:2200] = np.radians(400.0)  # a second
    with panels.style():
        ax = figures.estimates(history, FigureContext("x")).axes[4]
    assert ax.get_title("right") == ""
    assert ax.get_ylim()[1] > 400.0


@pytest.mark.parametrize(
    ("limits", "top"),
    # a span of 0.15 rad beyond the limit of 0.1 rad; 30 deg beyond the deflection where nothing limits it
    [({"aileron": (-0.05, 0.1)}, np.degrees(0.25)), ({}, np.degrees(0.1) + 30.0)],
)
def test_a_command_that_winds_up_is_clipped_and_named(make_history, limits, top):
    history = make_history(4001)
    history["aileron_cmd_rad"] = np.radians(np.linspace(0.0, 837.0, 4001))
    history["aileron_rad"] = np.minimum(history["aileron_cmd_rad"], 0.1)
    with panels.style():
        ax = figures.control(history, FigureContext("x", limits_rad=limits)).axes[1]
    assert ax.get_title("right") == "off scale: to +837"
    low, high = ax.get_ylim()
    assert top < high < top + 0.07 * (high - low)


def test_an_observer_that_finds_nothing_is_said_to_be_idle_and_one_that_works_is_not(make_history):
    history = make_history(400)
    t = history["time_s"]
    history["d1_hat_phi_radps"], history["d1_hat_theta_radps"] = 1e-12 * np.sin(t), np.radians(0.2 * np.sin(t))
    history["d1_hat_psi_radps"] = np.full_like(t, np.nan)
    with panels.style():
        axes = figures.estimates(history, FigureContext("x")).axes
    assert texts(axes[0])[0].startswith("observer idle: at most $6")
    assert texts(axes[3]) == []
    assert texts(axes[6]) == ["this controller makes no estimate"]


def test_effectiveness_that_stays_one_is_said_to(make_history):
    history = make_history(400) | {"effectiveness_rudder": np.ones(400)}
    with panels.style():
        axes = figures.estimates(history, FigureContext("x")).axes
    assert (texts(axes[2]), texts(axes[8])) == ([], [r"$\omega$ = 1 all flight"])


def test_what_the_controller_is_shown_is_drawn_where_a_sensor_errs(make_history):
    history = make_history(400)
    history["p_meas_radps"] = history["p_radps"] + 0.01
    with panels.style():
        exact = figures.control(history, FigureContext("x")).axes[0]
        wrong = figures.control(history, FigureContext("x", windows=[NOISE])).axes[0]
    assert "as measured" not in [line.get_label() for line in exact.lines]
    (line,) = [line for line in wrong.lines if line.get_label() == "as measured"]
    np.testing.assert_allclose(line.get_ydata(), np.degrees(history["p_meas_radps"]), rtol=1e-12)


# --- colours ---------------------------------------------------------------------------------------------------------


def luminance(colour: str) -> float:
    red, green, blue = (int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5))
    return 0.2126 * red + 0.7152 * green + 0.0722 * blue


def test_six_controllers_differ_in_colour_line_and_marker_and_are_no_hair():
    names = ["nndondi-l1", "ndi-l1", "nndondi-mrac", "ndi-mrac", "pid", "lqi"]
    found = looks([("jsbsim", name) for name in names])
    for key in ("color", "linestyle", "marker"):
        assert len({str(look[key]) for look in found.values()}) == 6, key
    assert min(look["linewidth"] for look in found.values()) >= 1.4


def test_a_controller_has_its_colour_in_every_comparison_and_others_take_the_free_ones():
    pair = looks([("jsbsim", "lqi"), ("jsbsim", "mine"), ("jsbsim", "pid")])
    alone = looks([("analytic", "pid"), ("jsbsim", "pid"), ("jsbsim", "lqi"), ("analytic", "lqi")])
    for name in ("pid", "lqi"):
        assert pair["jsbsim", name]["color"] == alone["jsbsim", name]["color"] == alone["analytic", name]["color"]
    assert len({look["color"] for look in pair.values()}) == 3
    assert alone["analytic", "pid"]["linestyle"] != alone["jsbsim", "pid"]["linestyle"]  # the plant


def test_seven_controllers_are_told_apart():
    found = looks([("jsbsim", f"mine{i}") for i in range(7)])
    assert len({(look["color"], str(look["linestyle"])) for look in found.values()}) == 7


def test_what_shares_a_panel_differs_in_grey():
    # attitude and reference; the components of a vector: by the line, for the greys are near each other
    assert palette.ACTUAL.get("linestyle", "-") == "-"
    assert palette.REFERENCE["linestyle"] != "-"
    assert palette.ACTUAL["linewidth"] > palette.REFERENCE["linewidth"]
    assert len({str(look["linestyle"]) for look in palette.SEVERAL}) == len(palette.SEVERAL)
    for shade in palette.KINDS.values():
        assert luminance(shade.dark) < 0.45  # a text on white


def test_the_kinds_of_window_have_colours_of_their_own():
    assert len({shade.colour for shade in palette.KINDS.values()}) == 6


def test_plain_marks_shade_what_begins_and_ends_together_once():
    windows = [FAULT, FAULT._replace(what="elevator", concerns=frozenset({"elevator"}))]
    ax = Figure().subplots()
    ax.set_xlim(0.0, 20.0)
    mark(ax, FigureContext("x", windows=windows), "aileron", "elevator", plain=True)
    assert shaded(ax) == [(2.0, 6.0)]
    assert (texts(ax), ax.patches[0].get_label()) == ([], "fault on a surface")
