"""The environments for learning: the rules of the two libraries, and our own."""

import inspect
import subprocess
import sys
from functools import partial
from multiprocessing.reduction import ForkingPickler
from typing import Any

import gymnasium
import numpy as np
import pytest
import shapely
from gymnasium.utils.env_checker import check_env
from pettingzoo.test import parallel_api_test, parallel_seed_test

import multisrt as ms
from multisrt.environments.environment import Environment
from multisrt.envs import (
    ENV_ID,
    AreaReward,
    DecisionSpec,
    parallel_env,
    policy_strategy,
    single_env,
)
from multisrt.envs.missions import KEYWORDS
from multisrt.geometry.errors import InvalidInputError
from multisrt.robots.registry import registered

HALL = Environment("hall", shapely.box(0, 0, 16, 3), starts=[(8, 1.5)])
"""A robot in the middle sees 4 m to either side, and so two frontiers."""

FEW = DecisionSpec(observe=("frontiers",), frontiers=4)
PLACES = DecisionSpec(actions="place", observe=())

DECISIONS = [DecisionSpec(map_cells=8), PLACES]


def play(env, seed=1, choose=lambda number: 0):
    """Play a mission of a team; return what each step gave."""
    env.reset(seed=seed)
    steps: list[Any] = []
    while env.agents:
        steps.append(env.step(dict.fromkeys(env.agents, choose(len(steps)))))
    return steps


def play_alone(env, seed=1, action=0):
    env.reset(seed=seed)
    steps: list[Any] = []
    while not steps or not (steps[-1][2] or steps[-1][3]):
        steps.append(env.step(action))
    return steps


# The rules of the libraries ----------------------------------------------------------------


@pytest.mark.parametrize("decision", DECISIONS, ids=["frontier", "place"])
def test_gymnasium_finds_nothing_wrong(decision):
    env = gymnasium.make(ENV_ID, environment=HALL, decision=decision, range_m=4.0)
    check_env(env.unwrapped)


@pytest.mark.parametrize("decision", DECISIONS, ids=["frontier", "place"])
def test_pettingzoo_finds_nothing_wrong(decision):
    make = partial(parallel_env, HALL, decision=decision, robots=2, range_m=3.0, max_time_s=60.0)
    parallel_api_test(make(), num_cycles=200)
    parallel_seed_test(make)


@pytest.mark.slow
def test_random_actions_keep_to_the_spaces():
    env = parallel_env("open", robots=2, max_time_s=100.0, decision=DecisionSpec(map_cells=16))
    observations, _ = env.reset(seed=3)
    for number, agent in enumerate(env.possible_agents):
        env.action_space(agent).seed(number)
    while env.agents:
        assert all(observations[a] in env.observation_space(a) for a in env.agents)
        chosen = {a: env.action_space(a).sample(observations[a]["action_mask"]) for a in env.agents}
        observations, _, _, _, infos = env.step(chosen)
        assert all(info["valid"] for info in infos.values())
    assert env.state() in env.state_space


@pytest.mark.slow
def test_worlds_are_explored_side_by_side_in_processes():
    envs = gymnasium.make_vec(
        ENV_ID,
        num_envs=2,
        vectorization_mode="async",
        vector_kwargs={"context": "spawn"},
        environment="open",
        decision=FEW,
        max_time_s=50.0,
    )
    try:
        observations, _ = envs.reset(seed=1)
        assert observations["frontiers"].shape == (2, 4, 4)
        _, rewards, _, _, _ = envs.step(np.zeros(2, np.int64))
    finally:
        envs.close()
    for seed, reward in zip((1, 2), rewards.tolist(), strict=True):
        env = single_env("open", decision=FEW, max_time_s=50.0)
        env.reset(seed=seed)
        assert env.step(0)[1] == reward


def test_what_makes_an_environment_can_be_pickled():
    make = partial(single_env, HALL, decision=FEW, reward=AreaReward(area="own"))
    env = ForkingPickler.loads(ForkingPickler.dumps(make))()
    env.reset(seed=1)
    assert env.run.spec.seed == 1


# A mission ---------------------------------------------------------------------------------


