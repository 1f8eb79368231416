"""What the pages hold: their sources, their blocks of commands, the files that they ask to write."""

from __future__ import annotations

import re
from pathlib import Path

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
PAGES = [*sorted(DOCS.rglob("*.md")), ROOT / "README.md", ROOT / "CONTRIBUTING.md"]


def text_of(page: str) -> str:
    return (ROOT / page).read_text(encoding="utf-8")


def name_of(page: Path) -> str:
    return page.relative_to(ROOT).as_posix()


def shell_blocks(text: str) -> list[str]:
    return re.findall(r"^```sh\n(.*?)^```$", text, re.MULTILINE | re.DOTALL)


def lines_of(block: str) -> list[str]:
    """Return the lines of a block, continued ones joined."""
    return block.replace("\\\n", " ").splitlines()


def inline_commands(text: str) -> list[str]:
    """Return what stands in backticks within a line and is a command with something behind it."""
    prose = re.sub(r"^```.*?^```$", "", text, flags=re.MULTILINE | re.DOTALL)
    return re.findall(r"`(uavftc(?:-fly)? [^`\n]+)`", prose)


def files_of(text: str) -> dict[str, str]:
    """Return the files of a page: a block behind a line that ends with its name, as in "`mine.yaml`:"."""
    found = re.findall(r"`([\w-]+\.(?:yaml|py))`[^`\n]*:\n\n```\w+\n(.*?)^```$", text, re.MULTILINE | re.DOTALL)
    return dict(found)


def without_code(text: str) -> str:
    text = re.sub(r"^```.*?^```$", "", text, flags=re.MULTILINE | re.DOTALL)
    return re.sub(r"`[^`\n]*`", "", text)
