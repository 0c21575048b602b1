import datetime
import random
import subprocess
import sys
import time
from time import time as clock

import msgspec
import numpy as np
import pytest
import shapely

from multisrt.environments.environment import Environment
from multisrt.geometry.bodies.collision import CollisionWorld
from multisrt.geometry.configuration import Configuration
from multisrt.geometry.errors import InvalidInputError, MultiSrtError
from multisrt.geometry.regions.edge_index import EdgeIndex
from multisrt.geometry.regions.safe_region import local_safe_region
from multisrt.planners.motion.trajectory import Trajectory, Waypoint
from multisrt.robots.explorer import Done, Look, Move, Note, Receive, Received, Send, Sense, Stop
from multisrt.robots.messages import Message
from multisrt.robots.registry import strategies, strategy
from multisrt.spec import DriveSpec, RangeFinderSpec, RobotSpec
from multisrt.testing import ExplorerDefect, check_explorer, two_rooms
from multisrt.testing.fingerprint import fingerprint
from multisrt.testing.hidden_truth import way_to_truth

WORLD = two_rooms()
NOTHING = object()
HALL = Environment("hall", shapely.box(0.0, 0.0, 6.0, 6.0))


class Base:
    """An explorer that follows a script; it has a metre of room ahead of its start."""

    def __init__(self, me):
        self.me = me
        self.at = me.start

    def run(self):
        yield from self.act()
        yield Done(complete=True, reason="enough")

    def act(self):
        yield Sense()

    def to(self, x=0.0, y=0.0, heading=0.0, seconds=10.0, start=None):
        a = self.at if start is None else start
        end = Waypoint(seconds, a.x + x, a.y + y, a.heading + heading)
        return Move(trajectory=Trajectory((Waypoint(0.0, *a), end)))


def explorer(act):
    """Return an explorer whose actions a function of it yields."""

    class Acting(Base):
        def run(self):
            actions = self.act()
            if hasattr(actions, "send"):
                yield from actions
            else:
                while (action := next(actions, NOTHING)) is not NOTHING:
                    yield action
            yield Done(complete=True, reason="enough")

    Acting.act = act
    return Acting


def check(make, *, world=HALL, teams=(1,), start=(3.0, 3.0), **more):
    robot = more.pop("robot", RobotSpec(start=start if tuple(teams) == (1,) else None))
    return check_explorer(make, worlds=[world], teams=teams, robot=robot, **more)


def refused(make, match, **more):
    with pytest.raises(ExplorerDefect, match=match) as caught:
        check(make, **more)
    return caught.value


# What keeps to the contract ---------------------------------------------------------------


@pytest.mark.parametrize("name", ["srt-star", "srt-radial"])
def test_the_strategies_of_the_registry_pass(name):
    checked = check_explorer(strategy(name), worlds=[WORLD], max_actions=3000)
    assert checked.name == name
    assert [run.outcome for run in checked.runs] == ["complete", "complete"]
    assert [run.robots for run in checked.runs] == [1, 3]


@pytest.mark.parametrize(
    "robot",
    [
        RobotSpec(footprint="box:0.5x0.3"),
        RobotSpec(drive=DriveSpec(kind="holonomic")),
        RobotSpec(drive=DriveSpec(kind="reeds-shepp")),
        RobotSpec(range_finder=RangeFinderSpec(range_m=3.0, beams=360)),
    ],
)
def test_bodies_drives_and_lasers_of_all_kinds_pass(robot):
    check_explorer(strategy("srt-radial"), worlds=[WORLD], teams=[2], robot=robot)


def test_the_summary_says_what_was_checked():
    checked = check_explorer(strategy("srt-radial"))
    assert {run.world for run in checked.runs} == {"two rooms", "open", "maze"}
    text = str(checked)
    assert "srt-radial keeps to the contract" in text
    assert "3 robots in 'maze': complete" in text
    assert "does not reach the truth" in text
    assert len({run.digest for run in checked.runs}) == len(checked.runs)


