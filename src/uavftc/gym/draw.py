"""Which flight an episode is: a case of a campaign, drawn by the environment's generator, or one scenario."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from uavftc.aircraft.definition import Aircraft, load_aircraft
from uavftc.errors import InputError
from uavftc.jobs.campaign.cases import Cases
from uavftc.scenario.campaign import load_campaign
from uavftc.scenario.changed import Changing
from uavftc.scenario.load import load_scenario
from uavftc.scenario.schema import Scenario

MOST_SEED = 2**31


class Drawn(NamedTuple):
    """The flight of an episode."""

    scenario: Scenario
    aircraft: Aircraft
    info: dict[str, Any]
    """What `reset` says of it."""


class Draw:
    """Draws flights: of a campaign where one is named, and of one scenario else.

    Parameters
    ----------
    campaign
        File or name of a campaign: what varies, and on which plants and aircraft; its controllers are not flown.
    scenario
        File or name of a scenario, in place of a campaign.
    controller, plant, aircraft
        In place of those of the scenario.
    set
        Values of the scenario by dotted key.

    Raises
    ------
    InputError
        If one of them is wrong, or both a campaign and a scenario are named.
    """

    def __init__(
        self,
        campaign: str | Path | None,
        scenario: str | Path | None,
        *,
        controller: str | None = None,
        plant: str | None = None,
        aircraft: str | None = None,
        set: Mapping[str, Any] | None = None,
    ) -> None:
        if campaign is not None and scenario is not None:
            remedy = "leave one out"
            raise InputError("campaign", found="a scenario as well", expected="one of the two", remedy=remedy)
        self._cases: Cases | None = None
        if campaign is None:
            bases = [load_scenario(scenario or "scenario3", controller=controller, plant=plant, aircraft=aircraft)]
            self._labels: Sequence[dict[str, Any]] = [{}]
            varied: tuple[str, ...] = ()
        else:
            file = load_campaign(campaign)
            self._cases, varied = Cases(file), tuple(file.vary)
            on = itertools.product((plant,) if plant else file.plants or (None,),
                                   (aircraft,) if aircraft else file.aircraft or (None,))  # fmt: skip
            variants = list(on)
            bases = [file.scenario(controller=controller, plant=p, aircraft=a) for p, a in variants]
            self._labels = [{"plant": base.plant, "aircraft": base.aircraft} for base in bases]
        self._seeded = "seed" in varied
        self._changing = [Changing(base.changed(set) if set else base) for base in bases]
        self._aircraft = [load_aircraft(base.aircraft) for base in bases]

    @property
    def count(self) -> int:
        """How many cases there are; 1 of a scenario."""
        return 1 if self._cases is None else self._cases.count

    def __call__(self, rng: np.random.Generator, case: int | None = None, variant: int | None = None) -> Drawn:
        """Return a flight that `rng` draws, or a given case, on a given variant.

        A case that is drawn has noise and turbulence of its own; one that is given has those of the campaign, and is
        the flight that `uavftc sweep` flies.

        Raises
        ------
        InputError
            If there is no such case or variant.
        """
        drawn = int(rng.integers(self.count)), int(rng.integers(len(self._changing))), int(rng.integers(MOST_SEED))
        chosen = drawn[0] if case is None else _within("case", case, self.count)
        which = drawn[1] if variant is None else _within("variant", variant, len(self._changing))
        values = {} if self._cases is None else self._cases.values(chosen)
        if case is None and not self._seeded:
            values = {**values, "seed": drawn[2]}
        scenario = self._changing[which](values)
        info = {"case": chosen, "variant": which, **self._labels[which], "values": values}
        return Drawn(scenario, self._aircraft[which], info)


def _within(what: str, given: int, count: int) -> int:
    if not 0 <= given < count:
        raise InputError(f"options['{what}']", found=str(given), expected=f"0 to {count - 1}", remedy="name another")
    return int(given)
