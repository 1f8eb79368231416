"""Fly the shipped scenarios of faults, damage, servos, sensors and air, draw each, and write docs/gallery.md.

    python tools/gallery.py                      # all, some minutes
    python tools/gallery.py --only fault-stuck   # those with this in their name; the others stay as they are
    python tools/gallery.py --check              # exit code 1 if page or pictures are not those of the scenarios

The check flies nothing: it compares the text of each scenario and the set of pictures, not how the flights ended.
"""

from __future__ import annotations

import argparse
import io
import re
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from uavftc.config.shipped import scenario_dir, scenario_names
from uavftc.core.signals import AXES
from uavftc.scenario.load import load_scenario

DOCS = Path(__file__).parents[1] / "docs"
PAGE, PICTURES = DOCS / "gallery.md", DOCS / "images" / "gallery"
LARGEST = 80_000  # bytes of a picture
LONG = 12  # lines of a scenario that is shown with its comments
COLOURS = 112  # of a picture

FAMILIES = {
    "Faults of surfaces and servos": ("beyond/fault-", "What each key means: [scenarios.md](scenarios.md#faults). "
                                      "Where each fault leaves four controllers: [faults.md](faults.md)."),
    "Faults of engines": ("beyond/engine-", "[scenarios.md](scenarios.md#faults-of-engines)."),
    "Damage": ("damage/", "How the six cases are scaled, and what is exact: [damage.md](damage.md)."),
    "Servos": ("beyond/servo-", "[scenarios.md](scenarios.md#actuators)."),
    "Sensors": ("beyond/sensor-", "[scenarios.md](scenarios.md#sensors)."),
    "Air": ("beyond/air-", "[scenarios.md](scenarios.md#disturbances)."),
}  # fmt: skip
"""Title: what the names of its scenarios begin with, and where more about them is."""
ALSO = {"Air": ["gust"]}

INTRODUCTION = """# Gallery

Written by `python tools/gallery.py`, which flies and draws all of it; `--check` compares page and scenarios.

One picture a scenario. Left: roll, pitch and yaw with their references, and what the controller is shown where a sensor
errs. Middle: what each effector is commanded and what it reaches, of two effectors an axis both. Right: airspeed, with
the wind where the air moves (N, E, D: to the north, to the east, down); flow angles, or the thrust of each engine where
one fails; the way flown. What happens has its number in the list at the top and in the panels that it concerns; the
dotted line is the moment of the requirement that limits the margin ([requirements.md](requirements.md)). The same
figure is `figures/overview.png` of every flight.

Next to each picture stand how the flight ended, with its metrics for roll, pitch and yaw, the command to fly it and the
scenario. The controller is NNDONDI-L1 with the paper's parameters unless the scenario says otherwise, and it is told
nothing of any fault. The aircraft is hale or, where the name ends in `-c172p`, JSBSim's Cessna 172.
"""

FLOWN = re.compile(r"<!-- flown: (?P<name>[\w/-]+) -->\n(?P<text>.*?)\n<!-- end -->", re.DOTALL)


def families() -> dict[str, list[str]]:
    """Return the names of the scenarios of each part of the page."""
    shipped = [*scenario_names("beyond"), *scenario_names("damage")]
    return {
        title: [*(name for name in shipped if name.startswith(prefix)), *ALSO.get(title, [])]
        for title, (prefix, _) in FAMILIES.items()
    }


def picture(name: str) -> Path:
    """Return where the picture of a scenario is."""
    return PICTURES / f"{name.replace('/', '-')}.png"


def shown_text(name: str) -> str:
    """Return the text of a scenario's file, without comments where it is long."""
    text = (scenario_dir() / f"{name}.yaml").read_text(encoding="utf-8").strip()
    lines = text.split("\n")
    return text if len(lines) <= LONG else "\n".join(line for line in lines if not line.lstrip().startswith("#"))


def entry(name: str, flown: str) -> str:
    """Return the part of the page of one scenario."""
    path = picture(name).relative_to(DOCS).as_posix()
    return f"""### {name.rpartition("/")[2]}

{load_scenario(name).description}

![Attitude, effectors, air and way flown of {name}]({path})

<!-- flown: {name} -->
{flown}
<!-- end -->

```sh
uavftc-fly {name}
```

```yaml
{shown_text(name)}
```
"""


