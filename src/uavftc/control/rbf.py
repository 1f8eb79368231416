"""Gaussian radial basis functions of eq. (10), the "6-5-1" networks of section 4.

    Phi_i(z) = exp(-|z - l_i|^2 / (2 k^2)),   i = 1..5,   z = [x1; x2] (6,)

The paper gives one centre value a node, the same in all six inputs: l = [-0.2, -0.1, 0, 0.1, 0.2]; width k = 0.4.
The heading enters relative to the initial heading, or Phi would vanish on every other one (the paper starts at 0).
Angle and rate of an axis that is not controlled are no inputs: a heading that nobody holds would make Phi vanish too.
"""

from __future__ import annotations

from math import exp
from typing import Annotated

from uavftc.config.values import Model, Number, Positive, list_of
from uavftc.core.stage import law

NODES = 5


class Rbf(Model):
    """Radial basis network "6-5-1": five Gaussians over the six inputs [x1; x2], rad and rad/s."""

    centres: Annotated[
        tuple[Number, Number, Number, Number, Number],
        list_of(5, "a list of five numbers, one centre for each hidden node"),
    ] = (-0.2, -0.1, 0.0, 0.1, 0.2)
    """node i is at centres[i] in every input"""
    width: Positive = 0.4
    """k of the Gaussian, > 0"""


@law
def basis(x1, x2, psi_0, axes, centres, width, Phi):
    """Write the basis functions into `Phi`, shape (5,).

    Parameters
    ----------
    x1, x2
        Attitude and body rates, (3,), rad and rad/s.
    psi_0
        Heading at the start, rad.
    axes
        1 for an axis that is controlled, 0 for another, shape (3,).
    centres, width
        l, shape (5,), and k of eq. (10), both in the units of z.
    Phi
        Output, shape (5,).
    """
    for i in range(NODES):
        square = axes[2] * (x1[2] - psi_0 - centres[i]) ** 2
        for j in range(2):
            square += axes[j] * (x1[j] - centres[i]) ** 2
        for j in range(3):
            square += axes[j] * (x2[j] - centres[i]) ** 2
        Phi[i] = exp(-square / (2.0 * width * width))
