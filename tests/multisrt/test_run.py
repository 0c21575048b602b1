import inspect
import json
from typing import Any

import msgspec
import numpy as np
import pytest
import shapely
from PIL import Image

import multisrt
from multisrt.environments.environment import Environment
from multisrt.finished_run import Run
from multisrt.geometry.errors import InvalidInputError
from multisrt.run import RunKeywords, explore
from multisrt.simulation.simulate import simulate
from multisrt.simulation.worlds import inline
from multisrt.spec import (
    Death,
    DriveSpec,
    FileEnvironment,
    RadioSpec,
    RangeFinderSpec,
    RobotSpec,
    RunSpec,
    StopRule,
)

ROOM = Environment("room", shapely.box(0, 0, 6, 5), starts=[(1.0, 1.0)])


class Enough(Exception):
    """Raised instead of simulating."""


@pytest.fixture
def spec_of(monkeypatch):
    """Return the spec that `explore` makes of its arguments, without running it."""

    def asked(*args, **kwargs) -> RunSpec:
        given = None

        def kept(spec, *_, **__):
            nonlocal given
            given = spec
            raise Enough

        with monkeypatch.context() as patch:
            patch.setattr("multisrt.run.simulate", kept)
            with pytest.raises(Enough):
                explore(*args, **kwargs)
        assert given is not None
        return given

    return asked


@pytest.fixture(scope="module")
def run() -> Run:
    return explore(ROOM, seed=1, start=(1.0, 1.0))


def test_the_defaults_are_those_of_the_specs(spec_of):
    assert spec_of(ROOM) == RunSpec(environment=inline(ROOM))
    # None is the same as not given, for every keyword.
    names = set(inspect.signature(explore).parameters)
    keywords = names - {"environment", "recording_path", "watch"}
    assert spec_of(ROOM, **dict.fromkeys(keywords)) == RunSpec(environment=inline(ROOM))


EXAMPLES: dict[str, Any] = {
    "strategy": "srt-star",
    "seed": 7,
    "options": {"cones": 12},
    "robots": 3,
    "start": (1.0, 1.0),
    "starts": [(1.0, 1.0), (2.0, 1.0)],
    "footprint": "box:0.6x0.4",
    "range_m": 3.0,
    "beams": 90,
    "drive": DriveSpec(speed_m_s=0.7),
    "radio_range_m": 15.0,
    "radio": RadioSpec(range_m=18.0),
    "faults": [Death(robot=1, time_s=3.0)],
    "base": (1.0, 1.0),
    "max_time_s": 50.0,
}
"""A value of each keyword that differs from its default."""


def test_each_keyword_of_a_run_is_taken_everywhere(spec_of):
    assert EXAMPLES.keys() == RunKeywords.__annotations__.keys()
    for name, value in EXAMPLES.items():
        base = {"robots": 2} if name in ("radio_range_m", "radio", "faults") else {}
        given = base | {name: value}
        assert spec_of(ROOM, **given) != spec_of(ROOM, **base), name
        assert multisrt.Stepper(ROOM, **given).spec == spec_of(ROOM, **given), name


def test_signatures_show_each_keyword_of_a_run():
    for function, others in ((explore, 4), (multisrt.Stepper, 2)):
        shown = inspect.signature(function).parameters
        assert RunKeywords.__annotations__.keys() < shown.keys()
        assert len(shown) == others + len(EXAMPLES)
        assert shown["seed"].annotation == "int | None"


def test_every_keyword_reaches_the_spec(spec_of):
    spec = spec_of(
        ROOM,
        strategy="srt-star",
        seed=7,
        options={"cones": 12},
        footprint="box:0.6x0.4",
        range_m=3.0,
        beams=90,
        drive=DriveSpec(speed_m_s=1.0),
        max_time_s=50.0,
    )
    assert spec == RunSpec(
        environment=inline(ROOM),
        strategy="srt-star",
        seed=7,
        options={"cones": 12},
        robots=(
            RobotSpec(
                footprint="box:0.6x0.4",
                drive=DriveSpec(speed_m_s=1.0),
                range_finder=RangeFinderSpec(range_m=3.0, beams=90),
            ),
        ),
        stop=StopRule(max_time_s=50.0),
    )


