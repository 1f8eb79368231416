"""A strict check of a JSBSim aircraft's files.

JSBSim passes over what it does not know: a misspelt element costs a whole term, an emptied value a factor. Here every
element, attribute and value of the sections that JSBSim reads is held against what JSBSim 1.3 reads there
(`sections`, `propulsion`, `components`, `functions`, written in the words of `grammar`). Of an aircraft with a
companion file every finding is an error; of any other it is a warning.
"""

from __future__ import annotations

import functools

from uavftc.aircraft.definition import Aircraft
from uavftc.errors import InputError, join
from uavftc.plants.jsbsim.strict.check import Finding, findings

__all__ = ["Finding", "findings", "refuse", "warnings"]

_SHOWN = 4  # warnings and errors of one aircraft that are listed; the first ones name the cause


@functools.lru_cache(maxsize=64)
def _kept(aircraft: Aircraft, _checksum: str) -> tuple[Finding, ...]:
    return tuple(findings(aircraft))


def refuse(aircraft: Aircraft) -> None:
    """Refuse an aircraft with a companion file whose XML says something that JSBSim would not read.

    Raises
    ------
    InputError
        With file, line, what was found and what was expected.
    """
    if aircraft.strict and (found := _kept(aircraft, aircraft.sha256())):
        errors = [finding.error() for finding in found]
        if len(errors) > _SHOWN + 1:  # one more takes no more room than to say so
            errors[_SHOWN:] = [
                InputError(
                    f"aircraft {aircraft.name}, {aircraft.xml}",
                    found=f"{len(found) - _SHOWN} more of this kind",
                    expected="none",
                    remedy="correct these first; the others are shown then",
                )
            ]
        raise join(errors)


def warnings(aircraft: Aircraft) -> list[str]:
    """Return what is wrong with the files of an aircraft without a companion file, one line each, a few and a count."""
    if aircraft.strict:
        return []
    try:
        found = _kept(aircraft, aircraft.sha256())
    except InputError as error:
        return [f"{error.where}: {error.found}"]
    lines = [finding.warning() for finding in found[:_SHOWN]]
    if len(found) > _SHOWN:
        lines.append(f"{aircraft.xml.name}: {len(found) - _SHOWN} more of this kind")
    return lines
