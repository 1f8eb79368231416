"""The file of a campaign: a base scenario, what varies in it and how, and by which controllers each case is flown."""

from __future__ import annotations

import difflib
import functools
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, ConfigDict, Field, PrivateAttr, ValidationError, model_validator
from pydantic_core import PydanticCustomError

from uavftc.analysis.metrics import METRICS
from uavftc.config import shipped
from uavftc.config.document import Origin
from uavftc.config.explain import explain
from uavftc.config.values import Model, NonNegative, Number, Positive, Problem, Whole, is_number, refusal
from uavftc.control.custom.module import is_path
from uavftc.errors import InputError, join
from uavftc.scenario.load import find_scenario, load_scenario, plain_data, read_document
from uavftc.scenario.overrides import apply, put
from uavftc.scenario.schema import Scenario

FOLDER = "campaigns"
"""Of the shipped scenarios, where the shipped campaigns are."""
MAX_CASES = 100_000_000
LHS_CASES = 10_000_000  # a Latin hypercube is drawn whole, eight bytes a case and key
SOBOL_KEYS = 21_201  # what the direction numbers of Joe and Kuo reach


def _pair(value: Any) -> Any:
    if not isinstance(value, list | tuple) or len(value) != 2 or not all(map(is_number, value)):
        raise PydanticCustomError("shape", "{expected}", {"expected": "a list of two numbers"})
    return tuple(value)


Pair = Annotated[tuple[Number, Number], BeforeValidator(_pair)]
Values = Annotated[tuple[Any, ...], Field(min_length=1)]


class Vary(Model):
    """What one key takes: exactly one of these."""

    model_config = ConfigDict(frozen=True, extra="forbid", populate_by_name=True)

    uniform: Pair | None = None
    """`[least, greatest]`, each value as likely"""
    normal: Pair | None = None
    """`[mean, standard deviation]`"""
    log_uniform: Pair | None = Field(None, alias="log-uniform")
    """`[least, greatest]`, both above 0, each ratio as likely"""
    integer: Pair | None = None
    """`[least, greatest]`, whole numbers, both included"""
    choice: Values | None = None
    """values of any kind, each as likely"""
    grid: Values | None = None
    """values of any kind: every one is flown with every value of the other grids"""
    list: Values | None = None
    """values of any kind, one after the other, in step with the other lists"""
    nominal: Any = None
    """the value without a fault, from which `falsify` measures distances; left out, that of the base"""

    @property
    def kind(self) -> str:
        """Which of them it is, as the file spells it."""
        return next(name for name in KINDS if getattr(self, name.replace("-", "_")) is not None)

    @property
    def given(self) -> tuple[Any, ...]:
        """What the file says of it."""
        found: tuple[Any, ...] = getattr(self, self.kind.replace("-", "_"))
        return found

    @property
    def enumerated(self) -> bool:
        """Whether it is a grid or a list, and not drawn."""
        return self.kind in ("grid", "list")

    @model_validator(mode="after")
    def _one(self) -> Vary:
        named = [name for name in KINDS if getattr(self, name.replace("-", "_")) is not None]
        if len(named) != 1:
            found = " and ".join(named) or "none of them"
            raise refusal([Problem((), found, f"exactly one of {', '.join(KINDS)}", "keep one, as uniform: [0.3, 1]")])
        if (wrong := _wrong(named[0], self.given)) is not None:
            raise refusal([Problem((named[0],), str(list(self.given)), wrong, "change the two numbers")])
        return self


KINDS = ("uniform", "normal", "log-uniform", "integer", "choice", "grid", "list")


def _wrong(kind: str, given: Sequence[Any]) -> str | None:
    """Return what is expected of a pair of numbers that is wrong, or None."""
    if kind in ("uniform", "log-uniform", "integer") and not given[0] < given[1]:
        return "[least, greatest], the first below the second"
    if kind == "log-uniform" and given[0] <= 0:
        return "two numbers above 0"
    if kind == "normal" and given[1] <= 0:
        return "[mean, standard deviation], the second above 0"
    if kind == "integer" and not all(float(end).is_integer() and abs(end) < 2**53 for end in given):
        return "two whole numbers"
    if kind == "uniform" and not math.isfinite(given[1] - given[0]):
        return "two numbers whose difference is finite"
    return None


class Worst(Model):
    """Histories of the flights with the smallest margins."""

    worst: Annotated[Whole, Field(ge=1, le=10_000)]
    """how many"""


