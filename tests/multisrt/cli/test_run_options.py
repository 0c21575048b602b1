from importlib import import_module
from typing import get_args, get_type_hints

import pytest
from PIL import Image

from multisrt.cli.run_options import DRIVES
from multisrt.geometry.errors import InvalidInputError
from multisrt.spec import (
    CatalogEnvironment,
    Death,
    DriveSpec,
    FileEnvironment,
    LateStart,
    RadioSpec,
    RangeFinderSpec,
    RobotSpec,
    RunSpec,
    Silence,
)
from tests.multisrt.cli.commands import Call


def spec_of(call: Call, *words: str) -> RunSpec:
    """Return the spec that `explore` makes of its options, without running it."""
    given: list[RunSpec] = []
    # Imported before the patch: it binds the real function.
    import_module("multisrt.run")

    def keep(spec: RunSpec, *_: object, **__: object) -> None:
        given.append(spec)
        raise InvalidInputError("that will do")

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("multisrt.simulation.simulate.simulate", keep)
        code, _, err = call("explore", *words)
    assert (code, err) == (2, "error: that will do\n")
    (spec,) = given
    return spec


def test_options_of_a_team(call):
    spec = spec_of(
        call,
        *("room.wkt", "--robots", "4", "--starts", "clustered", "--radio-range", "15"),
        *("--no-multi-hop", "--latency", "0.1", "--jitter", "0.2", "--loss", "0.3"),
        *("--walls", "weaken", "--drive", "dubins", "--turning-radius", "0.8"),
        *("--fault", "death:2@30", "--fault", "silence:1@20+15", "--fault", "late:3@60"),
        *("--fault", "death:0@1.5:moving"),
    )
    assert spec.starts == "clustered"
    assert spec.robots == 4 * (RobotSpec(drive=DriveSpec(kind="dubins", turning_radius_m=0.8)),)
    assert spec.radio == RadioSpec(
        range_m=15.0, multi_hop=False, latency_s=0.1, jitter_s=0.2, loss=0.3, walls="weaken"
    )
    assert spec.faults == (
        Death(robot=2, time_s=30.0),
        Silence(robot=1, time_s=20.0, duration_s=15.0),
        LateStart(robot=3, time_s=60.0),
        Death(robot=0, time_s=1.5, when="moving"),
    )


def test_every_drive_can_be_chosen():
    assert get_args(get_type_hints(DriveSpec)["kind"]) == DRIVES


def test_options_of_robots_that_differ(call):
    spec = spec_of(
        call,
        *("room.wkt", "--speed", "0.7", "--robots", "3"),
        *("--robot", "footprint=polygon:-0.2,-0.1 0.3,0 -0.2,0.1,range=6,speed=1,beams=90"),
        *("--robot", "start=2,3,0.5,drive=reeds-shepp,turning-radius=0.9"),
        *("--robot", "usual"),
    )
    usual = DriveSpec(speed_m_s=0.7)
    assert spec.robots == (
        RobotSpec(
            footprint="polygon:-0.2,-0.1 0.3,0 -0.2,0.1",
            drive=DriveSpec(speed_m_s=1.0),
            range_finder=RangeFinderSpec(range_m=6.0, beams=90),
        ),
        RobotSpec(
            start=(2.0, 3.0, 0.5),
            drive=DriveSpec(kind="reeds-shepp", speed_m_s=0.7, turning_radius_m=0.9),
        ),
        RobotSpec(drive=usual),
    )
    cars = spec_of(
        call,
        *("room.wkt", "--turning-radius", "0.8", "--robot", "drive=dubins", "--robot", "usual"),
    )
    assert [robot.drive for robot in cars.robots] == [
        DriveSpec(kind="dubins", turning_radius_m=0.8),
        DriveSpec(),
    ]
    starts = spec_of(call, "room.wkt", "--start", "1,1", "--start", "3,3,1")
    assert [robot.start for robot in starts.robots] == [(1.0, 1.0), (3.0, 3.0, 1.0)]
    two = spec_of(call, "room.wkt", "--robot", "range=2", "--robot", "range=3")
    assert [robot.range_finder.range_m for robot in two.robots] == [2.0, 3.0]


def test_options_of_images_describe_the_environment(call, folder):
    Image.new("L", (60, 40), 255).save(folder / "plan.png")
    (folder / "team.txt").write_text("1 A 9 19 0.0 100 100 1000 Explorer 1 1")
    words = ("--resolution", "0.1", "--threshold", "0.5", "--starts-from", "team.txt")
    spec = spec_of(call, "plan.png", *words)
    assert spec.environment == FileEnvironment(
        path="plan.png", resolution_m=0.1, threshold=0.5, starts_from="team.txt"
    )


def test_options_not_given_have_the_defaults_of_the_specs(call):
    spec = spec_of(call, "room.wkt")
    assert spec == RunSpec(environment=FileEnvironment(path="room.wkt"))


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--robots", "2", "--radio-range", "-1"], "--radio-range is -1.0; it must be 0 or more"),
        (["--robots", "2", "--loss", "2"], "--loss is 2.0; it must be from 0"),
        (["--robots", "2", "--walls", "weaken"], "give --radio-range, or let walls pass"),
        (["--speed", "0"], "--speed is a positive, finite number, not 0"),
        (["--robot", "speed=0"], "--robot speed is a positive, finite number, not 0"),
        (["--max-time", "0"], "--max-time is a positive time, not 0 s"),
    ],
)
def test_errors_name_the_option_that_was_given(call, words, said):
    code, out, err = call("explore", "room.wkt", *words)
    assert (code, out) == (2, "")
    assert err.startswith("error: ")
    assert said in err


def test_parameters_of_a_generator_are_in_the_spec(call):
    spec = spec_of(call, "open", "--set", "size_m=12", "--set", "seed=3", "--set", "columns=2")
    world = CatalogEnvironment(name="open", parameters={"size_m": 12, "columns": 2}, seed=3)
    assert spec.environment == world
    assert RunSpec.from_toml(spec.to_toml()) == spec
