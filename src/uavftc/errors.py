"""The one error a user can cause: wrong input, told so that it can be mended."""

from __future__ import annotations


class InputError(Exception):
    """Something the user gave is wrong; the command line turns it into exit code 2.

    Parameters
    ----------
    where
        Place of the fault: file, line and key, or the option.
    found
        What stands there.
    expected
        What should stand there.
    remedy
        How to mend it.
    """

    def __init__(self, where: str, *, found: str, expected: str, remedy: str) -> None:
        super().__init__(where, found, expected, remedy)
        self.where = where
        self.found = found
        self.expected = expected
        self.remedy = remedy

    def __str__(self) -> str:
        return (
            f"{self.where}\n  found:    {self.found}\n  expected: {self.expected}\n  remedy:   {self.remedy}"
        )
