"""What is said of a base station that robots do not reach, or that learned nothing."""

import re
from collections import Counter

import pytest
import shapely

import multisrt as ms
from multisrt.cli.base_notes import base_apart, not_delivered
from multisrt.cli.summary import print_summary
from multisrt.environments.environment import Environment
from multisrt.events import BaseLearned, NodeAdded
from multisrt.explain.srt import explain
from multisrt.geometry.configuration import Configuration

ROOMS = Environment("rooms", shapely.union_all([shapely.box(0, 0, 2, 2), shapely.box(3, 0, 13, 4)]))
# The way from one arm to the other is 80 m long.
BEND = Environment(
    "bend",
    shapely.union_all(
        [shapely.box(0, 0, 40, 1.2), shapely.box(38.8, 0, 40, 6), shapely.box(0, 4.8, 40, 6)]
    ),
)
# Two rooms, with a passage of 0.3 m x 1 m between them.
DOOR = Environment(
    "door",
    shapely.union_all(
        [shapely.box(0, 0, 3, 3), shapely.box(3, 1, 4, 1.3), shapely.box(4, 0, 8, 3)]
    ),
)
IN_TIME = {"home": "in-time"}


def spec(base: tuple[float, float], **radio) -> ms.RunSpec:
    x, y = base
    return ms.RunSpec(
        environment=ms.CatalogEnvironment(name="open"),
        base=ms.BaseSpec(x=x, y=y),
        radio=ms.RadioSpec(**radio),
    )


@pytest.mark.parametrize(
    ("radio", "said"),
    [
        ({}, "; it learns only what reaches it by radio from elsewhere"),
        ({"range_m": 3.0}, "; it learns only what reaches it by radio from elsewhere"),
        ({"range_m": 1.0}, "; none comes within radio range (1 m): it will learn nothing"),
        ({"walls": "block"}, "; walls block the radio: it will learn nothing"),
    ],
)
def test_a_base_in_another_part_is_told(radio, said):
    told = base_apart(spec((1.0, 1.0), **radio), ROOMS, [Configuration(5.0, 1.0, 0.0)])
    assert told == (
        "no robot can drive to the base station (1, 1), which is in another part of free space "
        f"(of 4 m2){said}"
    )


def test_a_base_behind_a_passage_is_told_where_the_body_is_too_large():
    here = [Configuration(1.0, 1.0, 0.0)]
    assert base_apart(spec((7.0, 1.0)), DOOR, here) == (
        "no robot can drive to the base station (7, 1), as passages are too narrow; it learns "
        "only what reaches it by radio from elsewhere"
    )
    # In a corner, where the middle of no body gets to.
    assert base_apart(spec((0.01, 0.01)), DOOR, here) == ""
    assert base_apart(spec((2.0, 1.0)), DOOR, here) == ""


def test_a_limit_too_short_to_find_the_way_is_told(capsys, tmp_path):
    run = ms.explore(
        BEND,
        strategy="minpos",
        starts=[(1.0, 0.6)],
        base=(1.0, 5.4),
        radio_range_m=3.0,
        options=IN_TIME,
        max_time_s=90.0,
        seed=1,
    )
    assert run.metrics.delivered_coverage == 0.0
    said = (
        "the base station learned nothing: no robot was in reach of its radio (3 m) within the "
        "time limit of 90 s, as none found a way there in time; allow more with --max-time, or "
        "start robots there (--starts base)"
    )
    assert not_delivered(run) == said
    print_summary([run], [tmp_path])
    assert f"  {said}" in capsys.readouterr().out.splitlines()


@pytest.mark.parametrize(
    ("strategy", "said"),
    [
        (
            "minpos",
            ": no robot was in reach of its radio (1 m); robots go there with --option "
            "home=in-time",
        ),
        ("informed", ": robots of informed send no nodes, which are what it learns"),
    ],
)
def test_without_the_option_it_is_named_where_there_is_one(strategy, said):
    run = ms.explore(
        ROOMS,
        strategy=strategy,
        starts=[(4.0, 1.0)],
        base=(12.0, 3.0),
        radio_range_m=1.0,
        max_time_s=3.0,
    )
    assert not_delivered(run) == f"the base station learned nothing{said}"


def test_a_base_behind_a_wall_is_told_twice(capsys, tmp_path):
    run = ms.explore(
        ROOMS,
        strategy="minpos",
        starts=[(5.0, 1.0)],
        base=(1.0, 1.0),
        radio=ms.RadioSpec(walls="block"),
        footprint="disc:0.2",
        options=IN_TIME,
    )
    print_summary([run], [tmp_path])
    lines = capsys.readouterr().out.splitlines()
    assert lines[2].endswith("no robot was in reach of its radio; they cannot drive there")
    assert lines[3].endswith("walls block the radio: it will learn nothing")


