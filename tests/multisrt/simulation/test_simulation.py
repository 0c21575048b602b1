import gc
import math
import weakref
from itertools import pairwise
from typing import ClassVar

import msgspec
import pytest
import shapely

from multisrt.analysis.metrics import measure
from multisrt.environments.environment import Environment
from multisrt.events import ArcClosed, Blocked, Collision, Ended, MapComplete, Motion, Sent
from multisrt.geometry.configuration import Configuration
from multisrt.geometry.errors import ClearanceError, InvalidInputError
from multisrt.geometry.regions.scan import ExactScan, LaserScan
from multisrt.planners.motion.trajectory import Trajectory, Waypoint
from multisrt.robots import registry
from multisrt.robots.explorer import (
    Done,
    Look,
    Move,
    Moved,
    Note,
    Receive,
    Received,
    Send,
    Sense,
    Stop,
    TimedOut,
)
from multisrt.robots.frontier.robot import FrontierRobot
from multisrt.robots.messages import Message
from multisrt.robots.multi_srt.robot import SrtRobot
from multisrt.robots.registry import Strategy
from multisrt.simulation.simulate import simulate
from multisrt.simulation.starts import starts_of
from multisrt.simulation.worlds import inline
from multisrt.spec import (
    CatalogEnvironment,
    RadioSpec,
    RangeFinderSpec,
    RobotSpec,
    RunSpec,
    StopRule,
)

HALL = Environment("hall", shapely.box(0, 0, 10, 6))
DISC = RobotSpec(start=(1.0, 1.0))
PI = math.pi


class NoOptions(msgspec.Struct, frozen=True, kw_only=True):
    pass


class Scripted:
    """An explorer that follows a script, and keeps the outcomes."""

    def __init__(self, script):
        self.script = script
        self.me = None
        self.told = []

    def run(self):
        for action in self.script:
            self.told.append((yield action))


@pytest.fixture
def drive(monkeypatch):
    """Run a script in a world; return the recording and the explorer."""

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
    return Move(
        trajectory=Trajectory((Waypoint(0.0, x0, y0, heading), Waypoint(time, x1, y1, heading)))
    )


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


def test_an_explorer_is_given_what_its_robot_is(drive):
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


def test_headings_that_differ_by_a_full_turn_are_equal(drive):
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
        trajectory=Trajectory(
            (Waypoint(0, 1, 1, 0.0), Waypoint(4, 3, 1, 0.0), Waypoint(8, 3, -1, 0.0)),
        )
    )
    recording, _ = drive(bent)
    assert recording.events[-1].time_s == 4.0
    assert recording.events[-1].configuration == (3.0, 1.0, 0.0)


def test_a_body_may_touch_a_wall_with_nothing_but_its_clearance(drive):
    # At 0.25 m from the wall the disc touches it, a micrometre farther away it does not.
    for y, outcome in ((0.25, "stalled"), (0.250001, "complete")):
        recording, _ = drive(straight(1, 1, 1, y), Done(complete=True, reason=""))
        assert recording.footer.outcome == outcome


def test_turns_are_checked(drive):
    # Half a metre from the wall above, a box whose corners reach 0.36 m turns; at 0.3 m it hits.
    turn = 0.5 * math.pi
    for gap, outcome in ((0.37, "complete"), (0.3, "stalled")):
        at = 6.0 - gap
        robot = RobotSpec(start=(2.0, at), footprint="box:0.6x0.4")
        spin = Move(trajectory=Trajectory((Waypoint(0, 2, at, 0.0), Waypoint(1, 2, at, turn))))
        recording, _ = drive(spin, Done(complete=True, reason=""), robot=robot)
        assert recording.footer.outcome == outcome


def test_turning_while_driving_is_checked(drive):
    # Along the wall, 0.25 m from it: straight on it fits. On a half circle of 0.1 m radius that
    # leads away from the wall a corner comes as near to it as 0.2 cos a + (0.3 - 0.1) sin a,
    # which is 0.28 m at 45 degrees; a circle of 1 m is wide enough.
    robot = RobotSpec(start=(2.0, 5.75), footprint="box:0.6x0.4")
    for x, turn, outcome in ((2.2, 0.0, "complete"), (2.2, PI, "stalled"), (4.0, PI, "complete")):
        bend = Move(trajectory=Trajectory((Waypoint(0, 2, 5.75, 0.0), Waypoint(4, x, 5.75, turn))))
        recording, _ = drive(bend, Done(complete=True, reason=""), robot=robot)
        assert recording.footer.outcome == outcome


