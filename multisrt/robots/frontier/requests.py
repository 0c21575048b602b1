"""Requests of the other robots of the team to this one."""

from __future__ import annotations

from dataclasses import dataclass

from multisrt.robots.frontier.messages import AssignmentMessage, GiveWayMessage


@dataclass(slots=True)
class Requests:
    """Requests that were heard and are not yet met.

    Attributes
    ----------
    give_way : GiveWayMessage or None
        The last request to give way.
    stop : bool
        Whether a stop signal came for the present goal.
    goal : bool
        Whether another robot asks this one, as the leader, for a goal.
    assignment : AssignmentMessage or None
        The leader's last assignment.

    Examples
    --------
    >>> requests = Requests()
    >>> requests.any_pending
    False
    >>> requests.goal = True
    >>> requests.any_pending, requests.a_choice_is_due
    (True, True)
    """

    give_way: GiveWayMessage | None = None
    stop: bool = False
    goal: bool = False
    assignment: AssignmentMessage | None = None

    @property
    def a_choice_is_due(self) -> bool:
        """Whether the robot is to choose a goal now: for others, or as its leader said."""
        return self.goal or self.assignment is not None

    @property
    def any_pending(self) -> bool:
        """Whether there is a request for which a robot stops driving."""
        return self.give_way is not None or self.stop or self.a_choice_is_due
