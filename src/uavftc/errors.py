"""The one error a user can cause: wrong input, with what is needed to fix it."""

from __future__ import annotations

from collections.abc import Sequence


def printable(text: str) -> str:
    """Return a text as it can be shown: what would steer a terminal or has no form, as its escape; on one line."""
    return "".join(ch if ch.isprintable() else repr(ch)[1:-1] for ch in text)


class InputError(Exception):
    """Something the user gave is wrong; the command line turns it into exit code 2.

    Parameters
    ----------
    where
        Place of the error: file, line and key, or the option.
    found
        What is there.
    expected
        What should be there.
    remedy
        How to fix it.
    """

    def __init__(self, where: str, *, found: str, expected: str, remedy: str) -> None:
        where, found, expected, remedy = map(printable, (where, found, expected, remedy))
        super().__init__(where, found, expected, remedy)
        self.where = where
        self.found = found
        self.expected = expected
        self.remedy = remedy

    def __str__(self) -> str:
        return f"{self.where}\n  found:    {self.found}\n  expected: {self.expected}\n  remedy:   {self.remedy}"

    def __reduce__(self) -> tuple[object, ...]:  # keyword-only arguments: the default would not come back in a worker
        return _rebuild, (type(self), self.where, self.found, self.expected, self.remedy)


def _rebuild(kind: type[InputError], where: str, found: str, expected: str, remedy: str) -> InputError:
    return kind(where, found=found, expected=expected, remedy=remedy)


class CombinedInputError(InputError):
    """Several input errors reported at once; its fields are those of the first.

    Parameters
    ----------
    errors
        Two or more; `join` gives the right class for any number.
    """

    def __init__(self, errors: Sequence[InputError]) -> None:
        first = errors[0]
        super().__init__(first.where, found=first.found, expected=first.expected, remedy=first.remedy)
        self.errors = tuple(errors)

    def __str__(self) -> str:
        parts = [f"{i}. {error}" for i, error in enumerate(self.errors, start=1)]
        return "\n".join([f"{len(self.errors)} errors in the input", *parts])

    def __reduce__(self) -> tuple[object, ...]:
        return type(self), (self.errors,)


def join(errors: Sequence[InputError]) -> InputError:
    """Return one error that reports all of `errors`, in their order."""
    return errors[0] if len(errors) == 1 else CombinedInputError(errors)
