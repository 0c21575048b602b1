"""How much of a world there is to explore: the truth that coverage is measured against.

A robot can see a point if the point is in sight, within range, of a place that its body can
get to from its start. What cannot be seen so, the inside of a closed room or a crack, is no
part of the task.
"""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
import shapely
from shapely import Polygon

from multisrt.environments.environment import Environment
from multisrt.geometry.configuration import Configuration
from multisrt.geometry.distance_field import distance_field
from multisrt.geometry.edge_index import EdgeIndex
from multisrt.geometry.footprint import Footprint
from multisrt.geometry.kernel import BoolArray
from multisrt.geometry.raster import Raster, paint_polygon
from multisrt.geometry.visibility import visibility_polygon

CELL_M = 0.1
"""Width of a cell in which areas are counted, where the world is not too large for it."""

MOST_CELLS = 16_000_000
"""A larger world is counted in larger cells."""


class Explorable:
    """What one robot could see of a world from all places that it can get to.

    Attributes
    ----------
    raster : Raster
        Its window holds the world; cells whose centre can be seen are marked.
    area_m2 : float
        Area of the marked cells.
    reachable_m2 : float
        Area of the places that the body's reference point can get to.
    """

    def __init__(
        self, environment: Environment, footprint: Footprint, range_m: float, start: Configuration
    ) -> None:
        component = environment.component(start.x, start.y)
        cell = cell_width(environment)
        self.raster = Raster(cell, environment.bounds)
        reachable = reachable_area(component, footprint, start)
        self.reachable_m2 = float(reachable.area)
        _paint_all(self.raster, reachable)
        # What lies outside the reachable places is seen across their border, and so from a
        # point of the border that is nearer.
        index = EdgeIndex(environment.edges, range_m / 3.0)
        border = shapely.segmentize(reachable.boundary, cell)
        for x, y in np.unique(shapely.get_coordinates(border), axis=0).tolist():
            boundary, _ = visibility_polygon(index, x, y, range_m, arc_tolerance_m=cell / 10.0)
            self.raster.paint_inside(boundary)
        # A raster of walls on round coordinates is off by up to a permille; the share of the
        # component's cells times its exact area is much less so.
        whole = Raster(cell, environment.bounds)
        _paint_all(whole, component)
        self.area_m2 = self.raster.area_m2() * float(component.area) / whole.area_m2()

    def farthest_m(self, start: Configuration) -> float:
        """Length of the shortest way from a place to the explorable point farthest from it.

        The way is one of a point through free space, measured on the raster; cells at the walls
        whose centres are joined to the rest by no free cell are left out.
        """
        return float(np.max(self._distances(start), initial=0.0))

    def _distances(self, start: Configuration) -> np.ndarray:
        raster = self.raster
        cells: BoolArray = raster.cells.copy()
        column = math.floor((start.x - raster.x0) / raster.cell_m)
        row = math.floor((start.y - raster.y0) / raster.cell_m)
        cells[row, column] = True
        field = distance_field(
            cells, raster.cell_m, [(start.x, start.y)], x0=raster.x0, y0=raster.y0
        )
        return field[np.isfinite(field)]


def cell_width(environment: Environment) -> float:
    """Width of the cells in which a world's areas are counted."""
    x0, y0, x1, y1 = environment.bounds
    return max(CELL_M, math.sqrt((x1 - x0) * (y1 - y0) / MOST_CELLS))


def reachable_area(component: Polygon, footprint: Footprint, start: Configuration) -> Polygon:
    """Give the places that a body's reference point can get to from a start.

    Exact for a disc. For a polygon these are the places with room for its inscribed disc: more
    than it can get to where it has to turn in a narrow place, never less.
    """
    radius = footprint.inscribed_radius_m
    # Chords of the rounded corners lie inside the true border by less than this.
    eroded = component.buffer(-radius + 1e-6, quad_segs=16)
    parts = [part for part in shapely.get_parts(eroded) if not part.is_empty]
    here = shapely.Point(start.x, start.y)
    nearest = min(parts, key=lambda part: float(part.distance(here)))
    assert isinstance(nearest, Polygon)
    return nearest


@lru_cache(maxsize=64)
def explorable(
    environment: Environment, footprint: Footprint, range_m: float, start: Configuration
) -> Explorable:
    """Give what can be explored, computed once for a world, body, range and start's component."""
    return Explorable(environment, footprint, range_m, start)


def _paint_all(raster: Raster, polygon: Polygon) -> None:
    # A polygon with holes, by the even-odd rule over all of its rings.
    cells = np.zeros_like(raster.cells)
    paint_polygon(
        shapely.get_coordinates(polygon.exterior), raster.x0, raster.y0, raster.cell_m, cells
    )
    for ring in polygon.interiors:
        hole = np.zeros_like(cells)
        paint_polygon(shapely.get_coordinates(ring), raster.x0, raster.y0, raster.cell_m, hole)
        cells &= ~hole
    raster.cells |= cells