def test_the_stop_rule_ends_a_motion_where_the_robot_is(drive):
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
def test_the_stop_rule_ends_a_later_motion_exactly_at_its_time(drive, end):
    # With 2.31 and 2.4, the time plus the remaining time is not exactly the end.
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


def test_a_motion_that_ends_with_the_time_is_complete(drive):
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


def test_the_watcher_is_called_with_every_event(drive):
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


def test_a_start_without_room_is_refused_with_its_clearance():
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


def test_a_random_start_depends_on_the_seed_and_has_room():
    starts = [start(RobotSpec(footprint="box:0.6x0.4"), PILLAR, seed) for seed in range(20)]
    assert starts == [start(RobotSpec(footprint="box:0.6x0.4"), PILLAR, seed) for seed in range(20)]
    assert len(set(starts)) == 20
    assert all(PILLAR.clearance(x, y) > math.hypot(0.3, 0.2) for x, y, _ in starts)


def test_a_drawn_start_lies_in_the_largest_part():
    cells = Environment("cells", shapely.union(shapely.box(0, 0, 2, 2), shapely.box(3, 0, 9, 6)))
    assert all(start(RobotSpec(), cells, seed).x > 3.0 for seed in range(10))


# Teams -----------------------------------------------------------------------------------------


class Word(Message, frozen=True, kw_only=True):
    kind: ClassVar[str] = "word"
    text: str = ""


class Call(Word, frozen=True, kw_only=True):
    kind: ClassVar[str] = "call"

    @property
    def wakes(self) -> bool:
        return True


END = Done(complete=True, reason="enough")
ON_CALL = Done(complete=True, reason="enough", on_call=True)


class Actor:
    """An explorer that follows a generator, and keeps the outcomes."""

    def __init__(self, acts):
        self.acts = acts
        self.told = []

    def run(self):
        acts = self.acts() if callable(self.acts) else iter(self.acts)
        outcome = None
        while True:
            try:
                action = acts.send(outcome) if hasattr(acts, "send") else next(acts)
            except StopIteration:
                return
            outcome = yield action
            self.told.append(outcome)


@pytest.fixture
def play(monkeypatch):
    """Run robots, each by a list of actions or a generator; return the outcomes, too."""

    def run(*scripts, starts, world=HALL, max_time_s=1000.0, robot=None, **spec):
        actors = [Actor(script) for script in scripts]
        strategy = Strategy(
            name="play",
            summary="",
            options=NoOptions,
            explorer=lambda me, options: actors[me.robot],
        )
        monkeypatch.setitem(registry._registry(), "play", strategy)
        body = RobotSpec() if robot is None else robot
        recording = simulate(
            RunSpec(
                environment=inline(world),
                strategy="play",
                robots=tuple(msgspec.structs.replace(body, start=start) for start in starts),
                stop=StopRule(max_time_s=max_time_s),
                **spec,
            ),
            world,
        )
        return recording, [actor.told for actor in actors]

    return run


TWO = [(1.0, 1.0), (1.0, 5.0)]
THREE = [(1.0, 1.0), (5.0, 1.0), (9.0, 1.0)]


def events(recording, kind, robot=None):
    return [
        event
        for event in recording.events
        if isinstance(event, kind) and robot in (None, event.robot)
    ]


def texts(outcome: Received) -> list[str]:
    return [message.text for message in outcome.messages]


def test_a_message_comes_after_its_latency(play):
    _, (_, told) = play(
        [Send(Word(sender=0, text="hello")), END],
        [Receive(), END],
        starts=TWO,
        radio=RadioSpec(latency_s=0.75),
    )
    assert told[0] == Received((Word(sender=0, text="hello"),), 0.75)


def test_jitter_comes_on_top_for_each_receiver_anew(play):
    times = []
    for seed in (0, 0, 1):
        _, told = play(
            [Send(Word(sender=0)), END],
            [Receive(), END],
            [Receive(), END],
            starts=THREE,
            radio=RadioSpec(latency_s=0.5, jitter_s=2.0),
            seed=seed,
        )
        times.append([told[robot][0].time_s for robot in (1, 2)])
    assert times[0] == times[1] != times[2]
    assert all(0.5 <= time <= 2.5 for pair in times for time in pair)
    assert times[0][0] != times[0][1]


