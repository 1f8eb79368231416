"""Tables as a notebook shows them."""

from __future__ import annotations

import html
from collections.abc import Iterable, Sequence

_RIGHT = ' style="text-align: right"'


def table(header: Sequence[str], rows: Iterable[Sequence[object]], caption: str = "") -> str:
    """Return an HTML table; the first column is that of names, the others of numbers."""
    lines = ["<table>"]
    if caption:
        lines.append(f"<caption>{html.escape(caption)}</caption>")
    lines.append(
        "<thead><tr>" + "".join(f"<th{_RIGHT if i else ''}>{html.escape(h)}</th>" for i, h in enumerate(header))
    )
    lines.append("</tr></thead><tbody>")
    for name, *cells in rows:
        numbers = "".join(f"<td{_RIGHT}>{html.escape(_text(cell))}</td>" for cell in cells)
        lines.append(f"<tr><th>{html.escape(str(name))}</th>{numbers}</tr>")
    return "".join([*lines, "</tbody></table>"])


def _text(cell: object) -> str:
    if cell is None:
        return ""
    return f"{cell:.4g}" if isinstance(cell, float) else str(cell)
