"""One run under way: the robots, the clock, and all that carries out what explorers yield."""

from __future__ import annotations

import math
from typing import IO

import msgspec
import simpy

from multisrt.geometry.bodies.footprint import Footprint
from multisrt.planners.motion.trajectory import Trajectory
from multisrt.recording import Recorder, Recording, RunOutcome
from multisrt.robots.explorer import (
    Action,
    Done,
    Move,
    Moved,
    Note,
    Outcome,
    Receive,
    Received,
    Send,
)
from multisrt.robots.messages import Message
from multisrt.robots.naming import named_robots
from multisrt.simulation.clock import Clock
from multisrt.simulation.faults import Faults, late_starts
from multisrt.simulation.interpreter import Interpreter, Overhear, Surroundings
from multisrt.simulation.journal import Journal, Watcher
from multisrt.simulation.mail import Mail
from multisrt.simulation.motions import Motions
from multisrt.simulation.robot import Robot
from multisrt.simulation.sensing import Sensing
from multisrt.simulation.setting_up import SetUp
from multisrt.simulation.standstill import WAITS_FOR_EVER, Standstill
from multisrt.simulation.traffic import Traffic


class Step(msgspec.Struct, frozen=True, kw_only=True):
    """One action of one robot, which has been decided and not yet been carried out.

    Attributes
    ----------
    robot : int
        The robot.
    time_s : float
        The time in seconds.
    outcome : Outcome
        What the explorer last received: the outcome of its action before, None at first.
    action : Action
        What it yielded: the action that is carried out next.
    """

    robot: int
    time_s: float
    outcome: Outcome
    action: Action

    def __str__(self) -> str:
        told = "" if self.outcome is None else f"{_told(self.outcome)} -> "
        return f"{self.time_s:.2f} s  robot {self.robot}  {told}{_done(self.action)}"


