import math
from itertools import pairwise

import msgspec
import pytest
import shapely

from multisrt import registry
from multisrt.environments.environment import Environment
from multisrt.events import ArcClosed, Collision, Ended, MapComplete, Motion
from multisrt.explorer import Done, Move, Moved, Note, Sense
from multisrt.geometry.configuration import Configuration
from multisrt.geometry.errors import ClearanceError, InvalidInputError
from multisrt.geometry.scan import ExactScan, LaserScan
from multisrt.metrics import measure
from multisrt.planners.motion.trajectory import Trajectory, Waypoint
from multisrt.registry import Strategy
from multisrt.simulation import simulate
from multisrt.spec import RangeFinderSpec, RobotSpec, RunSpec, StopRule, inline
from multisrt.starts import starts_of

HALL = Environment("hall", shapely.box(0, 0, 10, 6))
DISC = RobotSpec(start=(1.0, 1.0))
BOX = RobotSpec(start=(2.0, 3.0), footprint="box:0.6x0.4")


class NoOptions(msgspec.Struct, frozen=True, kw_only=True):
    pass


class Scripted:
    """Does what a test says, and keeps what it is told."""

    def __init__(self, script):
        self.script = script
        self.me = None
        self.told = []

    def run(self):
        for action in self.script:
            self.told.append((yield action))


@pytest.fixture
def drive(monkeypatch):
    """Run a script in a world; give the recording and the explorer."""

    def run(*script, robot=DISC, world=HALL, max_time_s=1000.0, watch=None):
        explorer = Scripted(script)

        def build(me, options):
            explorer.me = me
            return explorer

        strategy = Strategy(name="script", summary="", options=NoOptions, explorer=build)
        monkeypatch.setitem(registry._registry(), "script", strategy)
        spec = RunSpec(
            environment=inline(world),
            strategy="script",
            robots=(robot,),
            stop=StopRule(max_time_s=max_time_s),
        )
        return simulate(spec, world, watch=watch), explorer

    return run


def straight(x0, y0, x1, y1, *, heading=0.0, seconds=None) -> Move:
    time = 2.0 * math.hypot(x1 - x0, y1 - y0) if seconds is None else seconds
    return Move(Trajectory((Waypoint(0.0, x0, y0, heading), Waypoint(time, x1, y1, heading))))


def motions(recording) -> list[Motion]:
    return [event for event in recording.events if isinstance(event, Motion)]


def test_a_run_by_hand(drive):
    note = MapComplete(time_s=6.0, robot=0)
    arc = ((1.0, 2.0, 3.0, 4.0),)
    recording, explorer = drive(
        Sense(), straight(1, 1, 4, 1), Sense(), Note(note), Done(True, "enough", arc)
    )
    first, moved, second, noted = explorer.told
    assert isinstance(first, ExactScan)
    assert (first.configuration, first.time_s) == (Configuration(1.0, 1.0, 0.0), 0.0)
    assert first.range_m == 4.0
    assert moved == Moved(configuration=Configuration(4.0, 1.0, 0.0), time_s=6.0)
    assert (second.configuration, second.time_s) == (Configuration(4.0, 1.0, 0.0), 6.0)
    assert noted is None
    assert recording.events == (
        Motion(time_s=0.0, robot=0, waypoints=((0.0, 1.0, 1.0, 0.0), (6.0, 4.0, 1.0, 0.0))),
        note,
        Ended(time_s=6.0, robot=0, reason="enough", complete=True, frontier=arc),
    )
    assert (recording.footer.outcome, recording.footer.time_s) == ("complete", 6.0)
    assert "enough" in recording.footer.reason


def test_times_count_from_the_start_of_the_run(drive):
    recording, _ = drive(straight(1, 1, 3, 1), straight(3, 1, 3, 4), Done(complete=True, reason=""))
    assert [[w[0] for w in motion.waypoints] for motion in motions(recording)] == [
        [0.0, 4.0],
        [4.0, 10.0],
    ]
    assert [motion.time_s for motion in motions(recording)] == [0.0, 4.0]


