"""Conditions and runs of experiments: their number, order, pairing and specs."""

import shutil
from itertools import pairwise
from pathlib import Path

import msgspec
import pytest
import shapely
from hypothesis import Phase, given, settings
from hypothesis import strategies as st

from multisrt.environments.environment import Environment
from multisrt.experiments import run_specs
from multisrt.experiments.crossing import Condition, conditions, key_of, runs
from multisrt.experiments.spec import ExperimentSpec
from multisrt.geometry.errors import InvalidInputError
from multisrt.simulation.starts import starts_of
from multisrt.simulation.worlds import build_environment
from multisrt.spec import (
    CatalogEnvironment,
    Death,
    FileEnvironment,
    InlineEnvironment,
    LateStart,
    RobotSpec,
    RunSpec,
    Silence,
)

ROOM = "POLYGON ((0 0, 6 0, 6 5, 0 5, 0 0))"
HALL = "POLYGON ((0 0, 9 0, 9 6, 0 6, 0 0))"


def experiment(**said) -> ExperimentSpec:
    usual = {"name": "x", "environments": ["open"], "strategies": ["srt-star"], "repetitions": 1}
    return ExperimentSpec.from_dict(usual | said)


def labels(spec: ExperimentSpec, *names: str) -> list[tuple]:
    return [tuple(getattr(one, name) for name in names) for one in conditions(spec)]


def refused(spec: ExperimentSpec, folder: Path | None = None) -> str:
    with pytest.raises(InvalidInputError) as error:
        runs(spec, folder)
    message = str(error.value)
    assert "\n" not in message
    return message


# Conditions and their order ------------------------------------------------------------------


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


# Pairing -------------------------------------------------------------------------------------

RICH = {
    "environments": ["museum", {"name": "rooms", "seed": "repetition"}],
    "strategies": ["srt-star", "minpos", {"name": "rules", "label": "other"}],
    "robots": [3],
    "starts": ["scattered", "clustered", {"how": "clustered", "first": "drawn"}],
    "faults": ["none", {"label": "bad day", "deaths": 1, "silences": 1}],
    "repetitions": 2,
}


def test_repetitions_are_paired_over_strategies():
    met: dict[tuple, dict] = {}
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
    assert {(type(f), f.duration_s) for run in planned for f in run.spec.faults} == {(Silence, 7.0)}
    assert all(70 <= who.count(robot) <= 130 for robot in range(3))


# Environments --------------------------------------------------------------------------------


def test_seeds_make_one_environment_each():
    spec = experiment(
        environments=[
            {"name": "rooms", "seeds": "3-5"},
            {"name": "open", "label": "hall", "seeds": [7, 1], "parameters": {"size_m": 9}},
        ]
    )
    assert [(run.condition.environment, run.spec.environment) for run in runs(spec)] == [
        *((f"rooms {n}", CatalogEnvironment(name="rooms", seed=n)) for n in (3, 4, 5)),
        *(
            (f"hall {n}", CatalogEnvironment(name="open", seed=n, parameters={"size_m": 9}))
            for n in (7, 1)
        ),
    ]


def test_a_repetition_seed_makes_another_environment():
    spec = experiment(
        environments=[{"name": "rooms", "seed": "repetition"}, "museum"],
        repetitions=3,
        first_seed=4,
    )
    assert [run.spec.environment.seed for run in runs(spec)] == [4, None, 5, None, 6, None]


def test_paths_are_relative_to_the_experiment_file(tmp_path, monkeypatch):
    one, other = tmp_path / "one", tmp_path / "other"
    (one / "maps").mkdir(parents=True)
    for name in ("maps/room.wkt", "plain"):
        (one / name).write_text(ROOM)
    shutil.copytree(one, other)
    (other / "maps" / "again.wkt").write_text(HALL)
    spec = experiment(environments=["maps/room.wkt"], repetitions=2)
    here, there = runs(spec, one), runs(spec, other)
    assert [run.key for run in here] == [run.key for run in there]
    assert len({run.key for run in here}) == 2
    assert here[0].condition.environment == "room"
    # The environment is written out: recordings do not depend on the file's path.
    assert [run.spec for run in here] == [run.spec for run in there]
    world = build_environment(FileEnvironment(path=str(one / "maps" / "room.wkt")))
    assert build_environment(here[0].spec.environment) == world
    from_file = msgspec.structs.replace(
        here[0].spec, environment=FileEnvironment(path=str(one / "maps" / "room.wkt"))
    )
    assert key_of(from_file) == here[0].key
    monkeypatch.chdir(one)
    assert [run.key for run in runs(spec)] == [run.key for run in here]
    # A changed file is another run, even if the file was read before.
    (one / "maps" / "room.wkt").write_text(HALL)
    assert not {run.key for run in runs(spec, one)} & {run.key for run in there}


