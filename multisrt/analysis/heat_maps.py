"""Rasters of counts and times: where robots drove, what they saw, where they were isolated."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final, Literal

import numpy as np
import shapely

from multisrt.analysis.isolation import isolation
from multisrt.analysis.poses import legs_at, poses_on, tracks
from multisrt.analysis.scans import scanned_regions
from multisrt.environments.environment import Environment
from multisrt.events import Sensed
from multisrt.geometry.bodies.footprint import Footprint
from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.numerics.kernel import FloatArray, IntArray
from multisrt.planners.motion.trajectory import leg_points
from multisrt.recording import Recording

VisitCount = Literal["passes", "robots", "scans", "viewers"]
"""What is counted: times that robots drove past a place, robots that did, scans that showed it,
robots that saw it."""

CELLS: Final = 150
"""The longer side of a world is divided into about as many cells by default."""

MAX_CELLS: Final = 4_000_000
"""Upper bound of the cells of a map."""

STEPS: Final = 8
"""Least number of steps in which a robot crosses a cell where its time is counted."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class HeatMap:
    """A number for each cell of a raster.

    Attributes
    ----------
    x0, y0 : float
        Lower left corner of the raster, in metres.
    cell_m : float
        Width of its cells.
    values : (rows, columns) array of float
        The numbers; rows upwards from `y0`.
    """

    x0: float
    y0: float
    cell_m: float
    values: FloatArray

    @property
    def extent(self) -> tuple[float, float, float, float]:
        """Left, right, bottom and top of the raster, in metres."""
        rows, columns = self.values.shape
        return (
            self.x0,
            self.x0 + columns * self.cell_m,
            self.y0,
            self.y0 + rows * self.cell_m,
        )

    def centres(self) -> FloatArray:
        """Return the centres of the cells, row by row, ``(rows * columns, 2)``."""
        rows, columns = self.values.shape
        x, y = np.meshgrid(np.arange(columns) + 0.5, np.arange(rows) + 0.5)
        return np.column_stack([x.ravel(), y.ravel()]) * self.cell_m + (self.x0, self.y0)


def visits(
    recording: Recording,
    count: VisitCount = "passes",
    *,
    cell_m: float | None = None,
    environment: Environment | None = None,
) -> HeatMap:
    """Count how often, or by how many robots, places were visited or seen.

    Parameters
    ----------
    recording : Recording
        The run.
    count : {"passes", "robots", "scans", "viewers"}
        `passes`: how often a body drove over the centre of the cell, that is: how many stretches
        of paths of reference points lie within half the width of the body of it. `robots`: how
        many robots did. `scans`: how many scans showed the centre. `viewers`: how many robots
        saw it.
    cell_m : float, optional
        Width of the cells in metres; by default a power of two that divides the longer side of
        the world into about `CELLS` cells.
    environment : Environment, optional
        The world, if it has been built already.

    Returns
    -------
    HeatMap
        The counts, over the bounds of the world.

    Raises
    ------
    InvalidInputError
        If `count` is none of these, or cells are not positive or too many.

    Examples
    --------
    >>> import multisrt as ms
    >>> run = ms.explore("open", robots=2, seed=1, max_time_s=10.0)
    >>> visits(run.recording, "viewers", cell_m=1.0).values.shape
    (20, 20)
    """
    world = environment or recording.environment()
    found = _empty(world, cell_m)
    if count in ("passes", "robots"):
        for passed in _passes(recording, found.centres()):
            numbers = passed if count == "passes" else np.minimum(passed, 1)
            found.values[:] += numbers.reshape(found.values.shape)
    elif count in ("scans", "viewers"):
        for seen in _sightings(recording, world, found):
            found.values[:] += seen if count == "scans" else seen > 0
    else:
        raise InvalidInputError(f"count is passes, robots, scans or viewers, not {count!r}")
    return found


