"""The figures are made for every history, and show what happened in it."""

from __future__ import annotations

from pathlib import Path

import matplotlib as mpl
import numpy as np
import pytest
from PIL import Image

from uavftc.report import figures, panels
from uavftc.report.figures import write_figures
from uavftc.report.series import envelope
from uavftc.results.context import FigureContext
from uavftc.results.windows import VEHICLE, FlightWindow


def fault(surface: str, *args, **more) -> FlightWindow:
    axis = {"aileron": {"phi", "p", "f_p"}, "elevator": {"theta", "q", "f_q"}, "rudder": {"psi", "r", "f_r"}}
    return FlightWindow("fault", surface, *args, concerns=frozenset({surface, *axis.get(surface, ())}), **more)


CONTEXT = FigureContext(
    "scenario3: nndondi-l1 on hale, jsbsim",
    limits_rad=dict.fromkeys(("aileron", "elevator", "rudder"), (-0.05, 0.1)),
    windows=[
        fault("aileron", "ω = 0.5", 0.0, 8.0),
        fault("aileron", "ω = 0.8\nbias 0.1 + 0.5*sin(t) deg", 8.0, 12.0),
        fault("rudder", "ω = 0.2*t\nbias 3*cos(0.1*t) deg", 8.0, float("inf")),
    ],
)


def sizes(paths: list[Path]) -> dict[str, tuple[int, int]]:
    found = {}
    for path in paths:
        with Image.open(path) as image:
            image.load()
            found[path.name] = image.size
    return found


def test_four_figures_of_the_size_of_a_slide_and_one_of_all_on_one_page(tmp_path, make_history):
    bare = sizes(write_figures(tmp_path / "bare", make_history(4001), FigureContext("x")))
    assert bare.pop("overview.png") == (900, 600)
    assert bare == {
        "tracking.png": (1650, 1290),
        "control.png": (1650, 1290),
        "estimates.png": (2100, 1290),
        "air.png": (1650, 990),
    }
    paths = write_figures(tmp_path / "figures", make_history(4001), CONTEXT)
    # with a list of three windows in two lines of 0.22 in, a strip of two lanes of 0.19 in, and 0.06 in below each
    higher = {name: (width, height + 141) for name, (width, height) in bare.items()}
    assert sizes(paths) == higher | {"overview.png": (900, 600)}  # of one size, whatever happened


def test_no_figure_of_the_air_without_an_airspeed(tmp_path, make_history):
    history = make_history(50) | {"airspeed_mps": np.full(50, np.nan)}
    assert [p.name for p in write_figures(tmp_path, history, CONTEXT)] == [
        "tracking.png",
        "control.png",
        "estimates.png",
        "overview.png",
    ]


@pytest.mark.parametrize("rows", [0, 1, 2])
def test_a_flight_lost_at_once_is_drawn(tmp_path, make_history, rows):
    assert len(write_figures(tmp_path, make_history(rows), CONTEXT)) >= 3


def test_a_history_of_nothing_but_nan_and_one_without_columns_are_drawn(tmp_path, make_history):
    history = make_history(100)
    empty = {name: v if name == "time_s" else np.full_like(v, np.nan) for name, v in history.items()}
    assert len(write_figures(tmp_path, empty, CONTEXT)) == 4
    assert len(write_figures(tmp_path, {"time_s": history["time_s"]}, CONTEXT)) == 4


def test_a_diverged_end_neither_fails_nor_flattens_the_axes(make_history):
    history = make_history(400)
    history = {name: v.copy() for name, v in history.items()}
    history["phi_rad"][-3:] = 1e300, np.inf, np.nan
    with panels.style():
        top = figures.tracking(history, CONTEXT).axes[0].get_ylim()[1]
    assert top < 10.0  # deg; the reference is 5


@pytest.mark.slow
def test_a_spike_of_one_sample_survives_an_hour(tmp_path, make_history):
    history = make_history(720_000)
    history = {name: v.copy() for name, v in history.items()}
    history["q_radps"][333_333] = 1.0
    with panels.style():
        fig = figures.control(history, CONTEXT)
        line = fig.axes[2].lines[0]
        assert len(line.get_xdata()) < 5_000  # thinned
        assert np.max(line.get_ydata()) == pytest.approx(np.rad2deg(1.0))
    assert sizes(write_figures(tmp_path, history, CONTEXT))["control.png"][0] == 1650


def test_envelope_keeps_extremes_ends_and_order_and_passes_over_nan():
    t = np.arange(100_003.0)
    y = np.sin(t)
    y[5_000], y[70_000], y[-1], y[10:20] = 50.0, -40.0, 0.25, np.nan
    t_thin, y_thin = envelope(t, y, bins=1000)
    assert len(t_thin) <= 2 * 1000 + 2
    assert (np.diff(t_thin) >= 0).all()
    assert t_thin[np.argmax(y_thin)] == 5_000
    assert t_thin[np.argmin(y_thin)] == 70_000
    assert (t_thin[0], t_thin[-1], y_thin[-1]) == (0.0, 100_002.0, 0.25)
    assert np.isfinite(y_thin).all()
    assert np.isnan(envelope(t, np.full_like(y, np.nan))[1]).all()


def test_tracking_is_in_degrees_and_marks_the_convergence_time(make_history):
    with panels.style():
        fig = figures.tracking(make_history(4001), CONTEXT)
    left, right = fig.axes[0], fig.axes[1]
    assert left.lines[1].get_ydata()[0] == pytest.approx(5.0)  # the reference, deg
    assert left.get_ylabel() == r"$\phi$ [deg]"
    (mark,) = [line for line in right.lines if line.get_label() == "converged"]
    # 5 deg exp(-0.5 t) enters 0.02 deg at 2 ln 250 = 11.043 s; the next sample is 11.045 s
    assert mark.get_xdata()[0] == pytest.approx(11.045, abs=1e-9)
    assert right.texts[-1].get_text() == "11.04 s"


