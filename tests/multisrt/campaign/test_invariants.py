"""Good runs hold all invariants; runs that were tampered with break the one that is meant."""

import dataclasses
import math
import re

import msgspec
import numpy as np
import pytest
import shapely

from multisrt.analysis.measuring import measure_with_curves
from multisrt.campaign.invariants import INVARIANTS, JudgedRun, check, measures, merging
from multisrt.campaign.tracks import Track
from multisrt.campaign.violations import MAX_LENGTH
from multisrt.environments.environment import Environment
from multisrt.events import (
    AnyEvent,
    ArcClosed,
    BaseLearned,
    CameBack,
    Collision,
    Died,
    Ended,
    FellSilent,
    GoalChosen,
    Joined,
    Learned,
    Motion,
    NodeAdded,
    Organized,
    Sensed,
    Sent,
)
from multisrt.geometry.grids.occupancy import Occupancy
from multisrt.robots.exploration_map import ExplorationMap
from multisrt.simulation.simulate import simulate
from multisrt.simulation.worlds import build_environment
from multisrt.spec import (
    BaseSpec,
    CatalogEnvironment,
    Death,
    DriveSpec,
    LateStart,
    RadioSpec,
    RangeFinderSpec,
    RobotSpec,
    RunSpec,
    Silence,
    StopRule,
)
from tests.multisrt.campaign import sampled_runs
from tests.multisrt.campaign.tampering import ROOM, changed, drive, once, written

replace = msgspec.structs.replace

OPEN = CatalogEnvironment(name="open", parameters={"size_m": 8.0})


def executed(spec: RunSpec) -> JudgedRun:
    environment = build_environment(spec.environment)
    return JudgedRun(recording=simulate(spec, environment), environment=environment)


@pytest.fixture(scope="module")
def bids() -> JudgedRun:
    """Three robots that bid, one of which dies, with a radio that walls block, and a base."""
    return executed(
        RunSpec(
            environment=OPEN,
            strategy="minpos",
            robots=(RobotSpec(), RobotSpec(), RobotSpec(footprint="box:0.5x0.3")),
            radio=RadioSpec(range_m=5.0, walls="block", latency_s=0.1),
            base=BaseSpec(x=1.0, y=1.0),
            faults=(Death(robot=1, time_s=9.0),),
            seed=3,
        )
    )


@pytest.fixture(scope="module")
def srt() -> JudgedRun:
    """Two robots of the SRT family."""
    return executed(RunSpec(environment=OPEN, robots=(RobotSpec(),) * 2, seed=3))


def broken(run: JudgedRun, name: str) -> str:
    """Return what a run says of an invariant that it breaks; empty if it holds it."""
    violation = INVARIANTS[name](run)
    if violation is None:
        return ""
    assert violation.invariant == name
    assert "\n" not in violation.says
    assert len(violation.says) <= MAX_LENGTH
    return violation.says


# Good runs -----------------------------------------------------------------------------------


def test_good_runs_hold_all_invariants(bids, srt):
    assert bids.recording.footer.outcome == srt.recording.footer.outcome == "complete"
    assert check(bids) == check(srt) == []


@pytest.mark.parametrize("number", range(8))
def test_sampled_runs_hold_all_invariants(number):
    recording, environment = sampled_runs.run(11, number)
    assert check(JudgedRun(recording=recording, environment=environment)) == []


def test_every_invariant_is_described():
    for name, invariant in INVARIANTS.items():
        assert name == name.lower() == name.replace(" ", "-").replace("_", "-")
        first = (invariant.__doc__ or "").splitlines()[0]
        assert first.startswith("Check that ")
        assert first.endswith(".")
        assert "Cost:" in (invariant.__doc__ or "")


# Collisions ----------------------------------------------------------------------------------


def test_a_disc_that_drives_into_a_wall_collides():
    into = written([drive(0, (0.0, 2.0, 1.5, 0.0), (10.0, 3.76, 1.5, 0.0))])
    beside = written([drive(0, (0.0, 2.0, 1.5, 0.0), (10.0, 3.74, 1.5, 0.0))])
    assert "robot 0 touches an obstacle" in broken(into, "no-collision")
    assert not broken(beside, "no-collision")


def test_a_disc_on_an_arc_touches_a_wall_between_waypoints():
    # Half a circle of 1.3 m around (2, 1.5): a disc of 0.25 m reaches up to 3.05 m.
    start = (3.3, 1.5, math.pi / 2)
    up = drive(0, (0.0, *start), (9.0, 0.7, 1.5, 1.5 * math.pi))
    higher = Environment("higher", shapely.box(0.0, 0.0, 4.0, 3.06))
    assert "touches" in broken(written([up], starts=(start,)), "no-collision")
    assert not broken(written([up], starts=(start,), environment=higher), "no-collision")


@pytest.mark.parametrize(("y", "touches"), [(0.45, True), (0.52, False)])
def test_a_box_that_turns_touches_a_wall_between_its_poses(y, touches):
    # It is 1 m long: free along the wall before and after half a turn, but not across it.
    turn = drive(0, (0.0, 2.0, y, 0.0), (4.0, 2.0, y, math.pi))
    run = written([turn], starts=((2.0, y, 0.0),), robots=(RobotSpec(footprint="box:1.0x0.2"),))
    assert bool(broken(run, "no-collision")) is touches


@pytest.mark.parametrize(("y", "touches"), [(0.09, True), (0.11, False)])
def test_a_box_that_drives_along_a_wall(y, touches):
    along = drive(0, (0.0, 1.0, y, 0.0), (4.0, 3.0, y, 0.0))
    run = written([along], starts=((1.0, y, 0.0),), robots=(RobotSpec(footprint="box:1.0x0.2"),))
    assert bool(broken(run, "no-collision")) is touches


@pytest.mark.parametrize(("later_s", "meet"), [(0.0, True), (1.0, True), (1.1, False)])
def test_discs_meet_at_a_time(later_s, meet):
    # Both cross (2, 1.5): a disc is 0.5 m wide, and 0.7072 s of a diagonal crossing at 0.5 m/s.
    one = drive(0, (0.0, 0.5, 1.5, 0.0), (6.0, 3.5, 1.5, 0.0))
    other = drive(1, (later_s, 2.0, 0.5, 1.57), (later_s + 4.0, 2.0, 2.5, 1.57))
    # The second one crosses at later_s + 2 s, the first one at 3 s.
    run = written([one, other], starts=((0.5, 1.5, 0.0), (2.0, 0.5, 1.57)))
    apart_m = 0.5 * abs(3.0 - (later_s + 2.0)) / math.sqrt(2.0)
    assert (apart_m < 0.5) is bool(broken(run, "no-collision"))
    assert meet or later_s > 1.0


