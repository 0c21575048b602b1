"""Content of a map: a true world, or what robots knew of it at some time."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
import shapely
from shapely import MultiLineString
from shapely.geometry.base import BaseGeometry

from multisrt.environments.environment import Environment
from multisrt.exporting.grids import FREE_CELL, Cells
from multisrt.exporting.options import require_cell_width
from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.numerics.arrays import FloatArray
from multisrt.geometry.regions.boundary import OBSTACLE
from multisrt.geometry.regions.safe_region import LocalSafeRegion

SURFACE_M = 1e-4
"""Distance up to which an edge of known space counts as lying on a surface, in metres."""

MIN_LENGTH_M, MAX_LENGTH_M = 1e-2, 1e3
"""Bounds of the height and thickness of walls, in metres."""


@dataclass(frozen=True, slots=True, kw_only=True)
class MapOptions:
    """Options for writing maps; each format uses those that it needs.

    Attributes
    ----------
    cell_m : float or None
        Width of a cell of a grid, in metres. By default 0.05 m, doubled until a map has at most 16
        million cells.
    height_m : float
        Height of the walls of solids, in metres.
    thickness_m : float
        Thickness in metres of walls of which only one side is known, such as the outline of a
        world.

    Raises
    ------
    InvalidInputError
        If a number is out of range.

    Examples
    --------
    >>> MapOptions(cell_m=0.1).height_m
    1.0
    """

    cell_m: float | None = None
    height_m: float = 1.0
    thickness_m: float = 0.1

    def __post_init__(self) -> None:
        # Written so that NaN is refused, too.
        require_cell_width(self.cell_m)
        for what, length_m in (("height", self.height_m), ("thickness", self.thickness_m)):
            if not MIN_LENGTH_M <= length_m <= MAX_LENGTH_M:
                raise InvalidInputError(
                    f"the {what} of walls must be {MIN_LENGTH_M:g} to {MAX_LENGTH_M:g} m, "
                    f"not {length_m:g}"
                )


class Raster(NamedTuple):
    """A map as cells.

    Attributes
    ----------
    cells : (rows, columns) array of int8
        Free, occupied or unknown, see `multisrt.exporting.grids.Cells`; row 0 is the lowest y.
    x0, y0 : float
        Lower left corner of the first cell, in metres.
    cell_m : float
        Width of a cell, in metres.
    """

    cells: Cells
    x0: float
    y0: float
    cell_m: float

    @property
    def free_m2(self) -> float:
        """Area of the free cells, in square metres."""
        return int(np.count_nonzero(self.cells == FREE_CELL)) * self.cell_m**2


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Line:
    """A line that is shown above the floor of solids.

    Attributes
    ----------
    layer : {"edges", "paths"}
        Edges of a tree, or the path of a robot.
    robot : int
        Number of the robot, from 0.
    pieces : MultiLineString
        Its course, in metres.
    """

    layer: str
    robot: int
    pieces: MultiLineString


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class MapContent:
    """Content of a map.

    Attributes
    ----------
    environment : Environment
        The known free space, with its name and the starts in it.
    regions : tuple of LocalSafeRegion or None
        The known regions, of which free space is the union. None for the true world, of which
        nothing is unknown.
    lines : tuple of Line
        Trees and paths, for solids.
    """

    environment: Environment
    regions: tuple[LocalSafeRegion, ...] | None = None
    lines: tuple[Line, ...] = field(default=())

    def surfaces(self) -> BaseGeometry:
        """Return the edges of known free space that are observed surfaces, as lines in metres."""
        assert self.regions is not None
        seen: list[FloatArray] = []
        for region in self.regions:
            corners = region.boundary
            ends = np.stack([corners, np.roll(corners, -1, axis=0)], axis=1)
            seen.append(ends[region.tags == OBSTACLE])
        edges = self.environment.edges
        middles = shapely.points(0.5 * (edges[:, :2] + edges[:, 2:]))
        tree = shapely.STRtree(list(map(shapely.LineString, np.concatenate(seen))))
        near, _ = tree.query(middles, predicate="dwithin", distance=SURFACE_M)
        lines = shapely.linestrings(edges[np.unique(near)].reshape(-1, 2, 2))
        return shapely.line_merge(MultiLineString(list(lines)))
