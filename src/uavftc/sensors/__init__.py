"""What the controller sees: one error of the sensors a file, in the order in which they act on a measurement.

The order is the way of a measurement from the vehicle to the controller. How the sensor is mounted decides which
rotation its axes meet (misalignment); the transducer turns that into a signal (scale factor), to which its electronics
add what does not depend on the motion (bias, random walk, noise); the converter rounds the sum (quantisation), so that
small noise can be lost in a step; filter and bus hand it on later (delay); a message may be lost on the way (dropout);
and what is shown of a frozen channel depends on nothing any more (stuck).

Each file serves the attitude [phi, theta, psi] and the gyro [p, q, r]. A sensor is read once a sample of the
controller. An error is off where its keys are left out, and then costs nothing.
"""

from __future__ import annotations

from uavftc.sensors import (
    bias,
    delay,
    dropout,
    exact,
    misalignment,
    noise,
    quantisation,
    random_walk,
    scale_factor,
    stuck,
)

CHAIN = (exact, misalignment, scale_factor, bias, random_walk, noise, quantisation, delay, dropout, stuck)
"""The order on a measurement, from the truth on."""