def test_boxes_that_overlap_while_they_stand_collide():
    boxes = (RobotSpec(footprint="box:1.0x0.2"),) * 2
    over = written(starts=((1.0, 1.5, 0.0), (1.9, 1.5, 0.0)), robots=boxes)
    beside = written(starts=((1.0, 1.5, 0.0), (1.0, 1.71, 0.0)), robots=boxes)
    assert "robots 0 and 1 overlap" in broken(over, "no-collision")
    assert not broken(beside, "no-collision")


def test_a_pose_in_a_wall_is_found_in_a_run(bids):
    def into_the_wall(motion: Motion) -> Motion:
        time_s, _, y, heading = motion.waypoints[-1]
        return replace(motion, waypoints=(*motion.waypoints[:-1], (time_s, -0.1, y, heading)))

    assert "obstacle" in broken(changed(bids, once(Motion, into_the_wall, 4)), "no-collision")


def test_a_recorded_collision_is_one(bids):
    event = Collision(time_s=3.0, robot=2, configuration=(1, 1, 0), account="touched a cat")
    assert broken(changed(bids, extra=[event]), "no-collision").startswith("robot 2 touched a cat")


def seen_up_to(x: float) -> NodeAdded:
    """Return a node in the middle of the room whose region ends at x on the right."""
    return NodeAdded(
        time_s=0.0,
        robot=0,
        serial=0,
        parent=None,
        configuration=(2.0, 1.5, 0.0),
        stage="root",
        boundary=((0.0, 0.0), (x, 0.0), (x, 3.0), (0.0, 3.0)),
        tags="0000",
    )


@pytest.mark.parametrize(
    ("beams", "seen", "touches"), [(12, 4.0, True), (12, 3.0, False), (180, 3.0, True)]
)
def test_a_wall_that_a_laser_missed_is_not_known(beams, seen, touches):
    # The robot drives into the right wall, which its region reaches over, or not; 180 beams miss
    # no wall.
    robots = (RobotSpec(range_finder=RangeFinderSpec(beams=beams)),)
    narrower = Environment("narrower", shapely.box(0.0, 0.0, seen, 3.0))
    node = seen_up_to(4.0)
    move = drive(0, (0.0, 2.0, 1.5, 0.0), (10.0, seen - 0.2, 1.5, 0.0))
    run = written([node, move], environment=narrower, robots=robots)
    assert bool(broken(run, "no-collision")) is touches
    # It excuses that wall alone.
    down = drive(0, (10.0, seen - 0.2, 1.5, 0.0), (12.0, seen - 0.2, 0.1, 0.0))
    on = (down, drive(0, (12.0, seen - 0.2, 0.1, 0.0), (14.0, 1.0, 0.1, 0.0)))
    assert broken(written([node, move, *on], environment=narrower, robots=robots), "no-collision")


def test_a_region_of_a_laser_that_misses_nothing_holds_no_obstacle():
    node = seen_up_to(4.05)
    for beams, is_found in ((12, False), (180, True)):
        robots = (RobotSpec(range_finder=RangeFinderSpec(beams=beams)),)
        said = broken(written([node], robots=robots), "known-free-is-free")
        assert ("of obstacles" in said) is is_found


# Motions -------------------------------------------------------------------------------------


def test_a_doubled_speed_is_beyond_the_drive(bids, srt):
    def faster(motion: Motion) -> Motion:
        begin_s = motion.time_s
        half = [(begin_s + 0.5 * (w[0] - begin_s), *w[1:]) for w in motion.waypoints]
        return replace(motion, waypoints=tuple(half))

    for run in (bids, srt):
        assert "beyond" in broken(changed(run, once(Motion, faster, 2)), "motion-within-drive")


@pytest.mark.parametrize(
    ("kind", "waypoints", "what"),
    [
        ("differential", ((0.0, 2.0, 1.5, 0.0), (2.0, 2.5, 1.6, 0.0)), "to the side"),
        ("differential", ((0.0, 2.0, 1.5, 0.0), (2.0, 2.0, 1.5, 4.0)), "beyond 1.571 rad/s"),
        ("differential", ((0.0, 2.0, 1.5, 0.0), (2.0, 1.5, 1.5, 0.0)), ""),
        ("holonomic", ((0.0, 2.0, 1.5, 0.0), (2.0, 2.5, 1.6, 0.0)), ""),
        ("holonomic", ((0.0, 2.0, 1.5, 0.0), (2.0, 2.0, 1.5, 0.1)), "turns by"),
        ("reeds-shepp", ((0.0, 2.0, 1.5, 0.0), (2.0, 2.0, 1.5, 0.1)), "tighter than 0.5 m"),
        ("reeds-shepp", ((0.0, 2.0, 1.5, 0.0), (2.0, 1.5, 1.5, 0.0)), ""),
        ("dubins", ((0.0, 2.0, 1.5, 0.0), (2.0, 1.5, 1.5, 0.0)), "backwards"),
        (
            "dubins",
            ((0.0, 2.0, 1.0, 0.0), (2.0, 2.5, 1.5, math.pi / 2)),
            "",
        ),
        (
            "dubins",
            ((0.0, 2.0, 1.0, 0.0), (2.0, 2.4, 1.4, math.pi / 2)),
            "tighter than",
        ),
    ],
)
def test_each_drive_has_its_limits(kind, waypoints, what):
    radius = {"turning_radius_m": 0.5} if kind in ("dubins", "reeds-shepp") else {}
    robots = (RobotSpec(drive=DriveSpec(kind=kind, **radius)),)
    said = broken(written([drive(0, *waypoints)], robots=robots), "motion-within-drive")
    assert what in said
    assert bool(what) is bool(said)


def test_poses_do_not_jump(bids):
    def jump(motion: Motion) -> Motion:
        time_s, x, y, heading = motion.waypoints[0]
        return replace(motion, waypoints=((time_s, x + 0.01, y, heading), *motion.waypoints[1:]))

    assert "jumps by 0.01" in broken(changed(bids, once(Motion, jump, 3)), "motion-continuous")