def test_jitter_can_turn_the_order_of_messages_round(play):
    words = [Word(sender=0, text=str(k)) for k in range(20)]

    def hear():
        heard = []
        while len(heard) < 20:
            heard += texts((yield Receive()))
        assert sorted(heard) == sorted(word.text for word in words)
        assert heard != [word.text for word in words]
        yield END

    recording, _ = play([*map(Send, words), END], hear, starts=TWO, radio=RadioSpec(jitter_s=1.0))
    assert recording.footer.outcome == "complete"


def test_lost_messages_do_not_come_and_are_on_record(play):
    def hear():
        heard = 0
        while isinstance(received := (yield Receive(5.0)), Received):
            heard += len(received.messages)
        yield Done(complete=True, reason=str(heard))

    recording, _ = play(
        [*[Send(Word(sender=0)) for _ in range(400)], END],
        hear,
        hear,
        starts=THREE,
        radio=RadioSpec(loss=0.3),
    )
    sent = events(recording, Sent)
    assert len(sent) == 400
    assert all(sorted(event.reached + event.lost) == [1, 2] for event in sent)
    for robot in (1, 2):
        came = sum(robot in event.reached for event in sent)
        # 280 are expected, with a standard deviation of 9.2.
        assert 240 < came < 320
        assert events(recording, Ended, robot)[0].reason == str(came)


@pytest.mark.parametrize(("multi_hop", "reached"), [(True, (1, 2)), (False, (1,))])
def test_robots_in_between_relay(play, multi_hop, reached):
    recording, told = play(
        [Send(Word(sender=0)), END],
        [Receive(1.0), END],
        [Receive(1.0), END],
        starts=THREE,
        radio=RadioSpec(range_m=5.0, multi_hop=multi_hop),
    )
    assert events(recording, Sent)[0].reached == reached
    for robot in (1, 2):
        assert isinstance(told[robot][0], Received if robot in reached else TimedOut)


def test_the_place_at_the_time_of_sending_counts(play):
    # Robot 1 comes into range (2 m) after 4 s, of a path of 3 m at 0.5 m/s.
    def call():
        for _ in range(7):
            yield Send(Word(sender=0), 1)
            yield Receive(1.0)
        yield END

    recording, _ = play(
        call,
        [straight(5, 1, 2, 1), END],
        starts=THREE[:2],
        radio=RadioSpec(range_m=2.0 + 1e-9),
    )
    reached = [event.time_s for event in events(recording, Sent) if event.reached]
    assert reached == [4.0, 5.0, 6.0]


def test_a_message_to_one_robot_reaches_it_alone(play):
    recording, told = play(
        [Send(Word(sender=0), 2), Send(Word(sender=0), 1), Send(Word(sender=0), 2), END],
        [Receive(1.0), Receive(1.0), END],
        [Receive(1.0), Receive(1.0), END],
        starts=THREE,
    )
    assert [event.reached for event in events(recording, Sent)] == [(2,), (1,), (2,)]
    assert [len(told[robot][0].messages) for robot in (1, 2)] == [1, 2]
    assert all(isinstance(told[robot][1], TimedOut) for robot in (1, 2))


def test_messages_of_one_moment_arrive_in_order(play):
    def sender(robot):
        yield Send(Word(sender=robot, text=f"{robot}a"))
        yield Send(Word(sender=robot, text=f"{robot}b"))
        yield END

    for latency in (0.0, 1.0):
        _, told = play(
            lambda: sender(0),
            lambda: sender(1),
            [Receive(latency + 1.0), END],
            starts=THREE,
            radio=RadioSpec(latency_s=latency),
        )
        first = told[2][0]
        assert texts(first)[0] == "0a"
        assert first.time_s == latency


def test_all_messages_of_a_moment_are_there_at_its_end(play):
    # Robot 2 acts before; at 1 s all messages have arrived.
    def talk(robot):
        yield Receive(1.0)
        yield Send(Word(sender=robot, text=f"{robot}a"), 2)
        yield Send(Word(sender=robot, text=f"{robot}b"), 2)
        yield END

    _, told = play(
        lambda: talk(0), lambda: talk(1), [straight(9, 1, 9, 2), Receive(0), END], starts=THREE
    )
    assert texts(told[2][1]) == ["0a", "0b", "1a", "1b"]


