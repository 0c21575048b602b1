"""What goes wrong with robots, and when: deaths, silences and late starts.

A death strikes at its time, or, if it names something that the robot is to be doing (moving,
waiting, organising as a master), the first time from then on that the robot does it.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

from multisrt.events import CameBack, Died, FellSilent, Joined
from multisrt.simulation.clock import Clock
from multisrt.simulation.journal import Journal
from multisrt.simulation.motions import Motions
from multisrt.simulation.robot import Robot
from multisrt.spec import Death, Fault, LateStart, Silence

Doing = Literal["any", "moving", "waiting", "master"]
"""What a death waits for; see `Death`."""


def late_starts(faults: Sequence[Fault]) -> dict[int, float]:
    """Return the times in seconds at which robots start that start late, by robot."""
    return {fault.robot: fault.time_s for fault in faults if isinstance(fault, LateStart)}


class Faults:
    """Injects the faults that the spec of a run lists.

    Parameters
    ----------
    faults : sequence of Death, Silence or LateStart
        What goes wrong.
    robots : sequence of Robot
        The team.
    motions : Motions
        The robots' motions, which a death ends.
    clock, journal
        Those of the run.
    """

    def __init__(
        self,
        faults: Sequence[Fault],
        robots: Sequence[Robot],
        motions: Motions,
        *,
        clock: Clock,
        journal: Journal,
    ) -> None:
        self._silences = [fault for fault in faults if isinstance(fault, Silence)]
        self._pending: dict[int, Death] = {}
        self._motions = motions
        self._clock = clock
        self._journal = journal
        for fault in faults:
            self._schedule(fault, robots[fault.robot])

    def join(self, robot: Robot) -> None:
        """Switch on a robot that starts late."""
        self._journal.record(Joined(time_s=self._clock.now_s, robot=robot.number))
        self.switch_on(robot)

    def switch_on(self, robot: Robot) -> None:
        """Switch on a robot; its radio may have failed already."""
        robot.state, robot.hears = "on", True
        if self._is_silent(robot):
            self._silence(robot)

    def is_doomed(self, robot: Robot) -> bool:
        """Whether a death waits for what a robot does next."""
        return robot.number in self._pending

    def on_setting_out(self, robot: Robot) -> None:
        """Let a robot that is to die moving die halfway through the motion that it has begun.

        If that ends earlier, it dies there.
        """
        death = self._pending.get(robot.number)
        motion = robot.motion
        if death is None or death.when != "moving" or motion is None:
            return

        def die() -> None:
            if robot.motion is motion:
                self.on_doing(robot, "moving")

        self._clock.later(motion.move.trajectory.duration_s / 2.0, die)

    def on_doing(self, robot: Robot, doing: Doing) -> None:
        """Let a robot die now if its death waits for what it is doing."""
        death = self._pending.get(robot.number)
        if death is None or death.when != doing or robot.state == "dead":
            return
        if doing != "moving" or robot.motion is not None:
            self._kill(robot, doing)

    # Deaths ------------------------------------------------------------------------------

    def _schedule(self, fault: Fault, robot: Robot) -> None:
        if isinstance(fault, Death):
            self._clock.later(fault.time_s, lambda: self._arm(robot, fault))
        elif isinstance(fault, Silence):
            self._clock.later(fault.time_s, lambda: self._silence(robot))
            self._clock.later(fault.time_s + fault.duration_s, lambda: self._come_back(robot))

    def _arm(self, robot: Robot, death: Death) -> None:
        self._pending[robot.number] = death
        self.on_doing(robot, "any")
        if robot.motion is not None:
            self.on_doing(robot, "moving")
        if robot.waits:
            self.on_doing(robot, "waiting")

    def _kill(self, robot: Robot, doing: Doing) -> None:
        was: Literal["moving", "waiting", "master"] = (
            "master" if doing == "master" else "moving" if robot.motion is not None else "waiting"
        )
        now_s = self._clock.now_s
        if robot.motion is not None:
            self._motions.end(robot, now_s)
        robot.state, robot.hears = "dead", False
        robot.mailbox.clear()
        place = self._motions.where(robot)
        self._record(Died(time_s=now_s, robot=robot.number, configuration=(*place,), doing=was))
        robot.poke()

    # Silences ----------------------------------------------------------------------------

    def _is_silent(self, robot: Robot) -> bool:
        return any(
            fault.time_s <= self._clock.now_s < fault.time_s + fault.duration_s
            for fault in self._silences
            if fault.robot == robot.number
        )

    def _silence(self, robot: Robot) -> None:
        if robot.state in ("on", "done") and robot.hears:
            robot.hears = False
            self._record(FellSilent(time_s=self._clock.now_s, robot=robot.number))

    def _come_back(self, robot: Robot) -> None:
        if robot.state in ("on", "done") and not robot.hears and not self._is_silent(robot):
            robot.hears = True
            self._record(CameBack(time_s=self._clock.now_s, robot=robot.number))

    def _record(self, event: Died | FellSilent | CameBack) -> None:
        # A run that is not over yet does not end before it.
        self._journal.note_time(event.time_s)
        self._journal.record(event)
