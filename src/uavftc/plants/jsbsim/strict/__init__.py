"""A strict check of a JSBSim aircraft's files.

JSBSim passes over what it does not know: a misspelt element costs a whole term, an emptied value a factor. Here every
element, attribute and value of the sections that JSBSim reads is held against what JSBSim 1.3 reads there
(`sections`, `propulsion`, `components`, `functions`, written in the words of `grammar`). Of an aircraft with a
companion file every finding is an error that it does not allow; of any other it is a warning.
"""

from __future__ import annotations

import functools

from uavftc.aircraft.definition import Aircraft
from uavftc.errors import InputError, join
from uavftc.plants.jsbsim.strict.check import Finding, examined, findings

__all__ = ["Finding", "findings", "reads", "refuse", "warnings"]

_SHOWN = 4  # warnings and errors of one aircraft that are listed; the first ones name the cause


@functools.lru_cache(maxsize=64)
def _kept(aircraft: Aircraft, _checksum: str) -> tuple[tuple[Finding, ...], tuple[str, ...]]:
    found, read = examined(aircraft)
    return tuple(found), tuple(read)


def refuse(aircraft: Aircraft) -> None:
    """Refuse an aircraft whose XML says something that JSBSim would not read and its companion file does not allow.

    Raises
    ------
    InputError
        With file, line, what was found and what was expected.
    """
    if not aircraft.strict:
        return
    found = [f for f in _kept(aircraft, aircraft.sha256())[0] if not aircraft.allows(f.warning())]
    if found:
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
    """Return what is wrong with the files of an aircraft and allowed, one line each, a few and a count."""
    if aircraft.strict and aircraft.warnings == "strict":
        return []
    try:
        found, _ = _kept(aircraft, aircraft.sha256())
    except InputError as error:
        return [f"{error.where}: {error.found}"]
    lines = [finding.warning() for finding in found[:_SHOWN]]
    if len(found) > _SHOWN:
        lines.append(f"{aircraft.xml.name}: {len(found) - _SHOWN} more of this kind")
    return lines


def reads(aircraft: Aircraft) -> tuple[str, ...]:
    """Return the properties that an aircraft reads, as JSBSim looks them up, without sign; none if it is unreadable."""
    try:
        return _kept(aircraft, aircraft.sha256())[1]
    except InputError:
        return ()
