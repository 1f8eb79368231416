"""Outer loop: attitude to body-rate command; one law a file."""

from __future__ import annotations

from uavftc.control.outer import ndi, nndo

KINDS = (ndi, nndo)
DEFAULT = nndo
"""The kind that a scenario without one gets."""