def test_a_name_of_the_catalogue_is_not_a_file(tmp_path):
    (tmp_path / "open").mkdir()
    (tmp_path / "museum.wkt").write_text(ROOM)
    assert runs(experiment(), tmp_path)[0].spec.environment == CatalogEnvironment(name="open")
    message = refused(experiment(environments=["museum", "museum.wkt"]), tmp_path)
    assert "two different conditions are both called [museum, srt-star, 1 robot" in message
    both = experiment(environments=["museum", {"name": "museum.wkt", "label": "mine"}])
    assert len(runs(both, tmp_path)) == 2
    (mine,) = runs(experiment(environments=["./museum.wkt"]), tmp_path)
    assert build_environment(mine.spec.environment).free.equals(shapely.from_wkt(ROOM))


def test_an_environment_given_as_text():
    spec = experiment(environments=[{"name": "hall", "wkt": HALL, "starts": [[1.0, 1.0]]}])
    (run,) = runs(spec)
    assert run.spec.environment == InlineEnvironment(name="hall", wkt=HALL, starts=((1.0, 1.0),))
    world = build_environment(run.spec.environment)
    assert world == Environment("hall", shapely.from_wkt(HALL))
    assert starts_of(run.spec, world)[0][:2] == (1.0, 1.0)


# Teams ---------------------------------------------------------------------------------------


def test_bodies_inherit_drive_and_range_finder():
    said = {
        "drive": {"speed_m_s": 0.8},
        "range_finder": {"range_m": 6.0},
        "bodies": ["disc:0.2", {"footprint": "disc:0.3", "range_finder": {"beams": 360}}],
        "robots": [2, {"label": "pair", "members": [{"drive": {"kind": "holonomic"}}, {}]}],
    }
    planned = runs(experiment(**said))
    assert [(r.condition.robots, r.condition.team, r.condition.body) for r in planned] == [
        (2, "", "disc:0.2"),
        (2, "", "disc:0.3"),
        (2, "pair", "its own"),
    ]
    plain, keen, pair = (run.spec.robots for run in planned)
    assert plain[0] == plain[1]
    assert (plain[0].drive.speed_m_s, plain[0].range_finder.range_m) == (0.8, 6.0)
    assert (keen[0].drive.speed_m_s, keen[0].range_finder.range_m) == (0.8, 4.0)
    assert keen[0].range_finder.beams == 360
    assert (pair[0].drive.kind, pair[1].drive.speed_m_s) == ("holonomic", 0.8)
    assert pair[0].range_finder.range_m == pair[1].range_finder.range_m == 6.0


def test_given_starts_are_used_in_order():
    places = [[1, 1], [3, 1, 0.5], [5, 1]]
    first, second = runs(experiment(robots=[1, 2], starts=[{"places": places}]))
    assert [robot.start for robot in first.spec.robots] == [(1.0, 1.0)]
    assert [robot.start for robot in second.spec.robots] == [(1.0, 1.0), (3.0, 1.0, 0.5)]
    assert second.condition.starts == "given"


# Keys ----------------------------------------------------------------------------------------


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


