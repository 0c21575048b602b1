"""Unions and differences of areas, as polygons of shapely.

Without a grid for the results, GEOS loses parts or holes now and then where borders coincide up to
rounding, as those of scans beside one wall do, and those of rotated buildings; it raises no error.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Final

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely.geometry.base import BaseGeometry

GRID_M: Final = 1e-9
"""Spacing in metres of the grid to which corners of a union are rounded."""


def union_on_grid(areas: Iterable[BaseGeometry]) -> BaseGeometry:
    """Return the union of areas whose borders may coincide up to rounding, as those of scans do.

    Corners are rounded to a grid of `GRID_M`.

    Parameters
    ----------
    areas : iterable of shapely geometries
        Polygons in metres, which may be invalid.

    Returns
    -------
    Polygon or MultiPolygon
        Empty if there is no area.

    Examples
    --------
    >>> near, far = (-0.08800000000000008, 8.38), (3.144, 8.717)
    >>> left = shapely.Polygon([(-1.1, 8.3), (-1.2, 7.2), near, far])
    >>> right = shapely.Polygon([(-1.1, 6.9), (-0.088, 8.38), far])
    >>> round(left.area, 3), round(right.area, 3), round(union_on_grid([left, right]).area, 3)
    (0.594, 2.221, 2.815)
    """
    valid = shapely.make_valid(
        np.array([*areas], np.object_), method="structure", keep_collapsed=False
    )
    return shapely.union_all(valid, grid_size=GRID_M)


def difference_of(area: BaseGeometry, others: Sequence[BaseGeometry]) -> BaseGeometry:
    """Return an area without some others.

    Corners stay as they are given, unless GEOS gets the result wrong: then they are rounded to a
    grid of `GRID_M`, or of a 1e-14th of the largest coordinate if that is more.

    Parameters
    ----------
    area : shapely geometry
        Valid polygons in metres.
    others : sequence of shapely geometries
        Valid polygons in metres, which may overlap.

    Returns
    -------
    shapely geometry
        What is left.

    Examples
    --------
    >>> hall, wall = shapely.box(0.0, 0.0, 4.0, 3.0), shapely.box(2.0, 0.0, 2.5, 2.0)
    >>> difference_of(hall, [wall]).area
    11.0
    """
    if not others:
        return area
    exact = area.difference(shapely.union_all(others))
    solid: NDArray[np.object_] = np.asarray(others, np.object_)
    apart = _apart_inside(area, solid)
    grid_m = max(GRID_M, 1e-14 * float(np.abs(shapely.bounds(area)).max()))
    rounded = _rounded_difference(area, solid[~apart], grid_m)
    # What lies apart takes away its own area.
    off_m2 = exact.area - (rounded.area - shapely.area(solid[apart]).sum())
    if abs(off_m2) <= grid_m * shapely.length([area, *others]).sum():
        return exact
    return _rounded_difference(rounded, solid[apart], grid_m)


def _apart_inside(area: BaseGeometry, others: NDArray[np.object_]) -> NDArray[np.bool_]:
    """Return which of some areas lie within another area and apart from each other."""
    met, _ = shapely.STRtree(others).query(others)
    alone: NDArray[np.bool_] = np.bincount(met, minlength=len(others)) == 1
    shapely.prepare(area)
    return alone & shapely.contains_properly(area, others)


def _rounded_difference(
    area: BaseGeometry, others: NDArray[np.object_], grid_m: float
) -> BaseGeometry:
    """Return an area without others; corners are rounded to a grid."""
    solid = shapely.union_all(others, grid_size=grid_m)
    return shapely.difference(area, solid, grid_size=grid_m)
