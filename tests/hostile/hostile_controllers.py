"""Hostile controllers, generated: what a step returns and raises, telemetry, modules, and compiled laws.

Each is one file with what it does at a time: at the trial (exit code 2, nothing written) or in flight after 0.5 s (exit
code 3, the 101 rows up to there kept). `python tests/hostile/hostile_controllers.py` flies them all and counts.
"""

from __future__ import annotations

import atexit
import json
import os
import sys
import tempfile
import textwrap
import time
import traceback
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

TRIAL, FLIGHT = 2, 3
"""The promised exit codes."""

ROWS = 101  # rows up to 0.5 s at 200 Hz, t = 0 included
DEADLINE_S = 60.0  # of one case, on a busy computer; none of them takes a tenth of it alone


class Case(NamedTuple):
    """One controller and what is promised of it."""

    name: str
    source: str
    code: int
    words: tuple[str, ...] = ()
    """What the message has to contain."""
    options: tuple[str, ...] = ()
    """More of the command line."""


HEAD = """
import asyncio, collections, decimal, fractions, itertools, time, warnings
import numpy as np

def raising(name, error=RuntimeError("no look"), base=object):
    def method(self, *a, **k):
        raise error
    return type("Hostile", (base,), {name: method})

class Meta(type):
    @property
    def __name__(cls): raise RuntimeError("metaclass")
    @property
    def __module__(cls): raise RuntimeError("metaclass")
    def __repr__(cls): raise RuntimeError("metaclass")

class Endless:
    def __len__(self): return 3
    def __getitem__(self, i): return 0.0

class TextRaises(Exception):
    def __str__(self): raise RuntimeError("no text")
    __repr__ = __str__

class TextIsNone(Exception):
    def __str__(self): return None

class MetaError(Exception, metaclass=Meta): pass

class Own(BaseException): pass

class Noted(Exception):
    __notes__ = raising("__iter__")()

class Tensor:
    '''As a tensor that requires grad.'''
    def __array__(self, *a, **k): raise RuntimeError("Can't call numpy() on Tensor that requires grad.")
    def __len__(self): return 3
    def __getitem__(self, i): raise RuntimeError("no item")

class Shape(np.ndarray):
    @property
    def shape(self): raise RuntimeError("no shape")
    def __repr__(self): raise RuntimeError("no repr")
    def __array_finalize__(self, other): pass

def shape():
    return np.zeros(4).view(Shape)

class Liar:
    '''Says that it is an array.'''
    @property
    def __class__(self): raise RuntimeError("no class")

class Dict(dict):
    def __contains__(self, name): raise RuntimeError("no names")
    def __iter__(self): raise RuntimeError("no names")
    def get(self, *a): raise RuntimeError("no names")
    def __getitem__(self, name): raise RuntimeError("no items")

class Key(str):
    def __hash__(self): return hash("v1")
    def __eq__(self, other): raise RuntimeError("no comparison")
"""

