"""What robots that bid for frontiers say to one another."""

from __future__ import annotations

from typing import ClassVar, Literal

import msgspec

from multisrt.robots.frontier.goal import Place
from multisrt.robots.knowledge import Closing, Counts, Node
from multisrt.robots.messages import Message

Phase = Literal["choosing", "driving", "idle"]
"""What a robot is at: it has no goal yet, is on its way to one, or has nothing to do."""


class RobotReport(msgspec.Struct, frozen=True, kw_only=True, omit_defaults=True):
    """What a robot says of itself; a newer one replaces an older one.

    Attributes
    ----------
    robot : int
        Who.
    said : int
        Number of this saying among the robot's.
    time_s : float
        When it was said.
    phase : Phase
        What it is at.
    place : (x, y, heading)
        Where it is.
    goal : (x, y) or None
        Where it goes.
    remaining_m : float
        How far it still is to there.
    path : tuple of (x, y)
        The way there.
    footprint : str
        Its body.
    have : tuple of (robot, nodes, closings)
        What it knows.
    aim : (x, y) or None
        `rules`: the unexplored cell for whose sake it goes there.
    leader : bool
        `rules`: whether it goes first where robots meet.
    """

    robot: int
    said: int
    time_s: float
    phase: Phase
    place: tuple[float, float, float]
    goal: Place | None
    remaining_m: float
    path: tuple[Place, ...]
    footprint: str
    have: Counts
    aim: Place | None = None
    leader: bool = False


class ReportMessage(Message, frozen=True, kw_only=True):
    """The sender's report, those of others that it passes on, and entries of its map.

    Attributes
    ----------
    reports : tuple of RobotReport
        The sender's own first.
    asks : bool
        Whether whoever hears it is to answer.
    wants_goal : bool
        Whether it wants a goal from its leader.
    entries : tuple of Node
        What is new in its map.
    """

    kind: ClassVar[str] = "report"

    reports: tuple[RobotReport, ...]
    asks: bool = False
    wants_goal: bool = False
    entries: tuple[Node | Closing, ...] = ()

    @property
    def wakes(self) -> bool:
        """Questions reach also a robot that moves."""
        return self.asks or self.wants_goal


class GiveWayMessage(Message, frozen=True, kw_only=True):
    """Asks a robot that stands in the sender's way to leave it.

    Attributes
    ----------
    path : tuple of (x, y)
        Where the sender wants to go along.
    radius_m : float
        Radius of its body.
    firm : bool
        Whether the sender was asked itself, and has no place to go to.
    """

    kind: ClassVar[str] = "give way"

    path: tuple[Place, ...]
    radius_m: float
    firm: bool = False

    @property
    def wakes(self) -> bool:
        """It reaches also a robot that moves."""
        return True


class StopMessage(Message, frozen=True, kw_only=True):
    """Tells a robot that its goal is a frontier no more (SBX-R: stop signal).

    Attributes
    ----------
    goal : (x, y)
        The goal that is meant.
    """

    kind: ClassVar[str] = "stop"

    goal: Place

    @property
    def wakes(self) -> bool:
        """It reaches also a robot that moves."""
        return True


class AssignmentMessage(Message, frozen=True, kw_only=True):
    """The leader's word on who goes where (Stachniss and Burgard: central assignment).

    Attributes
    ----------
    goals : tuple of (robot, (x, y) or None)
        Everybody's goal.
    """

    kind: ClassVar[str] = "assignment"

    goals: tuple[tuple[int, Place | None], ...]

    @property
    def wakes(self) -> bool:
        """It reaches also a robot that moves."""
        return True


class InaccessibleMessage(Message, frozen=True, kw_only=True):
    """Says to which unexplored cells the sender finds no way (Álvarez: inaccessible cells).

    Attributes
    ----------
    cells : tuple of (x, y)
        Their centres.
    tried : tuple of (x, y)
        Where it was at the edge of what is known, or could not get to, and learnt nothing.
    radius_m : float
        Radius of its body: no larger one need try there.
    """

    kind: ClassVar[str] = "inaccessible"

    cells: tuple[Place, ...]
    tried: tuple[Place, ...]
    radius_m: float


class SwapMessage(Message, frozen=True, kw_only=True):
    """The sender takes a robot's goal and gives it its own (Álvarez: exchange of goals).

    Attributes
    ----------
    taken : (x, y)
        The goal that the sender takes.
    given : (x, y)
        The goal that it gives.
    """

    kind: ClassVar[str] = "swap"

    taken: Place
    given: Place
