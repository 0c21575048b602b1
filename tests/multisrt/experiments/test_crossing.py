"""Conditions and runs of experiments: their number, order and pairing."""

from itertools import pairwise
from typing import Any

import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st

from multisrt.experiments.crossing import Condition, conditions, key_of, runs
from multisrt.experiments.spec import ExperimentSpec
from multisrt.simulation.starts import starts_of
from multisrt.simulation.worlds import build_environment
from multisrt.spec import CatalogEnvironment, Death, LateStart, RobotSpec, RunSpec, Silence
from tests.multisrt.experiments.small import experiment, refused


def labels(spec: ExperimentSpec, *names: str) -> list[tuple[object, ...]]:
    """Return some labels of each condition, in order."""
    return [tuple(getattr(one, name) for name in names) for one in conditions(spec)]


def test_choices_are_crossed_in_the_order_of_the_file():
    spec = experiment(
        environments=["open", "museum"], strategies=["srt-star", "minpos"], robots=[2, 1]
    )
    assert labels(spec, "environment", "strategy", "robots") == [
        ("open", "srt-star", 2),
        ("open", "srt-star", 1),
        ("open", "minpos", 2),
        ("open", "minpos", 1),
        ("museum", "srt-star", 2),
        ("museum", "srt-star", 1),
        ("museum", "minpos", 2),
        ("museum", "minpos", 1),
    ]


def test_runs_are_ordered_by_repetition():
    spec = experiment(robots=[2, 1], repetitions=3, first_seed=10)
    found = [(run.repetition, run.condition.robots, run.spec.seed) for run in runs(spec)]
    assert found == [(0, 2, 10), (0, 1, 10), (1, 2, 11), (1, 1, 11), (2, 2, 12), (2, 1, 12)]


@given(
    st.lists(st.sampled_from(["open", "museum", "cave"]), min_size=1, unique=True),
    st.lists(st.sampled_from(["srt-star", "minpos"]), min_size=1, unique=True),
    st.lists(st.integers(1, 4), min_size=1, max_size=3, unique=True),
    st.lists(st.sampled_from(["scattered", "clustered"]), min_size=1, unique=True),
    st.lists(st.sampled_from(["disc:0.2", "disc:0.3"]), min_size=1, unique=True),
    st.integers(1, 3),
)
@settings(max_examples=15, deadline=None, phases=[Phase.explicit, Phase.generate])
def test_there_is_one_run_per_condition_and_repetition(
    environments, strategies, robots, starts, bodies, repetitions
):
    spec = experiment(
        environments=environments,
        strategies=strategies,
        robots=robots,
        starts=starts,
        bodies=bodies,
        repetitions=repetitions,
    )
    count = len(environments) * len(strategies) * len(robots) * len(starts) * len(bodies)
    assert len(conditions(spec)) == len(set(conditions(spec))) == count
    planned = runs(spec)
    assert len({run.key for run in planned}) == len(planned) == count * repetitions
    assert [run.key for run in planned] == [key_of(run.spec) for run in planned]
    assert planned == runs(spec)
    for run in planned:
        said = run.spec
        assert (said.strategy, len(said.robots), said.starts) == (
            run.condition.strategy,
            run.condition.robots,
            run.condition.starts,
        )
        assert {robot.footprint for robot in said.robots} == {run.condition.body}


def test_labels_are_those_of_tables():
    spec = experiment(
        environments=[{"name": "open", "label": "hall"}],
        strategies=[{"name": "srt-star", "label": "few cones", "options": {"cones": 6}}],
        robots=[{"label": "pair", "members": [{}, {"footprint": "disc:0.3"}]}],
        starts=[{"how": "clustered", "first": "drawn"}],
        radios=[{"range_m": 12.5}],
        faults=[{"label": "one dies", "deaths": 1}],
    )
    assert conditions(spec) == [
        Condition(
            environment="hall",
            strategy="few cones",
            robots=2,
            team="pair",
            starts="clustered, drawn",
            radio="12.5 m",
            body="its own",
            faults="one dies",
        )
    ]
    assert str(conditions(spec)[0]) == (
        "hall, few cones, pair, clustered, drawn, 12.5 m, its own, faults: one dies"
    )


def test_blocks_inherit_choices_from_the_experiment():
    spec = experiment(
        strategies=["srt-star", "srt-radial"],
        robots=[1, 2],
        blocks=[{"environments": ["museum"]}, {"robots": [8], "strategies": ["srt-ball"]}],
    )
    assert labels(spec, "environment", "strategy", "robots") == [
        ("museum", "srt-star", 1),
        ("museum", "srt-star", 2),
        ("museum", "srt-radial", 1),
        ("museum", "srt-radial", 2),
        ("open", "srt-ball", 8),
    ]


def test_a_condition_of_several_blocks_is_run_once():
    spec = experiment(
        blocks=[
            {"robots": [1, 2], "radios": ["unlimited"]},
            {"robots": [2, 4], "radios": [{"label": "unlimited"}]},
            {"robots": [4], "environments": [{"name": "open"}]},
        ],
        repetitions=2,
    )
    assert labels(spec, "robots") == [(1,), (2,), (4,)]
    assert len(runs(spec)) == 6


def test_exclusions_by_labels():
    spec = experiment(
        environments=["open", "museum"],
        strategies=["srt-star", "srt-radial"],
        robots=[1, 2, 4],
        exclude=[
            {"environment": "open", "robots": [2, 4]},
            {"strategy": "srt-star", "environment": "museum"},
        ],
    )
    assert labels(spec, "environment", "strategy", "robots") == [
        ("open", "srt-star", 1),
        ("open", "srt-radial", 1),
        ("museum", "srt-radial", 1),
        ("museum", "srt-radial", 2),
        ("museum", "srt-radial", 4),
    ]


