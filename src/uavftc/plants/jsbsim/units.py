"""Units at the border to JSBSim, which works in feet, slugs, pounds and radians."""

from __future__ import annotations

FT_M = 0.3048
"""One foot in metres (international foot, exact)."""

IN_M = 0.0254
"""One inch in metres (exact)."""

LBF_N = 4.4482216152605
"""One pound-force in newtons (exact: 0.45359237 kg times 9.80665 m/s^2)."""

SLUGFT2_KGM2 = LBF_N * FT_M
"""One slug ft^2 in kg m^2, and one lbf ft in N m: 1.3558179483314004."""

SLUG_KG = LBF_N / FT_M
"""One slug in kg."""
