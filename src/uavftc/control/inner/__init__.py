"""Inner loop: body-rate command to deflections; one law a file."""

from __future__ import annotations

from uavftc.control.inner import l1, mrac

KINDS = (l1, mrac)
DEFAULT = l1
"""The kind that a scenario without one gets."""
