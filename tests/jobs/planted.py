"""A planted corner: a controller that fails in 1/1,000 of a space of six options, at the end of a curved ridge.

It is a proportional attitude loop that holds the pitch off its reference by an angle of its options x1 ... x6, each on
[0, 1]. With t = x1 and the ridge c_i(t) = 1/2 + 0.35 (-1)^i sin(2.2 pi (t - 0.1 i)), i = 1 ... 5,

    r = 0.9 (1 - t) + 5 |(x2 ... x6) - c(t)| / sqrt(5)
    offset = max(0, 1 - (r - R)) deg

so that on `SCENARIO`, which asks the pitch to be within 1 deg, the margin is r - R near the ridge: it falls along the
ridge, towards t = 1, and rises fast to every side of it. R is the quantile 1/1,000 of r, by 24 million random points,
to within 0.001. A search has BUDGET flights; in seven eighths of the space the margin is 1 and says nothing.
"""

from __future__ import annotations

import numpy as np

DIMENSION = 6
BUDGET = 500
R = 0.6266
SCENARIO = """\
name: planted
duration_s: 3
plant: analytic
aircraft: hale
controller: {{kind: {controller}, rate_hz: 50, options: {{x1: 0.5, x2: 0.5, x3: 0.5, x4: 0.5, x5: 0.5, x6: 0.5}}}}
requirements:
  - {{name: pitch, always: "abs(theta_error_deg) <= 1", from_s: 2.5}}
"""
CAMPAIGN = """\
name: planted-corner
base: planted.yaml
seed: {seed}
cases: 500
design: sobol
vary:
  controller.options.x1: {{uniform: [0, 1]}}
  controller.options.x2: {{uniform: [0, 1]}}
  controller.options.x3: {{uniform: [0, 1]}}
  controller.options.x4: {{uniform: [0, 1]}}
  controller.options.x5: {{uniform: [0, 1]}}
  controller.options.x6: {{uniform: [0, 1]}}
"""


def ridge(t):
    """Return x2 ... x6 on the ridge at t, shape (..., 5)."""
    i = np.arange(1, DIMENSION)
    return 0.5 + 0.35 * (-1.0) ** i * np.sin(2.2 * np.pi * (np.asarray(t)[..., None] - 0.1 * i))


def height(x):
    """Return r - R at points, shape (..., 6): the margin near the ridge, negative in the corner."""
    x = np.asarray(x, dtype=float)
    away = np.linalg.norm(x[..., 1:] - ridge(x[..., 0]), axis=-1) / np.sqrt(DIMENSION - 1)
    return 0.9 * (1.0 - x[..., 0]) + 5.0 * away - R


def create(design, h, options):
    x = [options[f"x{i + 1}"] for i in range(DIMENSION)]
    offset = np.radians([0.0, max(0.0, 1.0 - float(height(x))), 0.0])
    B_inverse = np.linalg.inv(design.B)

    def step(t, x1_c, x1, x2):
        rates = 4.0 * (x1_c + offset - x1)
        return B_inverse @ (10.0 * (rates - x2) - design.A @ x2)

    return step
