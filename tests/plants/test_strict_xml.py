"""The strict check of an aircraft's files: what JSBSim would pass over is an error, or a warning without a companion.

Each case is one typing error in a copy of hale that JSBSim loads without a word, with the line that the message names.
"""

from __future__ import annotations

import re

import pytest

from flying import flown
from uavftc.aircraft.definition import load_aircraft, stock_names
from uavftc.config.shipped import aircraft_dir
from uavftc.errors import CombinedInputError, InputError
from uavftc.plants.jsbsim import strict
from uavftc.plants.jsbsim.strict.check import KINDS

AUTO = "systems/hale_autothrottle.xml"
PROP = "engine/hale_prop.xml"
PLANET = "flat_planet.xml"
MOTOR = "engine/hale_motor.xml"
HALE = aircraft_dir() / "hale"

# file, text (a bare word is an element's name), what it becomes, what is found there, the remedy
TYPOS = {
    "emptied property": (
        "hale.xml",
        "<property>aero/beta-rad</property>",
        "<property></property>",
        "nothing in <property>",
        "write a value",
    ),
    "function": ("hale.xml", "function", "functoin", "<functoin> as a child of <aerodynamics>", "<function>"),
    "axis": ("hale.xml", "axis", "axes", "<axes> as a child of <aerodynamics>", "<axis>"),
    "clipto": ("hale.xml", "clipto", "clipt", "<clipt> as a child of <actuator>", "<clipto>"),
    "limit of clipto": (AUTO, "<min>0</min>", "<mim>0</mim>", "<mim> as a child of <clipto>", "<min>"),
    "section": (
        "hale.xml",
        "external_reactions",
        "external_reaction",
        "<external_reaction> as a child",
        "<external_reactions>",
    ),
    "GM": (PLANET, "GM", "Gn", "<Gn> as a child of <planet>", "<GM>"),
    "J2 emptied": (PLANET, "<J2>0</J2>", "<J2/>", "nothing in <J2>", "write a value"),
    "number of a row": (PROP, "1.0  0.0650", "1.0", "1 number, '1.0'", "complete"),
    "first number of a table": (PROP, "0.0  0.1300", "0.1300", "1 number, '0.1300'", "complete"),
    "order of rows": (PROP, "1.0  0.0650", "0.4  0.0650", "0.4 after 0.5", "complete or correct"),
    "name of a table": (PROP, 'name="C_POWER"', 'name="C_POWR"', 'name="C_POWR" in <table>', 'name="C_POWER"'),
    "element of an engine": (MOTOR, "power", "powr", "<powr> as a child of <electric_engine>", "<power>"),
    "attribute unit": (
        "hale.xml",
        'wingarea unit="M2"',
        'wingarea units="M2"',
        'units="M2" in <wingarea>',
        'unit="..."',
    ),
    "unit": (PROP, 'diameter unit="M"', 'diameter unit="m"', 'unit="m" in <diameter>', "attribute unit"),
    "nan": ("hale.xml", "<value>-0.5</value>", "<value>nan</value>", "'nan' in <value>", "correct the text"),
    "friction": (
        "hale.xml",
        "dynamic_friction",
        "dynamic_fricton",
        "<dynamic_fricton> as a child of <contact>",
        "<dynamic_friction>",
    ),
    "test": (AUTO, "ap/at-on LT 0.5", "ap/at-on 0.5", "'ap/at-on 0.5' in <test>", "correct the text"),
    "logic": (AUTO, 'logic="AND" value="1"', 'logc="AND" value="1"', 'logc="AND" in <test>', 'logic="..."'),
    "type of an integral": (AUTO, 'ki type="trap"', 'ki type="trapez"', 'type="trapez" in <ki>', 'type="trap"'),
    "gain": (AUTO, "kp", "kpp", "<kpp> as a child of <pid>", "<kp>"),
    "output": (
        AUTO,
        "fcs/throttle-pos-norm[1]<",
        "fcs/throtle-pos-norm[1]<",
        "fcs/throtle-pos-norm[1]",
        "fcs/throttle-pos-norm[1]",
    ),
    "signs of products": ("hale.xml", 'inertia="false"', 'inertia="fals"', 'inertia="fals"', '"false"'),
    "text in an operator": ("hale.xml", "<product>", "<product> 2", "'2' in <product>", "put it into an element"),
    "thruster": ("hale.xml", "thruster", "thrster", "<thrster> as a child of <engine>", "<thruster>"),
    "no table of power": (
        PROP,
        'name="C_POWER"',
        'name="CP_MACH"',
        '<propeller> without <table name="C_POWER">',
        "add <table",
    ),
}


@pytest.mark.parametrize("name", TYPOS)
def test_what_jsbsim_would_pass_over_is_refused_with_its_line(name, edited):
    file, old, new, found, remedy = TYPOS[name]
    changes = [(old, new)]
    if old.isalnum() or old.replace("_", "").isalpha():
        changes = [(f"<{old}{end}", f"<{new}{end}") for end in (" ", ">")] + [(f"</{old}>", f"</{new}>")]
        text = (HALE / file).read_text(encoding="utf-8")
        changes = [change for change in changes if change[0] in text]
    folder = edited(file, *changes)
    path = folder / file
    text = path.read_text(encoding="utf-8")
    with pytest.raises(InputError) as error:
        strict.refuse(load_aircraft(str(folder)))
    assert str(path) in error.value.where
    assert found in error.value.found
    assert remedy in error.value.remedy
    assert error.value.expected
    lines = {text[: at.start()].count("\n") + 1 for _, made in changes for at in re.finditer(re.escape(made), text)}
    lines |= {text.count("\n", 0, text.index("<propeller")) + 1} if "without" in found else set()
    assert int(error.value.where.rpartition(" ")[2]) in lines


