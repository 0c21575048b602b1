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
from scipy.spatial import KDTree
from shapely import MultiPolygon, Polygon

from multisrt.environments.environment import Environment
from multisrt.geometry.bodies.footprint import Footprint
from multisrt.geometry.configuration import Configuration
from multisrt.geometry.grids.strip_map import OUTSIDE, StripMap
from multisrt.geometry.grids.strips import Runs, Strips, runs_of, runs_of_polygon, strips
from multisrt.geometry.numerics import libm
from multisrt.geometry.numerics.kernel import BoolArray, FloatArray
from multisrt.geometry.regions.edge_index import EdgeIndex
from multisrt.geometry.regions.visibility import visibility_polygons
from multisrt.spec import RunSpec

MAX_STRIP_M = 0.03
"""Upper bound of the height of the strips on which areas are measured, in metres."""

STRIP_SHARE = 1e-3
"""Upper bound of their height as a share of the side of a square of the same area: errors grow
with the square of the height, and are judged as shares of the area."""

TILTS_RAD = tuple(0.15 + k * math.pi / 8.0 for k in range(8))
"""Directions that strips may have: not those of the cones of stars with 8, 16, 32 or 64 cones."""

ALONG_RAD = 0.1
"""Walls whose direction differs by less from that of the strips run along them."""

MIN_SPACING_M, SPACING_SHARE = 0.05, 2e-4
"""Maximum distance between neighbouring viewpoints on the border of what a body can reach, where it
makes a difference: in metres, or, in large worlds, as a share of the side of a square of the same
area."""

OUTLINE_M = 5e-4
"""Viewpoints lie at most this far beyond the border, where it bends, in metres."""

ROUNDING_M = 1e-6
"""Bodies are smaller by this, and by up to as much again where they pass a corner, in metres: a
gap that just fits lets them through."""

VIEWPOINTS_AT_ONCE = 1024
"""Number of viewpoints whose regions are in memory at a time, each with about 100 kB."""

COARSER = (32, 8, 2, 1)
"""Viewpoints are first taken this many times farther apart; finer ones only near what is still
unseen."""

MIN_UNSEEN_M = 1e-6
"""Shorter intervals are rounding, not unseen."""

SAMPLE_M = 0.25
"""Distance of the points that stand for what is still unseen, in metres."""

MAX_SAMPLES = 1 << 20
"""Approximate maximum number of these points that are held at once, about 100 bytes each."""

EXPLORABLE = 1
"""The label of what is explorable; all else is `OUTSIDE`."""

Viewer = tuple[Footprint, float, Configuration]
"""The body of a robot, the range of its range finder (m), and its start."""