def test_a_robot_is_told_what_it_is(drive):
    robot = RobotSpec(start=(2.0, 3.0, 0.5), footprint="box:0.6x0.4")
    _, explorer = drive(Done(complete=True, reason=""), robot=robot)
    assert explorer.me.robot == 0
    assert explorer.me.start == (2.0, 3.0, 0.5)
    assert str(explorer.me.footprint) == "box:0.6x0.4"
    assert explorer.me.kinematics.speed_m_s == 0.5
    assert explorer.me.range_m == 4.0


def test_a_laser_gives_ranges(drive):
    robot = RobotSpec(start=(1.0, 1.0), range_finder=RangeFinderSpec(range_m=3.0, beams=8))
    _, explorer = drive(Sense(), Done(complete=True, reason=""), robot=robot)
    scan = explorer.told[0]
    assert isinstance(scan, LaserScan)
    # Walls 1 m to the left and below; the corner between them at the root of two; else nothing.
    assert scan.ranges[[4, 5, 6]] == pytest.approx([1.0, math.sqrt(2.0), 1.0])
    assert math.isinf(scan.ranges[0])


def test_an_explorer_that_gives_up_is_stalled(drive):
    recording, _ = drive(Done(complete=False, reason="tired"))
    assert recording.footer.outcome == "stalled"
    assert "tired" in recording.footer.reason


@pytest.mark.parametrize(
    ("x", "y", "heading"), [(1.001, 1.0, 0.0), (1.0, 0.999, 0.0), (1.0, 1.0, 0.01)]
)
def test_a_trajectory_from_elsewhere_is_refused(drive, x, y, heading):
    with pytest.raises(InvalidInputError, match="robot 0") as error:
        drive(straight(x, y, 4.0, 1.0, heading=heading))
    assert "1.0" in str(error.value)


def test_a_heading_is_the_same_after_a_whole_turn(drive):
    recording, _ = drive(
        straight(1, 1, 3, 1, heading=2.0 * math.pi), Done(complete=True, reason="")
    )
    assert recording.footer.outcome == "complete"


def test_into_a_wall(drive):
    recording, explorer = drive(Sense(), straight(1, 1, 12, 1), Sense(), Done(True, "unseen"))
    collision = recording.events[-1]
    assert isinstance(collision, Collision)
    assert collision.configuration == (1.0, 1.0, 0.0)
    assert recording.footer.outcome == "stalled"
    assert "touched an obstacle" in recording.footer.reason
    assert len(explorer.told) == 1
    metrics = measure(recording, HALL)
    assert metrics.collisions == 1
    assert metrics.outcome == "stalled"


def test_through_a_thin_wall(drive):
    world = Environment("two", HALL.free.difference(shapely.box(5, 0, 5.001, 6)))
    recording, _ = drive(straight(1, 1, 9, 1), world=world)
    assert recording.footer.outcome == "stalled"


def test_the_second_leg_of_a_trajectory_collides(drive):
    bent = Move(
        Trajectory(
            (Waypoint(0, 1, 1, 0.0), Waypoint(4, 3, 1, 0.0), Waypoint(8, 3, -1, 0.0)),
        )
    )
    recording, _ = drive(bent)
    assert recording.events[-1].time_s == 4.0
    assert recording.events[-1].configuration == (3.0, 1.0, 0.0)


def test_a_body_may_touch_a_wall_with_nothing_but_its_clearance(drive):
    # 0.25 m from the wall is a touch, a micrometre more is none.
    for y, outcome in ((0.25, "stalled"), (0.250001, "complete")):
        recording, _ = drive(straight(1, 1, 1, y), Done(complete=True, reason=""))
        assert recording.footer.outcome == outcome


