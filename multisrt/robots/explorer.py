"""The contract of an explorer: a plain object that is told what happens and says what to do.

`Explorer.run` is a generator. It yields actions and is sent back their outcomes. It does no
input or output, reads no clock but the one it is told, and cannot reach the world: it knows its
scans, its messages and its own configuration, and that is all. The same explorer can be driven
by the simulation, by a test by hand, or by a real robot.

=============  ==========================================  ================================
action         what is done                                what is sent back
=============  ==========================================  ================================
`Sense`        the range finder looks round                `Scan`
`Look`         other robots' bodies in sight are noticed   tuple of `Sighting`
`Move`         the body follows a trajectory               `Moved`, or `Received` (see there)
`Stop`         a motion that goes on ends here and now     `Moved`
`Send`         a message goes out by radio                 None
`Receive`      waits for messages, or for a motion's end   `Received`, `Moved` or `TimedOut`
`Note`         an event is put on record                   None
`Done`         nothing more; the robot stays where it is   nothing, or `Received` (see there)
=============  ==========================================  ================================
"""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import dataclass
from typing import Protocol

import msgspec
from numpy.random import Generator as RandomGenerator

from multisrt.events import AnyEvent, Purpose
from multisrt.geometry.bodies.footprint import Footprint
from multisrt.geometry.configuration import Configuration
from multisrt.geometry.regions.scan import Scan
from multisrt.planners.motion.kinematics import Kinematics
from multisrt.planners.motion.trajectory import Trajectory
from multisrt.robots.messages import Message


class Sense(msgspec.Struct, frozen=True):
    """Look round from where the robot is, also while it moves."""


class Look(msgspec.Struct, frozen=True):
    """Notice the bodies of other robots that are in sight and within range."""


class Move(msgspec.Struct, frozen=True, kw_only=True):
    """Follow a trajectory, which begins where the robot is.

    Attributes
    ----------
    trajectory : Trajectory
        The motion.
    purpose : str
        Why, for the record.
    guard_m : float or None
        The protective stop: the motion ends where another body that is in sight would come
        nearer than this. One that is nearer already when the motion begins stops it where the
        distance would fall below half of what it was, or below a quarter of this; one that is
        nearer than that, where it would fall at all. None: no such stop.
    listen : bool
        Whether to be told of messages on the way: `Received` is sent back when one comes that
        wakes (see `Message`), while the motion goes on; `Receive` waits for what comes next,
        and at last gives `Moved`.
    """

    trajectory: Trajectory
    purpose: Purpose = "explore"
    guard_m: float | None = None
    listen: bool = False


class Stop(msgspec.Struct, frozen=True):
    """End the motion that goes on."""


class Send(msgspec.Struct, frozen=True):
    """Send a message to whoever the radio reaches, or to one robot.

    Attributes
    ----------
    message : Message
        What is sent.
    to : int or None
        The robot that it is for; None: all.
    """

    message: Message
    to: int | None = None


class Receive(msgspec.Struct, frozen=True):
    """Wait for messages, or for the end of the motion that goes on.

    Attributes
    ----------
    timeout_s : float or None
        For how long; 0: until nothing more comes at this moment; None: for ever. While a motion
        goes on, only messages that wake end the waiting before its time; what else has come is
        received when it is over.
    """

    timeout_s: float | None = None


class Note(msgspec.Struct, frozen=True):
    """Put an event on record. It changes nothing and takes no time."""

    event: AnyEvent


class Done(msgspec.Struct, frozen=True):
    """The robot has finished.

    Attributes
    ----------
    complete : bool
        Whether all that it knew how to explore is explored.
    reason : str
        Why it ended, in words.
    frontier : tuple of (x0, y0, x1, y1)
        What frontier it leaves open.
    on_call : bool
        Whether to be told of messages that still come: `Received` is sent back, and the robot
        may act until it is done again. The run ends when all robots are done and no message
        is on its way.
    """

    complete: bool
    reason: str
    frontier: tuple[tuple[float, float, float, float], ...] = ()
    on_call: bool = False


class Sighting(msgspec.Struct, frozen=True, kw_only=True):
    """Another robot's body, as the range finder sees it.

    Attributes
    ----------
    robot : int
        Which; robots can be told apart.
    configuration : Configuration
        Where it is.
    footprint : Footprint
        Its outline.
    """

    robot: int
    configuration: Configuration
    footprint: Footprint


class Moved(msgspec.Struct, frozen=True, kw_only=True):
    """Where and when a motion ended.

    Attributes
    ----------
    configuration : Configuration
        Where.
    time_s : float
        When.
    blocked_by : Sighting or None
        The body before which the protective stop ended it.
    """

    configuration: Configuration
    time_s: float
    blocked_by: Sighting | None = None


class Received(msgspec.Struct, frozen=True):
    """Messages that came, in the order in which they came.

    Attributes
    ----------
    messages : tuple of Message
        At least one.
    time_s : float
        When the last one came.
    """

    messages: tuple[Message, ...]
    time_s: float


class TimedOut(msgspec.Struct, frozen=True):
    """Nothing came in time."""

    time_s: float


Action = Sense | Look | Move | Stop | Send | Receive | Note | Done
Outcome = Scan | tuple[Sighting, ...] | Moved | Received | TimedOut | None
Steps = Generator[Action, Outcome, None]
"""What `Explorer.run` returns, and every procedure that it delegates to."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RadioSelf:
    """What a robot knows of its radio: its data sheet.

    Attributes
    ----------
    range_m : float
        How far it reaches in the open; inf: unlimited.
    latency_s : float
        A message comes within this time, or never.
    loss : float
        Share of messages that never come.
    multi_hop : bool
        Whether robots in between relay messages.
    reaches_all : bool
        Whether every message comes to everybody: nothing limits the range, stands in the way,
        or loses it.
    """

    range_m: float = float("inf")
    latency_s: float = 0.0
    loss: float = 0.0
    multi_hop: bool = True
    reaches_all: bool = True


@dataclass(frozen=True, slots=True, kw_only=True)
class RobotSelf:
    """What a robot knows of itself before it begins.

    Attributes
    ----------
    robot : int
        Its number, from 0.
    start : Configuration
        Where it stands.
    footprint : Footprint
        Its body.
    kinematics : Kinematics
        How it moves.
    range_m : float
        How far its range finder reaches.
    rng : numpy.random.Generator
        Its own stream of random numbers.
    team : int
        How many robots the team has.
    radio : RadioSelf
        What its radio can do.
    time_s : float
        When it begins.
    team_range_m : float or None
        How far any range finder of the team reaches; None: as far as its own.
    """

    robot: int
    start: Configuration
    footprint: Footprint
    kinematics: Kinematics
    range_m: float
    rng: RandomGenerator
    team: int = 1
    radio: RadioSelf = RadioSelf()
    time_s: float = 0.0
    team_range_m: float | None = None

    @property
    def longest_range_m(self) -> float:
        """How far the best range finder of the team reaches."""
        return self.range_m if self.team_range_m is None else self.team_range_m


class Explorer(Protocol):
    """What decides for one robot."""

    def run(self) -> Generator[Action, Outcome, None]:
        """Yield actions and be sent their outcomes; the last action is `Done`."""
        ...