def test_receive_without_time_waits_for_the_whole_moment(play):
    # Robot 0 acts first; it still receives what robot 1 sends at the same time, and the answer
    # to its answer.
    def first():
        for text in ("", "one", "two"):
            if text:
                yield Send(Word(sender=0, text=text))
            received = yield Receive(0)
            assert isinstance(received, Received)
            assert received.time_s == 0.0
        assert (yield Receive(0)) == TimedOut(0.0)
        yield END

    def second():
        yield Send(Word(sender=1, text="zero"))
        for _ in range(2):
            received = yield Receive()
            yield Send(Word(sender=1, text=texts(received)[0] + " too"))
        yield END

    recording, told = play(first, second, starts=TWO)
    heard = [texts(outcome) for outcome in told[0] if isinstance(outcome, Received)]
    assert heard == [["zero"], ["one too"], ["two too"]]
    assert recording.footer.time_s == 0.0


def test_a_message_comes_before_a_timeout_of_the_same_time(play):
    late, punctual, early = (
        play(
            [Send(Word(sender=0)), END],
            [Receive(timeout), END],
            starts=TWO,
            radio=RadioSpec(latency_s=2.0),
        )[1][1][0]
        for timeout in (1.5, 2.0, 3.0)
    )
    assert late == TimedOut(1.5)
    assert punctual == early == Received((Word(sender=0),), 2.0)


def test_a_message_that_came_before_is_there_at_once(play):
    _, told = play(
        [Send(Word(sender=0, text="a")), Receive(1.0), Send(Word(sender=0, text="b")), END],
        [straight(1, 5, 3, 5), Receive(), Receive(3.0), END],
        starts=TWO,
    )
    assert told[1][1] == Received((Word(sender=0, text="a"), Word(sender=0, text="b")), 4.0)
    assert told[1][2] == TimedOut(7.0)


def called(*messages):
    """Send messages one after the other, a second apart, the first after a second."""

    def acts():
        for message in messages:
            yield Receive(1.0)
            yield Send(message)
        yield END

    return acts


def listening(x0, y0, x1, y1, **more) -> Move:
    return Move(trajectory=straight(x0, y0, x1, y1).trajectory, listen=True, **more)


def test_a_moving_robot_receives_messages_that_wake(play):
    a, b, c, d = (
        kind(sender=0, text=text)
        for kind, text in ((Word, "a"), (Call, "b"), (Word, "c"), (Call, "d"))
    )
    recording, (_, told) = play(
        called(a, b, c, d),
        [listening(1, 5, 5, 5), Receive(), Receive(), Receive(0), END],
        starts=TWO,
    )
    assert told[:3] == [
        Received((a, b), 2.0),
        Received((c, d), 4.0),
        Moved(configuration=Configuration(5.0, 5.0, 0.0), time_s=8.0),
    ]
    assert told[3] == TimedOut(8.0)
    assert [m.waypoints[-1] for m in motions(recording)] == [(8.0, 5.0, 5.0, 0.0)]


def test_a_moving_robot_does_not_receive_other_messages(play):
    a, b = Word(sender=0, text="a"), Word(sender=0, text="b")
    _, (_, told) = play(called(a, b), [listening(1, 5, 5, 5), Receive(), END], starts=TWO)
    assert told[:2] == [
        Moved(configuration=Configuration(5.0, 5.0, 0.0), time_s=8.0),
        Received((a, b), 8.0),
    ]


def test_a_robot_that_does_not_listen_receives_on_arrival(play):
    word = Call(sender=0)
    _, (_, told) = play(called(word), [straight(1, 5, 5, 5), Receive(), END], starts=TWO)
    assert told[:2] == [
        Moved(configuration=Configuration(5.0, 5.0, 0.0), time_s=8.0),
        Received((word,), 8.0),
    ]


def test_a_moving_robot_can_scan_send_and_wait(play):
    def on_the_way():
        yield listening(1, 5, 5, 5)
        assert (yield Receive(1.0)) == TimedOut(2.0)
        scan = yield Sense()
        assert (scan.configuration, scan.time_s) == (Configuration(2.0, 5.0, 0.0), 2.0)
        yield Send(Word(sender=1))
        moved = yield Receive()
        assert moved == Moved(configuration=Configuration(5.0, 5.0, 0.0), time_s=8.0)
        yield END

    recording, (told, _) = play(
        [Receive(1.0), Send(Call(sender=0)), Receive(), END], on_the_way, starts=TWO
    )
    assert told[2] == Received((Word(sender=1),), 2.0)
    assert recording.footer.outcome == "complete"


