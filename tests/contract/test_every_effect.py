"""One suite over every effect and every law: what a file in the tuple of its chain promises."""

from __future__ import annotations

import functools
import inspect
import re
import typing
from types import ModuleType

import numpy as np
import pytest
from pydantic import BaseModel

from uavftc import actuators, environment, sensors
from uavftc.actuators import stops
from uavftc.actuators.at_rest import Rest, everywhere
from uavftc.actuators.saturation import SurfaceLimits
from uavftc.config.described import descriptions
from uavftc.config.effect import config_of
from uavftc.config.explain import unit_of
from uavftc.config.values import Model, Window
from uavftc.control import inner, outer, whole
from uavftc.control.custom.controller import custom_controller
from uavftc.core.given import Given
from uavftc.core.layout import OWN_GANGS
from uavftc.core.program import Program
from uavftc.core.signals import EFFECTOR, ROW, ROW_WIDTH, SURFACES, as_records, empty_rows
from uavftc.core.stage import RAW, Block, Stage, records_of
from uavftc.flight.build import build_flight
from uavftc.scenario.schema import Scenario

GROUPS = {
    "actuators": actuators.CHAIN,
    "engines": actuators.ENGINES,
    "sensors": sensors.CHAIN,
    "environment": environment.KINDS,
    "outer": outer.KINDS,
    "inner": inner.KINDS,
}
EVERY = [(group, effect) for group, effects in GROUPS.items() for effect in effects]
LAWS = [
    (group, effect)
    for group, effect in EVERY
    if group != "engines" and (group != "environment" or hasattr(effect, "blocks"))
]

DIMENSIONLESS = {
    "kind", "surface", "effectiveness", "effectiveness_bounds", "gamma", "adaptation_gain", "Q", "reference_gain",
    "integration", "anti_windup", "centres", "width", "known", "mode", "damping", "ratio", "flow",
    "profile", "exponent", "count", "signs", "onset", "model", "severity", "rotational", "engine", "at", "power",
    "axis", "attitude_scale_factor_error", "gyro_scale_factor_error", "loop_gain",
}  # fmt: skip
UNIT = re.compile(r"(?<![\w/])(1/s|1/s\^2|rad/s|rad/s\^2|rad|s|m/s)(?=[,;.\s]|$)")
"""A unit in a description: keys named by a symbol of the paper have theirs there."""


def named(pairs):
    return pytest.mark.parametrize(
        ("group", "effect"), pairs, ids=[f"{group}/{effect.__name__.rpartition('.')[2]}" for group, effect in pairs]
    )