RETURNS = {
    "array raises": "raising('__array__')()",
    "array raises a base exception": "raising('__array__', Own('base'))()",
    "a tensor that requires grad": "Tensor()",
    "array returns a text": "type('A', (), {'__array__': lambda s, *a, **k: 'text'})()",
    "iter raises": "raising('__iter__', base=list)([0, 0, 0])",
    "len raises": "type('A', (), {'__len__': lambda s: 1 / 0, '__getitem__': lambda s, i: [0, 0][i]})()",
    "getattr raises": "raising('__getattr__')()",
    "getattribute raises": "raising('__getattribute__')()",
    "float raises": "[raising('__float__')(), 0, 0]",
    "float of a float raises": "[raising('__float__', base=float)(0.5), 0, 0]",
    "repr raises": "raising('__repr__')()",
    "repr raises a base exception": "raising('__repr__', KeyboardInterrupt())()",
    "repr is no text": "type('A', (), {'__repr__': lambda s: 5})()",
    "repr has a surrogate": "type('A', (), {'__repr__': lambda s: chr(0xd800)})()",
    "repr has an escape": "type('A', (), {'__repr__': lambda s: chr(27) + '[2J'})()",
    "repr is long": "type('A', (), {'__repr__': lambda s: 'x' * 10**7})()",
    "metaclass raises": "Meta('A', (), {})()",
    "class raises": "Liar()",
    "shape raises": "shape()",
    "endless": "Endless()",
    "an endless iterator": "itertools.count()",
    "three endless": "[Endless(), Endless(), Endless()]",
    "a huge number": "[10**400, 0, 0]",
    "a huge numpy object": "np.array([10**400, 0, 0], dtype=object)",
    "complex array": "np.zeros(3) * 1j",
    "complex list": "[0j, 0j, 0j]",
    "texts": "['0.1', '0.1', '0.1']",
    "a text of three": "'123'",
    "bytes of three": "b'123'",
    "an array of texts": "np.array(['0.1'] * 3)",
    "a dict": "{0: 0.1, 1: 0.1, 2: 0.1}",
    "a set": "{0.1, 0.2, 0.3}",
    "a generator": "(x for x in (0.1, 0.1, 0.1))",
    "truth values": "[True, False, True]",
    "an array of truth values": "np.array([True, False, True])",
    "decimals": "[decimal.Decimal(0)] * 3",
    "fractions": "[fractions.Fraction(1, 3)] * 3",
    "times": "np.array([1, 2, 3], dtype='m8[s]')",
    "a record": "np.zeros(3, dtype=[('a', 'f8')])",
    "nothing": "None",
    "a number": "0.1",
    "two": "[0.1, 0.1]",
    "four": "(0.1, 0.1, 0.1, 0.1)",
    "a matrix": "np.zeros((3, 3))",
    "a column": "np.zeros((3, 1))",
    "ten million": "[0.0] * 10**7",
    "nested": "[[0.1], [0.1], [0.1]]",
    "itself": "(lambda a: (a.append(a), a)[1])([0, 0])",
    "a class": "list",
    "a coroutine": "(warnings.simplefilter('ignore'), asyncio.sleep(0))[1]",
    "nothing among numbers": "[0.1, None, 0.1]",
    "a result with two maps": "(np.zeros(3), {}, {})",
    "a result whose second is a list": "(np.zeros(3), ['v1'])",
    "not a number": "[float('nan'), 0, 0]",
    "infinite": "[0, float('inf'), 0]",
}

RAISES = {
    "an exception": "raise RuntimeError('enough')",
    "exit": "raise SystemExit",
    "exit zero": "raise SystemExit(0)",
    "exit with a text": "import sys; sys.exit('bye')",
    "a keyboard interrupt of its own": "raise KeyboardInterrupt('mine')",
    "generator exit": "raise GeneratorExit",
    "a base exception of its own": "raise Own('base')",
    "cancelled": "raise asyncio.CancelledError",
    "a group": "raise BaseExceptionGroup('g', [Own(), KeyboardInterrupt()])",
    "a surrogate": "raise ValueError(chr(0xdc80) + ' and ' + chr(0xd800))",
    "an escape": "raise ValueError(chr(27) + ']0;title' + chr(7))",
    "lines": "raise ValueError('one' + chr(10) + 'two' + chr(13) + 'three' + chr(0x2028))",
    "a null": "raise ValueError(chr(0))",
    "a long text": "raise ValueError('x' * 10**7)",
    "a text that raises": "raise TextRaises",
    "a text that is none": "raise TextIsNone",
    "a hostile metaclass": "raise MetaError('meta')",
    "hostile notes": "raise Noted('notes')",
    "a note": "e = ValueError('noted'); e.add_note(chr(0xd800)); raise e",
    "recursion": "return step(t, x1_c, x1, x2)",
    "memory": "raise MemoryError",
    "a stop": "raise StopIteration",
    "a syntax error": "exec('def (')",
    "a syntax error with odd fields": "e = SyntaxError('odd'); e.filename = 5; e.lineno = 'x'; e.text = 7; raise e",
    "an input error": "from uavftc.errors import InputError as E; raise E(5, found=[], expected=None, remedy={})",
    "a failed step": "from uavftc.core.stage import StepFailed; raise StepFailed(chr(0xd800))",
    "an assertion": "assert False, Tensor()",
    "a missing file": "open('/nonexistent/file')",
    "a missing module": "import nowhere_to_be_found",
    "an unraisable": "raise 5",
    "a warning": "warnings.simplefilter('error'); warnings.warn('as an error'); return np.zeros(3)",
    "numpy that raises": "np.seterr(all='raise'); return np.zeros(3) / 0",
}

