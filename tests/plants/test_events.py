"""What JSBSim is told once at a row of a flight: when it acts, and what it leaves as it was."""

from __future__ import annotations

import numpy as np
import pytest

from flying import bare, jsbsim_plant
from uavftc.core.signals import empty_rows
from uavftc.plants.interface import Timing
from uavftc.plants.jsbsim.copy import Addition, edited
from uavftc.plants.jsbsim.events import Event, Told, row_at

THROTTLE = "fcs/throttle-cmd-norm[0]"
MASS = Addition("mass_balance", '<pointmass name="x"><weight unit="LBS">0</weight><location unit="M"><x>0</x><y>0</y>'
                '<z>0</z></location></pointmass>')  # fmt: skip
WEIGHT = "inertia/pointmass-weight-lbs[0]"


def flown(aircraft, events, *, chunks=(60,), substeps=1, additions=()):
    plant = jsbsim_plant(aircraft, Timing(0.005, substeps), told=[Told(tuple(events), tuple(additions))])
    rows = empty_rows(60, 4)
    program = bare(plant)
    first = 0
    for last in chunks:
        assert plant.run(program, rows, first, last) == last
        first = last
    return rows, plant.fdm


def test_rows_up_to_that_of_an_event_keep_every_bit_and_the_forces_from_it_on_know(hale):
    quiet, _ = flown(hale, [])
    told, _ = flown(hale, [Event(20, "fcs/rudder-cmd-norm", 0.1), Event(20, "fcs/elevator-cmd-norm", 0.1)])
    np.testing.assert_array_equal(told, quiet)  # the plant commands its surfaces at each frame
    told, _ = flown(hale, [Event(20, WEIGHT, 100.0)], additions=[MASS])
    np.testing.assert_array_equal(told[:21], quiet[:21])
    # the frame from t_20 computes with the new mass what moves the vehicle in the next
    assert np.any(told[22] != quiet[22])


@pytest.mark.parametrize("chunks", [(60,), (20, 60), (7, 21, 33, 60), (19, 20, 21, 60)])
def test_chunks_do_not_move_an_event(hale, chunks):
    events = [Event(40, WEIGHT, 0.0), Event(20, WEIGHT, 100.0), Event(0, WEIGHT, 1.0)]
    whole, _ = flown(hale, events, additions=[MASS])
    np.testing.assert_array_equal(flown(hale, events, chunks=chunks, additions=[MASS])[0], whole)


def test_events_act_between_the_frames_of_finer_steps(hale):
    quiet, _ = flown(hale, [], substeps=3)
    told, _ = flown(hale, [Event(20, WEIGHT, 100.0)], substeps=3, additions=[MASS])
    np.testing.assert_array_equal(told[:21], quiet[:21])
    assert np.any(told[21] != quiet[21])


def test_events_of_one_row_are_written_in_their_order_and_may_copy_a_property(hale):
    events = [Event(5, WEIGHT, 3.0), Event(5, "fcs/steer-cmd-norm", WEIGHT), Event(5, WEIGHT, 4.0)]
    _, fdm = flown(hale, events, additions=[MASS])
    assert fdm["fcs/steer-cmd-norm"] == pytest.approx(3.0, rel=1e-12)
    assert fdm[WEIGHT] == pytest.approx(4.0, rel=1e-12)


def test_an_event_on_what_does_not_exist_is_an_error(hale):
    with pytest.raises(KeyError, match="no/such"):
        jsbsim_plant(hale, told=[Told((Event(1, "no/such", 0.0),))])


@pytest.mark.parametrize("rate", [200.0, 130.0, 1000.0 / 3.0])
def test_a_window_begins_at_the_same_row_as_that_of_a_signal(rate):
    t = np.arange(5000) / rate
    for time in [0.0, 0.005, 1.0, 1.2345, 7.0, *t[::97], *np.nextafter(t[1::97], 9.0), *np.nextafter(t[1::97], 0.0)]:
        assert row_at(time, rate) == np.searchsorted(t, time)


@pytest.mark.parametrize("time", [1e16, 1e25, 1.7e308])
def test_a_time_beyond_every_row_is_never(time):
    # 7.3 Hz: the double nearest to a row would be searched for, one row after the other; 1.7e308 s has no row at all
    assert row_at(time, 7.3) == row_at(time, 1e4) == 2**53


@pytest.mark.parametrize(
    ("section", "expected"),
    [
        ("<mass_balance><a/></mass_balance>", "<mass_balance><a/><x/><y/></mass_balance>"),
        ("<mass_balance/>", "<mass_balance><x/><y/></mass_balance>"),
        ("", "<mass_balance><x/><y/></mass_balance>"),
    ],
)
def test_additions_stand_last_in_their_section(section, expected):
    xml = f"<fdm_config>{section}</fdm_config>".encode()
    added = edited(xml, moment=False, additions=[Addition("mass_balance", "<x/>"), Addition("mass_balance", "<y/>")])
    assert added.decode() == f"<fdm_config>{expected}</fdm_config>"


@pytest.mark.parametrize("section", ["", "<external_reactions/>", "<external_reactions><a/></external_reactions>"])
def test_an_addition_and_the_moment_share_a_section(section):
    xml = f"<fdm_config>{section}</fdm_config>".encode()
    text = edited(xml, moment=True, additions=[Addition("external_reactions", "<force/>")]).decode()
    assert text.count("<external_reactions>") == 1
    assert text.endswith("<force/></external_reactions></fdm_config>")
    assert text.index("uavftc-disturbance") < text.index("<force/>")