def test_options_are_the_strategys():
    checked = check_explorer(strategy("srt-star"), options={"cones": 8}, worlds=[HALL], teams=[1])
    assert checked.runs[0].outcome == "complete"
    with pytest.raises(InvalidInputError, match="coned"):
        check_explorer(strategy("srt-star"), options={"coned": 8})
    with pytest.raises(InvalidInputError, match="options"):
        check_explorer(Base, options={"cones": 8})


def test_something_to_run_is_asked_for():
    with pytest.raises(InvalidInputError, match="at least one"):
        check_explorer(Base, worlds=[])


def test_a_check_leaves_no_trace():
    before = [s.name for s in strategies()]
    states = random.getstate(), np.random.get_state()[1].tolist()  # noqa: NPY002
    clocks = time.time, time.monotonic_ns, datetime.datetime, clock
    check(Base)
    refused(explorer(lambda self: iter([1])), "no action")
    assert [s.name for s in strategies()] == before
    assert (random.getstate(), np.random.get_state()[1].tolist()) == states  # noqa: NPY002
    assert (time.time, time.monotonic_ns, datetime.datetime, clock) == clocks


def test_the_checker_does_not_need_pytest():
    code = "import sys, multisrt.testing.check; sys.exit('pytest' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_a_defect_says_what_is_wrong_where_and_the_remedy():
    defect = refused(explorer(lambda self: iter([Sense(), 1])), "no action")
    assert isinstance(defect, AssertionError)
    assert isinstance(defect, MultiSrtError)
    assert defect.where == "the robot in 'hall', action 2"
    assert str(defect) == f"{defect.where}: {defect.what}; {defect.remedy}"
    assert "\n" not in str(defect)


# Repeatability ----------------------------------------------------------------------------


def drives_by(number):
    """Return an explorer that drives a distance given by a number from 0 to 1."""

    def act(self):
        yield Sense()
        yield self.to(x=number(self))

    return explorer(act)


def test_the_random_stream_of_the_robot_is_allowed():
    check(drives_by(lambda self: self.me.rng.random()))


@pytest.mark.parametrize("draw", [lambda _: random.random(), lambda _: np.random.rand()])  # noqa: NPY002
def test_global_random_numbers(draw):
    assert "rng" in refused(drives_by(draw), "global random numbers").remedy


def test_a_random_generator_without_a_seed_is_found():
    refused(drives_by(lambda _: np.random.default_rng().random()), "besides what it was sent")


@pytest.mark.parametrize(
    "read",
    [
        lambda: time.time(),
        lambda: 1e-9 * time.perf_counter_ns(),
        lambda: clock(),
        lambda: datetime.datetime.now().timestamp(),
    ],
)
def test_a_clock(read):
    refused(drives_by(lambda _: (read() / 7e9) % 1.0), "reads a clock")


class Counting(Base):
    made = 0

    def act(self):
        Counting.made += 1
        yield Sense()
        yield self.to(x=0.001 * Counting.made)


class Listing(Base):
    places = []  # noqa: RUF012

    def act(self):
        yield Sense()
        Listing.places.append(self.me.robot)
        yield self.to(x=0.001 * len(Listing.places))


SHARED = {"n": 0}


def by_a_global(self):
    SHARED["n"] += 1
    yield Sense()
    yield self.to(x=0.001 * SHARED["n"])


def by_a_default(self, seen=[]):  # noqa: B006
    seen.append(1)
    yield Sense()
    yield self.to(x=0.001 * len(seen))


@pytest.mark.parametrize(
    ("make", "name"),
    [
        (Counting, "Counting.made"),
        (Listing, "Listing.places"),
        (explorer(by_a_global), "SHARED"),
        (explorer(by_a_default), "default of by_a_default"),
    ],
)
def test_state_that_explorers_share(make, name):
    defect = refused(make, "which explorers share")
    assert name in defect.what
    assert "self" in defect.remedy