def test_lost_messages_are_told_of_robots_that_were_in_reach():
    run = ms.explore(
        "open",
        strategy="minpos",
        starts=[(1.0, 1.0)],
        base=(2.0, 2.0),
        radio=ms.RadioSpec(loss=0.999),
        max_time_s=5.0,
        seed=1,
    )
    assert not_delivered(run) == (
        "the base station learned nothing, though robots were in reach of its radio for 5.0 s: no "
        "message with nodes arrived"
    )


def test_nothing_is_said_of_a_base_that_learned():
    run = ms.explore("open", strategy="minpos", starts=[(1.0, 1.0)], base=(2.0, 2.0), max_time_s=5)
    assert not_delivered(run) == ""
    assert base_apart(run.spec, run.environment, run.recording.starts) == ""
    alone = ms.explore("open", strategy="minpos", max_time_s=5.0)
    assert not_delivered(alone) == base_apart(alone.spec, alone.environment, []) == ""


def test_experiment_check_warns_of_a_base_apart(call, folder):
    (folder / "rooms.wkt").write_text(shapely.to_wkt(ROOMS.free))
    (folder / "rooms.toml").write_text(
        'name = "rooms"\nenvironments = ["rooms.wkt"]\nstrategies = ["closest"]\n'
        'bodies = ["disc:0.2"]\nrepetitions = 1\nstarts = [{ places = [[5.0, 1.0]] }]\n'
        "[base]\nx = 1.0\ny = 1.0\n"
    )
    code, _, err = call("experiment", "check", "rooms.toml", "--seconds", "0")
    (warning,) = err.splitlines()
    assert code == 0
    assert "no robot can drive to the base station (1, 1), which is in another part" in warning


def test_robots_that_ended_with_news_are_told():
    # Robot 0 is 4.8 m from the base station as the crow flies, and 80 m by the way round.
    run = ms.explore(
        BEND,
        strategy="minpos",
        starts=[(1.0, 0.6), (3.0, 5.4)],
        base=(1.0, 5.4),
        radio_range_m=3.0,
        max_time_s=40.0,
        options=IN_TIME,
    )
    lacking = _lacking(run)
    assert lacking[0] > 0
    assert lacking[1] == 0
    assert not_delivered(run) == (
        f"robot 0 did not bring home {lacking[0]} of its scans: it knew no place where the base "
        "station is certain to hear a robot; start robots there (--starts base)"
    )
    told = explain(run.recording, 0)
    assert f"of the {lacking[0]} scans that it knew, the base station in fact lacked" in told
    assert "it knew no place where the base station is certain to hear it" in told
    told = explain(run.recording, 1)
    assert re.search(r"of the \d+ scans that it knew, the base station in fact lacked \d+", told)
    assert "it knew no place" not in told


def test_robots_that_were_not_heard_where_they_should_be_are_told():
    run = _falls_silent([(1.0, 0.6)], radio_range_m=1.5)
    lacking = _lacking(run)[0]
    assert lacking > 0
    told = f"robot 0 did not bring home {lacking} of its scans: see multisrt why"
    assert not_delivered(run) == told


def test_each_robot_has_its_own_reason():
    # The radio of robot 0 fails beside the base station; robot 1 does not get there.
    run = _falls_silent([(1.0, 0.6), (1.0, 5.4)], radio_range_m=3.0)
    lacking = _lacking(run)
    assert not_delivered(run) == (
        f"robots 0 and 1 did not bring home {lacking.total()} of their scans: robot 1 knew no "
        "place where the base station is certain to hear a robot; start robots there (--starts "
        "base); of the others see multisrt why"
    )


def test_teams_that_started_at_the_base_station_get_other_advice():
    run = ms.explore(
        Environment("hall", shapely.box(0, 0, 30, 12)),
        strategy="srt-radial",
        robots=2,
        beams=90,
        base=(15.1, 0.02),
        starts="base",
        radio=ms.RadioSpec(range_m=14.0, walls="block"),
        max_time_s=60.0,
        options=IN_TIME,
    )
    assert "; move the base station away from walls" in not_delivered(run)


def _falls_silent(starts: list[tuple[float, float]], radio_range_m: float) -> ms.Run:
    return ms.explore(
        BEND,
        strategy="minpos",
        starts=starts,
        base=(1.0, 0.6),
        radio_range_m=radio_range_m,
        max_time_s=60.0,
        faults=[ms.Silence(robot=0, time_s=5.0, duration_s=100.0)],
        options=IN_TIME,
    )


def _lacking(run: ms.Run) -> Counter[int]:
    known = {name for event in run.recording.of(BaseLearned) for name in event.nodes}
    return Counter(
        node.robot for node in run.recording.of(NodeAdded) if (node.robot, node.serial) not in known
    )
