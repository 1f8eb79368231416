"""Variants of a controller in a comparison: named changes of its keys, ``NAME:KEY=VALUE``.

    --variant fast:controller.inner.filter_bandwidth=120
    --variant k6:controller.options.k=6 --variant k6:controller.options.k_i=2      two keys of one variant

A variant is of the scenario's controller, or of the first one that is compared; it is flown next to that one, under
its own name.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import NamedTuple

from uavftc.errors import InputError

_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_-]{0,99}")
_EXAMPLE = "--variant fast:controller.inner.filter_bandwidth=120"


class Variant(NamedTuple):
    """One variant: its name, and its changes as the user wrote them."""

    name: str
    changes: tuple[str, ...]
    """KEY=VALUE each."""

    @property
    def options(self) -> list[tuple[str, str]]:
        """Return each change with the option that it was given by, for messages."""
        return [(f"--variant {self.name}:{change}"[:200], change) for change in self.changes]


def variants_of(texts: Sequence[str], taken: Sequence[str]) -> list[Variant]:
    """Return the variants that options name, in their order; those of one name are one.

    Parameters
    ----------
    texts
        NAME:KEY=VALUE each.
    taken
        Names of the controllers that are compared.

    Raises
    ------
    InputError
        If one has no name or one that is taken, or changes anything but the controller.
    """
    changes: dict[str, list[str]] = {}
    for text in texts:
        where = f"--variant {text[:200]}"
        name, colon, change = text.partition(":")
        if not colon or _NAME.fullmatch(name) is None:
            found = "no name before a colon" if not colon else f"the name '{name}'"
            expected = "NAME:KEY=VALUE, the name of letters, digits, _ and -"
            raise InputError(where, found=found, expected=expected, remedy=f"for example {_EXAMPLE}")
        if name in taken:
            remedy = "choose another name: results are named after it"
            raise InputError(
                where, found=f"{name}, which is one of the controllers", expected="a name of its own", remedy=remedy
            )
        key = change.partition("=")[0].strip()
        if not key.startswith("controller.") or key == "controller.kind":
            found = f"the key {key}" if key else "no key"
            remedy = "name another controller in --controllers" if key == "controller.kind" else f"as in {_EXAMPLE}"
            expected = "a key below controller, other than its kind: a comparison is of controllers"
            raise InputError(where, found=found, expected=expected, remedy=remedy)
        changes.setdefault(name, []).append(change)
    return [Variant(name, tuple(each)) for name, each in changes.items()]
