"""Messages between Multi-SRT robots."""

from __future__ import annotations

from typing import ClassVar, Literal

import msgspec

from multisrt.planners.motion.kinematics import Kinematics
from multisrt.planners.motion.trajectory import Trajectory, Waypoint
from multisrt.robots.knowledge import Closing, Counts, EntriesMessage, Node, NodeId, WantMessage
from multisrt.robots.messages import Message

__all__ = [
    "EntriesMessage",
    "Key",
    "NoPlaceMessage",
    "Order",
    "OrdersMessage",
    "Path",
    "Phase",
    "RobotState",
    "StateMessage",
    "WantMessage",
    "motion_of",
    "path_of",
]

Phase = Literal["waiting", "perceived", "planned", "moving", "idle"]
"""Phase of a step: waits for the GPR; has perceived, and then planned, with that group; moves to
the target. Idle: stands and has nothing to do."""

Key = tuple[tuple[int, int], ...]
"""Name of a group that steps together: (robot, number of its step) of every member, by robot."""

Path = tuple[tuple[float, float, float, float], ...]
"""Waypoints of a motion: time from its start, x, y, heading; in seconds, metres and radians."""


def path_of(motion: Trajectory) -> Path:
    """Return a motion as messages hold it."""
    return tuple((w.time_s, w.x, w.y, w.heading) for w in motion.waypoints)


def motion_of(path: Path) -> Trajectory:
    """Return the motion that a message holds."""
    return Trajectory(tuple(Waypoint(*waypoint) for waypoint in path))


class RobotState(msgspec.Struct, frozen=True, kw_only=True):
    """A robot's report of itself; a newer state replaces an older one.

    Attributes
    ----------
    robot : int
        Its number.
    said : int
        Number of this state among all that it has reported: the larger is the newer.
    step : int
        Number of steps that it has made.
    phase : Phase
        Phase of its present step.
    key : Key
        The group with which it makes this step; empty before there is one.
    path : Path
        Its planned or ongoing motion; a single waypoint where it stands.
    arrival_s : float
        When the ongoing motion ends.
    node : NodeId or None
        The node at which it stands, or that it left last.
    frontier_m : float
        Length of the local frontier that it goes for, in metres; 0 if it goes elsewhere.
    waited : int
        How many times in a row it had to wait.
    tree : NodeId or None
        Root of the tree in which it is active; None while it is in none.
    footprint : str
        Its body.
    kinematics : Kinematics
        How it moves.
    range_m : float
        Its sensing range in metres (paper: R_p).
    have : tuple of (robot, nodes, closings)
        How many nodes and closings of every robot it knows.
    """

    robot: int
    said: int
    step: int
    phase: Phase
    key: Key
    path: Path
    arrival_s: float
    node: NodeId | None
    frontier_m: float
    waited: int
    tree: NodeId | None
    footprint: str
    kinematics: Kinematics
    range_m: float
    have: Counts

    @property
    def place(self) -> tuple[float, float, float]:
        """Its configuration, or that at the beginning of its ongoing motion."""
        return self.path[0][1:]

    @property
    def target(self) -> tuple[float, float]:
        """Position of its target: the end of its motion, or its own place while it stands."""
        return self.path[-1 if self.phase == "moving" else 0][1:3]


class StateMessage(Message, frozen=True, kw_only=True):
    """The sender's state, states of others that it passes on, and entries of its map.

    Attributes
    ----------
    states : tuple of RobotState
        The sender's own first.
    ask : bool
        Whether robots that may meet the sender in their next step are to answer.
    asked : tuple of int
        Robots that are to answer in any case.
    entries : tuple of Node or Closing
        Its own entries that it has not sent to all yet, and those of others that it knows beyond
        a gap in their numbers.
    """

    kind: ClassVar[str] = "state"

    states: tuple[RobotState, ...]
    ask: bool = False
    asked: tuple[int, ...] = ()
    entries: tuple[Node | Closing, ...] = ()

    @property
    def have(self) -> Counts:
        """What the sender knows; see `Counts`."""
        return self.states[0].have

    @property
    def wakes(self) -> bool:
        """Whether it is a question: those are answered during a motion, too."""
        return self.ask or bool(self.asked)


class NoPlaceMessage(Message, frozen=True, kw_only=True):
    """Says that the planner found no place at a node with a local frontier.

    Attributes
    ----------
    node : NodeId
        The node.
    """

    kind: ClassVar[str] = "no place"

    node: NodeId


class Order(msgspec.Struct, frozen=True, kw_only=True):
    """The order of a master to one robot in this step.

    Attributes
    ----------
    order : {"keep", "wait", "new target", "give way"}
        Make the planned motion, stay, go elsewhere, or clear another robot's way.
    path : Path
        The motion, for a new target or to give way.
    node : NodeId or None
        The node at the end of that motion, if there is one.
    """

    order: Literal["keep", "wait", "new target", "give way"]
    path: Path = ()
    node: NodeId | None = None


class OrdersMessage(Message, frozen=True, kw_only=True):
    """The orders of a master to its group (paper: the signal that ends the waiting phase).

    Attributes
    ----------
    key : Key
        The group, and its step.
    orders : tuple of (robot, Order)
        The order for every robot.
    feasible, unfeasible : tuple of int
        Robots whose planned motions conflicted with no other, and the rest.
    """

    kind: ClassVar[str] = "orders"

    key: Key
    orders: tuple[tuple[int, Order], ...]
    feasible: tuple[int, ...]
    unfeasible: tuple[int, ...]

    def order_for(self, robot: int) -> Order | None:
        """Return the order for a robot; None if it is not of the group."""
        return next((order for number, order in self.orders if number == robot), None)

    @property
    def wakes(self) -> bool:
        """Whether it is delivered during a motion: it is."""
        return True
