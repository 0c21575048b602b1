"""Where a robot is, at what time, and which tree it extends."""

from __future__ import annotations

from dataclasses import dataclass

from multisrt.geometry.configuration import Configuration
from multisrt.robots.knowledge import NodeId


@dataclass(slots=True, kw_only=True)
class Whereabouts:
    """The part of a robot's state that all its other parts read.

    Attributes
    ----------
    q_act : Configuration
        Current configuration; where the last motion ended (paper: q_act).
    time_s : float
        Current time, as far as the robot knows it.
    here : NodeId or None
        Node at the current configuration; None where none has been added yet.
    tree : NodeId or None
        Root of the tree that the robot extends; None while it is active in no tree.
    """

    q_act: Configuration
    time_s: float
    here: NodeId | None = None
    tree: NodeId | None = None

    @property
    def node(self) -> NodeId:
        """The node at the current configuration, where there must be one."""
        if self.here is None:
            raise AssertionError(f"there is no node at {self.q_act[:2]} yet")
        return self.here
