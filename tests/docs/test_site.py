"""Each page is in the site and leads somewhere; `pytest -m slow -n 0 tests/docs/test_site.py` builds it."""

from __future__ import annotations

import functools
import re
import subprocess
import sys
from html import unescape
from pathlib import Path
from urllib.parse import unquote

import pytest
from pages import DOCS, PAGES, ROOT, name_of, without_code

import uavftc

TOCTREE = re.compile(r"^```\{toctree\}\n(.*?)^```$", re.MULTILINE | re.DOTALL)


def entries(page: Path) -> list[Path]:
    """Return the pages that the toctrees of a page list."""
    found: list[Path] = []
    for body in TOCTREE.findall(page.read_text(encoding="utf-8")):
        for line in body.splitlines():
            if line and not line.startswith(":"):
                found += sorted(page.parent.glob(f"{line}.md")) or [page.parent / f"{line}.ipynb"]
    return found


def test_every_page_is_in_a_toctree_once() -> None:
    listed = [entry for page in DOCS.rglob("*.md") for entry in entries(page)]
    pages = {*DOCS.rglob("*.md"), *DOCS.glob("*.ipynb")} - {DOCS / "index.md"}
    assert set(listed) == pages
    assert len(listed) == len(pages)


@functools.cache
def anchors(page: Path) -> set[str]:
    """Return the anchors of a page's headings, as code hosts and MyST make them."""
    text = re.sub(r"^```.*?^```$", "", page.read_text(encoding="utf-8"), flags=re.MULTILINE | re.DOTALL)
    found: set[str] = set()
    for heading in re.findall(r"^#{1,4} +(.+)$", text, re.MULTILINE):
        slug = re.sub(r"[^\w\- ]", "", heading.strip().lower()).replace(" ", "-")
        same = sum(1 for each in found if re.fullmatch(rf"{re.escape(slug)}(-\d+)?", each))
        found.add(f"{slug}-{same}" if slug in found else slug)
    return found


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_links_and_anchors_of_a_page_resolve(page: Path) -> None:
    for target, anchor in re.findall(
        r"\]\((?!https?://)([^)#\s]*)(?:#([^)\s]+))?\)", without_code(page.read_text(encoding="utf-8"))
    ):
        file = (page.parent / target).resolve() if target else page
        assert file.exists(), target
        assert file.is_relative_to(ROOT), target
        if anchor and file.suffix == ".md":
            assert anchor in anchors(file), f"{target}#{anchor}"


def test_every_public_name_is_on_the_page_of_the_api() -> None:
    text = (DOCS / "api.md").read_text(encoding="utf-8")
    described = re.findall(r"^\.\. auto(?:function|class):: (\w+)$", text, re.MULTILINE)
    assert sorted(described) == sorted(set(uavftc.__all__) - {"__version__"})


def dead(site: Path) -> list[str]:
    """Return the links inside a built site that lead to no file or no place in it."""
    pages = {page: page.read_text(encoding="utf-8") for page in site.rglob("*.html")}
    places = {page: set(re.findall(r'\bid="([^"]+)"', text)) for page, text in pages.items()}
    found = []
    for page, text in pages.items():
        for link in map(unescape, re.findall(r'\b(?:href|src)="([^"]+)"', text)):
            if re.match(r"[a-z]+:", link):
                continue
            file, _, place = unquote(link).partition("#")
            target = (page.parent / file.partition("?")[0]).resolve() if file else page
            if target.is_dir():
                target /= "index.html"
            if not target.exists() or (place and place not in places.get(target, {place})):
                found.append(f"{page.relative_to(site)}: {link}")
    return found


@pytest.mark.slow
def test_the_site_builds_without_a_warning_and_has_no_dead_link(tmp_path: Path) -> None:
    for module in ("sphinx", "furo", "myst_nb", "ziamath"):
        pytest.importorskip(module, reason="needs the extra docs")
    site = (tmp_path / "site").resolve()
    options = ["-q", "-W", "--keep-going", "-d", str(tmp_path / "doctrees")]
    done = subprocess.run(
        [sys.executable, "-m", "sphinx", *options, str(DOCS), str(site)], check=False, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    assert done.stderr == ""
    assert dead(site) == []
    assert len(list(site.rglob("*.html"))) >= len(list(DOCS.rglob("*.md")))
    # Equations are drawn when the site is built; nothing is fetched to show them.
    theory = (site / "theory.html").read_text(encoding="utf-8")
    assert theory.count('<div class="math">') == (DOCS / "theory.md").read_text(encoding="utf-8").count("$$") / 2
    assert not re.search(r'<(?:script|link)[^>]*(?:src|href)="https?://', theory)