def _histories(value: Any) -> Any:
    if value in ("none", "failures", "all"):
        return value
    if isinstance(value, dict):
        return Worst.model_validate(value)
    expected = "none, failures, all, or worst: 10"
    raise PydanticCustomError("histories", "{expected}", {"expected": expected})


class Campaign(Model):
    """A campaign as its file says it."""

    name: Annotated[str, Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9._-]*$", max_length=100)]
    """names the result folder"""
    description: str = ""
    """free text"""
    base: Annotated[str, Field(min_length=1, max_length=4096)]
    """the scenario: a path that starts at the folder of this file, or the name of a shipped one"""
    seed: Annotated[Whole, Field(ge=0, le=2**63 - 1)] = 0
    """of all that is drawn; case i depends on it and on i alone (with `lhs` on `cases` too)"""
    cases: Annotated[Whole, Field(ge=1, le=MAX_CASES)] | None = None
    """how many; left out, the grid once"""
    design: Literal["random", "sobol", "lhs", "grid"] = "random"
    """how the drawn keys fill their space: independently, by a scrambled Sobol sequence, by a Latin hypercube; `grid`
    draws nothing"""
    vary: dict[str, Vary] = Field(default_factory=dict)
    """what varies: any key of the scenario by its dotted path, and one of `uniform`, `normal`, ..."""
    controllers: Annotated[tuple[str, ...], Field(min_length=1)] | None = None
    """each case is flown by each; left out, that of the base"""
    plants: Annotated[tuple[Literal["jsbsim", "analytic"], ...], Field(min_length=1)] | None = None
    """each case is flown on each"""
    aircraft: Annotated[tuple[str, ...], Field(min_length=1)] | None = None
    """each case is flown with each"""
    success: dict[str, NonNegative] | None = None
    """greatest value of metrics on every controlled axis of a flight that completes; left out, `survived`"""
    histories: Annotated[Literal["none", "failures", "all"] | Worst, BeforeValidator(_histories)] = "none"
    """which flights keep their history: `none`, `failures`, `worst: 10`, `all`"""
    timeout_s: Positive = 300.0
    """wall-clock time of one flight, after which it counts as an error"""

    _origin: Origin = PrivateAttr(default_factory=Origin)
    _folder: Path = PrivateAttr(default_factory=Path.cwd)

    @property
    def origin(self) -> Origin:
        """Where its keys were written."""
        return self._origin

    @property
    def count(self) -> int:
        """How many cases there are."""
        return self.cases if self.cases is not None else self.combinations

    @property
    def combinations(self) -> int:
        """How many combinations of grids and lists there are; 1 without any."""
        grids = math.prod(len(v.given) for v in self.vary.values() if v.kind == "grid")
        return grids * max((len(v.given) for v in self.vary.values() if v.kind == "list"), default=1)

    @model_validator(mode="after")
    def _consistent(self) -> Campaign:
        if found := [*self._about_design(), *self._about_names()]:
            raise refusal(found)
        return self

    def _about_design(self) -> list[Problem]:
        found = []
        drawn = [key for key, vary in self.vary.items() if not vary.enumerated]
        lists = [key for key, vary in self.vary.items() if vary.kind == "list"]
        if self.cases is None and (drawn or not self.vary):
            found.append(Problem(("cases",), "nothing", "the number of cases", "write cases: 1000"))
        if self.design == "grid":
            for key in drawn:
                remedy = "give a grid or a list, or another design"
                found.append(
                    Problem(("vary", key), self.vary[key].kind, "grid or list, because design is grid", remedy)
                )
        elif self.design != "random" and not drawn:
            expected = "a key that is drawn, such as one with uniform"
            found.append(Problem(("design",), self.design, expected, "write design: grid"))
        for key in lists[1:]:
            if len(self.vary[key].given) != len(self.vary[lists[0]].given):
                entries, first = f"{len(self.vary[key].given)} values", len(self.vary[lists[0]].given)
                expected = f"{first}, as vary.{lists[0]} has: lists go in step"
                found.append(Problem(("vary", key, "list"), entries, expected, "make them as long, or use grid"))
        if self.design == "lhs" and (self.cases or 0) > LHS_CASES:
            expected = f"at most {LHS_CASES} with design: lhs, which is drawn whole"
            found.append(Problem(("cases",), str(self.cases), expected, "use sobol or random"))
        if self.design == "sobol" and len(drawn) > SOBOL_KEYS:
            found.append(Problem(("vary",), f"{len(drawn)} drawn keys", f"at most {SOBOL_KEYS}", "use random"))
        return found

    def _about_names(self) -> list[Problem]:
        found = []
        for key in ("controllers", "plants", "aircraft"):
            names = getattr(self, key) or ()
            for i, name in enumerate(names):
                if name in names[:i]:
                    found.append(Problem((key, i), f"{name} a second time", "each once", "remove one"))
        for key in self.vary:
            if key in ("name", "description"):
                found.append(Problem(("vary", key), key, "a key that a flight depends on", "remove it"))
            elif key in ("plant", "aircraft", "controller"):
                several = key if key == "aircraft" else f"{key}s"
                remedy = f"write {several}: [...] next to vary"
                found.append(Problem(("vary", key), key, f"{several}: each case is flown with each", remedy))
        known = [metric.name for metric in METRICS]
        for key in self.success or {}:
            if key not in known:
                near = difflib.get_close_matches(key, known, n=1)
                remedy = f"did you mean {near[0]}?" if near else "choose one of them"
                found.append(Problem(("success", key), f"'{key}'", f"one of {', '.join(known)}", remedy))
        return found

    @functools.cached_property
    def base_file(self) -> Path:
        """The file of the base scenario.

        Raises
        ------
        InputError
            If there is none.
        """
        beside = self._folder / Path(self.base).expanduser()
        try:
            if beside.is_file():
                return beside
        except (OSError, ValueError):
            pass
        try:
            return find_scenario(self.base)
        except InputError as error:
            where = self.origin.where(("base",))
            found = f"'{self.base}': {error.found} (looked in {self._folder})"
            raise InputError(where, found=found, expected=error.expected, remedy=error.remedy) from None

    def scenario(self, *, controller: str | None, plant: str | None, aircraft: str | None) -> Scenario:
        """Return the base with another controller, plant and aircraft; None is the base's.

        Raises
        ------
        InputError
            If there is no such thing, or the base is wrong.
        """
        if controller is not None and is_path(controller) and (self._folder / controller).is_file():
            controller = str((self._folder / controller).resolve())
        if aircraft is not None and (self._folder / aircraft).is_dir():
            aircraft = str((self._folder / aircraft).resolve())
        return load_scenario(self.base_file, controller=controller, plant=plant, aircraft=aircraft)