def test_turns_are_checked(drive):
    # Half a metre from the wall above, a box whose corners reach 0.36 m turns; at 0.3 m it hits.
    turn = 0.5 * math.pi
    for gap, outcome in ((0.37, "complete"), (0.3, "stalled")):
        at = 6.0 - gap
        robot = RobotSpec(start=(2.0, at), footprint="box:0.6x0.4")
        spin = Move(Trajectory((Waypoint(0, 2, at, 0.0), Waypoint(1, 2, at, turn))))
        recording, _ = drive(spin, Done(complete=True, reason=""), robot=robot)
        assert recording.footer.outcome == outcome


def test_turning_while_driving_is_checked(drive):
    # Along the wall, 0.25 m from it: with a constant heading it fits, while turning it does not.
    robot = RobotSpec(start=(2.0, 5.75), footprint="box:0.6x0.4")
    for turn, outcome in ((0.0, "complete"), (2.0 * math.pi, "stalled")):
        bend = Move(Trajectory((Waypoint(0, 2, 5.75, 0.0), Waypoint(4, 4, 5.75, turn))))
        recording, _ = drive(bend, Done(complete=True, reason=""), robot=robot)
        assert recording.footer.outcome == outcome


def test_the_stop_rule_cuts_a_motion_where_it_is(drive):
    # Two metres take four seconds; after three the robot has gone one metre and a half.
    recording, explorer = drive(
        straight(1, 1, 3, 1), Done(complete=True, reason=""), max_time_s=3.0
    )
    assert recording.footer.outcome == "out_of_time"
    assert recording.footer.time_s == 3.0
    assert "3 s" in recording.footer.reason
    assert motions(recording)[-1].waypoints == ((0.0, 1.0, 1.0, 0.0), (3.0, 2.5, 1.0, 0.0))
    assert explorer.told == []
    assert measure(recording, HALL).total_distance_m == 1.5


@pytest.mark.parametrize("end", [0.6, 0.82, 0.85, 2.31, 2.4])
def test_the_stop_rule_in_a_later_motion_ends_exactly_at_its_time(drive, end):
    # With 2.31 and 2.4 the rest of the time, added to the time, is not quite the end.
    recording, _ = drive(
        straight(1, 1, 1.1, 1, seconds=0.1),
        straight(1.1, 1, 3, 1, seconds=0.2),
        straight(3, 1, 5, 1, seconds=17.0),
        max_time_s=end,
    )
    assert recording.footer.time_s == end
    assert motions(recording)[-1].waypoints[-1][0] <= end
    assert motions(recording)[-1].waypoints[-1][0] == pytest.approx(end, rel=1e-12)
    assert recording.footer.outcome == "out_of_time"


def test_a_motion_that_ends_with_the_time_is_whole(drive):
    recording, explorer = drive(
        straight(1, 1, 3, 1), Sense(), Done(complete=True, reason=""), max_time_s=4.0
    )
    assert recording.footer.outcome == "complete"
    assert explorer.told[0].configuration == (3.0, 1.0, 0.0)


def test_nothing_moves_when_the_time_is_over(drive):
    recording, _ = drive(straight(1, 1, 3, 1), straight(3, 1, 5, 1), max_time_s=4.0)
    assert recording.footer.outcome == "out_of_time"
    assert recording.footer.time_s == 4.0
    assert motions(recording)[-1].waypoints == ((4.0, 3.0, 1.0, 0.0),)


def test_a_wall_behind_the_end_of_time_is_not_hit(drive):
    recording, _ = drive(straight(1, 1, 12, 1), max_time_s=4.0)
    assert recording.footer.outcome == "out_of_time"


def test_every_event_is_told_as_it_happens(drive):
    seen = []
    recording, _ = drive(straight(1, 1, 3, 1), Done(complete=True, reason=""), watch=seen.append)
    assert tuple(seen) == recording.events


def test_an_explorer_ends_with_done(drive):
    with pytest.raises(InvalidInputError, match="Done"):
        drive(Sense())


@pytest.mark.parametrize("action", [None, Sense, "sense"])
def test_an_explorer_yields_actions(drive, action):
    with pytest.raises(InvalidInputError, match="no action"):
        drive(action, Done(complete=True, reason=""))


