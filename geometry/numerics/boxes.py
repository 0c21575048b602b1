"""Axis-parallel boxes ``(x0, y0, x1, y1)``: which of many meet one."""

from __future__ import annotations

from multisrt.geometry.numerics.kernel import FloatArray, IntArray, kernel


@kernel
def bounds_of(boundary: FloatArray) -> tuple[float, float, float, float]:
    """Give the least x, least y, greatest x and greatest y of some points."""
    x0 = x1 = boundary[0, 0]
    y0 = y1 = boundary[0, 1]
    for i in range(1, boundary.shape[0]):
        x0, x1 = min(x0, boundary[i, 0]), max(x1, boundary[i, 0])
        y0, y1 = min(y0, boundary[i, 1]), max(y1, boundary[i, 1])
    return x0, y0, x1, y1


@kernel
def all_below(points: FloatArray, limit: float) -> bool:
    """Tell whether all coordinates of some points are numbers between minus and plus a limit."""
    for i in range(points.shape[0]):
        if not (abs(points[i, 0]) < limit and abs(points[i, 1]) < limit):
            return False
    return True


@kernel
def boxes_meeting(
    boxes: FloatArray,
    slacks: FloatArray,
    box: tuple[float, float, float, float],
    found: IntArray,
) -> int:
    """Find the boxes that have something in common with one, borders included.

    Parameters
    ----------
    boxes : (n, 4) array
        Which are asked.
    slacks : (n,) array
        By how much each is widened on all sides.
    box : (x0, y0, x1, y1)
        The one.
    found : (n,) array of int
        Where their indices are written, rising.

    Returns
    -------
    int
        How many they are.
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