def test_robots_that_differ(spec_of):
    robots = [RobotSpec(start=(1, 1)), RobotSpec(footprint="disc:0.3")]
    spec = spec_of(ROOM, robots=robots, starts="clustered", seed=3)
    assert spec.robots == tuple(robots)
    assert (spec.starts, spec.seed) == ("clustered", 3)


@pytest.mark.parametrize(
    "given",
    [
        {"start": (1, 1)},
        {"starts": [(1, 1)]},
        {"footprint": "disc:0.25"},
        {"range_m": 4.0},
        {"beams": 90},
        {"drive": DriveSpec()},
    ],
)
def test_robot_specs_and_keywords_do_not_mix(given):
    with pytest.raises(InvalidInputError, match="a RobotSpec says everything") as error:
        explore(ROOM, robots=[RobotSpec()], **given)
    assert f"leave out {next(iter(given))}, or" in str(error.value)


def test_a_single_robot(spec_of):
    assert spec_of(ROOM, start=(2, 3)).robots == (RobotSpec(start=(2.0, 3.0)),)
    assert spec_of(ROOM, starts=[(2, 3)]).robots == (RobotSpec(start=(2.0, 3.0)),)


def test_a_team(spec_of):
    faults = (Death(robot=3, time_s=10.0),)
    spec = spec_of(
        ROOM,
        robots=4,
        starts="clustered",
        radio_range_m=15.0,
        faults=list(faults),
        range_m=6.0,
        drive=DriveSpec(kind="holonomic"),
    )
    robot = RobotSpec(range_finder=RangeFinderSpec(range_m=6.0), drive=DriveSpec(kind="holonomic"))
    assert spec.robots == (robot,) * 4
    assert spec.starts == "clustered"
    assert spec.radio == RadioSpec(range_m=15.0)
    assert spec.faults == faults
    assert spec_of(ROOM, robots=2).starts == "scattered"


def test_a_team_with_given_starts(spec_of):
    places = (1, 1), (2, 2, 0.5)
    for given in ({"starts": places}, {"starts": list(places), "robots": 2}):
        assert [robot.start for robot in spec_of(ROOM, **given).robots] == [
            (1.0, 1.0),
            (2.0, 2.0, 0.5),
        ]


def test_a_complete_radio(spec_of):
    radio = RadioSpec(range_m=15.0, loss=0.25, walls="block")
    assert spec_of(ROOM, robots=2, radio=radio).radio == radio


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"robots": 0}, "at least one robot, not 0"),
        ({"robots": 2, "start": (1, 1)}, "give starts"),
        ({"robots": 2, "starts": [(1, 1)] * 3}, "3 starts for 2 robots"),
        ({"robots": 1, "starts": []}, "0 starts for 1 robot: "),
        ({"starts": []}, "at least one robot, not 0"),
        ({"robots": []}, "at least one robot"),
        ({"robots": 2.5}, r"a number or a sequence of RobotSpec, not 2\.5"),
        ({"robots": "two"}, r"robots\[0\] is 't'"),
        ({"robots": [RobotSpec(), "disc:0.3"]}, r"robots\[1\] is 'disc:0.3'"),
        ({"start": (1, 1), "starts": [(1, 1)]}, "not both"),
        ({"starts": "anywhere"}, "anywhere"),
        ({"radio_range_m": 3.0, "radio": RadioSpec()}, "radio_range_m alone"),
        ({"radio_range_m": -3.0}, "range_m of a radio"),
        ({"faults": [Death(robot=1, time_s=1.0)]}, "there is no such robot"),
    ],
)
def test_impossible_runs_are_refused(given, said):
    with pytest.raises(InvalidInputError, match=said):
        explore(ROOM, **given)


