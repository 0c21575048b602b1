"""The map of each robot in the course of a run: what it made, and what it learned of others."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import shapely
from shapely.geometry.base import BaseGeometry

from multisrt.analysis.scans import scanned_regions
from multisrt.environments.environment import Environment
from multisrt.events import Learned, NodeAdded, NodeName, Sensed
from multisrt.geometry.numerics.kernel import FloatArray
from multisrt.geometry.regions.overlay import GRID_M, union_on_grid
from multisrt.recording import Recording


class KnownRegion(NamedTuple):
    """A region on the map of a robot.

    Attributes
    ----------
    time_s : float
        Since when it knows the region, in seconds.
    maker : int
        The robot that took the scan.
    corners : (n, 2) array
        Corners of the region in metres, not closed.
    """

    time_s: float
    maker: int
    corners: FloatArray


def known_regions(
    recording: Recording, environment: Environment | None = None
) -> list[list[KnownRegion]]:
    """Return the regions on the map of each robot, in the order in which it came to know them.

    A robot knows the regions of the nodes that it made (`NodeAdded`) and of those that it learned
    of (`Learned`), as it says itself. A robot that notes no node knows what its own scans showed.

    Parameters
    ----------
    recording : Recording
        The run.
    environment : Environment, optional
        The world, if it has been built already; it is needed only for robots that note no node.

    Returns
    -------
    list of list of KnownRegion
        One list for each robot, by time; no region twice.

    Examples
    --------
    >>> import multisrt as ms
    >>> run = ms.explore("open", robots=2, seed=1, max_time_s=10.0)
    >>> known = known_regions(run.recording)
    >>> sorted({region.maker for region in known[0]})
    [0, 1]
    """
    known: list[dict[NodeName, KnownRegion]] = [{} for _ in recording.spec.robots]
    nodes: dict[NodeName, NodeAdded] = {}
    for event in recording.events:
        match event:
            case NodeAdded():
                name = event.robot, event.serial
                nodes[name] = event
                own = KnownRegion(event.time_s, event.robot, recording.region(event))
                known[event.robot].setdefault(name, own)
            case Learned():
                for name in event.nodes:
                    region = KnownRegion(event.time_s, name[0], recording.region(nodes[name]))
                    known[event.robot].setdefault(name, region)
    found = [list(regions.values()) for regions in known]
    with_nodes = {node.robot for node in nodes.values()}
    if len(with_nodes) < len(found) and recording.of(Sensed):
        shown = scanned_regions(recording, environment or recording.environment())
        for scan, corners in zip(recording.of(Sensed), shown, strict=True):
            if scan.robot not in with_nodes and len(corners):
                found[scan.robot].append(KnownRegion(scan.time_s, scan.robot, corners))
    return found


def areas_known(
    regions: Sequence[KnownRegion], times_s: Sequence[float], environment: Environment
) -> list[dict[int, shapely.MultiPolygon]]:
    """Return the free space that a robot knows at some times, by the robot that saw it.

    Parameters
    ----------
    regions : sequence of KnownRegion
        All regions that come to be on its map, by time.
    times_s : sequence of float
        The times in seconds, ascending.
    environment : Environment
        The world.

    Returns
    -------
    list of dict from int to MultiPolygon
        One for each time, in the order of the robots. The areas of several robots may overlap.
    """
    known: dict[int, BaseGeometry] = {}
    found = []
    begin = -math.inf
    for time_s in times_s:
        for maker in sorted({region.maker for region in regions}):
            new = [
                shapely.Polygon(region.corners)
                for region in regions
                if region.maker == maker and begin < region.time_s <= time_s
            ]
            if new:
                before = known.get(maker, shapely.MultiPolygon())
                known[maker] = union_on_grid([before, *new])
        begin = time_s
        found.append(
            {
                maker: polygons_of(
                    shapely.intersection(known[maker], environment.free, grid_size=GRID_M)
                )
                for maker in sorted(known)
            }
        )
    return found


def polygons_of(area: BaseGeometry) -> shapely.MultiPolygon:
    """Return the polygons of a shape, without its points and lines."""
    parts = shapely.get_parts(area)
    return shapely.MultiPolygon([part for part in parts if part.geom_type == "Polygon"])