def sections(annotation) -> list[type[BaseModel]]:
    """Return the sections that an annotation admits."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return [annotation]
    return [section for part in typing.get_args(annotation) for section in sections(part)]


def all_sections(annotation) -> list[type[BaseModel]]:
    """Return those that an annotation admits, and those inside them."""
    inside = [
        section
        for outside in sections(annotation)
        for field in outside.model_fields.values()
        for section in all_sections(field.annotation)
    ]
    return [*sections(annotation), *inside]


@functools.cache
def scenario() -> Scenario:
    return Scenario.model_validate({"name": "contract", "duration_s": 1, "plant": "analytic"})


SURFACES_HIT = [{"surface": "rudder", "effectiveness": 0.5, "bias_deg": 1}]
ON = {
    "saturation": {"min_rad": -0.05, "max_rad": 0.1},
    "faults": SURFACES_HIT,
    "damage": [{"control_power": {"elevator": 0.5}}],
    "controller": {"delay_s": 0.0125, "loop_gain": 1.5},
    "sensors": {
        "gyro_bias_degps": [1, -2, 3],
        "gyro_misalignment_deg": [3, -2, 1],
        "attitude_misalignment_deg": [-1, 2, 30],
        "attitude_scale_factor_error": [0.01, 0, -0.02],
        "gyro_random_walk_degps_per_rts": [0.1, 0, 0.2],
        "attitude_noise_density_deg_per_rthz": [0.1, 0, 0.2],
        "gyro_quantisation_degps": [0, 0.1, 0.2],
        "attitude_delay_s": [0.01, 0.0125, 0],
        "gyro_dropout": [{"start_s": 0.05, "mean_lost_s": 0.02, "mean_between_s": 0.02}],
        "attitude_stuck": [{"start_s": 0.05, "end_s": 0.1, "axis": "pitch"}],
    },
    "actuators": {
        "deadband_deg": 0.5,
        "delay_s": 0.0075,
        "bandwidth_radps": 40,
        "damping": 0.7,
        "rate_limit_degps": 60,
        "min_deg": -4,
        "max_deg": 5,
        "backlash_deg": 0.4,
        "elevator": {"damping": None},
    },
}


RUDDER = {"surface": "rudder"}
FAULTS_ON = {
    "effectiveness": {"effectiveness": 0.5, "bias_deg": 1},
    "intermittent": {"on_s": 1, "off_s": 0.1, "effectiveness": 0.5},
    "oscillatory": {"amplitude_deg": 1, "frequency_hz": 2},
    "drift": {"rate_degps": 1},
    "hardover": {"rate_degps": 1},
    "float": {"ratio": 0.5},
    "stuck": {"at_deg": 1},
    "total-loss": {},
}
"""Of each kind of fault one that acts; a scenario has only one of them at a time on a surface."""

DISTURBANCES_ON = {
    "angular-acceleration": {"p_degps2": 1, "q_degps2": 2, "r_degps2": -1},
    "attitude-rate": {"phi_degps": 1, "theta_degps": 2, "psi_degps": -1},
    "wind": {"north_mps": 1, "east_mps": 2, "down_mps": -1},
    "shear": {"north_mps": 4, "east_mps": -2},
    "gust": {"ramp_s": 0.5, "north_mps": 1, "down_mps": -1},
    "gust-train": {"ramp_s": 0.2, "count": 2, "north_mps": 1, "signs": "random", "onset": "random"},
    "turbulence": {"severity": "light", "fade_s": 0},
}
"""Of each kind of disturbance one that acts; no plant has all of them."""


@functools.cache
def everything_on() -> Scenario:
    return Scenario.model_validate({"name": "contract", "duration_s": 1, "plant": "analytic", **ON})


@functools.cache
def given() -> Given:
    flown = build_flight(scenario()).given
    three = {
        "effectors": SURFACES,
        "mixing": np.eye(3),
        "gangs": OWN_GANGS,
        "trim_rad": None,
        "read": None,
        "sense": None,
    }
    return flown._replace(stops_rad=np.array([[-np.inf, np.inf]] * 3), **three)


def config(group: str, effect: ModuleType, of: Scenario):
    """Return what a scenario says of an effect; a law of a loop has its defaults and the aircraft's B_m."""
    if getattr(effect, "ENTRY_OF", None) == "faults" and of is everything_on():
        return (effect.Config.model_validate(RUDDER | FAULTS_ON[effect.Config.model_fields["kind"].default]),)
    if getattr(effect, "ENTRY_OF", None) == "disturbances" and of is everything_on():
        return (effect.Config.model_validate(DISTURBANCES_ON[effect.Config.model_fields["kind"].default]),)
    if group not in ("outer", "inner"):
        return config_of(effect, of)
    chosen = effect.Config()
    return chosen.model_copy(update={"B_m": given().design.B.tolist()}) if hasattr(chosen, "B_m") else chosen


@named(EVERY)
def test_a_file_says_what_it_is(group: str, effect: ModuleType) -> None:
    # a line that names it, then what its equations are
    assert effect.__doc__
    title = effect.__doc__.splitlines()[0]
    assert 15 < len(title) <= 118
    assert title.endswith((".", ":")) or effect.__doc__.splitlines()[1] != ""


@named([(group, effect) for group, effect in EVERY if hasattr(effect, "Config")])
def test_each_key_is_documented_and_has_a_unit_or_none(group: str, effect: ModuleType) -> None:
    # the reference of the keys, the schema for editors and the error messages are made of these
    found = all_sections(effect.Config)
    assert found
    for section in found:
        assert issubclass(section, Model)
        assert section.model_config["frozen"]
        assert section.model_config["extra"] == "forbid" or section is SurfaceLimits  # by the names of an aircraft
        assert inspect.getdoc(section)
        texts = descriptions(section)
        for key, field in section.model_fields.items():
            if key == "kind" or sections(field.annotation):  # the section itself says what it is
                continue
            assert texts[key], f"{section.__qualname__}.{key} says nothing"
            assert key in DIMENSIONLESS or unit_of(key) or UNIT.search(texts[key]), f"{key}: {texts[key]}"


