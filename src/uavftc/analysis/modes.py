"""The natural modes of an aircraft, named: phugoid and short period, dutch roll, roll and spiral.

The longitudinal block runs over [V, alpha, q, theta] and the lateral one over [beta, p, r, phi] (u, w and v in
place of V, alpha and beta will do). A mode is named by where it lives: the participation of state k in eigenvalue i is
|v_ki w_ki| of the right and left eigenvectors, which does not depend on the units of the states. The two eigenvalues
that live most in alpha and q are the short period, those that live most in beta and r the dutch roll.
"""

from __future__ import annotations

import itertools
from typing import NamedTuple

import numpy as np

REAL = 1e-9  # relative: an imaginary part below this is rounding
STATES = ("V", "alpha", "q", "theta", "beta", "p", "r", "phi")
"""States of the full linear model of an aircraft: true airspeed, m/s; angles, rad; body rates, rad/s."""


class Mode(NamedTuple):
    """One mode: a complex pair, or one real eigenvalue."""

    name: str
    motion: str
    """`longitudinal` or `lateral`."""
    eigenvalue: complex
    """1/s; of a pair the one with a positive imaginary part."""

    @property
    def natural_frequency(self) -> float:
        """|lambda|, rad/s; of a real mode the inverse of its time constant."""
        return abs(self.eigenvalue)

    @property
    def damping(self) -> float | None:
        """Damping ratio; 1 or -1 for a real mode, None for an eigenvalue at the origin."""
        return -self.eigenvalue.real / abs(self.eigenvalue) if self.eigenvalue else None

    @property
    def time_constant(self) -> float | None:
        """Time to fall to 1/e, s; negative for a mode that grows, None for one that does neither."""
        return -1.0 / self.eigenvalue.real if self.eigenvalue.real else None


def modes(A: np.ndarray) -> list[Mode]:
    """Return the modes of a model over `STATES`, shape (8, 8), the fastest first."""
    return [*longitudinal(A[:4, :4]), *lateral(A[4:, 4:])]


def longitudinal(A: np.ndarray) -> list[Mode]:
    """Return short period and phugoid of a block over [V, alpha, q, theta], shape (4, 4)."""
    values, share = participation(A)
    fast, slow = _halves(values, share[[1, 2]].sum(axis=0))
    found = []
    for name, chosen in (("short period", fast), ("phugoid", slow)):
        found += _named(name, f"{name} (aperiodic)", "longitudinal", values[chosen])
    return _fastest_first(found)


def lateral(A: np.ndarray) -> list[Mode]:
    """Return dutch roll, roll and spiral of a block over [beta, p, r, phi], shape (4, 4).

    Roll and spiral can merge into one pair, which is then `roll-spiral`.
    """
    values, share = participation(A)
    dutch, rest = _halves(values, share[[0, 2]].sum(axis=0))
    found = _named("dutch roll", "dutch roll (aperiodic)", "lateral", values[dutch])
    if values[rest[0]].imag:
        found += _named("roll-spiral", "", "lateral", values[rest])
    else:
        roll, spiral = sorted(rest, key=lambda i: -share[1, i])
        found += [Mode("roll", "lateral", complex(values[roll])), Mode("spiral", "lateral", complex(values[spiral]))]
    return _fastest_first(found)


def participation(A: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the eigenvalues, shape (n,), and the share of each state (row) in each of them, shape (n, n).

    The shares of an eigenvalue add up to 1.
    """
    values, right = np.linalg.eig(A)
    values = values.astype(complex)
    values.imag[np.abs(values.imag) <= REAL * np.abs(values)] = 0.0
    left = np.linalg.pinv(right)  # an inverse, except for a matrix without a full set of eigenvectors
    share = np.abs(right * left.T)
    return values, share / np.maximum(share.sum(axis=0), 1e-300)


def _halves(values: np.ndarray, weight: np.ndarray) -> tuple[list[int], list[int]]:
    """Split four eigenvalues into the two of the greatest weight and the others; a pair stays together."""
    whole = [c for c in itertools.combinations(range(4), 2) if _closed(values[list(c)])]
    first = max(whole, key=lambda c: float(weight[list(c)].sum()))
    return list(first), [i for i in range(4) if i not in first]


def _closed(pair: np.ndarray) -> bool:
    """Whether two eigenvalues are both real, or a conjugate pair."""
    a, b = pair
    if not a.imag and not b.imag:
        return True
    return bool(abs(a - np.conj(b)) <= 1e-6 * abs(a))


def _named(periodic: str, aperiodic: str, motion: str, pair: np.ndarray) -> list[Mode]:
    if pair[0].imag:
        return [Mode(periodic, motion, complex(pair[np.argmax(pair.imag)]))]
    return [Mode(aperiodic, motion, complex(value)) for value in pair]


def _fastest_first(found: list[Mode]) -> list[Mode]:
    return sorted(found, key=lambda mode: -abs(mode.eigenvalue))
