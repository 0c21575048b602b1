"""The union of many regions around a place, for bodies that move in it.

The union is never made: a body is inside if its middle is in one of the regions and it keeps off
the union's border, which is what of the regions' borders lies in none of the others.
"""

from __future__ import annotations

import math

import numpy as np

from multisrt.geometry.numerics.distances import inside
from multisrt.geometry.numerics.kernel import BoolArray, FloatArray, IntArray, kernel
from multisrt.geometry.numerics.rings import Rings
from multisrt.geometry.numerics.segments import cross_each_other, squared_distance
from multisrt.geometry.regions.frontier_arcs import uncovered


class KnownSpace:
    """The union of regions in a window; beyond the window nothing is known.

    Parameters
    ----------
    rings : Rings
        The regions' borders.
    indices : (k,) array of int
        Which of them are united: all that have a part in the window.
    window : tuple of float
        x0, y0, x1, y1.

    Attributes
    ----------
    border : (b, 4) array
        Segments x0, y0, x1, y1: the union's border, and that of the window. Regions that end at
        one line from both sides have none between them, nor have those that leave a crack of
        rounding. Pieces shorter than 0.1 mm may be missing.
    """

    def __init__(
        self, rings: Rings, indices: IntArray, window: tuple[float, float, float, float]
    ) -> None:
        self._rings = rings
        self._indices = indices
        self._window = window
        self.border = _border(indices, window, *rings.arrays)

    def holds(self, places: FloatArray) -> BoolArray:
        """Tell which places, ``(n, 2)``, lie inside, and in the window."""
        found: BoolArray = _holds(places, self._window, self._indices, *self._rings.arrays[:3])
        return found

    def clearances(self, places: FloatArray, at_most_m: float) -> FloatArray:
        """Give how far places, ``(n, 2)``, are from the border, or `at_most_m` if they are more."""
        found: FloatArray = _clearances(places, at_most_m, self.border)
        return found

    def passes(self, ways: FloatArray, radius_m: float) -> BoolArray:
        """Tell along which straight ways a disc stays inside that does so where they begin.

        Parameters
        ----------
        ways : (n, 4) array
            Each from x0, y0 to x1, y1.
        radius_m : float
            The disc's.
        """
        found: BoolArray = _passes(ways, radius_m, self.border)
        return found

    def sees(self, x: float, y: float, places: FloatArray) -> BoolArray:
        """Tell which places, ``(n, 2)``, are in sight of one that lies inside, and so do they.

        A line of sight that touches the border is none.
        """
        found: BoolArray = _sees(x, y, places, self.border)
        return found


@kernel
def _border(
    indices: IntArray,
    window: tuple[float, float, float, float],
    starts: IntArray,
    corners: FloatArray,
    boxes: FloatArray,
    stretches: FloatArray,
) -> FloatArray:
    x0, y0, x1, y1 = window
    total = 0
    for k in indices:
        total += starts[k + 1] - starts[k]
    edges = np.empty((total, 4))
    count = 0
    for k in indices:
        px, py = corners[starts[k + 1] - 1]
        for c in range(starts[k], starts[k + 1]):
            qx, qy = corners[c]
            if max(px, qx) >= x0 and min(px, qx) <= x1 and max(py, qy) >= y0 and min(py, qy) <= y1:
                edges[count, 0], edges[count, 1], edges[count, 2], edges[count, 3] = px, py, qx, qy
                count += 1
            px, py = qx, qy
    rest, _ = uncovered(edges[:count], starts, corners, boxes, stretches, indices)
    frame = np.array([[x0, y0, x1, y0], [x1, y0, x1, y1], [x1, y1, x0, y1], [x0, y1, x0, y0]])
    return np.concatenate((rest, frame))


