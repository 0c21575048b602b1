"""Axis-aligned boxes ``(x0, y0, x1, y1)``: bounds of points, and intersection queries."""

from __future__ import annotations

from multisrt.geometry.numerics.arrays import FloatArray, IntArray
from multisrt.geometry.numerics.kernel import kernel


@kernel
def bounds_of(boundary: FloatArray) -> tuple[float, float, float, float]:
    """Return the smallest box ``(x0, y0, x1, y1)`` around points.

    Parameters
    ----------
    boundary : (n, 2) array
        The points, at least one.

    Examples
    --------
    >>> import numpy as np
    >>> bounds_of(np.array([(0.0, 3.0), (2.0, 1.0)]))
    (0.0, 1.0, 2.0, 3.0)
    """
    x0 = x1 = boundary[0, 0]
    y0 = y1 = boundary[0, 1]
    for i in range(1, boundary.shape[0]):
        x0, x1 = min(x0, boundary[i, 0]), max(x1, boundary[i, 0])
        y0, y1 = min(y0, boundary[i, 1]), max(y1, boundary[i, 1])
    return x0, y0, x1, y1


@kernel
def all_below(points: FloatArray, limit: float) -> bool:
    """Whether all coordinates of ``(n, 2)`` points are of smaller magnitude than a limit.

    False for points with NaN, true for no points.
    """
    for i in range(points.shape[0]):
        if not (abs(points[i, 0]) < limit and abs(points[i, 1]) < limit):
            return False
    return True


@kernel
def intersecting_boxes(
    boxes: FloatArray,
    slacks: FloatArray,
    box: tuple[float, float, float, float],
    found: IntArray,
) -> int:
    """Find the boxes that intersect one, borders included.

    Parameters
    ----------
    boxes : (n, 4) array
        The boxes to search.
    slacks : (n,) array
        Length by which each of them is extended on all sides; it may be negative.
    box : (x0, y0, x1, y1)
        The one box.
    found : (n,) array of int
        Memory for the indices of the boxes found, written in ascending order.

    Returns
    -------
    int
        Number of boxes found.

    Examples
    --------
    >>> import numpy as np
    >>> boxes = np.array([(0.0, 0.0, 1.0, 1.0), (5.0, 5.0, 6.0, 6.0), (2.5, 0.0, 3.0, 1.0)])
    >>> found = np.empty(3, np.int64)
    >>> count = intersecting_boxes(boxes, np.full(3, 0.5), (1.0, 0.0, 2.0, 1.0), found)
    >>> found[:count].tolist()
    [0, 2]
    """
    x0, y0, x1, y1 = box
    count = 0
    for k in range(boxes.shape[0]):
        slack = slacks[k]
        if (
            boxes[k, 0] <= x1 + slack
            and boxes[k, 2] >= x0 - slack
            and boxes[k, 1] <= y1 + slack
            and boxes[k, 3] >= y0 - slack
        ):
            found[count] = k
            count += 1
    return count
