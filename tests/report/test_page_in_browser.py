"""report.html in a headless Chromium: drawn, moved, linked, turned dark, narrow, printed; one browser for all tests."""

from __future__ import annotations

import base64
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from report.browser import Page, browser, missing
from report.test_page import campaign, hostile_page
from uavftc.cli.app import umbrella
from uavftc.results.history import read_history

lacking = missing()
pytestmark = pytest.mark.skipif(lacking is not None, reason=lacking or "")

WIDE, PHONE = (1280, 900), (400, 800)


@pytest.fixture(scope="module")
def chromium() -> Iterator[Page]:
    with browser() as page:
        page.size(*WIDE)
        page.prefers("light")
        yield page


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    """Return the results of scenario 3 over 60 s, with their page."""
    out = tmp_path_factory.mktemp("page") / "flight"
    arguments = ["fly", "scenario3", "--set", "duration_s=60", "--report", "--no-plots", "--quiet", "--out", str(out)]
    assert CliRunner().invoke(umbrella, arguments).exit_code == 0
    return out


@pytest.fixture(scope="module")
def opened(chromium: Page, folder: Path) -> Page:
    """Return the page of the flight, opened once for the tests that follow; each puts back what it changes."""
    assert (folder / "report.html").stat().st_size < 6_000_000
    chromium.open(folder / "report.html")
    return chromium


def set_time(page: Page, t: float) -> None:
    page.run(
        "const s = document.getElementById('time'); s.value = arguments[0]; s.dispatchEvent(new Event('input'))", t
    )


def attitude(page: Page) -> list[float]:
    return [float(word) for word in page.run("return document.getElementById('view').dataset.attitude").split()]


def ranges(page: Page) -> list[list[float]]:
    return page.run("return uavftc.plots.flatMap(p => p.group.panels.map((_, i) => "
                    "p.place._fullLayout['xaxis' + (i ? i + 1 : '')].range.map(Number)))")  # fmt: skip


def test_all_plots_are_drawn_and_the_console_is_silent(opened):
    assert opened.said() == []
    assert opened.run("return performance.getEntriesByType('resource').length") == 0  # nothing is loaded
    drawn = opened.run("return uavftc.plots.map(p => [p.group.key,"
                       "p.group.panels.reduce((n, q) => n + q.curves.length, 0),"
                       "p.place.querySelectorAll('.scatterlayer .trace .js-line').length])")  # fmt: skip
    assert [key for key, _, _ in drawn] == ["attitude", "effectors", "rates", "engines", "air", "estimates"]
    for key, curves, lines in drawn:
        assert lines == curves > 0, key


def test_windows_are_shaded_and_named(opened):
    # the roll angle has the two faults of the aileron, 0-8 and 8-12 s, by their numbers
    shaded = opened.run("return uavftc.plots[0].place.layout.shapes.filter(s => s.type === 'rect' && s.xref === 'x')"
                        ".map(s => [s.label.text, s.x0, s.x1])")  # fmt: skip
    assert shaded == [["1", 0, 8], ["4", 8, 12]]
    bars = opened.run("return [...document.querySelectorAll('.bar')].map(b => b.textContent)")
    assert len(bars) == 8
    assert bars[0] == "1  aileron: ω = 0.5"


def test_the_slider_moves_the_aircraft_to_where_the_history_has_it(opened, folder):
    history = read_history(folder / "history.parquet")
    seen = []
    for t in (0.0, 2.0, 9.0, 60.0):
        set_time(opened, t)
        k = int(np.searchsorted(history["time_s"], t))
        expected = np.degrees([history[f"{angle}_rad"][k] for angle in ("phi", "theta", "psi")])
        np.testing.assert_allclose(attitude(opened), expected, atol=0.02)
        seen.append(opened.run("return document.getElementById('view').toDataURL()"))
        shown = opened.run("return document.querySelector('#readout td').textContent")  # the roll angle
        assert float(shown) == pytest.approx(expected[0], abs=0.02)
    assert len(set(seen)) == 4
    line = opened.run("const c = uavftc.plots[0].place.querySelector('.cursor'); return c.getBoundingClientRect().x")
    right = opened.run(
        "const r = uavftc.plots[0].place.querySelector('.nsewdrag').getBoundingClientRect(); return r.right"
    )
    assert abs(line - right) < 2.5  # the end of the flight


def test_keys_reach_slider_view_and_buttons(opened):
    from selenium.webdriver.common.by import By
    from selenium.webdriver.common.keys import Keys

    set_time(opened, 5.0)
    slider = opened.driver.find_element(By.ID, "time")
    slider.send_keys(Keys.ARROW_RIGHT)
    assert opened.run("return uavftc.clock.t") == pytest.approx(5.005, abs=1e-6)  # a sample of 200 Hz further
    before = opened.run("return document.getElementById('view').toDataURL()")
    opened.driver.find_element(By.ID, "view").send_keys(Keys.ARROW_LEFT)
    assert opened.run("return document.getElementById('view').toDataURL()") != before
    opened.driver.find_element(By.ID, "play").send_keys(Keys.ENTER)
    opened.until("return uavftc.clock.t > 5.05")
    opened.driver.find_element(By.ID, "play").send_keys(Keys.ENTER)
    stopped = opened.run("return uavftc.clock.t")
    assert opened.run("return document.getElementById('play').getAttribute('aria-pressed')") == "false"
    assert opened.run("return uavftc.clock.t") == stopped
    reached = opened.run("return [...document.querySelectorAll('a, button, input, select, canvas, summary')]"
                         ".every(e => e.tabIndex >= 0)")  # fmt: skip
    assert reached