@pytest.mark.parametrize(
    "given",
    [
        {"robots": 2},
        {"robots": [RobotSpec()]},
        {"starts": "clustered"},
        {"radio": RadioSpec()},
        {"faults": [1]},
        {"seed": 1},
        # Defaults that are given explicitly count as given.
        {"seed": 0},
        {"range_m": 4.0},
    ],
)
def test_a_run_spec_and_keywords_do_not_mix(given):
    with pytest.raises(InvalidInputError, match="a RunSpec describes the run") as error:
        explore(RunSpec(environment=inline(ROOM)), **given)
    assert str(error.value).endswith(f"leave out {next(iter(given))}")


def test_a_saved_spec_repeats_the_run(run, tmp_path):
    run.save_spec(tmp_path / "spec.toml")
    spec = RunSpec.from_toml((tmp_path / "spec.toml").read_text())
    assert spec == run.spec
    assert explore(spec).digest == run.digest


def test_a_saved_spec_knows_the_world_of_its_file(tmp_path):
    path = tmp_path / "room.wkt"
    path.write_text("POLYGON ((0 0, 6 0, 6 5, 0 5, 0 0), (2 2, 2 3, 3.3 3, 2 2))")
    run = explore(path, seed=1, max_time_s=3.0)
    run.save_spec(tmp_path / "spec.toml")
    spec = RunSpec.from_toml((tmp_path / "spec.toml").read_text())
    assert isinstance(spec.environment, FileEnvironment)
    assert spec.environment.digest == run.environment.digest
    assert spec.environment.starts == ()
    # They are a check, no part of the run; a recording has no suggested starts.
    again = explore(spec)
    assert (again.digest, again.spec) == (run.digest, run.spec)
    Run(again.recording).save_spec(tmp_path / "again.toml")
    texts = [(tmp_path / name).read_text() for name in ("again.toml", "spec.toml")]
    assert texts[0] == texts[1].replace("starts = []\n", "")
    path.write_text("POLYGON ((0 0, 7 0, 7 5, 0 5, 0 0))")
    said = "room.wkt holds another world than when .* restore the file, or remove the line 'digest'"
    for environment in (None, multisrt.read_environment(path)):
        with pytest.raises(InvalidInputError, match=said):
            simulate(spec, environment)
    assert explore(path, seed=1, max_time_s=3.0).environment.area_m2 == 35.0


def write_starts(folder, *places):
    """Write one world as GeoJSON with suggested starts, and as an image with a team file."""
    grey = np.zeros((12, 16), np.uint8)
    grey[1:11, 1:15] = 255
    Image.fromarray(grey).save(folder / "room.png")
    world = multisrt.read_environment(folder / "room.png", resolution_m=0.5)
    free = {"type": "Feature", "properties": {"kind": "free"}}
    starts = {"type": "Feature", "properties": {"kind": "start"}}
    features = [
        free | {"geometry": shapely.geometry.mapping(world.free)},
        starts | {"geometry": {"type": "MultiPoint", "coordinates": places}},
    ]
    document = {"type": "FeatureCollection", "features": features}
    (folder / "room.geojson").write_text(json.dumps(document))
    lines = [
        f"{number} R {2 * x:.0f} {2 * (6 - y):.0f} 0 100 300 1000 Explorer {number} 1"
        for number, (x, y) in enumerate(places, start=1)
    ]
    (folder / "team.txt").write_text("\n".join(lines))


