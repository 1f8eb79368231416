"""Rules of the house that no other tool checks: untyped code, the list of compiled packages, imports, length."""

from __future__ import annotations

import ast
import re
import subprocess
import sys
import tomllib
from collections.abc import Iterator
from pathlib import Path

import uavftc
from uavftc.core.compile_cache import COMPILED

PACKAGE = Path(uavftc.__file__).parent
FILES = sorted(PACKAGE.rglob("*.py"))
LAWS = ("law", "intrinsic", "overload")
"""Decorators of what is compiled; what numba itself decorates counts too."""
MAX_LINES = 400

Function = ast.FunctionDef | ast.AsyncFunctionDef


def parsed(file: Path) -> ast.Module:
    return ast.parse(file.read_text(encoding="utf-8"))


def root_of(node: ast.expr) -> str:
    """Return the first name of an expression: `numba` of `numba.njit(cache=True)`."""
    while not isinstance(node, ast.Name):
        if isinstance(node, ast.Call):
            node = node.func
        elif isinstance(node, ast.Attribute):
            node = node.value
        else:
            return ""
    return node.id


def compiled_by_call(tree: ast.Module) -> set[str]:
    """Return the functions that are handed to numba by name: `numba.njit(f)`, `numba.njit(signature)(f)`."""
    return {
        argument.id
        for node in ast.walk(tree)
        if isinstance(node, ast.Call) and root_of(node.func) == "numba"
        for argument in node.args
        if isinstance(argument, ast.Name)
    }


def is_law(function: Function, by_call: set[str]) -> bool:
    return function.name in by_call or any(root_of(d) in (*LAWS, "numba") for d in function.decorator_list)


def untyped(node: ast.AST, by_call: set[str]) -> Iterator[Function]:
    """Yield the functions without any annotation that are no laws; what stands inside a law is part of it."""
    for child in ast.iter_child_nodes(node):
        if isinstance(child, Function):
            if is_law(child, by_call):
                continue
            arguments = [*child.args.posonlyargs, *child.args.args, *child.args.kwonlyargs]
            arguments += [a for a in (child.args.vararg, child.args.kwarg) if a is not None]
            if child.returns is None and all(a.annotation is None for a in arguments):
                yield child
        yield from untyped(child, by_call)


def test_a_function_without_annotations_is_a_compiled_law():
    # numba types a law; all other code is typed, and mypy takes only functions with some annotation in hand
    found = []
    for file in FILES:
        tree = parsed(file)
        found += [f"{file.relative_to(PACKAGE)}:{f.lineno} {f.name}" for f in untyped(tree, compiled_by_call(tree))]
    assert not found


def test_the_rule_of_untyped_functions_sees_what_it_is_for():
    # one of each kind, so that a rule that sees nothing does not pass for one that is kept
    tree = ast.parse(
        "@law\ndef a(p, s, row):\n    def inner(x): ...\n"
        "@numba.njit(cache=True)\ndef b(x): ...\n"
        "def c(x): ...\nnumba.njit(signature)(c)\n"
        "def typed(x: int) -> int: ...\n"
        "def d(x): ...\n"
        "class K:\n    def e(self): ...\n    def f(self) -> None:\n        def g(): ...\n"
    )
    assert [f.name for f in untyped(tree, compiled_by_call(tree))] == ["d", "e", "g"]


def test_every_file_with_a_law_is_among_the_compiled():
    # the cache of machine code is named after the files in COMPILED; a law outside them would be served stale
    covered = {
        file
        for part in COMPILED
        for file in ([PACKAGE / part] if part.endswith(".py") else (PACKAGE / part).rglob("*.py"))
    }
    with_laws = {
        file
        for file in FILES
        for node in ast.walk(parsed(file))
        if isinstance(node, Function) and any(root_of(d) in LAWS for d in node.decorator_list)
    }
    assert len(with_laws) >= 15
    assert {str(file.relative_to(PACKAGE)) for file in with_laws - covered} == set()


def test_the_list_of_compiled_packages_stands_once():
    # and each of its parts exists, or a package that was moved would drop out of the name of the cache in silence
    assert [str(file.relative_to(PACKAGE)) for file in FILES if "COMPILED = (" in file.read_text(encoding="utf-8")] == [
        "core/compile_cache.py"
    ]
    assert [part for part in COMPILED if not (PACKAGE / part).exists()] == []


