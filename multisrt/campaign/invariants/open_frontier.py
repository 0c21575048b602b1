"""The frontier that a robot could still have explored, computed on the true map."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
import shapely
from shapely import LineString, MultiLineString, MultiPolygon, Polygon
from shapely.geometry.base import BaseGeometry

from multisrt.campaign.bodies import FloatArray
from multisrt.campaign.judged_run import JudgedRun
from multisrt.events import NodeName

GRID_M: Final = 1e-6
"""Corners of overlays are rounded to multiples of this, in metres."""

SPACING_M: Final = 0.1
"""Distance of the points that stand for a frontier, in metres."""

SIMPLER_M: Final = 2e-3
"""Borders of what is known are simplified by this, a tenth of all slacks at most, in metres."""

WALL_M: Final = 0.01
"""What lies within this of a wall is the wall's, in metres."""


@dataclass(frozen=True, slots=True, kw_only=True)
class OpenFrontier:
    """A contiguous frontier that is visible from a place of a body.

    Attributes
    ----------
    length_m : float
        Its length.
    behind_m2 : float
        Area of the unknown part behind it.
    place : (x, y)
        Its middle.
    stand : (x, y)
        A place of the body's reference point from which it is visible.
    """

    length_m: float
    behind_m2: float
    place: tuple[float, float]
    stand: tuple[float, float]


@dataclass(frozen=True, slots=True, kw_only=True)
class Reach:
    """The limits of where a robot goes, and of what counts as frontier for it.

    Attributes
    ----------
    off_walls_m : float
        Distance of its reference point from walls that is certainly sufficient.
    off_unknown_m : float
        The same for the unknown area.
    enters_m : float
        Distance of where it is from such places at which it certainly has a path to them. A robot
        whose range finder shows more than those of others may stand where these show a wall.
    scrap_m : float
        Unknown parts that contain no disc of this radius are ignored.
    blind_m : float
        Places closer to a wall may appear as wall to it; 0 for an exact range finder.
    sees_m : float
        Distance from which it looks at a frontier.
    min_frontier_m : float
        Shorter frontiers do not count.
    is_ball : bool
        Whether its regions are balls: from a place it sees no farther than the next wall.
    """

    off_walls_m: float
    off_unknown_m: float
    enters_m: float
    scrap_m: float
    blind_m: float
    sees_m: float
    min_frontier_m: float
    is_ball: bool = False


def open_frontiers(
    run: JudgedRun,
    robot: int,
    names: Collection[NodeName],
    reach: Reach,
    at: Sequence[float],
    *,
    obstacles: BaseGeometry | None = None,
    looked: BaseGeometry | None = None,
    only: BaseGeometry | None = None,
) -> list[OpenFrontier]:
    """Return the frontiers that a robot could still explore, the longest first.

    Parameters
    ----------
    run : JudgedRun
        The run.
    robot : int
        The robot.
    names : collection of (robot, serial)
        The nodes on its map.
    reach : Reach
        Where it can go, and what counts as frontier.
    at : sequence of float
        Where it stands: x and y come first.
    obstacles : geometry, optional
        Places where its reference point cannot be.
    looked : geometry, optional
        Places from which it has looked: it may pass them, but does not look from there again.
    only : geometry, optional
        Area in which the frontier must lie to belong to it.
    """
    space = run.component(robot)
    unknown, _ = _open_space(run, space, names, reach)
    if unknown.is_empty:
        return []
    standing = standing_space(run, robot, names, reach, obstacles)
    standing = _part_at(standing, at, reach.enters_m)
    if looked is not None:
        standing = without(standing, looked)
    if standing.is_empty:
        return []
    found = []
    for part in shapely.get_parts(unknown).tolist():
        near = _frontier_of(run, space, part, reach)
        if only is not None:
            near = near.intersection(only)
        for stretch in stretches(near):
            found += _seen(run, space, stretch, standing, reach, float(part.area))
    return sorted(found, key=lambda one: -one.length_m)


def frontiers(
    run: JudgedRun, robot: int, names: Collection[NodeName], reach: Reach, apart_m: float
) -> BaseGeometry:
    """Return the surroundings of all frontiers of a robot, each of which is one part.

    Parameters
    ----------
    run, robot, names, reach
        As for `open_frontiers`.
    apart_m : float
        Frontiers that are at most this far apart, in metres, are taken for one.
    """
    space = run.component(robot)
    unknown, _ = _open_space(run, space, names, reach)
    return _frontier_of(run, space, unknown, reach).buffer(0.5 * apart_m, quad_segs=2)


def standing_space(
    run: JudgedRun,
    robot: int,
    names: Collection[NodeName],
    reach: Reach,
    obstacles: BaseGeometry | None = None,
) -> BaseGeometry:
    """Return where the reference point of a robot can be; see `open_frontiers`."""
    _, standing = _open_space(run, run.component(robot), names, reach)
    return standing if obstacles is None else without(standing, obstacles)


def path_leads(
    run: JudgedRun,
    robot: int,
    names: Collection[NodeName],
    reach: Reach,
    at: Sequence[float],
    places: Sequence[Sequence[float]],
    obstacles: BaseGeometry,
) -> bool:
    """Return whether a path leads from where a robot stands to one of some places.

    Parameters
    ----------
    run, robot, names, reach, at, obstacles
        As for `open_frontiers`.
    places : sequence of sequence of float
        The places: x and y come first.
    """
    standing = standing_space(run, robot, names, reach, obstacles)
    part = _part_at(standing, at, reach.enters_m)
    there = shapely.MultiPoint([(place[0], place[1]) for place in places])
    return bool(shapely.dwithin(part, there, reach.off_walls_m))