class Simulation:
    """One run under way.

    Parameters
    ----------
    setup : SetUp
        The run.
    watch : callable, optional
        Called with every event as it is recorded.
    overhear : callable, optional
        Called before each action with the robot, the time in seconds, what its explorer received
        for the last action, and what it yielded.
    file : binary file, optional
        Where the recording is written during the run.
    pausing : bool, optional
        Whether the run pauses before each action.

    Attributes
    ----------
    interpreters : list of Interpreter
        Those of the robots, by number; empty once the explorers are let go of.
    paused_at : Step or None
        The step before which the run pauses now: the next advance of the clock carries it out.
    """

    def __init__(
        self,
        setup: SetUp,
        *,
        watch: Watcher | None = None,
        overhear: Overhear | None = None,
        file: IO[bytes] | None = None,
        pausing: bool = False,
    ) -> None:
        spec = self.spec = setup.spec
        self._streams = setup.streams
        self.clock = clock = Clock()
        self._standstill = standstill = Standstill(spec.stop.max_idle_s, spec.faults)
        self.journal = journal = Journal(Recorder(setup.header, file), standstill, watch)
        self.robots = robots = [
            Robot(number, robot, setup.obstacles.body(Footprint.parse(robot.footprint)), clock)
            for number, robot in enumerate(spec.robots)
        ]
        traffic = Traffic([robot.body for robot in robots], setup.starts, setup.index)
        sensing = Sensing(setup.index, traffic, robots)
        self.motions = Motions(
            robots,
            setup.obstacles,
            traffic,
            sensing,
            clock=clock,
            journal=journal,
            max_time_s=spec.stop.max_time_s,
        )
        self.mail = Mail(
            robots,
            setup.radio,
            spec.radio,
            traffic,
            setup.base,
            clock=clock,
            journal=journal,
        )
        faults = Faults(spec.faults, robots, self.motions, clock=clock, journal=journal)
        surroundings = Surroundings(
            strategy=spec.strategy,
            clock=clock,
            journal=journal,
            sensing=sensing,
            motions=self.motions,
            mail=self.mail,
            faults=faults,
            standstill=standstill,
        )
        self.paused_at: Step | None = None
        joins = late_starts(spec.faults)
        for robot in robots:
            if robot.number not in joins:
                # All are switched on before the first of them sends anything.
                faults.switch_on(robot)
        pause = self._pause if pausing else None
        self.interpreters = [
            Interpreter(robot, explorer, surroundings, pause, overhear)
            for robot, explorer in zip(robots, setup.explorers, strict=True)
        ]
        self._processes = [
            interpreter.process(joins.get(number))
            for number, interpreter in enumerate(self.interpreters)
        ]
        for process in self._processes:
            clock.start(process)

    def has_events(self) -> bool:
        """Whether anything is left to happen before the run ends by the stop rule."""
        next_s = self.clock.next_s
        return (
            next_s <= self.spec.stop.max_time_s
            and not self._is_over()
            and not self._standstill.is_over(next_s, self.robots)
        )

    def close(self) -> None:
        """Let go of the explorers."""
        # Suspended processes would keep the robots' maps until garbage is collected.
        for process in self._processes:
            process.close()
        self.mail.close()
        self.interpreters.clear()

    def finish(self) -> Recording:
        """Let go of the explorers, and return the recording of the run, which does not continue."""
        self.close()
        max_time_s = self.spec.stop.max_time_s
        next_s = self.clock.next_s
        if not self._is_over() and next_s < math.inf:
            end_s = self._standstill.end_s
            if end_s <= max_time_s and self._standstill.is_over(next_s, self.robots):
                self.motions.end_all(end_s)
                return self._finish(end_s, "stalled", self._standstill.reason(self.robots))
            self.motions.end_all(max_time_s)
            reason = f"the time limit of {max_time_s:g} s is reached"
            return self._finish(max_time_s, "out_of_time", reason)
        return self._finish(self.journal.last_s, *self._outcome())

    def recording_so_far(self) -> Recording:
        """Return the recording as if the run were cut off now; it continues."""
        now_s = self.clock.now_s
        return self.journal.cut_off(
            now_s,
            f"stepped up to {now_s:g} s",
            self.motions.under_way(now_s),
            chance=self._streams.are_drawn_from,
        )

    def _finish(self, time_s: float, outcome: RunOutcome, reason: str) -> Recording:
        chance = self._streams.are_drawn_from
        return self.journal.finish(time_s, outcome, reason, chance=chance)

    def _pause(self, robot: int, outcome: Outcome, action: Action) -> simpy.Event:
        now_s = self.clock.now_s
        self.paused_at = Step(robot=robot, time_s=now_s, outcome=outcome, action=action)
        return self.clock.pause()

    def _is_over(self) -> bool:
        # All are done or dead, and no message is on its way that could call one on.
        if self.motions.collision is not None:
            return True
        if self.mail.messages_in_flight > 0:
            return False
        for robot in self.robots:
            if robot.state == "dead":
                continue
            # One that is done and not on call waits for nothing.
            if robot.state != "done" or (robot.mailbox and robot.waits):
                return False
        return True

    def _outcome(self) -> tuple[RunOutcome, str]:
        if (collision := self.motions.collision) is not None:
            return "stalled", f"robot {collision.robot} {collision.account}"
        living = [robot for robot in self.robots if robot.state != "dead"]
        if not living:
            return "stalled", "all robots died"
        waiting = [robot.number for robot in living if robot.state != "done" or robot.end is None]
        if waiting:
            wait = "waits" if len(waiting) == 1 else "wait"
            return "stalled", f"{named_robots(waiting)} {wait} {WAITS_FOR_EVER}"
        ends = [robot.end for robot in living if robot.end is not None]
        dead = [robot.number for robot in self.robots if robot.state == "dead"]
        if len({end.reason for end in ends}) == 1 and len(ends) > 1:
            told = [f"all {'others' if dead else 'robots'}: {ends[0].reason}"]
        else:
            told = [f"robot {end.robot}: {end.reason}" for end in ends]
        reasons = "; ".join([f"{named_robots(dead)} died", *told] if dead else told)
        return ("complete" if all(end.complete for end in ends) else "stalled"), reasons


def _told(outcome: Outcome) -> str:
    match outcome:
        case tuple():
            return f"sees {[sighting.robot for sighting in outcome]}"
        case Moved():
            x, y, _ = outcome.configuration
            by = outcome.blocked_by
            return f"Moved to ({x:.2f}, {y:.2f})" + (f", blocked by {by.robot}" if by else "")
        case Received():
            kinds = ", ".join(f"{m.kind} of {m.sender}" for m in outcome.messages)
            return f"Received({kinds})"
    return type(outcome).__name__


def _done(action: Action) -> str:
    name = type(action).__name__
    match action:
        case Note():
            return f"Note({type(action.event).__name__})"
        case Move() if isinstance(action.trajectory, Trajectory):
            end = action.trajectory.end
            return f"Move to ({end.x:.2f}, {end.y:.2f}) in {action.trajectory.duration_s:.2f} s"
        case Send() if isinstance(action.message, Message):
            to = "all" if action.to is None else action.to
            return f"Send({action.message.kind}) to {to}"
        case Receive():
            if action.timeout_s is None:
                return "Receive"
            if action.timeout_s == 0.0:
                return "Receive what has arrived"
            return f"Receive for {action.timeout_s:g} s"
        case Done():
            return f"Done({action.reason})"
    return name