@named([(group, effect) for group, effect in EVERY if hasattr(effect, "Config")])
def test_its_place_in_a_scenario_is_one(group: str, effect: ModuleType) -> None:
    # a section, keys in one, or a kind of entry: `schema.py` looks for exactly these
    places = [name for name in ("SECTION", "KEYS_IN", "ENTRY_OF") if hasattr(effect, name)]
    if group in ("outer", "inner"):
        assert places == []  # its kind is chosen in `controller`
    else:
        assert len(places) == 1
    if "ENTRY_OF" in places or group in ("outer", "inner"):
        assert isinstance(effect.Config.model_fields["kind"].default, str)
    if "KEYS_IN" in places:
        effect.Config()  # where nothing is said it is off: every key has a default


def test_no_two_files_share_a_key_or_a_kind() -> None:
    # the keys of a section come from several files, and a kind names one
    for group, effects in GROUPS.items():
        kinds = [e.Config.model_fields["kind"].default for e in effects if hasattr(e, "Config") and is_a_kind(e)]
        assert len(set(kinds)) == len(kinds), group
    shared = [(e.KEYS_IN, key) for _, e in EVERY if hasattr(e, "KEYS_IN") for key in e.Config.model_fields]
    assert len(set(shared)) == len(shared)


def is_a_kind(effect: ModuleType) -> bool:
    return isinstance(effect.Config, type) and "kind" in effect.Config.model_fields


@named([(group, effect) for group, effect in EVERY if hasattr(effect, "FAULT")])
def test_a_fault_that_changes_an_effect_is_a_kind_with_a_label(group: str, effect: ModuleType) -> None:
    # entries of `faults` are told apart by their kind, and figures write the label into the window
    assert isinstance(effect.FAULT.model_fields["kind"].default, str)
    assert isinstance(effect.FAULT.label, property)


@named([(group, effect) for group, effect in EVERY if hasattr(effect, "Config")])
def test_each_entry_with_a_window_has_a_label(group: str, effect: ModuleType) -> None:
    # figures list it, and write it into the window
    entries = [s for s in all_sections(effect.Config) if issubclass(s, Window) or hasattr(s, "end_s")]
    for entry in entries:
        bases = entry.__subclasses__() or [entry]  # of several kinds of sensor each says its unit
        assert all(isinstance(getattr(one, "label", None), property) for one in bases), entry.__qualname__
    if getattr(effect, "ENTRY_OF", None):
        assert entries


@named(LAWS)
def test_its_stage_is_made_of_its_step(group: str, effect: ModuleType) -> None:
    # one implementation of each law, with the records it says
    assert isinstance(effect.PARAMS, np.dtype)
    assert isinstance(effect.STATE, np.dtype)
    assert isinstance(effect.stage, Stage)
    assert effect.stage.python is getattr(effect.step, "py_func", effect.step)
    assert (effect.stage.params, effect.stage.state) == (effect.PARAMS, effect.STATE)
    assert effect.stage.on_effector is (group == "actuators")
    assert effect.stage.reads is not None
    assert effect.stage.writes
    assert effect.step.__doc__


@named([(group, effect) for group, effect in EVERY if group == "environment"])
def test_a_disturbance_adds_to_the_fields_it_names(group: str, effect: ModuleType) -> None:
    # by a signal of time, by a law, or by both; the plants ask which fields those are, and never look at the others
    assert hasattr(effect, "prescribe") or hasattr(effect, "blocks")
    rows = still_rows(5)
    before = rows.copy()
    disturb(effect, rows)
    once = as_records(rows - before)
    changed = [name for name in ROW.names if once[name].any()]
    assert sorted(changed) == sorted(effect.FIELDS)
    disturb(effect, rows)
    np.testing.assert_array_equal(rows - before, 2.0 * once.view(float).reshape(rows.shape))  # what overlaps adds up