def test_the_time_axes_of_all_plots_are_one(opened):
    script = "const done = arguments[0]; Plotly.relayout(uavftc.plots[2].place, {'xaxis.range': [7, 13]})"
    opened.driver.execute_async_script(f"{script}.then(() => setTimeout(done, 50))")
    opened.until("return uavftc.plots.every(p => Math.abs(p.place._fullLayout.xaxis.range[0] - 7) < 1e-9)")
    assert ranges(opened) == [[7, 13]] * len(ranges(opened))
    opened.run("document.querySelector('button[data-from]').click()")  # the first window, 0-8 s
    opened.until("return uavftc.plots.every(p => Math.abs(p.place._fullLayout.xaxis.range[1] - 8.85) < 1e-9)")
    opened.run("document.getElementById('whole').click()")
    opened.until("return uavftc.plots.every(p => p.place._fullLayout.xaxis.range[1] === 60)")
    assert ranges(opened) == [[0, 60]] * len(ranges(opened))


def test_light_and_dark_by_the_system_and_by_the_button(opened):
    ground = ("return [getComputedStyle(document.body).backgroundColor,"
              " ...uavftc.plots.map(p => p.place._fullLayout.paper_bgcolor)]")  # fmt: skip
    dark = ["rgb(27, 29, 33)"] + ["#1b1d21"] * 6
    light = ["rgb(255, 255, 255)"] + ["#ffffff"] * 6
    assert opened.run(ground) == light
    opened.prefers("dark")
    opened.until("return uavftc.plots.every(p => p.place._fullLayout.paper_bgcolor === '#1b1d21')")
    assert opened.run(ground) == dark
    opened.run("document.getElementById('theme').click()")
    opened.until("return uavftc.plots.every(p => p.place._fullLayout.paper_bgcolor === '#ffffff')")
    assert opened.run(ground) == light
    opened.prefers("light")
    opened.run("document.getElementById('theme').click()")
    opened.until("return uavftc.plots.every(p => p.place._fullLayout.paper_bgcolor === '#1b1d21')")
    assert opened.run(ground) == dark
    opened.run("document.getElementById('theme').click()")
    opened.until("return uavftc.plots.every(p => p.place._fullLayout.paper_bgcolor === '#ffffff')")


def test_on_a_phone_nothing_is_wider_than_the_screen(opened):
    opened.size(*PHONE)
    opened.until("return uavftc.plots.every(p => p.place._fullLayout.width <= 400)")
    assert opened.run("return document.documentElement.scrollWidth") == 400
    assert opened.run("return document.getElementById('view').clientWidth") > 300
    opened.size(*WIDE)
    opened.until("return uavftc.plots.every(p => p.place._fullLayout.width > 500)")


def test_the_scenario_is_copied(opened, folder):
    opened.run("document.execCommand = () => { window.copied = document.activeElement.value; return true; };"
               "navigator.clipboard.writeText = () => Promise.reject(new Error('no'));"
               "document.querySelector('button[data-copy=scenario]').click()")  # fmt: skip
    text = opened.until("return window.copied")
    assert text == (folder / "scenario.yaml").read_text(encoding="utf-8")


def test_on_paper_it_is_light_and_without_what_cannot_be_pressed(opened):
    opened.prefers("dark", media="print")
    shown = opened.run("return ['.timebar', '#theme', 'h1', '.plot'].map(s => "
                       "getComputedStyle(document.querySelector(s)).display !== 'none')")  # fmt: skip
    assert shown == [False, False, True, True]
    assert opened.run("return getComputedStyle(document.body).backgroundColor") == "rgb(255, 255, 255)"
    opened.prefers("light")
    printed = opened.driver.execute_cdp_cmd("Page.printToPDF", {"printBackground": True})
    assert base64.b64decode(printed["data"]).startswith(b"%PDF")
    assert opened.said() == []


def test_hostile_texts_are_shown_and_not_run(chromium, tmp_path):
    path = tmp_path / "hostile.html"
    path.write_text(hostile_page(), encoding="utf-8")
    chromium.open(path)
    assert chromium.said() == []
    assert chromium.run("return window.hacked === undefined")
    assert "<img src=x" in chromium.run("return document.querySelector('h1').textContent")
    assert chromium.run("return document.querySelectorAll('img').length") == 0


def test_a_comparison_and_a_campaign_are_drawn(chromium, tmp_path):
    out = tmp_path / "both"
    arguments = ["compare", "scenario1", "--controllers", "nndondi-l1,pid", "--set", "duration_s=3", "--report"]
    assert CliRunner().invoke(umbrella, [*arguments, "--no-plots", "--quiet", "--out", str(out)]).exit_code == 0
    chromium.open(out / "report.html")
    assert chromium.said() == []
    lines = chromium.run("return document.querySelectorAll('.scatterlayer .trace .js-line').length")
    assert lines == 4 * (3 + 3 + 3 + 3) + 3 + 4  # four flights, three references; speed and height, JSBSim's alone
    path = tmp_path / "campaign.html"
    path.write_text(campaign(50), encoding="utf-8")
    chromium.open(path)
    assert chromium.said() == []
    assert chromium.run("return document.querySelectorAll('#plot-scatter .point').length") == 50
    chromium.run("const s = document.getElementById('y-input'); s.value = 1; s.dispatchEvent(new Event('change'))")
    assert chromium.until("return document.getElementById('plot-scatter').layout.yaxis.title.text === 'margin'")