TELEMETRY = {
    "a huge number": "{'v1': [10**400, 0, 0]}",
    "array raises": "{'v1': raising('__array__')()}",
    "a tensor that requires grad": "{'d1_hat': Tensor()}",
    "iter raises": "{'f_hat': raising('__iter__', base=list)([0, 0, 0])}",
    "oversized": "{'v1': np.zeros(10**7)}",
    "oversized list": "{'v1': [0.0] * 10**6}",
    "a number": "{'v1': 5}",
    "two": "{'v1': [1, 2]}",
    "complex": "{'v1': np.zeros(3) * 1j}",
    "texts": "{'v1': ['1', '2', '3']}",
    "nothing": "{'v1': None}",
    "a map": "{'v1': {0: 1, 1: 1, 2: 1}}",
    "truth values": "{'v1': [True, True, True]}",
    "endless": "{'v1': Endless()}",
    "repr raises": "{'v1': raising('__repr__')()}",
    "a key that raises": "{Key('v1'): 1}",
    "a map that raises, with two": "Dict(v1=[1, 2])",
}

MODULES = {
    "nothing": "",
    "syntax": "def create(:",
    "null": "x = '\\x00'\n\x00",
    "raises": "raise RuntimeError('top')",
    "raises a base exception": "class Own(BaseException): pass\nraise Own('top')",
    "interrupts itself": "raise KeyboardInterrupt",
    "exits": "import sys; sys.exit(0)",
    "raises a surrogate": "raise ValueError(chr(0xd800))",
    "raises no text": "class E(Exception):\n    def __str__(self): raise RuntimeError\nraise E",
    "imports nothing there": "import nowhere_to_be_found",
    "a missing module of odd name": "raise ModuleNotFoundError(name=5)",
    "opens nothing there": "open('/nonexistent/file')",
    "an odd system error": "raise OSError(5, chr(0xd800))",
    "getattr raises": "def __getattr__(name): raise RuntimeError('no ' + name)",
    "getattr raises a base exception": "def __getattr__(name): raise SystemExit(0)",
    "getattr interrupts": "def __getattr__(name): raise KeyboardInterrupt",
    "getattr returns anything": "def __getattr__(name): return 5",
    "another module": (
        "import sys\nclass M:\n    def __getattr__(s, n): raise RuntimeError(n)\nsys.modules[__name__] = M()"
    ),
    "not in the modules": "import sys\ndel sys.modules[__name__]\nraise ValueError('gone')",
    "no search path": "import sys\nsys.path = None",
    "a file that is none": "__file__ = type('F', (), {'__str__': lambda s: 1 / 0})()\ncreate = 5",
    "recursion": "def f(): f()\nf()",
    "create is a number": "create = 5",
    "create is a class that raises": "class create:\n    def __init__(self, d, h, o): raise RuntimeError('made')",
    "create has a signature that raises": (
        "class C:\n    @property\n    def __signature__(s): raise RuntimeError\n"
        "    def __call__(s, *a): raise RuntimeError('called')\ncreate = C()"
    ),
    "create has a default whose repr raises": (
        "class R:\n    def __repr__(s): raise RuntimeError\ndef create(d, h, o, more, other=R()): pass"
    ),
    "create takes nothing": "def create(): pass",
    "create returns nothing": "def create(d, h, o): pass",
    "create returns what raises": (
        "class R:\n    def __repr__(s): raise RuntimeError\ndef create(d, h, o): return R()"
    ),
    "create returns hostile class": (
        "class L:\n    @property\n    def __class__(s): raise RuntimeError('class')\ndef create(d, h, o): return L()"
    ),
    "create interrupts": "def create(d, h, o): raise KeyboardInterrupt",
    "create exits": "def create(d, h, o): raise SystemExit(0)",
    "create returns three": "def create(d, h, o): return (lambda t, a, b, c: (0, 0, 0)), {}, 1",
    "create returns a tuple of nothing": "def create(d, h, o): return ()",
    "signals are no map": "def create(d, h, o): return (lambda t, a, b, c: (0, 0, 0)), [('w', '1')]",
    "a signal whose unit raises": (
        "class R:\n    def __repr__(s): raise RuntimeError\n    __eq__ = __hash__ = __repr__\n"
        "def create(d, h, o): return (lambda t, a, b, c: (0, 0, 0)), {'w': R(), 'v': (R(), R())}"
    ),
    "a signal whose name raises": (
        "class R(str):\n    def __repr__(s): raise RuntimeError\n"
        "def create(d, h, o): return (lambda t, a, b, c: (0, 0, 0)), {R('w'): '1'}"
    ),
    "a signal of endless labels": (
        "import itertools\ndef create(d, h, o): return (lambda t, a, b, c: (0, 0, 0)), {'w': ('1', itertools.count())}"
    ),
    "a signal of too many numbers": "def create(d, h, o): return (lambda t, a, b, c: (0, 0, 0)), {'w': ('1', 10**18)}",
    "a signal whose name steers a terminal": (
        "def create(d, h, o): return (lambda t, a, b, c: (0, 0, 0)), {chr(27) + '[2J': '1'}"
    ),
    "a step that asks for what there is not": "def create(d, h, o): return lambda t, a, b, c, *, banana: (0, 0, 0)",
    "a step whose signature raises, and that takes more": (
        "class C:\n    @property\n    def __signature__(s): raise SystemExit(0)\n"
        "    def __call__(s, t, a, b, c, positions): return 0, 0, 0\ndef create(d, h, o): return C()"
    ),
    "create is a generator": "def create(d, h, o):\n    yield 1",
    "create is a coroutine": "import warnings\nwarnings.simplefilter('ignore')\nasync def create(d, h, o): pass",
    "create changes its design": "def create(d, h, o):\n    d.B = 5\n    return lambda t, a, b, c: [d.B @ a] * 3",
    "both forms": (
        "from uavftc.core.stage import Stage, law\n@law\ndef s(p, s, row): pass\nstage = Stage(s)\ncreate = s"
    ),
    "the stage is hostile": "class S:\n    @property\n    def __class__(s): raise RuntimeError('c')\nstage = S()",
    "PARAMS only": "PARAMS = 5",
    "a dtype that raises": "class D:\n    def __getattr__(s, n): raise RuntimeError(n)\nPARAMS = STATE = stage = D()",
}

