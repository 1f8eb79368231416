"""Draw the pictures of docs/report.md: pages of flights made for it, in a headless Chromium; say how long drawing took.

    python tools/page_pictures.py [DIR]

writes docs/images/report-*.png (or into DIR), and on standard output the size of each page and how long it took until
all of it was drawn: the first time in a new browser, and the median of five more, with the processor time.
It needs the extra `report`, selenium, chromium and chromedriver.
"""

from __future__ import annotations

import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT / "tests"))

from report.browser import Page, browser, missing  # noqa: E402

COLOURS = 256
JOBS = {
    "flight": ("fly", "scenario3", "--report"),
    "long": ("fly", "scenario3", "--set", "duration_s=60", "--report"),
    "comparison": ("compare", "scenario3", "--controllers", "nndondi-l1,nndondi-mrac,pid", "--report"),
    "campaign": ("sweep", "paper-faults", "--set", "cases=40"),
}


def fly(folder: Path) -> None:
    """Fly what the pictures show."""
    for name, (command, *rest) in JOBS.items():
        plots = [] if command == "sweep" else ["--no-plots"]
        words = [sys.executable, "-m", "uavftc", command, *rest, "--quiet", "--out", str(folder / name), *plots]
        subprocess.run(words, check=True)
    subprocess.run([sys.executable, "-m", "uavftc", "report", str(folder / "campaign"), "--quiet"], check=True)


def small(path: Path) -> None:
    """Write a picture again with few colours."""
    from PIL import Image

    Image.open(path).convert("RGB").quantize(COLOURS, method=Image.Quantize.MAXCOVERAGE).save(path, optimize=True)


def pictures(page: Page, folder: Path, out: Path) -> None:
    """Draw every picture."""
    page.size(1280, 1000)
    for name, scheme in (("light", "light"), ("dark", "dark")):
        page.prefers(scheme)
        page.open(folder / "flight" / "report.html")
        page.run("uavftc.clock.set(9.5, 'picture')")
        page.picture(out / f"report-{name}.png", (0, 0, 1280, 1640), 0.7)
    page.prefers("light")
    page.open(folder / "comparison" / "report.html")
    page.picture(out / "report-comparison.png", (0, 0, 1280, 1280), 0.6)
    page.open(folder / "campaign" / "report.html")
    page.picture(out / "report-campaign.png", (0, 0, 1280, 1000), 0.6)
    page.size(400, 800)
    page.open(folder / "flight" / "report.html")
    page.run("uavftc.clock.set(9.5, 'picture')")
    page.picture(out / "report-narrow.png", (0, 0, 400, 1900), 0.7)
    for path in out.glob("report-*.png"):
        small(path)


def times(folder: Path) -> None:
    """Print the size of each page and how long drawing it took."""
    for name in JOBS:
        path = folder / name / "report.html"
        with browser() as page:
            page.size(1280, 1000)
            page.count()
            first = page.open(path) / 1e3
            waited, taken = [], []
            for _ in range(5):
                waited.append(page.open(path) / 1e3)
                taken.append(page.processor_s())
            said = page.said()
        size, cpu = path.stat().st_size / 1e6, statistics.median(taken)
        print(f"{name}: {size:.2f} MB, drawn in {first:.2f} s by a new browser, then {statistics.median(waited):.2f} s")
        print(f"  {cpu:.2f} s of processor time of its main thread", *said)


def main() -> None:
    """Fly, draw and measure."""
    if (lacking := missing()) is not None:
        sys.exit(lacking)
    out = Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT / "docs" / "images"
    with tempfile.TemporaryDirectory() as name:
        fly(Path(name))
        with browser() as page:
            pictures(page, Path(name), out)
        times(Path(name))


if __name__ == "__main__":
    main()
