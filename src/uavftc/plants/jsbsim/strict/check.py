"""The walk through an aircraft's files: each element against its kind."""

from __future__ import annotations

import difflib
from collections.abc import Iterable
from pathlib import Path
from typing import NamedTuple

from uavftc.aircraft.definition import Aircraft
from uavftc.aircraft.effectors import is_property
from uavftc.errors import InputError
from uavftc.plants.jsbsim.strict import components, functions, propulsion, sections, values
from uavftc.plants.jsbsim.strict.document import Node, read
from uavftc.plants.jsbsim.strict.grammar import PROSE, Kind

KINDS: dict[str, Kind] = {**sections.KINDS, **propulsion.KINDS, **components.KINDS, **functions.KINDS}
_TABLES = frozenset(["table", "propeller-table", "cornering"])
_LOOKED_UP = ("property", "value", "conditions", "argument")
_NOT_LOOKED_UP = ("target", "declaration")
_TAKEN_OUT = ("aircraft-output", "aircraft-input")  # of the copy that JSBSim loads
_NAMED = 24  # names listed in a message
_PATH_PREFIXES = ("xmlns", "xsi:", "xml:")
_FOLDERS = {
    "engine": ("Engines", "engines", "Engine", "engine"),
    "thruster": ("Engines", "engines", "Engine", "engine"),
    "tank": ("Engines", "engines", "Engine", "engine"),
    "propulsion": ("Engines", "engines", "Engine", "engine"),
    "system": ("Systems", "systems"),
}


class Finding(NamedTuple):
    """Something in an aircraft's files that JSBSim passes over, or cannot be meant."""

    path: Path
    line: int
    found: str
    expected: str
    remedy: str

    def error(self) -> InputError:
        """Return it as an error."""
        return InputError(
            f"aircraft file {self.path}, line {self.line}",
            found=self.found,
            expected=self.expected,
            remedy=self.remedy,
        )

    def warning(self) -> str:
        """Return it as one line."""
        return f"{self.path.name}, line {self.line}: {self.found}; {self.remedy}"