def test_a_robot_stops_where_it_is(play):
    def on_the_way():
        yield listening(1, 5, 5, 5)
        moved = yield Stop()
        assert moved == Moved(configuration=Configuration(1.5, 5.0, 0.0), time_s=1.0)
        # It stands there now, and the old motion is forgotten.
        assert (yield Receive(20.0)) == TimedOut(21.0)
        yield straight(1.5, 5, 1.5, 4)
        yield END

    recording, _ = play(called(Call(sender=0)), on_the_way, starts=TWO)
    assert [motion.waypoints for motion in motions(recording)] == [
        ((0.0, 1.0, 5.0, 0.0), (1.0, 1.5, 5.0, 0.0)),
        ((21.0, 1.5, 5.0, 0.0), (23.0, 1.5, 4.0, 0.0)),
    ]


def test_an_explorer_that_lets_no_time_pass_is_refused(play, monkeypatch):
    monkeypatch.setattr("multisrt.simulation.interpreter.MAX_ACTIONS", 50)

    def waits_for_nothing():
        yield straight(1, 5, 2, 5)
        while True:
            yield Receive(0.0)

    with pytest.raises(InvalidInputError, match=r"robot 0 yielded 50 actions at 2 s and lets no"):
        play(waits_for_nothing(), starts=[(1.0, 5.0)])

    def answers(robot):
        yield Send(Call(sender=robot))
        while True:
            yield Receive()
            yield Send(Call(sender=robot))

    with pytest.raises(InvalidInputError, match=r"yielded 50 actions at 0 s and lets no time"):
        play(answers(0), answers(1), starts=TWO)


def test_actions_are_counted_for_each_moment_alone(play, monkeypatch):
    monkeypatch.setattr("multisrt.simulation.interpreter.MAX_ACTIONS", 5)

    def waits():
        for _ in range(40):
            yield Receive(0.1)
        yield END

    recording, _ = play(waits(), starts=[(1.0, 5.0)])
    assert recording.footer.outcome == "complete"


def test_a_stop_needs_a_motion_and_a_motion_a_robot_that_stands(play):
    with pytest.raises(InvalidInputError, match=r"robot 1 yielded Stop, but it stands"):
        play([END], [Stop(), END], starts=TWO)
    with pytest.raises(InvalidInputError, match=r"robot 1 yielded Move while a motion goes on"):
        play(
            called(Call(sender=0)),
            [listening(1, 5, 5, 5), listening(1.5, 5, 5, 5)],
            starts=TWO,
        )


# Other bodies: discs of 0.25 m at half a metre a second.

FACING = [(1.0, 3.0), (9.0, 3.0)]


def guarded(x0, y0, x1, y1) -> Move:
    return Move(trajectory=straight(x0, y0, x1, y1).trajectory, guard_m=0.5)


def test_two_that_meet_head_on_stop_and_can_leave(play):
    # 8 m between them, 1 m when bodies are half a metre apart: 3.5 m each, in 7 s.
    def drive(x0, x1):
        moved = yield guarded(x0, 3, x1, 3)
        assert moved.time_s == pytest.approx(7.0, abs=1e-3)
        assert moved.blocked_by is not None
        here = moved.configuration
        yield Receive(1.0)
        assert here.x == pytest.approx(x0 + 3.5 if x1 > x0 else x0 - 3.5, abs=1e-3)
        moved = yield guarded(*here[:2], x0, 3)
        assert moved == Moved(
            configuration=Configuration(x0, 3.0, 0.0), time_s=pytest.approx(15.0, abs=2e-3)
        )
        yield END

    recording, told = play(lambda: drive(1.0, 9.0), lambda: drive(9.0, 1.0), starts=FACING)
    assert recording.footer.outcome == "complete"
    blocked = events(recording, Blocked)
    assert sorted((event.robot, event.by) for event in blocked) == [(0, 1), (1, 0)]
    for robot, other in ((0, 1), (1, 0)):
        sighting = told[robot][0].blocked_by
        assert sighting.robot == other
        assert str(sighting.footprint) == "disc:0.25"
        (event,) = events(recording, Blocked, robot)
        assert event.configuration == told[robot][0].configuration
        assert event.time_s == told[robot][0].time_s
    apart = told[1][0].configuration.x - told[0][0].configuration.x
    assert apart == pytest.approx(1.0, abs=1e-3)
    assert apart >= 1.0


