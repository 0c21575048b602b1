"""What robots were doing, by hand-made recordings."""

import itertools
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, Literal

import pytest
from msgspec.structs import replace

import multisrt as ms
from multisrt.analysis.activity import ACTIVITIES, Spell, activities
from multisrt.events import (
    AnyEvent,
    CameBack,
    Coordinated,
    Ended,
    FellSilent,
    Joined,
    Organized,
)
from multisrt.recording import Recording
from multisrt.spec import LateStart, RadioSpec

TWO = [(1.0, 1.0, 0.0), (3.0, 1.0, 0.0)]


@pytest.fixture(scope="module")
def team(recorded) -> Callable[..., Recording]:
    """Build a recording of two robots, with a radio that reaches everywhere."""
    return partial(recorded, starts=TWO)


def ended(time_s: float, robot: int = 0) -> Ended:
    return Ended(time_s=time_s, robot=robot, reason="done", complete=True, frontier=())


def coordinated(time_s: float, robot: int, order: Literal["keep", "wait"]) -> Coordinated:
    return Coordinated(
        time_s=time_s, robot=robot, ger=(0, 1), master=1, feasible=(), unfeasible=(0, 1),
        target=(1.0, 1.0), order=order, new_target=(1.0, 1.0),
    )  # fmt: skip


def organized(time_s: float, robot: int) -> Organized:
    return Organized(
        time_s=time_s, robot=robot, feasible=(), unfeasible=(0, 1), before={}, after={},
        orders={}, conflicts=(),
    )  # fmt: skip


def spells(*borders: Any) -> list[Spell]:
    """Read times and activities in turn."""
    times, doing = borders[::2], borders[1::2]
    return [Spell(a, b, c) for (a, b), c in zip(itertools.pairwise(times), doing, strict=True)]


def test_a_robot_that_does_nothing_waits(recorded):
    assert activities(recorded()) == [spells(0.0, "waits", 50.0)]


def test_a_run_of_no_duration_has_no_spells(recorded):
    assert activities(recorded(end_s=0.0)) == [[]]


def test_moving_turning_and_stopping_on_the_way(recorded, moved):
    way = moved(
        (2.0, 1.0, 1.0, 0.0),
        (4.0, 1.0, 1.0, 1.0),
        (9.0, 3.0, 1.0, 1.0),
        (12.0, 3.0, 1.0, 1.0),  # it stands for 3 s
        (15.0, 4.0, 1.0, 1.0),
    )
    expected = spells(0.0, "waits", 2.0, "moves", 9.0, "waits", 12.0, "moves", 15.0, "waits", 50.0)
    assert activities(recorded(way)) == [expected]


def test_motions_that_follow_at_once_are_one_spell(recorded, moved):
    one = moved((0.0, 1.0, 1.0, 0.0), (4.0, 2.0, 1.0, 0.0))
    two = moved((4.0, 2.0, 1.0, 0.0), (50.0, 3.0, 1.0, 0.0))
    assert activities(recorded(one, two)) == [spells(0.0, "moves", 50.0)]


def test_only_motions_for_other_trees_are_support(recorded, moved):
    one = moved((0.0, 1.0, 1.0, 0.0), (4.0, 2.0, 1.0, 0.0))
    two = moved((4.0, 2.0, 1.0, 0.0), (6.0, 3.0, 1.0, 0.0))
    three = moved((6.0, 3.0, 1.0, 0.0), (7.0, 4.0, 1.0, 0.0))
    ways = [replace(one, purpose="support"), two, replace(three, purpose="home")]
    expected = spells(0.0, "supports", 4.0, "moves", 7.0, "waits", 50.0)
    assert activities(recorded(*ways)) == [expected]


def test_a_stand_in_which_a_master_organises_is_coordination(team, moved):
    events: Sequence[AnyEvent] = [
        moved((0.0, 1.0, 1.0, 0.0), (4.0, 2.0, 1.0, 0.0)),
        coordinated(6.0, 0, "wait"),
        organized(6.0, 1),
        coordinated(9.0, 0, "keep"),
        moved((9.0, 2.0, 1.0, 0.0), (12.0, 3.0, 1.0, 0.0)),
        moved((20.0, 3.0, 1.0, 0.0), (30.0, 4.0, 1.0, 0.0)),
        moved((7.0, 3.0, 1.0, 0.0), (8.0, 4.0, 1.0, 0.0), robot=1),
    ]
    first, second = activities(team(*events))
    assert first == spells(
        0.0, "moves", 4.0, "coordinates", 9.0, "moves", 12.0, "waits", 20.0, "moves", 30.0,
        "waits", 50.0,
    )  # fmt: skip
    assert second == spells(0.0, "coordinates", 7.0, "moves", 8.0, "waits", 50.0)