@pytest.mark.slow
def test_the_nearest_frontier_explores_the_apartment():
    env = single_env("apartment", decision=DecisionSpec(observe=()))
    steps = play_alone(env)
    assert steps[-1][2]
    assert env.run.outcome == "complete"
    assert env.run.metrics.coverage >= 0.95


@pytest.mark.parametrize("robots", [1, 2])
def test_a_policy_outside_makes_the_run_of_one_inside(robots):
    keywords = {"robots": robots, "range_m": 3.0}
    env = parallel_env(HALL, decision=FEW, **keywords)
    play(env)
    with registered(policy_strategy("policy", lambda seen: 0, FEW)):
        run = ms.explore(HALL, strategy="policy", seed=1, **keywords)
    assert env.run.digest == run.digest


def test_equal_seeds_and_actions_give_equal_bytes(tmp_path):
    def saved(name):
        env = parallel_env(HALL, decision=FEW, robots=2, range_m=3.0)
        play(env, seed=5, choose=lambda number: number % 3)
        env.recording.save(tmp_path / name)
        return (tmp_path / name).read_bytes()

    assert saved("first") == saved("second")


def test_rewards_add_up_to_what_is_measured():
    env = parallel_env(HALL, decision=FEW, robots=2, range_m=3.0)
    _, infos = env.reset(seed=1)
    first_m2 = infos["robot_0"]["seen_m2"]
    steps = play(env)
    metrics = env.run.metrics
    seen_m2 = first_m2 + sum(step[1]["robot_0"] for step in steps)
    # Areas of metrics are summed over strips, and so not exact to rounding.
    assert seen_m2 == pytest.approx(metrics.coverage * 48.0, rel=2e-6)
    assert seen_m2 == pytest.approx(steps[-1][4]["robot_0"]["seen_m2"])

    own = parallel_env(HALL, decision=FEW, robots=2, range_m=3.0, reward=AreaReward(area="own"))
    shares = play(own)
    assert sum(sum(step[1].values()) for step in shares) == pytest.approx(seen_m2 - first_m2)


def test_costs_add_up_to_time_and_distance():
    gains = []

    def reward(gain):
        gains.append(gain)
        return 0.0

    env = parallel_env(HALL, decision=FEW, robots=2, range_m=3.0, reward=reward)
    play(env)
    metrics = env.run.metrics
    for robot in range(2):
        own = [gain for gain in gains if gain.robot == robot]
        assert sum(g.distance_m for g in own) == pytest.approx(metrics.distance_by_robot_m[robot])
    # The time before the first decision is in no step.
    first_s = min(choice.time_s for choice in env.recording.of(ms.events.GoalChosen))
    assert sum(g.time_s for g in own) == pytest.approx(env.recording.footer.time_s - first_s)


def test_one_robot_decides_and_the_others_go_on():
    env = parallel_env(HALL, decision=FEW, robots=3, range_m=3.0)
    observations, infos = env.reset(seed=1)
    while env.agents:
        deciding = [a for a in env.agents if infos[a]["decides"]]
        assert len(deciding) == 1
        for agent in env.agents:
            mask = observations[agent]["action_mask"].tolist()
            assert (mask == [0, 0, 0, 0, 1]) == (agent not in deciding)
        # What the others are told to do is not looked at.
        observations, _, terminated, truncated, infos = env.step(
            {a: 0 if a in deciding else -7 for a in env.agents}
        )
    assert all(terminated.values())
    assert not any(truncated.values())
    assert infos["robot_0"]["outcome"] == env.run.outcome == "complete"


def test_the_robot_that_asks_needs_an_action():
    env = parallel_env(HALL, decision=FEW, robots=2, range_m=3.0)
    env.reset(seed=1)
    with pytest.raises(ms.InvalidInputError, match="robot_0 asks where to go"):
        env.step({"robot_1": 0})


def test_after_the_end_there_is_no_step():
    alone = single_env(HALL, decision=FEW, range_m=4.0)
    play_alone(alone)
    team = parallel_env(HALL, decision=FEW, robots=2, range_m=3.0)
    play(team)
    for step_on in (lambda: alone.step(0), lambda: team.step({"robot_0": 0, "robot_1": 0})):
        with pytest.raises(ms.InvalidInputError, match="the mission is over"):
            step_on()