def test_the_protective_stop_before_a_body_that_stands(play):
    def drive():
        moved = yield guarded(1, 3, 8, 3)
        # The other stands at 5: 4 m less two radii and the guard.
        assert moved.configuration.x == pytest.approx(4.0, abs=1e-3)
        assert moved.configuration.x <= 4.0
        assert moved.time_s == pytest.approx(6.0, abs=1e-3)
        # It is within the guard now: the next stop is at half the distance.
        moved = yield guarded(*moved.configuration[:2], 8, 3)
        assert moved.configuration.x == pytest.approx(4.25, abs=2e-3)
        assert moved.blocked_by.robot == 1
        yield END

    recording, _ = play(drive, [END], starts=[(1.0, 3.0), (5.0, 3.0)])
    assert recording.footer.outcome == "complete"
    assert len(events(recording, Blocked)) == 2


def test_a_robot_that_has_left_in_time_blocks_no_other(play):
    # Robot 1 has left the path before robot 0 arrives.
    recording, told = play(
        [guarded(1, 3, 8, 3), END], [guarded(5, 3, 5, 5.5), END], starts=[(1.0, 3.0), (5.0, 3.0)]
    )
    assert told[0][0].blocked_by is None
    assert events(recording, Blocked) == []


def test_a_robot_that_sets_out_later_can_block_a_moving_one(play):
    # Robot 1 crosses at 6 s, when robot 0 is at 4: it stops before the crossing.
    def cross():
        yield Receive(2.0)
        yield straight(5, 5, 5, 3)
        yield END

    recording, told = play([guarded(1, 3, 8, 3), END], cross, starts=[(1.0, 3.0), (5.0, 5.0)])
    assert told[0][0].blocked_by.robot == 1
    assert told[0][0].configuration.x < 5.0
    assert recording.footer.outcome == "complete"


@pytest.mark.parametrize("other", ["stands", "comes"])
def test_bodies_that_touch_end_the_run(play, other):
    move = straight(9, 3, 1, 3)
    recording, told = play(
        [straight(1, 3, 9, 3), END],
        [Receive(), END] if other == "stands" else [move, END],
        starts=FACING,
    )
    collision = recording.events[-1]
    assert isinstance(collision, Collision)
    assert recording.footer.outcome == "stalled"
    for word in ("touched", "robot 0", "robot 1"):
        assert word in recording.footer.reason
    # Centres are half a metre apart then.
    time = 15.0 if other == "stands" else 7.5
    assert collision.time_s == pytest.approx(time, abs=1e-3)
    assert recording.footer.time_s == collision.time_s
    assert told[0] == []
    assert measure(recording, HALL).collisions == 1


def test_all_motions_before_a_collision_are_recorded(play):
    recording, _ = play(
        [straight(1, 3, 9, 3), END],
        [straight(9, 3, 1, 3), END],
        [straight(1, 1, 9, 1), END],
        starts=[*FACING, (1.0, 1.0)],
    )
    ends = {motion.robot: motion.waypoints[-1] for motion in motions(recording)}
    assert {robot: end[1] for robot, end in ends.items()} == pytest.approx(
        {0: 4.75, 1: 5.25, 2: 4.75}, abs=1e-3
    )


def test_look_gives_the_bodies_in_sight_and_range(play):
    wall = Environment("wall", HALL.free.difference(shapely.box(1.5, 2.9, 3, 3.1)))
    starts = [(2.0, 1.0), (5.0, 1.0), (2.0, 5.0), (9.0, 1.0)]
    _, told = play([Look(), END], *[[END]] * 3, starts=starts, world=wall)
    (sighting,) = told[0][0]
    assert (sighting.robot, sighting.configuration) == (1, Configuration(5.0, 1.0, 0.0))
    assert str(sighting.footprint) == "disc:0.25"


