"""What explorers are given, what they yield and where they go."""

from typing import Any, cast

import msgspec
import numpy as np
import pytest

from multisrt.events import ArcClosed, MapComplete
from multisrt.geometry.configuration import Configuration
from multisrt.geometry.regions.safe_region import local_safe_region
from multisrt.planners.motion.trajectory import Trajectory, Waypoint
from multisrt.robots.explorer import Look, Move, Note, Receive, Received, Send, Sense, Stop
from multisrt.spec import DriveSpec, RangeFinderSpec, RobotSpec
from tests.multisrt.testing.explorers import WORLD, Hello, check, explorer, refused

ARC = ArcClosed(time_s=0.0, robot=0, node=(0, 0), reason=cast(Any, "narrow"), arc=())


def test_a_scan_that_is_changed_is_found():
    def act(self):
        scan = yield Sense()
        scan.boundary[0] += 0.1
        yield self.to(x=0.1)

    refused(explorer(act), "a scan that it was sent was changed")


def test_a_scan_that_is_changed_later_is_found():
    def act(self):
        scan = yield Sense()
        yield self.to(x=0.1)
        scan.boundary[0] += 0.1
        yield Sense()

    refused(explorer(act), "a scan that it was sent was changed")


def test_a_read_only_scan_that_is_changed_is_found():
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


def test_a_change_of_its_robot_self_is_found():
    def act(self):
        yield Sense()
        object.__setattr__(self.me, "range_m", 100.0)
        yield Sense()

    refused(explorer(act), "its RobotSelf was changed")


def test_a_message_that_the_receiver_changes_is_found():
    def act(self):
        yield Send(Hello(sender=self.me.robot, place=np.zeros(2)))
        received = yield Receive(timeout_s=1.0)
        if isinstance(received, Received):
            (message,) = received.messages
            assert isinstance(message, Hello)
            message.place[0] = 7.0

    refused(explorer(act), "a message .* that it was sent was changed", teams=(2,), world=WORLD)


def test_sightings_that_are_changed_are_found():
    def act(self):
        seen = yield Look()
        for sighting in seen:
            msgspec.structs.force_setattr(sighting, "robot", 9)
        yield Sense()

    robot = RobotSpec(range_finder=RangeFinderSpec(range_m=10.0))
    what = "tuple of sightings that it was sent was changed"
    refused(explorer(act), what, teams=(2,), robot=robot)


def test_a_trajectory_that_is_changed_is_found():
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


@pytest.mark.parametrize("nonsense", [None, "sense", Sense, (1.0, 2.0)])
def test_what_is_no_action_is_found(nonsense):
    refused(explorer(lambda self: iter([nonsense])), "no action|the class Sense")


@pytest.mark.parametrize(
    ("action", "match"),
    [
        (Send(cast(Any, "hello")), "no message"),
        (Receive(-1.0), "timeout_s of its Receive is -1; give 0 or more"),
        (Receive(float("nan")), "timeout_s of its Receive is nan, a float"),
        (Note(cast(Any, "hello")), "on record"),
        (Note(MapComplete(time_s=0, robot=0)), "a whole number where its class declares a float"),
        (Note(ARC), "reason: unknown value 'narrow'; allowed: 'blocked by"),
        (Stop(), "it stands"),
        (Move(trajectory=cast(Any, ((0.0, 3.0, 3.0, 0.0),))), "trajectory of its Move is"),
        (Move(trajectory=Trajectory(())), "its trajectory has no waypoint"),
        (Move(trajectory=Trajectory(cast(Any, ((0.0, 3.0, 3.0),)))), "waypoint 0"),
        (Send(Hello(sender=0, place=cast(Any, object()))), "cannot be written"),
        (Send(Hello(sender=0, place=np.zeros(1)), to=4), "to robot 4"),
    ],
)
def test_actions_with_wrong_arguments_are_found(action, match):
    refused(explorer(lambda self: iter([action])), match)


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
        motion = Trajectory((Waypoint(0.0, *self.at), Waypoint(9.0, *self.at)))
        told = yield Move(trajectory=motion, listen=True)
        assert isinstance(told, Received)
        if self.twice:
            yield Move(trajectory=motion)

    twice, once = explorer(act, twice=True), explorer(act, twice=False)
    refused(twice, "while a motion goes on", teams=(2,), world=WORLD)
    refused(once, "Done while a motion goes on", teams=(2,), world=WORLD)


def test_driving_into_unseen_space_is_found():
    def act(self):
        yield self.to(x=1.0)

    defect = refused(explorer(act), "neither sensed nor been told of")
    assert "only_known" in defect.remedy
    check(explorer(act), only_known=False)


def test_driving_around_an_unseen_corner_is_found():
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

    blind, seeing = explorer(act, looks=False), explorer(act, looks=True)
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