@pytest.mark.parametrize("turn", [0.0, 1e-13, 1.2e-12, 1e-9, 1e-8, 1e-6])
def test_a_leg_that_hardly_turns_is_where_it_begins_and_ends(turn):
    begin, end = (-0.607, 9.658, 0.959), (-0.607 + 3.0 * np.cos(0.959), 9.658 + 3.0 * np.sin(0.959))
    track = Track(begin, [drive(0, (1.0, *begin), (2.0, *end, begin[2] + turn))], 9.0)
    poses = track.at(np.array([1.0, 1.5, 2.0 - 1e-9]))
    halfway = (begin[0] + end[0]) / 2.0, (begin[1] + end[1]) / 2.0
    for pose, place in zip(poses.tolist(), (begin, halfway, end), strict=True):
        assert math.dist(pose[:2], place[:2]) < 5e-7


def test_a_left_out_motion_is_a_jump(bids):
    assert "jumps" in broken(changed(bids, once(Motion, lambda _: None, 3)), "motion-continuous")


def test_nobody_moves_when_dead_or_before_a_late_start():
    move = drive(0, (5.0, 2.0, 1.5, 0.0), (6.0, 2.5, 1.5, 0.0))
    died = Died(time_s=5.5, robot=0, configuration=(2.25, 1.5, 0.0), doing="moving")
    late = (LateStart(robot=0, time_s=8.0),)
    assert "after its death" in broken(written([move, died]), "motion-continuous")
    assert "before it is switched on" in broken(written([move], faults=late), "motion-continuous")
    assert not broken(written([move]), "motion-continuous")
    early = Died(time_s=2.0, robot=0, configuration=(2.0, 1.5, 0.0), doing="waiting")
    assert not broken(written([early], faults=late), "motion-continuous")


def test_scans_are_taken_where_the_robot_is(bids):
    def elsewhere(scan: Sensed) -> Sensed:
        x, y, heading = scan.configuration
        return replace(scan, configuration=(x, y + 1e-3, heading))

    said = broken(changed(bids, once(Sensed, elsewhere, 9)), "motion-continuous")
    assert "where its sensed event is" in said


# Free space ----------------------------------------------------------------------------------


def test_an_enlarged_region_is_not_free(bids, srt):
    def larger(node: NodeAdded) -> NodeAdded:
        x, y, _ = node.configuration
        boundary = tuple((x + 1.02 * (a - x), y + 1.02 * (b - y)) for a, b in node.boundary)
        return replace(node, boundary=boundary)

    for run in (bids, srt):
        said = broken(changed(run, once(NodeAdded, larger, 1)), "known-free-is-free")
        assert "obstacles" in said or "beyond the range" in said


def test_a_region_behind_a_corner_was_not_in_sight():
    # An L: the place sees the lower arm; the upper one is behind the corner.
    ell = Environment("L", shapely.box(0, 0, 4, 1).union(shapely.box(3, 0, 4, 3)))
    whole = ((0.0, 0.0), (4.0, 0.0), (4.0, 3.0), (3.0, 3.0), (3.0, 1.0), (0.0, 1.0))
    for corners, is_seen in ((whole, False), ((*whole[:2], (4.0, 1.0), (0.0, 1.0)), True)):
        node = NodeAdded(
            time_s=0.0,
            robot=0,
            serial=0,
            parent=None,
            configuration=(0.5, 0.5, 0.0),
            stage="root",
            boundary=tuple(corners),
            tags="0" * len(corners),
        )
        robots = (RobotSpec(range_finder=RangeFinderSpec(range_m=6.0)),)
        run = written([node], starts=((0.5, 0.5, 0.0),), environment=ell, robots=robots)
        assert ("not in sight" not in broken(run, "known-free-is-free")) is is_seen


# Starts and faults ---------------------------------------------------------------------------


AT = (1.0, 1.0, 0.5)


TURN = drive(0, (4.0, *AT), (5.0, 1.0, 1.0, 1.0))


ENDED = Ended(time_s=5.0, robot=0, reason="done", complete=True, frontier=())


def organized(time_s: float) -> Organized:
    return Organized(
        time_s=time_s,
        robot=0,
        feasible=(),
        unfeasible=(),
        before={},
        after={},
        orders={},
        conflicts=(),
    )


def died(time_s: float, doing: str = "waiting") -> Died:
    return Died(time_s=time_s, robot=0, configuration=AT, doing=doing)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("start", "faults", "events", "what"),
    [
        (AT, (), [], ""),
        (AT[:2], (), [], "starts at (1, 1, 0.5) instead of (1, 1, 0)"),
        ((1.0, 1.1, 0.5), (), [], "instead of (1, 1.1, 0.5)"),
        (None, (LateStart(robot=0, time_s=3.0),), [Joined(time_s=3.0, robot=0)], ""),
        (None, (LateStart(robot=0, time_s=3.0),), [Joined(time_s=0.0, robot=0)], "due at 3.00 s"),
        (None, (LateStart(robot=0, time_s=3.0),), [], "is not switched on"),
        (None, (LateStart(robot=0, time_s=30.0),), [], ""),
        (None, (Death(robot=0, time_s=3.0),), [died(3.0)], ""),
        (None, (Death(robot=0, time_s=3.0),), [], "does not die, 3.00 s"),
        (None, (Death(robot=0, time_s=3.0),), [died(4.0)], "does not die, 3.00 s"),
        (None, (Death(robot=0, time_s=3.0),), [died(2.0)], "which is not due"),
        (None, (Death(robot=0, time_s=3.0, when="waiting"),), [died(3.0)], ""),
        (None, (Death(robot=0, time_s=3.0, when="waiting"),), [], "does not die, 3.00 s"),
        (None, (Death(robot=0, time_s=4.5, when="waiting"),), [TURN, died(5.0)], ""),
        (None, (Death(robot=0, time_s=4.5, when="waiting"),), [TURN], "does not die, 5.00 s"),
        (None, (Death(robot=0, time_s=4.5, when="waiting"),), [TURN, ENDED], ""),
        (
            None,
            (Death(robot=0, time_s=3.0, when="master"),),
            [organized(4.0), died(4.0, "master")],
            "",
        ),
        (None, (Death(robot=0, time_s=3.0, when="master"),), [organized(2.0)], ""),
        (None, (Death(robot=0, time_s=3.0, when="master"),), [organized(4.0)], "not die, 4.00 s"),
        (None, (Death(robot=0, time_s=3.0, when="moving"),), [died(4.0)], "was to die moving"),
        (None, (Death(robot=0, time_s=3.0, when="moving"),), [], ""),
        (None, (Death(robot=0, time_s=3.0, when="moving"),), [TURN], "does not die, 5.00 s"),
        (None, (Death(robot=0, time_s=6.0, when="moving"),), [TURN], ""),
        (None, (), [died(4.0)], "which is not due"),
    ],
)
def test_starts_late_starts_and_deaths_are_as_told(start, faults, events, what):
    run = written(events, starts=(AT,), robots=(RobotSpec(start=start),), faults=faults)
    said = broken(run, "starts-and-faults")
    assert what in said
    assert bool(what) is bool(said)


