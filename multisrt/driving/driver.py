"""Explorers outside the simulation: `drive` and `Driver`.

An explorer yields actions and receives their outcomes. Here the actions are executed by callables
supplied by the user, which command a real robot or a robot in another simulator.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Generator, Iterable, Mapping
from dataclasses import replace
from typing import Any, NoReturn

from multisrt.driving.body import Arrived, Body, Told
from multisrt.events import AnyEvent, Blocked, Ended, Motion, Sensed, Sent
from multisrt.geometry.configuration import Configuration
from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.regions.scan import ExactScan, LaserScan, Scan
from multisrt.robots.defects import brief
from multisrt.robots.encoding import decode, encode
from multisrt.robots.explorer import (
    Action,
    Done,
    Explorer,
    Look,
    Move,
    Moved,
    Note,
    Outcome,
    Receive,
    Received,
    RobotSelf,
    Send,
    Sense,
    Sighting,
    Steps,
    Stop,
    TimedOut,
)
from multisrt.robots.messages import Message
from multisrt.robots.registry import strategy as strategy_named
from multisrt.robots.strategy import Strategy, as_strategy
from multisrt.simulation import plain, protocol
from multisrt.simulation.plain import SAME_TIME_S

Exploring = Strategy | Callable[[RobotSelf, Any], Explorer] | str
"""A strategy, its name, or a class or function that builds the explorer of one robot."""


def drive(
    strategy: Exploring,
    me: RobotSelf,
    *,
    sense: Callable[[], Scan],
    move: Callable[[Move], Moved | None],
    send: Callable[[bytes, int | None], object] | None = None,
    receive: Callable[[float], Told] | None = None,
    look: Callable[[], Iterable[Sighting]] | None = None,
    stop: Callable[[], Moved] | None = None,
    options: Mapping[str, object] | None = None,
    note: Callable[[AnyEvent], object] | None = None,
    on_call_s: float = 60.0,
) -> Driver:
    """Run an explorer on a robot outside the simulation, until it is done.

    Parameters
    ----------
    strategy : str, Strategy, class or callable
        A strategy, its name, or a class or function that builds an explorer from `me` and
        `options`.
    me : RobotSelf
        What the robot knows about itself before it begins.
    sense, move, send, receive, look, stop : callable
        Callables that command the body; see `Body`.
    options : mapping, optional
        Options of the strategy that differ from its defaults.
    note : callable, optional
        Called with each event that the explorer records.
    on_call_s : float, optional
        Time in seconds for which a robot that is done and on call waits for messages.

    Returns
    -------
    Driver
        The finished driver: `events`, `end`, `explorer`.

    Raises
    ------
    InvalidInputError
        If a callable returns an invalid value, or one that the explorer needs is missing.
    ExplorerDefect
        If the explorer yields an impossible action.

    Examples
    --------
    A body that stands in the middle of a room, and is commanded to look around:

    >>> import numpy as np
    >>> from multisrt.driving import scan_of_polygon
    >>> from multisrt.geometry.bodies.footprint import Footprint
    >>> from multisrt.planners.motion.kinematics import Differential
    >>> me = RobotSelf(
    ...     robot=0,
    ...     start=Configuration(2.0, 2.0),
    ...     footprint=Footprint.disc(0.2),
    ...     kinematics=Differential(),
    ...     range_m=5.0,
    ...     rng=np.random.default_rng(1),
    ... )
    >>> room = [(0.0, 0.0), (4.0, 0.0), (4.0, 4.0), (0.0, 4.0)]
    >>> def sense():
    ...     return scan_of_polygon(room, me.start, time_s=0.0, range_m=5.0)
    >>> def move(move):
    ...     raise AssertionError("there is nothing to drive to")
    >>> drive("srt-radial", me, sense=sense, move=move).end.complete
    True
    """
    body = Body(sense=sense, move=move, send=send, receive=receive, look=look, stop=stop)
    driver = Driver(strategy, me, body, options=options, note=note, on_call_s=on_call_s)
    while driver.poll():
        pass
    return driver


class Driver:
    """Runs one explorer on one body, as long as the body has something to report.

    With several robots in one process, a loop calls `poll` of each in turn.

    Parameters
    ----------
    strategy, me, options, note, on_call_s
        As for `drive`.
    body : Body
        The callables that command the body.

    Attributes
    ----------
    me : RobotSelf
        What the robot knew about itself at the beginning.
    explorer : Explorer
        The explorer.
    time_s : float
        The last time in seconds that the explorer received.
    events : list of Event
        All events: those recorded by the explorer, scans, motions, messages and the end.
    end : Ended or None
        How the explorer ended; None while it explores.
    """

    def __init__(
        self,
        strategy: Exploring,
        me: RobotSelf,
        body: Body,
        *,
        options: Mapping[str, object] | None = None,
        note: Callable[[AnyEvent], object] | None = None,
        on_call_s: float = math.inf,
    ) -> None:
        self.me = me
        self.name, self.options, self.explorer = _explorer(strategy, me, options)
        self.time_s = me.time_s
        self.events: list[AnyEvent] = []
        self.end: Ended | None = None
        self._body = body
        self._note = note
        self._on_call_s = on_call_s
        self._mailbox: list[Message] = []
        self._motion: tuple[Move, float] | None = None
        self._pace = protocol.Pace(me.robot)
        self._loop = self._run()

    @property
    def is_done(self) -> bool:
        """Whether the explorer is done, perhaps on call."""
        return self.end is not None

    def poll(self) -> bool:
        """Continue until the body has nothing to report yet.

        Returns
        -------
        bool
            Whether the explorer may act again; also true if it is done and on call.
        """
        return next(self._loop, False) is not False

    def close(self) -> None:
        """Abandon the run, and close the explorer."""
        self._loop.close()

    # Actions -----------------------------------------------------------------------------

    def _run(self) -> Generator[bool, None, None]:
        number = self.me.robot
        actions = protocol.begin(self.explorer, number)
        outcome: Outcome = None
        while True:
            action = self._next(actions, outcome)
            outcome = None
            protocol.require_in_order(action, number, moves=self._motion is not None)
            match action:
                case Sense():
                    outcome = self._sense()
                case Look():
                    outcome = self._look()
                case Move():
                    outcome = yield from self._move(plain.motion(action, number))
                case Stop():
                    outcome = self._stop()
                case Send():
                    self._send(action)
                case Receive():
                    limit_s = plain.timeout_s(action, number)
                    until_s = math.inf if limit_s is None else self.time_s + max(0.0, limit_s)
                    outcome = yield from self._wait(until_s)
                case Note():
                    self._put_on_record(action)
                case Done():
                    outcome = yield from self._finish(action)
                    if outcome is None:
                        return
                case _:
                    protocol.refuse_action(action, number)

    def _next(self, actions: Steps, outcome: Outcome) -> Action:
        self._pace.count(self.time_s)
        return protocol.next_action(self.explorer, actions, outcome, self.me.robot)

    def _sense(self) -> Scan:
        scan = self._body.sense()
        if not isinstance(scan, ExactScan | LaserScan):
            self._refuse("sense", scan, "a scan: scan_of_ranges and scan_of_polygon make one")
        self._tell_time(scan.time_s, "sense")
        here = self._configuration(scan.configuration, "sense")
        if isinstance(scan, LaserScan) and scan.covered is None:
            scan = replace(scan, covered=self.me.footprint.outline_at(here))
        self.events.append(Sensed(time_s=self.time_s, robot=self.me.robot, configuration=(*here,)))
        return scan

    def _look(self) -> tuple[Sighting, ...]:
        if self._body.look is None:
            return ()
        seen = self._body.look()
        found = tuple(seen) if isinstance(seen, Iterable) else (seen,)
        if not all(isinstance(each, Sighting) for each in found):
            self._refuse("look", seen, "a Sighting of each robot that is seen; if none is, ()")
        return found

    def _send(self, action: Send) -> None:
        if self._body.send is None:
            raise InvalidInputError(
                f"the explorer of robot {self.me.robot} sends a message, but there is no send: "
                "give one, which carries bytes to another robot or to all"
            )
        to = plain.addressee(action.to, self.me.robot)
        size_bytes = plain.size_bytes(action.message, self.me.robot)
        self._body.send(encode(action.message), to)
        kind, number = action.message.kind, self.me.robot
        self.events.append(Sent(time_s=self.time_s, robot=number, kind=kind, size_bytes=size_bytes))

    def _put_on_record(self, action: Note) -> None:
        event = plain.event(action.event, self.me.robot, self.time_s)
        self.events.append(event)
        if self._note is not None:
            self._note(event)

    def _finish(self, done: Done) -> Generator[bool, None, Received | None]:
        on_call = plain.is_on_call(done, self.me.robot)
        self.end = plain.ended(done, self.me.robot, self.time_s)
        self.events.append(self.end)
        if not on_call or self.me.team == 1 or self._body.receive is None:
            return None
        told = yield from self._wait(self.time_s + self._on_call_s)
        if not isinstance(told, Received):
            return None
        self.end = None
        return told

    # Motion and waiting ------------------------------------------------------------------

    def _move(self, move: Move) -> Generator[bool, None, Outcome]:
        self._motion = move, self.time_s
        moved = self._body.move(move)
        if moved is not None:
            return self._moved(moved, "move")
        if self._body.receive is None:
            raise InvalidInputError(
                "move returned None, so that the motion goes on, but there is no receive that "
                "reports its end: give one, or return Moved when the motion has ended"
            )
        return (yield from self._wait(math.inf, hears=move.listen))

    def _stop(self) -> Moved:
        if self._body.stop is None:
            raise InvalidInputError(
                f"the explorer of robot {self.me.robot} stops on its way, but there is no stop: "
                "give one, or a move that returns when the motion has ended"
            )
        return self._moved(self._body.stop(), "stop")

    def _moved(self, moved: object, of: str) -> Moved:
        if not isinstance(moved, Moved):
            self._refuse(of, moved, "Moved(configuration=..., time_s=...)")
        if self._motion is None:
            self._refuse(of, moved, "Moved only for a motion that was begun")
        (move, set_out_s), self._motion = self._motion, None
        here = self._configuration(moved.configuration, of)
        self._tell_time(moved.time_s, of)
        number = self.me.robot
        self.events.append(_driven(move, set_out_s, self.time_s, here, number))
        if moved.blocked_by is not None:
            if not isinstance(moved.blocked_by, Sighting):
                self._refuse(of, moved, "Moved with a Sighting or None as blocked_by")
            by = moved.blocked_by.robot
            self.events.append(
                Blocked(time_s=self.time_s, robot=number, by=by, configuration=(*here,))
            )
        return Moved(configuration=here, time_s=self.time_s, blocked_by=moved.blocked_by)

    def _wait(
        self, until_s: float, *, hears: bool = True
    ) -> Generator[bool, None, Moved | Received | TimedOut]:
        # Until a motion ends, messages arrive or the time has come, as in the simulation.
        while True:
            if hears and self._mailbox and (self._motion is None or self._is_woken()):
                return self._received()
            told = self._listen(until_s)
            match told:
                case None:
                    yield True
                case Moved():
                    return self._moved(told, "receive")
                case Arrived():
                    if not isinstance(told.data, tuple | list):
                        self._refuse("receive", told, "Arrived with a tuple of bytes as data")
                    self._mailbox += map(decode, told.data)
                    self._tell_time(told.time_s, "receive")
                case TimedOut():
                    self._tell_time(told.time_s, "receive")
                    if hears and self._mailbox:
                        return self._received()
                    if self.time_s < until_s - SAME_TIME_S:
                        self._refuse("receive", told, f"TimedOut at {until_s:g} s or later")
                    return told
                case _:
                    self._refuse("receive", told, "Arrived, Moved, TimedOut or None")

    def _listen(self, until_s: float) -> object:
        if self._body.receive is not None:
            return self._body.receive(until_s)
        if until_s > self.time_s:
            raise InvalidInputError(
                f"the explorer of robot {self.me.robot} waits, but there is no receive: give one, "
                "which returns TimedOut at the time that it is given"
            )
        return TimedOut(self.time_s)

    def _is_woken(self) -> bool:
        return any(message.wakes for message in self._mailbox)

    def _received(self) -> Received:
        messages = tuple(self._mailbox)
        self._mailbox.clear()
        return Received(messages, self.time_s)

    def _configuration(self, told: object, of: str) -> Configuration:
        try:
            x, y, heading = map(float, told)  # type: ignore[call-overload]
        except (TypeError, ValueError):
            x = y = heading = math.nan
        if not math.isfinite(x + y + heading):
            raise InvalidInputError(
                f"{of} of robot {self.me.robot} reports the configuration {brief(told)}: give x, y "
                "(m) and the heading (rad), three finite numbers"
            )
        return Configuration(x, y, heading)

    def _tell_time(self, told: object, of: str) -> None:
        try:
            time_s = float(told)  # type: ignore[arg-type]
            said = f"{time_s:g}"
        except (TypeError, ValueError):
            time_s, said = math.nan, brief(told)
        if not math.isfinite(time_s) or time_s < self.time_s - SAME_TIME_S:
            raise InvalidInputError(
                f"{of} of robot {self.me.robot} reports {said} s after {self.time_s:g} s: give "
                "seconds of one clock, which never falls"
            )
        self.time_s = max(self.time_s, time_s)

    def _refuse(self, of: str, value: object, remedy: str) -> NoReturn:
        raise InvalidInputError(
            f"{of} of robot {self.me.robot} returned {brief(value)}; return {remedy}"
        )


def _driven(
    move: Move, set_out_s: float, ended_s: float, here: Configuration, robot: int
) -> Motion:
    # The commanded path up to the point nearest to where it ended, in the time that it took.
    trajectory = move.trajectory
    if trajectory.end.distance(here) > 0.0:
        times = [trajectory.duration_s * k / 200 for k in range(201)]
        trajectory = trajectory.until(min(times, key=lambda t: trajectory.at(t).distance(here)))
    took_s, planned_s = ended_s - set_out_s, trajectory.duration_s
    pace = took_s / planned_s if planned_s > 0.0 else 0.0
    waypoints = [(set_out_s + pace * w.time_s, w.x, w.y, w.heading) for w in trajectory.waypoints]
    last = waypoints[-1]
    turn = math.remainder(here.heading - last[3], math.tau)
    waypoints[len(waypoints) - 1 :] = [(ended_s, here.x, here.y, last[3] + turn)]
    return Motion(time_s=set_out_s, robot=robot, waypoints=tuple(waypoints), purpose=move.purpose)


def _explorer(
    strategy: Exploring, me: RobotSelf, options: Mapping[str, object] | None
) -> tuple[str, dict[str, Any], Explorer]:
    given = dict(options or {})
    chosen = strategy_named(strategy) if isinstance(strategy, str) else as_strategy(strategy)
    if chosen.sees_truth:
        raise InvalidInputError(
            f"{chosen.name} plans on the true map, so it drives simulated robots only"
        )
    return chosen.name, given, chosen.explorer(me, chosen.parse_options(given))