def isolated_times(
    recording: Recording, *, cell_m: float | None = None, environment: Environment | None = None
) -> HeatMap:
    """Return for how long robots were isolated from all others, by where they were meanwhile.

    Parameters
    ----------
    recording : Recording
        The run.
    cell_m : float, optional
        Width of the cells in metres; by default twice as wide as for `visits`.
    environment : Environment, optional
        The world, if it has been built already.

    Returns
    -------
    HeatMap
        Seconds, summed over all robots; together they are the times of `multisrt.isolation`.

    Raises
    ------
    InvalidInputError
        If cells are not positive or too many.

    Examples
    --------
    >>> import multisrt as ms
    >>> radio = ms.RadioSpec(range_m=5.0)
    >>> given = {"robots": 2, "radio": radio, "max_time_s": 60.0}
    >>> run = ms.explore("apartment", strategy="closest", seed=1, **given)
    >>> found = isolated_times(run.recording)
    >>> total_s = sum(robot.total_s for robot in ms.isolation(run.recording))
    >>> abs(float(found.values.sum()) - total_s) < 1e-6
    True
    """
    world = environment or recording.environment()
    found = _empty(world, cell_m, CELLS // 2)
    rows, columns = found.values.shape
    for robot, own in enumerate(isolation(recording, world)):
        legs = tracks(recording)[robot].legs
        for begin, end in own.spells:
            times, spans = _steps(legs, begin, end, found.cell_m / STEPS)
            at = poses_on(legs_at(legs, times), times)[:, :2]
            column, row = ((at - (found.x0, found.y0)) / found.cell_m).astype(np.int64).T
            cell = np.clip(row, 0, rows - 1), np.clip(column, 0, columns - 1)
            np.add.at(found.values, cell, spans)
    return found


def _empty(world: Environment, cell_m: float | None, cells: int = CELLS) -> HeatMap:
    x0, y0, x1, y1 = world.bounds
    if cell_m is None:
        cell_m = 2.0 ** round(math.log2(max(x1 - x0, y1 - y0) / cells))
    if not 0.0 < cell_m < math.inf:
        raise InvalidInputError(f"the width of cells is a positive number of metres, not {cell_m}")
    columns = max(1.0, math.ceil((x1 - x0) / cell_m - 1e-9))
    rows = max(1.0, math.ceil((y1 - y0) / cell_m - 1e-9))
    if rows * columns > MAX_CELLS:
        raise InvalidInputError(
            f"cells of {cell_m:g} m make {rows * columns:,.0f} of them; at most {MAX_CELLS:,} are "
            "drawn: take larger ones"
        )
    values = np.zeros((int(rows), int(columns)))
    return HeatMap(x0=x0, y0=y0, cell_m=cell_m, values=values)


def _passes(recording: Recording, centres: FloatArray) -> Iterator[IntArray]:
    # How often each robot passed each of some points.
    tree = shapely.STRtree(np.asarray(shapely.points(centres), np.object_))
    for robot, track in enumerate(tracks(recording)):
        body = Footprint.parse(recording.spec.robots[robot].footprint)
        path = _path(track.legs)
        yield _times_near(tree, centres, path, 0.5 * body.width_m)


def _path(legs: FloatArray) -> FloatArray:
    # The points of a path, with chords for arcs, without repetitions.
    points = [(float(legs[0, 1]), float(legs[0, 2]))]
    for leg in legs.tolist():
        if leg[1:3] != leg[5:7]:
            points += leg_points(leg[:4], leg[4:])[1:]
    path: FloatArray = np.array(points)
    moves = (np.diff(path, axis=0) != 0.0).any(axis=1)
    kept: FloatArray = path[np.append(True, moves)]
    return kept


def _times_near(
    tree: shapely.STRtree, centres: FloatArray, path: FloatArray, radius_m: float
) -> IntArray:
    # For each point the number of stretches of a path that lie within a distance of it.
    if len(path) == 1:
        near = np.hypot(*(centres - path[0]).T) <= radius_m
        once: IntArray = near.astype(np.int64)
        return once
    lines = shapely.linestrings(np.stack([path[:-1], path[1:]], axis=1))
    which, cell = tree.query(lines, predicate="dwithin", distance=radius_m)
    order = np.lexsort((which, cell))
    which, cell = which[order], cell[order]
    lengths = np.hypot(*np.diff(path, axis=0).T)
    before = np.append(0.0, np.cumsum(lengths))
    along = np.diff(path, axis=0)[which] / lengths[which, None]
    away = centres[cell] - path[which]
    foot = (away * along).sum(axis=1)
    aside = away[:, 0] * along[:, 1] - away[:, 1] * along[:, 0]
    half = np.sqrt(np.maximum(0.0, radius_m**2 - aside**2))
    begin = before[which] + np.clip(foot - half, 0.0, lengths[which])
    end = before[which] + np.clip(foot + half, 0.0, lengths[which])
    new = np.ones(len(cell), np.bool_)
    new[1:] = (cell[1:] != cell[:-1]) | (begin[1:] > end[:-1] + 1e-9)
    return np.bincount(cell[new], minlength=len(centres))


def _sightings(recording: Recording, world: Environment, like: HeatMap) -> Iterator[FloatArray]:
    # For each robot how many of its scans showed the centre of each cell.
    shown = scanned_regions(recording, world)
    rows, columns = like.values.shape
    x = like.x0 + (np.arange(columns) + 0.5) * like.cell_m
    y = like.y0 + (np.arange(rows) + 0.5) * like.cell_m
    for robot in range(len(recording.spec.robots)):
        seen = np.zeros(like.values.shape)
        for scan, corners in zip(recording.of(Sensed), shown, strict=True):
            if scan.robot != robot or not len(corners):
                continue
            c0, c1 = np.searchsorted(x, (corners[:, 0].min(), corners[:, 0].max()))
            r0, r1 = np.searchsorted(y, (corners[:, 1].min(), corners[:, 1].max()))
            region = shapely.Polygon(corners)
            shapely.prepare(region)
            at_x, at_y = np.meshgrid(x[c0:c1], y[r0:r1])
            seen[r0:r1, c0:c1] += shapely.contains_xy(region, at_x, at_y)
        yield seen


def _steps(
    legs: FloatArray, begin: float, end: float, step_m: float
) -> tuple[FloatArray, FloatArray]:
    # Times at which a robot stood for spans of time that together last from begin to end, so
    # short that it moved by no more than a step in each.
    cuts: list[float] = [begin]
    for leg in legs[(legs[:, 0] < end) & (legs[:, 4] > begin)].tolist():
        first, last = max(begin, leg[0]), min(end, leg[4])
        length_m = math.hypot(leg[5] - leg[1], leg[6] - leg[2])
        # An arc is at most 1.6 times as long as its chord, up to half a turn.
        count = max(1, math.ceil(1.6 * length_m / step_m))
        cuts += np.linspace(first, last, count + 1)[1:].tolist()
    at = np.array(cuts)
    return 0.5 * (at[1:] + at[:-1]), np.diff(at)
