"""Figures 2 to 11: the paper's panels, units and legends, and nothing that noise or chatter could spoil."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from flying import flown
from uavftc.analysis.metrics import metrics_of
from uavftc.jobs.campaign.pool import Flown
from uavftc.jobs.paper.figures import CAPTIONS, PRINT, draw, figure_2, write_figures
from uavftc.report import panels
from uavftc.results.history import published

CASES = [("scenario1", "nndondi-l1"), ("scenario1-unsaturated", "nndondi-l1")] + [
    (scenario, controller)
    for scenario in ("scenario2", "scenario3")
    for controller in ("nndondi-l1", "ndi-l1", "nndondi-mrac")
]
OUTER, INNER = "$v_1$ [deg/s]", "$v_2$ [rad]"
D1, F = r"$\hat d_1$ [deg/s]", r"$\hat f$ [deg/s$^2$]"


@pytest.fixture(scope="module")
def flights() -> dict[tuple[str, str], Flown]:
    return {case: as_flown(*case) for case in CASES}


def as_flown(scenario: str, controller: str) -> Flown:
    flight, records, outcome = flown(scenario, "analytic", controller)
    return Flown(flight.scenario, outcome, metrics_of(records), published(records), flight.plant.settings)


def drawn(number: int, flights):
    with panels.style(PRINT):
        return draw(number, flights)


def changed(flights, key, **columns):
    """The flights with some columns of one of them multiplied or replaced."""
    history = flights[key].history | columns
    return flights | {key: flights[key]._replace(history=history)}


def titles(figure) -> list[str]:
    return [ax.get_title(loc="left") for ax in figure.axes]


def units(figure) -> list[str]:
    return [ax.get_ylabel() for ax in figure.axes]


def legend(figure) -> list[str]:
    return [text.get_text() for text in figure.legends[0].get_texts()]


@pytest.mark.slow
def test_ten_figures_as_png_and_pdf_at_the_width_of_a_page(tmp_path: Path, flights):
    paths = write_figures(tmp_path / "figures", flights, prefix="analytic-")
    names = [f"analytic-figure-{n:02d}.{kind}" for n in range(2, 12) for kind in ("png", "pdf")]
    assert [p.name for p in paths] == names
    assert sorted(p.name for p in (tmp_path / "figures").iterdir()) == sorted(names)
    for path in paths[::2]:
        with Image.open(path) as image:
            assert image.size[0] == pytest.approx(170 / 25.4 * 200, abs=1)
            assert 500 < image.size[1] < 1200  # not more than three quarters of a page
    for path in paths[1::2]:
        pdf = path.read_bytes()
        assert pdf.startswith(b"%PDF")
        assert b"/FontFile2" in pdf  # fonts are embedded, as TrueType
        assert b"/Type3" not in pdf
        assert len(pdf) < 400_000


def test_captions_are_the_papers():
    assert list(CAPTIONS) == list(range(2, 12))
    assert CAPTIONS[6] == (
        "Tracking performance in scenario 2. (a) Tracking curves of roll angle; (b) tracking curves of pitch angle; "
        "(c) tracking curves of yaw angle."
    )
    assert CAPTIONS[5].endswith("(d) lumped disturbance estimations for the inner loop with input saturation.")
    assert CAPTIONS[10].endswith("(d) control outputs of the inner loop of NNDONDI-MRAC controller.")


def test_figure_2_is_the_saturation_and_the_tanh_beneath_it():
    (ax,) = figure_2().axes
    hard, smooth = ax.lines[:2]
    at = dict(zip(np.round(hard.get_xdata(), 6), zip(hard.get_ydata(), smooth.get_ydata(), strict=True), strict=True))
    assert at[1.5] == pytest.approx((1.0, np.tanh(1.5)))
    assert at[-0.5] == pytest.approx((-0.5, -0.5 * np.tanh(1.0)))
    assert at[0.0] == (0.0, 0.0)
    assert [text.get_text() for text in ax.get_legend().get_texts()] == ["sat($v_2$)", "h($v_2$)"]
    (ax,) = figure_2(lambda v, u_min, u_max: np.full_like(v, u_min + u_max)).axes
    assert set(ax.lines[1].get_ydata()) == {0.5}


@pytest.mark.parametrize("number", [3, 6, 9])
def test_tracking_has_three_lettered_panels_in_degrees_and_the_errors_next_to_them(flights, number):
    figure = drawn(number, flights)
    assert titles(figure)[::2] == ["(a) Roll angle", "(b) Pitch angle", "(c) Yaw angle"]
    assert titles(figure)[1::2] == ["Roll error", "Pitch error", "Yaw error"]
    assert units(figure)[::2] == [r"$\phi$ [deg]", r"$\theta$ [deg]", r"$\psi$ [deg]"]
    assert {ax.get_xlabel() for ax in figure.axes[-2:]} == {"time [s]"}
    (reference,) = (line for line in figure.axes[0].lines if line.get_label() == "reference")
    assert reference.get_ydata()[0] == pytest.approx(5.0)
    assert all(ax.get_yscale() == "log" for ax in figure.axes[1::2])
    assert "analytic model" in figure.get_suptitle()
    names = {
        3: ["without saturation", "with saturation (coincides)"],
        6: ["NNDONDI-L1", "NDI-L1 (coincides with NNDONDI-L1)", "NNDONDI-MRAC"],
    }
    faults = ["fault on a surface"] if number == 9 else []  # scenario 3 alone has any
    assert legend(figure) == [*names[min(number, 6)], "reference", *faults, "error within 0.02 deg"]
    shown = [[(p.get_x(), p.get_x() + p.get_width()) for p in ax.patches if p.get_x() > -1] for ax in figure.axes[::2]]
    both, late = [(0.0, 8.0), (8.0, 12.0)], [(8.0, 12.0)]  # of aileron and elevator, and of the rudder
    assert shown == ([both, both, late] if faults else [[], [], []])


def test_a_curve_that_does_not_coincide_is_not_said_to(flights):
    key = ("scenario2", "ndi-l1")
    moved = changed(flights, key, phi_rad=flights[key].history["phi_rad"] + np.radians(0.01))
    assert legend(drawn(6, moved))[1] == "NDI-L1"


@pytest.mark.parametrize(("number", "outer", "inner"), [(4, OUTER, INNER), (5, D1, F)])
def test_scenario_1_has_the_outer_loop_above_and_saturation_to_the_right(flights, number, outer, inner):
    figure = drawn(number, flights)
    assert titles(figure) == [
        "(a) Outer loop, without saturation", "(b) Outer loop, with saturation",
        "(c) Inner loop, without saturation", "(d) Inner loop, with saturation",
    ]  # fmt: skip
    assert units(figure) == [outer, outer, inner, inner]


@pytest.mark.parametrize(("number", "outer", "inner"), [(7, OUTER, INNER), (10, OUTER, INNER), (8, D1, F), (11, D1, F)])
def test_scenarios_2_and_3_have_l1_above_mrac(flights, number, outer, inner):
    figure = drawn(number, flights)
    assert titles(figure) == [
        "(a) Outer loop, NNDONDI-L1", "(b) Inner loop, NNDONDI-L1",
        "(c) Outer loop, NNDONDI-MRAC", "(d) Inner loop, NNDONDI-MRAC",
    ]  # fmt: skip
    assert units(figure) == [outer, inner, outer, inner]
    rates = figure.axes[0].lines[0].get_ydata()
    if number == 7:
        assert rates[0] == pytest.approx(2.5)  # 0.5 1/s times 5 deg
    three = ["$p_c$, aileron", "$q_c$, elevator", "$r_c$, rudder"] if inner == INNER else ["roll", "pitch", "yaw"]
    assert legend(figure)[:3] == three


def test_the_limits_are_drawn_where_there_are_any(flights):
    figure = drawn(4, flights)
    limits = [
        sorted(line.get_ydata()[0] for line in ax.lines if line.get_label() == "saturation limit") for ax in figure.axes
    ]
    assert limits == [[], [], [], [-0.05, 0.1]]
    assert legend(figure)[3] == "saturation limit"
    assert figure.axes[2].get_ylim() == figure.axes[3].get_ylim()


def test_a_command_far_beyond_the_limits_leaves_the_others_legible(flights):
    key = ("scenario3", "nndondi-l1")
    far = changed(flights, key, aileron_cmd_rad=20.0 * flights[key].history["aileron_cmd_rad"])
    panel = drawn(10, far).axes[1]
    assert panel.get_title(loc="right").startswith("off scale: to ")
    assert panel.get_ylim()[1] <= 0.25 + 1e-9


def test_rounding_noise_is_drawn_as_zero_and_the_observer_said_to_be_idle(flights):
    for ax in drawn(8, flights).axes[::2]:
        assert ax.get_ylim()[1] > 0.05  # deg/s
        assert max(np.abs(line.get_ydata()).max() for line in ax.lines) < 1e-4
        assert not ax.collections
        (note,) = ax.texts
        assert note.get_text().startswith("observer idle: at most $")


def test_an_observer_at_work_is_not_said_to_be_idle(flights):
    key = ("scenario2", "nndondi-l1")
    t = flights[key].history["time_s"]
    busy = changed(flights, key, d1_hat_phi_radps=np.radians(0.3 * np.sin(t)))
    working, idle = drawn(8, busy).axes[::2]
    assert not working.texts
    assert len(idle.texts) == 1


def test_chatter_is_a_band(flights):
    # effectiveness over 1 from 8 to 12 s: MRAC's rudder chatters, L1's does not
    figure = drawn(10, flights)
    _, l1, _, mrac = figure.axes
    assert not l1.collections
    assert mrac.collections
    assert "range of chatter" in legend(figure)


def test_a_lost_flight_is_drawn_as_far_as_it_went_and_says_so(flights):
    key = ("scenario3", "nndondi-mrac")
    whole = flights[key]
    history = {name: values[:500] for name, values in whole.history.items()}
    outcome = whole.outcome._replace(completed=False, ended_because="lost", ended_at_s=2.495)
    figure = drawn(11, flights | {key: whole._replace(history=history, outcome=outcome)})
    assert titles(figure)[3] == "(d) Inner loop, NNDONDI-MRAC, lost at 2.5 s"
    assert figure.axes[3].get_xlim() == (0.0, 20.0)


def test_a_missing_flight_is_named_before_anything_is_drawn(tmp_path, flights):
    some = {key: value for key, value in flights.items() if key != ("scenario3", "ndi-l1")}
    with pytest.raises(KeyError, match="no flight of scenario3 by ndi-l1"):
        write_figures(tmp_path / "figures", some)
    assert not (tmp_path / "figures").exists()