def test_no_convergence_mark_when_the_last_row_is_outside(make_history):
    with panels.style():
        fig = figures.tracking(make_history(1000), CONTEXT)
    assert [line for ax in fig.axes for line in ax.lines if line.get_label() == "converged"] == []


def test_control_shows_limits_faults_and_their_labels(make_history):
    with panels.style():
        fig = figures.control(make_history(4001), CONTEXT)
    aileron, elevator, rudder = (fig.axes[i] for i in (1, 3, 5))
    limits = [line.get_ydata()[0] for line in aileron.lines if line.get_label() == "limit"]
    assert limits == pytest.approx([-2.8648, 5.7296], abs=1e-3)
    assert written(aileron) == ["1: ω = 0.5", "2"]  # the second has no room for its three lines: it is in the list
    assert elevator.texts[:] == []
    assert written(rudder) == ["3: ω = 0.2*t\nbias 3*cos(0.1*t) deg"]
    assert shaded(rudder) == [(8.0, 20.0)]  # open-ended: to the end of the flight
    assert shaded(aileron) == [(0.0, 8.0), (8.0, 12.0)]


def written(ax) -> list[str]:
    return [text.get_text().replace("\N{NO-BREAK SPACE}", " ") for text in ax.texts]


def shaded(ax) -> list[tuple[float, float]]:
    return [(p.get_x(), p.get_x() + p.get_width()) for p in ax.patches]


def test_control_shows_each_effector_that_is_not_the_surface_of_an_axis(make_history):
    # of three, two panels in the fourth row and one in the fifth, each with its command, position, limits and faults
    history, t = make_history(4001), np.arange(4001) / 200.0
    for j, name in enumerate(("left_flap", "right_flap", "slat")):
        history[f"{name}_cmd_rad"], history[f"{name}_rad"] = 0.01 * j + 0.001 * t, 0.01 * j + 0.0005 * t
    windows = [fault("right_flap", "ω = 0.1", 2.0, 4.0)]
    with panels.style():
        fig = figures.control(history, FigureContext("x", limits_rad={"slat": (-0.01, 0.05)}, windows=windows))
    left, right, slat, hidden = fig.axes[6:10]
    assert [ax.get_title("left") for ax in (left, right, slat)] == ["(g) left flap", "(h) right flap", "(i) slat"]
    assert not hidden.get_visible()
    command, position = (line.get_ydata() for line in right.lines[:2])
    np.testing.assert_allclose((command[-1], position[-1]), np.degrees((0.01 + 0.02, 0.01 + 0.01)), rtol=1e-12)
    assert (len(left.patches), len(right.patches), len(slat.patches)) == (0, 1, 0)
    limits = [line.get_ydata()[0] for line in slat.lines if line.get_label() == "limit"]
    np.testing.assert_allclose(limits, np.degrees([-0.01, 0.05]))
    assert fig.get_size_inches()[1] > 8.6


def test_limits_far_away_are_named_and_do_not_flatten_the_curve(make_history):
    far = FigureContext("x", limits_rad={"aileron": (-0.6, 0.6)})
    with panels.style():
        fig = figures.control(make_history(4001), far)
    assert fig.axes[1].get_title(loc="right") == "off scale: limit −34.4, +34.4"
    assert fig.axes[1].get_ylim()[1] < 10.0


def test_a_limit_on_one_side_is_drawn_alone(make_history):
    with panels.style():
        fig = figures.control(make_history(4001), FigureContext("x", limits_rad={"aileron": (-np.inf, 0.1)}))
    assert [line.get_ydata()[0] for line in fig.axes[1].lines if line.get_label() == "limit"] == pytest.approx(
        [np.rad2deg(0.1)]
    )
    assert fig.axes[1].get_title(loc="right") == ""


def test_noise_of_rounding_is_not_magnified(make_history):
    history = make_history(500)
    history["d1_hat_phi_radps"] = 1e-17 * np.sin(np.arange(500.0))
    with panels.style():
        low, high = figures.estimates(history, CONTEXT).axes[0].get_ylim()
    assert high - low >= 0.1  # deg/s


def test_moving_air_has_panels_below_the_throttle(make_history):
    with panels.style():
        calm = figures.air(make_history(10), FigureContext("x"))
        wind = FlightWindow("air", "", "wind, north 3 m/s", 0.0, 9.0, VEHICLE | {"wind"})
        windy = figures.air(make_history(10), FigureContext("x", windows=[wind]))
    titles = [[ax.get_title(loc="left") for ax in fig.axes] for fig in (calm, windy)]
    assert titles[0] == ["(a) airspeed", "(b) altitude", "(c) flow angles", "(d) throttle"]
    assert titles[1][:6] == [*titles[0], "(e) wind", "(f) rotation of air"]
    assert next(text.get_text() for text in windy.axes[5].texts) == "this air does not turn"


def test_names_with_mathematics_and_the_users_own_settings_do_no_harm(tmp_path, make_history):
    context = FigureContext("a $x_{$ b", windows=[fault("rudder", "half $of{$ x", 0.0, 9.0)])
    with mpl.rc_context({"font.size": 3.0, "text.usetex": True}):
        write_figures(tmp_path / "user", make_history(20), context)
        assert mpl.rcParams["font.size"] == 3.0
    write_figures(tmp_path / "plain", make_history(20), context)
    for name in ("tracking.png", "control.png"):
        assert (tmp_path / "user" / name).read_bytes() == (tmp_path / "plain" / name).read_bytes()