def test_look_sees_where_the_others_are_now(play):
    _, told = play(
        [Receive(2.0), Look(), END], [straight(1, 5, 3, 5), END], starts=[(1.0, 3.0), (1.0, 5.0)]
    )
    assert told[0][1][0].configuration == Configuration(2.0, 5.0, 0.0)


# The end


def test_a_robot_on_call_is_called_on_again(play):
    def on_call():
        received = yield Done(complete=False, reason="nothing known", on_call=True)
        assert received == Received((Word(sender=0),), 5.0)
        yield straight(1, 5, 3, 5)
        yield ON_CALL
        raise AssertionError("nobody calls again")

    recording, _ = play([Receive(5.0), Send(Word(sender=0)), END], on_call, starts=TWO)
    assert [(e.time_s, e.reason) for e in events(recording, Ended, 1)] == [
        (0.0, "nothing known"),
        (9.0, "enough"),
    ]
    # The last end counts.
    assert recording.footer.outcome == "complete"
    assert recording.footer.time_s == 9.0


def test_a_message_under_way_to_a_robot_on_call_prolongs_the_run(play):
    def on_call():
        yield ON_CALL
        yield straight(1, 5, 3, 5)
        yield ON_CALL

    recording, told = play(
        [Send(Word(sender=0)), END], on_call, starts=TWO, radio=RadioSpec(latency_s=3.0)
    )
    assert told[1][0].time_s == 3.0
    assert recording.footer.time_s == 7.0
    assert recording.footer.outcome == "complete"


def test_an_equal_second_end_is_not_recorded(play):
    recording, told = play(
        called(Word(sender=0), Word(sender=0)), [ON_CALL, ON_CALL, ON_CALL], starts=TWO
    )
    assert len(told[1]) == 2
    assert len(events(recording, Ended, 1)) == 1


def test_a_robot_that_is_done_for_good_does_not_hold_up_the_end(play):
    recording, _ = play(called(Word(sender=0)), [END], starts=TWO)
    assert recording.footer.outcome == "complete"
    assert recording.footer.time_s == 1.0


def test_a_robot_that_waits_for_ever_stalls_the_run(play):
    recording, told = play(
        [straight(1, 1, 3, 1), END], [Receive(), END], [Receive(2.0), Receive(), END],
        starts=[(1.0, 1.0), (1.0, 5.0), (9.0, 5.0)],
    )  # fmt: skip
    assert recording.footer.outcome == "stalled"
    assert "[1, 2]" in recording.footer.reason
    assert told[1] == []
    assert recording.footer.time_s == 4.0


def test_a_robot_that_gives_up_stalls_the_run(play):
    recording, _ = play([END], [Done(complete=False, reason="tired")], starts=TWO)
    assert recording.footer.outcome == "stalled"
    assert recording.footer.reason == "robot 0: enough; robot 1: tired"


def test_the_stop_rule_cuts_the_motions_of_all(play):
    recording, told = play(
        [straight(1, 1, 9, 1), END],
        [straight(5, 5, 3, 5), straight(3, 5, 9, 5), END],
        [Receive(), END],
        starts=[(1.0, 1.0), (5.0, 5.0), (9.0, 3.0)],
        max_time_s=6.0,
    )
    assert recording.footer.outcome == "out_of_time"
    assert recording.footer.time_s == 6.0
    assert {(m.robot, m.waypoints) for m in motions(recording)} == {
        (0, ((0.0, 1.0, 1.0, 0.0), (6.0, 4.0, 1.0, 0.0))),
        (1, ((0.0, 5.0, 5.0, 0.0), (4.0, 3.0, 5.0, 0.0))),
        (1, ((4.0, 3.0, 5.0, 0.0), (6.0, 4.0, 5.0, 0.0))),
    }
    assert told[0] == []


# Recordings


def test_events_are_on_record_in_the_order_in_which_they_happen(play):
    def chatter(robot, x):
        def acts():
            for k in range(4):
                y = 1.0 + k % 2
                yield Send(Word(sender=robot))
                yield straight(x, y, x, 3.0 - y, seconds=1.0 + 0.3 * robot)
            yield END

        return acts

    recording, _ = play(chatter(0, 1.0), chatter(1, 5.0), chatter(2, 9.0), starts=THREE)
    # A motion is recorded when it ends.
    times = [
        event.waypoints[-1][0] if isinstance(event, Motion) else event.time_s
        for event in recording.events
    ]
    assert times == sorted(times)
    for robot in range(3):
        for before, after in pairwise(motions_of(recording, robot)):
            assert before.waypoints[-1][0] <= after.time_s == after.waypoints[0][0]
            assert before.waypoints[-1][1:] == after.waypoints[0][1:]


