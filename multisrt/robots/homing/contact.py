"""Places from which the base station is certain to hear a robot."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import shapely
from shapely import LineString

from multisrt.geometry.numerics.arrays import BoolArray, FloatArray
from multisrt.geometry.numerics.distances import inside
from multisrt.robots.knowledge import Entries, Node, NodeId
from multisrt.robots.robot_self import RadioSelf, RobotSelf

Place = tuple[float, float]

RANGE_MARGIN_M = 0.05
"""Margin in metres subtracted from the radio range.

Robots stop slightly off their goals.
"""


def is_certainly_in_range(base: Place, radio: RadioSelf, place: Sequence[float]) -> bool:
    """Return whether the base station is in radio range of a place, were there no walls."""
    return math.dist(place[:2], base) <= radio.range_m - RANGE_MARGIN_M


def is_certain_contact(
    base: Place, radio: RadioSelf, configuration: Sequence[float], region: FloatArray
) -> bool:
    """Return whether the base station is certain to hear a robot at a node.

    Parameters
    ----------
    base : (x, y)
        Where the base station is, in metres.
    radio : RadioSelf
        The radio of the robot.
    configuration : (x, y, heading)
        Where the node is (m, rad).
    region : (n, 2) array
        Corners of its local safe region, in metres.
    """
    if not is_certainly_in_range(base, radio, configuration):
        return False
    return not radio.walls_matter or inside(region, *base)


class ContactPlaces:
    """The nodes from which the base station is certain to hear a robot.

    A node counts if the base station is in radio range of it; and, where walls break or weaken
    links, if it lies in the local safe region of the node, so that nothing is in between. There may
    be other places from which it hears the robot.

    Parameters
    ----------
    me : RobotSelf
        What the robot knows of itself; it has a base station.

    Attributes
    ----------
    base : (x, y)
        Where the base station is, in metres.
    nodes : dict of NodeId to Node
        The nodes, in the order in which they became known.

    Examples
    --------
    >>> import numpy as np
    >>> from multisrt.geometry.bodies.footprint import Footprint
    >>> from multisrt.geometry.configuration import Configuration
    >>> from multisrt.planners.motion.kinematics import Differential
    >>> from multisrt.robots.robot_self import RadioSelf
    >>> me = RobotSelf(
    ...     robot=0,
    ...     start=Configuration(1.0, 1.0),
    ...     footprint=Footprint.disc(0.25),
    ...     kinematics=Differential(),
    ...     range_m=4.0,
    ...     rng=np.random.default_rng(0),
    ...     base=(0.0, 0.0),
    ...     radio=RadioSelf(range_m=3.0),
    ... )
    >>> contact = ContactPlaces(me)
    >>> contact.certainly_in_range(0.0, 2.9), contact.certainly_in_range(2.5, 2.5)
    (True, False)
    """

    def __init__(self, me: RobotSelf) -> None:
        assert me.base is not None
        self.base: Place = me.base
        self.nodes: dict[NodeId, Node] = {}
        self._radio = me.radio
        self._looked_at = 0

    def update(self, entries: Entries) -> bool:
        """Take the new nodes into account; return whether there are more of them."""
        nodes = entries.nodes
        if len(nodes) == self._looked_at:
            return False
        before = len(self.nodes)
        for node in list(nodes.values())[self._looked_at :]:
            if is_certain_contact(self.base, self._radio, node.configuration, node.region.boundary):
                self.nodes[node.id] = node
        self._looked_at = len(nodes)
        return len(self.nodes) > before

    def is_certain_beside(self, node: Node, place: Place) -> bool:
        """Return whether it is certain to hear a robot at a place beside one of `nodes`."""
        if not is_certainly_in_range(self.base, self._radio, place):
            return False
        return not self._radio.walls_matter or bool(
            shapely.covers(shapely.Polygon(node.region.boundary), LineString([place, self.base]))
        )

    def certainly_in_range(self, x: float, y: float) -> bool:
        """Return whether distance alone makes contact certain at a place.

        Always False where walls affect the radio.
        """
        return bool(self.certainly_in_range_at(np.array([[x, y]]))[0])

    def certainly_in_range_at(self, places: FloatArray) -> BoolArray:
        """Return at which places, ``(m, 2)``, distance alone makes contact certain.

        Always False where walls affect the radio.
        """
        if self._radio.walls_matter:
            return np.zeros(len(places), np.bool_)
        range_m = self._radio.range_m - RANGE_MARGIN_M
        near: BoolArray = np.hypot(*(places - self.base).T) <= range_m
        return near