def _frontier_of(
    run: JudgedRun, space: Polygon, unknown: BaseGeometry, reach: Reach
) -> BaseGeometry:
    # What is unknown ends before what may look like a wall: its sides there are no frontier.
    walls_m = reach.blind_m + WALL_M
    walls = run.once(
        ("walls", shapely.to_wkb(space), walls_m),
        lambda: space.boundary.buffer(walls_m, quad_segs=2),
    )
    return shapely.difference(unknown.boundary, walls)


def _open_space(
    run: JudgedRun, space: Polygon, names: Collection[NodeName], reach: Reach
) -> tuple[BaseGeometry, BaseGeometry]:
    return run.once(
        ("open frontier", shapely.to_wkb(space), reach, frozenset(names)),
        lambda: _unknown_and_standing(run, space, names, reach),
    )


def _unknown_and_standing(
    run: JudgedRun, space: Polygon, names: Collection[NodeName], reach: Reach
) -> tuple[BaseGeometry, BaseGeometry]:
    # What is unknown in a space, and where the body can stand in what is known.
    known = united(run, names).simplify(SIMPLER_M)
    unknown = without(space, known)
    if reach.blind_m > 0.0:
        walls = space.boundary.buffer(reach.blind_m, quad_segs=4)
        unknown = without(unknown, walls)
    unknown = unknown.buffer(-reach.scrap_m, quad_segs=4)
    unknown = solid(unknown.buffer(reach.scrap_m * 0.999, quad_segs=4))
    standing = _valid(known.buffer(-reach.off_unknown_m, quad_segs=4))
    roomy = _valid(space.buffer(-reach.off_walls_m, quad_segs=4))
    both = shapely.intersection(standing, roomy, grid_size=GRID_M)
    return unknown, solid(both.simplify(SIMPLER_M))


def united(run: JudgedRun, names: Collection[NodeName]) -> BaseGeometry:
    """Return the union of the regions of nodes."""
    key = "united", frozenset(names)
    return run.once(key, lambda: union_of(run.regions[name] for name in names))


def union_of(areas: Iterable[BaseGeometry]) -> BaseGeometry:
    """Return the union of areas, which need not be valid."""
    return solid(shapely.union_all([_valid(area) for area in areas], grid_size=GRID_M))


def without(area: BaseGeometry, other: BaseGeometry) -> BaseGeometry:
    """Return an area less another one."""
    return solid(shapely.difference(_valid(area), _valid(other), grid_size=GRID_M))


def _valid(shape: BaseGeometry) -> BaseGeometry:
    # Even a buffer of GEOS is not always valid.
    return shape if shape.is_valid else solid(shapely.make_valid(shape))


def solid(shape: BaseGeometry) -> BaseGeometry:
    """Return the polygons of a geometry, without its points and lines."""
    if isinstance(shape, Polygon | MultiPolygon):
        return shape
    return MultiPolygon([p for p in shapely.get_parts(shape) if isinstance(p, Polygon)])


def _part_at(standing: BaseGeometry, at: Sequence[float], within_m: float) -> BaseGeometry:
    # The part from which the robot sets out, or nothing; it may stand a little outside of it.
    here = shapely.Point(at[0], at[1])
    parts = [part for part in shapely.get_parts(standing) if not part.is_empty]
    near = [part for part in parts if part.distance(here) <= within_m]
    return min(near, key=lambda part: float(part.distance(here)), default=MultiPolygon())


def stretches(lines: BaseGeometry) -> list[LineString]:
    """Return the lines of a geometry, merged where they meet, without its points."""
    parts = [part for part in shapely.get_parts(lines) if isinstance(part, LineString)]
    merged = shapely.line_merge(MultiLineString([part for part in parts if not part.is_empty]))
    whole: list[LineString] = shapely.get_parts(merged).tolist()
    return [part for part in whole if part.length > 0.0]


def _seen(
    run: JudgedRun,
    space: Polygon,
    stretch: LineString,
    standing: BaseGeometry,
    reach: Reach,
    area_m2: float,
) -> list[OpenFrontier]:
    # The longest run of points of a stretch that are in sight of the places next to them.
    if stretch.length < reach.min_frontier_m:
        return []
    count = max(2, math.ceil(stretch.length / SPACING_M))
    shares = (np.arange(count) + 0.5) / count
    points = shapely.line_interpolate_point(stretch, shares, normalized=True)
    sights = shapely.shortest_line(points, standing)
    lengths = shapely.length(sights)
    is_seen = (lengths <= reach.sees_m) & np.asarray(shapely.covers(run.walls.grown, sights))
    if reach.is_ball:
        is_seen &= lengths <= shapely.distance(shapely.get_point(sights, -1), space.boundary)
    begin, length = _longest_run(is_seen)
    length_m = length / count * float(stretch.length)
    if length_m < reach.min_frontier_m:
        return []
    middle = begin + length // 2
    ends: FloatArray = shapely.get_coordinates(sights[middle])
    (px, py), (sx, sy) = ends[0].tolist(), ends[-1].tolist()
    return [OpenFrontier(length_m=length_m, behind_m2=area_m2, place=(px, py), stand=(sx, sy))]


def _longest_run(flags: Sequence[bool] | np.ndarray) -> tuple[int, int]:
    best, begin = (0, 0), 0
    for k, flag in enumerate([*flags, False]):
        if not flag:
            if k - begin > best[1]:
                best = begin, k - begin
            begin = k + 1
    return best