@kernel
def _holds(
    places: FloatArray,
    window: tuple[float, float, float, float],
    indices: IntArray,
    starts: IntArray,
    corners: FloatArray,
    boxes: FloatArray,
) -> BoolArray:
    x0, y0, x1, y1 = window
    holds = np.zeros(places.shape[0], np.bool_)
    for i in range(places.shape[0]):
        x, y = places[i, 0], places[i, 1]
        if not (x0 < x < x1 and y0 < y < y1):
            continue
        for k in indices:
            if (
                boxes[k, 0] <= x <= boxes[k, 2]
                and boxes[k, 1] <= y <= boxes[k, 3]
                and inside(corners[starts[k] : starts[k + 1]], x, y)
            ):
                holds[i] = True
                break
    return holds


@kernel
def _clearances(places: FloatArray, at_most: float, border: FloatArray) -> FloatArray:
    clearances = np.empty(places.shape[0])
    for i in range(places.shape[0]):
        x, y = places[i, 0], places[i, 1]
        nearest = at_most
        for b in range(border.shape[0]):
            ax, ay, bx, by = border[b, 0] - x, border[b, 1] - y, border[b, 2] - x, border[b, 3] - y
            if (
                max(ax, bx) > -nearest
                and min(ax, bx) < nearest
                and max(ay, by) > -nearest
                and min(ay, by) < nearest
            ):
                nearest = min(nearest, math.sqrt(squared_distance(ax, ay, bx, by)))
        clearances[i] = nearest
    return clearances


@kernel
def _passes(ways: FloatArray, radius: float, border: FloatArray) -> BoolArray:
    passes = np.ones(ways.shape[0], np.bool_)
    for i in range(ways.shape[0]):
        x, y = ways[i, 0], ways[i, 1]
        dx, dy = ways[i, 2] - x, ways[i, 3] - y
        left, right = min(0.0, dx) - radius, max(0.0, dx) + radius
        low, high = min(0.0, dy) - radius, max(0.0, dy) + radius
        for b in range(border.shape[0]):
            ax, ay, bx, by = border[b, 0] - x, border[b, 1] - y, border[b, 2] - x, border[b, 3] - y
            if (
                max(ax, bx) > left
                and min(ax, bx) < right
                and max(ay, by) > low
                and min(ay, by) < high
                and _distance_to_way(ax, ay, bx, by, dx, dy) < radius
            ):
                passes[i] = False
                break
    return passes


@kernel
def _distance_to_way(ax: float, ay: float, bx: float, by: float, dx: float, dy: float) -> float:
    # From segment a-b to the one from the origin to d.
    if cross_each_other(ax, ay, bx, by, 0.0, 0.0, dx, dy):
        return 0.0
    nearest = min(
        squared_distance(ax, ay, bx, by), squared_distance(ax - dx, ay - dy, bx - dx, by - dy)
    )
    nearest = min(nearest, squared_distance(-ax, -ay, dx - ax, dy - ay))
    nearest = min(nearest, squared_distance(-bx, -by, dx - bx, dy - by))
    return math.sqrt(nearest)


@kernel
def _sees(x: float, y: float, places: FloatArray, border: FloatArray) -> BoolArray:
    sees = np.ones(places.shape[0], np.bool_)
    for i in range(places.shape[0]):
        dx, dy = places[i, 0] - x, places[i, 1] - y
        left, right, low, high = min(0.0, dx), max(0.0, dx), min(0.0, dy), max(0.0, dy)
        for b in range(border.shape[0]):
            ax, ay, bx, by = border[b, 0] - x, border[b, 1] - y, border[b, 2] - x, border[b, 3] - y
            if max(ax, bx) < left or min(ax, bx) > right or max(ay, by) < low or min(ay, by) > high:
                continue
            # Both ends of each lie on different sides of the other, or on it.
            side_a, side_b = dx * ay - dy * ax, dx * by - dy * bx
            if side_a * side_b > 0.0:
                continue
            ex, ey = bx - ax, by - ay
            if (ex * ay - ey * ax) * (ex * (ay - dy) - ey * (ax - dx)) <= 0.0:
                sees[i] = False
                break
    return sees
