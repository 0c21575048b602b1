"""What happens in a run, as plain data: what a recording holds, line by line.

Every event says when it happened and to which robot. Lengths are metres, times seconds, angles
radians. The names of the fields are the names in the file.
"""

from __future__ import annotations

from typing import Literal

import msgspec

Point = tuple[float, float]
Segment = tuple[float, float, float, float]
"""x0, y0, x1, y1; a frontier segment has its region on the left."""

Stage = Literal["root", "draw", "approach", "complete"]
"""How the planner found a node's place."""


class Event(msgspec.Struct, frozen=True, kw_only=True, tag_field="event"):
    """Something that happened to a robot.

    Attributes
    ----------
    time_s : float
        When, in the run's own time.
    robot : int
        To whom, counted from 0.
    """

    time_s: float
    robot: int


class Motion(Event, frozen=True, kw_only=True, tag="motion"):
    """A robot moved; `time_s` is when it set out.

    Attributes
    ----------
    waypoints : tuple of (time_s, x, y, heading)
        Times from the start of the run. Between two waypoints position and heading change at
        constant rates; headings are not wrapped, so turns are signed.
    """

    waypoints: tuple[tuple[float, float, float, float], ...]


class NodeAdded(Event, frozen=True, kw_only=True, tag="node"):
    """A robot added a node to its tree.

    Attributes
    ----------
    serial : int
        The node's number among its robot's.
    parent : int or None
        Serial number of the node that the robot came from.
    configuration : (x, y, heading)
        Where the scan was taken.
    stage : {"root", "draw", "approach", "complete"}
        How the planner found the place.
    boundary : tuple of (x, y)
        The local safe region, counter-clockwise, not closed.
    tags : str
        One digit for the piece from corner i to corner i + 1: 0 obstacle, 1 range, 2 gap, 3 cut.
    """

    serial: int
    parent: int | None
    configuration: tuple[float, float, float]
    stage: Stage
    boundary: tuple[Point, ...]
    tags: str


class Decision(Event, frozen=True, kw_only=True, tag="decision"):
    """A robot chose where to go next, and what it knew.

    Attributes
    ----------
    node : int
        Serial number of the node that it stood at.
    frontier_m : float
        Length of the local frontier there.
    choice : str
        `draw`, `approach`, `complete`, `parent`, `nearest_open`, `home` or `end`.
    target : (x, y) or None
        The place chosen.
    draws : int
        How many candidates were drawn.
    refused : dict
        Why candidates were refused, with how often: `no room`, `near a node`, `in another region`.
    """

    node: int
    frontier_m: float
    choice: Literal["draw", "approach", "complete", "parent", "nearest_open", "home", "end"]
    target: Point | None
    draws: int = 0
    refused: dict[str, int] = {}


class ArcClosed(Event, frozen=True, kw_only=True, tag="arc_closed"):
    """A robot gave up a frontier arc that no place it can reach would open.

    Attributes
    ----------
    node : int
        Serial number of the arc's node.
    reason : str
        `too narrow`: the body fits nowhere from which the arc can be seen. `not reachable`: it
        would fit, but no known way leads there. `seen from near`: the robot has looked from
        every such place.
    arc : tuple of (x0, y0, x1, y1)
        The arc's segments.
    """

    node: int
    reason: Literal["too narrow", "not reachable", "seen from near"]
    arc: tuple[Segment, ...]


class MapComplete(Event, frozen=True, kw_only=True, tag="map_complete"):
    """No frontier is left in a robot's map; all that remains is the way home."""


class Collision(Event, frozen=True, kw_only=True, tag="collision"):
    """A body touched an obstacle: a defect, which ends the run.

    Attributes
    ----------
    configuration : (x, y, heading)
        Where the motion that touched began.
    account : str
        What was being done.
    """

    configuration: tuple[float, float, float]
    account: str


class Ended(Event, frozen=True, kw_only=True, tag="ended"):
    """A robot is done.

    Attributes
    ----------
    reason : str
        Why it ended, in words.
    complete : bool
        Whether no frontier was left that it knew a way to open.
    frontier : tuple of (x0, y0, x1, y1)
        The frontier segments that it left open.
    """

    reason: str
    complete: bool
    frontier: tuple[Segment, ...]


AnyEvent = Motion | NodeAdded | Decision | ArcClosed | MapComplete | Collision | Ended