def test_shared_state_is_found_although_every_run_repeats():
    class Board(Base):
        told = {}  # noqa: RUF012

        def act(self):
            # The first robot clears the shared state: no run knows of another one.
            if self.me.robot == 0:
                Board.told.clear()
            Board.told[self.me.robot] = self.at.x
            yield Sense()
            yield Receive(timeout_s=1.0)
            yield self.to(heading=0.01 * len(Board.told))

    refused(Board, "Board.told.*share", teams=(3,), world=WORLD)
    check(Board)


def test_state_shared_by_simultaneous_explorers_is_found():
    # Each restores the shared state at its end: only simultaneous explorers disturb it.
    class Turnstile(Base):
        inside = set()  # noqa: RUF012

        def act(self):
            others = len(Turnstile.inside)
            Turnstile.inside.add(id(self))
            yield Sense()
            others = max(others, len(Turnstile.inside) - 1)
            yield self.to(x=0.1 * others + 0.1)
            Turnstile.inside.discard(id(self))

    with pytest.raises(ExplorerDefect, match="shares state with explorers that run at the same"):
        check_explorer(Turnstile, worlds=[HALL, HALL], teams=[1], robot=RobotSpec(start=(3.0, 3.0)))


# What it is given -------------------------------------------------------------------------


def test_a_scan_that_is_changed():
    def act(self):
        scan = yield Sense()
        scan.boundary[0] += 0.1
        yield self.to(x=0.1)

    refused(explorer(act), "a scan that it was sent was changed")


def test_a_scan_that_is_changed_later():
    def act(self):
        scan = yield Sense()
        yield self.to(x=0.1)
        scan.boundary[0] += 0.1
        yield Sense()

    refused(explorer(act), "a scan that it was sent was changed")


def test_a_scan_that_is_read_only_by_then():
    def act(self):
        scan = yield Sense()
        local_safe_region(scan, "radial")
        scan.boundary[0] += 0.1

    refused(explorer(act), "a scan that it was sent was changed")


def test_arrays_may_be_made_read_only_and_copied():
    def act(self):
        scan = yield Sense()
        boundary = local_safe_region(scan, "radial").boundary.copy()
        boundary += 1.0

    check(explorer(act))


def test_its_robot_self():
    def act(self):
        yield Sense()
        object.__setattr__(self.me, "range_m", 100.0)
        yield Sense()

    refused(explorer(act), "its RobotSelf was changed")


class Hello(Message, frozen=True, kw_only=True):
    place: np.ndarray


def test_a_message_that_the_receiver_changes():
    def act(self):
        yield Send(Hello(sender=self.me.robot, place=np.zeros(2)))
        received = yield Receive(timeout_s=1.0)
        if isinstance(received, Received):
            received.messages[0].place[0] = 7.0

    refused(explorer(act), "a message .* that it was sent was changed", teams=(2,), world=WORLD)


def test_a_message_that_the_sender_changes():
    def act(self):
        place = np.zeros(2)
        yield Send(Hello(sender=self.me.robot, place=place))
        place[0] = 7.0

    refused(explorer(act), "Send that it had yielded|that it had sent", world=WORLD)


def test_sightings():
    def act(self):
        seen = yield Look()
        for sighting in seen:
            msgspec.structs.force_setattr(sighting, "robot", 9)
        yield Sense()

    robot = RobotSpec(range_finder=RangeFinderSpec(range_m=10.0))
    what = "tuple of sightings that it was sent was changed"
    refused(explorer(act), what, teams=(2,), robot=robot)


def test_a_trajectory():
    def act(self):
        move = self.to(x=0.5)
        self.move = move
        yield Sense()
        yield move

    def act_later(self):
        yield Sense()
        yield (move := self.to(x=0.5))
        object.__setattr__(move.trajectory, "waypoints", ())
        yield Sense()

    check(explorer(act))
    refused(explorer(act_later), "the Move that it had yielded was changed")


# What it yields ---------------------------------------------------------------------------


@pytest.mark.parametrize("nonsense", [None, "sense", Sense, (1.0, 2.0)])
def test_no_action(nonsense):
    refused(explorer(lambda self: iter([nonsense])), "no action")