def name_of(file: Path) -> str:
    parts = file.relative_to(PACKAGE.parent).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def imports(tree: ast.Module, modules: set[str]) -> set[str]:
    """Return the modules that are imported outside functions, those for type checking included."""
    found: set[str] = set()
    waiting: list[ast.AST] = [tree]
    while waiting:
        for node in ast.iter_child_nodes(waiting.pop()):
            if isinstance(node, ast.Import):
                found |= {alias.name for alias in node.names}
            elif isinstance(node, ast.ImportFrom) and node.module:
                whole = {f"{node.module}.{alias.name}" for alias in node.names}
                found |= {name if name in modules else node.module for name in whole}
            elif not isinstance(node, Function | ast.Lambda):
                waiting.append(node)
    return found & modules


def circles(graph: dict[str, set[str]]) -> list[list[str]]:
    """Return the strongly connected components of more than one module (Tarjan)."""
    number: dict[str, int] = {}
    low: dict[str, int] = {}
    stack: list[str] = []
    found: list[list[str]] = []

    def visit(module: str) -> None:
        number[module] = low[module] = len(number)
        stack.append(module)
        for other in sorted(graph[module]):
            if other not in number:
                visit(other)
                low[module] = min(low[module], low[other])
            elif other in stack:
                low[module] = min(low[module], number[other])
        if low[module] == number[module]:
            component = stack[stack.index(module) :]
            del stack[stack.index(module) :]
            if len(component) > 1:
                found.append(sorted(component))

    for module in sorted(graph):
        if module not in number:
            visit(module)
    return found


def test_there_is_no_circle_of_imports():
    # a circle works or fails by the order in which its modules are first imported; types alone make one too
    modules = {name_of(file): file for file in FILES}
    graph = {name: imports(parsed(file), set(modules)) - {name} for name, file in modules.items()}
    assert circles(graph) == []


def test_circles_are_found():
    # given one of two modules and one of three behind it
    graph = {"a": {"b"}, "b": {"a", "c"}, "c": {"d"}, "d": {"e"}, "e": {"c"}, "f": {"a"}}
    assert sorted(circles(graph)) == [["a", "b"], ["c", "d", "e"]]


def test_no_file_is_long():
    # what is longer holds more than one thing
    lengths = {str(f.relative_to(PACKAGE)): len(f.read_text(encoding="utf-8").splitlines()) for f in FILES}
    assert {name: n for name, n in lengths.items() if n > MAX_LINES} == {}


EXTRAS = {"cma", "SALib", "distributed", "dask", "gymnasium", "plotly", "jinja2"}
"""Packages that an extra brings; only the modules that need one import it, and no command loads those without need."""
NAMED = {"ruamel.yaml": "ruamel"}
"""Where a package is imported by another name than the one that it is installed by."""
BROUGHT = {"pydantic_core", "llvmlite"}
"""What pydantic and numba are made of, and always bring."""


def test_what_is_imported_is_a_declared_dependency():
    # another package may bring it here, and not in the environment of a user
    text = tomllib.loads((PACKAGE.parents[1] / "pyproject.toml").read_text(encoding="utf-8"))
    declared = {re.split(r"[<>=\[; ]", one)[0] for one in text["project"]["dependencies"]}
    known = {NAMED.get(name, name) for name in declared} | BROUGHT | EXTRAS | {"uavftc", *sys.stdlib_module_names}
    found = set()
    for file in FILES:
        for node in ast.walk(parsed(file)):
            if isinstance(node, ast.Import):
                found |= {(alias.name.partition(".")[0], file.name) for alias in node.names}
            elif isinstance(node, ast.ImportFrom) and not node.level:
                found.add(((node.module or "").partition(".")[0], file.name))
    assert {pair for pair in found if pair[0] not in known} == set()


def test_the_commands_load_where_no_extra_is_installed():
    absent = sorted(EXTRAS | {"pandas"})
    code = f"import sys; sys.modules.update(dict.fromkeys({absent}))\nimport uavftc.cli.app, uavftc.api.doors"
    subprocess.run([sys.executable, "-c", code], check=True)
