"""Limits of gangs and of single effectors, about trim, and what an axis may be commanded within them."""

from __future__ import annotations

import numpy as np
from pydantic import TypeAdapter

from uavftc.actuators import saturation
from uavftc.aircraft.effectors import mixing_of
from uavftc.core.layout import targets_of

NAMES = ("left", "right", "elevator", "rudder")
GANGS = {"aileron": {"left": 1.0, "right": -1.0}, "elevator": {"elevator": -1.0}, "rudder": {"rudder": 2.0}}
MIXING = mixing_of(NAMES, GANGS)


def limits(config, names=NAMES, gangs=GANGS):
    checked = TypeAdapter(saturation.Config).validate_python(config)
    return saturation.effector_limits(checked, mixing_of(names, gangs), targets_of(names, gangs))


def test_one_pair_for_all_limits_each_effector_counted_as_its_axis_does():
    # the paper's -0.05 to 0.1 rad is of the aileron that rolls right: on the right wing that is -0.1 to 0.05
    table = limits({"min_rad": -0.05, "max_rad": 0.1})
    np.testing.assert_array_equal(table, [[-0.05, 0.1], [-0.1, 0.05], [-0.1, 0.05], [-0.05, 0.1]])
    np.testing.assert_array_equal(saturation.axis_limits(table, MIXING)[:2], [[-0.05, 0.1]] * 2)


def test_limits_of_a_gang_are_those_of_its_members_times_their_weights():
    table = limits({"aileron": {"min_rad": -0.05, "max_rad": 0.1}, "rudder": {"min_rad": -0.2, "max_rad": 0.3}})
    free = [-np.inf, np.inf]
    np.testing.assert_array_equal(table, [[-0.05, 0.1], [-0.1, 0.05], free, [-0.4, 0.6]])
    np.testing.assert_array_equal(saturation.axis_limits(table, MIXING), [[-0.05, 0.1], free, [-0.2, 0.3]])


def test_of_several_limits_on_an_effector_the_tightest_act():
    table = limits({"aileron": {"min_rad": -0.05, "max_rad": 0.1}, "right": {"min_rad": -0.02, "max_rad": 0.3}})
    np.testing.assert_array_equal(table[:2], [[-0.05, 0.1], [-0.02, 0.05]])
    # the right one ends the roll to the right first: -0.02 of it is 0.02 of aileron
    np.testing.assert_array_equal(saturation.axis_limits(table, MIXING)[0], [-0.05, 0.02])


def test_an_axis_without_an_effector_has_no_limits():
    table = saturation.axis_limits(np.array([[-0.1, 0.2]]), np.array([[0.0, 1.0, 0.0]]))
    np.testing.assert_array_equal(table, [[-np.inf, np.inf], [-0.1, 0.2], [-np.inf, np.inf]])


def test_each_axis_of_a_v_tail_may_use_what_its_surfaces_have():
    # two surfaces of 0.3 and 0.2 rad of which each moves with elevator and rudder: the smaller one limits both
    mixing = np.array([[0.0, 1.0, 1.0], [0.0, 1.0, -1.0]])
    table = saturation.axis_limits(np.array([[-0.3, 0.3], [-0.1, 0.2]]), mixing)
    np.testing.assert_array_equal(table[1:], [[-0.1, 0.2], [-0.2, 0.1]])
