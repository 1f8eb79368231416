"""What the controller sees: one error of the sensors a file, in the order in which they act on a measurement."""

from __future__ import annotations

from uavftc.sensors import exact, gyro

CHAIN = (exact, gyro)
"""The order on a measurement, from the truth on."""
