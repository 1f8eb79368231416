"""What may stand in an element: the few words in which the tables of this package are written.

A `Kind` is one way an element is read; two elements of one name can be of different kinds (the `<output>` of a
component is a property's name, that of an aircraft a file). Children are written by kind, `{"number": "ixx! iyy"}`,
with a mark behind the name: `!` must be there, `*` any number, `+` one or more, none at most one. Attributes are
`name`, `name!` where it must be there, and `name=what`, with what a form of `values.FORMS` or the words allowed,
`OR|AND`. Words stand in strings, because a table of a hundred names is read more easily so.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

PROSE = ("documentation", "description", "limitation", "note", "reference")
"""Elements for people: allowed in every element with children, and never looked into."""


class Child(NamedTuple):
    """A child of an element."""

    kind: str
    required: bool
    many: bool


class Attribute(NamedTuple):
    """An attribute: the form of its value, or the words allowed; `any` for whatever is not empty."""

    required: bool
    form: str
    words: tuple[str, ...]


class Kind(NamedTuple):
    """How an element is read."""

    children: Mapping[str, Child]
    attributes: Mapping[str, Attribute]
    form: str | None
    """Form of its text, from `values.FORMS`; None where JSBSim passes over text."""
    words: tuple[str, ...]
    """Texts allowed, where they are few."""
    one_of: tuple[tuple[str, ...], ...]
    """Of each of these sets of children one must be there."""
    arguments: tuple[int, int | None]
    """Least and greatest number of children, those for people not counted."""
    file: bool
    """Whether its content may stand in another file, named by the attribute `file`."""


def kind(
    children: Mapping[str, str] | None = None,
    attributes: str = "",
    *,
    form: str | None = None,
    words: str = "",
    one_of: tuple[str, ...] = (),
    arguments: tuple[int, int | None] = (0, None),
    file: bool = False,
) -> Kind:
    """Return a kind from its short notation."""
    known = {}
    for of, names in (children or {}).items():
        for name in names.split():
            bare = name.rstrip("!*+")
            known[bare] = Child(of, required=name[-1] in "!+", many=name[-1] in "*+")
    allowed = {}
    for name in (attributes + (" file" if file else "")).split():
        bare, _, form_of = name.partition("=")
        choices = tuple(form_of.split("|")) if "|" in form_of else ()
        allowed[bare.rstrip("!")] = Attribute(bare.endswith("!"), "any" if choices else form_of or "any", choices)
    alternatives = tuple(tuple(names.split("|")) for names in one_of)
    return Kind(known, allowed, form, tuple(words.split()), alternatives, arguments, file)