def silent(*times_s: float) -> list[FellSilent | CameBack]:
    """Return a radio that fails, works again, fails again and so on."""
    kinds = (FellSilent, CameBack)
    return [kinds[k % 2](time_s=time_s, robot=0) for k, time_s in enumerate(times_s)]


@pytest.mark.parametrize(
    ("faults", "events", "what"),
    [
        ([(2.0, 3.0)], silent(2.0, 5.0), ""),
        ([(2.0, 3.0)], [], "never falls silent, which is due, 2.00 s"),
        ([(2.0, 3.0)], silent(2.0), "never works again, which is due, 5.00 s"),
        ([(2.0, 3.0)], silent(2.0, 4.0), "works again, which is not due, 4.00 s"),
        ([(2.0, 3.0), (4.0, 3.0)], silent(2.0, 7.0), ""),
        ([(2.0, 3.0), (4.0, 3.0)], silent(2.0, 5.0), "works again, which is not due, 5.00 s"),
        ([(2.0, 30.0)], silent(2.0), ""),
        ([], silent(2.0), "falls silent, which is not due"),
    ],
)
def test_radios_are_silent_as_told(faults, events, what):
    silences = tuple(Silence(robot=0, time_s=at, duration_s=lasting) for at, lasting in faults)
    said = broken(written(events, faults=silences), "starts-and-faults")
    assert what in said
    assert bool(what) is bool(said)


def test_the_dead_and_those_switched_on_late_are_silent_meanwhile():
    faults = (
        Silence(robot=0, time_s=2.0, duration_s=6.0),
        LateStart(robot=0, time_s=5.0),
        Death(robot=0, time_s=7.0),
    )
    events: list[AnyEvent] = [Joined(time_s=5.0, robot=0), FellSilent(time_s=5.0, robot=0)]
    assert broken(written([*events, died(7.0)], faults=faults), "starts-and-faults") == ""
    said = broken(written(events, faults=faults[:2]), "starts-and-faults")
    assert "never works again, which is due, 8.00 s" in said


# Messages ------------------------------------------------------------------------------------


def report(time_s: float, robot: int, *reached: int, lost: tuple[int, ...] = ()) -> Sent:
    return Sent(time_s=time_s, robot=robot, kind="report", size_bytes=9, reached=reached, lost=lost)


TWO = ((0.5, 0.5, 0.0), (3.5, 2.5, 0.0))
THREE = ((0.5, 0.5, 0.0), (2.0, 1.5, 0.0), (3.5, 2.5, 0.0))
NEAR = RadioSpec(range_m=2.0)


@pytest.mark.parametrize(
    ("sent", "starts", "spec", "what"),
    [
        (report(1.0, 0, 1), TWO, {}, ""),
        (report(1.0, 0, 1), TWO, {"radio": NEAR}, "3.606 m away"),
        (report(1.0, 0, 2), THREE, {"radio": NEAR}, ""),
        (report(1.0, 0, 2), THREE, {"radio": replace(NEAR, multi_hop=False)}, "no link"),
        (report(1.0, 0, lost=(1,)), TWO, {}, "loses none"),
        (report(1.0, 0, lost=(1,)), TWO, {"radio": RadioSpec(loss=0.5)}, ""),
        (
            report(1.0, 0, 1),
            TWO,
            {"faults": (Silence(robot=1, time_s=0.5, duration_s=1.0),)},
            "robot 1, whose radio does not work",
        ),
        (
            report(1.0, 0, 1),
            TWO,
            {"faults": (Silence(robot=0, time_s=0.5, duration_s=1.0),)},
            "sender's radio does not work",
        ),
        (
            report(1.0, 0, 2),
            THREE,
            {"radio": NEAR, "faults": (Silence(robot=1, time_s=0.5, duration_s=1.0),)},
            "no link",
        ),
        (report(1.0, 0, 1), TWO, {"faults": (LateStart(robot=1, time_s=5.0),)}, "does not work"),
        (report(1.0, 2, 0), TWO, {"base": BaseSpec(x=2.0, y=1.5), "radio": NEAR}, ""),
        (report(1.0, 2, 0), TWO, {"base": BaseSpec(x=3.0, y=1.5), "radio": NEAR}, "no link"),
    ],
)
def test_messages_come_over_links(sent, starts, spec, what):
    said = broken(written([sent], starts=starts, **spec), "messages-over-links")
    assert what in said
    assert bool(what) is bool(said)


@pytest.mark.parametrize(
    ("walls", "range_m", "what"),
    [("pass", 4.0, ""), ("block", 4.0, "no link"), ("weaken", 4.0, "no link"), ("weaken", 9.0, "")],
)
def test_walls_block_or_weaken_links(walls, range_m, what):
    # Two walls of 5 dB: 4 m become 4 / 10 ** 0.5 = 1.26 m, and 9 m become 2.85 m; it takes 2.5 m.
    pillars = shapely.box(1.0, 0.5, 1.2, 2.5).union(shapely.box(2.0, 0.5, 2.2, 2.5))
    world = Environment("pillars", ROOM.free.difference(pillars))
    radio = RadioSpec(range_m=range_m, walls=walls)
    run = written(
        [report(1.0, 0, 1)],
        starts=((0.4, 1.5, 0.0), (2.9, 1.5, 0.0)),
        environment=world,
        radio=radio,
    )
    said = broken(run, "messages-over-links")
    assert what in said
    assert bool(what) is bool(said)


def test_a_message_after_death_reaches_nobody(bids):
    died = bids.recording.of(Died)[0]

    def too_late(sent: Sent) -> Sent:
        return replace(sent, reached=(died.robot,))

    late = [
        k for k, e in enumerate(bids.recording.of(Sent)) if e.time_s > died.time_s and not e.robot
    ]
    assert f"robot {died.robot}" in broken(
        changed(bids, once(Sent, too_late, late[0])), "messages-over-links"
    )


