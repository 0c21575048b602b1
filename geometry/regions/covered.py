"""What a body covers is free, although no beam of its laser may show it."""

from __future__ import annotations

import numpy as np
import shapely

from multisrt.geometry.numerics.distances import distance_to_segments
from multisrt.geometry.numerics.kernel import FloatArray
from multisrt.geometry.regions.boundary import TagArray


def with_covered(
    place: tuple[float, float], boundary: FloatArray, tags: TagArray, covered: FloatArray
) -> tuple[FloatArray, TagArray]:
    """Return the boundary of a region together with what a body covers.

    Parameters
    ----------
    place : (x, y)
        Where the scan was taken, in metres.
    boundary : (n, 2) array
        Corners of the region in metres, counter-clockwise, star-shaped about the place.
    tags : (n,) array of int8
        Why it ends at the piece from corner i to corner i + 1.
    covered : (k, 2) array
        Corners of the body in metres, star-shaped about the place.

    Returns
    -------
    boundary, tags
        Of the union, which is star-shaped as well. A piece of the body's outline has the tag of
        the piece of the region that is nearest to its middle.

    Notes
    -----
    A region from beams ends before a wall by a share of the distance, and may end inside a body
    that stands right beside the wall. That body could not leave its place, as motions are planned
    in what is known to be free. Costmaps of mobile robots clear the footprint for the same reason.
    """
    ends = np.stack([boundary, np.roll(boundary, -1, axis=0)], axis=1)
    clear_m = distance_to_segments(np.array([place]), ends.reshape(-1, 4))[0]
    if clear_m >= np.hypot(*(covered - place).T).max():
        return boundary, tags
    region, body = shapely.Polygon(boundary), shapely.Polygon(covered)
    if region.covers(body):
        return boundary, tags
    union = shapely.orient_polygons(shapely.union(region, body))
    ring = shapely.get_coordinates(shapely.get_exterior_ring(union))
    pieces = np.asarray(shapely.linestrings(ends))
    middles = shapely.points(0.5 * (ring[:-1] + ring[1:]))
    return ring[:-1].copy(), tags[shapely.STRtree(pieces).nearest(middles)]
