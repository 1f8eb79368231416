"""What crosses between Python and JSBSim at a sample: what is read, what is not, and the loop around it."""

from __future__ import annotations

from xml.etree import ElementTree

import numpy as np
import pytest

from flying import bare, jsbsim_plant
from uavftc.aircraft.definition import load_aircraft, stock_names
from uavftc.core.signals import ENGINE, Shape, as_records, empty_rows
from uavftc.plants.jsbsim.model import trimmed_model
from uavftc.plants.jsbsim.reading import HEIGHT, NEAR_FT, STATE_PROPERTIES, Reading
from uavftc.plants.jsbsim.writer import Below, looper, reader


@pytest.mark.parametrize("burns", [False, True])
def test_a_mass_that_fuel_leaves_is_read_at_each_sample(burns):
    # and one that stays is not; both are what JSBSim computes with
    aircraft = load_aircraft("jsbsim:c172p")
    plant = jsbsim_plant(aircraft, airspeed=62.0, altitude=1500.0)
    plant.fdm["propulsion/fuel_freeze"] = 0.0 if burns else 1.0
    model = trimmed_model(aircraft, 62.0, 1500.0)
    reading = Reading(plant.fdm, aircraft, model, throttles=True, engines=0)
    reading.read()
    reading.weigh()
    observe, *_ = reading.blocks()
    masses = []
    for _ in range(200):
        plant.fdm.run()
        reading.read()
        masses.append(plant.fdm["inertia/mass-slugs"])
        assert observe.state["mass"] == masses[-1]
    assert (masses[0] > masses[-1]) == burns


def test_the_ground_is_felt_for_near_it_only():
    # also at a height that is not a number, and at the limit
    asked = []

    def force():
        asked.append(height[0])
        return -7.0

    height, memory = [0.0], np.zeros(3)
    read = reader(memory, [lambda: 1.0, lambda: height[0], Below(force, 1, 1000.0)])
    for height[0], expected in ((1000.1, 0.0), (1000.0, -7.0), (-5.0, -7.0), (np.nan, -7.0), (np.inf, 0.0)):
        memory[:] = 9.0
        read()
        np.testing.assert_array_equal(memory, [1.0, height[0], expected])
    np.testing.assert_array_equal(asked, [1000.0, -5.0, np.nan])
    assert STATE_PROPERTIES[HEIGHT] == "position/h-sl-ft"


def test_no_aircraft_is_so_large_that_it_touches_the_ground_from_where_its_force_is_not_read():
    # points of contact of all that JSBSim ships and of hale, from the origin of the structural frame, against 300 m
    unit = {"IN": 1.0 / 12.0, "FT": 1.0, "M": 1.0 / 0.3048, "CM": 0.01 / 0.3048}
    reach = {}
    for name in (*(f"jsbsim:{name}" for name in stock_names()), "hale"):
        for place in ElementTree.parse(load_aircraft(name).xml).iterfind(".//contact/location"):
            ft = [unit[place.get("unit", "IN")] * float(place.findtext(axis)) for axis in "xyz"]
            reach[name] = max(reach.get(name, 0.0), float(np.linalg.norm(ft)))
    assert len(reach) > 40
    assert max(reach.values()) < NEAR_FT / 2.0, max(reach, key=reach.get)


def test_the_loop_writes_what_the_program_made_then_steps_then_reads():
    done, out, into = [], np.zeros(2), np.zeros(1)

    def program(k, _end):
        out[:] = [k, 10.0 * k]
        done.append(("program", k, into[0]))
        return k if k == 7 else k + 1

    setters = [[lambda v: done.append(("a", v))], [lambda v: done.append(("b", v)), lambda v: done.append(("c", v))]]
    fly = looper(out, setters, lambda: done.append(("step",)), into, [lambda: float(len(done))])
    assert fly(program, 5, 7) == 7
    assert done == [
        ("program", 5, 0.0), ("a", 5.0), ("b", 50.0), ("c", 50.0), ("step",),
        ("program", 6, 5.0), ("a", 6.0), ("b", 60.0), ("c", 60.0), ("step",),
    ]  # fmt: skip
    assert fly(program, 6, 9) == 7  # where the program ends the flight, nothing more is written
    assert done[-1] == ("program", 7, 15.0)


def test_rows_without_room_for_engines_have_none_written():
    plant = jsbsim_plant(load_aircraft("hale"))
    assert "power" not in [block.name for block in plant.before()]
    plant = jsbsim_plant(load_aircraft("hale"), engines=2)
    shape = Shape(4, 2)
    rows = empty_rows(1, shape)
    plant.run(bare(plant), rows, 0, 1)
    engines = as_records(rows, shape)["engines"][0]
    assert engines.dtype == ENGINE
    np.testing.assert_array_equal(engines["throttle"], as_records(rows, shape)["throttle"][0])
    assert np.all(engines["thrust"] > 100.0)