COMPILED = """
import numpy as np
from uavftc.core.stage import RAW, Stage, law, params_of
PARAMS = np.dtype([("gain", "f8")])
STATE = np.dtype([("n", "f8")])
def params(design, h, options):
    return params_of(PARAMS, gain=0.1)
@law
def step(p, s, row):
    s.n += 1.0
    for i in range(3):
        row.v2[i] = p.gain * (row.x1_c[i] - row.x1_meas[i])
    if row.t >= WHEN:
        ACTION
stage = Stage(step, PARAMS, STATE)
"""

LAWS = {
    "sets a status": "row.status = 7",
    "sets the status of a lost vehicle": "row.status = 2.0",
    "sets a negative status": "row.status = -1.0",
    "sets the status of a law that raised": "row.status = -250.0",
    "sets a status that is no number": "row.status = np.nan",
    "raises": "raise ValueError('compiled')",
    "raises at once": "raise KeyError",
    "fails an assertion": "assert row.t < 0.0",
    "commands no number": "row.v2[0] = np.nan",
    "commands infinity": "row.v2[2] = np.inf",
}

COMPILED_MODULES = {
    "params raises": ("    return params_of(PARAMS, gain=0.1)", "    raise RuntimeError('params')"),
    "params exits": ("    return params_of(PARAMS, gain=0.1)", "    raise SystemExit(0)"),
    "params of nothing": ("    return params_of(PARAMS, gain=0.1)", "    return None"),
    "params of two": ("    return params_of(PARAMS, gain=0.1)", "    return np.zeros(2, PARAMS)"),
    "params of another field": ("gain=0.1)", "again=0.1)"),
    "state of a hostile class": ("@law", "def state(d, h, o):\n    return type('S', (np.ndarray,), {})((1,))\n@law"),
    "a state larger than any memory": ('[("n", "f8")]', '[("n", "f8"), ("m", "f8", (2**27, 2))]'),
    "an unknown field": ("s.n += 1.0", "s.m += 1.0"),
    "an unknown name": ("s.n += 1.0", "nowhere_defined(s)"),
    "what numba has not": ("s.n += 1.0", "with open('x') as f: pass"),
    "three arguments too many": ("def step(p, s, row)", "def step(p, s, row, a, b, c)"),
    "writes the time": ("s.n += 1.0", "row.t = -1.0"),
    "writes the vehicle": ("s.n += 1.0", "row.x1[0] = 1.0"),
    "an object in STATE": ('[("n", "f8")]', '[("n", "O")]'),
    "a stage of another STATE": ("stage = Stage(step, PARAMS, STATE)", "stage = Stage(step, PARAMS)"),
    "a stage that is a function": ("stage = Stage(step, PARAMS, STATE)", "stage = step"),
}