def test_an_action_that_cannot_be_followed_is_told():
    env = single_env(HALL, decision=FEW, range_m=4.0)
    _, info = env.reset(seed=1)
    assert info["valid"]
    assert not env.step(3)[4]["valid"]
    env.reset(seed=1)
    assert env.step(1)[4]["valid"]


def test_the_stop_rule_truncates():
    env = parallel_env(HALL, decision=FEW, robots=2, range_m=3.0, max_time_s=3.0)
    *_, terminated, truncated, infos = play(env)[-1]
    assert truncated == {"robot_0": True, "robot_1": True}
    assert not any(terminated.values())
    assert infos["robot_0"]["outcome"] == "out_of_time"
    assert env.recording.footer.time_s == 3.0


@pytest.mark.slow
def test_a_mission_is_over_at_the_coverage_asked_for():
    whole = len(play_alone(single_env("open", decision=FEW)))
    env = single_env("open", decision=FEW, end_coverage=0.5)
    steps = play_alone(env)
    assert steps[-1][2]
    assert steps[-1][4]["outcome"] == "covered"
    assert 0.5 <= env.run.metrics.coverage < 0.7
    assert len(steps) < whole


def test_a_robot_that_dies_is_no_agent_any_more():
    faults = [ms.Death(robot=1, time_s=2.0)]
    env = parallel_env(HALL, decision=FEW, robots=2, range_m=3.0, faults=faults)
    steps = play(env)
    ended = [step[2]["robot_1"] for step in steps if "robot_1" in step[2]]
    assert ended[-1]
    assert not any(ended[:-1])
    assert len(steps) > len(ended)


def test_a_robot_that_starts_late_observes_nothing_before():
    faults = [ms.LateStart(robot=1, time_s=5.0)]
    env = parallel_env(HALL, decision=FEW, robots=2, range_m=3.0, faults=faults)
    observations, _ = env.reset(seed=1)
    assert not observations["robot_1"]["pose"].any()
    steps = play(env)
    times = [s[0]["robot_1"]["time"][0] for s in steps if s[4]["robot_1"]["decides"]]
    assert times
    assert min(times) >= 5.0


def test_a_mission_can_be_over_before_any_decision():
    room = Environment("room", shapely.box(0, 0, 3, 3), starts=[(1, 1)])
    env = single_env(room, decision=FEW)
    observation, info = env.reset(seed=1)
    assert observation["action_mask"].tolist() == [0, 0, 0, 0, 1]
    assert info["seen_m2"] == pytest.approx(9.0)
    _, reward, terminated, _, _ = env.step(4)
    assert (reward, terminated) == (0.0, True)


def test_observations_are_new_arrays():
    env = single_env(HALL, decision=FEW, range_m=4.0)
    first, _ = env.reset(seed=1)
    kept = {name: part.copy() for name, part in first.items()}
    for part in first.values():
        part[...] = 1
    env.reset(seed=1)
    again, _ = env.reset(seed=1)
    assert all((again[name] == kept[name]).all() for name in kept)


# Worlds and seeds --------------------------------------------------------------------------


def test_a_seed_determines_the_world_and_what_follows():
    def worlds(env, first):
        env.reset(seed=first)
        specs = [env.run.spec]
        for _ in range(3):
            env.reset()
            specs.append(env.run.spec)
        return specs

    make = partial(single_env, ["open", "rooms"], decision=FEW, world_seeds=range(50))
    once = worlds(make(), 7)
    assert once[0].seed == 7
    assert worlds(make(), 7) == once
    assert len({spec.seed for spec in once}) == 4
    assert len({spec.environment.seed for spec in once}) > 1
    env = make()
    drawn = {(env.reset(seed=k), env.run.environment.name)[1] for k in range(10)}
    assert drawn == {"open", "rooms"}


def test_without_a_seed_missions_follow_from_that_of_the_spec():
    def seeds(seed):
        env = parallel_env(HALL, decision=FEW, robots=2, seed=seed)
        return [(env.reset(), env.run.spec.seed)[1] for _ in range(3)]

    assert seeds(4) == seeds(4)
    assert seeds(4) != seeds(5)


