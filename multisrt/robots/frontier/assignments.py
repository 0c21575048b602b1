"""The goals that a robot assigns to others as their leader."""

from __future__ import annotations

from multisrt.robots.frontier.goal import Place
from multisrt.robots.frontier.messages import AssignmentMessage, RobotReport


class Assignments:
    """The goals that one robot has assigned to others lately.

    Parameters
    ----------
    number : int
        Number of the robot that leads.
    keep_s : float
        For how long an assignment counts of which its robot has reported nothing, in seconds.

    Examples
    --------
    >>> assignments = Assignments(0, keep_s=0.5)
    >>> assignments.add(1, AssignmentMessage(sender=0, goal=(2.0, 3.0)), 10.0)
    >>> assignments.waits_for(1, 10.0)
    True
    >>> assignments.send(1, 10.0).goal
    (2.0, 3.0)
    >>> assignments.waits_for(1, 10.0), assignments.goal_of(1, 10.2), assignments.goal_of(1, 11.0)
    (False, (2.0, 3.0), None)
    """

    def __init__(self, number: int, keep_s: float) -> None:
        self._number = number
        self._keep_s = keep_s
        self._made: dict[int, tuple[float, AssignmentMessage]] = {}
        self._sent: dict[int, AssignmentMessage] = {}

    def add(self, robot: int, assignment: AssignmentMessage, now_s: float) -> None:
        """Keep an assignment until its robot asks for it."""
        self._made[robot] = now_s, assignment
        self._sent.pop(robot, None)

    def waits_for(self, robot: int, now_s: float) -> bool:
        """Whether there is a recent assignment for a robot that it has not got yet."""
        return robot not in self._sent and self._recent(robot, now_s) is not None

    def send(self, robot: int, now_s: float) -> AssignmentMessage:
        """Return the assignment for a robot, which has got it then; one of no goal without any."""
        assignment = self._recent(robot, now_s) or AssignmentMessage(sender=self._number)
        self._sent[robot] = assignment
        return assignment

    def goal_of(self, robot: int, now_s: float, report: RobotReport | None = None) -> Place | None:
        """Return the goal that a robot reports, else the one assigned to it lately, if any."""
        if report is not None and report.goal is not None:
            return report.goal
        assignment = self._recent(robot, now_s)
        return None if assignment is None else assignment.goal

    def _recent(self, robot: int, now_s: float) -> AssignmentMessage | None:
        made = self._made.get(robot)
        return made[1] if made is not None and now_s <= made[0] + self._keep_s else None