SLOW = {
    "sleeps": "time.sleep(3600)",
    "spins": "\n            while True: pass",
    "catches everything once": (
        "\n            try: time.sleep(3600)\n            except BaseException: pass\n            time.sleep(3600)"
    ),
    "turns it into another": (
        "\n            try: time.sleep(3600)\n            except BaseException: raise ValueError('turned')"
    ),
    "blocks in its result": "return type('A', (), {'__array__': lambda s, *a, **k: time.sleep(3600)})()",
    "blocks in a repr": "return type('A', (), {'__repr__': lambda s: time.sleep(3600)})()",
}


def stepping(when: float, body: str) -> str:
    """Return a controller whose step does `body` from a time on, s, and commands zero before."""
    lines = f"if t > {when}:\n    {body}\nreturn np.zeros(3)"
    return (
        HEAD
        + "\ndef create(design, h, options):\n    def step(t, x1_c, x1, x2):\n"
        + textwrap.indent(lines, " " * 8)
        + "\n    return step\n"
    )


def cases() -> Iterator[Case]:
    """Yield all cases."""
    times = ((TRIAL, -1.0, "at the trial"), (FLIGHT, 0.5, "in flight"))
    for code, when, at in times:
        # what is reported is the step, and not a mistake of this file
        named = ("mine.py, step(",) if code == TRIAL else ("the controller failed: ",)
        for name, value in RETURNS.items():
            finite = name not in ("not a number", "infinite")  # the envelope's watch sees these in flight
            words = named if finite or code == TRIAL else ("a state or command is not a number",)
            yield Case(f"returns, {name}, {at}", stepping(when, f"return {value}"), code, words)
        for name, body in RAISES.items():
            yield Case(f"raises, {name}, {at}", stepping(when, body), code, named)
        for name, value in TELEMETRY.items():
            yield Case(f"telemetry, {name}, {at}", stepping(when, f"return np.zeros(3), {value}"), code, named)
        for name, body in SLOW.items():
            limit = ("--set", "controller.timeout_s=0.5")
            yield Case(f"slow, {name}, {at}", stepping(when, body), code, (*named, "controller.timeout_s"), limit)
        for name, action in LAWS.items():
            source = COMPILED.replace("WHEN", "-1.0" if code == TRIAL else "0.503").replace("ACTION", action)
            yield Case(f"compiled, {name}, {at}", source, code)
    for name, source in MODULES.items():
        yield Case(f"module, {name}", source, TRIAL)
    for name, (old, new) in COMPILED_MODULES.items():
        source = COMPILED.replace(old, new).replace("WHEN", "1e9").replace("ACTION", "pass")
        yield Case(f"compiled module, {name}", source, TRIAL)