def test_environments_without_any_seed_begin_missions_of_their_own():
    """Two of eight draws of 31 bits are equal once in 10^8 times."""
    alone: list[Any] = [single_env(HALL, decision=FEW) for _ in range(2)]
    teams: list[Any] = [parallel_env(HALL, decision=FEW, robots=2) for _ in range(2)]
    seeds = [(env.reset(), env.run.spec.seed)[1] for env in alone + teams for _ in range(2)]
    assert len(set(seeds)) == len(seeds)


def test_vectors_without_a_seed_begin_missions_of_their_own():
    envs: Any = gymnasium.make_vec(
        ENV_ID, num_envs=3, vectorization_mode="sync", environment=HALL, decision=FEW
    )
    envs.reset()
    seeds = {run.spec.seed for run in envs.get_attr("run")}
    assert len(seeds) == 3


def test_a_seed_from_entropy_can_be_told_and_repeated():
    env = single_env(["open", "rooms"], decision=FEW, world_seeds=range(50))
    env.reset()
    spec = env.run.spec
    again = single_env(["open", "rooms"], decision=FEW, world_seeds=range(50))
    again.reset(seed=1)
    again.np_random = np.random.default_rng(env.np_random_seed)
    again.reset()
    assert again.run.spec == spec


def test_a_spec_fixes_the_missions_by_its_seed():
    spec = ms.RunSpec(environment=ms.CatalogEnvironment(name="open"))
    first, second = (single_env(spec, decision=FEW) for _ in range(2))
    first.reset()
    second.reset()
    assert first.run.spec == second.run.spec


def test_a_spec_can_be_given_for_its_team_and_world():
    spec = ms.RunSpec(
        environment=ms.CatalogEnvironment(name="open"),
        strategy="minpos",
        robots=(ms.RobotSpec(), ms.RobotSpec(footprint="box:0.6x0.4")),
        seed=3,
    )
    env = parallel_env(spec, decision=FEW)
    env.reset(seed=9)
    run = env.run
    assert run.spec.robots == spec.robots
    assert (run.spec.seed, run.spec.strategy) == (9, "policy")


@pytest.mark.parametrize(
    ("make", "told"),
    [
        (partial(single_env, HALL, strategy="minpos"), "leave out strategy, which is 'minpos'"),
        (partial(single_env, HALL, robot=2), "takes no 'robot' .did you mean 'robots'"),
        (partial(single_env, HALL, robots=2), "use multisrt.envs.parallel_env for a team"),
        (partial(single_env, []), "the sequence has none"),
        (partial(single_env, "opem"), "did you mean 'open'"),
        (partial(single_env, "museum", world_seeds=[1]), "'museum' is fixed"),
        (partial(single_env, HALL, world_seeds=[1]), "for generators of the catalogue"),
        (partial(single_env, "open", world_seeds=[]), "world_seeds has no seed"),
        (partial(single_env, HALL, end_coverage=95), "end_coverage is a share"),
        (partial(single_env, HALL, render_mode="human"), "render_mode is rgb_array or None"),
        (partial(parallel_env, HALL, state_cells=0), "state_cells is a whole number"),
    ],
)
def test_what_cannot_be_is_refused(make, told):
    with pytest.raises(ms.InvalidInputError, match=told):
        make()


def test_a_spec_leaves_no_room_for_keywords():
    spec = ms.RunSpec(environment=ms.CatalogEnvironment(name="open"))
    with pytest.raises(ms.InvalidInputError, match="with it, leave out seed"):
        single_env(spec, seed=1)


def test_options_of_another_strategy_are_refused():
    with pytest.raises(ms.InvalidInputError, match="no option 'beta'"):
        single_env(HALL, options={"cones": 8, "beta": 2.0})


def test_a_step_before_the_first_mission_is_refused():
    with pytest.raises(ms.InvalidInputError, match="call reset first"):
        single_env(HALL).step(0)


def test_the_keywords_are_those_of_explore():
    known = set(inspect.signature(ms.explore).parameters)
    assert {"strategy", *KEYWORDS} == known - {"environment", "recording_path", "watch", "progress"}


# What looks at the truth -------------------------------------------------------------------


