"""How much of a world there is to explore: the reference for coverage.

A robot can see a point if it is in sight and within range of a position that the body can reach
from its start. What cannot be seen in this way, as the inside of a closed room or a crack, is not
part of the task. The task of a team is what any of its robots can see, including robots that die.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import shapely
from shapely import MultiPolygon, Polygon

from multisrt.environments.environment import Environment
from multisrt.geometry.bodies.footprint import Footprint
from multisrt.geometry.configuration import Configuration
from multisrt.geometry.grids.distance_field import distance_field
from multisrt.geometry.grids.raster import Raster, paint_polygon
from multisrt.geometry.numerics.kernel import BoolArray, FloatArray
from multisrt.geometry.regions.edge_index import EdgeIndex
from multisrt.geometry.regions.visibility import visibility_polygon
from multisrt.spec import RunSpec

CELL_M = 0.1
"""Width of the cells in which areas are counted, in metres, unless the world is too large."""

MAX_CELLS = 16_000_000
"""Number of cells from which on cells are larger."""

Viewer = tuple[Footprint, float, Configuration]
"""The body of a robot, the range of its range finder (m), and its start."""


@dataclass(frozen=True, slots=True, eq=False)
class Explorable:
    """The part of a world that a team could see from all positions that its robots can reach.

    Attributes
    ----------
    raster : Raster
        Its window covers the world; cells whose centre can be seen are marked.
    area_m2 : float
        The area that can be seen.
    reachable : Polygon or MultiPolygon
        The positions that the reference point of a robot can reach.
    """

    raster: Raster
    area_m2: float
    reachable: Polygon | MultiPolygon

    @property
    def cell_m2(self) -> float:
        """The area that a marked cell stands for, in square metres."""
        return self.area_m2 / int(np.count_nonzero(self.raster.cells))

    def farthest_m(self, *starts: Configuration) -> float:
        """Return the largest path length from the nearest start to an explorable point, in metres.

        The path is that of a point through free space, measured on the raster; cells at walls
        that no free cell connects to the rest are left out.
        """
        raster = self.raster
        cells: BoolArray = raster.cells.copy()
        sources = [(start.x, start.y) for start in starts]
        for x, y in sources:
            column = math.floor((x - raster.x0) / raster.cell_m)
            row = math.floor((y - raster.y0) / raster.cell_m)
            cells[row, column] = True
        field: FloatArray = distance_field(
            cells, raster.cell_m, sources, x0=raster.x0, y0=raster.y0
        )
        return float(np.max(field[np.isfinite(field)], initial=0.0))


def cell_width(environment: Environment) -> float:
    """Return the width of the cells in which the areas of a world are counted, in metres."""
    x0, y0, x1, y1 = environment.bounds
    return max(CELL_M, math.sqrt((x1 - x0) * (y1 - y0) / MAX_CELLS))


def reachable_area(component: Polygon, footprint: Footprint, start: Configuration) -> Polygon:
    """Return the positions that the reference point of a body can reach from a start.

    Exact for a disc. For a polygon these are the positions with room for its inscribed disc, a
    superset of those that it can reach.
    """
    return _places(component, footprint, start).reachable


def viewers(spec: RunSpec, starts: Sequence[Configuration]) -> tuple[Viewer, ...]:
    """Return the bodies, ranges and starts of the team of a run."""
    return tuple(
        (Footprint.parse(robot.footprint), robot.range_finder.range_m, start)
        for robot, start in zip(spec.robots, starts, strict=True)
    )


def explorable(environment: Environment, team: tuple[Viewer, ...]) -> Explorable:
    """Return what a team can explore: what any of its robots could see.

    The result is cached: for robots with one body and range that can reach the same positions,
    and for teams of such robots.

    Parameters
    ----------
    environment : Environment
        The world.
    team : tuple of (Footprint, range_m, Configuration)
        The bodies, ranges and starts of the robots; see `viewers`.
    """
    # Of robots that reach the same positions, the one with the largest range sees all.
    ranges: dict[_Places, float] = {}
    for footprint, range_m, start in team:
        places = _places(environment.component(start.x, start.y), footprint, start)
        ranges[places] = max(range_m, ranges.get(places, 0.0))
    return _explorable_from(environment, tuple(ranges.items()))


@dataclass(frozen=True, slots=True, eq=False)
class _Places:
    """Positions of a component that a body can reach; hashed by identity, to key caches."""

    component: Polygon
    reachable: Polygon


def _places(component: Polygon, footprint: Footprint, start: Configuration) -> _Places:
    here = shapely.Point(start.x, start.y)
    parts = _roomy_parts(component, footprint)
    return min(parts, key=lambda places: float(places.reachable.distance(here)))


@lru_cache(maxsize=16)
def _explorable_from(
    environment: Environment, seen_from: tuple[tuple[_Places, float], ...]
) -> Explorable:
    # What is seen from each of some areas, with the range from there.
    raster = Raster(cell_width(environment), environment.bounds)
    area = 0.0
    for component in dict.fromkeys(places.component for places, _ in seen_from):
        cells = np.zeros_like(raster.cells)
        for places, range_m in seen_from:
            if places.component == component:
                cells |= _seen_from(environment, places, range_m)
        # With walls on round coordinates, counted cells are off by up to 0.1 %; their share of the
        # cells of the component times its exact area is much more precise.
        whole = int(np.count_nonzero(_filled(environment, component)))
        area += int(np.count_nonzero(cells)) * float(component.area) / whole
        raster.cells |= cells
    reachable_by_any = shapely.union_all([places.reachable for places, _ in seen_from])
    assert isinstance(reachable_by_any, Polygon | MultiPolygon)
    return Explorable(raster=raster, area_m2=area, reachable=reachable_by_any)


@lru_cache(maxsize=16)
def _roomy_parts(component: Polygon, footprint: Footprint) -> tuple[_Places, ...]:
    # Chords of the rounded corners lie inside the true border by less than a micrometre.
    eroded = component.buffer(1e-6 - footprint.inscribed_radius_m, quad_segs=16)
    parts = (part for part in shapely.get_parts(eroded) if not part.is_empty)
    return tuple(_Places(component, part) for part in parts)


@lru_cache(maxsize=16)
def _seen_from(environment: Environment, places: _Places, range_m: float) -> BoolArray:
    raster = Raster(cell_width(environment), environment.bounds)
    raster.cells |= _filled(environment, places.reachable)
    # A point outside of the reachable area is seen across its border, and so from a point of the
    # border, which is nearer.
    index = EdgeIndex(environment.edges, range_m / 3.0)
    border = shapely.segmentize(places.reachable.boundary, raster.cell_m)
    for x, y in np.unique(shapely.get_coordinates(border), axis=0).tolist():
        boundary, _ = visibility_polygon(index, x, y, range_m, arc_tolerance_m=raster.cell_m / 10.0)
        raster.paint_inside(boundary)
    return raster.cells


def _filled(environment: Environment, polygon: Polygon) -> BoolArray:
    # A polygon with holes, by the even-odd rule over all of its rings.
    raster = Raster(cell_width(environment), environment.bounds)
    raster.paint_inside(shapely.get_coordinates(polygon.exterior))
    cells = raster.cells
    for ring in polygon.interiors:
        hole = np.zeros_like(cells)
        paint_polygon(shapely.get_coordinates(ring), raster.x0, raster.y0, raster.cell_m, hole)
        cells &= ~hole
    return cells