@pytest.mark.parametrize(
    ("sent", "starts", "spec", "what"),
    [
        (report(1.0, 0, 1, 2), THREE, {}, ""),
        (report(1.0, 0, 1), THREE, {}, ""),  # it may be for robot 1 alone
        (report(1.0, 0, 1, 3), THREE, {"base": BaseSpec(x=2.0, y=1.5)}, "does not reach robot 2"),
        (report(1.0, 0, 1, 2), THREE, {"base": BaseSpec(x=2.0, y=1.5)}, "not reach the base"),
        (report(1.0, 0, 1, lost=(2,)), THREE, {"radio": RadioSpec(loss=0.5)}, ""),
        (report(1.0, 0), TWO, {}, "reaches nobody, but all others are in reach"),
        (report(1.0, 0), TWO, {"radio": NEAR}, ""),
        (report(1.0, 0), TWO, {"faults": (Silence(robot=1, time_s=0.5, duration_s=1.0),)}, ""),
        (report(1.0, 1, 0, 2), THREE, {"radio": replace(NEAR, multi_hop=False)}, ""),
        (replace(report(1.0, 0, 1), kind="no place"), THREE, {"radio": NEAR}, "reach robot 2"),
        (
            replace(report(1.0, 0, 1), kind="no place"),
            THREE,
            {"radio": replace(NEAR, multi_hop=False)},
            "",
        ),
        (
            replace(report(1.0, 0), kind="no place"),
            THREE,
            {"radio": NEAR, "faults": (Silence(robot=1, time_s=0.5, duration_s=1.0),)},
            "",
        ),
    ],
)
def test_messages_to_all_reach_all_in_reach(sent, starts, spec, what):
    said = broken(written([sent], starts=starts, **spec), "reaches-all-in-reach")
    assert what in said
    assert bool(what) is bool(said)


@pytest.mark.parametrize(
    ("walls", "range_m", "is_in_reach"),
    [("pass", 4.0, True), ("block", 4.0, False), ("weaken", 4.0, False), ("weaken", 9.0, True)],
)
def test_walls_excuse_messages_that_reach_nobody(walls, range_m, is_in_reach):
    pillars = shapely.box(1.0, 0.5, 1.2, 2.5).union(shapely.box(2.0, 0.5, 2.2, 2.5))
    world = Environment("pillars", ROOM.free.difference(pillars))
    run = written(
        [report(1.0, 0)],
        starts=((0.4, 1.5, 0.0), (2.9, 1.5, 0.0)),
        environment=world,
        radio=RadioSpec(range_m=range_m, walls=walls),
    )
    assert bool(broken(run, "reaches-all-in-reach")) is is_in_reach


def test_a_relayed_message_that_is_kept_back_is_found(bids):
    several = [k for k, e in enumerate(bids.recording.of(Sent)) if len(e.reached) > 1]
    assert several
    kept_back = changed(
        bids, lambda e: replace(e, reached=e.reached[:1]) if isinstance(e, Sent) else e
    )
    assert broken(bids, "reaches-all-in-reach") == broken(kept_back, "reaches-all-in-reach") == ""
    whole = executed(RunSpec(environment=OPEN, strategy="minpos", robots=(RobotSpec(),) * 4))
    fewer = changed(
        whole,
        lambda e: replace(e, reached=e.reached[:2]) if isinstance(e, Sent) else e,
    )
    assert broken(whole, "reaches-all-in-reach") == ""
    assert "robot 3, which is in reach" in broken(fewer, "reaches-all-in-reach")


# Knowledge -----------------------------------------------------------------------------------


def test_a_node_is_not_learned_without_a_message(bids, srt):
    for run in (bids, srt):
        learned = run.recording.of(Learned)[0]
        silent = changed(run, lambda e: replace(e, reached=()) if isinstance(e, Sent) else e)
        said = broken(silent, "knowledge-by-scan-or-message")
        assert said, "nobody can know of others"
        first = f"learns of node {learned.nodes[0][1]} of robot {learned.nodes[0][0]}"
        assert first in said or "of which it cannot have heard" in said


def test_a_node_is_not_learned_before_the_latency(bids):
    early = changed(
        bids, lambda e: replace(e, time_s=e.time_s - 0.05) if isinstance(e, Learned) else e
    )
    assert "which no message can have brought" in broken(early, "knowledge-by-scan-or-message")


def test_who_hears_a_report_learns_what_it_is_about(bids, srt):
    for run in (bids, srt):
        last = len(run.recording.of(Learned)) - 1
        assert broken(run, "hearers-learn") == ""
        deaf = changed(run, lambda e: None if isinstance(e, Learned) and e.robot == 0 else e)
        whole = run.recording.footer.outcome == "complete"
        assert last > 0
        assert ("robot 0 heard at" in broken(deaf, "hearers-learn")) is whole


def test_a_base_station_that_hears_of_nodes_learns_them():
    run = executed(
        RunSpec(
            environment=OPEN, strategy="minpos", robots=(RobotSpec(),), base=BaseSpec(x=2.0, y=2.0)
        )
    )
    assert run.recording.footer.outcome == "complete"
    assert broken(run, "hearers-learn") == ""
    lost = changed(run, once(BaseLearned, lambda _: None))
    assert "the base station heard at" in broken(lost, "hearers-learn")
    for excused in (
        changed(lost, extra=[FellSilent(time_s=run.end_s, robot=0)]),
        changed(lost, outcome="out_of_time"),
    ):
        assert broken(excused, "hearers-learn") == ""


def test_a_node_is_noted_where_a_scan_was_taken(bids):
    blind = changed(bids, once(Sensed, lambda _: None))
    assert "where it has taken no scan" in broken(blind, "knowledge-by-scan-or-message")


def test_a_goal_is_not_chosen_with_a_robot_never_heard():
    chosen = GoalChosen(
        time_s=2.0, robot=0, rule="minpos", because="start", goal=None, robots=(0, 2)
    )
    near = RadioSpec(latency_s=0.5)
    relayed = [report(0.4, 2, 1), report(1.0, 1, 0)]
    for messages, has_heard in (
        ([], False),
        ([report(1.0, 2, 1)], False),
        ([report(1.0, 2, 0)], True),
        ([report(1.6, 2, 0)], False),
        (relayed, True),
        (relayed[::-1], False),
    ):
        said = broken(
            written([*messages, chosen], starts=THREE, radio=near), "knowledge-by-scan-or-message"
        )
        assert ("robot 2, of which it cannot have heard" in said) is not has_heard