def load_campaign(source: str | Path, overrides: Sequence[str] = (), set: Mapping[str, Any] | None = None) -> Campaign:
    """Read, change and check the file of a campaign.

    Parameters
    ----------
    source
        A YAML file, or the name of a shipped campaign.
    overrides
        ``key=value`` each, value in YAML.
    set
        Values by dotted key.

    Raises
    ------
    InputError
        If anything is wrong with it; all errors at once.
    """
    path = find_campaign(source)
    document = read_document(path, what="campaign")
    for override in overrides:
        apply(document, override)
    for key, value in (set or {}).items():
        put(document, key, plain_data(value), f"{key} = {value!r}"[:200])
    try:
        campaign = Campaign.model_validate(document.data)
    except ValidationError as error:
        raise join(explain(error, document, Campaign)) from None
    campaign._origin, campaign._folder = Origin(document), path.parent.resolve()
    return campaign


def find_campaign(source: str | Path) -> Path:
    """Return the file of a campaign given as a path or by the name of a shipped one.

    Raises
    ------
    InputError
        If there is neither.
    """
    path, text = Path(source), str(source)
    try:
        if path.is_file():
            return path
    except (OSError, ValueError):
        pass
    folder = shipped.scenario_dir() / FOLDER
    names = sorted(file.stem for file in folder.glob("*.yaml"))
    name = text.removesuffix(".yaml").removeprefix(f"{FOLDER}/")
    if name in names:
        return folder / f"{name}.yaml"
    near = difflib.get_close_matches(name, names, n=1)
    raise InputError(
        text[:200] or "CAMPAIGN",
        found="no such file",
        expected=f"the file of a campaign, or one of {', '.join(names)}",
        remedy=f"did you mean {near[0]}?" if near else "check the path",
    )


def where_varied(campaign: Campaign, key: str) -> str:
    """Return the file and line of a varied key."""
    return campaign.origin.place(("vary", key))
