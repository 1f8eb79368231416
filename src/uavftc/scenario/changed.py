"""A scenario changed by values, in Python: with the same checks and messages as one read from a file."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import suppress
from typing import Any

from uavftc.config.document import Document
from uavftc.errors import InputError
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
    return _made(plain_data(scenario.model_dump()), values, _places(values, where))


class Changing:
    """A scenario that is changed many times, each time from what it is; what does not change is checked once.

    Sections in which no key changes stay the objects they are, and only what concerns several sections is checked
    again. Where anything is wrong, the whole is made anew, for the messages.
    """

    def __init__(self, scenario: Scenario) -> None:
        self._data = scenario.model_dump()
        self._same = dict(scenario_of(Document(plain_data(self._data), "")))

    def __call__(self, values: Mapping[str, Any], where: str | Mapping[str, str] = "") -> Scenario:
        """Return it with other values at dotted keys; arguments and errors as those of `changed`.

        `where` may give each key its place.
        """
        places = _places(values, where)
        sections = {key.partition(".")[0].partition("[")[0] for key in values}
        if sections <= self._same.keys():
            data = {name: plain_data(self._data[name]) if name in sections else self._same[name] for name in self._data}
            with suppress(InputError):
                return _made(data, values, places)
        return _made(plain_data(self._data), values, places)


def _places(values: Mapping[str, Any], where: str | Mapping[str, str]) -> Mapping[str, str]:
    return where if isinstance(where, Mapping) else dict.fromkeys(values, where)


def _made(data: dict[str, Any], values: Mapping[str, Any], places: Mapping[str, str]) -> Scenario:
    document = Document(data, next(iter(places.values()), "") or "a change of the scenario")
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
