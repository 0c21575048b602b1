"""The contract of an explorer: an object that yields actions and receives their outcomes.

An explorer makes the decisions of one robot. Its method `run` is a generator that yields actions
and receives their outcomes as the values of the yield expressions:

>>> class OneScan:
...     '''Takes one scan, and ends.'''
...
...     def __init__(self, me, options):
...         self.me = me
...
...     def run(self):
...         scan = yield Sense()
...         yield Done(complete=False, reason=f"has looked around at {scan.time_s} s")

An explorer does no input or output, knows the time only from these outcomes, and has no access to
the world: it knows only its scans, its messages and its own configuration. The same explorer can
therefore be run by the simulation, step by step in a test, or by the driver of a real robot.

=========  ==========================================  =========================================
action     effect                                      outcome that is sent back
=========  ==========================================  =========================================
`Sense`    the range finder takes a scan               `Scan`
`Look`     bodies of other robots are detected         tuple of `Sighting`
`Move`     the body follows a trajectory               `Moved`; while listening, or `Received`
`Stop`     the present motion ends immediately         `Moved`
`Send`     a message goes out by radio                 None
`Receive`  waits for messages, or for a motion's end   `Received`, `Moved` or `TimedOut`
`Note`     an event is recorded                        None
`Done`     the robot stays where it is                 nothing; on call, `Received`
=========  ==========================================  =========================================

Time passes only in `Move` and `Receive`. Lengths are in metres, times in seconds since the run
began, angles in radians counter-clockwise from the x axis; all robots share one frame.

A `Strategy` is made from the class of an explorer, or a function that builds one, and a frozen
structure of options. A complete example, which drives back and forth:

>>> import msgspec
>>> import multisrt as ms
>>> from multisrt.geometry.configuration import Configuration
>>> from multisrt.planners.motion.steering import turn_and_drive

>>> class Options(msgspec.Struct, frozen=True, kw_only=True):
...     '''How far to drive in metres, and how often.'''
...
...     length_m: float = 2.0
...     times: int = 3

>>> class BackAndForth:
...     '''Scans at both ends of a straight line.'''
...
...     def __init__(self, me: RobotSelf, options: Options) -> None:
...         self.me = me
...         self.options = options
...
...     def run(self) -> "Steps":
...         at = self.me.start
...         ends = [Configuration(at.x + self.options.length_m, at.y, 0.0), at]
...         for k in range(self.options.times):
...             yield Sense()
...             goal = ends[k % 2]
...             motion = turn_and_drive(self.me.kinematics, at, goal.x, goal.y)
...             moved = yield Move(trajectory=motion, guard_m=0.1)
...             at = moved.configuration
...             if moved.blocked_by is not None:
...                 yield Done(complete=False, reason="another robot is in the way")
...                 return
...         yield Done(complete=False, reason=f"has driven {self.options.times} times")

>>> strategy = ms.Strategy(
...     name="back-and-forth",
...     summary="Drives to and fro on a straight line",
...     options=Options,
...     explorer=BackAndForth,
... )

`check_explorer` runs a strategy and reports its first defect; `ms.register` makes it available by
name to `ms.explore`, to experiments and to the command line. A test can run it step by step:

>>> import numpy as np
>>> from multisrt.geometry.bodies.footprint import Footprint
>>> from multisrt.planners.motion.kinematics import Differential
>>> me = RobotSelf(
...     robot=0,
...     start=Configuration(1.0, 1.0, 0.0),
...     footprint=Footprint.disc(0.25),
...     kinematics=Differential(),
...     range_m=4.0,
...     rng=np.random.default_rng(0),
... )
>>> steps = strategy.explorer(me, Options(times=1)).run()
>>> next(steps)
Sense()
>>> move = steps.send(None)  # the scan: this explorer does not read it
>>> move.trajectory.end.x
3.0
>>> steps.send(Moved(configuration=move.trajectory.end, time_s=move.trajectory.duration_s)).reason
'has driven 1 times'
"""

from __future__ import annotations

from collections.abc import Generator
from typing import Protocol

import msgspec

from multisrt.events import AnyEvent, Purpose
from multisrt.geometry.bodies.footprint import Footprint
from multisrt.geometry.configuration import Configuration
from multisrt.geometry.regions.scan import Scan
from multisrt.planners.motion.trajectory import Trajectory
from multisrt.robots.messages import Message
from multisrt.robots.robot_self import RadioSelf, RobotSelf

