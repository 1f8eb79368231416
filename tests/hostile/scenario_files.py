"""A seeded generator of hostile scenario files and of hostile values for --set.

Each file begins as a good one, the shipped scenarios and their full texts with every default, and is then spoiled in
one way or in several: the families below. The same seed gives the same files. A family need not make a bad file:
what a spoiled file is, the loader must tell.
"""

from __future__ import annotations

import copy
import json
import random
from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

from uavftc.config.document import parse
from uavftc.config.shipped import scenario_dir, scenario_names
from uavftc.scenario.load import load_scenario, scenario_text


class Raw(str):
    """A value written into the file as it stands."""

    __slots__ = ()


class Case(NamedTuple):
    """One hostile file."""

    name: str
    """Family and number."""
    content: bytes
    """Of the file."""
    overrides: tuple[str, ...] = ()
    """For --set."""


Data = dict[str, Any]
Path = tuple[str | int, ...]

SCALARS = [
    *map(Raw, (
        "", "null", "~", "Null", "true", "False", "yes", "on", "NO", ".inf", "-.inf", ".nan", "-.nan", "+.inf", "inf",
        "nan", "NaN", "1e308", "1e309", "-1e309", "1e-308", "5e-324", "1e-400", "-0.0", "0", "-1", "+1", "1.", ".5",
        "1_000", "012", "0o17", "0o8", "0b11", "0xFF", "0xZZ", "0x" + "F" * 200, "1:30", "2026-01-01", "1,5", "1 000",
        "1e", "e1", "--1", "1d3", "1f", "9" * 30, "9" * 399, "9" * 401, "9" * 5000, "-" + "9" * 400, "1." + "3" * 2000,
        "0." + "0" * 400 + "1", "9223372036854775807", "9223372036854775808", "18446744073709551616", "[]", "{}",
        "[1]", "[1, 2]", "[1, 2, 3]", "[1, 2, 3, 4]", "[null, null, null]", "[[1, 2, 3]]", "[a, b, c]", "{a: 1}",
        "{kind: l1}", "[{}]", "[[]]", "[[[]]]", "'5'", '"5.0"', "'null'", "5 deg", "5deg", "0.1 rad", "10 %", "$HOME",
        "~/x", "${PWD}", "{{ x }}", "%s", "%(x)s", "{0}", "!!float 5", "!!python/object:os.system x", "!x 1", "&a 1",
        "*a", "<<", "@x", "`x`", "|", ">", "? x", "- 1", "# 1", "'", '"', "[", "{", "]", "}", ":", "a: b", "- - -",
        "---", "...", "%YAML 1.1", "\t5", "=", "!", "&", "*", "1#2", "5 # a comment", "5;", "0x1p3", "1e+5", "1E5",
        "1e+-5", "١٢٣", "½", "５", "∞", "−5",
    )),
    "", " ", "\n", "a\nb", "\t", "\x00", "\x07", "\x1b[31mred\x1b[0m", "\x1b]0;title\x07", "\x7f", "\x85", "\u200b",
    "\u202egnp.exe", "\u2028", "\u2029", "\ufeff", "\ufffe", "\ue000", "🛩", "e\u0301" * 50, "ﷺ" * 30, "\U0010ffff",
    "x" * 5000, "../../../etc/passwd", "/dev/null", "/dev/zero", "CON", "C:\\x", "a/b", "a\\b", "..", ".", "-x", "--",
    "jsbsim:", "jsbsim:../x", "jsbsim:c172p/../737", "file:///x", "http://example.com", "'; drop", "a" * 101,
    "\\ud800", "&amp;", "<b>", "%00", "pid", "lqi", "ndi-l1", "ndi", "l1", "mrac", "nndo-ndi", "none", "off", "True",
    "analytic", "jsbsim", "hale", "JSBSIM", "Hale", "hale ", "os", "sys", "json:loads", "os.path", "numpy.random",
    "__main__", "no.such.module", "x.py", "./x.py", "rudder", "Rudder", "rudders", "elevator", "stuck", "loss", "gust",
    "wind", "turbulence", "angular-acceleration", "attitude-rate",
]  # fmt: skip
EXPRESSIONS = [
    "t", "-t", "+-+-t", "1/0", "0/0", "t/t", "1/t", "1/(t-1)", "sqrt(-1)", "sqrt(t-1)", "tan(pi/2)", "exp(1000)",
    "exp(exp(exp(t)))", "0*exp(1e9*t)", "9**9**9**9", "t**t", "(-1)**t", "2**-t", "min(t)", "min()", "max(1)", "sin()",
    "sin(1,2)", "sin(t", "sin t", "sin", "pi", "pi()", "e", "T", "time", "t t", "2t", "2 t", "2(t)", "t.real", "t[0]",
    "t if t else 1", "lambda: 1", "[t]", "(t,)", "t;t", "t==1", "t<1", "not t", "t and 1", "t%2", "t//2", "t@t", "t^2",
    "~t", "t<<1", "t:=1", "1e999", "1e-999", "1_0", "0x10", "1j", "1.2.3", "1..2", "..", "1e", "1e+", "'t'", '"t"',
    "f'{t}'", "__import__('os')", "eval('1')", "abs", "abs(abs)", "sin(sin)", "sin(x=1)", "sin(*t)", "min(*[1,2])",
    "(" * 90 + "t" + ")" * 90, "(" * 300 + "t" + ")" * 300, "-" * 500 + "t", "sin(" * 90 + "t" + ")" * 90, "+".join(
        ["t"] * 400), "*".join(["t"] * 400), "t" * 999, "1" * 999, "1" * 1001, "9" * 400, "t+" * 333, "sin(t)**2 + c",
    "ｓｉｎ(t)", "ｔ", "π", "t²", "t×2", "t−1", "١", "t\u200b", "t\x00", "t\n+1", "t\r\n", "t\t+\t1", "t # x", "t\\\n1",
    "\u202et", "sin(t)\x1b[31m", "min(1,2,3,t,5)", "min(" + ",".join(["t"] * 300) + ")", "abs(-1e308)*10", "1e308*10*t",
    "-0.0", "0", "  5  ", " ", "", "step(t)", "random()", "heaviside(t)", "where(t>1,1,0)", "0.1 + 0.5*sin(t)",
    "3*cos(0.1*t)", "max(0, t-5)", "tanh(t)*5", "5*min(1, max(0, 1e9*(t-1)))", "1e9*t", "1e-9*t", "5 deg", "5°",
]  # fmt: skip
NAMES = [
    "phi", "phi_rad", "Phi_deg", "phi-deg", "phi deg", "phi_deg ", " phi_deg", "phi_deg\x00", "\x1b[31m", "\u202e", "",
    "kind", "Kind", "surface", "name", "null", "~", "0", "1", "-1", "1.5", "true", "__class__", "__init__",
    "model_dump", "model_fields", "remedies", "options", "constructor", "$ref", "<<", "*", "a.b", "a[0]", "a" * 300,
    "ключ", "鍵",
    "🛩", "k\nk", "k\tk", "\u2028", "\ue000", "e\u0301", "ﬁ", "controller.outer", "faults[0]", "%s", "{x}",
]  # fmt: skip
UNITS = ["deg", "rad", "degps", "radps", "degps2", "radps2", "mps", "kts", "ft", "m", "km", "s", "ms", "min", "hz",
         "khz", "hertz", "percent", "", "DEG", "si"]  # fmt: skip


