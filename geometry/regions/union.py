"""Unions of regions, as polygons of shapely."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Final

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

GRID_M: Final = 1e-9
"""Spacing in metres of the grid to which corners of a union are rounded."""


def union_of(areas: Iterable[BaseGeometry]) -> BaseGeometry:
    """Return the union of areas whose borders may coincide up to rounding, as those of scans do.

    Corners are rounded to a grid of `GRID_M`. Without one, GEOS loses parts or holes of such a
    union now and then, without an error: what is beyond a wall is then taken for free space.

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
    >>> round(left.area, 3), round(right.area, 3), round(union_of([left, right]).area, 3)
    (0.594, 2.221, 2.815)
    """
    valid = shapely.make_valid(
        np.array([*areas], np.object_), method="structure", keep_collapsed=False
    )
    return shapely.union_all(valid, grid_size=GRID_M)