# Measures and maps ---------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("change", "what"),
    [
        (lambda m: {"seen_area_m2": 0.9 * m.covered_area_m2}, "are covered, but"),
        (lambda m: {"explorable_area_m2": 0.9 * m.seen_area_m2}, "are seen, but"),
        (lambda m: {"explorable_area_m2": 2.0 * m.free_area_m2}, "are explorable, but"),
        (lambda m: {"time_to_95_s": m.time_to_99_s, "time_to_99_s": m.time_to_95_s}, "90, 95, 99"),
        (lambda m: {"time_to_99_s": m.makespan_s + 1.0}, "90, 95, 99"),
        (lambda m: {"delivered_coverage": m.coverage + 0.01}, "are delivered, but"),
        (lambda m: {"covered_area_m2": 0.9 * m.covered_area_m2}, "only"),
        (lambda m: {"coverage": 1.1}, "no share"),
        (lambda m: {"lower_bound_s": m.makespan_s + 1.0}, "less than its bound"),
    ],
)
def test_inconsistent_measures_are_found(bids, monkeypatch, change, what):
    metrics, curves = measure_with_curves(bids.recording, bids.environment)
    wrong = replace(metrics, **change(metrics))
    monkeypatch.setattr(measures, "measure_with_curves", lambda *_: (wrong, curves))
    assert what in broken(bids, "measures-consistent")


def test_coverage_that_falls_is_found(bids, monkeypatch):
    metrics, curves = measure_with_curves(bids.recording, bids.environment)
    times = list(curves.covered_at_s)
    half_s = times[48]
    assert half_s is not None
    times[50] = half_s - 0.1
    wrong = curves._replace(covered_at_s=tuple(times))
    monkeypatch.setattr(measures, "measure_with_curves", lambda *_: (metrics, wrong))
    assert "50 % are covered before 49 %" in broken(bids, "measures-consistent")


def test_maps_that_depend_on_the_order_are_found(bids, srt, monkeypatch):
    whole = ExplorationMap.merge
    monkeypatch.setattr(
        ExplorationMap, "merge", lambda known, entries: whole(known, list(entries)[:-1])
    )
    for run in (bids, srt):
        assert "merged in another order, gives other nodes" in broken(run, "merge-order")


@pytest.mark.parametrize(
    ("closer", "reason", "whose"),
    [
        (1, "not reachable", "robot 0"),
        (0, "not reachable", "robot 1"),
        (0, "too narrow", "robot 1"),
        (1, "too narrow", ""),
        (0, "seen from near", ""),
    ],
)
def test_closings_of_others_that_are_applied_are_found(monkeypatch, closer, reason, whose):
    # Robot 1 is narrower than robot 0, and closes the arcs of the first node of robot 0.
    robots = (RobotSpec(), RobotSpec(footprint="disc:0.2"))
    spec = RunSpec(environment=OPEN, robots=robots, seed=3, stop=StopRule(max_time_s=1.0))
    run = executed(spec)
    first = next(node for node in run.recording.of(NodeAdded) if node.robot == 0)
    ends = zip(first.boundary, (*first.boundary[1:], first.boundary[0]), strict=True)
    arc = tuple((*p, *q) for (p, q), tag in zip(ends, first.tags, strict=True) if tag == "1")
    closed = ArcClosed(time_s=1.0, robot=closer, node=(0, first.serial), reason=reason, arc=arc)
    tampered = changed(run, extra=[closed])
    assert broken(tampered, "closings-apply-where-valid") == ""
    monkeypatch.setattr(ExplorationMap, "_applies", lambda known, closing: True)
    said = broken(tampered, "closings-apply-where-valid")
    assert (f"changes the map of {whose}: with 1 such arcs" in said) if whose else not said


def test_rasters_that_depend_on_the_order_are_found(bids, monkeypatch):
    class Forgetful(Occupancy):
        """Takes in three regions, and no more."""

        taken = 0

        def add(self, region):
            self.taken += 1
            return super().add(region) if self.taken <= 3 else 0

    monkeypatch.setattr(merging, "raster_for", lambda *_: Forgetful(0.1, 0.3))
    assert "gives other cells" in broken(bids, "merge-order")


# Ends ----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("footer", "what"),
    [
        ({"reason": " "}, "without a reason"),
        ({"outcome": "done"}, "the outcome is 'done'"),
        ({"outcome": "out_of_time"}, "before the limit"),
        ({"outcome": "stalled"}, "but all robots that live ended completely"),
        ({"time_s": 1.0}, "after the end"),
        ({"time_s": 900.0}, "it ends at 900.00 s, but the last event is at"),
        ({"time_s": 1e6}, "beyond its limit"),
    ],
)
def test_runs_end_as_they_say(srt, footer, what):
    assert what in broken(changed(srt, **footer), "ends")


def test_a_complete_run_has_robots_that_ended(srt):
    without = changed(srt, lambda e: None if isinstance(e, Ended) and e.robot == 1 else e)
    assert "robot 1 has not ended" in broken(without, "ends")
    given_up = changed(srt, lambda e: replace(e, complete=False) if isinstance(e, Ended) else e)
    assert "ended incomplete" in broken(given_up, "ends")


def test_nobody_is_to_wait_for_a_message_that_never_comes(srt):
    waits = changed(srt, outcome="stalled", reason="robot 1 waits for a message that never comes")
    without = changed(waits, lambda e: None if isinstance(e, Ended) and e.robot == 1 else e)
    assert "never comes" in broken(without, "ends")


def test_too_many_events_are_found():
    scans = [Sensed(time_s=20.0, robot=0, configuration=(2.0, 1.5, 0.0))] * 4001
    assert "4001 events in 20.0 s, more than 4000" in broken(written(scans), "ends")
    assert not broken(written(scans[:4000]), "ends")


@pytest.mark.parametrize(
    ("reason", "time_s", "spec", "what"),
    [
        ("boxed in by robot 1, which does not give way", 5.0, {}, ""),
        ("no time is left for another goal and the way home", 19.0, {}, ""),
        ("no time is left for another goal and the way home", 5.0, {}, "995 s before the limit"),
        (
            "no time is left for another goal and the way home",
            5.0,
            {"options": {"home": "relays"}},
            "",
        ),
        ("it has had enough", 5.0, {}, "which is no reason"),
        ("it has had enough", 5.0, {"strategy": "informed"}, ""),
        (
            "the planner has no target, with 2.0 m of frontier left open at 1 nodes",
            5.0,
            {"strategy": "srt-radial"},
            "which must not happen",
        ),
        (
            "the planner has no target, with 2.0 m of frontier left open at 1 nodes",
            5.0,
            {"strategy": "srt-radial", "options": {"complete": False}},
            "",
        ),
    ],
)
def test_robots_end_incomplete_for_a_reason(reason, time_s, spec, what):
    end = Ended(time_s=time_s, robot=0, reason=reason, complete=False, frontier=())
    limit_s = 20.0 if time_s == 19.0 else 1000.0
    spec = {"strategy": "minpos", **spec}
    run = written([end], end_s=time_s, stop=StopRule(max_time_s=limit_s), **spec)
    said = broken(run, "incomplete-for-a-reason")
    assert what in said
    assert bool(what) is bool(said)