def bases() -> list[Data]:
    """Return the documents that are spoiled: the shipped files, and what they are with every default."""
    found = []
    for name in scenario_names():
        text = (scenario_dir() / f"{name}.yaml").read_text(encoding="utf-8")
        found += [parse(t, name)[0] for t in (text, scenario_text(load_scenario(name)))]
    custom = scenario_text(load_scenario("scenario1", controller="pid"))
    return [*found, parse(custom, "pid")[0]]


def render(value: Any) -> str:
    """Return the document as YAML: top-level keys on lines of their own, the rest in flow style."""
    if not isinstance(value, dict):
        return _flow(value) + "\n"
    lines = []
    for key, item in value.items():
        if isinstance(item, list) and item and all(isinstance(entry, dict) for entry in item):
            lines += [f"{_key(key)}:", *(f"  - {_flow(entry)}" for entry in item)]
        elif isinstance(item, dict) and item:
            lines += [f"{_key(key)}:", *(f"  {_key(name)}: {_flow(v)}" for name, v in item.items())]
        else:
            lines.append(f"{_key(key)}: {_flow(item)}")
    return "\n".join(lines) + "\n"


def _key(key: Any) -> str:
    return str(key) if isinstance(key, Raw) else json.dumps(str(key))


def _flow(value: Any) -> str:
    if isinstance(value, Raw):
        return str(value)
    if isinstance(value, dict):
        return "{" + ", ".join(f"{_key(k)}: {_flow(v)}" for k, v in value.items()) + "}"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(_flow(v) for v in value) + "]"
    return json.dumps(value)