@pytest.mark.parametrize(
    ("action", "match"),
    [
        (Send("hello"), "no message"),
        (Receive(-1.0), "timeout_s=-1.0"),
        (Receive(float("nan")), "timeout_s=nan"),
        (Note("hello"), "on record"),
        (Stop(), "it stands"),
        (Move(trajectory=((0.0, 3.0, 3.0, 0.0),)), "Move with"),
        (Move(trajectory=Trajectory(())), "waypoints are"),
        (Move(trajectory=Trajectory(((0.0, 3.0, 3.0, 0.0),))), "waypoint 0"),
        (Send(Hello(sender=0, place=object())), "cannot be written"),
        (Send(Hello(sender=0, place=np.zeros(1)), to=4), "to robot 4"),
    ],
)
def test_actions_with_nonsense_in_them(action, match):
    refused(explorer(lambda self: iter([action])), match)


def trajectory(*waypoints):
    return Move(trajectory=Trajectory(tuple(Waypoint(*w) for w in waypoints)))


@pytest.mark.parametrize(
    ("move", "match"),
    [
        (trajectory((0, 3.5, 3, 0), (9, 4, 3, 0)), r"begins at \(3.500.*is at \(3.000"),
        (trajectory((0, 3, 3, 0.1), (9, 3, 3, 0)), "begins at"),
        (trajectory((0, 3, 3, 0), (9, float("nan"), 3, 0)), "waypoint 1"),
        (trajectory((0, 3, 3, 0), (float("inf"), 4, 3, 0)), "waypoint 1"),
        (trajectory((0, 3, 3, 0), (4, 3.1, 3, 0), (3, 3.2, 3, 0)), "waypoint 2 .* at 3 s"),
        (trajectory((1, 3, 3, 0), (4, 3.1, 3, 0)), "waypoint 0 .* at 1 s"),
        (trajectory((0, 3, 3, 0), (1, 3.6, 3, 0)), "0.5 m/s"),
        (trajectory((0, 3, 3, 0), (0, 3.6, 3, 0)), "0.5 m/s"),
        (trajectory((0, 3, 3, 0), (1.99, 4, 3, 0)), "0.5 m/s"),
        (trajectory((0, 3, 3, 0), (1, 3, 3, 1.6)), "rad/s"),
        (trajectory((0, 3, 3, 0), (9, 3, 3.5, 0)), "sideways"),
    ],
)
def test_motions_that_the_body_cannot_make(move, match):
    refused(explorer(lambda self: iter([Sense(), move])), match)


def test_the_limits_themselves_are_allowed():
    turn = trajectory((0, 3, 3, 0), (1, 3, 3, 0.5 * np.pi))
    drive = trajectory((0, 3, 3, 0.5 * np.pi), (2, 3, 4, 0.5 * np.pi))
    check(explorer(lambda self: iter([Sense(), turn, drive])))


@pytest.mark.parametrize(
    ("drive", "move", "match"),
    [
        ("holonomic", trajectory((0, 3, 3, 0), (9, 3.5, 3.5, 0.1)), "keeps its heading"),
        ("reeds-shepp", trajectory((0, 3, 3, 0), (9, 3, 3, 1)), "too tight"),
        ("dubins", trajectory((0, 3, 3, 0), (9, 2.5, 3, 0)), "backwards"),
        ("holonomic", trajectory((0, 3, 3, 0), (9, 3.5, 3.5, 0.0)), None),
        ("reeds-shepp", trajectory((0, 3, 3, 0), (9, 2.5, 3, 0)), None),
        ("reeds-shepp", trajectory((0, 3, 3, 0), (9, 3.6, 3.6, 0.5 * np.pi)), None),
    ],
)
def test_each_drive_allows_only_its_own_motions(drive, move, match):
    make = explorer(lambda self: iter([Sense(), move]))
    robot = RobotSpec(start=(3.0, 3.0), drive=DriveSpec(kind=drive))
    if match is None:
        check(make, robot=robot)
    else:
        refused(make, match, robot=robot)


