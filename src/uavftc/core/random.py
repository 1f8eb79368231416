"""Random numbers: a stream for each effect and axis, of which no other depends, and normal numbers inside a law.

Before a flight, `stream(seed, effect, index)` is a numpy Generator. Within one, a law is compiled and keeps no array,
so its numbers are functions of a counter: with key(seed, effect, index) among its parameters (a field "u8"),

    normal(p.key, n)     the n-th number of the stream, normal with mean 0 and variance 1
    uniform(p.key, n)    the n-th number of the stream, uniform on (0, 1)

with n = 0, 1, 2, ... counted by the law in its state ("i8"), or made of the sample it is at. They need no memory, any
of them can be had alone, and how a flight is cut into chunks cannot change one. `normal` and `uniform` of one key and
counter come of the same words: a law that needs both, or several numbers a sample, takes several keys or counters.

The generator is Philox4x32-10 of Salmon et al., "Parallel random numbers: as easy as 1, 2, 3" (SC 2011): the key and
the counter are 64 bits of theirs each. Words become uniform numbers (j + 1/2) 2^-52, so never 0 or 1, and those become
normal ones by Box and Muller, sqrt(-2 ln u1) cos(2 pi u2), to 8.6 standard deviations.
"""

from __future__ import annotations

import zlib

import numpy as np

from uavftc.core.stage import law

_U = np.uint64
_LOW, _HALF, _LOST = _U(0xFFFFFFFF), _U(32), _U(12)
_M0, _M1 = _U(0xD2511F53), _U(0xCD9E8D57)  # multipliers of Philox4x32
_W0, _W1 = _U(0x9E3779B9), _U(0xBB67AE85)  # added to its key each round
_ROUNDS = 10
_UNIT = 2.0**-52


def stream(seed: int, effect: str, index: int = 0) -> np.random.Generator:
    """Return the random numbers of one effect, and of one axis, entry or effector of it.

    Parameters
    ----------
    seed
        Of the scenario, >= 0.
    effect
        The name of the effect, such as "gyro noise".
    index
        Axis, entry or effector, >= 0.
    """
    return np.random.Generator(np.random.Philox(_sequence(seed, effect, index)))


def key(seed: int, effect: str, index: int = 0) -> np.uint64:
    """Return the key of such a stream for `normal` and `uniform`; parameters as those of `stream`."""
    return _sequence(seed, effect, index).generate_state(1, np.uint64)[0]


def _sequence(seed: int, effect: str, index: int) -> np.random.SeedSequence:
    return np.random.SeedSequence(seed, spawn_key=(zlib.crc32(effect.encode()), index))


@law
def philox(key, counter):
    """Return the four words, 32 bits each, of Philox4x32-10 at the counter (counter, 0) of 64 bits each."""
    k = _U(key)
    c = _U(counter)
    return philox_words(c & _LOW, c >> _HALF, _U(0), _U(0), k & _LOW, k >> _HALF)


@law
def philox_words(c0, c1, c2, c3, k0, k1):
    """Return the four words of Philox4x32-10 at a counter and a key of 32 bit words, all uint64."""
    for _ in range(_ROUNDS):
        a, b = _M0 * c0, _M1 * c2
        c0, c1, c2, c3 = (b >> _HALF) ^ c1 ^ k0, b & _LOW, (a >> _HALF) ^ c3 ^ k1, a & _LOW
        k0, k1 = (k0 + _W0) & _LOW, (k1 + _W1) & _LOW
    return c0, c1, c2, c3


@law
def _unit(high, low):
    """Return a number on (0, 1) of two words."""
    return (float(((_U(high) << _HALF) | _U(low)) >> _LOST) + 0.5) * _UNIT


@law
def uniform(key, counter):
    """Return a number of the stream `key`, uniform on (0, 1), by its place: a whole number >= 0."""
    a, b, _, _ = philox(key, counter)
    return _unit(a, b)


@law
def normal(key, counter):
    """Return a number of the stream `key`, normal (0, 1), by its place: a whole number >= 0."""
    a, b, c, d = philox(key, counter)
    return np.sqrt(-2.0 * np.log(_unit(a, b))) * np.cos(2.0 * np.pi * _unit(c, d))