def fly(case: Case, folder: Path) -> tuple[int, bytes, bytes]:
    """Fly a case with the command, in a fork of this process; return its exit code, stdout and stderr."""
    folder.mkdir()
    source = case.source.encode("utf-8", "surrogatepass")
    (folder / "mine.py").write_bytes(source)
    command = ["uavftc-fly", "scenario3", "--plant", "analytic", "--controller", "mine.py", "--no-plots"]
    command += ["--set", "duration_s=1", "--out", "out", *case.options]
    child = os.fork()
    if child == 0:
        try:
            atexit._clear()  # what the parent has to do at its end is not the child's
            os.chdir(folder)
            for number, name in ((1, "stdout"), (2, "stderr")):
                os.dup2(os.open(folder / name, os.O_WRONLY | os.O_CREAT), number)
            sys.stdout, sys.stderr = (
                open(number, "w", encoding="utf-8", errors=errors, closefd=False)  # noqa: SIM115
                for number, errors in ((1, "strict"), (2, "backslashreplace"))
            )
            sys.argv = command
            from uavftc.cli.app import main_fly

            main_fly()
        except BaseException:
            traceback.print_exc()
        finally:
            sys.stderr.flush()
            os._exit(1)
    end = time.monotonic() + DEADLINE_S
    while (done := os.waitpid(child, os.WNOHANG))[0] == 0:
        if time.monotonic() > end:
            os.kill(child, 9)
            os.waitpid(child, 0)
            return -9, (folder / "stdout").read_bytes(), (folder / "stderr").read_bytes()
        time.sleep(0.005)
    code = os.waitstatus_to_exitcode(done[1])
    return code, (folder / "stdout").read_bytes(), (folder / "stderr").read_bytes()


def defects(case: Case, folder: Path) -> list[str]:
    """Fly a case and return what is not as promised."""
    code, stdout, stderr = fly(case, folder)
    found = [] if code == case.code else [f"exit code {code}, promised {case.code}"]
    if b"Traceback" in stdout + stderr:
        found.append("a traceback")
    if b"\x1b" in stdout + stderr:
        found.append("a raw escape")
    written = sorted(path.name for path in folder.iterdir() if path.name not in ("mine.py", "stdout", "stderr"))
    message = stderr.decode("utf-8", "replace")
    if case.code == TRIAL:
        first, *rest = message.splitlines() or [""]
        heads = tuple(f"  {head:10}" for head in ("found:", "expected:", "remedy:"))
        if not first.startswith("error: ") or [line[:12] for line in rest] != list(heads):
            found.append("not one message")
        found += [f"written: {', '.join(written)}"] * bool(written)
    else:
        found += _defects_of_a_flight(folder)
        if not found:
            message = json.loads((folder / "out" / "summary.json").read_text(encoding="utf-8"))["ended_because"]
    found += [f"no word of {word}" for word in case.words if word not in message]
    return [f"{what}\n{textwrap.indent(message[-1500:], '    ')}" for what in found]


def _defects_of_a_flight(folder: Path) -> list[str]:
    import pyarrow.parquet

    try:
        summary = json.loads((folder / "out" / "summary.json").read_text(encoding="utf-8"))
        time_s = pyarrow.parquet.read_table(folder / "out" / "history.parquet")["time_s"].to_pylist()
    except (OSError, ValueError) as error:
        return [f"no flight: {error}"]
    found = [] if summary["completed"] is False else ["completed"]
    reason = summary["ended_because"] or ""
    if not reason.isprintable() or "at t = 0.505 s" not in reason:
        found.append(f"ended because {reason!r}")
    if time_s != [k / 200 for k in range(ROWS)]:
        found.append(f"{len(time_s)} rows up to {time_s[-1:]}")
    return found


def run_all(folder: Path, chosen: str = "") -> tuple[int, list[str]]:
    """Fly all cases whose name contains `chosen`; return how many, and the defects."""
    import uavftc.flight.build
    import uavftc.jobs.fly
    import uavftc.report.table
    from uavftc.flight.fly import fly_to_memory
    from uavftc.scenario.load import load_scenario

    scenario = load_scenario("scenario3", plant="analytic", controller="lqi", overrides=["duration_s=0.1"])
    fly_to_memory(uavftc.flight.build.build_flight(scenario))  # compiled once, for all that are forked
    n, found = 0, []
    for n, case in enumerate((case for case in cases() if chosen in case.name), start=1):
        found += [f"{case.name}: {defect}" for defect in defects(case, folder / f"{n:03d}")]
    return n, found


def report(n: int, found: list[str]) -> str:
    """Return the counts in one line."""
    return f"{n} hostile controllers, {len(found)} defects"


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as temporary:
        count, failures = run_all(Path(temporary).resolve(), *sys.argv[1:2])
    print(*failures, report(count, failures), sep="\n")
    sys.exit(bool(failures))
