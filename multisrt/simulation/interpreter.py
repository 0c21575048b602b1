"""The interpreter of one explorer's actions.

It runs as a process of the clock: it sends the explorer the outcome of its last action, carries
out the action that the explorer yields, and waits where the action takes time.
"""

from __future__ import annotations

from collections.abc import Callable, Generator
from dataclasses import dataclass
from typing import Any

import simpy

from multisrt.events import Ended, Organized, Sensed
from multisrt.geometry.regions.scan import Scan
from multisrt.robots.code_places import package_of, place_of_yield, place_suffix
from multisrt.robots.defects import ExplorerDefect, refuse
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
    Send,
    Sense,
    Steps,
    Stop,
    TimedOut,
)
from multisrt.simulation import plain, protocol
from multisrt.simulation.clock import LATE, ROUNDING_S, Clock
from multisrt.simulation.faults import Faults
from multisrt.simulation.journal import Journal
from multisrt.simulation.mail import Mail
from multisrt.simulation.motions import Motions
from multisrt.simulation.robot import Robot
from multisrt.simulation.sensing import Sensing
from multisrt.simulation.standstill import Standstill

Process = Generator[Any, Any, None]
"""A process of the clock."""

Pause = Callable[[int, Outcome, Action], simpy.Event]
"""Takes a robot, what its explorer received and what it yielded; returns an event to wait for."""