def still_rows(n: int) -> np.ndarray:
    """Return rows of level flight in still air; nothing in them loses a digit when something small is added."""
    rows = empty_rows(n)
    records = as_records(rows)
    records["t"], records["airspeed"], records["height"] = np.linspace(0.0, 1.0, n), 32.0, 512.0
    return rows


def disturb(effect: ModuleType, rows: np.ndarray) -> None:
    """Let an entry that acts disturb the rows, by its signals and its laws."""
    (entry,) = config("environment", effect, everything_on())
    records = as_records(rows)
    if hasattr(effect, "prescribe"):
        chosen = effect.drawn(entry, 7, 0) if hasattr(effect, "drawn") else entry
        assert (chosen.start_s, chosen.end_s) == (entry.start_s, entry.end_s)
        effect.prescribe(chosen, records["t"], records, given().targets)
    if hasattr(effect, "blocks"):
        Program(effect.blocks((entry,), given())).run(rows, 0, len(rows))


@named(LAWS)
def test_blocks_come_of_a_scenario_with_defaults(group: str, effect: ModuleType) -> None:
    # what does nothing costs nothing: of the actuators only the stops of the aircraft are there
    blocks = effect.blocks(config(group, effect, scenario()), given())
    assert all(isinstance(block, Block) for block in blocks)
    if group == "actuators":
        assert blocks == [] or effect is stops
    elif group == "environment":
        assert blocks == []
    elif group in ("outer", "inner"):
        assert blocks


@named(LAWS)
def test_blocks_come_of_a_scenario_in_which_it_acts(group: str, effect: ModuleType) -> None:
    # names unlike those of the other effects, an entry an effector
    blocks = effect.blocks(config(group, effect, everything_on()), finite_stops())
    assert blocks
    for block in blocks:
        assert isinstance(block, Block)
        assert block.params.dtype == block.stage.params
        assert block.stage.state in (RAW, block.state.dtype)
        assert len(block.params) == (len(given().effectors) if block.stage.on_effector else 1)


def finite_stops() -> Given:
    return given()._replace(stops_rad=np.array([[-0.3, 0.2]] * 3), damage=everything_on().damage)


def chain_of(group: str, of: Scenario, with_stops: Given) -> list[Block]:
    return [b for effect in GROUPS[group] for b in effect.blocks(config(group, effect, of), with_stops)]


def test_every_name_of_a_flights_blocks_is_its_own() -> None:
    # two effects with one name could not fly together
    names = [b.name for group in ("sensors", "actuators") for b in chain_of(group, everything_on(), finite_stops())]
    assert len(set(names)) == len(names)


# --- compiled and in plain Python ------------------------------------------------------------------------------------


def random_rows(n: int) -> np.ndarray:
    rows = np.random.default_rng(71).uniform(-0.3, 0.3, empty_rows(n).shape)
    records = as_records(rows)
    records["t"], records["status"] = np.arange(n) * 0.005, 0.0
    return rows


def in_python(block: Block, rows: np.ndarray) -> np.ndarray:
    """Run the law of a block as it is written on records of its memory; return its state."""
    state, raw = block.state.copy(), block.stage.state == RAW
    params, memory = block.params.view(np.recarray), state if raw else state.view(np.recarray)
    for row in rows:
        signals = row[:ROW_WIDTH].view(ROW).view(np.recarray)[0]
        if not block.stage.on_effector:
            block.stage.python(params[0], state if raw else memory[0], signals)
            continue
        for i, effector in enumerate(row[ROW_WIDTH:].view(EFFECTOR).view(np.recarray)):
            block.stage.python(params[i], memory[i], effector, signals)
    return state


def numbers(array: np.ndarray) -> np.ndarray:
    """Return the numbers in records, of whatever fields, as one line."""
    if array.dtype.names is None:
        return np.ravel(array).astype(float)
    return np.concatenate([np.ravel(array[name]).astype(float) for name in array.dtype.names])


