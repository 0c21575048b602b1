"""Explorers with one mistake each, as their authors would write them."""

import gc
import random
import time
from typing import Any

import msgspec
import numpy as np

from multisrt.events import MapComplete
from multisrt.geometry.configuration import Configuration
from multisrt.planners.motion.steering import turn_and_drive
from multisrt.planners.motion.trajectory import Trajectory, Waypoint
from multisrt.robots.explorer import Done, Look, Move, Note, Receive, Send, Sense, Stop
from multisrt.robots.messages import Message
from multisrt.robots.toolkit import RegionExplorer, assignment

HEARD: list[int] = []


class Options(msgspec.Struct, frozen=True, kw_only=True):
    """None."""


class Explorer:
    """What the wrong explorers have in common."""

    def __init__(self, me, options):
        self.me = me
        self.at = me.start

    def go(self, x, y):
        """Drive by a vector."""
        motion = turn_and_drive(self.me.kinematics, self.at, self.at.x + x, self.at.y + y)
        moved = yield Move(trajectory=motion, guard_m=0.1)
        self.at = moved.configuration

    def step(self, length=0.1):
        """Drive a little in a random direction, within what every scan shows."""
        angle = self.draw()
        yield from self.go(length * np.cos(angle), length * np.sin(angle))

    def draw(self):
        """Draw an angle."""
        return self.me.rng.uniform(0.0, 2.0 * np.pi)

    def end(self):
        """Return the last action."""
        return Done(complete=False, reason="enough")


class NeverSenses(Explorer):
    def run(self):
        yield Receive(timeout_s=10.0)
        yield Done(complete=True, reason="all is known")


class EndsAtOnce(Explorer):
    def run(self):
        yield Done(complete=False, reason="nothing to do")


class NeverMoves(Explorer):
    def run(self):
        yield Sense()
        yield self.end()


class CoversLittle(Explorer):
    def run(self):
        scan = yield Sense()
        x, y = 0.01 * (scan.boundary.mean(axis=0) - self.at[:2])
        yield from self.go(x, y)
        yield self.end()


class DrivesBlind(Explorer):
    def run(self):
        yield from self.go(0.3, 0.0)
        yield Sense()
        yield self.end()


class DrivesThroughAWall(Explorer):
    def run(self):
        yield Sense()
        yield from self.go(20.0, 0.0)
        yield self.end()


class SharesAClassAttribute(Explorer):
    seen: list[Any] = []  # noqa: RUF012

    def run(self):
        yield Sense()
        self.seen.append(self.at)
        yield Receive(timeout_s=float(len(self.seen)))
        yield self.end()


class SharesAGlobal(Explorer):
    def run(self):
        yield Sense()
        HEARD.append(self.me.robot)
        yield Receive(timeout_s=float(len(HEARD)))
        yield self.end()


class Hello(Message, frozen=True, kw_only=True):
    content: Any


class SendsWhatCannotBeWritten(Explorer):
    def run(self):
        yield Sense()
        yield Send(Hello(sender=self.me.robot, content=(1, self.me.rng)))
        yield self.end()


class ChangesItsMessage(Explorer):
    def run(self):
        places = [1.0]
        yield Sense()
        yield Send(Hello(sender=self.me.robot, content=places))
        yield Receive(timeout_s=1.0)
        places.append(2.0)
        yield self.end()


class SendsToNobody(Explorer):
    def run(self):
        yield Send(Hello(sender=self.me.robot, content=1), to=7)
        yield self.end()


class Wanders(Explorer):
    """Drives a little, in a direction that its children draw."""

    def run(self):
        yield Sense()
        yield from self.step()
        yield self.end()


class DrawsByRandom(Wanders):
    def draw(self):
        return random.uniform(0.0, 6.28)


class DrawsByNumpy(Wanders):
    def draw(self):
        return np.random.uniform(0.0, 6.28)  # noqa: NPY002


class DrawsFromAnUnseededGenerator(Wanders):
    def draw(self):
        return np.random.default_rng().uniform(0.0, 6.28)


class ReadsAClock(Wanders):
    def draw(self):
        return time.time() % 6.28