Overhear = Callable[[int, float, Outcome, Action], None]
"""Takes a robot, the time in seconds, what its explorer received and what it yielded."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Surroundings:
    """What carries out the actions of all robots of a run, and the name of their strategy."""

    strategy: str
    clock: Clock
    journal: Journal
    sensing: Sensing
    motions: Motions
    mail: Mail
    faults: Faults
    standstill: Standstill


class _Terminated(Exception):
    """Ends the process of a robot that has died or collided."""


class Interpreter:
    """Carries out the actions of one robot's explorer.

    Parameters
    ----------
    robot : Robot
        The robot.
    explorer : Explorer
        What decides for it.
    surroundings : Surroundings
        What carries out its actions.
    pause : callable, optional
        What to wait for before each action is carried out.
    overhear : callable, optional
        Called before each action is carried out.

    Attributes
    ----------
    actions : generator or None
        What `run` of the explorer returned.
    """

    def __init__(
        self,
        robot: Robot,
        explorer: Explorer,
        surroundings: Surroundings,
        pause: Pause | None = None,
        overhear: Overhear | None = None,
    ) -> None:
        self._robot = robot
        self._explorer = explorer
        self._is_ours = package_of(type(explorer)) == "multisrt"
        self._pause = pause
        self._overhear = overhear
        self._strategy = surroundings.strategy
        self._clock = surroundings.clock
        self._journal = surroundings.journal
        self._sensing = surroundings.sensing
        self._motions = surroundings.motions
        self._mail = surroundings.mail
        self._faults = surroundings.faults
        self._standstill = surroundings.standstill
        self.actions: Steps | None = None
        self._pace = protocol.Pace(robot.number)

    def process(self, join_s: float | None) -> Process:
        """Run the explorer until it is permanently done, or the robot dies or collides.

        Parameters
        ----------
        join_s : float or None
            When a robot that starts late is switched on, in seconds; None: it is on already.
        """
        try:
            if join_s is not None:
                while self._clock.now_s < join_s - ROUNDING_S:
                    self._clock.later(join_s - self._clock.now_s, self._robot.poke)
                    yield from self._sleep()
                self._faults.join(self._robot)
            yield from self._interpret()
        except _Terminated:
            pass
        except ExplorerDefect as defect:
            raise defect.in_run(self._strategy, self._clock.now_s) from defect.__cause__

    def _interpret(self) -> Process:
        robot, number, pause = self._robot, self._robot.number, self._pause
        outcome: Outcome = None
        self.actions = actions = protocol.begin(self._explorer, number)
        while True:
            action = self._next_action(actions, outcome)
            if pause is not None:
                yield pause(number, outcome, action)
            outcome = None
            protocol.require_in_order(action, number, moves=robot.motion is not None)
            match action:
                # The most frequent actions come first.
                case Receive():
                    if robot.mailbox and robot.motion is None and not self._faults.is_doomed(robot):
                        outcome = self._received()
                    else:
                        outcome = yield from self._wait(plain.timeout_s(action, number))
                case Send():
                    self._mail.send(robot, action.message, action.to)
                case Note():
                    self._note(action)
                case Move():
                    move = plain.motion(action, number)
                    if not self._motions.begin(robot, move):
                        return
                    self._faults.on_setting_out(robot)
                    outcome = yield from self._wait(None, hears=move.listen)
                case Sense():
                    outcome = self._scan()
                case Look():
                    outcome = self._sensing.look(robot, self._clock.now_s)
                case Stop():
                    outcome = self._stop()
                case Done():
                    on_call = plain.is_on_call(action, number)
                    self._finish(action)
                    if not on_call:
                        return
                    outcome = yield from self._wait(None)
                    robot.state = "on"
                case _:
                    protocol.refuse_action(action, number)
            if robot.state == "dead" or self._motions.collision is not None:
                return

    def _next_action(self, actions: Steps, outcome: Outcome) -> Action:
        now_s, number = self._clock.now_s, self._robot.number
        self._journal.note_time(now_s)
        self._pace.count(now_s)
        action = protocol.next_action(self._explorer, actions, outcome, number)
        if self._overhear is not None:
            self._overhear(number, now_s, outcome, action)
        return action

    def _note(self, note: Note) -> None:
        number = self._robot.number
        try:
            event = plain.event(note.event, number, self._clock.now_s, is_ours=self._is_ours)
        except ExplorerDefect as defect:
            place = place_suffix(place_of_yield(type(self._explorer), self.actions))
            raise ExplorerDefect(f"{defect.what}{place}", defect.where, defect.remedy) from None
        if flaw := self._journal.flaw(event):
            refuse(number, f"its {type(event).__name__}: {flaw}", "see multisrt.events")
        self._journal.record(event)
        if isinstance(event, Organized):
            self._faults.on_doing(self._robot, "master")

    def _scan(self) -> Scan:
        now_s = self._clock.now_s
        scan = self._sensing.scan(self._robot, now_s)
        # What a run is judged by is recorded here, whatever the explorer makes of it.
        self._journal.record(
            Sensed(time_s=now_s, robot=self._robot.number, configuration=(*scan.configuration,))
        )
        return scan

    def _stop(self) -> Moved | None:
        robot = self._robot
        self._faults.on_doing(robot, "moving")
        return None if robot.state == "dead" else self._motions.end(robot, self._clock.now_s)

    def _finish(self, done: Done) -> None:
        robot = self._robot
        end = plain.ended(done, robot.number, self._clock.now_s)
        if flaw := self._journal.flaw(end):
            refuse(robot.number, f"its Done: {flaw}", "give places in metres")
        # A robot that is called on and ends as before is not recorded again.
        if robot.end is None or _statement(robot.end) != _statement(end):
            self._journal.record(end)
        robot.end = end
        robot.state = "done"

    # Waiting -----------------------------------------------------------------------------

    def _wait(
        self, timeout_s: float | None, hears: bool = True
    ) -> Generator[Any, Any, Moved | Received | TimedOut]:
        # Until a motion ends, messages arrive or time is up, in this order of precedence.
        robot, time_out = self._robot, None
        robot.waits = robot.motion is None
        if robot.waits:
            self._faults.on_doing(robot, "waiting")
        try:
            while True:
                if self._motions.is_stopped(robot):
                    self._faults.on_doing(robot, "moving")
                if robot.state == "dead":
                    raise _Terminated
                if (moved := self._motions.ended(robot)) is not None:
                    return moved
                if self._motions.collision is not None:
                    raise _Terminated
                if (hears and robot.mailbox) and (
                    robot.motion is None or any(m.wakes for m in robot.mailbox)
                ):
                    return self._received()
                if time_out is not None and time_out.processed:
                    if hears and robot.mailbox:
                        return self._received()
                    return TimedOut(self._clock.now_s)
                if timeout_s is not None and time_out is None:
                    time_out = self._clock.later(max(0.0, timeout_s), robot.poke, LATE)
                    self._standstill.expect(self._clock.now_s + timeout_s, timeout_s)
                yield from self._sleep()
        finally:
            robot.waits = False

    def _received(self) -> Received:
        messages = tuple(self._robot.mailbox)
        self._robot.mailbox.clear()
        return Received(messages, self._clock.now_s)

    def _sleep(self) -> Process:
        self._robot.wake = self._clock.event()
        yield self._robot.wake
        if self._robot.state == "dead":
            raise _Terminated


def _statement(end: Ended) -> tuple[object, ...]:
    return end.reason, end.complete, end.frontier
