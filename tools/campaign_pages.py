"""Fly the shipped campaigns and write docs/campaign-results.md: a figure and the tables of each.

python tools/campaign_pages.py                       # all of them as their files say: an hour on two idle cores
python tools/campaign_pages.py --only turbulence --cases 50
python tools/campaign_pages.py --only turbulence --folder DIR    # the page of a campaign that was flown already

Campaigns are flown into results/campaigns/<name>; one that is there is gone on with, one that is finished is not flown
again. Other campaigns than those of --only keep their part of the page.
"""

from __future__ import annotations

import argparse
import re
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

from uavftc.jobs.sweep_report.job import draw, sweep_report
from uavftc.report import campaign_page

ROOT = Path(__file__).parents[1]
PAGE = ROOT / "docs" / "campaign-results.md"
IMAGES = ROOT / "docs" / "images" / "campaigns"
RESULTS = Path("results") / "campaigns"
SHIPPED = (
    "paper-faults",
    "severe-faults",
    "severe-faults-c172p",
    "turbulence",
    "turbulence-c172p",
    "uncertainty",
    "uncertainty-c172p",
)
FIGURES = ("success", "margins", "sensitivity", "map")
"""Of the paper's campaign; the others show the map alone."""


def fly(name: str, cases: int | None, workers: int | None) -> Path:
    """Fly a campaign as a user does, or go on with it, and return its folder."""
    folder = RESULTS / name
    command = [sys.executable, "-m", "uavftc", "sweep", name, "--out", str(folder)]
    command += ["--set", f"cases={cases}"] if cases else []
    command += ["--workers", str(workers)] if workers else []
    command += ["--resume"] if (folder / "campaign.json").is_file() else []
    subprocess.run(command, check=True)
    return folder


def part_of(name: str, folder: Path) -> str:
    """Write the figures of a campaign, and return its part of the page."""
    flown, document = sweep_report(folder)
    chosen = FIGURES if name == "paper-faults" else ("map",)
    with tempfile.TemporaryDirectory() as temporary:
        drawn = draw(Path(temporary) / "figures", flown, document, chosen)
        shown = [figure for figure in chosen if f"{figure}.png" in drawn]
        for figure in shown:
            _copy(Path(temporary) / "figures" / f"{figure}.png", IMAGES / f"{name}-{figure}.png")
    cases = document["cases"]
    whole = "" if cases == _cases_of_file(name) else f" --set cases={cases}"
    lines = [
        f"## `{name}`",
        "",
        f"{document['description']} {cases} cases, {document['flights']} flights; {_success(document)}.",
        "",
        "```sh",
        f"uavftc sweep {name}{whole}",
        f"uavftc sweep-report results/sweep-{name}",
        "```",
        "",
        *campaign_page.success_rows(document),
    ]
    if name == "paper-faults":
        lines += [*campaign_page.pair_rows(document)]
    if any(document["sensitivity"]["variants"].values()):
        lines += [*campaign_page.sensitivity_rows(document)]
    for figure in shown:
        lines += [f"![{campaign_page.FIGURES[figure]}](images/campaigns/{name}-{figure}.png)", ""]
    return "\n".join(lines)


def _success(document: dict[str, Any]) -> str:
    success = document["success_is"]
    if isinstance(success, str):
        return "success: every requirement met"
    return "success: flown to the end, " + ", ".join(f"`{key}` at most {limit:g}" for key, limit in success.items())


def _cases_of_file(name: str) -> int:
    from uavftc.scenario.campaign import load_campaign

    return load_campaign(name).count


def _copy(source: Path, target: Path) -> None:
    """Copy a figure into the docs, small: 256 colours are enough for what it shows."""
    from PIL import Image

    target.parent.mkdir(parents=True, exist_ok=True)
    with Image.open(source) as image:
        width = min(image.width, 1500)
        size = width, round(image.height * width / image.width)
        small = image.convert("RGB").resize(size, Image.Resampling.LANCZOS)
        small.quantize(256, dither=Image.Dither.NONE).save(target, optimize=True)


def main() -> None:
    """Fly, and write the page."""
    parser = argparse.ArgumentParser(description="Fly the shipped campaigns and write docs/campaign-results.md.")
    parser.add_argument("--only", default="", help="names, separated by commas")
    parser.add_argument("--cases", type=int, help="so many of each, in place of what its file says")
    parser.add_argument("--workers", type=int)
    parser.add_argument("--folder", type=Path, help="where the one of --only was flown already")
    arguments = parser.parse_args()
    names = [name for name in SHIPPED if name in (arguments.only.split(",") if arguments.only else SHIPPED)]
    if not names or (arguments.folder and len(names) > 1):
        parser.error(f"--only: one of {', '.join(SHIPPED)}")
    for name in names:
        folder = arguments.folder or fly(name, arguments.cases, arguments.workers)
        text = part_of(name, folder)
        begins, ends = f"<!-- {name}: written by tools/campaign_pages.py -->", f"<!-- end of {name} -->"
        page = PAGE.read_text(encoding="utf-8")
        pattern = re.compile(f"{re.escape(begins)}.*?{re.escape(ends)}", re.DOTALL)
        page, count = pattern.subn(lambda _: f"{begins}\n{text}\n{ends}", page)  # noqa: B023 - used at once
        if count != 1:
            sys.exit(f"{PAGE}: no place for {name}")
        PAGE.write_text(page, encoding="utf-8", newline="\n")
    if not arguments.folder:
        print(f"flown into {RESULTS}; remove it when the page is as it should be", file=sys.stderr)


if __name__ == "__main__":
    main()
