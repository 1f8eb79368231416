"""Mutants of an aircraft's XML: one typing error each, systematic over every element, attribute, value and row."""

from __future__ import annotations

import random
import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

_TOKEN = re.compile(r"<(/?)([A-Za-z_][\w.-]*)((?:\s+[\w:.-]+\s*=\s*(?:\"[^\"]*\"|'[^']*'))*)\s*(/?)>")
_ATTRIBUTE = re.compile(r"([\w:.-]+)\s*=\s*([\"'])(.*?)\2")


class Mutant(NamedTuple):
    """A change of one file."""

    kind: str
    """What was done, such as `element name`."""
    file: str
    role: str
    """Parent and element, such as `product/property`."""
    start: int
    end: int
    text: str
    """What replaces file[start:end]."""
    close: tuple[int, int] | None = None
    """The name in the closing tag, which is replaced by the same text."""

    @property
    def name(self) -> str:
        return f"{self.kind}: {self.file} {self.role} at {self.start}"

    def applied(self, source: str) -> str:
        """Return the file's text with the change."""
        if self.close is not None:
            first, last = self.close
            source = source[:first] + self.text + source[last:]
        return source[: self.start] + self.text + source[self.end :]


@dataclass
class Element:
    tag: str
    name: tuple[int, int]
    attributes: list[tuple[tuple[int, int], tuple[int, int]]]
    start: int
    inside: int
    parent: str
    close: tuple[int, int] | None = None
    end: int = 0
    outside: int = 0
    """Where its text ends."""
    children: list[Element] = field(default_factory=list)


def elements(text: str) -> list[Element]:
    """Return the elements of a document, in their order; comments are skipped, places stay."""
    bare = re.sub("<!--.*?-->", lambda found: " " * len(found[0]), text, flags=re.DOTALL)
    found: list[Element] = []
    opened: list[Element] = []
    for token in _TOKEN.finditer(bare):
        if token[1]:
            element = opened.pop()
            element.close, element.outside, element.end = token.span(2), token.start(), token.end()
            continue
        offset = token.start(3)
        attributes = [
            ((offset + a.start(1), offset + a.end(1)), (offset + a.start(3), offset + a.end(3)))
            for a in _ATTRIBUTE.finditer(token[3])
        ]
        parent = opened[-1].tag if opened else ""
        element = Element(token[2], token.span(2), attributes, token.start(), token.end(), parent)
        element.end, element.outside = token.end(), token.end()
        if opened:
            opened[-1].children.append(element)
        found.append(element)
        if not token[4]:
            opened.append(element)
    return found


def misspelt(word: str, rng: random.Random) -> str:
    """Return a word with one letter dropped, doubled or changed, or two of them exchanged."""
    places = [i for i, letter in enumerate(word) if letter.isalpha()]
    while True:
        i = rng.choice(places)
        how = rng.randrange(4)
        if how == 0 and len(places) > 1:
            made = word[:i] + word[i + 1 :]
        elif how == 1:
            made = word[: i + 1] + word[i:]
        elif how == 2 and i + 1 < len(word) and word[i + 1].isalpha():
            made = word[:i] + word[i + 1] + word[i] + word[i + 2 :]
        else:
            made = word[:i] + rng.choice("abcdefghijklmnopqrstuvwxyz") + word[i + 1 :]
        if made != word and (made[0] == word[0] or made[0].isalpha()):
            return made


def mutants(folder: Path, seed: int = 0) -> Iterator[Mutant]:
    """Yield every mutant of the XML files of an aircraft's folder."""
    rng = random.Random(seed)
    for path in sorted(folder.rglob("*.xml")):
        text, file = path.read_text(encoding="utf-8"), path.relative_to(folder).as_posix()
        for element in elements(text):
            yield from _of_element(text, file, element, rng)


def _of_element(text: str, file: str, element: Element, rng: random.Random) -> Iterator[Mutant]:
    role = f"{element.parent}/{element.tag}"
    yield Mutant("element name", file, role, *element.name, misspelt(element.tag, rng), element.close)
    if element.parent:
        yield Mutant("child dropped", file, role, element.start, element.end, "")
    for name, value in element.attributes:
        key, word = text[slice(*name)], text[slice(*value)]
        at = f"{role}@{key}"
        yield Mutant("attribute name", file, at, *name, misspelt(key, rng))
        yield Mutant("attribute emptied", file, at, *value, "")
        if any(letter.isalpha() for letter in word):
            yield Mutant("attribute value", file, at, *value, misspelt(word, rng))
    content = text[element.inside : element.outside]
    if element.children or not content.strip():
        return
    first = element.inside + len(content) - len(content.lstrip())
    last = element.inside + len(content.rstrip())
    yield Mutant("value emptied", file, role, element.inside, element.outside, "")
    if element.tag == "tableData":
        for word in re.finditer(r"\S+", text[first:last]):
            yield Mutant("number dropped", file, role, first + word.start(), first + word.end(), "")
    elif re.fullmatch(r"[-+\d.eE]+", text[first:last]):
        yield Mutant("not a number", file, role, first, last, rng.choice(["nan", "inf", "-", "1,5", "0x10", "1 2"]))
    elif any(letter.isalpha() for letter in text[first:last]):
        yield Mutant("word misspelt", file, role, first, last, misspelt(text[first:last], rng))
