"""What each law says that it reads and writes is what its source does."""

from __future__ import annotations

import ast
import inspect
import textwrap
from types import ModuleType

import pytest

from uavftc import actuators, environment, sensors
from uavftc.control import allocation, inner, outer
from uavftc.control.custom import controller, memory
from uavftc.control.whole import lqi
from uavftc.core.signals import EFFECTOR, ROW
from uavftc.core.stage import Stage
from uavftc.flight import envelope
from uavftc.plants import analytic
from uavftc.plants.jsbsim import bridge

RECORD = object()
"""Stands for the row or the effector among the names of a law; a field of either stands by its name."""


def stages_of(module: ModuleType) -> list[Stage]:
    """Return the stages of a module, also those in a tuple of it."""
    found = [item for value in vars(module).values() for item in (value if isinstance(value, tuple) else (value,))]
    return list({id(item): item for item in found if isinstance(item, Stage)}.values())


MODULES = (
    *actuators.CHAIN, *environment.KINDS, *sensors.CHAIN, *outer.KINDS, *inner.KINDS, lqi, allocation, envelope,
    analytic, controller, memory,
)  # fmt: skip
STAGES = {f"{module.__name__}.{stage.python.__name__}": stage for module in MODULES for stage in stages_of(module)}
BRIDGE = {stage.python.__name__: stage for stage in stages_of(bridge)}


class Use(ast.NodeVisitor):
    """Fields of the records among `names` that a function reads and writes, also through what it calls."""

    def __init__(self, function, names):
        self.reads, self.writes = set(), set()
        self._function, self._names = getattr(function, "py_func", function), dict(names)
        (definition,) = ast.parse(textwrap.dedent(inspect.getsource(self._function))).body
        for statement in definition.body:
            self.visit(statement)

    def _meant(self, node):
        """Return what an expression stands for: RECORD, the name of a field, or None."""
        if isinstance(node, ast.Name):
            return self._names.get(node.id)
        if isinstance(node, ast.Attribute) and self._meant(node.value) is RECORD:
            return node.attr
        return None

    def _store(self, target):
        if isinstance(target, ast.Tuple):
            for part in target.elts:
                self._store(part)
            return
        inside = target.value if isinstance(target, ast.Subscript) else target
        field = self._meant(inside) if not isinstance(target, ast.Name) else None
        if isinstance(field, str):
            self.writes.add(field)
        if isinstance(target, ast.Subscript):
            self.visit(target.slice)

    def _read(self, field):
        if isinstance(field, str) and field not in self.writes:  # what it has written itself it may read
            self.reads.add(field)

    def visit_Assign(self, node):
        (target,) = node.targets
        several = isinstance(target, ast.Tuple) and isinstance(node.value, ast.Tuple)
        pairs = zip(target.elts, node.value.elts, strict=True) if several else [(target, node.value)]
        aliases = {}
        for name, value in pairs:
            if isinstance(name, ast.Name):
                aliases[name.id] = self._meant(value)
            if not (isinstance(name, ast.Name) and self._meant(value) is not None):  # another name for it does not help
                self.visit(value)
        self._names.update(aliases)
        self._store(target)

    def visit_AugAssign(self, node):
        self.visit(node.value)
        self.visit(node.target)  # it is read first
        self._store(node.target)

    def visit_Attribute(self, node):
        self._read(self._meant(node))
        self.generic_visit(node)

    def visit_Name(self, node):
        self._read(self._meant(node))

    def visit_Call(self, node):
        called = self._function.__globals__.get(node.func.id) if isinstance(node.func, ast.Name) else None
        given = [self._meant(argument) for argument in node.args]
        if hasattr(called, "py_func") and any(item is not None for item in given):
            inside = Use(called, zip(inspect.signature(called.py_func).parameters, given, strict=True))
            self.reads |= inside.reads - self.writes
            self.writes |= inside.writes
            rest = [argument for argument, item in zip(node.args, given, strict=True) if item is None]
        else:
            rest = node.args
        for argument in rest:
            self.visit(argument)


def uses(stage: Stage) -> Use:
    """Return what the law of a stage does with the row and the effector, its last parameters."""
    names = list(inspect.signature(stage.python).parameters)[2:]
    return Use(stage.python, [(name, RECORD) for name in names])


def lines(p, s, e, row):
    """No law: each way to use a record once."""
    a, b = row.x1, row.x2
    a[0] = b[row.t > 0]
    v1 = row.v1
    e.deflection += v1[0]
    row.d1[0], row.d2[0] = helper(p, row, row.u2)
    e.command = e.bias if row.throttle else 0.0
    s.x = e.command + row.x1[1]
    v1 = p.height
    v1[0] = s.alpha


def _helper(p, record, u2):
    first = u2[0]
    u2[1] = record.beta
    return p.x, first


class helper:  # noqa: N801 - stands for a compiled function
    py_func = staticmethod(_helper)


def test_the_reader_of_laws_sees_every_way_to_use_a_record():
    # aliases, tuples, additions in place, functions that are given the record or a field of it;
    # what the law has written itself it may read
    found = uses(Stage(lines))
    assert found.reads == {"x2", "t", "v1", "deflection", "beta", "u2", "bias", "throttle"}
    assert found.writes == {"x1", "deflection", "u2", "d1", "d2", "command"}


def test_no_stage_is_left_out():
    # every law of a chain, the controllers, the allocation, the watch and the plants
    assert len(STAGES) >= 16
    assert {name.rpartition(".")[2] for name in STAGES} >= {
        "step", "observe", "allocate_gang", "gather_gang", "allocate_mixed", "gather_mixed", "_write_nan",
    }  # fmt: skip
    assert len(BRIDGE) == 6


@pytest.mark.parametrize("name", STAGES)
def test_a_law_reads_and_writes_what_it_says(name):
    # a flight is refused by what the laws say: a law that says less flies on what nothing has written
    stage, found = STAGES[name], uses(STAGES[name])
    assert found.reads == stage.reads
    assert found.writes == stage.writes


@pytest.mark.parametrize("name", BRIDGE)
def test_a_law_of_the_bridge_reads_and_writes_what_it_says(name):
    # as every other
    stage, found = BRIDGE[name], uses(BRIDGE[name])
    assert (found.reads, found.writes) == (stage.reads, stage.writes)


@pytest.mark.parametrize("name", STAGES)
def test_what_a_law_names_is_a_field(name):
    # a law on the row has no effector to read from
    known = {*ROW.names, *(EFFECTOR.names if STAGES[name].on_effector else ())}
    assert STAGES[name].reads | STAGES[name].writes <= known