def motions_of(recording, robot) -> list[Motion]:
    return [motion for motion in motions(recording) if motion.robot == robot]


def test_messages_are_counted_with_their_sizes(play):
    short, long = Word(sender=0, text="a"), Call(sender=0, text="a" * 1000)
    recording, _ = play([Send(short), Send(long, 2), END], [END], [END], starts=THREE)
    sent = events(recording, Sent)
    assert [(e.kind, e.size_bytes, e.reached) for e in sent] == [
        ("word", short.size_bytes, (1, 2)),
        ("call", long.size_bytes, (2,)),
    ]
    assert 1000 < long.size_bytes < 1050
    assert short.size_bytes < 40
    metrics = measure(recording, HALL)
    assert metrics.messages == 2
    assert metrics.bytes_sent == short.size_bytes + long.size_bytes
    assert metrics.messages_by_kind == {"word": 1, "call": 1}


def test_an_explorer_is_given_its_team(monkeypatch):
    selves = []

    def build(me, options):
        selves.append(me)
        return Actor([END])

    strategy = Strategy(name="team", summary="", options=NoOptions, explorer=build)
    monkeypatch.setitem(registry._registry(), "team", strategy)
    robots = tuple(
        RobotSpec(start=start, range_finder=RangeFinderSpec(range_m=range_m))
        for start, range_m in zip(THREE, (2.0, 5.0, 3.0), strict=True)
    )
    radio = RadioSpec(range_m=9.0, latency_s=0.5, jitter_s=0.25, loss=0.1, multi_hop=False)
    simulate(RunSpec(environment=inline(HALL), strategy="team", robots=robots, radio=radio), HALL)
    assert [me.robot for me in selves] == [0, 1, 2]
    assert [me.range_m for me in selves] == [2.0, 5.0, 3.0]
    assert {(me.team, me.max_range_m) for me in selves} == {(3, 5.0)}
    assert selves[0].radio.latency_s == 0.75
    assert (selves[0].radio.range_m, selves[0].radio.loss) == (9.0, 0.1)
    assert not selves[0].radio.multi_hop
    assert not selves[0].radio.reaches_all
    streams = [me.rng.random() for me in selves]
    assert len(set(streams)) == 3


@pytest.mark.parametrize("trouble", ["none", "much"])
def test_a_run_of_a_team_can_be_repeated(trouble):
    radio = RadioSpec(loss=0.2, latency_s=0.1, jitter_s=0.3) if trouble == "much" else RadioSpec()
    spec = RunSpec(
        environment=inline(HALL), robots=(RobotSpec(),) * 3, radio=radio,
        stop=StopRule(max_time_s=120.0), seed=5,
    )  # fmt: skip
    first, second = simulate(spec, HALL), simulate(spec, HALL)
    assert first.events == second.events
    assert first.footer == second.footer


def test_a_run_never_sets_the_garbage_collector():
    before, met = gc.get_threshold(), set()
    simulate(
        RunSpec(environment=CatalogEnvironment(name="open"), seed=1),
        watch=lambda _: met.add(gc.get_threshold()),
    )
    assert met == {before}
    assert gc.get_threshold() == before


@pytest.mark.parametrize(
    ("strategy", "kind"), [("srt-radial", SrtRobot), ("minpos", FrontierRobot)]
)
@pytest.mark.parametrize("max_time_s", [20.0, 600.0])
def test_the_knowledge_of_robots_is_freed_with_their_run(monkeypatch, strategy, kind, max_time_s):
    # Without the garbage collector: experiments make thousands of runs in one process.
    made, init = [], kind.__init__

    def noted(robot, *arguments):
        init(robot, *arguments)
        made.append(weakref.ref(robot))

    monkeypatch.setattr(kind, "__init__", noted)
    spec = RunSpec(
        environment=CatalogEnvironment(name="apartment"),
        strategy=strategy,
        robots=(RobotSpec(),) * 2,
        stop=StopRule(max_time_s=max_time_s),
    )
    gc.disable()
    try:
        simulate(spec)
        assert [robot() for robot in made] == [None, None]
    finally:
        gc.enable()
