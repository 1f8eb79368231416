"""The notebook of ten minutes runs from top to bottom, and prints what stands in it."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

NOTEBOOK = Path(__file__).parents[2] / "docs" / "ten-minutes.ipynb"
RUN = """
import sys, nbclient, nbformat
notebook = nbformat.read(sys.argv[1], as_version=4)
nbclient.NotebookClient(notebook, timeout=600, kernel_name="python3").execute()
nbformat.write(notebook, sys.argv[2])
"""


def printed(file: Path) -> list[str]:
    cells: list[dict[str, Any]] = json.loads(file.read_text(encoding="utf-8"))["cells"]
    outputs = [cell.get("outputs", ()) for cell in cells]
    return ["".join("".join(o["text"]) for o in cell if o["output_type"] == "stream") for cell in outputs]


def test_the_notebook_runs_and_prints_what_it_shows(tmp_path: Path) -> None:
    again = tmp_path / "again.ipynb"
    subprocess.run([sys.executable, "-c", RUN, NOTEBOOK, again], check=True, cwd=tmp_path, capture_output=True)
    assert printed(again) == printed(NOTEBOOK)
    assert any("L1" in text for text in printed(NOTEBOOK))
