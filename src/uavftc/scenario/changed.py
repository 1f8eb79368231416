"""A scenario changed by values, in Python: with the same checks and messages as one read from a file."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from uavftc.config.document import Document
from uavftc.scenario.load import scenario_of
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
        document = Document(_lists(self._data), next(iter(places.values()), "") or "a change of the scenario")
        for key, value in values.items():
            put(document, key, _lists(value), places[key] or f"{key} = {value}"[:200])
        return scenario_of(document)


def remade(scenario: Scenario, edit: Callable[[Document], None], where: str) -> Scenario:
    """Return a scenario made anew of its data after `edit` has changed them.

    Raises
    ------
    InputError
        If it is wrong then; `where` says by what.
    """
    document = Document(_lists(scenario.model_dump()), where)
    edit(document)
    return scenario_of(document)


def _lists(value: Any) -> Any:
    """Return the data anew, with lists in place of tuples, so that they can be changed, and what they are of cannot."""
    if isinstance(value, dict):
        return {key: _lists(item) for key, item in value.items()}
    return [_lists(item) for item in value] if isinstance(value, list | tuple) else value