def paths(value: Any, here: Path = ()) -> Iterator[Path]:
    """Yield the path of every value below a document, sections and lists included."""
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, item in items:
        yield (*here, key)
        yield from paths(item, (*here, key))


def get(data: Any, path: Path) -> Any:
    """Return what stands at a path."""
    for part in path:
        data = data[part]
    return data


def put(data: Any, path: Path, value: Any) -> None:
    """Set what stands at a path."""
    get(data, path[:-1])[path[-1]] = value


def leaves(data: Data) -> list[Path]:
    """Return the paths of what is neither a section nor a list of them."""
    return [p for p in paths(data) if not isinstance(get(data, p), dict | list)]


# --- the families: each spoils a document in place ------------------------------------------------------------------


def scalar(rng: random.Random, data: Data) -> None:
    """Any value replaced by any other."""
    put(data, rng.choice(list(paths(data))), rng.choice(SCALARS))


def expression(rng: random.Random, data: Data) -> None:
    """A signal replaced by an expression, good or bad."""
    signals = [p for p in leaves(data) if str(p[-1]).endswith(("_deg", "_degps2", "_mps", "effectiveness"))]
    put(data, rng.choice(signals or leaves(data)), rng.choice(EXPRESSIONS))


def magnitude(rng: random.Random, data: Data) -> None:
    """A number of any size and sign."""
    numbers = [p for p in leaves(data) if isinstance(get(data, p), int | float) or get(data, p) is None]
    value = rng.choice((1, -1)) * 10.0 ** rng.uniform(-320, 308) if rng.random() < 0.5 else rng.uniform(-1e4, 1e4)
    put(data, rng.choice(numbers), rng.choice((value, int(value) if abs(value) < 1e300 else value)))


def structure(rng: random.Random, data: Data) -> None:
    """A section moved, wrapped, emptied, doubled, renamed or taken for something else."""
    path = rng.choice(list(paths(data)))
    value = copy.deepcopy(get(data, path))
    match rng.randrange(8):
        case 0:
            put(data, path, [value])
        case 1:
            put(data, path, {rng.choice(NAMES): value})
        case 2:
            del get(data, path[:-1])[path[-1]]
        case 3:
            other = rng.choice([p for p in paths(data) if isinstance(get(data, p), dict)] or [()])
            get(data, other)[str(path[-1])] = value
        case 4:
            holder = get(data, path[:-1])
            if isinstance(holder, dict):
                holder[rng.choice(NAMES)] = holder.pop(path[-1])
            else:
                holder.append(value)
        case 5:
            data[str(path[-1])] = value
        case 6:
            put(data, path, copy.deepcopy(get(data, rng.choice(list(paths(data))))))
        case _:
            holder = get(data, path[:-1])
            if isinstance(holder, dict):
                holder[Raw(json.dumps(path[-1]) + " ")] = value  # the key a second time


