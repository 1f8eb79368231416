"""An XML file as a tree whose every piece knows its line; expat, because other readers lose the lines of text."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from xml.parsers import expat

from uavftc.errors import InputError


@dataclass
class Node:
    """An element."""

    tag: str
    attributes: dict[str, str]
    line: int
    path: Path
    children: list[Node] = field(default_factory=list)
    pieces: list[tuple[int, str]] = field(default_factory=list)
    """Text as expat gives it, at most one line a piece, with line numbers."""

    def lines(self) -> list[tuple[int, str]]:
        """Return the lines of text that are not blank, stripped, with their numbers."""
        joined: dict[int, str] = {}
        for line, piece in self.pieces:
            joined[line] = joined.get(line, "") + piece
        return [(line, text.strip()) for line, text in joined.items() if text.strip()]


def read(path: Path, what: str = "a JSBSim aircraft definition") -> Node:
    """Return the root of a file.

    Raises
    ------
    InputError
        If the file cannot be read or is not well-formed.
    """
    parser = expat.ParserCreate()
    opened: list[Node] = []
    roots: list[Node] = []

    def start(tag: str, attributes: dict[str, str]) -> None:
        node = Node(tag, attributes, parser.CurrentLineNumber, path)
        (opened[-1].children if opened else roots).append(node)
        opened.append(node)

    def text(piece: str) -> None:
        if opened:
            opened[-1].pieces.append((parser.CurrentLineNumber, piece))

    parser.StartElementHandler = start
    parser.EndElementHandler = lambda _tag: opened.pop()
    parser.CharacterDataHandler = text
    try:
        parser.Parse(path.read_bytes(), True)
    except OSError as error:
        raise InputError(
            f"aircraft file {path}",
            found=error.strerror or str(error),
            expected=what,
            remedy="check the path and its permissions",
        ) from None
    except expat.ExpatError as error:
        raise InputError(
            f"aircraft file {path}, line {error.lineno}",
            found=f"malformed XML: {expat.errors.messages[error.code]}",
            expected="well-formed XML",
            remedy="close and nest the elements around this line properly",
        ) from None
    return roots[0]
