"""What the documents name exists."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from flying import flown

ROOT = Path(__file__).parents[1]
EQUATIONS = (ROOT / "docs" / "equations.md").read_text(encoding="utf-8")


def rows() -> list[list[str]]:
    lines = [line for line in EQUATIONS.splitlines() if re.match(r"\| \d", line)]
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in lines]


def test_every_equation_of_the_paper_has_a_row() -> None:
    covered: list[int] = []
    for row in rows():
        first, _, last = row[0].partition("-")
        covered += range(int(first), int(last or first) + 1)
    assert sorted(covered) == list(range(1, 79))


@pytest.mark.parametrize("row", rows(), ids=lambda row: row[0])
def test_code_and_test_of_each_equation_exist(row: list[str]) -> None:
    for name in re.findall(r"`([\w/.]+\.(?:py|xml|yaml|md))`(?: ((?:`\w+`(?:, )?)+))?", row[2]):
        file = ROOT / "src" / "uavftc" / name[0]
        file = file if file.exists() else ROOT / name[0]
        text = file.read_text(encoding="utf-8")
        for function in re.findall(r"\w+", name[1]):
            assert f"def {function}(" in text, f"{name[0]} has no {function}"
    for file_name, test in re.findall(r"`([\w/]+\.py)::(\w+)`", row[3]):
        assert f"def {test}(" in (ROOT / "tests" / file_name).read_text(encoding="utf-8"), f"{file_name} has no {test}"


@pytest.mark.parametrize("page", [*sorted((ROOT / "docs").rglob("*.md")), ROOT / "README.md", ROOT / "CONTRIBUTING.md"])
def test_links_inside_the_project_lead_somewhere(page: Path) -> None:
    for target in re.findall(r"\]\((?!https?://|#)([^)#]+)", page.read_text(encoding="utf-8")):
        assert (page.parent / target).exists(), f"{page.name}: {target}"


HISTORY = (ROOT / "docs" / "history.md").read_text(encoding="utf-8")


def listed(table: str) -> list[str]:
    """Return the columns that a table of history.md names, in its order."""
    body = HISTORY.split(f"<!-- columns: {table} -->")[1].split("<!-- end -->")[0]
    cells = [line.split("|")[1] for line in body.splitlines() if line.startswith("| `")]
    return [name for cell in cells for name in re.findall(r"`([^`]+)`", cell)]


@pytest.mark.parametrize("plant", ["jsbsim", "analytic"])
def test_the_page_on_the_history_has_every_column_and_no_other(plant: str) -> None:
    flight, *_ = flown("scenario1", plant, None, ("duration_s=1", "actuators={bandwidth_radps: 57}"))
    names = [c.name for c in flight.columns]
    common = listed("common")
    assert [name for name in names if name in common] == common  # in their order
    of = {name: "<effector>" for name in flight.layout.names} | {name: "<engine>" for name in flight.layout.engines}
    own = {name.replace(each, word, 1) for name in names for each, word in of.items() if name.startswith(f"{each}_")}
    assert own - set(common) <= set(listed("own"))
    known = {name for name in names for each in of if name.startswith(f"{each}_")}
    assert set(names) - set(common) <= known
    if plant == "jsbsim":
        assert own >= set(listed("own"))