__all__ = [
    "Action",
    "Done",
    "Explorer",
    "Look",
    "Move",
    "Moved",
    "Note",
    "Outcome",
    "RadioSelf",
    "Receive",
    "Received",
    "RobotSelf",
    "Send",
    "Sense",
    "Sighting",
    "Steps",
    "Stop",
    "TimedOut",
]

# Actions ------------------------------------------------------------------------------------


class Sense(msgspec.Struct, frozen=True):
    """Take a scan from the current configuration, also during a motion; the outcome is a `Scan`.

    Examples
    --------
    >>> def look_around():
    ...     scan = yield Sense()
    ...     yield Done(complete=False, reason=f"has seen up to {scan.range_m} m")
    >>> next(look_around())
    Sense()
    """


class Look(msgspec.Struct, frozen=True):
    """Detect the visible bodies of other robots within sensing range.

    The outcome is a tuple of `Sighting`, empty if there are none.

    Examples
    --------
    >>> def wait_for_space():
    ...     while (yield Look()):
    ...         yield Receive(timeout_s=1.0)
    ...     yield Done(complete=False, reason="no robot is in sight")
    >>> steps = wait_for_space()
    >>> next(steps), steps.send(()).reason
    (Look(), 'no robot is in sight')
    """


class Move(msgspec.Struct, frozen=True, kw_only=True):
    """Follow a trajectory.

    The outcome is `Moved`, when the motion ends.

    Attributes
    ----------
    trajectory : Trajectory
        The motion; it begins at the current configuration.
    purpose : Purpose
        Why the robot moves, for the record.
    guard_m : float or None
        Guard distance of the protective stop in metres: the motion ends before the distance to
        another visible body falls below this value. If a body is closer already when the motion
        begins, the motion ends before that distance is halved or falls below a quarter of the guard
        distance; if it is closer than this quarter, before the distance decreases at all. None: no
        protective stop.
    listen : bool
        Whether messages are delivered during the motion: the outcome is `Received` when a message
        arrives that wakes (see `Message.wakes`), and the motion continues. `Receive` then waits for
        the next message, and its last outcome is `Moved`.

    Examples
    --------
    >>> from multisrt.planners.motion.kinematics import Holonomic
    >>> motion = Holonomic(speed_m_s=0.5).drive(Configuration(0.0, 0.0, 0.0), 3.0, 4.0)
    >>> move = Move(trajectory=motion, guard_m=0.1)
    >>> move.trajectory.duration_s, move.purpose
    (10.0, 'explore')
    """

    trajectory: Trajectory
    purpose: Purpose = "explore"
    guard_m: float | None = None
    listen: bool = False


class Stop(msgspec.Struct, frozen=True):
    """End the present motion; the outcome is `Moved`.

    Examples
    --------
    >>> def drive(trajectory):
    ...     told = yield Move(trajectory=trajectory, listen=True)
    ...     if isinstance(told, Received):  # a message came on the way
    ...         told = yield Stop()
    ...     yield Done(complete=False, reason=f"stands since {told.time_s} s")
    """


class Send(msgspec.Struct, frozen=True):
    """Send a message by radio.

    Attributes
    ----------
    message : Message
        The message.
    to : int or None
        Number of the receiving robot; None: all robots that the radio reaches.

    Examples
    --------
    >>> class Hello(Message, frozen=True, kw_only=True):
    ...     kind = "hello"
    >>> Send(Hello(sender=0), to=2).message.kind
    'hello'
    """

    message: Message
    to: int | None = None


class Receive(msgspec.Struct, frozen=True):
    """Wait for messages, or for the end of the present motion.

    The outcome is `Received`, `Moved` if a motion ended, or `TimedOut`.

    Attributes
    ----------
    timeout_s : float or None
        Maximum time to wait in seconds; 0: only messages that arrive at the present time; None: no
        limit. During a motion, only messages that wake end the waiting; the others are received
        when the motion has ended.

    Examples
    --------
    >>> def wait():
    ...     told = yield Receive(timeout_s=5.0)
    ...     heard = len(told.messages) if isinstance(told, Received) else 0
    ...     yield Done(complete=False, reason=f"{heard} messages by {told.time_s} s")
    >>> steps = wait()
    >>> next(steps), steps.send(TimedOut(time_s=5.0)).reason
    (Receive(timeout_s=5.0), '0 messages by 5.0 s')
    """

    timeout_s: float | None = None