class _Walk:
    def __init__(self, aircraft: Aircraft) -> None:
        self.aircraft = aircraft
        self.found: list[Finding] = []
        self.opened: set[tuple[Path, str]] = set()
        self.written: dict[str, tuple[Node, int]] = {}
        self.read: set[str] = set()
        self.reads: dict[str, None] = {}
        """What JSBSim looks up as it flies, in order; `read` has every word that might be one."""

    def add(self, node: Node, line: int, found: str, expected: str, remedy: str) -> None:
        self.found.append(Finding(node.path, line, found, expected, remedy))

    def element(self, node: Node, name: str) -> None:
        """Check an element and all in it against the kind of this name."""
        kind = KINDS[name]
        if kind.form == "prose":
            return
        self.attributes(node, kind)
        self.text(node, kind)
        if kind.form != "rows":
            self.properties(node, name)
        if name not in _NOT_LOOKED_UP:
            self.look_ups(node, kind)
        reads = dict(self.reads)
        self.children(node, kind, self.included(node, name, kind))
        if name in _TAKEN_OUT:
            self.reads = reads
        if name in _TABLES:
            self.table(node)
        if name == "propeller":
            self.coefficients(node)

    def attributes(self, node: Node, kind: Kind) -> None:
        for key, value in node.attributes.items():
            if key.startswith(_PATH_PREFIXES):
                continue
            allowed = kind.attributes.get(key)
            if allowed is None:
                self.unknown(node, node.line, f'{key}="{value}" in <{node.tag}>', key, kind.attributes, '{}="..."')
                continue
            text = value.strip()
            lines = [(node.line, text)] if text else []
            if allowed.words:
                problems = values.words(node.line, lines, allowed.words)
                near = difflib.get_close_matches(text, allowed.words, 1)
            else:
                problems = values.FORMS[allowed.form](node.line, lines)
                near = difflib.get_close_matches(text, values.UNITS, 1) if allowed.form == "unit" else []
            for problem in problems:
                remedy = f'write {key}="{near[0]}"' if near else f"correct or remove the attribute {key}"
                self.add(node, problem.line, f'{key}="{value}" in <{node.tag}>', problem.expected, remedy)
        for key, attribute in kind.attributes.items():
            if attribute.required and key not in node.attributes:
                self.add(
                    node,
                    node.line,
                    f"<{node.tag}> without {key}",
                    f'{key}="..." of <{node.tag}>'
                    + (f": {', '.join(dict.fromkeys(attribute.words))}" * bool(attribute.words)),
                    f'add {key}="..."',
                )

    def text(self, node: Node, kind: Kind) -> None:
        lines = node.lines()
        if kind.form == "rows":  # with its table, which knows the dimensions
            return
        if kind.form is None:
            if lines:
                self.add(
                    node,
                    lines[0][0],
                    f"'{_short(lines[0][1])}' in <{node.tag}>",
                    f"no text in <{node.tag}>: JSBSim passes over it",
                    "put it into an element, or into a comment",
                )
            return
        if kind.form == "conditions" and not lines and not node.children:
            lines = [(node.line, "")]
        problems = (
            values.words(node.line, lines, kind.words) if kind.words else values.FORMS[kind.form](node.line, lines)
        )
        for problem in problems:
            self.add(
                node,
                problem.line,
                f"{problem.found} in <{node.tag}>",
                problem.expected,
                f"write a value into <{node.tag}>"
                if problem.found == "nothing"
                else f"correct the text of <{node.tag}>",
            )

    def children(self, node: Node, kind: Kind, included: Node | None) -> None:
        known = {**dict.fromkeys(PROSE, "prose")} if kind.children else {}
        known |= {tag: child.kind for tag, child in kind.children.items()}
        strangers: list[str] = []
        seen: dict[str, int] = {}
        for child in node.children:
            of = known.get(child.tag)
            if of is None:
                strangers.append(child.tag)
                self.unknown(
                    node, child.line, f"<{child.tag}> as a child of <{node.tag}>", child.tag, kind.children, "<{}>"
                )
                continue
            seen[child.tag] = seen.get(child.tag, 0) + 1
            if seen[child.tag] == 2 and child.tag in kind.children and not kind.children[child.tag].many:
                self.add(
                    node,
                    child.line,
                    f"a second <{child.tag}> in <{node.tag}>",
                    f"one <{child.tag}>: JSBSim reads the first",
                    "remove one of the two",
                )
            if of != "prose":
                self.element(child, of)
        self.missing(node, kind, seen, included, strangers)

    def missing(
        self, node: Node, kind: Kind, seen: dict[str, int], included: Node | None, strangers: list[str]
    ) -> None:
        there = set(seen) | {child.tag for child in included.children} if included else set(seen)
        if kind.file and "file" in node.attributes and included is None:
            return  # JSBSim says which file it does not find
        needed = [(tag,) for tag, child in kind.children.items() if child.required] + list(kind.one_of)
        for tags in needed:
            if there.isdisjoint(tags) and not _near(tags[0], strangers):
                names = " or ".join(f"<{tag}>" for tag in tags)
                self.add(node, node.line, f"<{node.tag}> without {names}", f"{names} in <{node.tag}>", f"add {names}")
        least, most = kind.arguments
        count = sum(1 for child in node.children if child.tag not in PROSE)
        if count < least or (most is not None and count > most):
            expected = f"{least}" if least == most else f"{least} or more" if most is None else f"{least} to {most}"
            self.add(
                node,
                node.line,
                f"{count} terms in <{node.tag}>",
                f"{expected} in <{node.tag}>",
                "add what is missing"
                if count < least
                else "join the terms in a <sum> or <product>: JSBSim reads the first",
            )

    def coefficients(self, node: Node) -> None:
        """Check that a propeller has both its tables, without which JSBSim ends the process."""
        there = {child.attributes.get("name") for child in node.children if child.tag == "table"}
        for name in ("C_THRUST", "C_POWER"):
            if name not in there:
                table = f'<table name="{name}">'
                self.add(node, node.line, f"<propeller> without {table}", f"{table} in <propeller>", f"add {table}")

    def table(self, node: Node) -> None:
        """Check the rows of a table, which follow from the number of its independent variables."""
        variables = sum(1 for child in node.children if child.tag == "independentVar")
        if variables == 0 and node.attributes.get("type") != "internal" and node.tag == "table":
            self.add(
                node,
                node.line,
                "a table without <independentVar>",
                "the property that the table is read by",
                "add <independentVar>",
            )
        data = [child for child in node.children if child.tag == "tableData"]
        nested = len(data) > 1 or any(child.children for child in data)
        for child in data:
            self.rows(child, 2 if nested else {1: 1, 2: 2}.get(variables), inside=nested)

    def rows(self, node: Node, dimensions: int | None, *, inside: bool) -> None:
        if inside and "breakPoint" not in node.attributes:
            self.add(
                node, node.line, "<tableData> without breakPoint", "where this part stands", 'add breakPoint="..."'
            )
        if node.children:
            for child in node.children:
                self.rows(child, dimensions, inside=True)
            return
        for problem in values.rows(node.line, node.lines(), dimensions):
            self.add(node, problem.line, problem.found, problem.expected, "complete or correct the row")

    def unknown(self, node: Node, line: int, found: str, name: str, known: Iterable[str], form: str) -> None:
        names = sorted(known)
        near = _near(name, names)
        if len(names) <= _NAMED:
            expected = f"one of: {', '.join(names)}" if names else f"nothing of that kind in <{node.tag}>"
        else:
            expected = f"{', '.join(near) or ', '.join(names[:_NAMED])}, or another that JSBSim reads there"
        remedy = f"write {form.format(near[0])}" if near else "rename or remove it; JSBSim would pass over it"
        self.add(node, line, found, expected, remedy)

    def look_ups(self, node: Node, kind: Kind) -> None:
        """Keep the properties that JSBSim looks up for an element."""
        texts = [text.split() for _, text in node.lines()] if kind.form in _LOOKED_UP else []
        words = [word for text in texts for word in (text[::2] if kind.form == "conditions" else text)]
        for key, value in node.attributes.items():
            if key in kind.attributes and kind.attributes[key].form in _LOOKED_UP:
                words.append(value.strip())
        for word in words:
            name = word.removeprefix("-")
            if values.is_property(word) and is_property(name.removeprefix("/")):
                self.reads[name] = None

    def properties(self, node: Node, name: str) -> None:
        """Keep the properties that an element writes or reads."""
        for line, text in node.lines():
            if name == "target":
                self.written.setdefault(_bare(text), (node, line))
            else:
                self.read.update(_bare(word) for word in text.split())
        self.read.update(_bare(node.attributes[key]) for key in ("value", "execute") if key in node.attributes)

    def outputs(self) -> None:
        """Check that no output misses, by a letter, the position that the companion file names."""
        positions = {_bare(name) for key, name in self.aircraft.properties() if key.endswith("position")}
        positions |= {
            _bare(name.replace("-cmd-", "-pos-")) for name in self.aircraft.engines().values()
        }  # JSBSim's own
        for position in sorted(positions - set(self.written)):
            stray = [name for name in self.written if name not in self.read | positions]
            for name in difflib.get_close_matches(position, stray, 1, 0.9):
                node, line = self.written[name]
                self.add(
                    node,
                    line,
                    f"<output>{name}</output>, which nothing reads",
                    f"{position}, the position that {self.aircraft.companion.name} names",
                    f"write <output>{position}</output>, or name what is written in {self.aircraft.companion.name}",
                )

    def included(self, node: Node, name: str, kind: Kind) -> Node | None:
        """Check the file that an element names, and return its root."""
        file = node.attributes.get("file", "").strip()
        if not kind.file or not file:
            return None
        path = self.find(name, file)
        if path is None:
            return None
        root = read(path, "a file of a JSBSim aircraft")
        of = name if root.tag == node.tag else root.tag
        if root.tag != node.tag and root.tag not in kind.children:
            self.unknown(
                root, root.line, f"<{root.tag}> as the root of a file for <{node.tag}>", root.tag, kind.children, "<{}>"
            )
        elif (path, of) not in self.opened:
            self.opened.add((path, of))
            self.element(root, of)
        return root

    def find(self, name: str, file: str) -> Path | None:
        """Return the file that JSBSim would open."""
        folder_of_aircraft = self.aircraft.folder
        shared = {"system": self.aircraft.systems_dir}.get(name, self.aircraft.engine_dir)
        for folder in (folder_of_aircraft, *(folder_of_aircraft / inner for inner in _FOLDERS.get(name, ())), shared):
            path = folder / (file if file.endswith(".xml") else f"{file}.xml")
            if path.is_file():
                return path
        return None


