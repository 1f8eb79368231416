"""What pushes the vehicle over time: one kind of disturbance a file. Overlapping disturbances add up."""

from __future__ import annotations

from uavftc.environment import angular_acceleration, attitude_rate, gust, gust_train, shear, turbulence, wind

KINDS = (angular_acceleration, attitude_rate, wind, shear, gust, gust_train, turbulence)
"""The kinds of entry of a scenario's `disturbances`."""