class Note(msgspec.Struct, frozen=True):
    """Record an event; this takes no time.

    It has no effect on the run, except that it may trigger a fault: a robot whose `multisrt.Death`
    has ``when="master"`` dies when it records `Organized`.

    Attributes
    ----------
    event : Event
        The event.

    Examples
    --------
    >>> from multisrt.events import MapComplete
    >>> Note(MapComplete(time_s=12.0, robot=0)).event.time_s
    12.0
    """

    event: AnyEvent


class Done(msgspec.Struct, frozen=True):
    """End the exploration; the robot stays where it is.

    Attributes
    ----------
    complete : bool
        Whether it left no frontier that it could reach if no other body blocked its path.
    reason : str
        Why it ended, as text.
    frontier : tuple of (x0, y0, x1, y1)
        Frontier segments that it leaves open, in metres.
    on_call : bool
        Whether messages are still delivered: the outcome is `Received` when one arrives, and the
        robot may act until it yields `Done` again. The run ends when all robots are done and no
        message is in flight.

    Examples
    --------
    >>> Done(complete=False, reason="the battery is low", frontier=((2.0, 0.0, 2.0, 1.5),)).on_call
    False
    """

    complete: bool
    reason: str
    frontier: tuple[tuple[float, float, float, float], ...] = ()
    on_call: bool = False


# Outcomes -----------------------------------------------------------------------------------


class Sighting(msgspec.Struct, frozen=True, kw_only=True):
    """The body of another robot, as detected by the range finder.

    Attributes
    ----------
    robot : int
        Number of that robot; robots can be identified.
    configuration : Configuration
        Its configuration.
    footprint : Footprint
        Its outline.

    Examples
    --------
    >>> at = Configuration(3.0, 4.0, 0.0)
    >>> seen = Sighting(robot=1, configuration=at, footprint=Footprint.disc(0.25))
    >>> seen.configuration.distance(Configuration(0.0, 0.0)), seen.footprint.width_m
    (5.0, 0.5)
    """

    robot: int
    configuration: Configuration
    footprint: Footprint


class Moved(msgspec.Struct, frozen=True, kw_only=True):
    """The end of a motion.

    Attributes
    ----------
    configuration : Configuration
        Where it ended.
    time_s : float
        When it ended.
    blocked_by : Sighting or None
        The body that caused a protective stop; None if the motion was completed or ended by `Stop`.

    Examples
    --------
    >>> moved = Moved(configuration=Configuration(3.0, 4.0), time_s=10.0)
    >>> moved.blocked_by is None
    True
    """

    configuration: Configuration
    time_s: float
    blocked_by: Sighting | None = None


class Received(msgspec.Struct, frozen=True):
    """Received messages, in the order of their arrival.

    Attributes
    ----------
    messages : tuple of Message
        At least one.
    time_s : float
        Time at which the last of them arrived.

    Examples
    --------
    >>> Received((Message(sender=2), Message(sender=1)), time_s=7.5).messages[0].sender
    2
    """

    messages: tuple[Message, ...]
    time_s: float


class TimedOut(msgspec.Struct, frozen=True):
    """No message arrived within the time limit of `Receive`.

    Attributes
    ----------
    time_s : float
        The present time.
    """

    time_s: float


Action = Sense | Look | Move | Stop | Send | Receive | Note | Done
Outcome = Scan | tuple[Sighting, ...] | Moved | Received | TimedOut | None
Steps = Generator[Action, Outcome, None]
"""Type of the generators of `Explorer.run` and of procedures called with ``yield from``."""


class Explorer(Protocol):
    """The decision maker of one robot.

    Examples
    --------
    >>> class StaysAtHome:
    ...     def run(self):
    ...         yield Done(complete=False, reason="has stayed at home")
    >>> [action.reason for action in StaysAtHome().run()]
    ['has stayed at home']
    """

    def run(self) -> Steps:
        """Yield actions and receive their outcomes.

        The last action is `Done`. It is an error of the explorer if the generator returns without
        it or raises an exception; `multisrt.testing.check_explorer` finds most such errors.

        Returns
        -------
        generator
            Yields the robot's actions and receives the outcome of each.
        """
        ...