def test_every_kind_that_a_table_names_is_there():
    # A child of an unknown kind would be a KeyError on the first aircraft that has it.
    named = {child.kind for kind in KINDS.values() for child in kind.children.values()}
    assert named - set(KINDS) == set()


# The typing errors of the aircraft that JSBSim ships; all else in all of them is accepted.
STOCK = {
    "Boeing314": {"a second <ratedboost1> in <piston_engine>", "a second <ratedpower1> in <piston_engine>",
                  "a second <ratedrpm1> in <piston_engine>", "a second <ratedaltitude1> in <piston_engine>"},
    "Short_S23": {"a second <boostoverride> in <piston_engine>", 'breakpoint="" in <tableData>'},
    "p51d": {'loginc="AND" in <test>', 'LOGIC="AND" in <test>', 'login="AND" in <test>'},
}  # fmt: skip


def test_what_stands_in_the_aircraft_that_jsbsim_ships_is_known():
    # Sixty aircraft with their engines and systems: what they use, JSBSim reads. `blank` is of a format it left.
    names = [name for name in stock_names() if name != "blank"]
    assert len(names) > 50
    found = {}
    for name in names:
        if words := {finding.found for finding in strict.findings(load_aircraft(f"jsbsim:{name}"))}:
            found[name] = words
    assert found == STOCK


def test_an_aircraft_without_a_companion_is_warned_about(edited):
    # Four of its findings and the number of the others: what it claims nothing about, it is not refused for.
    changes = [(name, name + "x") for name in ("htailarea", "htailarm", "vtailarea", "vtailarm")]
    folder = edited("hale.xml", *changes, ('name="NOSE_SKID"', 'name="NOSE_SKID" nmae="x"'))
    with pytest.raises(CombinedInputError) as error:
        strict.refuse(load_aircraft(str(folder)))
    assert len(error.value.errors) == 5
    (folder / "uavftc.yaml").unlink()
    bare = load_aircraft(str(folder))
    strict.refuse(bare)
    lines = strict.warnings(bare)
    assert len(lines) == 5
    assert lines[0] == "hale.xml, line 21: <htailareax> as a child of <metrics>; write <htailarea>"
    assert lines[4] == "hale.xml: 1 more of this kind"


def test_the_warnings_stand_with_those_of_the_flight(edited):
    # They reach summary.json and the terminal as every other warning does.
    from uavftc.results.flight import notes_of

    folder = edited("hale.xml", ("htailarm", "htailarn"))
    (folder / "uavftc.yaml").unlink()
    overrides = (f"aircraft={folder}", "saturation=null", "duration_s=0.1", "initial.airspeed_mps=30")
    flight, _, _ = flown("scenario1", "jsbsim", None, overrides)
    assert notes_of(flight) == ("hale.xml, line 22: <htailarn> as a child of <metrics>; write <htailarm>",)


def test_a_file_that_is_included_is_checked_with_its_own_path(edited):
    folder = edited(AUTO, ("<kd>", "<kdd>"), ("</kd>", "</kdd>"))
    with pytest.raises(InputError) as error:
        strict.refuse(load_aircraft(str(folder)))
    assert str(folder / AUTO) in error.value.where


AILERON = "<value>0.258740549229</value>"


def test_an_aircraft_without_roll_control_is_refused_in_spite_of_its_analytic_model(edited):
    # The XML is in order, and the aileron rolls it through its yaw alone: `design` refuses it, and so does the flight.
    folder = edited("hale.xml", (AILERON, "<value>0</value>"))
    with pytest.raises(InputError, match=r"too little aileron for a small step: roll has 0.03 times"):
        flown("scenario1", "jsbsim", None, (f"aircraft={folder}", "duration_s=1"))


@pytest.mark.parametrize("surface", ["aileron", "rudder"])
def test_a_surface_that_moves_nothing_is_refused_in_spite_of_an_analytic_model(surface, edited):
    # Its channel ends at a property of another name, so the position that JSBSim itself has stays at zero.
    # Without its elevator there is no trim, which is refused before.
    positions = {"aileron": ("left-aileron", "right-aileron"), "rudder": ("rudder",)}[surface]
    outputs = [f"<output>fcs/{position}-pos-rad</output>" for position in positions]
    folder = edited("hale.xml", *((output, output.replace("pos-rad", "elsewhere")) for output in outputs))
    with pytest.raises(InputError, match=f"no small-signal {surface} response: 0 rad/s"):
        flown("scenario1", "jsbsim", None, (f"aircraft={folder}", "duration_s=1"))


def test_a_reference_beyond_the_authority_of_hale_is_flown():
    # hale's companion brings the paper's rotational model: what is asked of it is its user's affair, with a warning.
    _, records, _ = flown("scenario1", "jsbsim", None, ("reference.psi_deg=170", "duration_s=0.5"))
    assert len(records) == 101
