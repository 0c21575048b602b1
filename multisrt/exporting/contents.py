"""Contents of an exported run, which are the same in all formats.

All positions are in metres in the frame of the environment, angles in radians counter-clockwise
from +x.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from multisrt.events import Pose
from multisrt.exporting.grids import Cells
from multisrt.geometry.numerics.arrays import FloatArray

Colour = tuple[float, float, float, float]
"""Red, green, blue and opacity, from 0 to 1."""

State = Literal["not started", "on", "silent", "dead"]
"""State of a robot: waiting for a late start, exploring or done, without radio, dead."""


@dataclass(frozen=True, slots=True, eq=False)
class Placed:
    """Pose of a robot (x, y, heading); headings are not wrapped."""

    robot: int
    pose: Pose


@dataclass(frozen=True, slots=True, eq=False)
class Body:
    """Change of the state of a robot's body, or its first state."""

    robot: int
    state: State


@dataclass(frozen=True, slots=True, eq=False)
class Truth:
    """The true world, as cells of the grid of all maps."""

    cells: Cells


@dataclass(frozen=True, slots=True, eq=False)
class KnownMap:
    """The map of a robot: its cells, and the centres of its frontier cells, ``(n, 2)``."""

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
    """A motion that a robot begins: time (s), x, y, heading at points on it, ``(n, 4)``."""

    robot: int
    points: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class Links:
    """The working radio links: x, y of both robots of each, ``(n, 4)``."""

    lines: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class Said:
    """A decision of a robot, or an unplanned event (`is_trouble`), as text in one line."""

    robot: int
    text: str
    is_trouble: bool


@dataclass(frozen=True, slots=True, eq=False)
class Covered:
    """The shares of the explorable area that the team has covered and has seen, from 0 to 1."""

    coverage: float
    seen: float


Content = Placed | Body | Truth | KnownMap | Tree | Way | Links | Said | Covered