def unit(rng: random.Random, data: Data) -> None:
    """A key with another unit."""
    with_unit = [p for p in paths(data) if isinstance(p[-1], str) and "_" in p[-1]]
    path = rng.choice(with_unit)
    holder, old = get(data, path[:-1]), path[-1]
    new = f"{str(old).rsplit('_', 1)[0]}_{rng.choice(UNITS)}".rstrip("_")
    holder[new] = holder.pop(old) if rng.random() < 0.7 else holder[old]


def name(rng: random.Random, data: Data) -> None:
    """A key nobody knows."""
    holders = [p for p in paths(data) if isinstance(get(data, p), dict)]
    get(data, rng.choice([*holders, ()]))[rng.choice(NAMES)] = rng.choice(SCALARS)


def nulls(rng: random.Random, data: Data) -> None:
    """Nothing, in any number of places."""
    share = rng.random()
    for path in list(paths(data)):
        if rng.random() < share:
            try:
                put(data, path, None)
            except (KeyError, TypeError, IndexError):
                continue  # below what is null already


def lists(rng: random.Random, data: Data) -> None:
    """Lists and matrices of a wrong shape."""
    target = rng.choice([p for p in paths(data) if p[0] in ("controller", "sensors", "faults", "disturbances")])
    n, m = rng.choice((0, 1, 2, 3, 4, 50)), rng.choice((0, 1, 2, 3, 4, 50))
    filler = rng.choice((0, 1.0, None, "t", True, {}, [], 1e308, -1))
    put(data, target, rng.choice(([filler] * n, [[filler] * m] * n, [[filler] * (3 + i % 2) for i in range(n)])))


def matrix(rng: random.Random, data: Data) -> None:
    """Matrices that are singular, unstable, asymmetric or huge."""
    scale = 10.0 ** rng.uniform(-200, 200)
    kind = rng.choice(("zero", "random", "singular", "skew"))
    rows = [[rng.gauss(0, scale) if kind == "random" else 0.0 for _ in range(3)] for _ in range(3)]
    if kind == "singular":
        rows = [[scale, scale, scale]] * 3
    if kind == "skew":
        rows = [[0.0, scale, 0.0], [-scale, 0.0, 0.0], [0.0, 0.0, -scale]]
    where = data.setdefault("controller", {})
    inner = where.setdefault("inner", {}) if isinstance(where, dict) else {}
    if isinstance(inner, dict):
        inner[rng.choice(("A_m", "B_m", "K_1", "K_0", "Q", "P"))] = rows


def windows(rng: random.Random, data: Data) -> None:
    """Faults and disturbances on windows that overlap, run backwards, are empty or lie outside the flight."""
    times = (0, 0.0, 1e-9, 5, 8, 8.0, 12, 19.995, 20, 20.0001, 1e9, -1, None, 1e308, 5e-324)
    entries = []
    for _ in range(rng.choice((1, 2, 3, 8, 40))):
        entry: Data = {"surface": rng.choice(("aileron", "elevator", "rudder", "rudder", "flap", None, 3))}
        entry |= {k: rng.choice(times) for k in ("start_s", "end_s") if rng.random() < 0.8}
        entry |= {"effectiveness": rng.choice((0, 1, 0.5, -1, 2, "0.2*t", "t - 5"))} if rng.random() < 0.7 else {}
        entry |= {"bias_deg": rng.choice((0, 1, "sin(t)", "1/(t-10)", 1e6))} if rng.random() < 0.4 else {}
        entry |= {"kind": rng.choice(("effectiveness", "stuck", "float", None, 1))} if rng.random() < 0.2 else {}
        entries.append(entry)
    data["faults"] = entries
    if rng.random() < 0.3:
        data["disturbances"] = [
            {"kind": rng.choice(("angular-acceleration", "attitude-rate", "gust", "wind", "turbulence", "x")),
             **{k: rng.choice(times) for k in ("start_s", "end_s")},
             rng.choice(("p_degps2", "phi_degps", "north_mps", "w_mps")): rng.choice(EXPRESSIONS)}
            for _ in range(rng.choice((1, 2, 5)))
        ]  # fmt: skip


