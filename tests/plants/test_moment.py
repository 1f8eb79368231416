"""The moment input of an aircraft that has none: where it is written, that it is exact, that nothing else changes."""

from __future__ import annotations

import xml.etree.ElementTree as ET

import numpy as np
import pytest

from flying import bare, flown, jsbsim_plant
from uavftc.aircraft.definition import load_aircraft, stock_names
from uavftc.core.signals import as_records, empty_rows
from uavftc.plants.jsbsim.copy import MOMENT, edited

BEFORE, AFTER = '<fdm_config name="a"><metrics/>', "<aerodynamics/></fdm_config>\n"
FORCE = '<force name="hook" frame="BODY"><direction><x>1</x></direction></force>'


def add_moment(text):
    """Return the text of an aircraft's XML with the moment added."""
    return edited(text.encode(errors="surrogateescape"), moment=True).decode(errors="surrogateescape")


def reactions(text):
    """Return the names of what an aircraft's only <external_reactions> holds, in order."""
    (section,) = ET.fromstring(text).findall("external_reactions")
    return [(child.tag, child.get("name")) for child in section]


def test_a_file_that_is_named_is_still_read():
    text = BEFORE + '<external_reactions file="a/b"/>' + AFTER
    assert ET.fromstring(add_moment(text)).find("external_reactions").get("file") == "a/b"


@pytest.mark.parametrize(
    ("section", "there"),
    [
        ("", []),
        ("<external_reactions/>", []),
        ("<external_reactions />", []),
        ("<external_reactions></external_reactions>", []),
        (f"<external_reactions>\n {FORCE}\n</external_reactions>", [("force", "hook")]),
        (f'<external_reactions file="none">{FORCE}</external_reactions>', [("force", "hook")]),
        ('<external_reactions file="a/b"/>', []),
        ('<external_reactions file="a>b" />', []),
        ("<!-- <external_reactions> was here --> <!-- </fdm_config> -->", []),
        (f"<!-- <external_reactions/> --><external_reactions>{FORCE}</external_reactions>", [("force", "hook")]),
    ],
)
def test_the_moment_is_added_to_what_is_there(section, there):
    # One section with the moment and all it had before; nothing in a comment is taken for it.
    text = BEFORE + section + AFTER
    assert reactions(add_moment(text)) == [("moment", MOMENT), *there]
    assert add_moment(text).count(MOMENT) == 1


def test_every_aircraft_that_jsbsim_ships_can_take_it():
    # All of them as they are written: comments, style sheets, capital letters, Latin-1.
    for name in stock_names():
        text = load_aircraft(f"jsbsim:{name}").xml.read_text(encoding="utf-8", errors="surrogateescape")
        if "</fdm_config>" in text:  # one is of an older format, and JSBSim does not load it
            before = ET.fromstring(text.encode("utf-8", errors="surrogateescape")).find("external_reactions")
            had = [] if before is None else [(child.tag, child.get("name")) for child in before]
            after = reactions(add_moment(text).encode("utf-8", errors="surrogateescape"))
            assert after == [("moment", MOMENT), *had], name


def accelerations(aircraft, d2, *, airspeed, altitude, has_moment=True):
    """Return p_dot, q_dot, r_dot, rad/s^2, of the first frame from the trim."""
    plant = jsbsim_plant(aircraft, airspeed=airspeed, altitude=altitude, has_moment=has_moment)
    rows = empty_rows(1, len(plant.u_limits))
    as_records(rows)["d2"] = d2
    plant.run(bare(plant), rows, 0, 1)
    return np.array([plant.fdm[f"accelerations/{x}dot-rad_sec2"] for x in "pqr"])


@pytest.mark.parametrize("d2", [(0.3, 0.0, 0.0), (0.0, -0.2, 0.0), (0.0, 0.0, 0.1), (0.05, 0.1, -0.2)])
def test_d2_is_exactly_an_angular_acceleration_of_a_stock_aircraft(d2):
    # The moment J d2 with the J that JSBSim holds, products of inertia and all; less what the trim leaves.
    aircraft, at = load_aircraft("jsbsim:c172p"), {"airspeed": 62.0, "altitude": 1500.0}
    still = accelerations(aircraft, (0.0, 0.0, 0.0), **at)
    np.testing.assert_allclose(accelerations(aircraft, d2, **at) - still, d2, atol=1e-9)
    np.testing.assert_array_equal(accelerations(aircraft, d2, **at, has_moment=False), still)  # not by another way


def test_an_added_moment_is_as_good_as_the_aircrafts_own(hale):
    # hale with its own input, and as if it had none: the same acceleration.
    at, d2 = {"airspeed": 30.0, "altitude": 1000.0}, (0.05, 0.1, -0.2)
    without = hale.model_copy(update={"disturbance_moment": None})
    np.testing.assert_allclose(accelerations(without, d2, **at), d2, rtol=1e-9)
    np.testing.assert_allclose(accelerations(hale, d2, **at), d2, rtol=1e-9)


def test_a_scenario_disturbs_a_stock_aircraft():
    # From the scenario to the motion: the push is rejected, and was there.
    push = "disturbances=[{kind: angular-acceleration, start_s: 5, end_s: 6, p_degps2: 30}]"
    overrides = ("aircraft=jsbsim:c172p", "initial.airspeed_mps=62", "saturation=null", "duration_s=10")
    _, pushed, outcome = flown("scenario1", "jsbsim", None, (*overrides, push))
    _, quiet, _ = flown("scenario1", "jsbsim", None, overrides)
    assert outcome.completed
    difference = pushed["x2"][:, 0] - quiet["x2"][:, 0]
    np.testing.assert_array_equal(difference[:1001], 0.0)
    assert np.max(np.abs(difference)) > np.radians(0.25)  # 30 deg/s^2 against an inner loop of 8.5 1/s
    assert abs(difference[-1]) < np.radians(0.1)