@dataclass(frozen=True, slots=True, eq=False)
class Explorable:
    """The part of a world that a team could see from all positions that its robots can reach.

    Attributes
    ----------
    plane : StripMap
        What can be seen has the label `EXPLORABLE`. Areas are scaled such that the connected part
        of free space around the starts has its exact area. It is shared: relabel copies only.
    free_m2 : float
        Area of that connected part, in square metres.
    reachable : Polygon or MultiPolygon
        The positions that the reference point of a robot can reach.
    """

    plane: StripMap
    free_m2: float
    reachable: Polygon | MultiPolygon

    @property
    def area_m2(self) -> float:
        """The area that can be seen, in square metres; never more than that of free space."""
        return min(self.free_m2, float(self.plane.areas_m2[EXPLORABLE]))


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
        The bodies, ranges and starts of the robots, in one connected part of free space; see
        `viewers`.
    """
    # Of robots that reach the same positions, the one with the largest range sees all.
    ranges: dict[_Places, float] = {}
    component = environment.component(*team[0][2][:2])
    for footprint, range_m, start in team:
        places = _places(component, footprint, start)
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
def _roomy_parts(component: Polygon, footprint: Footprint) -> tuple[_Places, ...]:
    # Where the body passes a corner, its path is an arc, and the chords that stand for it lie
    # nearer to the corner: coarse ones would let the body through gaps that are too narrow.
    radius_m = footprint.inscribed_radius_m
    segments = math.ceil(math.pi / 4.0 / math.acos(1.0 - min(1.0, ROUNDING_M / radius_m)))
    # On a shape with a fixed precision, as generators make them, buffers are rounded to it, and may
    # fail.
    exact = shapely.from_wkb(shapely.to_wkb(component))
    eroded = exact.buffer(ROUNDING_M - radius_m, quad_segs=segments)
    parts = (part for part in shapely.get_parts(eroded) if not part.is_empty)
    return tuple(_Places(component, part) for part in parts)


@lru_cache(maxsize=16)
def _explorable_from(
    environment: Environment, seen_from: tuple[tuple[_Places, float], ...]
) -> Explorable:
    # What is seen from any of some areas, with the range from there.
    component = seen_from[0][0].component
    plane = StripMap(strips_of(environment, component), 2)
    for places, range_m in seen_from:
        plane.relabel(_seen_from(environment, places, range_m), [[EXPLORABLE, EXPLORABLE]])
    reachable_by_any = shapely.union_all([places.reachable for places, _ in seen_from])
    assert isinstance(reachable_by_any, Polygon | MultiPolygon)
    return Explorable(plane=plane, free_m2=component.area, reachable=reachable_by_any)


@lru_cache(maxsize=16)
def strips_of(environment: Environment, component: Polygon) -> Strips:
    """Return the strips on which areas of a component of free space are measured.

    Their heights are scaled such that the area of the component is exact.
    """
    height_m = min(MAX_STRIP_M, STRIP_SHARE * math.sqrt(component.area))
    cut = strips(environment.edges, height_m, _tilt_rad(environment.edges))
    runs = runs_of_polygon(cut, component)
    measured = float(((runs.end - runs.begin) * cut.heights[runs.strip]).sum())
    return cut._replace(heights=cut.heights * (component.area / measured))


def _tilt_rad(walls: FloatArray) -> float:
    # The direction in which the least length of walls runs: where regions end along strips, beside
    # walls or at an arc that touches one, they are wrong by up to half a strip.
    along = walls[:, 2:] - walls[:, :2]
    lengths, directions = np.hypot(*along.T), libm.arctan2(along[:, 1], along[:, 0])
    between = np.abs(np.subtract.outer(TILTS_RAD, directions)) % math.pi
    runs_along = np.minimum(between, math.pi - between) < ALONG_RAD
    return TILTS_RAD[int(np.argmin((runs_along * lengths).sum(axis=1)))]


@lru_cache(maxsize=16)
def _seen_from(environment: Environment, places: _Places, range_m: float) -> Runs:
    unseen, seen = 1, 2
    cut = strips_of(environment, places.component)
    plane = StripMap(cut, 3)
    plane.relabel(runs_of_polygon(cut, places.component), [[unseen, unseen, seen]])
    see = [[OUTSIDE, seen, seen]]
    plane.relabel(runs_of_polygon(cut, places.reachable), see)
    # A point outside of the reachable area is seen across its border, and so from a point of the
    # border, which is nearer.
    index = EdgeIndex(environment.edges, range_m / 3.0)
    # Ring by ring: together they take GEOS far more time and memory.
    rings = shapely.get_parts(places.reachable.boundary)
    outline = shapely.simplify(rings, OUTLINE_M)
    spacing_m = max(MIN_SPACING_M, SPACING_SHARE * math.sqrt(places.component.area))
    border = shapely.get_coordinates(shapely.segmentize(outline, spacing_m))
    taken = np.zeros(len(border), np.bool_)
    for step in COARSER:
        chosen = np.flatnonzero(~taken[::step]) * step
        chosen = chosen[_near_unseen(plane, unseen, border[chosen], range_m)]
        taken[chosen] = True
        for first in range(0, len(chosen), VIEWPOINTS_AT_ONCE):
            viewpoints = border[chosen[first : first + VIEWPOINTS_AT_ONCE]]
            regions = visibility_polygons(index, viewpoints, range_m)
            plane.relabel(runs_of(cut, regions, plane.runs(unseen)), see)
    return plane.runs(seen)


def _near_unseen(plane: StripMap, unseen: int, viewpoints: FloatArray, range_m: float) -> BoolArray:
    # Which viewpoints have anything unseen within their range.
    runs = plane.runs(unseen)
    lengths = runs.end - runs.begin
    intervals = np.flatnonzero(lengths > MIN_UNSEEN_M)
    near = np.zeros(len(viewpoints), np.bool_)
    if not len(intervals):
        return near
    count = np.ceil(lengths[intervals] / SAMPLE_M).astype(np.int64) + 1
    blocks = np.flatnonzero(np.diff(np.cumsum(count) // MAX_SAMPLES)) + 1
    at = plane.cut.frame(viewpoints)
    for some, counts in zip(np.split(intervals, blocks), np.split(count, blocks), strict=True):
        # Points from the one end of each interval to the other.
        which = np.repeat(some, counts)
        step = np.arange(len(which)) - np.repeat(np.cumsum(counts) - counts, counts)
        x = runs.begin[which] + step * np.repeat(lengths[some] / (counts - 1), counts)
        y = plane.cut.middles[runs.strip[which]]
        tree = KDTree(np.column_stack([x, y]))
        others = np.flatnonzero(~near)
        distance, _ = tree.query(at[others], distance_upper_bound=range_m + SAMPLE_M)
        near[others] = np.isfinite(distance)
    return near
