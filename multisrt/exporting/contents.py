"""What of a run is shown: the same things in all formats.

All positions are in metres in the frame of the environment, angles in radians counter-clockwise
from +x.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from multisrt.events import Pose
from multisrt.exporting.grids import Cells
from multisrt.geometry.numerics.arrays import FloatArray

State = Literal["not started", "on", "silent", "dead"]
"""State of a robot: switched off before a late start, exploring or done, without radio, dead."""


@dataclass(frozen=True, slots=True, eq=False)
class Placed:
    """Where a robot is: `pose` (x, y, heading); headings are not wrapped."""

    robot: int
    pose: Pose


@dataclass(frozen=True, slots=True, eq=False)
class Body:
    """The body of a robot is in another state than before, or is shown first."""

    robot: int
    state: State


@dataclass(frozen=True, slots=True, eq=False)
class Truth:
    """The true world, as cells of the grid of all maps."""

    cells: Cells


@dataclass(frozen=True, slots=True, eq=False)
class KnownMap:
    """The map of a robot: cells, and the centres of frontier cells, ``(n, 2)``."""

    robot: int
    cells: Cells
    frontier: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class Tree:
    """The nodes that a robot has made, ``(n, 2)``, and the edges to them, ``(m, 4)``."""

    robot: int
    nodes: FloatArray
    edges: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class Way:
    """A motion that a robot begins: time (s), x, y, heading of points on it, ``(n, 4)``."""

    robot: int
    points: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class Links:
    """The radio links that hold: x, y of the two robots of each, ``(n, 4)``."""

    lines: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class Said:
    """A decision of a robot, or what was not planned, in one line of words."""

    robot: int
    text: str
    is_trouble: bool


@dataclass(frozen=True, slots=True, eq=False)
class Covered:
    """The shares of the explorable area that the team has covered and has seen, from 0 to 1."""

    coverage: float
    seen: float


Content = Placed | Body | Truth | KnownMap | Tree | Way | Links | Said | Covered