class GoesByAddresses(Wanders):
    def draw(self):
        return id(object()) * 1e-3 % 6.28 + 1e-6 * id(self)


class WaitsForEver(Explorer):
    def run(self):
        yield Sense()
        yield Receive()
        yield self.end()


class PollsForEver(Explorer):
    def run(self):
        yield Sense()
        while True:
            yield Receive(timeout_s=1.0)


class DrivesToAndFro(Explorer):
    def run(self):
        yield Sense()
        while True:
            yield from self.go(0.2, 0.0)
            yield from self.go(-0.2, 0.0)


class NotesForEver(Explorer):
    def run(self):
        while True:
            yield Note(MapComplete(time_s=0.0, robot=self.me.robot))


class ComputesForEver(Explorer):
    def run(self):
        scan = yield Sense()
        best = 0.0
        while best < scan.range_m:
            best += 0.0
        yield self.end()


class CatchesAll(Explorer):
    def run(self):
        yield Sense()
        count = 0
        while True:
            try:  # noqa: SIM105
                count += 1
            except:  # noqa: E722
                pass


class ReturnsAList(Explorer):
    def run(self):
        return [Sense(), self.end()]


class ReturnsNothing(Explorer):
    def run(self):
        self.first = Sense()


class ReturnsWithoutDone(Explorer):
    def run(self):
        yield Sense()


class IsAsynchronous(Explorer):
    async def run(self):
        yield Sense()


class YieldsATuple(Explorer):
    def run(self):
        yield (Sense(), self.end())


class YieldsNothing(Explorer):
    def run(self):
        yield


class YieldsAClass(Explorer):
    def run(self):
        yield Sense
        yield self.end()


class YieldsAProcedure(Explorer):
    def run(self):
        yield Sense()
        yield self.go(0.1, 0.0)
        yield self.end()


class YieldsATrajectory(Explorer):
    def run(self):
        yield turn_and_drive(self.me.kinematics, self.at, self.at.x, self.at.y)
        yield self.end()


class BeginsElsewhere(Explorer):
    def run(self):
        yield Sense()
        start = Configuration(0.0, 0.0, 0.0)
        yield Move(trajectory=turn_and_drive(self.me.kinematics, start, 1.0, 0.0))
        yield self.end()


class DrivesTooFast(Explorer):
    def run(self):
        yield Sense()
        x, y, heading = self.at
        end = Waypoint(0.1, x + 0.5 * np.cos(heading), y + 0.5 * np.sin(heading), heading)
        yield Move(trajectory=Trajectory((Waypoint(0.0, x, y, heading), end)))
        yield self.end()


class DrivesToNowhere(Explorer):
    def run(self):
        yield Sense()
        x, y, heading = self.at
        end = Waypoint(1.0, float("nan"), y, heading)
        yield Move(trajectory=Trajectory((Waypoint(0.0, x, y, heading), end)))
        yield self.end()


class Wake(Message, frozen=True, kw_only=True):
    @property
    def wakes(self):
        """Wake at once."""
        return True


class IsDoneWhileItMoves(Explorer):
    def run(self):
        scan = yield Sense()
        x, y = 0.9 * np.array(self.at[:2]) + 0.1 * scan.boundary.mean(axis=0)
        if self.me.robot > 0:
            yield Receive(timeout_s=0.1)
            yield Send(Wake(sender=self.me.robot))
        else:
            motion = turn_and_drive(self.me.kinematics, self.at, x, y)
            yield Move(trajectory=motion, listen=True)
        yield self.end()


class StopsWhereItStands(Explorer):
    def run(self):
        yield Stop()
        yield self.end()


class NotesForAnother(Explorer):
    def run(self):
        yield Note(MapComplete(time_s=0.0, robot=self.me.robot + 1))
        yield self.end()


class NotesTheFuture(Explorer):
    def run(self):
        yield Note(MapComplete(time_s=60.0, robot=self.me.robot))
        yield self.end()


class EndsWithAWord(Explorer):
    def run(self):
        yield Sense()
        yield Done(complete="yes", reason="enough")  # type: ignore[arg-type]