def test_an_explorers_own_error_comes_through(drive):
    def script():
        yield Sense()
        raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        drive(*script())


def test_events_of_a_run_are_in_order(museum_run):
    times = [event.time_s for event in museum_run.events if not isinstance(event, Collision)]
    assert all(a <= b for a, b in pairwise(times))
    assert not any(isinstance(event, ArcClosed) and not event.arc for event in museum_run.events)


@pytest.fixture(scope="module")
def museum_run():
    from multisrt.environments.catalog import environment

    world = environment("museum")
    return simulate(RunSpec(environment=inline(world), seed=3), world)


PILLAR = Environment("pillar", HALL.free.difference(shapely.box(4, 2, 6, 4)))


def start(robot: RobotSpec, world: Environment, seed: int = 0) -> Configuration:
    spec = RunSpec(environment=inline(world), robots=(robot,), seed=seed)
    return starts_of(spec, world)[0]


def test_a_start_inside_an_obstacle():
    with pytest.raises(ClearanceError, match=r"\(5, 3\).*'pillar'.*clearance 0 m"):
        start(RobotSpec(start=(5.0, 3.0)), PILLAR)


def test_a_start_outside_of_the_world():
    with pytest.raises(ClearanceError, match=r"\(50, 3\)"):
        start(RobotSpec(start=(50.0, 3.0)), PILLAR)


def test_a_start_that_is_too_tight_says_the_clearance():
    with pytest.raises(ClearanceError, match=r"clearance there is 0\.1 m.*0\.25") as error:
        start(RobotSpec(start=(3.9, 3.0)), PILLAR)
    assert error.value.clearance_m == pytest.approx(0.1)


def test_a_start_with_no_more_than_the_radius_is_a_touch():
    with pytest.raises(ClearanceError):
        start(RobotSpec(start=(0.25, 3.0)), HALL)
    assert start(RobotSpec(start=(0.2500001, 3.0)), HALL) == (0.2500001, 3.0, 0.0)


def test_whether_a_box_fits_depends_on_its_heading():
    corridor = Environment("corridor", shapely.box(0, 0, 10, 0.5))
    box = "box:0.6x0.4"
    assert start(RobotSpec(start=(5.0, 0.25), footprint=box), corridor) == (5.0, 0.25, 0.0)
    assert start(RobotSpec(start=(5.0, 0.25, math.pi), footprint=box), corridor)
    with pytest.raises(ClearanceError, match=r"0\.25 m.*0\.2 to 0\.361"):
        start(RobotSpec(start=(5.0, 0.25, math.pi / 2), footprint=box), corridor)


def test_a_body_that_fits_nowhere():
    with pytest.raises(InvalidInputError, match=r"disc:3\.1 fits nowhere in 'hall'.*3\.1 m"):
        start(RobotSpec(footprint="disc:3.1"), HALL)


def test_a_suggested_start():
    suggested = Environment("hall", HALL.free, starts=[(3.0, 2.0), (1.0, 1.0)])
    assert start(RobotSpec(), suggested) == (3.0, 2.0, 0.0)
    with pytest.raises(ClearanceError):
        start(RobotSpec(footprint="disc:2.1"), suggested)


def test_a_drawn_start_depends_on_the_seed_and_has_room_for_any_heading():
    starts = [start(RobotSpec(footprint="box:0.6x0.4"), PILLAR, seed) for seed in range(20)]
    assert starts == [start(RobotSpec(footprint="box:0.6x0.4"), PILLAR, seed) for seed in range(20)]
    assert len(set(starts)) == 20
    assert all(PILLAR.clearance(x, y) > math.hypot(0.3, 0.2) for x, y, _ in starts)


def test_a_drawn_start_lies_in_the_largest_part():
    cells = Environment("cells", shapely.union(shapely.box(0, 0, 2, 2), shapely.box(3, 0, 9, 6)))
    assert all(start(RobotSpec(), cells, seed).x > 3.0 for seed in range(10))
