"""Nodes and closings of a robot's map, made again from a recording."""

from __future__ import annotations

import numpy as np

from multisrt.events import ArcClosed, ClosingReason, NodeAdded
from multisrt.geometry.configuration import Configuration
from multisrt.geometry.regions.safe_region import LocalSafeRegion
from multisrt.robots.knowledge import Closing, ClosingId, Node, NodeId


def recorded_node(event: NodeAdded, range_m: float) -> Node:
    """Return the node that a robot added.

    Parameters
    ----------
    event : NodeAdded
        What was recorded.
    range_m : float
        Range of the robot's range finder in metres.
    """
    configuration = Configuration(*event.configuration)
    region = LocalSafeRegion(
        x=configuration.x,
        y=configuration.y,
        range_m=range_m,
        boundary=event.region(),
        tags=np.asarray([int(tag) for tag in event.tags], np.int8),
    )
    return Node(
        id=NodeId(event.robot, event.serial),
        configuration=configuration,
        region=region,
        parent=None if event.parent is None else NodeId(*event.parent),
        time_s=event.time_s,
    )


def recorded_closing(
    event: ArcClosed, reason: ClosingReason, number: int, width_m: float
) -> Closing:
    """Return the closing of an arc that a robot gave up for good.

    Parameters
    ----------
    event : ArcClosed
        What was recorded.
    reason : str
        The reason of the event.
    number : int
        A number for the closing, of which no other one of the robot has the same.
    width_m : float
        Width of the robot's body in metres.
    """
    return Closing(
        id=ClosingId(event.robot, number),
        node=NodeId(*event.node),
        arc=np.asarray(event.arc, np.float64).reshape(-1, 4),
        reason=reason,
        width_m=width_m,
    )
