"""What all events have in common, and the words of which they are made."""

from __future__ import annotations

import msgspec

Point = tuple[float, float]

Segment = tuple[float, float, float, float]
"""x0, y0, x1, y1; a frontier segment has its region on the left, seen from its first end."""

Pose = tuple[float, float, float]
"""x, y, heading."""

NodeName = tuple[int, int]
"""The robot that made a node, and the serial number of the node among those of that robot."""


# Events hold plain data without cycles, which the garbage collector need not track.
class Event(msgspec.Struct, frozen=True, kw_only=True, gc=False, tag_field="event"):
    """Something that happened to a robot.

    Attributes
    ----------
    time_s : float
        When it happened.
    robot : int
        The robot.
    """

    time_s: float
    robot: int