def limits(rng: random.Random, data: Data) -> None:
    """Limits of the surfaces: one for all, one each, crossed, of the wrong sign, null, of the wrong surface."""

    def value() -> Any:
        return rng.choice((-0.05, 0.1, 0, -0.0, 1e308, 5e-324, -1e-300, None, "x", [1, 2, 3], [None] * 3, True, 0.05))

    surfaces = {
        s: rng.choice(({"min_rad": value(), "max_rad": value()}, [value(), value()], value()))
        for s in rng.sample(("aileron", "elevator", "rudder", "flap", "throttle"), rng.randrange(1, 5))
    }
    lists = {k: [value() for _ in range(rng.choice((1, 2, 3, 4)))] for k in ("min_rad", "max_rad")}
    data["saturation"] = rng.choice((surfaces, lists, {"min_rad": value(), "max_rad": value()}, {"max_rad": value()}))


def timing(rng: random.Random, data: Data) -> None:
    """Duration and delay that do not go together."""
    data["duration_s"] = rng.choice((0, 1e-9, 0.004, 0.005, 0.0125, 1, 20.001, 19.999999999999, 1e5, 1e6, 1e300, "20"))
    controller = data.setdefault("controller", {})
    if isinstance(controller, dict):
        controller["delay_s"] = rng.choice((0, 1e-12, 0.001, 0.0137, 5, 19.9, 20, 1e6, 1e308, -0.001, None, "0.01"))


SPOILERS: tuple[tuple[Callable[[random.Random, Data], None], int], ...] = (
    (scalar, 720), (expression, 320), (magnitude, 320), (structure, 320), (unit, 160), (name, 160), (nulls, 120),
    (lists, 120), (matrix, 80), (windows, 220), (limits, 140), (timing, 60),
)  # fmt: skip


def _text(rng: random.Random, text: str) -> bytes:
    """Spoil the text of a file: its characters, its lines, its encoding, its YAML."""
    at = rng.randrange(len(text))
    before = text.split("\n")
    lines = list(before)
    row = rng.randrange(len(lines))
    match rng.randrange(16):
        case 0:
            text = text[:at] + chr(rng.randrange(0, 0x250)) + text[at:]
        case 1:
            text = text[:at] + text[at + rng.randrange(1, 30) :]
        case 2:
            text = text[:at]
        case 3:
            lines[row] = (
                rng.choice(("\t", " ", "   ", "- ", "? ", ": ", "# ", "--- ", "&a ", "*a ", "!t ")) + lines[row]
            )
        case 4:
            lines.insert(
                row, rng.choice(("---", "...", "%YAML 9.9", "<<: *x", "a: &a [*a]", "{", "]", "'", "\x00", "="))
            )
        case 5:
            lines[row : row + 1] = [lines[row]] * rng.choice((2, 3, 100))
        case 6:
            rng.shuffle(lines)
        case 7:
            return text.encode(rng.choice(("utf-16", "utf-32", "utf-16-le", "utf-8-sig", "cp037")))
        case 8:
            raw = bytearray(text.encode())
            for _ in range(rng.choice((1, 1, 5, 50))):
                raw[rng.randrange(len(raw))] = rng.randrange(256)
            return bytes(raw)
        case 9:
            return (text * rng.choice((2, 50))).encode()
        case 10:
            return text.replace("\n", rng.choice(("\r\n", "\r", "\u2028", "\x85", ""))).encode()
        case 11:
            lines[row] = lines[row].replace(":", rng.choice((" :", "=", "：", "::", ":\t", ":")), 1) + rng.choice(
                (" ", "\\")
            )
        case 12:
            lines[row] = lines[row].replace(" ", "\u00a0", rng.choice((1, 9)))
        case 13:
            text = text.replace("{", rng.choice(("[", "(", "{{", "")), 1)
        case 14:
            depth = rng.choice((10, 49, 51, 200, 2000, 20000))
            opened, closed = rng.choice((("[", "]"), ("{a: ", "}"), ("- ", ""), ("? ", "")))
            text += f"\ndescription: {opened * depth}{closed * depth}\n"
        case _:
            wide, deep = rng.choice(((2, 5), (9, 9), (2, 40), (50, 2)))
            bomb = "x0: &x0 [1]\n" + "".join(
                f"x{i + 1}: &x{i + 1} [{', '.join([f'*x{i}'] * wide)}]\n" for i in range(deep)
            )
            text = rng.choice((bomb + text, text + "options: &o {a: *o}\n", text + "sensors: &s\n  a: *s\n"))
    if lines != before:
        text = "\n".join(lines)
    return text.encode("utf-8", "surrogatepass")


