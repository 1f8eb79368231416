"""A scenario changed by values, in Python: with the same checks and messages as one read from a file."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from uavftc.config.document import Document
from uavftc.scenario.load import plain_data, scenario_of
from uavftc.scenario.overrides import put
from uavftc.scenario.schema import Scenario


def changed(scenario: Scenario, values: Mapping[str, Any], where: str = "") -> Scenario:
    """Return a scenario with other values at dotted keys, such as ``faults[0].effectiveness``.

    Parameters
    ----------
    scenario
        Left as it is.
    values
        By key, as a file has them.
    where
        What the user changed it by, for messages; the key itself where it is empty.

    Raises
    ------
    InputError
        If a key does not exist or a value is wrong.
    """

    return Changing(scenario)(values, where)


class Changing:
    """A scenario that is changed many times, each time from what it is; what it says is read out of it once."""

    def __init__(self, scenario: Scenario) -> None:
        self._data = scenario.model_dump()

    def __call__(self, values: Mapping[str, Any], where: str | Mapping[str, str] = "") -> Scenario:
        """Return it with other values at dotted keys; arguments and errors as those of `changed`.

        `where` may give each key its place.
        """
        places = where if isinstance(where, Mapping) else dict.fromkeys(values, where)
        document = Document(plain_data(self._data), next(iter(places.values()), "") or "a change of the scenario")
        for key, value in values.items():
            put(document, key, plain_data(value), places[key] or f"{key} = {value}"[:200])
        return scenario_of(document)


def remade(scenario: Scenario, edit: Callable[[Document], None], where: str) -> Scenario:
    """Return a scenario made anew of its data after `edit` has changed them.

    Raises
    ------
    InputError
        If it is wrong then; `where` says by what.
    """
    document = Document(plain_data(scenario.model_dump()), where)
    edit(document)
    return scenario_of(document)
