"""What Multi-SRT robots say to one another."""

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
"""What a robot is at: waits for its GPR; has perceived, and then planned, with that group; moves
to its target; or has nothing to do and stands."""

Key = tuple[tuple[int, int], ...]
"""A group that steps together: for every member, which of its steps."""

Path = tuple[tuple[float, float, float, float], ...]
"""Waypoints of a motion: time from its start, x, y, heading."""


def path_of(motion: Trajectory) -> Path:
    """Return a motion as messages hold it."""
    return tuple((w.time_s, w.x, w.y, w.heading) for w in motion.waypoints)


def motion_of(path: Path) -> Trajectory:
    """Return the motion that a message holds."""
    return Trajectory(tuple(Waypoint(*waypoint) for waypoint in path))


class RobotState(msgspec.Struct, frozen=True, kw_only=True):
    """What a robot says of itself; a newer one replaces an older one.

    Attributes
    ----------
    robot : int
        Who.
    said : int
        Number of this saying among the robot's.
    step : int
        How many steps it has made.
    phase : Phase
        What it is at.
    key : Key
        The group with which it makes this step; empty before there is one.
    path : Path
        Its planned or ongoing motion; where it stands, if it plans none.
    arrival_s : float
        When the ongoing motion ends.
    node : NodeId or None
        The node that it stands at, or left last.
    frontier_m : float
        Length of its local frontier, as far as it plans to go there.
    waited : int
        How often in a row it was told to wait.
    tree : NodeId or None
        Root of the tree that it is active in; None while it has nothing to do.
    footprint : str
        Its body.
    kinematics : Kinematics
        How it moves.
    range_m : float
        How far it sees (paper: R_p).
    have : tuple of (robot, nodes, closings)
        What it knows.
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
        """Where it stands, or where its ongoing motion began."""
        return self.path[0][1:]

    @property
    def target(self) -> tuple[float, float]:
        """Where it goes: its own place, unless it moves."""
        return self.path[-1 if self.phase == "moving" else 0][1:3]


class StateMessage(Message, frozen=True, kw_only=True):
    """The sender's state, those of others that it vouches for, and entries of its map.

    Attributes
    ----------
    states : tuple of RobotState
        The sender's own first.
    ask : bool
        Whether those are to answer who may meet the sender in their next step.
    asked : tuple of int
        Who is to answer in any case.
    entries : tuple of Node or Closing
        What is new in its map.
    """

    kind: ClassVar[str] = "state"

    states: tuple[RobotState, ...]
    ask: bool = False
    asked: tuple[int, ...] = ()
    entries: tuple[Node | Closing, ...] = ()

    @property
    def wakes(self) -> bool:
        """Questions reach also a robot that moves."""
        return self.ask or bool(self.asked)


class Order(msgspec.Struct, frozen=True, kw_only=True):
    """What a master tells one robot.

    Attributes
    ----------
    order : {"keep", "wait", "new target", "give way"}
        Go where it planned, stay, or go elsewhere.
    path : Path
        The motion, for a new target or to give way.
    node : NodeId or None
        The node at its end, if there is one.
    """

    order: Literal["keep", "wait", "new target", "give way"]
    path: Path = ()
    node: NodeId | None = None


class OrdersMessage(Message, frozen=True, kw_only=True):
    """A master's word to its group (paper: the signal that ends the waiting phase).

    Attributes
    ----------
    key : Key
        The group and its step.
    orders : tuple of (robot, Order)
        What everyone shall do.
    feasible, unfeasible : tuple of int
        Robots whose planned ways conflicted with nobody's, and the rest.
    """

    kind: ClassVar[str] = "orders"

    key: Key
    orders: tuple[tuple[int, Order], ...]
    feasible: tuple[int, ...]
    unfeasible: tuple[int, ...]

    def order_for(self, robot: int) -> Order | None:
        """Give what one robot shall do; None if it is not of the group."""
        return next((order for number, order in self.orders if number == robot), None)

    @property
    def wakes(self) -> bool:
        """An idle robot may have to give way."""
        return True
