"""Aerodynamic functions of an XML: which there are, what a name means, and where a factor goes."""

from __future__ import annotations

import pytest

from uavftc.aircraft.definition import load_aircraft
from uavftc.plants.jsbsim.copy import Addition, edited
from uavftc.plants.jsbsim.functions import Factor, functions, meant
from uavftc.plants.jsbsim.load import initialised
from uavftc.plants.jsbsim.trim import place

XML = b"""<fdm_config>
  <system><function name="not/this"><value>1</value></function></system>
  <aerodynamics>
    <function name="aero/f/k"><value>2</value></function>
    <axis name="ROLL">
      <function name="aero/c/Clp"> <description>a <b/> c</description><!-- c -->
        <product><property>p</property><value>3</value></product>
      </function>
      <function name="aero/c/t"><table/></function>
      <function><value>4</value></function>
    </axis>
    <axis name="YAW"><function name="aero/n/Clp"><p>x</p><value>5</value></function></axis>
  </aerodynamics>
  <aerodynamics><function name="second"><value>1</value></function></aerodynamics>
</fdm_config>
"""


def test_the_functions_are_those_of_the_section_that_jsbsim_reads():
    found = functions(XML)
    assert found.names == ["aero/f/k", "aero/c/Clp", "aero/c/t", "aero/n/Clp"]
    assert found.elsewhere is None
    terms = [XML[one.begin : one.end] for one in found.functions]
    assert terms == [
        b"<value>2</value>",
        b"<product><property>p</property><value>3</value></product>",
        b"<table/>",
        b"<p>x</p>",  # JSBSim passes over a second term
    ]


def test_a_factor_makes_a_product_of_the_term_and_moves_no_line():
    text = edited(XML, moment=False, additions=[Factor("aero/c/t", -0.5), Factor("aero/f/k", 3.0)])
    assert b'<function name="aero/c/t"><product><value>-0.5</value><table/></product></function>' in text
    assert b'"aero/f/k"><product><value>3.0</value><value>2</value></product></function>' in text
    assert text.count(b"\n") == XML.count(b"\n")
    both = edited(XML, moment=True, additions=[Addition("aerodynamics", "<x/>"), Factor("aero/c/Clp", 2.0)])
    assert b"<product><value>2.0</value><product><property>p</property><value>3</value></product></product>" in both


def test_a_factor_is_put_into_a_file_in_utf_16():
    text = b'<?xml version="1.0" encoding="UTF-16"?>' + XML
    assert b"<product><value>2.0</value><table/>" in edited(
        text.decode().encode("utf-16"), moment=False, additions=[Factor("aero/c/t", 2.0)]
    )


def test_a_name_is_the_whole_one_or_its_last_part():
    names = functions(XML).names
    assert meant("aero/c/t", names).function == meant("t", names).function == "aero/c/t"
    two = meant("Clp", names)
    assert two.function is None
    assert two.expected == "one function; it is the last part of aero/c/Clp, aero/n/Clp"
    assert meant("aero/n/Clp", names).function == "aero/n/Clp"
    absent = meant("Cl_p", names)
    assert (absent.function, absent.expected) == (None, "one of k, Clp, t")
    assert absent.remedy == "did you mean Clp?"
    assert meant("clp", names).function is None  # CL is lift, Cl is roll
    assert "stands 2 times" in meant("x/a", ["x/a", "x/a"]).expected


def test_aerodynamics_in_a_file_of_their_own_are_seen_as_such():
    found = functions(b'<fdm_config><aerodynamics file="aero"/></fdm_config>')
    assert found.names == []
    assert found.elsewhere == "aero"


@pytest.mark.parametrize(("name", "function"), [("hale", "aero/moment/Cl_p"), ("jsbsim:c172p", "aero/coefficient/Clp")])
def test_the_measured_roll_damping_is_that_of_the_xml_times_the_factor(name, function):
    # by central differences over the roll rate: of what JSBSim calls the rolling moment, and of the function alone
    aircraft = load_aircraft(name)
    damping = []
    for changes in ([], [Factor(function, 1.3)]):
        fdm = initialised(aircraft, 0.005, changes)
        moments = []
        for p in (0.01, -0.01):
            place(fdm, airspeed=50.0, altitude=1000.0, alpha=0.02, rates=(p, 0.0, 0.0))
            moments.append([fdm[function], fdm["moments/l-aero-lbsft"]])
        damping.append([(a - b) / 0.02 for a, b in zip(*moments, strict=True)])
    (alone, total), (scaled, scaled_total) = damping
    assert alone < 0.0
    assert scaled == pytest.approx(1.3 * alone, rel=1e-12)
    assert scaled_total - total == pytest.approx(0.3 * alone, rel=1e-9)
    if name == "hale":  # of which nothing else answers to a roll rate about the roll axis
        assert scaled_total == pytest.approx(1.3 * total, rel=1e-9)


def test_every_function_of_the_cessna_can_have_a_factor():
    # 0.5 on each coefficient: what it gives is half, and JSBSim complains about none
    aircraft = load_aircraft("jsbsim:c172p")
    names = functions(aircraft.xml.read_bytes()).names
    assert len(names) > 30

    def values(changes):
        fdm = initialised(aircraft, 0.005, changes)
        place(fdm, airspeed=50.0, altitude=1000.0, alpha=0.03, beta=0.05, rates=(0.1, 0.1, 0.1))
        return {name: fdm[name] for name in names}

    nominal, halved = values([]), values([Factor(name, 0.5) for name in names if name.startswith("aero/coefficient")])
    for name in names:
        if not name.endswith("adot"):  # alpha dot follows from the forces, which are others
            share = 0.5 if name.startswith("aero/coefficient") else 1.0
            assert halved[name] == pytest.approx(share * nominal[name], rel=1e-12), name