def test_orders_that_are_carried_out_at_once_take_no_time(team, moved):
    one = moved((0.0, 1.0, 1.0, 0.0), (4.0, 2.0, 1.0, 0.0))
    two = moved((4.0, 2.0, 1.0, 0.0), (6.0, 3.0, 1.0, 0.0))
    first, _ = activities(team(one, coordinated(4.0, 0, "keep"), two))
    assert first == spells(0.0, "moves", 6.0, "waits", 50.0)


def test_a_robot_that_is_called_on_is_done_until_it_sets_out(recorded, moved):
    way = moved((30.0, 1.0, 1.0, 0.0), (35.0, 2.0, 1.0, 0.0))
    found = activities(recorded(ended(10.0), way, ended(40.0)))
    assert found == [
        spells(0.0, "waits", 10.0, "done", 30.0, "moves", 35.0, "waits", 40.0, "done", 50.0)
    ]


def test_late_starts_and_deaths(team, moved, died):
    recording = team(
        moved((0.0, 1.0, 1.0, 0.0), (5.0, 6.0, 1.0, 0.0)),
        died(5.0, 0),
        Joined(time_s=20.0, robot=1),
        ended(30.0, 1),
        died(40.0, 1),
        faults=(LateStart(robot=1, time_s=20.0),),
    )
    first, second = activities(recording)
    assert first == spells(0.0, "moves", 5.0, "dead", 50.0)
    assert second == spells(
        0.0, "not started", 20.0, "waits", 30.0, "done", 40.0, "dead", 50.0
    )  # fmt: skip
    never = team(faults=(LateStart(robot=1, time_s=90.0),))
    assert activities(never)[1] == spells(0.0, "not started", 50.0)


def test_a_silent_radio_cuts_both_robots_off(team, moved):
    recording = team(
        moved((0.0, 1.0, 1.0, 0.0), (20.0, 6.0, 1.0, 0.0)),
        FellSilent(time_s=10.0, robot=1),
        CameBack(time_s=30.0, robot=1),
        ended(25.0, 1),
    )
    first, second = activities(recording)
    assert first == spells(0.0, "moves", 10.0, "cut off", 30.0, "waits", 50.0)
    assert second == spells(0.0, "waits", 10.0, "cut off", 25.0, "done", 50.0)


def test_a_robot_out_of_range_is_cut_off(recorded, moved):
    # From 2 m to 7 m apart and on, at 1 m/s, with a radio of 4 m.
    way = moved((0.0, 3.0, 1.0, 0.0), (5.0, 8.0, 1.0, 0.0), robot=1)
    made = recorded(way, starts=TWO, radio=RadioSpec(range_m=4.0))
    assert activities(made, with_isolation=False) == [
        spells(0.0, "waits", 50.0),
        spells(0.0, "moves", 5.0, "waits", 50.0),
    ]
    found = activities(made)
    assert [[doing for *_, doing in robot] for robot in found] == [
        ["waits", "cut off"],
        ["moves", "cut off"],
    ]
    assert found[0][0].end_s == pytest.approx(2.0, abs=1e-6)


def test_motions_beyond_the_end_are_cut(recorded, moved):
    way = moved((45.0, 1.0, 1.0, 0.0), (55.0, 2.0, 1.0, 0.0))
    assert activities(recorded(way)) == [spells(0.0, "waits", 45.0, "moves", 50.0)]


@pytest.mark.slow
@pytest.mark.parametrize("strategy", ["srt-radial", "utility"])
def test_spells_partition_real_runs(strategy):
    run = ms.explore(
        "rooms", strategy=strategy, robots=3, starts="clustered", seed=1, max_time_s=60.0,
        radio=RadioSpec(range_m=12.0),
    )  # fmt: skip
    found = activities(run.recording)
    assert found == activities(run.recording, run.environment)
    for robot in found:
        assert (robot[0].start_s, robot[-1].end_s) == (0.0, run.recording.footer.time_s)
        for one, two in itertools.pairwise(robot):
            assert one.start_s < one.end_s == two.start_s
            assert one.activity != two.activity
    assert {spell.activity for robot in found for spell in robot} <= set(ACTIVITIES)
    # Standing and moving are those of the measures, where nothing hides them.
    waiting = run.metrics.waiting_time_by_robot_s
    for robot, waited in zip(found, waiting, strict=True):
        doing = {activity for *_, activity in robot}
        if not doing & {"cut off", "done"}:
            stood = sum(b - a for a, b, what in robot if what in ("waits", "coordinates"))
            assert stood == pytest.approx(waited, abs=1e-6)
