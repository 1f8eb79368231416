"""How curves and windows look on a page, in light and dark, from the palette of all figures."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from uavftc.report import palette

_DASHES = ("-", None)
_STANDARD = 1.7  # width of a line, pixels


def on_page(look: Mapping[str, Any]) -> dict[str, Any]:
    """Return the look of a curve, as matplotlib takes it, as a page takes it: colours, width and dashes in pixels."""
    colour, width = look["color"], float(look.get("linewidth", _STANDARD))
    style = look.get("linestyle", "-")
    dash = "solid" if style in _DASHES else ",".join(f"{round(max(width, 1.2) * part, 1)}px" for part in style[1])
    return {"light": colour, "dark": palette.ON_DARK.get(colour, colour), "width": width, "dash": dash}


LOOKS = {
    name: on_page(look)
    for name, look in {
        "actual": palette.ACTUAL,
        "reference": palette.REFERENCE,
        "measured": palette.MEASURED,
        "command": palette.COMMAND,
        "deflection": palette.DEFLECTION,
        "estimate": palette.ESTIMATE,
        "twin": palette.TWIN,
        "limit": palette.LIMIT,
        "truth": {"color": palette.GREEN},
        **{f"several{i}": look for i, look in enumerate(palette.SEVERAL)},
    }.items()
}
"""By the names that curves of a flight have in `Curve.look`."""

SHADES = {kind: {"colour": shade.colour, "text": shade.dark} for kind, shade in palette.KINDS.items()}
"""By the kind of window: its colour, and the same dark enough for a text on white."""