# Errors --------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("said", "told"),
    [
        ({"environments": ["opn"]}, "there is no environment 'opn' (did you mean 'open'?)"),
        ({"strategies": ["srt-str"]}, "there is no strategy 'srt-str' (did you mean 'srt-star'?)"),
        (
            {"strategies": [{"name": "srt-star", "options": {"cone": 6}}]},
            "srt-star has no option 'cone' (did you mean 'cones'?)",
        ),
        (
            {"strategies": [{"name": "srt-star", "options": {"cones": "many"}}]},
            "option cones='many' of srt-star: Expected `int`",
        ),
        (
            {"robots": [1, 2], "radios": [{"range_m": 8}]},
            "x: [open, srt-star, 2 robots, scattered, 8 m, disc:0.25]: srt-star needs a radio "
            "range of at least three times the sensor range: 12 m",
        ),
        (
            {"robots": [2], "faults": [{"label": "worst", "deaths": 1, "silences": 1}]},
            "faults 'worst': 2 robots with a fault of their own leave none without in a team of 2;"
            " exclude this condition, or let fewer fail",
        ),
        (
            {"robots": [2], "faults": [{"label": "a", "deaths": 1, "between_s": [9, 3]}]},
            "between_s is two times, the first not after the second, not [9.0, 3.0]",
        ),
        (
            {"faults": [{"label": "a", "faults": [{"fault": "death", "robot": 1, "time_s": 1}]}]},
            "fault 1 (death of robot 1): there is no such robot; the 1 count from 0",
        ),
        ({"bodies": ["disk:3"]}, "footprint 'disk:3' is not known; write disc:RADIUS"),
        (
            {"environments": [{"name": "open", "parameters": {"sise_m": 3}}]},
            "open has no parameter 'sise_m'; it takes seed and",
        ),
        (
            {"environments": [{"name": "museum", "seed": "repetition"}]},
            "the bundled map 'museum' is fixed: it takes neither seed nor parameters",
        ),
        (
            {"environments": [{"name": "rooms", "seed": 1, "seeds": "0-3"}]},
            "environment 'rooms': give 'seed' or 'seeds', not both",
        ),
        (
            {"environments": [{"name": "rooms", "seeds": "3-1"}]},
            "seeds are numbers, or a range like \"0-9\", not '3-1'",
        ),
        (
            {"environments": [{"name": "rooms", "seeds": "0-999999999"}]},
            "1000000000 seeds are more than 1000000 runs; take fewer",
        ),
        ({"environments": ["no/such.wkt"]}, "no/such.wkt"),
        ({"environments": [{"name": "a", "wkt": "POLYGON ((0 0"}]}, "environment 'a'"),
        (
            {"environments": [{"name": "a", "wkt": ROOM, "seed": 3}]},
            "environment 'a' is given as 'wkt': parameters and seeds are for generators",
        ),
        (
            {"environments": [{"name": "open", "starts": [[1, 1]]}]},
            "'starts' are for an environment given as 'wkt'",
        ),
        (
            {"environments": [{"name": "open", "resolution_m": 0.1}]},
            "'open' is an environment of the catalogue: a resolution or a threshold is for images",
        ),
        (
            {"robots": [3], "starts": [{"places": [[1, 1], [2, 2]]}]},
            "2 starts are given for a team of 3; give more, or exclude this condition",
        ),
        (
            {"starts": [{"places": [[1, 1]], "first": "drawn"}]},
            "starts are given ('places') or 'drawn', not both",
        ),
        ({"starts": [{"places": [[1]]}]}, "a start is (x, y) or (x, y, heading), not (1.0,)"),
        (
            {
                "robots": [{"label": "a", "members": [{"start": [1, 1]}]}],
                "starts": [{"first": "drawn"}],
            },
            "starts 'scattered, drawn' and the team both say where robot 0 starts",
        ),
        ({"exclude": [{}]}, "exclusion 1 is empty"),
        (
            {"exclude": [{"robots": 1}], "strategies": ["srt-star", "minpos"]},
            "no runs are left: 'exclude' matches all 2 conditions; exclude fewer",
        ),
        (
            {"exclude": [{"strategy": "srt-ster"}]},
            "exclusion 1 matches no condition: there is no strategy 'srt-ster' (did you mean "
            "'srt-star'?); labels are those of tables, as in [open, srt-star, 1 robot",
        ),
        (
            {"exclude": [{"robots": [1, 3]}, {"robots": 3}]},
            "exclusion 2 matches no condition: there is no robots 3",
        ),
        (
            {"strategies": ["srt-star", {"name": "minpos", "label": "srt-star"}]},
            "two different conditions are both called [open, srt-star, 1 robot",
        ),
        (
            {"radios": ["unlimited", {"loss": 0.1}]},
            "both called [open, srt-star, 1 robot, scattered, unlimited, disc:0.25]; give "
            "them labels of their own",
        ),
        (
            {"strategies": ["srt-star", {"name": "srt-star", "label": "again"}]},
            "repetition 0 of [open, again, 1 robot, scattered, unlimited, disc:0.25] and repetition"
            " 0 of [open, srt-star, 1 robot, scattered, unlimited, disc:0.25] are the same run; "
            "leave one of them out",
        ),
        (
            {"robots": list(range(1, 1001)), "repetitions": 1001},
            "1 x 1 x 1000 x 1 x 1 x 1 x 1 conditions of 1001 repetitions are more than 1000000",
        ),
    ],
)
def test_impossible_experiments_are_refused(said, told, tmp_path):
    message = refused(experiment(**said), tmp_path)
    assert told in message
    assert message.startswith(("x: ", "environment "))


def test_an_empty_experiment_is_refused():
    assert "there are no runs; name 'environments'" in refused(ExperimentSpec(name="x"))


def test_environments_are_built_once(monkeypatch):
    built = []

    def build(spec):
        built.append(spec)
        return build_environment(spec)

    monkeypatch.setattr(run_specs, "build_environment", build)
    spec = experiment(
        environments=["open", {"name": "rooms", "seeds": "0-4"}],
        strategies=["srt-star", "minpos"],
        robots=[1, 2],
        repetitions=3,
    )
    assert len(runs(spec)) == 6 * 2 * 2 * 3
    assert len(built) == 2