def assert_same(block: Block, samples: int) -> None:
    rows = random_rows(samples)
    plain = rows.copy()
    expected = in_python(block, plain)
    before = rows.copy()
    assert Program([block]).run(rows, 0, samples) == samples
    assert not np.array_equal(rows, before)  # it did something
    np.testing.assert_allclose(rows, plain, rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(numbers(block.state), numbers(expected), rtol=1e-12, atol=1e-12)


@named(LAWS)
def test_a_law_compiled_is_the_law_in_plain_python(group: str, effect: ModuleType) -> None:
    # on random signals: what is read with NUMBA_DISABLE_JIT=1 in a debugger is what flies
    blocks = effect.blocks(config(group, effect, everything_on()), finite_stops())
    for block in blocks:
        assert_same(block, 30)


@pytest.mark.parametrize("name", whole.NAMES)
def test_a_whole_controller_promises_the_same(name: str) -> None:
    # it stands in the place of both loops: made of the design, tried before it flies
    module = __import__(f"{whole.__name__}.{name}", fromlist=["x"])
    assert module.__doc__.strip()
    (last,) = (block for block in custom_controller(name, given(), {}).blocks if block.name == "custom")
    if not isinstance(last, Block):
        assert callable(module.create(given().design, given().h, {}))
        return
    assert module.stage.python is getattr(module.step, "py_func", module.step)
    assert (module.stage.params, module.stage.state) == (module.PARAMS, module.STATE)
    assert_same(last, 30)


@pytest.mark.parametrize("field", ["deflection", "command"])
@pytest.mark.parametrize("effector", [0, 1, 2])
def test_nan_passes_through_the_chain_of_the_actuators(field: str, effector: int) -> None:
    # a broken command must reach the watch, not become a plausible deflection: also by an effect that is new here
    rows = empty_rows(8)
    effectors = as_records(rows)["effectors"]
    effectors["effectiveness"] = 1.0
    effectors[field][:, effector] = np.nan
    blocks = chain_of("actuators", everything_on(), finite_stops())
    assert len(blocks) == len(actuators.CHAIN)
    assert Program([], blocks).run(rows, 0, 8) == 8
    expected = np.zeros(3, dtype=bool)
    expected[effector] = field == "deflection"  # the command is the allocation's, the effects work on the deflection
    np.testing.assert_array_equal(np.isnan(effectors["deflection"][-1]), expected)


@named([(group, effect) for group, effect in EVERY if group == "actuators"])
def test_nan_passes_through_each_of_the_actuators(group: str, effect: ModuleType) -> None:
    # alone too, with finite limits, whatever is about it
    (block,) = effect.blocks(config(group, effect, everything_on()), finite_stops())
    rows = empty_rows(8)
    as_records(rows)["effectors"]["effectiveness"] = 1.0
    as_records(rows)["effectors"]["deflection"] = np.nan
    Program([], [block]).run(rows, 0, 8)
    assert np.isnan(as_records(rows)["effectors"]["deflection"][-1]).all()


def test_limits_are_given_by_name_to_each_effector() -> None:
    # the contract is checked with limits that bind: three effectors, three records
    saturation = next(e for e in actuators.CHAIN if getattr(e, "SECTION", None) == "saturation")
    (block,) = saturation.blocks(everything_on().saturation, given())
    np.testing.assert_array_equal(block.params, records_of(saturation.PARAMS, 3, u_min=[-0.05] * 3, u_max=[0.1] * 3))


@named(
    [(group, effect) for group, effect in EVERY if group == "actuators" and getattr(effect, "ENTRY_OF", "") == "faults"]
)
def test_a_fault_of_a_surface_says_where_it_leaves_it_at_rest(group: str, effect: ModuleType) -> None:
    # what `uavftc survivable` asks of each; an interval an effector, and another one than without the fault
    before = everywhere(3).within(*finite_stops().stops_rad.T)
    entries = config(group, effect, everything_on())
    found = effect.at_rest(entries, finite_stops(), Rest(0.5, lambda _: np.zeros(3)), before)
    for reach in found:
        assert np.all(reach.low <= reach.high)
        assert reach.held.dtype == bool
    assert any(not np.array_equal(reach.low, before.low) or reach.by_beta.any() for reach in found)
    (same,) = effect.at_rest((), finite_stops(), Rest(0.5, lambda _: np.zeros(3)), before)
    np.testing.assert_array_equal(same.low, before.low)