def test_move_and_done_during_a_motion_are_found():
    class Awake(Hello, frozen=True, kw_only=True):
        @property
        def wakes(self):
            return True

    def act(self):
        if self.me.robot == 0:
            yield Receive(timeout_s=1.0)
            yield Send(Awake(sender=0, place=np.zeros(1)))
            return
        way = Trajectory((Waypoint(0.0, *self.at), Waypoint(9.0, *self.at)))
        told = yield Move(trajectory=way, listen=True)
        assert isinstance(told, Received)
        if self.twice:
            yield Move(trajectory=way)

    first, second = explorer(act), explorer(act)
    first.twice, second.twice = True, False
    refused(first, "while a motion goes on", teams=(2,), world=WORLD)
    refused(second, "Done while it moved", teams=(2,), world=WORLD)


# Where it goes ----------------------------------------------------------------------------


def test_driving_into_unseen_space_is_found():
    def act(self):
        yield self.to(x=1.0)

    defect = refused(explorer(act), "neither sensed nor been told of")
    assert "only_known" in defect.remedy
    check(explorer(act), only_known=False)


def test_driving_round_an_unseen_corner_is_found():
    # From the left room the strip behind the wall is hidden; the way leads there by the door.
    def act(self):
        yield Sense()
        yield self.to(heading=0.5 * np.pi)
        self.at = Configuration(5.0, 3.0, 0.5 * np.pi)
        yield self.to(y=1.25)
        self.at = Configuration(5.0, 4.25, 0.5 * np.pi)
        yield self.to(heading=-0.5 * np.pi)
        self.at = Configuration(5.0, 4.25, 0.0)
        if self.looks:
            yield Sense()
        yield self.to(x=2.0)

    blind, seeing = explorer(act), explorer(act)
    blind.looks, seeing.looks = False, True
    refused(blind, r"action 5: .* neither sensed", world=WORLD, start=(5.0, 3.0))
    check(seeing, world=WORLD, start=(5.0, 3.0))


@pytest.mark.parametrize("tells", [True, False])
def test_what_a_message_may_contain_is_known(tells):
    # The second robot takes no scan.
    def act(self):
        if self.me.robot == 0:
            yield Sense()
            if tells:
                yield Send(Hello(sender=0, place=np.zeros(1)))
        else:
            yield Receive(timeout_s=1.0)
            yield self.to(x=0.2 if self.at.x < 3.0 else -0.2)

    robot = RobotSpec(drive=DriveSpec(kind="holonomic"), range_finder=RangeFinderSpec(range_m=10.0))
    if tells:
        check(explorer(act), teams=(2,), robot=robot)
    else:
        refused(explorer(act), "robot 1 of 2 .* neither sensed", teams=(2,), robot=robot)


def test_a_laser_shows_what_lies_between_its_beams():
    robot = RobotSpec(start=(3.0, 3.0), range_finder=RangeFinderSpec(beams=16))

    def act(self):
        yield Sense()
        yield self.to(x=1.0)

    check(explorer(act), robot=robot)


def test_a_collision():
    def act(self):
        yield Sense()
        yield self.to(x=2.9)

    refused(explorer(act), "touched an obstacle", only_known=False)


# The truth --------------------------------------------------------------------------------


class Cheat(Base):
    def __init__(self, me, world):
        super().__init__(me)
        self.pocket = {"deep": [world]}


class Slotted:
    __slots__ = ("world",)

    def __init__(self, world):
        self.world = world


def as_local(self):
    peeked = [EdgeIndex(WORLD.edges, 1.0)]
    yield Sense()
    yield self.to(x=0.1 * len(peeked))


def by_import(self):
    yield Sense()
    from multisrt.environments.catalog import environment

    environment("open")


def by_module(self):
    import multisrt as ms

    yield Sense()
    ms.explore("open")