@pytest.mark.parametrize("kind", ["geojson", "team"])
def test_a_saved_spec_knows_the_starts_that_its_files_suggest(tmp_path, kind):
    path, team = tmp_path / "room.geojson", tmp_path / "team.txt"
    file = FileEnvironment(path=str(path))
    if kind == "team":
        path = tmp_path / "room.png"
        file = FileEnvironment(path=str(path), resolution_m=0.5, starts_from=str(team))
    plain = RunSpec(environment=file, seed=1, stop=StopRule(max_time_s=3.0))
    write_starts(tmp_path, (2, 2), (4, 3))
    run = explore(plain)
    run.save_spec(tmp_path / "spec.toml")
    spec = RunSpec.from_toml((tmp_path / "spec.toml").read_text())
    assert isinstance(spec.environment, FileEnvironment)
    assert spec.environment.starts == run.environment.starts
    assert explore(spec).digest == run.digest
    # The same free space with other starts: the digest of the world is the same, that of a run not.
    write_starts(tmp_path, (5, 2), (4, 3))
    other = explore(plain)
    assert other.environment.digest == run.environment.digest
    assert other.recording.starts != run.recording.starts
    assert other.digest != run.digest
    said = f"{(team if kind == 'team' else path).name} suggests other starts than when .*'starts'"
    for environment in (None, other.environment):
        with pytest.raises(InvalidInputError, match=said):
            simulate(spec, environment)
    # Without robots that may start there, they are of no concern.
    given = explore(msgspec.structs.replace(plain, robots=(RobotSpec(start=(3, 3)),)))
    given.save_spec(tmp_path / "given.toml")
    write_starts(tmp_path, (2, 2), (4, 3))
    again = RunSpec.from_toml((tmp_path / "given.toml").read_text())
    assert explore(again).digest == given.digest


def test_why_explains_the_last_decision(run):
    assert "its last decision was at 0.00 s" in run.why(0, 0.0)
    assert run.why(0) == run.why(0, run.metrics.makespan_s)
    with pytest.raises(InvalidInputError, match="there is no robot 1"):
        run.why(1)


def test_the_specs_of_faults_and_radios_are_public():
    assert all(getattr(multisrt, name) is not None for name in multisrt.__all__)
    assert {"RadioSpec", "Death", "Silence", "LateStart"} <= set(multisrt.__all__)


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"starts": "clustered"}, "starts is for teams, and there is one robot: give robots"),
        ({"radio_range_m": 15.0}, "radio_range_m is for teams"),
        (
            {"starts": "clustered", "robots": [RobotSpec(start=(2, 2))]},
            "starts says how starts are drawn, but every robot was given its start",
        ),
    ],
)
def test_keywords_that_nothing_uses_are_refused(given, said):
    with pytest.raises(InvalidInputError, match=said):
        explore("open", **given)


def test_a_misspelt_keyword_is_refused_with_a_hint():
    for name, meant in (("seeds", "seed"), ("option", "options"), ("robot", "robots")):
        with pytest.raises(InvalidInputError) as error:
            explore("open", **{name: 1})  # type: ignore[arg-type]
        assert f"explore takes no argument {name!r} (did you mean {meant!r}?)" in str(error.value)
    with pytest.raises(InvalidInputError, match="no argument 'stop': give max_time_s=SECONDS"):
        explore("open", stop={"max_time_s": 9.0})  # type: ignore[call-arg]


def test_messages_lead_from_an_image_to_its_world(tmp_path):
    grid = tmp_path / "grid.npy"
    np.save(grid, np.zeros((30, 30), dtype=bool))
    way = r"ms\.read_environment\(file, resolution_m=\.\.\.\)"
    with pytest.raises(InvalidInputError, match=f"metres per cell .*{way}"):
        explore(grid)
    for function in (explore, multisrt.Stepper):
        with pytest.raises(InvalidInputError, match=f"'resolution_m': give .*{way}"):
            function(grid, resolution_m=0.1)  # type: ignore[call-arg]
    with pytest.raises(InvalidInputError, match=f"'resolution_m': give .*{way}"):
        multisrt.compare([grid], ["minpos", "closest"], resolution_m=0.1)
    world = multisrt.read_environment(grid, resolution_m=0.1)
    assert world.area_m2 == pytest.approx(9.0)


def test_explanations_show_themselves_as_they_read(run):
    told = run.why(0)
    assert repr(told) == str(told)
    assert told.count("\n") > 1


def test_a_team_of_one_takes_the_keywords_of_a_team():
    run = explore("open", robots=1, starts="clustered", radio_range_m=20.0, max_time_s=5.0)
    assert run.spec.starts == "clustered"
