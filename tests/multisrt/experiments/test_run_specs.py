"""Specs of planned runs: environments, teams and starts, and experiments that are impossible."""

import shutil

import msgspec
import pytest
import shapely
from PIL import Image

from multisrt.environments.environment import Environment
from multisrt.experiments import run_specs
from multisrt.experiments.crossing import key_of, runs
from multisrt.experiments.spec import ExperimentSpec
from multisrt.geometry.errors import InvalidInputError
from multisrt.simulation.starts import starts_of
from multisrt.simulation.worlds import build_environment
from multisrt.spec import CatalogEnvironment, EnvironmentSpec, FileEnvironment, InlineEnvironment
from tests.multisrt.experiments.small import HALL, ROOM, experiment, refused


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
    environments = [run.spec.environment for run in runs(spec)]
    rooms, museums = environments[::2], environments[1::2]
    assert rooms == [CatalogEnvironment(name="rooms", seed=seed) for seed in (4, 5, 6)]
    assert museums == [CatalogEnvironment(name="museum")] * 3


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


def test_a_team_file_is_relative_to_the_experiment_file(tmp_path):
    (tmp_path / "maps").mkdir()
    Image.new("L", (60, 40), 255).save(tmp_path / "maps" / "hall.png")
    (tmp_path / "maps" / "team.txt").write_text("1 A 9 19 0.0 100 100 1000 Explorer 1 1")
    hall = {"name": "maps/hall.png", "resolution_m": 0.1, "starts_from": "maps/team.txt"}
    (run,) = runs(experiment(environments=[hall], robots=[1]), tmp_path)
    assert isinstance(run.spec.environment, InlineEnvironment)
    (start,) = run.spec.environment.starts
    assert start == pytest.approx((0.95, 2.05))
    with pytest.raises(InvalidInputError, match=r"none\.txt does not exist"):
        runs(experiment(environments=[hall | {"starts_from": "none.txt"}]), tmp_path)


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
            "option cones='many' of srt-star: Expected a whole number",
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
            "fault 1 (death of robot 1): there is no such robot; the team has one robot, number 0",
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
            "'open' is an environment of the catalogue: a resolution, a threshold or a team",
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


def test_a_strategy_that_knows_the_map_does_not_compete(tmp_path):
    message = refused(experiment(strategies=["minpos", "informed"]), tmp_path)
    assert "informed knows the map" in message
    assert "ask for it as the reference" in message


def test_an_empty_experiment_is_refused():
    assert "there are no runs; name 'environments'" in refused(ExperimentSpec(name="x"))


def test_environments_are_built_once(monkeypatch):
    built: list[EnvironmentSpec] = []

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
