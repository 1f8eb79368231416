"""A headless Chromium for the tests of pages and for the pictures of docs/report.md."""

from __future__ import annotations

import base64
import os
import shutil
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

DRAWN_WITHIN_S = 90.0  # on a machine that is busy


def missing() -> str | None:
    """Return what a browser lacks here; None where there is all of it."""
    try:
        import selenium  # noqa: F401
    except ImportError:
        return "no package selenium: pip install selenium"
    for program in ("chromium", "chromedriver"):
        if shutil.which(program) is None:
            return f"no {program}: apt-get install chromium chromium-driver"
    return None


class Page:
    """A browser with one page open."""

    def __init__(self, driver: Any) -> None:
        self.driver = driver

    def run(self, script: str, *arguments: Any) -> Any:
        """Return what a script returns in the page."""
        return self.driver.execute_script(script, *arguments)

    def size(self, width: int, height: int) -> None:
        """Make the window so large, pixels; below 500 it is a phone."""
        command = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": width < 500}
        self.driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", command)

    def prefers(self, scheme: str, media: str = "screen") -> None:
        """Let the system ask for `light` or `dark`, on `screen` or in `print`."""
        features = [{"name": "prefers-color-scheme", "value": scheme}]
        self.driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": media, "features": features})

    def open(self, path: Path) -> float:
        """Open a page, wait until all of it is drawn, and return how long that took, ms."""
        self.driver.get(path.resolve().as_uri())
        return float(self.until("return document.documentElement.dataset.drawn"))

    def processor_s(self) -> float:
        """Return the processor time that the main thread of the page has taken so far, s; call `count` before."""
        found = self.driver.execute_cdp_cmd("Performance.getMetrics", {})["metrics"]
        return float(next(one["value"] for one in found if one["name"] == "TaskDuration"))

    def count(self) -> None:
        """Count processor time from now on."""
        self.driver.execute_cdp_cmd("Performance.enable", {"timeDomain": "threadTicks"})

    def until(self, script: str, within_s: float = DRAWN_WITHIN_S) -> Any:
        """Return what a script returns as soon as that is something."""
        end = time.monotonic() + within_s
        while not (found := self.run(script)):
            assert time.monotonic() < end, f"never so: {script}; {self.said()}"
            time.sleep(0.05)
        return found

    def said(self) -> list[str]:
        """Return what went wrong in the page and what its console says."""
        lines = [f"{entry['level']}: {entry['message']}" for entry in self.driver.get_log("browser")]
        return [*self.run("return typeof uavftc === 'undefined' ? ['no script ran'] : uavftc.problems"), *lines]

    def picture(self, path: Path, clip: tuple[int, int, int, int] | None = None, scale: float = 1.0) -> None:
        """Write a picture of the page, of a part (x, y, width, height) where one is given."""
        options: dict[str, Any] = {"format": "png", "captureBeyondViewport": True}
        if clip is not None:
            options["clip"] = dict(zip(("x", "y", "width", "height"), clip, strict=True)) | {"scale": scale}
        found = self.driver.execute_cdp_cmd("Page.captureScreenshot", options)
        path.write_bytes(base64.b64decode(found["data"]))


@contextmanager
def browser() -> Iterator[Page]:
    """Yield a headless Chromium."""
    from selenium.webdriver import Chrome
    from selenium.webdriver.chrome.options import Options
    from selenium.webdriver.chrome.service import Service

    options = Options()
    options.binary_location = str(shutil.which("chromium"))
    arguments = ["--headless=new", "--disable-dev-shm-usage", "--hide-scrollbars", "--force-color-profile=srgb"]
    if hasattr(os, "getuid") and os.getuid() == 0:
        arguments.append("--no-sandbox")
    for argument in arguments:
        options.add_argument(argument)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    driver = Chrome(options=options, service=Service(shutil.which("chromedriver")))
    try:
        driver.set_script_timeout(DRAWN_WITHIN_S)
        yield Page(driver)
    finally:
        driver.quit()
