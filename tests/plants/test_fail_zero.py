"""The project's `effectiveness: 0` compared with JSBSim's failure of an actuator, `malfunction/fail_zero`.

c172x has actuators on both ailerons with rate limits and a backlash, the same for both faults: fail_zero replaces the
input of the actuator, effectiveness replaces the command upstream of it. They are not the same fault in two respects.
fail_zero sends the surface to its neutral, effectiveness 0 to the trim, because deflections count from there; and
c172x has an aileron trim of -0.08 against the torque of its propeller. So the comparison is made twice: from a start
with a neutral aileron, where trim and neutral are the same, and from the true trim with a bias from trim to neutral.
Both must be the same motion to rounding, the transient of the actuator included: nothing is left to account for.
"""

from __future__ import annotations

import numpy as np
import pytest

from flying import given_of
from uavftc.actuators import effectiveness, stops
from uavftc.aircraft.definition import load_aircraft
from uavftc.control import allocation
from uavftc.core.program import Program
from uavftc.core.signals import as_records, empty_rows
from uavftc.plants.interface import Timing
from uavftc.plants.jsbsim.model import trimmed_model
from uavftc.plants.jsbsim.plant import JSBSimPlant

FAILED = tuple(f"fcs/{side}-aileron-actuator/malfunction/fail_zero" for side in ("left", "right"))
AILERONS = ("fcs/left-aileron-pos-rad", "fcs/right-aileron-pos-rad")
FAIL_ROW, ROWS = 200, 1201  # 1 s and 6 s, at 200 Hz
BACKLASH = 0.005  # rad, of either actuator
COMMAND = 0.05  # of the aileron, rad


def fly(fault, *, neutral):
    """Fly c172x open loop under a constant aileron; return the records and both ailerons' positions, rad."""
    model = trimmed_model(load_aircraft("jsbsim:c172x"), 55.0, 1500.0)
    to_neutral = -model.trim["surfaces"][0] * model.rad_per_command[0]
    if neutral:
        model = model._replace(trim=model.trim | {"surfaces": [0.0, *model.trim["surfaces"][1:]]})
    timing = Timing(0.005, 1)
    still = {"wind_n": np.zeros(3), "has_wind": False, "has_moment": False}
    plant = JSBSimPlant(load_aircraft("jsbsim:c172x"), model, timing, **still)
    given = given_of(timing, ROWS, plant.u_limits)
    allocate, gather = allocation.blocks(given)
    faulty = effectiveness.blocks((effectiveness.Config(surface="aileron"),), given)
    actuators = [allocate, *faulty, *stops.blocks(None, given), gather]
    program = Program(plant.before(), [*actuators, *plant.after()])
    rows = empty_rows(ROWS)
    records = as_records(rows)
    surfaces = records["effectors"]
    surfaces["effectiveness"] = 1.0
    records["v2"][:, 0] = COMMAND
    if fault.startswith("effectiveness"):
        surfaces["effectiveness"][FAIL_ROW:, 0] = 0.0
    if fault == "effectiveness and bias":
        surfaces["bias"][FAIL_ROW:, 0] = to_neutral
    ailerons = np.empty((ROWS, 2))
    for k in range(ROWS):
        if fault == "fail_zero" and k == FAIL_ROW:
            for name in FAILED:
                plant.fdm[name] = 1
        plant.run(program, rows, k, k + 1)
        ailerons[k] = [plant.fdm[name] for name in AILERONS]
    return records, ailerons


@pytest.mark.parametrize(("fault", "neutral"), [("effectiveness", True), ("effectiveness and bias", False)])
def test_effectiveness_zero_is_jsbsims_fail_zero(fault, neutral):
    # Given the same flight up to 1 s, both faults move the ailerons and the aircraft alike for 5 s: positions, roll
    # rate and bank are equal to rounding (the bias goes through rad and back, hence not asked to the bit).
    theirs, their_ailerons = fly("fail_zero", neutral=neutral)
    ours, our_ailerons = fly(fault, neutral=neutral)
    healthy, _ = fly("none", neutral=neutral)
    np.testing.assert_array_equal(ours["x2"][:FAIL_ROW], theirs["x2"][:FAIL_ROW])
    np.testing.assert_allclose(our_ailerons, their_ailerons, rtol=0, atol=1e-9)
    np.testing.assert_allclose(ours["x2"], theirs["x2"], rtol=0, atol=1e-9)
    np.testing.assert_allclose(ours["x1"], theirs["x1"], rtol=0, atol=1e-9)
    # and it is a fault: the aileron comes back to within its backlash of neutral, and the bank is another
    np.testing.assert_array_less(np.abs(their_ailerons[FAIL_ROW + 100 :]), BACKLASH)
    assert np.min(np.abs(their_ailerons[FAIL_ROW - 1])) > 2.0 * BACKLASH
    assert np.degrees(healthy["x1"][-1, 0] - theirs["x1"][-1, 0]) > 10.0


def test_effectiveness_zero_goes_to_the_trim_and_not_to_neutral():
    # Why the bias is needed: from the true trim the surface that lost its effectiveness stays where the trim has it.
    _, ailerons = fly("effectiveness", neutral=False)
    model = trimmed_model(load_aircraft("jsbsim:c172x"), 55.0, 1500.0)
    at_trim = model.trim["surfaces"][0] * np.radians([20.0, -15.0])  # up to 20 deg up, 15 deg down
    np.testing.assert_allclose(ailerons[-1], at_trim, rtol=0, atol=BACKLASH)
    assert np.min(np.abs(at_trim)) > 2.0 * BACKLASH