def test_a_team_is_excluded_by_its_label_or_its_size():
    pair = {"label": "pair", "members": [{}, {"footprint": "disc:0.3"}]}
    for robots, left in (("pair", [(1, ""), (2, "")]), (2, [(1, "")]), ([1, 2], None)):
        spec = experiment(robots=[1, 2, pair], exclude=[{"robots": robots}])
        if left is None:
            assert "no runs are left: 'exclude' matches all 3 conditions" in refused(spec)
        else:
            assert labels(spec, "robots", "team") == left


RICH: dict[str, Any] = {
    "environments": ["museum", {"name": "rooms", "seed": "repetition"}],
    "strategies": ["srt-star", "minpos", {"name": "rules", "label": "other"}],
    "robots": [3],
    "starts": ["scattered", "clustered", {"how": "clustered", "first": "drawn"}],
    "faults": ["none", {"label": "bad day", "deaths": 1, "silences": 1}],
    "repetitions": 2,
}


@pytest.mark.slow
def test_repetitions_are_paired_over_strategies():
    met: dict[tuple[str, str, str, int], dict[str, tuple[object, ...]]] = {}
    for run in runs(experiment(**RICH)):
        one, said = run.condition, run.spec
        world = build_environment(said.environment)
        here = (one.environment, one.starts, one.faults, run.repetition)
        met.setdefault(here, {})[one.strategy] = (
            *(world.digest, starts_of(said, world), said.faults, said.seed, said.radio),
        )
    assert len(met) == 2 * 3 * 2 * 2
    for strategies in met.values():
        assert set(strategies) == {"srt-star", "minpos", "other"}
        assert len(set(strategies.values())) == 1
    # Every repetition draws anew.
    for environment, starts, faults, repetition in met:
        if repetition == 0:
            first = met[environment, starts, faults, 0]["minpos"]
            second = met[environment, starts, faults, 1]["minpos"]
            # Clusters that are not drawn start where the museum suggests, with every seed.
            same = (environment, starts) == ("museum", "clustered")
            assert (first[1] == second[1]) == same
            assert (first[0] == second[0]) == (environment == "museum")
            assert (first[2] == second[2]) == (faults == "none")


def test_drawn_starts_do_not_depend_on_the_team():
    spec = experiment(
        environments=["museum"],
        strategies=["srt-star", "minpos"],
        robots=[1, 4],
        starts=[{"first": "drawn"}],
        repetitions=20,
    )
    drawn: dict[int, set] = {}
    for run in runs(spec):
        drawn.setdefault(run.repetition, set()).add(run.spec.robots[0].start)
        assert all(robot.start is None for robot in run.spec.robots[1:])
    assert all(len(places) == 1 for places in drawn.values())
    places = [next(iter(p)) for p in drawn.values()]
    assert len(set(places)) == 20
    museum = build_environment(CatalogEnvironment(name="museum"))
    assert all(museum.clearance(x, y) > 0.25 for x, y, _ in places)
    # Starts fall into both halves of the environment.
    west, east = museum.bounds[0], museum.bounds[2]
    assert {x > (west + east) / 2 for x, _, _ in places} == {True, False}


@given(st.integers(0, 10**6), st.integers(2, 6))
@settings(max_examples=30, deadline=None)
def test_drawn_faults_are_as_many_as_asked_for(seed, robots):
    late = robots - 2
    faults = {
        "label": "many",
        "faults": [{"fault": "death", "robot": 0, "time_s": 3.0}] if robots > 4 else [],
        "deaths": 1,
        "late_starts": late - (robots > 4),
        "between_s": [5.0, 9.0],
    }
    (run,) = runs(experiment(robots=[robots], faults=[faults], first_seed=seed))
    made = run.spec.faults
    assert len(made) == 1 + late
    assert len({fault.robot for fault in made}) == len(made) < robots
    drawn = made[1:] if robots > 4 else made
    assert all(5.0 <= fault.time_s <= 9.0 for fault in drawn)
    assert [type(fault) for fault in drawn] == [Death, *[LateStart] * (len(drawn) - 1)]
    assert robots <= 4 or made[0] == Death(robot=0, time_s=3.0)


def test_faulty_robots_are_drawn_uniformly():
    faults = {"label": "one", "silences": 1, "silence_s": 7.0}
    planned = runs(experiment(robots=[3], faults=[faults], repetitions=300))
    who = [fault.robot for run in planned for fault in run.spec.faults]
    for run in planned:
        for fault in run.spec.faults:
            assert isinstance(fault, Silence)
            assert fault.duration_s == 7.0
    assert all(70 <= who.count(robot) <= 130 for robot in range(3))


def test_equal_specs_have_equal_keys():
    plain = RunSpec(environment=CatalogEnvironment(name="open"))
    wordy = RunSpec(
        environment=CatalogEnvironment(name="open", parameters={}), robots=(RobotSpec(),), seed=0
    )
    others = [
        RunSpec(environment=CatalogEnvironment(name="open"), seed=1),
        RunSpec(environment=CatalogEnvironment(name="museum")),
        RunSpec(environment=CatalogEnvironment(name="open"), robots=(RobotSpec(),) * 2),
        RunSpec(environment=CatalogEnvironment(name="open"), options={"cones": 6}),
    ]
    assert key_of(plain) == key_of(wordy)
    keys = [key_of(spec) for spec in (plain, *others)]
    assert all(a != b for a, b in pairwise(sorted(keys)))
