"""When a campaign knows enough: the interval of success of every controller is as narrow as was asked for.

It is looked at in the order of the cases, and not in that in which flights end: after case 0, after cases 0 and 1, and
so on, each time all variants of a case are known. The campaign ends with the first number of cases that will do. Which
it is depends on the cases alone, and so does the table: flights of later cases that ended before are left out.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from uavftc.analysis.proportion import width
from uavftc.errors import InputError
from uavftc.scenario.campaign import Campaign

_UNKNOWN, _FAILED, _SUCCEEDED, _ERROR = -1, 0, 1, 2


class Narrow:
    """Takes flights in any order, and says after how many cases the campaign is over.

    Parameters
    ----------
    asked
        Width of Wilson's interval of success, of each variant.
    cases, variants
        How many there are; a byte a flight is kept.
    """

    def __init__(self, asked: float, cases: int, variants: int) -> None:
        self.asked = asked
        self.after: int | None = None
        """Cases that are enough; None as long as they are not."""
        self._known = np.full((cases, variants), _UNKNOWN, dtype=np.int8)
        self._next = 0
        self._succeeded, self._flown = np.zeros(variants, dtype=int), np.zeros(variants, dtype=int)

    def take(self, case: int, place: int, success: bool | None) -> None:
        """Take what came of a flight: its success, None of one that could not be flown and counts neither way."""
        self._known[case, place] = _ERROR if success is None else _SUCCEEDED if success else _FAILED
        while self.after is None and self._next < len(self._known) and (self._known[self._next] != _UNKNOWN).all():
            row = self._known[self._next]
            self._succeeded += row == _SUCCEEDED
            self._flown += row != _ERROR
            self._next += 1
            if (width(self._succeeded, self._flown) <= self.asked).all():
                self.after = self._next


def refuse_counted(campaign: Campaign) -> None:
    """Refuse a campaign whose first cases are no sample of all.

    Raises
    ------
    InputError
        If something in it is counted off.
    """
    for key, vary in campaign.vary.items():
        if vary.enumerated:
            raise InputError(
                f"--until-width with {campaign.origin.where(('vary', key))}",
                found=f"a {vary.kind}, which is counted off: the first cases are no sample of all",
                expected="keys that are drawn, when a campaign may end before its last case",
                remedy=f"write choice in place of {vary.kind}, or leave --until-width out",
            )


def remove_later(histories: Path, cases: int) -> None:
    """Remove the histories of cases that the campaign ended before, and what a flight broken off was writing."""
    for path in list(histories.iterdir()) if histories.is_dir() else []:
        number = path.name.partition("-")[0]
        if path.name.startswith(".") or (number.isdigit() and int(number) >= cases):
            path.unlink()
