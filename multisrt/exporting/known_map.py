"""The map that a robot of a run, or the team, had at some time."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable

import numpy as np
import shapely
from shapely import MultiLineString

from multisrt.environments.environment import Environment
from multisrt.events import Motion
from multisrt.exporting.grids import ShownRegions
from multisrt.exporting.map_content import Line, MapContent
from multisrt.exporting.sampling import course_of, nanoseconds
from multisrt.exporting.selection import require_robot, require_time
from multisrt.exporting.trees import tree_by
from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.numerics.arrays import FloatArray
from multisrt.geometry.regions.safe_region import LocalSafeRegion
from multisrt.recording import Recording

GRID_M = 1e-6
"""Grid in metres to which known space is rounded, so that regions join without gaps."""


def known_map(
    recording: Recording,
    environment: Environment | None = None,
    *,
    robot: int | None = None,
    time_s: float | None = None,
) -> Environment:
    """Return the free space that a robot of a run, or the team, knew at some time.

    It is the union of the regions of the nodes that the robot made, and of those that it learned
    of; for a robot that records no nodes, the area that its scans showed.

    Parameters
    ----------
    recording : Recording
        The run.
    environment : Environment, optional
        Its world; by default it is built from the recording.
    robot : int, optional
        The robot, from 0; by default what all robots of the team knew together.
    time_s : float, optional
        The time in seconds; by default the end of the run.

    Returns
    -------
    Environment
        The known free space, with the starts of the robots that lie in it as suggested starts. Its
        boundary consists of observed surfaces and of borders to unknown space.

    Raises
    ------
    InvalidInputError
        If there is no such robot or time, or nothing was known then.

    Examples
    --------
    >>> import multisrt as ms
    >>> run = ms.explore("open", robots=2, seed=1)
    >>> begin, end = (known_map(run.recording, robot=0, time_s=t) for t in (1.0, None))
    >>> 0.0 < begin.area_m2 < end.area_m2 <= run.environment.area_m2 + 1e-3
    True
    """
    content = known_content(
        recording, environment or recording.environment(), robot=robot, time_s=time_s
    )
    return content.environment


def known_content(
    recording: Recording,
    environment: Environment,
    *,
    robot: int | None = None,
    time_s: float | None = None,
    layers: Iterable[str] = (),
) -> MapContent:
    """Return what a robot of a run, or the team, knew at some time, as a map to write.

    Parameters
    ----------
    recording, environment, robot, time_s
        As for `known_map`.
    layers : iterable of {"edges", "paths"}, optional
        Lines to show: edges of trees, and paths of robots.

    Raises
    ------
    InvalidInputError
        If there is no such robot or time, or nothing was known then.
    """
    require_robot(recording, robot)
    until = nanoseconds(require_time(recording, time_s))
    shown = ShownRegions(recording, environment)
    found: dict[int, LocalSafeRegion] = {}
    for event in recording.events:
        if nanoseconds(event.time_s) <= until and robot in (None, event.robot):
            for region in shown.by(event):
                found.setdefault(id(region), region)  # shared by all robots that know it
    regions = tuple(found.values())
    who = "the team" if robot is None else f"robot {robot}"
    when = "" if time_s is None else f" at {time_s:g} s"
    if not regions:
        raise InvalidInputError(f"{who} knew nothing yet{when}: there is no map to write")
    free = _union([region.boundary for region in regions])
    name = f"{environment.name}, known to {who}{when or ' at the end'}"
    known = Environment(name, free, starts=_starts_in(free, recording))
    lines = _lines(recording, robot, time_s, frozenset(layers))
    return MapContent(environment=known, regions=regions, lines=lines)


def world_content(
    recording: Recording, environment: Environment, *, layers: Iterable[str] = ()
) -> MapContent:
    """Return the true world of a run, with the starts of its robots, as a map to write."""
    starts = _starts_in(environment.free, recording)
    world = Environment(environment.name, environment.free, starts=starts)
    return MapContent(environment=world, lines=_lines(recording, None, None, frozenset(layers)))


def _union(corners: Iterable[FloatArray]) -> shapely.MultiPolygon:
    regions = shapely.make_valid(np.array([shapely.Polygon(own) for own in corners], np.object_))
    # Rounding of slivers in GEOS divides by zero without consequence.
    with np.errstate(divide="ignore", invalid="ignore"):
        area = shapely.union_all(shapely.set_precision(regions, GRID_M), grid_size=GRID_M)
    parts = shapely.get_parts(area)
    return shapely.MultiPolygon([part for part in parts if part.geom_type == "Polygon"])


def _starts_in(free: shapely.MultiPolygon, recording: Recording) -> list[tuple[float, float]]:
    starts = [(start.x, start.y) for start in recording.starts]
    return [(x, y) for x, y in starts if shapely.contains_xy(free, x, y)]


def _lines(
    recording: Recording, robot: int | None, time_s: float | None, layers: frozenset[str]
) -> tuple[Line, ...]:
    robots = range(len(recording.starts)) if robot is None else [robot]
    end_s = require_time(recording, time_s)
    pieces: dict[tuple[str, int], list[FloatArray]] = defaultdict(list)
    if "edges" in layers:
        for one in robots:
            tree = tree_by(recording, one, time_s)
            places = {(node.robot, node.serial): node.configuration[:2] for node in tree.nodes}
            pieces["edges", one] += [np.array([places[a], places[b]]) for a, b in tree.edges]
    if "paths" in layers:
        for motion in recording.of(Motion):
            driven = _until(course_of(motion), end_s)
            if motion.robot in robots and len(driven) > 1 and np.ptp(driven, axis=0).any():
                pieces["paths", motion.robot].append(driven)
    return tuple(
        Line(layer=layer, robot=one, pieces=MultiLineString(own))
        for (layer, one), own in sorted(pieces.items())
        if own
    )


def _until(course: FloatArray, end_s: float) -> FloatArray:
    """Return the places of a course up to a time, ``(n, 2)``."""
    times = course[:, 0]
    driven: FloatArray = course[times <= end_s, 1:3]
    if times[0] < end_s < times[-1]:
        last = [np.interp(end_s, times, course[:, axis]) for axis in (1, 2)]
        driven = np.vstack([driven, last])
    return driven
