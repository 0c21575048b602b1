"""The union of many regions around a place, for bodies that move in it.

The union itself is not computed. A disc is inside it if its centre is in one of the regions and
no piece of the union's border is nearer than its radius; that border consists of the pieces of
the regions' borders that lie in none of the others.
"""

from __future__ import annotations

import math

import numpy as np

from multisrt.geometry.numerics.distances import inside
from multisrt.geometry.numerics.kernel import BoolArray, FloatArray, IntArray, kernel
from multisrt.geometry.numerics.rings import RingArrays, Rings, corners_of
from multisrt.geometry.numerics.segments import cross_each_other, squared_distance
from multisrt.geometry.regions.union_border import UnionBorder


class KnownSpace:
    """The union of regions in a window; beyond the window nothing is known.

    Parameters
    ----------
    rings : Rings
        The boundaries of the regions.
    indices : (k,) array of int
        The regions to unite: all that have a part in the window.
    window : tuple of float
        x0, y0, x1, y1 in metres.
    border : UnionBorder, optional
        The border of the union of all rings, as far as computed before.

    Attributes
    ----------
    border : (b, 4) array
        Segments x0, y0, x1, y1 in metres: the border of the union, and that of the window. There
        is none between regions that end at one line from both sides, or that leave a crack of
        rounding. Pieces shorter than 0.1 mm may be missing.

    Examples
    --------
    Two rooms of 2 x 2 m side by side:

    >>> import numpy as np
    >>> from multisrt.geometry.numerics.rings import Rings
    >>> room = np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]])
    >>> rings = Rings([room, room + [2.0, 0.0]])
    >>> known = KnownSpace(rings, np.array([0, 1]), (-9.0, -9.0, 9.0, 9.0))
    >>> known.holds(np.array([[1.0, 1.0], [5.0, 1.0]])).tolist()
    [True, False]
    >>> known.clearances(np.array([[2.0, 1.5]]), 3.0).tolist()
    [0.5]
    >>> known.passes(np.array([[1.0, 1.0, 3.0, 1.0]]), 0.9).tolist()
    [True]
    """

    def __init__(
        self,
        rings: Rings,
        indices: IntArray,
        window: tuple[float, float, float, float],
        border: UnionBorder | None = None,
    ) -> None:
        self._rings = rings
        self._indices = indices
        self._window = window
        border = UnionBorder(rings) if border is None else border
        x0, y0, x1, y1 = window
        frame = np.array([[x0, y0, x1, y0], [x1, y0, x1, y1], [x1, y1, x0, y1], [x0, y1, x0, y0]])
        self.border: FloatArray = np.concatenate((border.within(indices, window), frame))

    def holds(self, places: FloatArray) -> BoolArray:
        """Return which places, ``(n, 2)`` in metres, lie inside the union and the window."""
        rings = self._rings.arrays(self._indices)
        found: BoolArray = _holds(places, self._window, self._indices, rings)
        return found

    def clearances(self, places: FloatArray, at_most_m: float) -> FloatArray:
        """Return the distances of places from the border, cut off at a limit.

        Parameters
        ----------
        places : (n, 2) array
            x and y in metres.
        at_most_m : float
            Maximum distance in metres that is returned.

        Returns
        -------
        (n,) array
            In metres.
        """
        found: FloatArray = _clearances(places, at_most_m, self.border)
        return found

    def passes(self, paths: FloatArray, radius_m: float) -> BoolArray:
        """Return along which straight paths a disc stays inside, if it is inside at their start.

        Parameters
        ----------
        paths : (n, 4) array
            x0, y0, x1, y1 in metres, each from x0, y0.
        radius_m : float
            Radius of the disc in metres.

        Returns
        -------
        (n,) array of bool
            Whether no piece of the border is nearer to the path than the radius.
        """
        found: BoolArray = _passes(paths, radius_m, self.border)
        return found

    def sees(self, x: float, y: float, places: FloatArray) -> BoolArray:
        """Return which places are in sight of a place.

        Parameters
        ----------
        x, y : float
            The place in metres, inside the union.
        places : (n, 2) array
            Places in metres, inside the union.

        Returns
        -------
        (n,) array of bool
            Whether the segment between them neither crosses nor touches the border.
        """
        found: BoolArray = _sees(x, y, places, self.border)
        return found


@kernel
def _holds(
    places: FloatArray,
    window: tuple[float, float, float, float],
    indices: IntArray,
    rings: RingArrays,
) -> BoolArray:
    boxes = rings.boxes
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
                and inside(corners_of(rings, k), x, y)
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
def _passes(paths: FloatArray, radius: float, border: FloatArray) -> BoolArray:
    passes = np.ones(paths.shape[0], np.bool_)
    for i in range(paths.shape[0]):
        x, y = paths[i, 0], paths[i, 1]
        dx, dy = paths[i, 2] - x, paths[i, 3] - y
        left, right = min(0.0, dx) - radius, max(0.0, dx) + radius
        low, high = min(0.0, dy) - radius, max(0.0, dy) + radius
        for b in range(border.shape[0]):
            ax, ay, bx, by = border[b, 0] - x, border[b, 1] - y, border[b, 2] - x, border[b, 3] - y
            if (
                max(ax, bx) > left
                and min(ax, bx) < right
                and max(ay, by) > low
                and min(ay, by) < high
                and _distance_to_path(ax, ay, bx, by, dx, dy) < radius
            ):
                passes[i] = False
                break
    return passes


@kernel
def _distance_to_path(ax: float, ay: float, bx: float, by: float, dx: float, dy: float) -> float:
    # Distance from segment a-b to the one from the origin to d.
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
    # Pieces of the border in the order of their distance: what lies behind a place hides nothing.
    away = np.empty(border.shape[0])
    for b in range(border.shape[0]):
        away[b] = squared_distance(
            border[b, 0] - x, border[b, 1] - y, border[b, 2] - x, border[b, 3] - y
        )
    order = np.argsort(away)
    sees = np.ones(places.shape[0], np.bool_)
    for i in range(places.shape[0]):
        dx, dy = places[i, 0] - x, places[i, 1] - y
        left, right, low, high = min(0.0, dx), max(0.0, dx), min(0.0, dy), max(0.0, dy)
        reach = (1.0 + 1e-9) * (dx * dx + dy * dy)
        for b in order:
            if away[b] > reach:
                break
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