# Complete, boxed in, and waiting ---------------------------------------------------------------


def cut_off(run: JudgedRun, until_s: float, reason: str, complete: bool) -> JudgedRun:
    """Return a run that ends early, of whose robots each says the same."""
    ends = [
        Ended(time_s=until_s, robot=robot, reason=reason, complete=complete, frontier=())
        for robot in run.robots
        if run.present_s(robot)[1] > until_s
    ]
    outcome = "complete" if complete else "stalled"
    return changed(
        run,
        lambda e: None if isinstance(e, Ended) else e,
        extra=ends,
        until_s=until_s,
        time_s=until_s,
        outcome=outcome,
    )


@pytest.mark.parametrize("share", [0.1, 0.3, 0.5])
def test_a_run_that_is_cut_off_is_not_complete(bids, srt, share):
    for run in (bids, srt):
        early = cut_off(run, share * run.end_s, "nothing is left", complete=True)
        said = broken(early, "complete-is-complete")
        assert "but could go to" in said
        assert "(nothing is left)" in said


def test_long_reasons_of_robots_are_cut(bids):
    reason = "boxed in by robots 1, 2, 3, 4, 5, 6, 7, 8, 9, 10 and 11, with some frontier left"
    early = cut_off(bids, 0.1 * bids.end_s, reason, complete=True)
    said = broken(early, "complete-is-complete")
    assert "(boxed in by robots 1, 2, 3, 4, 5, ...)" in said
    assert re.search(r"but could go to \(-?\d+\.\d\d, -?\d+\.\d\d\) and see \d+\.\d\d m", said)


def test_a_robot_in_the_open_is_not_boxed_in(bids, srt):
    for run in (bids, srt):
        early = cut_off(run, 0.2 * run.end_s, "boxed in by robot 1, which stands", complete=False)
        assert "boxed in by robot 1" in broken(early, "boxed-in-is-boxed-in")


@pytest.mark.parametrize(("spacing", "has_looked"), [(0.5, False), (8.0, True)])
def test_places_beside_nodes_of_trees_count_as_looked_from(srt, spacing, has_looked):
    options = {"completion_spacing": spacing}
    spec = replace(srt.recording.spec, options=options)
    header = replace(srt.recording.header, spec=spec)
    early = cut_off(srt, 0.3 * srt.end_s, "nothing is left", complete=True)
    recording = dataclasses.replace(early.recording, header=header)
    run = JudgedRun(recording=recording, environment=srt.environment)
    assert bool(broken(run, "complete-is-complete")) is not has_looked


CORRIDOR_TO_5_M = NodeAdded(
    time_s=0.0,
    robot=0,
    serial=0,
    parent=None,
    configuration=(1.2, 0.5, 0.0),
    stage="root",
    boundary=((0.0, 0.0), (5.0, 0.0), (5.0, 1.0), (0.0, 1.0)),
    tags="0100",
)
"""What a first scan shows of a corridor of 1 m."""


@pytest.mark.parametrize(
    ("behind_m", "is_closed", "is_left"),
    [(0.5, True, True), (0.17, True, False), (0.17, False, True)],
)
def test_an_arc_seen_from_near_counts_if_a_scan_shows_more(behind_m, is_closed, is_left):
    # A corridor of 1 m whose end is unknown; an area of d_min squared is 0.16 m2.
    world = Environment("corridor", shapely.box(0.0, 0.0, 5.0 + behind_m, 1.0))
    closed = ArcClosed(
        time_s=1.0, robot=0, node=(0, 0), reason="seen from near", arc=((5.0, 0.0, 5.0, 1.0),)
    )
    end = Ended(time_s=1.0, robot=0, reason="nothing is left", complete=True, frontier=())
    run = written(
        [CORRIDOR_TO_5_M, *[closed] * is_closed, end],
        starts=((1.2, 0.5, 0.0),),
        environment=world,
        robots=(RobotSpec(footprint="disc:0.2"),),
        strategy="srt-star",
    )
    assert bool(broken(run, "complete-is-complete")) is is_left


@pytest.mark.parametrize(("there", "way_is_free"), [(2.5, False), (0.4, True)])
def test_a_robot_behind_a_body_is_boxed_in(there, way_is_free):
    # A corridor of 1 m: robot 1 stands in it, and robot 0 has seen past it, up to 5 m.
    world = Environment("corridor", shapely.box(0.0, 0.0, 12.0, 1.0))
    robots = (RobotSpec(footprint="disc:0.2"), RobotSpec(footprint="disc:0.3"))
    end = Ended(
        time_s=1.0,
        robot=0,
        reason="boxed in by robot 1, which does not give way",
        complete=False,
        frontier=(),
    )
    run = written(
        [CORRIDOR_TO_5_M, end],
        starts=((1.2, 0.5, 0.0), (there, 0.5, 0.0)),
        environment=world,
        robots=robots,
        strategy="closest",
        options={"cell_m": 0.05, "margin_m": 0.0, "min_frontier_m": 0.1},
    )
    assert bool(broken(run, "boxed-in-is-boxed-in")) is way_is_free


@pytest.mark.parametrize(
    ("range_m", "walls", "is_left"),
    [(7.0, "pass", True), (5.0, "pass", False), (7.0, "block", False)],
)
def test_a_goal_that_needs_no_relay_is_reached_by_a_chain(range_m, walls, is_left):
    # The frontier is at 5 m, and the base station at 0.5 m hears it from up to 0.9 of the range.
    world = Environment("corridor", shapely.box(0.0, 0.0, 12.0, 1.0))
    reason = "no goal is left from which the chain reaches the base station"
    end = Ended(time_s=1.0, robot=0, reason=reason, complete=False, frontier=())
    run = written(
        [CORRIDOR_TO_5_M, end],
        starts=((1.2, 0.5, 0.0), (0.4, 0.5, 0.0)),
        environment=world,
        robots=(RobotSpec(footprint="disc:0.2"),) * 2,
        strategy="closest",
        base=BaseSpec(x=0.5, y=0.5),
        radio=RadioSpec(range_m=range_m, walls=walls),
        options={"home": "chain", "cell_m": 0.05, "margin_m": 0.0, "min_frontier_m": 0.1},
    )
    assert bool(broken(run, "chain-reaches-no-goal")) is is_left


@pytest.mark.parametrize("name", ["bids", "srt"])
def test_a_team_that_stands_for_ever_is_found(name, request):
    run = request.getfixturevalue(name)
    stands = changed(
        run,
        lambda e: None if isinstance(e, Ended) else e,
        time_s=run.end_s + 5000.0,
        outcome="out_of_time",
    )
    assert "anything from" in broken(stands, "waits-within-limits")


