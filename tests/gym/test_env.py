"""The environment is a flight, its laws and rows to the bit, cut before the agent; gymnasium finds nothing to say."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
import pytest

import uavftc
from uavftc.analysis.requirements import margin_of
from uavftc.errors import InputError
from uavftc.flight.build import build_flight
from uavftc.flight.fly import fly_to_memory
from uavftc.flight.recorder import published
from uavftc.scenario.load import load_scenario

gymnasium = pytest.importorskip("gymnasium")

from gymnasium.utils.env_checker import check_env  # noqa: E402

import uavftc.gym  # noqa: E402 - registers
from uavftc.gym.env import FaultTolerantAttitude  # noqa: E402
from uavftc.gym.look import BOUNDS  # noqa: E402
from uavftc.gym.reward import Margins  # noqa: E402

ID = "uavftc/FaultTolerantAttitude-v0"
SHORT = {"duration_s": 1.0, "requirements": None}
ZERO = np.zeros(3, np.float32)


def episode(env: Any, act: Any = lambda obs: ZERO, **reset: Any) -> tuple[list[np.ndarray], list[float], bool, dict]:
    obs, _ = env.reset(**reset)
    seen, rewards = [obs], []
    while True:
        obs, reward, terminated, truncated, info = env.step(act(obs))
        seen.append(obs)
        rewards.append(reward)
        if terminated or truncated:
            return seen, rewards, terminated, info


@pytest.mark.parametrize("plant", ["jsbsim", "analytic"])
@pytest.mark.parametrize("scenario", ["scenario3", "beyond/sensor-delay"])
def test_an_assistant_that_does_nothing_leaves_the_flight_as_it_is_to_the_bit(plant: str, scenario: str) -> None:
    env = FaultTolerantAttitude(scenario=scenario, mode="assist", plant=plant, set={"duration_s": 2.0})
    episode(env, options={"case": 0})
    flight = build_flight(load_scenario(scenario, plant=plant, set={"duration_s": 2.0}))
    records, _ = fly_to_memory(flight)
    assert len(env.records) == len(records) == 401
    ours, plain = published(env.records, flight.columns), published(records, flight.columns)
    assert [name for name in plain if not np.array_equal(ours[name], plain[name], equal_nan=True)] == []


def test_damage_and_engines_strike_an_episode_as_they_strike_a_flight() -> None:
    # between two rows: where the program is cut, the plant is told at the same frame
    changed = {"duration_s": 1.0, "damage[0].start_s": 0.25, "damage[0].end_s": 0.5}
    env = FaultTolerantAttitude(scenario="damage/left-wing-tip-off", mode="assist", set=changed)
    episode(env, options={"case": 0})
    flight = build_flight(load_scenario("damage/left-wing-tip-off", set=changed))
    plain = published(fly_to_memory(flight)[0], flight.columns)
    ours = published(env.records, flight.columns)
    assert [name for name in plain if not np.array_equal(ours[name], plain[name], equal_nan=True)] == []
    assert np.abs(plain["p_radps"]).max() > 1e-3


def test_an_agent_in_place_of_the_inner_loop_commands_the_surfaces() -> None:
    # full positive aileron is the upper limit, half negative elevator half the lower one: asked and given
    env = FaultTolerantAttitude(scenario="scenario1", set=SHORT)
    episode(env, lambda obs: np.array([1.0, -0.5, 0.0], np.float32))
    limits = env.flight.given.design.limits_rad
    v2 = env.records["v2"]
    assert v2[:, 0].tolist() == [limits[0][1]] * len(v2)
    assert v2[:, 1].tolist() == [0.5 * limits[1][0]] * len(v2)
    assert v2[:, 2].tolist() == [0.0] * len(v2)
    assert env.records["x2"][-1, 0] > 0.0 > env.records["x2"][-1, 1]  # it rolls right and pitches down
    assert "l1" not in env.flight.program.names
    assert "ndi" in env.flight.program.names  # the outer loop stays, and its command is seen


def test_the_dense_reward_is_the_worst_margin_of_the_verdicts_own_formulas() -> None:
    # at each sample, by the recorder of the verdict in one chunk: always over that sample alone
    env = FaultTolerantAttitude(scenario="scenario3", mode="assist", set={"duration_s": 8.0})
    _, rewards, terminated, info = episode(env, options={"case": 0})
    assert not terminated
    flight, records, n = env.flight, env.records, env.flight.steps
    values = {
        (one.name, name): flight.signals[name].make(one.window).take(records)
        for one in flight.requirements for name in one.formula.names
    }  # fmt: skip
    rho = np.full((len(flight.requirements), n + 1), np.inf)
    for i, one in enumerate(flight.requirements):
        last = n if one.last is None else one.last
        found = one.formula.robustness({name: values[one.name, name] for name in one.formula.names}, one.scale)
        rho[i, one.first : last + 1] = found[one.first : last + 1]
    worst = rho.min(axis=0)
    m = np.where(worst >= 0, np.minimum(1, worst), worst / (1 + np.abs(worst)))
    expected = m[:n] / n
    assert rewards[:-1] == pytest.approx(expected[:-1], rel=1e-12, abs=1e-15)
    assert rewards[-1] == pytest.approx(expected[-1] + info["verdict"]["margin"], rel=1e-12)
    fresh = Margins(flight)
    rows = env._rows
    assert [fresh(rows, k, k + 1) for k in range(n)] == pytest.approx(m[:n], rel=1e-12)
    assert Margins(flight)(rows, 0, n) == pytest.approx(m[:n].sum(), rel=1e-12)


def test_the_verdict_at_the_end_is_that_of_the_flight() -> None:
    env = FaultTolerantAttitude(scenario="scenario2", mode="assist", set={"duration_s": 2.0})
    _, _, terminated, info = episode(env, options={"case": 0})
    flight = uavftc.fly("scenario2", set={"duration_s": 2.0})
    assert not terminated
    assert info["verdict"]["margin"] == flight.verdict.margin
    assert info["verdict"]["limiting"] == flight.verdict.limiting


def test_a_vehicle_that_is_lost_terminates_the_episode() -> None:
    # full deflections held turn it over; the last reward carries -1 - (T - t)/T
    env = FaultTolerantAttitude(scenario="scenario1", set={"saturation": None, "duration_s": 20.0})
    seen, rewards, terminated, info = episode(env, lambda obs: np.ones(3, np.float32))
    assert terminated
    lost_at = env.records["t"][-1]
    assert info["verdict"]["outcome"] == "lost"
    assert info["verdict"]["margin"] == pytest.approx(-1 - (20 - lost_at) / 20)
    assert rewards[-1] == pytest.approx(info["verdict"]["margin"], abs=1 / 4000 + 1e-9)
    assert "outside the envelope" in info["ended_because"]
    assert len(seen) == len(env.records)
    with pytest.raises(RuntimeError, match="call reset"):
        env.step(ZERO)


def test_what_is_no_number_ends_it_too() -> None:
    env = FaultTolerantAttitude(scenario="scenario1", set=SHORT)
    env.reset(seed=0)
    obs, _, terminated, _, info = env.step(np.array([np.nan, 0, 0], np.float32))
    assert terminated
    assert info["verdict"]["margin"] == -2.0
    assert np.isfinite(obs).all()


def test_the_same_seed_is_the_same_episode_and_another_is_another() -> None:
    def of(seed: int) -> tuple[bytes, dict[str, Any]]:
        env = FaultTolerantAttitude("paper-faults", set={"duration_s": 12.0}, plant="analytic")
        rng = np.random.default_rng(5)
        actions = rng.uniform(-0.1, 0.1, (300, 3)).astype(np.float32)
        first = env.reset(seed=seed)
        parts = [first[0].tobytes()]
        for action in actions:
            obs, reward, *_ = env.step(action)
            parts += [obs.tobytes(), np.float64(reward).tobytes()]
        return b"".join(parts), first[1]

    one, info = of(3)
    assert of(3) == (one, info)
    assert of(4)[1]["case"] != info["case"]
    assert 0.3 <= info["values"]["faults[0].effectiveness"] <= 1.0


def test_a_case_can_be_chosen_and_is_the_flight_of_the_campaign() -> None:
    from uavftc.jobs.campaign.cases import Cases
    from uavftc.scenario.campaign import load_campaign

    env = FaultTolerantAttitude("paper-faults")
    _, info = env.reset(seed=0, options={"case": 17})
    assert info["case"] == 17
    assert info["values"] == Cases(load_campaign("paper-faults")).values(17)
    assert env.flight.scenario.faults[1].effectiveness.value == info["values"]["faults[1].effectiveness"]


def test_an_action_may_be_held() -> None:
    env = FaultTolerantAttitude(scenario="scenario1", hold=4, set=SHORT, plant="analytic")
    seen, rewards, *_ = episode(env, lambda obs: np.full(3, 0.01, np.float32))
    assert (len(seen), len(rewards), len(env.records)) == (51, 50, 201)
    every = FaultTolerantAttitude(scenario="scenario1", set=SHORT, plant="analytic")
    _, all_of_them, *_ = episode(every, lambda obs: np.full(3, 0.01, np.float32))
    assert sum(rewards) == pytest.approx(sum(all_of_them))


def test_what_is_seen_is_within_its_bounds_and_what_the_controller_is_shown() -> None:
    env = FaultTolerantAttitude(scenario="beyond/sensor-bias", mode="assist", set={"duration_s": 1.0})
    seen, *_ = episode(env, options={"case": 0})
    records = env.records
    assert (np.abs(seen) <= BOUNDS.astype(np.float32)).all()
    at = 150
    assert seen[at][5:8] == pytest.approx(records["x2_meas"][at], rel=1e-6)
    assert (records["x2_meas"][at] != records["x2"][at]).any()
    assert seen[at][8:11] == pytest.approx(records["v1"][at], rel=1e-6)
    limits = env.flight.given.design.limits_rad
    v2 = records["v2"][at]
    assert seen[at][11:14] == pytest.approx(np.where(v2 >= 0, v2 / limits[:, 1], -v2 / limits[:, 0]), rel=1e-6)


@pytest.mark.parametrize("mode", ["replace", "assist"])
def test_gymnasium_finds_nothing_to_say(mode: str) -> None:
    env = gymnasium.make(ID, scenario="scenario1", mode=mode, plant="analytic", set=SHORT)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(env.unwrapped, skip_render_check=True)


def test_it_is_made_by_name_of_its_package() -> None:
    env = gymnasium.make("uavftc.gym:" + ID, scenario="scenario1", plant="analytic", set=SHORT)
    assert env.reset(seed=0)[0].shape == (17,)


def test_vectorised_it_is_the_same_as_alone() -> None:
    given = {"campaign": "paper-faults", "plant": "analytic", "set": {"duration_s": 12.0}}
    many = gymnasium.make_vec(ID, num_envs=2, vectorization_mode="sync", **given)
    obs, _ = many.reset(seed=7)
    after = many.step(np.full((2, 3), 0.01, np.float32))[0]
    many.close()
    for i in range(2):
        env = FaultTolerantAttitude(**given)
        assert env.reset(seed=7 + i)[0].tobytes() == obs[i].tobytes()
        assert env.step(np.full(3, 0.01, np.float32))[0].tobytes() == after[i].tobytes()


@pytest.mark.slow
def test_vectorised_in_processes_it_is_the_same() -> None:
    given = {"campaign": "paper-faults", "set": {"duration_s": 12.0}}
    runs = []
    for how in ("sync", "async"):
        vector = {"context": "spawn"} if how == "async" else {}
        many = gymnasium.make_vec(ID, num_envs=2, vectorization_mode=how, vector_kwargs=vector, **given)
        many.reset(seed=7)
        rows = [many.step(np.full((2, 3), 0.02, np.float32))[:2] for _ in range(20)]
        runs.append(b"".join(part.tobytes() for row in rows for part in row))
        many.close()
    assert runs[0] == runs[1]


def test_what_cannot_be_flown_is_refused_in_words() -> None:
    with pytest.raises(InputError, match="replace or assist"):
        FaultTolerantAttitude(mode="both")
    with pytest.raises(InputError, match="one of the two"):
        FaultTolerantAttitude("paper-faults", "scenario1")
    with pytest.raises(InputError, match="whole number"):
        FaultTolerantAttitude(hold=0)
    with pytest.raises(InputError, match="an inner loop to replace"):
        FaultTolerantAttitude(scenario="scenario1", controller="pid").reset()
    with pytest.raises(InputError, match="0 to 999"):
        FaultTolerantAttitude("paper-faults").reset(options={"case": 1000})


def test_the_examples_fly_a_case_and_a_rate_loop_is_better_than_chance() -> None:
    from examples import gym_agents

    env = FaultTolerantAttitude(scenario="scenario1", plant="analytic", set={"duration_s": 6.0})
    env.action_space.seed(0)
    random, _ = gym_agents.episode(env, lambda obs: env.action_space.sample(), 0)
    scripted, verdict = gym_agents.episode(env, gym_agents.scripted, 0)
    assert scripted > random + 0.5
    assert verdict["outcome"] != "lost"


@pytest.mark.parametrize(
    "formula",
    [
        "abs(phi_deg) <= 60 and not (theta_deg >= 5) or psi_error_deg <= 2*t**2",
        "phi_rad >= -0.1 implies sin(q_radps)/(1 + cos(t)) <= max(0.2, tanh(t), exp(-t))",
        "aileron_cmd_travel_degps <= 30 and elevator_saturated_share <= 0.5 and min(sqrt(t), 2, pi) >= -1",
        "left_aileron_rad <= 0.4 and left_aileron_travel_radps <= 1 and roll_moment_asked_nm <= 1e5",
        "psi_deg <= 3 and psi_meas_deg >= -3 and left_motor_throttle <= 1 and load_factor <= 3.8",
        "1/(phi_rad - phi_rad) <= 2",
    ],
)
def test_the_machine_reads_a_formula_as_the_verdict_does(formula: str) -> None:
    # every operation, every kind of signal, and what is not a number
    asked = [{"name": "one", "always": formula, "scale": 2.0}]
    flight = build_flight(load_scenario("scenario3", set={"duration_s": 1.0, "requirements": asked}))
    records, _ = fly_to_memory(flight)
    rows = np.ascontiguousarray(records.view(float).reshape(len(records), -1))
    (one,) = flight.requirements
    values = {name: flight.signals[name].make(one.window).take(records) for name in one.formula.names}
    rho = np.broadcast_to(one.formula.robustness(values, one.scale), len(records))
    margins = Margins(flight)
    found = [margins(rows, k, k + 1) for k in range(len(records))]
    assert found == pytest.approx([margin_of(float(r)) for r in rho], rel=1e-12, abs=1e-14)


def test_an_action_held_over_samples_is_the_same_flight_on_jsbsim_as_commanded_at_each() -> None:
    held = FaultTolerantAttitude(scenario="scenario3", hold=5, set={"duration_s": 1.0})
    each = FaultTolerantAttitude(scenario="scenario3", set={"duration_s": 1.0})
    for env in (held, each):
        env.reset(options={"case": 0}, seed=0)
    actions = np.random.default_rng(0).uniform(-0.2, 0.2, (40, 3)).astype(np.float32)
    together = sum(held.step(action)[1] for action in actions)
    apart = sum(each.step(action)[1] for action in actions for _ in range(5))
    assert together == pytest.approx(apart, rel=1e-12)
    assert held.records.tobytes() == each.records.tobytes()


def test_positions_that_jsbsim_moves_are_those_of_the_flight_row_by_row() -> None:
    # a Cessna's surfaces are read, and belong to the row before; here each row is flown alone
    given = {"duration_s": 1.0, "saturation": None}
    env = FaultTolerantAttitude(scenario="scenario1", mode="assist", aircraft="jsbsim:c172p", set=given)
    episode(env, options={"case": 0})
    flight = build_flight(load_scenario("scenario1", aircraft="jsbsim:c172p", set=given))
    plain = published(fly_to_memory(flight)[0], flight.columns)
    ours = published(env.records, flight.columns)
    assert [name for name in plain if not np.array_equal(ours[name], plain[name], equal_nan=True)] == []
    assert np.ptp(plain["aileron_rad"]) > 1e-4
