"""Line segments: distance from the origin, and crossings."""

from multisrt.geometry.numerics.kernel import kernel


@kernel
def squared_distance(ax: float, ay: float, bx: float, by: float) -> float:
    """Return the squared distance from the origin to the segment from a to b.

    Examples
    --------
    >>> squared_distance(3.0, -1.0, 3.0, 1.0)
    9.0
    """
    ex, ey = bx - ax, by - ay
    along = -(ax * ex + ay * ey)
    if along > 0.0:
        squared = ex * ex + ey * ey
        if along < squared:
            area = ax * by - ay * bx
            return area * area / squared
        return bx * bx + by * by
    return ax * ax + ay * ay


@kernel
def cross_each_other(
    ax: float, ay: float, bx: float, by: float, ux: float, uy: float, vx: float, vy: float
) -> bool:
    """Whether segments a-b and u-v cross.

    Of the two ends of each segment one belongs to it and the other does not, so that a line
    through a corner where two segments meet crosses exactly one of them. Parallel segments never
    cross.

    Examples
    --------
    >>> cross_each_other(0.0, 0.0, 2.0, 0.0, 1.0, -1.0, 1.0, 1.0)
    True
    >>> cross_each_other(0.0, 0.0, 2.0, 0.0, 3.0, -1.0, 3.0, 1.0)
    False
    """
    ex, ey = bx - ax, by - ay
    u_is_left = ex * (uy - ay) - ey * (ux - ax) > 0.0
    v_is_left = ex * (vy - ay) - ey * (vx - ax) > 0.0
    if u_is_left == v_is_left:
        return False
    ex, ey = vx - ux, vy - uy
    return (ex * (ay - uy) - ey * (ax - ux) > 0.0) != (ex * (by - uy) - ey * (bx - ux) > 0.0)
