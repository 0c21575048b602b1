"""Warnings about teams that stall."""

from typing import Any

import pytest
import shapely

from multisrt.environments.environment import Environment
from multisrt.robots.explorer import Done, Look, Move, Sense
from multisrt.robots.loading import load_strategy
from multisrt.robots.toolkit import trajectory
from multisrt.robots.toolkit.templates import template
from multisrt.simulation.worlds import inline
from multisrt.spec import RobotSpec, RunSpec
from multisrt.testing import check_explorer, two_rooms
from multisrt.testing.cases import Case
from multisrt.testing.check_warnings import warnings_about
from multisrt.testing.checked_run import CheckedRun
from multisrt.testing.doorway import waits_for_ever
from multisrt.testing.unfinished import Unfinished
from multisrt.testing.watchdog import Limits, Watchdog
from tests.multisrt.testing.explorers import Base, check


class RunsInto(Base):
    """Sees all at once, but drives to another robot first, and gives up before it."""

    def run(self):
        yield Sense()
        seen = yield Look()
        if seen:
            other = seen[0].configuration
            motion = trajectory(self.me.kinematics, self.at, [other])
            moved = yield Move(trajectory=motion, guard_m=0.1)
            if moved.blocked_by is not None:
                yield Done(complete=False, reason="no way is left")
                return
        yield Done(complete=True, reason="all is seen")


def run_of(robots, outcome, *unfinished, world="hall"):
    return CheckedRun(
        world=world,
        robots=robots,
        outcome=outcome,
        time_s=10.0,
        covered=0.99,
        actions={"Sense": 1, "Move": 1, "Done": 1},
        digest="0" * 64,
        unfinished=unfinished,
    )


ROOM = Environment("room", shapely.box(0.0, 0.0, 4.0, 4.0))
BLOCKED = Unfinished(robot=0, reason="no way", blocked_by=2)
BESIDE = Unfinished(robot=1, reason="no way", beside=0)
LOST = Unfinished(robot=2, reason="is lost")


def test_robots_that_stop_before_each_other_are_told():
    checked = check(RunsInto, world=ROOM, start=(2.0, 2.0), teams=(1, 2))
    (warning,) = [each for each in checked.warnings if "team" in each]
    assert warning.startswith("it stalls in a team: robot ")
    assert "('no way is left', stopped before robot " in warning
    assert "Receive(timeout_s=...)" in warning
    assert [run.outcome for run in checked.runs] == ["complete", "stalled"]
    assert checked.runs[0].unfinished == ()


def test_a_team_that_stalls_where_one_robot_completes():
    runs = [run_of(1, "complete"), run_of(3, "stalled", BLOCKED, BESIDE, LOST)]
    (warning,) = warnings_about(runs, RunsInto)
    assert warning.partition(";")[0] == (
        "it stalls in a team: robot 0 ('no way', stopped before robot 2), robot 1 ('no way', "
        "beside robot 0) and 1 more end without completing (3 robots in 'hall')"
    )
    runs += [run_of(robots, "stalled", LOST) for robots in (4, 5)]
    (warning,) = warnings_about(runs, RunsInto)
    assert ", and so in 1 other run; " in warning
    runs.append(run_of(6, "stalled", LOST))
    (warning,) = warnings_about(runs, RunsInto)
    assert "robot 2 ('is lost') ends without completing (4 robots in 'hall'), and so " in warning


def test_what_stalls_alone_too_is_no_matter_of_teams():
    assert not warnings_about([run_of(1, "stalled", LOST), run_of(3, "stalled", BLOCKED)], Base)


def test_without_a_run_alone_bodies_in_the_way_tell():
    elsewhere = run_of(1, "stalled", LOST, world="maze")
    assert not warnings_about([elsewhere, run_of(3, "stalled", LOST, BESIDE)], RunsInto)
    (warning,) = warnings_about([elsewhere, run_of(3, "stalled", LOST, BLOCKED)], RunsInto)
    assert warning.startswith("it stalls in a team")


# A robot in the doorway, and what is put on record about maps --------------------------------


def written(folder, **replaced):
    """Write the explorer of `strategy new` with some of its lines replaced; return a reference."""
    text = template("explorer", "mine", "mine.py")
    for old, new in replaced.values():
        assert old in text
        text = text.replace(old, new)
    (folder / "impatient.py").write_text(text)
    return f"{folder / 'impatient.py'}:Mine"


SMALL: dict[str, Any] = {"teams": (2,), "repeat_in_process": False}
NEVER_GIVES_UP = ("while barred < self.options.patience:", "while True:")


def doorway_case(reference, **robot):
    description = inline(two_rooms())
    spec = RunSpec(environment=description, strategy="mine", robots=(RobotSpec(**robot),) * 2)
    limits = Limits(max_time_s=1e4, max_actions=10_000, max_decision_s=10.0)
    with Watchdog(10.0) as watchdog:
        like = Case(
            load_strategy(reference),
            spec,
            two_rooms(),
            limits=limits,
            watchdog=watchdog,
            only_known=True,
        )
        return waits_for_ever(like)


@pytest.mark.slow
def test_an_explorer_that_waits_for_ever_is_told(tmp_path):
    told = doorway_case(written(tmp_path, patience=NEVER_GIVES_UP))
    assert told.startswith("it never ends where a robot that has died stands in the only doorway")
    assert "learned anything new for 600 s: robot 0 waits and robot 1 is dead" in told
    assert "end with Done(complete=False)" in told


@pytest.mark.slow
def test_an_explorer_that_gives_up_in_time_is_not(tmp_path):
    assert doorway_case(written(tmp_path)) == ""


def test_a_body_that_fits_no_doorway_is_not_tried(tmp_path):
    assert doorway_case(written(tmp_path), footprint="disc:1.2") == ""


@pytest.mark.slow
def test_nodes_that_none_learns_are_told(tmp_path):
    silent = written(tmp_path, learned=("if new:", "if False:"))
    checked = check_explorer(silent, worlds=[two_rooms()], **SMALL)
    (warning,) = checked.warnings
    assert warning.startswith("it sends nodes to other robots, and none records Learned")
    assert check_explorer(written(tmp_path), worlds=[two_rooms()], **SMALL).warnings == ()


@pytest.mark.slow
def test_an_explorer_without_map_complete_is_told(tmp_path):
    silent = written(tmp_path, complete=("if not self.knows_all:", "if False:"))
    world = [two_rooms()]
    told = str(check_explorer(silent, worlds=world, teams=(1,), repeat_in_process=False))
    assert "note: it notes no MapComplete: when a robot knows its map complete stays" in told
    told = str(check_explorer(written(tmp_path), worlds=world, teams=(1,), repeat_in_process=False))
    assert "note" not in told
