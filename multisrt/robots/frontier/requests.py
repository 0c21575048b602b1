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
    meet : bool
        Whether this robot's partner is here to take its news; see `multisrt.robots.homing.pairs`.
    link : bool
        Whether the front of the chain called this robot, let it go, or has nothing to do any more.
    assignment : AssignmentMessage or None
        The leader's answer to a robot that asked it for a goal.

    Examples
    --------
    >>> requests = Requests()
    >>> requests.any_pending
    False
    >>> requests.stop = True
    >>> requests.any_pending
    True
    """

    give_way: GiveWayMessage | None = None
    stop: bool = False
    meet: bool = False
    link: bool = False
    assignment: AssignmentMessage | None = None

    @property
    def any_pending(self) -> bool:
        """Whether there is a request for which a robot stops driving."""
        return self.give_way is not None or self.stop or self.meet or self.link
