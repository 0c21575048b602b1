"""What a body covers is free, although no beam of its laser may show it."""

from __future__ import annotations

import numpy as np
import shapely

from multisrt.geometry.numerics import libm
from multisrt.geometry.numerics.distances import distance_to_segments
from multisrt.geometry.numerics.kernel import FloatArray
from multisrt.geometry.regions.boundary import TagArray
from multisrt.geometry.regions.scan import LaserScan, beam_spacing_rad


def with_covered(
    scan: LaserScan, boundary: FloatArray, tags: TagArray
) -> tuple[FloatArray, TagArray]:
    """Return the boundary of the union of a region and what the body around a laser covers.

    Parameters
    ----------
    scan : LaserScan
        What the laser measured.
    boundary : (n, 2) array
        Corners of its region in metres, counter-clockwise, star-shaped about the place of the scan.
    tags : (n,) array of int8
        Why it ends at the piece from corner i to corner i + 1.

    Returns
    -------
    boundary, tags
        Of the union, which is star-shaped as well. A piece of the body's outline has the tag of
        the piece of the region that is nearest to its middle. The region itself if the body is not
        known, or if a reading ends inside it, so that it cannot be as large as it is said to be.

    Notes
    -----
    A region from beams ends before a wall by a share of the distance, and may end inside a body
    that stands right beside the wall. That body could not leave its place, as motions are planned
    in what is known to be free. Costmaps of mobile robots clear the footprint for the same reason.
    """
    if scan.covered is None:
        return boundary, tags
    place = scan.configuration[:2]
    ends = np.stack([boundary, np.roll(boundary, -1, axis=0)], axis=1)
    clear_m = distance_to_segments(np.array([place]), ends.reshape(-1, 4))[0]
    if clear_m >= np.hypot(*(scan.covered - place).T).max():
        return boundary, tags
    region, body = shapely.Polygon(boundary), shapely.Polygon(scan.covered)
    if region.covers(body) or shapely.contains_xy(body, _ends_of_beams(scan)).any():
        return boundary, tags
    union = shapely.orient_polygons(shapely.union(region, body))
    ring = shapely.get_coordinates(shapely.get_exterior_ring(union))
    pieces = np.asarray(shapely.linestrings(ends))
    middles = shapely.points(0.5 * (ring[:-1] + ring[1:]))
    return ring[:-1].copy(), tags[shapely.STRtree(pieces).nearest(middles)]


def _ends_of_beams(scan: LaserScan) -> FloatArray:
    x, y, _ = scan.configuration
    ranges = np.where(np.isfinite(scan.ranges), scan.ranges, scan.range_m)
    angles = beam_spacing_rad(scan) * np.arange(len(ranges))
    return np.column_stack([x + ranges * libm.cos(angles), y + ranges * libm.sin(angles)])