def scenario_cases(seed: int) -> Iterator[Case]:
    """Yield the hostile files, always the same for a seed."""
    good = bases()
    for spoil, count in SPOILERS:
        for i in range(count):
            rng = random.Random(f"{seed} {spoil.__name__} {i}")
            data = copy.deepcopy(rng.choice(good))
            spoil(rng, data)
            yield Case(f"{spoil.__name__} {i}", render(data).encode("utf-8", "surrogatepass"))
    for i in range(180):
        rng = random.Random(f"{seed} several {i}")
        data = copy.deepcopy(rng.choice(good))
        for _ in range(rng.randrange(2, 7)):
            try:
                rng.choice(SPOILERS)[0](rng, data)
            except (KeyError, TypeError, AttributeError, IndexError):
                continue  # what it spoils is gone
        yield Case(f"several {i}", render(data).encode("utf-8", "surrogatepass"))
    for i in range(420):
        rng = random.Random(f"{seed} text {i}")
        source = (scenario_dir() / f"{rng.choice(scenario_names())}.yaml").read_text(encoding="utf-8")
        yield Case(f"text {i}", _text(rng, source))
    for i, content in enumerate((b"", b"\n", b"null", b"[]", b"5", b"a", b"\xff", b"\x00", b"{}", b"---\n---\n", b"#")):
        yield Case(f"whole {i}", content)


OPTION_KEYS = (
    "duration_s", "name", "description", "seed", "plant", "aircraft", "initial.airspeed_mps", "reference.phi_deg",
    "reference", "controller.outer.bandwidth", "controller.outer.kind", "controller.inner.A_m", "controller.kind",
    "controller.options.x", "controller.delay_s", "saturation", "saturation.max_rad", "faults", "faults[0]",
    "faults[0].surface", "faults[4].effectiveness", "faults[99].bias_deg", "disturbances[0].kind",
    "sensors.gyro_bias_degps", "envelope.bank_deg", "no.such.key", "",
)  # fmt: skip
"""27 keys, with 8 values each: 216 options."""
MALFORMED = (
    "", "=", "==", "x", "x=", ".x=1", "x.=1", "x..y=1", "[0]=1", "faults[]=1", "faults[-1].surface=rudder",
    "faults[0=1", "faults[1e3]=1", "faults[9999999999999999999999].x=1", "a b=1", "\x1b[31m=1", "\u202e=1", "name=\x00",
    "ключ=1", "name[0]=x", "seed.x=1", "reference[0]=1", "duration_s.x[0].y=1", "x" * 5000 + "=1", "x.y" * 300 + "=1",
    "seed=" + "9" * 6000, "name=[" + "[" * 3000,
)  # fmt: skip


def option_cases(seed: int) -> Iterator[Case]:
    """Yield 216 options for --set on a good file: 27 keys with 8 values each, one of these the option malformed."""
    good = (scenario_dir() / "scenario3.yaml").read_bytes()
    for i, key in enumerate(OPTION_KEYS):
        rng = random.Random(f"{seed} option {i}")
        values = [*rng.sample(SCALARS, 5), *rng.sample(EXPRESSIONS, 2)]
        for j, value in enumerate(values):
            written = str(value) if isinstance(value, Raw) or rng.random() < 0.5 else json.dumps(value)
            yield Case(f"option {8 * i + j}", good, (f"{key}={written}",))
        yield Case(f"option {8 * i + 7}", good, (MALFORMED[i],))
