"""Space that robots may know to be free: sensed by themselves, or told of in messages."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from multisrt.geometry.regions.scan import ExactScan, Scan
from multisrt.robots.messages import Message

TOLERANCE_M = 0.005
"""Distance by which a body may reach beyond what was sensed: chords stand for arcs in both."""


class KnownSpace:
    """Space that the robots of one run may know to be free.

    A message may contain all that its sender knew when it sent it.

    Examples
    --------
    >>> from multisrt.robots.messages import Message
    >>> class Hello(Message, frozen=True):
    ...     pass
    >>> known, hello = KnownSpace(), Hello(sender=0)
    >>> known.add(0, shapely.box(0.0, 0.0, 2.0, 2.0))
    >>> known.unknown_part(1, shapely.box(1.0, 0.0, 3.0, 1.0), pad_m=0.0).area > 1.9
    True
    >>> known.tell(0, hello)
    >>> known.hear(1, [hello])
    >>> round(known.unknown_part(1, shapely.box(1.0, 0.0, 3.0, 1.0), pad_m=0.0).area, 1)
    1.0
    """

    def __init__(self) -> None:
        self._regions: list[BaseGeometry] = []
        # The numbers of regions that a robot knows, or a message may contain, as bits.
        self._of_robots: dict[int, int] = {}
        self._of_messages: dict[int, tuple[Message, int]] = {}

    def add(self, robot: int, region: BaseGeometry) -> None:
        """Note that a robot knows a region.

        Parameters
        ----------
        robot : int
            The robot.
        region : geometry
            The region, in metres.
        """
        self._of_robots[robot] = self._of(robot) | 1 << len(self._regions)
        self._regions.append(region)

    def tell(self, robot: int, message: Message) -> None:
        """Note that a robot sends a message."""
        _, before = self._of_messages.get(id(message), (message, 0))
        self._of_messages[id(message)] = message, before | self._of(robot)

    def hear(self, robot: int, messages: Iterable[Message]) -> None:
        """Note that a robot is sent messages."""
        for message in messages:
            _, told = self._of_messages.get(id(message), (message, 0))
            self._of_robots[robot] = self._of(robot) | told

    def unknown_part(self, robot: int, shape: BaseGeometry, pad_m: float) -> BaseGeometry:
        """Return the part of a shape that a robot cannot know to be free.

        Parameters
        ----------
        robot : int
            The robot.
        shape : geometry
            The shape, in metres.
        pad_m : float
            Distance in metres by which the shape is to be widened.

        Returns
        -------
        geometry
            The part, without what lies within `TOLERANCE_M` of the outline; perhaps empty.
        """
        rest: BaseGeometry = shape.buffer(pad_m - TOLERANCE_M)
        known = self._of(robot)
        for number in range(len(self._regions) - 1, -1, -1):
            if rest.is_empty:
                return rest
            if known >> number & 1 and shapely.intersects(self._regions[number], rest):
                rest = rest.difference(self._regions[number])
        # Slits between adjacent regions come from rounding.
        return shapely.Polygon() if rest.buffer(-0.5 * TOLERANCE_M).is_empty else rest

    def _of(self, robot: int) -> int:
        return self._of_robots.get(robot, 0)


def seen_in(scan: Scan) -> BaseGeometry:
    """Return the region that a scan shows to be free, in metres.

    For a laser it is the polygon of the ends of its beams.
    """
    if isinstance(scan, ExactScan):
        polygon = shapely.Polygon(scan.boundary)
    else:
        reach = np.where(np.isfinite(scan.ranges), scan.ranges, scan.range_m)
        angle = 2.0 * np.pi * np.arange(len(reach)) / len(reach)
        x, y, _ = scan.configuration
        ends = np.column_stack([x + reach * np.cos(angle), y + reach * np.sin(angle)])
        polygon = shapely.Polygon(ends)
    return polygon if polygon.is_valid else shapely.make_valid(polygon)
