"""Targets of a robot, and the steps that lead to them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, NamedTuple

from multisrt.events import Stage
from multisrt.planners.motion.trajectory import Trajectory
from multisrt.robots.explorer import Sighting
from multisrt.robots.knowledge import NodeId
from multisrt.robots.multi_srt.roadmap import OutAndBack


@dataclass(frozen=True, slots=True)
class NewPlace:
    """A target at which there is no node yet.

    Attributes
    ----------
    x, y : float
        Its position in metres.
    stage : Stage
        How it was found, for the record.
    route : tuple of NodeId
        Nodes of the roadmap to pass, from the current one; the last becomes the new node's parent.
    roomy : bool
        Whether the body fits in any heading along the straight line from that last node.
    aim : NodeId or None
        The node whose frontier is to be seen from the place, or from somewhere beyond it.
    is_interim : bool
        Whether the robot only passes here on its way to a place that sees the frontier of `aim`.
    """

    x: float
    y: float
    stage: Stage
    route: tuple[NodeId, ...]
    roomy: bool = False
    aim: NodeId | None = None
    is_interim: bool = False


@dataclass(frozen=True, slots=True)
class KnownNode:
    """A target that is a node, at the end of a path over the roadmap.

    Attributes
    ----------
    route : tuple of NodeId
        From the current node to the target, both included.
    aim : NodeId or None
        The node whose frontier is the reason to go there.
    """

    route: tuple[NodeId, ...]
    aim: NodeId | None = None


Target = NewPlace | KnownNode


@dataclass(frozen=True, slots=True)
class Barred:
    """Says that there is no target for now, as bodies of other robots stand in the way.

    Attributes
    ----------
    bodies : dict of int to Sighting
        These bodies, by robot.
    """

    bodies: dict[int, Sighting]


@dataclass(frozen=True, slots=True, kw_only=True)
class Step:
    """The next motion towards a target: one iteration of BUILD_SRT.

    Attributes
    ----------
    out_and_back : OutAndBack
        The motion, and for a new place the motion back where it is known.
    node : NodeId or None
        The node at the end of the motion; None where there is none yet.
    rest : Target or None
        The remainder of the target after this step.
    parent : NodeId
        Parent of the node that is added at a new place.
    stage : Stage
        How a new place was found, for the record.
    roomy : bool
        Whether the body fits in any heading all along the motion.
    frontier_m : float
        Length of the local frontier that the step is made for, in metres.
    order : {"new target", "give way"} or None
        The order of a master that this step carries out; None: the robot's own plan.
    """

    out_and_back: OutAndBack
    node: NodeId | None
    rest: Target | None = None
    parent: NodeId
    stage: Stage = "draw"
    roomy: bool = False
    frontier_m: float = 0.0
    order: Literal["new target", "give way"] | None = None

    @property
    def motion(self) -> Trajectory:
        """The trajectory to follow."""
        return self.out_and_back.out

    @property
    def gives_way(self) -> bool:
        """Whether the step only clears the way of another robot."""
        return self.order == "give way"


class Interrupted(NamedTuple):
    """A step that a protective stop interrupted, of a car that cannot return.

    Attributes
    ----------
    step : Step
        The step.
    driven_s : float
        How much of its motion has been made, in seconds.
    """

    step: Step
    driven_s: float
