"""One robot's knowledge of the other robots of its team, from their reports."""

from __future__ import annotations

import math

from multisrt.robots.frontier.messages import RobotReport


class Teammates:
    """The latest reports of the other robots.

    Parameters
    ----------
    number : int
        Number of the robot that keeps the reports.
    lost_after_s : float
        A robot not heard from for this long is presumed lost, in seconds.
    relay_for_s : float
        Reports of robots heard from within this time, in seconds, are passed on.

    Attributes
    ----------
    reports : dict of int to RobotReport
        The latest report of each robot.
    heard_s : dict of int to float
        When each robot was last heard from.
    """

    def __init__(self, number: int, lost_after_s: float, relay_for_s: float) -> None:
        self._number = number
        self._lost_after_s = lost_after_s
        self._relay_for_s = relay_for_s
        self.reports: dict[int, RobotReport] = {}
        self.heard_s: dict[int, float] = {}
        self._deaf_since_s: dict[int, float] = {}
        self._lost_since_s: dict[int, float] = {}

    def present(self, now_s: float) -> list[RobotReport]:
        """Return the reports of the robots to take into account, by number.

        Robots that have nothing to do are left out, and robots that are presumed lost: those not
        heard from for `lost_after_s`, and those noted as lost and not heard from since.
        """
        return self._heard_within(self._lost_after_s, now_s)

    def worth_relaying(self, now_s: float) -> list[RobotReport]:
        """Return the reports to pass on to others, by number."""
        return self._heard_within(min(self._relay_for_s, self._lost_after_s), now_s)

    def _heard_within(self, seconds: float, now_s: float) -> list[RobotReport]:
        return [
            report
            for number, report in sorted(self.reports.items())
            if report.phase != "idle"
            and self.heard_s[number] >= now_s - seconds
            and not self.is_lost(number)
        ]

    def take(self, report: RobotReport) -> None:
        """Keep a report of another robot, unless a later one is known."""
        known = self.reports.get(report.robot)
        if report.robot != self._number and (known is None or report.said >= known.said):
            self.reports[report.robot] = report
            self.heard_s[report.robot] = max(self.last_heard_s(report.robot), report.time_s)

    def last_heard_s(self, robot: int) -> float:
        """Return when a robot was last heard from; ``-inf`` if never."""
        return self.heard_s.get(robot, -math.inf)

    def note_lost(self, robot: int, now_s: float) -> None:
        """Presume a robot lost until it is heard from."""
        self._lost_since_s[robot] = now_s

    def is_lost(self, robot: int) -> bool:
        """Return whether a robot was noted as lost, and has not been heard from since."""
        since_s = self._lost_since_s.get(robot)
        return since_s is not None and self.last_heard_s(robot) <= since_s

    def note_deaf(self, robot: int, now_s: float) -> None:
        """Record that a robot did not answer."""
        self._deaf_since_s[robot] = now_s

    def is_deaf(self, robot: int) -> bool:
        """Return whether a robot has not been heard from since it did not answer."""
        since_s = self._deaf_since_s.get(robot)
        return since_s is not None and self.last_heard_s(robot) <= since_s