def page(flown: Mapping[str, str]) -> str:
    """Return the text of the page; `flown` has the line of each flight by the name of its scenario."""
    parts = [INTRODUCTION]
    for title, names in families().items():
        links = ", ".join(f"[{name.rpartition('/')[2]}](#{name.rpartition('/')[2]})" for name in names)
        parts.append(f"- {title}: {links}.")
    for title, names in families().items():
        parts.append(f"\n## {title}\n\n{FAMILIES[title][1]}\n")
        parts += [entry(name, flown.get(name, "")) for name in names]
    return "\n".join(parts).rstrip("\n") + "\n"


def flown_in(text: str) -> dict[str, str]:
    """Return the line of each flight that a page has."""
    return {found["name"]: found["text"] for found in FLOWN.finditer(text)}


def line_of(summary: Mapping[str, Any]) -> str:
    """Return how a flight ended and its metrics, in one line of the page."""
    from uavftc.results.summary import ending_of

    _, text = ending_of(summary)
    line = re.sub(r"^\w+", lambda outcome: f"**{outcome[0]}**", text)
    parts = []
    for metric, title, digits, unit in (
        ("steady_state_error_deg", "error at the end", 3, "deg"),
        ("iae", "IAE", 3, "rad s"),
        ("control_activity_rad", "control activity", 2, "rad"),
    ):
        values = [summary["axes"][axis][metric] for axis in AXES]
        if any(value is not None for value in values):
            texts = ["-" if value is None else f"{value:.{digits}f}" for value in values]
            parts.append(f"{title} {', '.join(texts)} {unit}")
    return "; ".join([line, *parts]) + "."


def draw(name: str) -> str:
    """Fly a scenario, write its picture, and return its line."""
    from PIL import Image

    from uavftc.jobs.campaign.pool import fly_one
    from uavftc.report import panels
    from uavftc.report.overview import STYLE, overview

    result = fly_one(load_scenario(name))
    assert result.history is not None
    with panels.style(STYLE), io.BytesIO() as drawn:
        overview(result.history, result.figure_context()).savefig(drawn, format="png")
        flat = Image.open(drawn).convert("RGB")
    few = flat.quantize(colors=COLOURS, method=Image.Quantize.MEDIANCUT, dither=Image.Dither.NONE)
    few.save(picture(name), optimize=True)
    return line_of(result.summary())


def problems() -> list[str]:
    """Return what is not as the scenarios have it."""
    text = PAGE.read_text(encoding="utf-8") if PAGE.is_file() else ""
    flown, names = flown_in(text), [name for part in families().values() for name in part]
    found = [f"{name} has not been flown" for name in names if not flown.get(name)]
    if page(flown) != text:
        found.append(f"{PAGE.name} is not what the scenarios say")
    expected = {picture(name).name for name in names}
    there = {path.name: path.stat().st_size for path in PICTURES.glob("*")}
    found += [f"{name} is missing" for name in sorted(expected - there.keys())]
    found += [f"{name} is of no scenario" for name in sorted(there.keys() - expected)]
    return found + [f"{name} has {size} bytes, more than {LARGEST}" for name, size in there.items() if size > LARGEST]


def main() -> int:
    """Draw and write, or check."""
    parser = argparse.ArgumentParser(description="Fly and draw the shipped scenarios, and write docs/gallery.md.")
    parser.add_argument("--check", action="store_true", help="write nothing; exit code 1 if something is out of date")
    parser.add_argument("--only", nargs="+", default=[""], metavar="NAME", help="scenarios with this in their name")
    arguments = parser.parse_args()
    if arguments.check:
        found = problems()
        print("".join(f"{line}: run {Path(__file__).name}\n" for line in found), end="")
        return int(bool(found))
    PICTURES.mkdir(parents=True, exist_ok=True)
    names = [name for part in families().values() for name in part]
    flown = flown_in(PAGE.read_text(encoding="utf-8")) if PAGE.is_file() else {}
    for name in names:
        if any(part in name for part in arguments.only):
            flown[name] = draw(name)
            print(f"{name}: {flown[name]}", file=sys.stderr)
    for path in PICTURES.glob("*"):
        if path not in map(picture, names):
            path.unlink()
    PAGE.write_text(page(flown), encoding="utf-8", newline="\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