@pytest.mark.parametrize(
    ("make", "match"),
    [
        (lambda me: Cheat(me, WORLD), r"explorer\.pocket\['deep'\]\[0\] is a .*Environment"),
        (lambda me: Cheat(me, Slotted(WORLD)), r"pocket\['deep'\]\[0\]\.world is"),
        (lambda me: Cheat(me, lambda: WORLD.free), "global 'WORLD'"),
        (lambda me: Cheat(me, CollisionWorld(WORLD.free)), "CollisionWorld"),
        (lambda me: Cheat(me, EdgeIndex(HALL.edges, 1.0)), "EdgeIndex of the world"),
        (lambda me: Cheat(me, HALL.edges[:2]), "array of the world's edges"),
        (explorer(lambda self: iter([Sense()] * len(WORLD.starts))), "global 'WORLD' is"),
        (explorer(by_import), r"multisrt\.environments\.catalog"),
        (explorer(by_module), r"ms\.explore is multisrt\.run\.explore"),
    ],
)
def test_the_truth(make, match):
    defect = refused(make, match)
    assert "gets at the truth" in defect.what


def test_the_truth_in_a_closure_and_in_a_generator():
    def hide(world):
        return lambda: world

    refused(lambda me: Cheat(me, hide(WORLD)), "closure 'world'")

    class Peeking(Base):
        def run(self):
            index = self.look()
            yield Sense()
            del index
            yield Done(complete=True, reason="")

        def look(self):
            return next(iter(PEEK))

    PEEK[:] = [EdgeIndex(HALL.edges, 1.0)]
    refused(Peeking, r"local 'index'|global 'PEEK'")


PEEK: list[object] = []


def test_an_index_of_what_the_robot_has_seen_is_allowed():
    def act(self):
        scan = yield Sense()
        # Part of the hall: its visibility polygon, of which a corner is cut off by the range.
        edges = np.hstack([scan.boundary, np.roll(scan.boundary, -1, axis=0)])
        self.index = EdgeIndex(edges, 1.0)
        yield Sense()

    check(explorer(act), start=(1.0, 1.0))


def test_the_path_to_the_truth_is_a_shortest_one():
    thing = {"a": {"b": [WORLD]}, "c": WORLD}
    found = way_to_truth({"it": thing}, WORLD)
    assert found is not None
    assert found[0] == "it['c']"
    assert way_to_truth({"it": {"a": 1, "b": [np.zeros(3)]}}, WORLD) is None


# The end ----------------------------------------------------------------------------------


def test_endless_without_time():
    def act(self):
        while True:
            yield Sense()

    refused(explorer(act), "100 actions and was not Done", max_actions=100)


def test_endless_in_time():
    def act(self):
        while True:
            yield Receive(timeout_s=10.0)

    refused(explorer(act), r"robots \[0\] were not done after 1000 s", max_time_s=1000.0)


def test_waiting_for_ever():
    refused(explorer(lambda self: iter([Receive()])), "never comes")


def test_no_done():
    class Short(Base):
        def run(self):
            yield Sense()

    refused(Short, "without a last action Done")


def test_no_generator():
    class Listed(Base):
        def run(self):
            return [Sense(), Done(complete=True, reason="")]

    refused(Listed, "gave a list, not a generator")


def test_errors_of_the_explorer_are_reported_as_the_cause():
    def act(self):
        yield Sense()
        raise KeyError("lost")

    assert isinstance(refused(explorer(act), "raised KeyError").__cause__, KeyError)


def test_explorers_that_cannot_be_built_are_found():
    refused(lambda me: me.nonsense, "building .* raised AttributeError")
    refused(lambda me: 7, r"a int, which has no run\(\)")


# Fingerprints -----------------------------------------------------------------------------


def test_fingerprints_tell_values_apart_and_not_objects():
    def value(x=1.0):
        return {"a": (1, np.array([x, 2.0])), "b": Waypoint(0.0, x, 2.0, 3.0), "c": {1, 2}}

    assert fingerprint(value()) == fingerprint(value())
    assert fingerprint(value()) != fingerprint(value(np.nextafter(1.0, 2.0)))
    assert fingerprint([1, [2]]) != fingerprint([[1], 2])
    assert fingerprint((1, 2)) != fingerprint([1, 2])
    assert fingerprint(np.zeros(2)) != fingerprint(np.zeros((2, 1)))
    endless = []
    endless.append(endless)
    assert fingerprint(endless)