def test_one_robot_of_a_team_that_waits_for_ever_is_found():
    # Robot 0 stands from 1 s on, while robot 1 drives to and fro.
    there = [drive(1, (4.0 * k, 0.5, 2.5, 0.0), (4.0 * k + 2.0, 1.5, 2.5, 0.0)) for k in range(100)]
    back = [
        drive(1, (4.0 * k + 2.0, 1.5, 2.5, 0.0), (4.0 * k + 4.0, 0.5, 2.5, 0.0)) for k in range(100)
    ]
    moves = [drive(0, (0.0, 3.0, 0.5, 0.0), (1.0, 3.5, 0.5, 0.0)), *there, *back]
    starts = ((3.0, 0.5, 0.0), (0.5, 2.5, 0.0))
    for strategy, end_s, is_found in (
        ("minpos", 400.0, True),
        ("minpos", 150.0, False),
        ("srt-radial", 400.0, False),
    ):
        until = [move for move in moves if move.waypoints[-1][0] <= end_s]
        run = written(until, starts=starts, strategy=strategy, end_s=end_s)
        assert ("robot 0 does not do" in broken(run, "waits-within-limits")) is is_found


def test_a_robot_that_is_called_on_has_not_ended():
    end = Ended(time_s=2.0, robot=0, reason="done", complete=True, frontier=())
    called_on = drive(0, (10.0, 2.0, 1.5, 0.0), (11.0, 2.5, 1.5, 0.0))
    ended = written([end], strategy="minpos", end_s=400.0, outcome="out_of_time")
    assert not broken(ended, "waits-within-limits")
    on = written([end, called_on], strategy="minpos", end_s=400.0, outcome="out_of_time")
    assert broken(on, "waits-within-limits")
    # A motion is recorded when it is over, after later events.
    scan = Sensed(time_s=12.0, robot=0, configuration=(2.5, 1.5, 0.0))
    late = written([end, scan, called_on], strategy="minpos", end_s=400.0, outcome="out_of_time")
    assert broken(late, "waits-within-limits")
    # It ends again as before, which is not recorded.
    nothing = GoalChosen(time_s=12.0, robot=0, rule="minpos", because="gave way", goal=None)
    again = written(
        [end, called_on, nothing], strategy="minpos", end_s=400.0, outcome="out_of_time"
    )
    assert not broken(again, "waits-within-limits")
    chooses = written([called_on, nothing], strategy="minpos", end_s=400.0, outcome="out_of_time")
    assert broken(chooses, "waits-within-limits")
    # One that gives way has still ended: the SRT family records nothing more of it.
    aside = msgspec.structs.replace(called_on, purpose="give way")
    stays = written([end, aside], strategy="srt-star", end_s=900.0, outcome="out_of_time")
    assert not broken(stays, "waits-within-limits")


def test_a_robot_that_makes_tiny_motions_for_ever_is_found():
    ends = ((1.0, 1.5, 0.0), (1.005, 1.5, 0.0))
    for count, is_found in ((100, False), (200, True)):
        moves = [
            drive(0, (2.0 * k, *ends[k % 2]), (2.0 * k + 1.0, *ends[1 - k % 2]))
            for k in range(count)
        ]
        run = written(moves, starts=((1.0, 1.5, 0.0),), strategy="closest", end_s=2.0 * count)
        assert bool(broken(run, "drives-get-somewhere")) is is_found


def to_and_fro(laps: int) -> list[Motion]:
    """Return motions of 2 m each, two in a lap of 8 s."""
    ends = ((1.0, 1.5, 0.0), (3.0, 1.5, 0.0), (1.0, 1.5, 0.0))
    return [
        drive(0, (4.0 * k, *ends[k % 2]), (4.0 * k + 4.0, *ends[k % 2 + 1]))
        for k in range(2 * laps)
    ]


def test_a_robot_that_drives_in_circles_is_found():
    # The walls of the room are 14 m long.
    def run(laps, *events, strategy="closest"):
        return written(
            [*to_and_fro(laps), *events],
            starts=((1.0, 1.5, 0.0),),
            strategy=strategy,
            end_s=8.0 * laps,
            outcome="out_of_time",
        )

    name = "drives-get-somewhere"
    assert not broken(run(3), name)
    assert "robot 0 drives 16.1 m from 0.00 s to 32.00 s" in broken(run(4), name)
    assert broken(run(4, strategy="srt-radial"), name)
    assert not broken(run(4, strategy="informed"), name)
    # The same goal again and again is a step forward once.
    goals = [
        GoalChosen(
            time_s=8.0 * k, robot=0, rule="closest", because="news", goal=(3.0, 1.5 + 0.01 * k)
        )
        for k in range(8)
    ]
    assert "drives 16.1 m" in broken(run(4, *goals), name)
    elsewhere = replace(goals[2], goal=(1.2, 1.5))
    assert not broken(run(4, elsewhere), name)
    assert not broken(run(4, Learned(time_s=20.0, robot=0, nodes=((1, 0),))), name)
    # A region that shows nothing new is a step forward with SRT alone, at a new place.
    room = ((0.0, 0.0), (4.0, 0.0), (4.0, 3.0), (0.0, 3.0))
    nodes = [
        NodeAdded(
            time_s=1.0 + 16.0 * k,
            robot=0,
            serial=k,
            parent=None,
            configuration=(2.0, 1.5, 0.0),
            boundary=room,
            tags="0000",
            stage="scan",
        )
        for k in range(2)
    ]
    beside = [nodes[0], replace(nodes[1], configuration=(2.6, 1.5, 0.0))]
    assert "drives 15.5 m from 1.00 s" in broken(run(4, *beside), name)
    assert "drives 15.5 m from 1.00 s" in broken(run(4, *nodes, strategy="srt-radial"), name)
    assert not broken(run(4, *beside, strategy="srt-radial"), name)


def test_a_standstill_that_the_stop_rule_ends_is_found(srt):
    reason = "no robot moved, sensed or learned anything new for 3,600 s: robots 0 and 1 wait"
    assert reason in broken(changed(srt, outcome="stalled", reason=reason), "waits-within-limits")


def test_regions_are_those_of_the_recording(bids):
    for name, node in bids.nodes.items():
        assert np.allclose(
            shapely.get_coordinates(bids.regions[name])[:-1], np.array(node.boundary)
        )


def test_runs_with_a_short_limit_hold_all_invariants():
    spec = RunSpec(environment=OPEN, strategy="gain", stop=StopRule(max_time_s=3.0), seed=1)
    assert check(executed(spec)) == []