def findings(aircraft: Aircraft) -> list[Finding]:
    """Return what is wrong with an aircraft's files, as `examined`."""
    return examined(aircraft)[0]


def examined(aircraft: Aircraft) -> tuple[list[Finding], list[str]]:
    """Return what is wrong with an aircraft's files, and the properties that they read, without sign.

    The files are the aircraft's, all that it includes, and its planet's.

    Raises
    ------
    InputError
        If one of them cannot be read or is not well-formed, or the aircraft's root is not `fdm_config`.
    """
    walk = _Walk(aircraft)
    root = read(aircraft.xml)
    if root.tag != "fdm_config":
        walk.unknown(root, root.line, f"<{root.tag}> as the document's root", root.tag, ["fdm_config"], "<{}>")
        raise walk.found[0].error()
    walk.element(root, "fdm_config")
    walk.outputs()
    planet = aircraft.folder / aircraft.planet if aircraft.planet else None
    if planet is not None and planet.is_file():
        root = read(planet, "a planet's file")
        if root.tag == "planet":
            walk.element(root, "planet")
        else:
            walk.unknown(root, root.line, f"<{root.tag}> as the root of a planet's file", root.tag, ["planet"], "<{}>")
    return walk.found, list(walk.reads)


def _bare(name: str) -> str:
    """Return the name of a property without sign and without the index 0, which is understood."""
    return name.strip().removeprefix("-").replace("[0]", "")


def _near(name: str, names: Iterable[str]) -> list[str]:
    """Return the names that may have been meant, nearest first; upper and lower case count as one."""
    folded: dict[str, str] = {}
    for known in names:
        folded.setdefault(known.lower(), known)
    cutoff = 0.5 if len(name) <= 3 else 0.6
    return [folded[found] for found in difflib.get_close_matches(name.lower(), folded, 3, cutoff)]


def _short(text: str) -> str:
    return text if len(text) <= 40 else f"{text[:37]}..."
