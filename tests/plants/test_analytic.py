"""The analytic plant against eq. (7): order of the integration, linear response, a change inside a sample, inputs."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import expm

from flying import bare, given_of
from uavftc.actuators import delay
from uavftc.control import allocation
from uavftc.core.program import Program
from uavftc.core.signals import as_records, empty_rows
from uavftc.plants.analytic import AnalyticPlant
from uavftc.plants.interface import Timing

HALE_J = np.array([[52723.0, 0.0, -8435.0], [0.0, 6314.0, 0.0], [-8435.0, 0.0, 58771.0]])
BALL_J = 1000.0 * np.eye(3)  # no gyroscopic coupling: x2 obeys a linear equation exactly
A_L = np.array([[-8.5, 1.2, -3.5], [-1.5, -1.5, -1.0], [-0.02, 0.0, -2.0]])
B_M = np.array([[10.0, 0.0, 0.225], [0.0, 7.5, 0.0], [1.125, 0.0, 6.75]])
ZERO = np.zeros((3, 3))


def fly(samples, *, J=HALE_J, A=A_L, B=B_M, h=0.05, substeps=1, x1=(0, 0, 0), x2=(0, 0, 0), **inputs):
    """Return the records of `samples` + 1 rows; inputs are arrays (3,) or (samples + 1, 3) of row fields."""
    plant = AnalyticPlant(J, A, B, Timing(h, substeps))
    plant._state["x1"], plant._state["x2"] = x1, x2
    rows = empty_rows(samples + 1)
    records = as_records(rows)
    for field, value in inputs.items():
        records[field] = value
    plant.run(bare(plant), rows, 0, len(rows))
    return records


def late(commands, part, *, J=HALE_J, h=0.05, substeps=32, x1=(0, 0, 0), x2=(0, 0, 0), **inputs):
    """Return the records of a flight whose commands, one a row, reach the surfaces `part` of a sample later."""
    timing = Timing(h, substeps)
    plant = AnalyticPlant(J, A_L, B_M, timing)
    plant._state["x1"], plant._state["x2"] = x1, x2
    given = given_of(timing, len(commands))
    allocate, gather = allocation.blocks(given)
    actuators = delay.blocks(delay.Config(delay_s=part * h), given)
    rows = empty_rows(len(commands))
    records = as_records(rows)
    records["v2"] = commands
    for field, value in inputs.items():
        records[field] = value
    program = Program(plant.before(), [allocate, *actuators, gather, *plant.after()], substeps=substeps)
    plant.run(program, rows, 0, len(rows))
    return records


def eq7(x, *, J, A, B, u2, d1, d2):
    """Return the derivative of [x1, x2] by eqs. (1), (2) in vector form and (7), written here once more."""
    (phi, theta, _), w = x[:3], x[3:]
    g1 = np.array(
        [
            [1.0, np.sin(phi) * np.tan(theta), np.cos(phi) * np.tan(theta)],
            [0.0, np.cos(phi), -np.sin(phi)],
            [0.0, np.sin(phi) / np.cos(theta), np.cos(phi) / np.cos(theta)],
        ]
    )
    return np.concatenate([g1 @ w + d1, np.linalg.solve(J, -np.cross(w, J @ w)) + A @ w + B @ u2 + d2])


def exact(x, seconds, **inputs):
    """Return the state after `seconds` under constant inputs, by a method of order 8."""
    given = {"J": HALE_J, "A": A_L, "B": B_M, "u2": np.zeros(3), "d1": np.zeros(3), "d2": np.zeros(3)} | inputs
    solution = solve_ivp(lambda _t, x: eq7(x, **given), (0.0, seconds), x, method="DOP853", rtol=1e-13, atol=1e-15)
    return solution.y[:, -1]


def held(A, B, h):
    """Return (Ad, Bd): x(t + h) = Ad x(t) + Bd u for an input held over h."""
    block = expm(h * np.block([[A, B], [np.zeros((3, 6))]]))
    return block[:3, :3], block[:3, 3:]


START = {"x1": (0.3, 0.2, -0.4), "x2": (0.8, -0.6, 0.5)}
LOADS = {"u2": (0.05, -0.04, 0.03), "d1": (0.02, -0.01, 0.03), "d2": (0.1, 0.2, -0.3)}


def test_order_of_convergence_is_four():
    # Given a nonlinear flight of 1 s, halving the step divides the error by 2^4: the classical rule is whole.
    x0 = np.concatenate([START["x1"], START["x2"]])
    reference = exact(x0, 1.0, **{k: np.array(v) for k, v in LOADS.items()})
    errors = []
    for substeps in (1, 2, 4, 8):
        last = fly(20, substeps=substeps, **START, **LOADS)[-1]
        errors.append(np.max(np.abs(np.concatenate([last["x1"], last["x2"]]) - reference)))
    orders = np.log2(np.divide(errors[:-1], errors[1:]))
    np.testing.assert_allclose(orders, 4.0, atol=0.25)
    assert errors[-1] < 1e-7


def test_agrees_with_an_eighth_order_method_at_the_flown_step():
    # At the 5 ms of a flight the integration error over 1 s is far below anything a metric shows.
    x0 = np.concatenate([START["x1"], START["x2"]])
    last = fly(200, h=0.005, **START, **LOADS)[-1]
    reference = exact(x0, 1.0, **{k: np.array(v) for k, v in LOADS.items()})
    np.testing.assert_allclose(np.concatenate([last["x1"], last["x2"]]), reference, atol=1e-9)


def test_rates_of_a_ball_follow_the_matrix_exponential():
    # Given a body without gyroscopic coupling, x2 is linear: each row of a flight under changing inputs is Ad x + Bd u.
    rng = np.random.default_rng(3)
    u2 = rng.uniform(-0.1, 0.1, (41, 3))
    x2_0 = np.array([0.4, -0.3, 0.2])
    records = fly(40, J=BALL_J, h=0.02, substeps=16, x2=x2_0, u2=u2)
    Ad, Bd = held(A_L, B_M, 0.02)
    x2 = x2_0
    for k in range(41):
        np.testing.assert_allclose(records["x2"][k], x2, atol=1e-10)
        x2 = Ad @ x2 + Bd @ u2[k]


def test_small_motions_of_hale_are_linear():
    # For rates of 1e-7 rad/s the gyroscopic part is below rounding of the result: expm in six states, attitude too.
    scale = 1e-7
    x2_0 = scale * np.array([1.0, -2.0, 3.0])
    last = fly(100, h=0.02, substeps=16, x2=x2_0)[-1]
    full = np.block([[ZERO, np.eye(3)], [ZERO, A_L]])
    expected = expm(2.0 * full) @ np.concatenate([np.zeros(3), x2_0])
    np.testing.assert_allclose(np.concatenate([last["x1"], last["x2"]]), expected, atol=1e-6 * scale)


COMMANDS = np.array([[0.1, 0.05, -0.1], [-0.1, 0.02, 0.1], [0.0, 0.0, 0.0]])


@pytest.mark.parametrize("part", [0.0, 0.25, 0.375, 0.96875, 1.0])
def test_a_delay_that_falls_on_plant_steps_splits_the_sample_exactly(part):
    # A command that changes at t_k + f h is flown as two pieces; a mean command in its place would be 1e-4 off.
    h, (one, two, _) = 0.05, COMMANDS
    records = late(COMMANDS, part, J=BALL_J)
    first, second = held(A_L, B_M, part * h), held(A_L, B_M, (1 - part) * h)
    x2 = second[1] @ one
    np.testing.assert_allclose(records["x2"][1], x2, atol=1e-12)
    expected = second[0] @ (first[0] @ x2 + first[1] @ one) + second[1] @ two
    np.testing.assert_allclose(records["x2"][2], expected, atol=1e-12)
    whole = held(A_L, B_M, h)
    mean = whole[0] @ x2 + whole[1] @ (part * one + (1 - part) * two)
    if 0.0 < part < 0.9:
        assert np.max(np.abs(mean - expected)) > 1e-4


def test_a_delay_inside_a_sample_is_exact_for_the_nonlinear_model():
    # The attitude passes the change too: two pieces of an eighth-order integration, with the disturbances held.
    h, part, (one, two, _) = 0.05, 0.625, COMMANDS
    loads = {k: np.array(LOADS[k]) for k in ("d1", "d2")}
    records = late(COMMANDS, part, **START, **loads)
    x = np.concatenate([START["x1"], START["x2"]])
    for u2, seconds in ((0.0 * one, part * h), (one, (1 - part) * h), (one, part * h), (two, (1 - part) * h)):
        x = exact(x, seconds, u2=u2, **loads)
    np.testing.assert_allclose(np.concatenate([records["x1"][2], records["x2"][2]]), x, atol=1e-11)


def test_a_delay_that_falls_between_plant_steps_is_off_by_one_step_squared():
    # Over the one step in which the command changes the surface stands at the mean of both: the impulse is right, and
    # what is left is |A B du| dt^2 / 8 a change.
    h, part, substeps, (one, two, _) = 0.05, 0.37, 32, COMMANDS
    records = late(COMMANDS, part, J=BALL_J, substeps=substeps)
    first, second = held(A_L, B_M, part * h), held(A_L, B_M, (1 - part) * h)
    expected = second[0] @ (first[0] @ (second[1] @ one) + first[1] @ one) + second[1] @ two
    found = np.abs(records["x2"][2] - expected)
    bound = (np.abs(A_L) @ np.abs(B_M) @ (np.abs(one) + np.abs(two - one))) * (h / substeps) ** 2 / 8.0
    assert np.all(found <= bound)
    assert np.max(found) > 1e-8  # it is not exact, so the bound says something


def test_the_row_holds_the_deflection_from_its_own_instant_on():
    # What a row publishes as u2 is flown from t_k on, also where the command changes within the sample.
    records = late(COMMANDS, 0.25)
    np.testing.assert_array_equal(records["u2"], [np.zeros(3), COMMANDS[0], COMMANDS[1]])
    np.testing.assert_array_equal(records["effectors"]["deflection"], records["u2"])
    np.testing.assert_array_equal(records["effectors"]["command"], COMMANDS)


def test_d1_adds_to_the_attitude_rates():
    # Eq. (7): x1' = g1 x2 + d1. At a banked, pitched attitude without rates, x1 moves by d1 t, not by g1 d1 t.
    d1 = np.array([0.02, -0.03, 0.04])
    records = fly(20, x1=(0.6, 0.5, 0.1), d1=d1)
    np.testing.assert_allclose(records["x1"][20] - (0.6, 0.5, 0.1), d1 * 1.0, atol=1e-14)
    np.testing.assert_array_equal(records["x2"], 0.0)


def test_d2_adds_to_the_angular_accelerations():
    # Eq. (7): x2' = ... + d2, past B_m and past J: without damping one axis spins up by d2 t and no other moves.
    for axis in range(3):
        d2 = 0.3 * np.eye(3)[axis]
        last = fly(20, A=ZERO, J=BALL_J, d2=d2)[-1]
        np.testing.assert_allclose(last["x2"], d2, rtol=1e-14, atol=1e-15)
        np.testing.assert_allclose(last["x1"][axis], 0.15, rtol=1e-12)


def test_inputs_hold_from_their_row_on():
    # A command in row k is the first cause of motion in row k + 1 and of no other row: there is no hidden delay.
    u2 = np.zeros((8, 3))
    u2[3] = 0.1, 0.1, 0.1
    records = fly(7, u2=u2)
    np.testing.assert_array_equal(records["x2"][:4], 0.0)
    assert np.all(np.abs(records["x2"][4]) > 0.01)


def test_slices_fly_as_one():
    # The loop hands over slices of rows; the flight is the same to the bit wherever they are cut.
    whole = fly(30, **START, **LOADS)
    plant = AnalyticPlant(HALE_J, A_L, B_M, Timing(0.05, 1))
    plant._state["x1"], plant._state["x2"] = START["x1"], START["x2"]
    rows = empty_rows(31)
    records = as_records(rows)
    for field, value in LOADS.items():
        records[field] = value
    program = bare(plant)
    for first, last in ((0, 1), (1, 13), (13, 31)):
        assert plant.run(program, rows, first, last) == last
    assert records.tobytes() == whole.tobytes()


def test_air_data_is_not_a_number():
    # A rotational model has no airspeed: the row says so, instead of a zero that would pass for a measurement.
    records = fly(2)
    for field in ("airspeed", "altitude", "height", "alpha", "beta", "throttle", "wind_n"):
        assert np.all(np.isnan(records[field])), field