def test_the_state_shows_what_the_team_has_seen():
    env = parallel_env(HALL, decision=FEW, robots=2, range_m=3.0, state_cells=32)
    env.reset(seed=1)
    seen, free, robots = env.state()
    # The hall of 16 m x 3 m fills 6 of 32 rows.
    assert free.sum() == 32 * 6
    assert free[:6].all()
    assert robots.sum() == 2
    assert (seen <= free).all()
    assert 0 < seen.sum() < free.sum()
    play(env)
    assert env.state()[0].sum() == pytest.approx(free.sum(), abs=4)


def test_a_picture_shows_walls_and_robots():
    env = single_env(HALL, decision=FEW, range_m=4.0, render_mode="rgb_array")
    env.reset(seed=1)
    picture = env.render()
    assert picture is not None
    assert picture.shape == (384, 384, 3)
    colours = {tuple(c) for c in picture.reshape(-1, 3).tolist()}
    assert colours == {(40, 40, 40), (170, 170, 170), (255, 255, 255), (0, 0x72, 0xB2)}
    # The hall is at the foot of the picture, as y points up.
    assert tuple(picture[0, 0].tolist()) == (40, 40, 40)
    assert tuple(picture[-10, 10].tolist()) == (170, 170, 170)
    with pytest.warns(
        UserWarning, match='without specifying any render mode: give render_mode="rgb_'
    ):
        assert single_env(HALL).render() is None


def test_environments_tell_their_worlds_and_team():
    assert repr(single_env("apartment", seed=3)) == "ExploreEnv('apartment', robots=1, seed=3)"
    team = parallel_env(["rooms", "maze"], robots=2)
    assert repr(team) == "ExploreParallelEnv('rooms' and 1 more, robots=2)"


def test_without_the_extra_the_import_says_what_to_install():
    code = (
        "import sys; sys.modules['pettingzoo'] = None\n"
        "try:\n    import multisrt.envs\n"
        "except ImportError as error:\n    print(error)"
    )
    told = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert "pettingzoo, which is not installed: pip install 'multisrt[learn]'" in told.stdout


@pytest.mark.parametrize("wrong", [99.5, "x", float("nan"), None])
def test_a_wrong_action_changes_nothing(wrong):
    env = single_env("apartment", decision=DecisionSpec(observe=()))
    env.reset(seed=1)
    with pytest.raises(InvalidInputError, match="the number of a frontier is a whole number"):
        env.step(wrong)
    _, _, terminated, truncated, info = env.step(0)
    assert (terminated, truncated, info["decides"]) == (False, False, True)
    assert info["time_s"] > 0.0


def test_three_numbers_are_no_place():
    env = single_env("apartment", decision=DecisionSpec(actions="place", observe=()))
    env.reset(seed=1)
    with pytest.raises(InvalidInputError, match="two numbers from -1 to 1"):
        env.step([0.0, 1.0, 0.0])
    assert env.step([0.0, 1.0])[4]["decides"]


def test_no_step_follows_the_end_of_an_episode():
    env = single_env("apartment", decision=DecisionSpec(observe=()), max_time_s=5.0)
    env.reset(seed=1)
    while not env.step(0)[3]:
        pass
    with pytest.raises(InvalidInputError, match="call reset first"):
        env.step(0)
    env.reset(seed=1)
    env.close()
    with pytest.raises(InvalidInputError, match="call reset first"):
        env.step(0)


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({"end_coverage": "x"}, "end_coverage is a share"),
        ({"world_seeds": 5}, "world_seeds is a sequence of seeds"),
        ({"world_seeds": [1, "a"]}, "a seed of world_seeds is a whole number"),
        ({"reward": 3}, "reward is a function of a Gain"),
        ({"decision": {}}, "decision is a DecisionSpec"),
        ({"options": {"replan": "nwes"}}, "did you mean 'news'"),
    ],
)
def test_wrong_arguments_are_refused_at_construction(wrong, said):
    with pytest.raises(InvalidInputError, match=said):
        single_env("rooms", **wrong)


@pytest.mark.parametrize("wrong", [1.5, -1, "1"])
def test_a_seed_is_a_whole_number(wrong):
    with pytest.raises(InvalidInputError, match="seed is a whole number from 0"):
        single_env("apartment").reset(seed=wrong)
    with pytest.raises(InvalidInputError, match="seed is a whole number from 0"):
        parallel_env("apartment", robots=2).reset(seed=wrong)
