"""Messages between robots that go to frontiers."""

from __future__ import annotations

from typing import ClassVar, Literal

import msgspec

from multisrt.robots.frontier.goal import Place
from multisrt.robots.knowledge import Counts, Node
from multisrt.robots.messages import Message

Phase = Literal["choosing", "driving", "idle"]
"""State of a robot: it has no goal yet, is on its way to one, or has nothing to do."""


class ChainLink(msgspec.Struct, frozen=True, kw_only=True):
    """A relay of a chain; see `multisrt.robots.frontier.chain`.

    Attributes
    ----------
    robot : int
        Number of the robot that is to stand there.
    place : (x, y)
        Where, in metres.
    """

    robot: int
    place: Place


class RobotReport(msgspec.Struct, frozen=True, kw_only=True, omit_defaults=True):
    """A robot's report of itself; a later report replaces an earlier one.

    Attributes
    ----------
    robot : int
        Number of the robot.
    said : int
        Serial number of the report among those of the robot.
    time_s : float
        When it was made.
    phase : {"choosing", "driving", "idle"}
        What the robot is doing.
    place : (x, y, heading)
        Where it is.
    goal : (x, y) or None
        Where it is going.
    remaining_m : float
        Length of the rest of its path in metres.
    path : tuple of (x, y)
        The path, from where the goal was chosen.
    footprint : str
        Its body.
    have : tuple of (robot, nodes, closings)
        How many entries of each robot's map it knows.
    aim : (x, y) or None
        `rules`: the unexplored cell for whose sake it goes to its goal.
    leader : bool
        `rules`: whether it goes first where robots meet.
    links : tuple of ChainLink or None
        Chains: the relays that the robot needs as the front, from the base station on; None if it
        is not the front.
    passes_front : bool
        Chains: whether it found nothing to do as the front, so that the next robot is the front.
    speed_m_s : float or None
        Pairs and chains: its speed; None for others.
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
    links: tuple[ChainLink, ...] | None = None
    passes_front: bool = False
    speed_m_s: float | None = None


class ReportMessage(Message, frozen=True, kw_only=True):
    """The sender's report, those of others that it passes on, and entries of its map.

    Attributes
    ----------
    reports : tuple of RobotReport
        The sender's own first.
    asks : bool
        Whether to answer with a report.
    wants_goal : bool
        Whether the sender wants a goal from its leader.
    entries : tuple of Node
        The nodes that the sender has made since its last report to all, and those of others that
        it knows beyond a gap in their numbers. There are no closings: robots that bid for
        frontiers close no arcs.
    """

    kind: ClassVar[str] = "report"

    reports: tuple[RobotReport, ...]
    asks: bool = False
    wants_goal: bool = False
    entries: tuple[Node, ...] = ()

    @property
    def have(self) -> Counts:
        """What the sender knows; see `Counts`."""
        return self.reports[0].have

    @property
    def wakes(self) -> bool:
        """Whether it is a question: these also reach a robot that moves."""
        return self.asks or self.wants_goal


class GiveWayMessage(Message, frozen=True, kw_only=True):
    """Asks a robot to leave the sender's path.

    Attributes
    ----------
    path : tuple of (x, y)
        The rest of the sender's path.
    radius_m : float
        Radius of its body in metres.
    firm : bool
        Whether the sender was asked to give way itself, and has no place to go to.
    """

    kind: ClassVar[str] = "give way"

    path: tuple[Place, ...]
    radius_m: float
    firm: bool = False

    @property
    def wakes(self) -> bool:
        """True: it also reaches a robot that moves."""
        return True


class StopMessage(Message, frozen=True, kw_only=True):
    """Informs a robot that its goal is no longer a frontier (SBX-R: stop signal).

    Attributes
    ----------
    goal : (x, y) or None
        The goal. None: whatever its goal is, as the sender knows no frontier any more that it could
        reach.
    """

    kind: ClassVar[str] = "stop"

    goal: Place | None = None

    @property
    def wakes(self) -> bool:
        """True: it also reaches a robot that moves."""
        return True


class AssignmentMessage(Message, frozen=True, kw_only=True):
    """The goal that the leader assigns to a robot (Stachniss and Burgard: central assignment).

    Attributes
    ----------
    goal : (x, y) or None
        The goal; None if the leader knows no frontier that the robot could reach.
    utility, share : float
        Utility of the goal when it was assigned, and the cost as a share of the largest one.
    """

    kind: ClassVar[str] = "assignment"

    goal: Place | None = None
    utility: float = 0.0
    share: float = 0.0

    @property
    def wakes(self) -> bool:
        """True: it also reaches a robot that moves."""
        return True


class InaccessibleMessage(Message, frozen=True, kw_only=True):
    """Lists the unexplored cells to which the sender finds no path (Álvarez: inaccessible cells).

    Attributes
    ----------
    cells : tuple of (x, y)
        Their centres.
    tried : tuple of (x, y)
        Places at the edge of the known area that it reached without result, or could not reach.
    radius_m : float
        Radius of its body in metres: no larger robot need try there.
    """

    kind: ClassVar[str] = "inaccessible"

    cells: tuple[Place, ...]
    tried: tuple[Place, ...]
    radius_m: float


class SwapMessage(Message, frozen=True, kw_only=True):
    """Takes over a robot's goal in exchange for the sender's (Álvarez: exchange of goals).

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
