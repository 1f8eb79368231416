"""The verdict on a flight: what came of it, in a word, and one number that says how far it was from failing.

    survived     flown to its end, every requirement met
    degraded     flown to its end, a requirement broken
    lost         the vehicle was lost
    numerical    the plant's own integration does not converge there, so nothing is said of the vehicle

The margin of a flight is the smallest of its requirements', in (-1, 1]; 1 where none is asked. A vehicle lost has

    margin = -1 - (T - t_lost)/T,   T the length of the flight,

from -1 down to -2 where it is lost at once: the earlier the lower, so that the number orders flights for a search. What
ended for its integration counts as lost then, never as survived.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

from uavftc.analysis.requirements import Met

FLOWN = "flown"
"""Name of what every flight is asked: to reach its end."""

SURVIVED, DEGRADED, LOST, NUMERICAL = "survived", "degraded", "lost", "numerical"


class Verdict(NamedTuple):
    """What came of a flight."""

    outcome: str
    """`survived`, `degraded`, `lost` or `numerical`."""
    margin: float
    limiting: str | None
    """The requirement of the smallest margin; None where none is asked and the flight reached its end."""
    requirements: tuple[Met, ...]

    @property
    def at_s(self) -> float | None:
        """When the limiting requirement was nearest to its limit, or furthest beyond."""
        return next((one.at_s for one in self.requirements if one.name == self.limiting), None)

    def document(self) -> dict[str, Any]:
        """Return it as `summary.json` has it."""
        return {
            "outcome": self.outcome,
            "margin": self.margin,
            "limiting": self.limiting,
            "requirements": [one._asdict() for one in self.requirements],
        }


def verdict_of(
    found: Sequence[Met], *, completed: bool, ended_at_s: float | None, duration_s: float, numerical: bool = False
) -> Verdict:
    """Return the verdict on a flight.

    Parameters
    ----------
    found
        How each requirement of the scenario fared.
    completed, ended_at_s, numerical
        Whether the flight reached its end, when it ended before, s, and whether it ended for its integration.
    duration_s
        Length of the flight, s.
    """
    if completed:
        flown = (Met(FLOWN, 1.0, True, duration_s),) if found else ()
        judged = [one for one in found if one.margin is not None]
        least = min(judged, key=lambda one: one.margin or 0.0, default=None)
        broken = any(not one.met for one in found)
        margin = 1.0 if least is None or least.margin is None else least.margin
        limiting = None if least is None else least.name
        return Verdict(DEGRADED if broken else SURVIVED, margin, limiting, (*flown, *found))
    ended = 0.0 if ended_at_s is None else min(ended_at_s, duration_s)
    margin = -1.0 - (duration_s - ended) / duration_s
    lost = Met(FLOWN, margin, False, ended)
    return Verdict(NUMERICAL if numerical else LOST, margin, FLOWN, (lost, *found))