class ImportsTheWorld(Explorer):
    def run(self):
        from multisrt.environments.catalog import environment

        yield Sense()
        yield Done(complete=False, reason=f"{environment('office').free.area} m2")


class SearchesMemory(Explorer):
    def run(self):
        yield Sense()
        found = [thing for thing in gc.get_objects() if type(thing).__name__ == "Environment"]
        yield Done(complete=False, reason=f"{len(found)} worlds")


class LooksIntoFrames(Explorer):
    def run(self):
        try:
            raise ValueError
        except ValueError as error:
            frame = error.__traceback__.tb_frame.f_back  # type: ignore[union-attr]
        yield Sense()
        yield Done(complete=False, reason=str(frame))


class WritesALog(Explorer):
    def run(self):
        scan = yield Sense()
        with open("log.txt", "a") as log:
            log.write(f"sensed at {scan.time_s} s")
        yield self.end()


class ChangesItsScan(Explorer):
    def run(self):
        scan = yield Sense()
        scan.boundary[:] += 1.0
        yield self.end()


class RaisesAnError(Explorer):
    def run(self):
        yield Sense()
        yield self.best({})

    def best(self, costs):
        return costs["goal"]


class Exits(Explorer):
    def run(self):
        yield Sense()
        raise SystemExit(0)


class CannotBeBuilt(Explorer):
    def __init__(self, me, options):
        super().__init__(me, options)
        self.width_m = me.footprint.breadth_m

    def run(self):
        yield self.end()


class HasNoRun:
    def __init__(self, me, options):
        self.me = me


class TakesTooMuch(Explorer):
    def __init__(self, me, options, world):
        super().__init__(me, options)
        self.world = world

    def run(self):
        yield self.end()


class Collides(Explorer):
    """Drives to where the others start, without a guard distance."""

    def run(self):
        scan = yield Sense()
        middle = scan.boundary.mean(axis=0)
        for _ in range(40):
            angle = self.me.rng.uniform(0.0, 2.0 * np.pi)
            x, y = middle + 0.4 * np.array([np.cos(angle), np.sin(angle)])
            motion = turn_and_drive(self.me.kinematics, self.at, x, y)
            moved = yield Move(trajectory=motion)
            self.at = moved.configuration
        yield self.end()


class GoesByTheOrderOfASet(Explorer):
    def run(self):
        yield Sense()
        first = next(iter({f"{angle} degrees" for angle in range(360)}))
        angle = np.radians(float(first.removesuffix(" degrees")))
        yield from self.go(0.05 * np.cos(angle), 0.05 * np.sin(angle))
        yield self.end()


class ForgetsYieldFrom(Explorer):
    def look_around(self):
        """Take a scan."""
        yield Sense()

    def run(self):
        self.look_around()
        yield self.end()


class ForgetsYield(Explorer):
    def run(self):
        Sense()
        yield self.end()


class UsesAnAction(Explorer):
    def run(self):
        yield Look()
        scan: Any = Sense()
        yield Receive(timeout_s=scan.time_s)


class MisspellsAnAttribute(Explorer):
    def run(self):
        scan = yield Sense()
        yield Receive(timeout_s=scan.times_s)


class GivesArgumentsByPlace(Explorer):
    def run(self):
        yield Sense()
        yield Move(self.at, guard=0.1)  # type: ignore[call-arg]


class ForgetsSuper(RegionExplorer):
    def __init__(self, me, options):
        self.told = me.start, options

    def choose(self):
        """Choose nothing."""
        return None


class ForgetsReturn(RegionExplorer):
    def choose(self):
        """Look at the map."""
        self.map.open_nodes()


class MisspellsChoose(RegionExplorer):
    def chose(self):
        """Choose nothing."""
        return None


@assignment
def keeps_a_list(costs, robot):
    """Choose by how often it was asked, by whomever."""
    HEARD.append(robot)
    return np.argsort(costs[robot])[len(HEARD) % 2 if np.isfinite(costs[robot]).sum() > 1 else 0]


@assignment
def misspells_a_function(costs, robot):
    """Choose nothing."""
    return costs[robot].argmim()
