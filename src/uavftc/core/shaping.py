"""Shaped noise: white noise through first-order sections in series, exact at the samples whatever the step.

    x_1' = l_1 (n - x_1)                        y_1 = x_1
    x_i' = l_i (y_(i-1) - x_i)                  y_i = g_i y_(i-1) + (1 - g_i) x_i,     i = 2, 3, ...

with n white noise of unit intensity, E n(t) n(t') = delta(t - t'): section i is (1 + g_i s/l_i) / (1 + s/l_i), and a
lag where g_i is 0. The variable of the derivative is what the caller says: time, or length flown.

Over a step a, with x' = F x + G n (F lower triangular) and nu independent standard normal numbers,

    x(t + a) = Phi x(t) + c nu,     Phi = exp(F a),     c c' = Q = integral from 0 to a of exp(F s) G G' exp(F' s) ds,

so that covariances are exact at the samples for every step; held white noise would lose variance with a long one. Phi
and Q are Taylor series over a part 2^-m of the step in which l a <= `SMALL`, doubled m times:
Q(2a) = Q + Phi Q Phi', Phi(2a) = Phi Phi. From any state, a step of many correlation times leads to a state drawn from
the stationary distribution. Where l changes from step to step, each is that of the present l.

Source: C. F. van Loan, IEEE Trans. Automatic Control 23 (1978) 395, for Q; the triangular series and its doubling here.
"""

from __future__ import annotations

from math import sqrt

from uavftc.core.random import normal
from uavftc.core.stage import law

SECTIONS = 6
"""Most sections in series."""

SMALL = 0.1  # l a over which the series are summed; TERMS of them leave 0.1^10 / 10!, 3e-17
TERMS = 9
ROUNDING = 1e-18  # of a term against the first one; below, the sum is what it was
RESOLVED = 1e-13  # of a pivot against its diagonal: below, it is rounding, and so is what would be divided by it

WORK = ("f8", (6, SECTIONS, SECTIONS))
"""Type of the memory that `move` works in: a field of a law's state."""


@law
def move(x, rates, leads, n, step, key, counter, work):
    """Move the states x of n sections on by a step, with the normal numbers of `key` from `counter` on.

    x, rates (l, > 0), leads (g): shape (SECTIONS,), of which n are used; the first lead is not.
    """
    F, S, Q, Phi, T, R = work[0], work[1], work[2], work[3], work[4], work[5]
    parts, small = 0, step
    fastest = rates[0]
    for i in range(1, n):
        fastest = max(fastest, rates[i])
    while fastest * small > SMALL and parts < 60:
        small *= 0.5
        parts += 1
    _matrix(F, R, rates, leads, n)
    for i in range(n):
        for j in range(n):
            S[i, j] = 0.0
            Q[i, j] = 0.0
            R[i, j] = 1.0 if i == j else 0.0
            Phi[i, j] = R[i, j]
    S[0, 0] = rates[0] * rates[0]
    scale, size = small, 1.0
    for k in range(TERMS):
        for i in range(n):
            for j in range(i + 1):
                Q[i, j] += scale * S[i, j]
        for i in range(n):
            for j in range(n):
                total = 0.0
                for m in range(i + 1):
                    total += F[i, m] * S[m, j]
                T[i, j] = total
        for i in range(n):  # S becomes F S + S F'
            for j in range(n):
                S[i, j] = T[i, j] + T[j, i]
        for i in range(n):  # R becomes F^(k + 1)
            for j in range(i + 1):
                total = 0.0
                for m in range(j, i + 1):
                    total += F[i, m] * R[m, j]
                T[i, j] = total
        for i in range(n):
            for j in range(i + 1):
                R[i, j] = T[i, j]
                Phi[i, j] += scale * T[i, j]
        scale *= small / (k + 2)
        size *= 2.0 * fastest * small / (k + 2)
        if size < ROUNDING:
            break
    for i in range(n):
        for j in range(i):
            Q[j, i] = Q[i, j]
    for _ in range(parts):
        _times(Phi, Q, T, n)
        for i in range(n):
            for j in range(n):
                total = 0.0
                for k in range(n):
                    total += T[i, k] * Phi[j, k]
                R[i, j] = total
        for i in range(n):
            for j in range(n):
                Q[i, j] += R[i, j]
        _times(Phi, Phi, T, n)
        for i in range(n):
            for j in range(n):
                Phi[i, j] = T[i, j]
    _add_noise(x, Phi, Q, T, n, key, counter)


@law
def _matrix(F, y, rates, leads, n):
    """Write F; y is memory, its first row the output of the sections so far."""
    for i in range(n):
        y[0, i] = 0.0
        for j in range(n):
            F[i, j] = 0.0
    y[0, 0] = 1.0
    F[0, 0] = -rates[0]
    for i in range(1, n):
        for j in range(i):
            F[i, j] = rates[i] * y[0, j]
            y[0, j] *= leads[i]
        F[i, i] = -rates[i]
        y[0, i] = 1.0 - leads[i]


@law
def _times(A, B, C, n):
    """Write A B into C; A is lower triangular."""
    for i in range(n):
        for j in range(n):
            total = 0.0
            for k in range(i + 1):
                total += A[i, k] * B[k, j]
            C[i, j] = total


@law
def _add_noise(x, Phi, Q, c, n, key, counter):
    """Write Phi x + c nu into x, c the lower triangular root of Q; what is not resolved in its pivots is left out."""
    for i in range(n):
        for j in range(i + 1):
            left = Q[i, j]
            for k in range(j):
                left -= c[i, k] * c[j, k]
            if i == j:
                c[i, i] = sqrt(left) if left > RESOLVED * Q[i, i] else 0.0
            else:
                c[i, j] = left / c[j, j] if c[j, j] > 0.0 else 0.0
    for i in range(n - 1, -1, -1):  # from below: x_i takes those above it, as they were
        total = 0.0
        for j in range(i + 1):
            total += Phi[i, j] * x[j]
        x[i] = total
    for j in range(n):
        nu = normal(key, counter + j)
        for i in range(j, n):
            x[i] += c[i, j] * nu


@law
def output(x, leads, n):
    """Return y_n of the sections."""
    y = x[0]
    for i in range(1, n):
        y = leads[i] * y + (1.0 - leads[i]) * x[i]
    return y
