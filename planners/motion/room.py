"""The configurations and motions of a body that stay inside a region."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from multisrt.geometry.bodies.clearance import disc_clearance, path_clearance
from multisrt.geometry.bodies.fitting import pose_is_inside, rotation_is_free
from multisrt.geometry.bodies.free_travel import free_travel_polygon
from multisrt.geometry.configuration import Configuration
from multisrt.geometry.numerics.distances import inside
from multisrt.geometry.numerics.kernel import FloatArray, kernel
from multisrt.planners.motion.trajectory import NO_TURN_RAD

ROUNDING_M = 1e-9
"""Tolerance for a travel distance that is computed twice, in metres."""


class Room:
    """A region in which a body moves; all tests are exact along the whole motion.

    Parameters
    ----------
    boundary : (n, 2) array
        The region's ring in metres, or its rings separated by NaN as `rings_of` returns them.
    outline : (k, 2) array or float
        The body including its margin: corners about the reference point in metres,
        counter-clockwise, or the radius of a disc.

    Examples
    --------
    >>> square = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]])
    >>> room = Room(square, 0.5)
    >>> room.holds(Configuration(3.5, 2.0, 0.0)), room.holds(Configuration(3.6, 2.0, 0.0))
    (True, False)
    >>> room.lets_pass([(0.0, 1.0, 1.0, 0.0), (1.0, 3.0, 1.0, 0.0)])
    True
    """

    def __init__(self, boundary: FloatArray, outline: FloatArray | float) -> None:
        self.boundary = boundary
        self.outline = outline
        # One corner of each ring: a body that covers a whole ring covers that corner.
        gaps = np.flatnonzero(np.isnan(boundary[:-1, 0]))
        self._corners = np.ascontiguousarray(boundary[gaps + 1])

    @property
    def bounds(self) -> tuple[float, float, float, float]:
        """Bounds of the region: minimum x and y, maximum x and y in metres."""
        low, high = np.nanmin(self.boundary, axis=0), np.nanmax(self.boundary, axis=0)
        return float(low[0]), float(low[1]), float(high[0]), float(high[1])

    def holds(self, at: Configuration) -> bool:
        """Whether the body at a configuration is inside the region."""
        if isinstance(self.outline, float):
            return (
                bool(inside(self.boundary, at.x, at.y))
                and disc_clearance(self.boundary, at.x, at.y) >= self.outline
            )
        return bool(
            pose_is_inside(self.boundary, self.outline, *at)
            and not _covers_any(self.outline, *at, self._corners)
        )

    def lets_pass(self, waypoints: Sequence[Sequence[float]]) -> bool:
        """Whether the body stays inside the region during a motion.

        Parameters
        ----------
        waypoints : sequence of (time, x, y, heading)
            Waypoints of the motion, as in `Trajectory`.

        Returns
        -------
        bool
        """
        if not self.holds(Configuration(*waypoints[0][1:])):
            return False
        if not self.holds(Configuration(*waypoints[-1][1:])):
            return False
        return all(self._leg_is_free(a, b) for a, b in pairwise(waypoints))

    def _leg_is_free(self, a: Sequence[float], b: Sequence[float]) -> bool:
        _, x, y, heading = a
        dx, dy, turn = b[1] - x, b[2] - y, b[3] - heading
        distance = math.hypot(dx, dy)
        if abs(turn) < NO_TURN_RAD:
            turn = 0.0
        if isinstance(self.outline, float):
            if distance == 0.0:
                return self.holds(Configuration(x, y, heading))
            return bool(path_clearance(self.boundary, x, y, dx, dy, turn) >= self.outline)
        if turn == 0.0:
            if distance == 0.0:
                return True
            ux, uy = dx / distance, dy / distance
            travel = free_travel_polygon(
                self.boundary, self.outline, x, y, heading, ux, uy, distance
            )
            return bool(travel >= distance - ROUNDING_M)
        # On an arc the body rotates about the arc's centre.
        outline, cx, cy = self.outline, x, y
        if distance > 0.0:
            away = 0.5 / math.tan(0.5 * turn)
            ox, oy = 0.5 * -dx + away * dy, 0.5 * -dy - away * dx
            cx, cy = x - ox, y - oy
            c, s = math.cos(heading), math.sin(heading)
            outline = outline + np.array([c * ox + s * oy, c * oy - s * ox])
        return bool(rotation_is_free(self.boundary, outline, cx, cy, heading, turn))


@kernel
def _covers_any(
    outline: FloatArray, x: float, y: float, heading: float, points: FloatArray
) -> bool:
    """Whether a body at a configuration covers any of the points."""
    c, s = math.cos(heading), math.sin(heading)
    for k in range(points.shape[0]):
        px, py = points[k, 0] - x, points[k, 1] - y
        if inside(outline, c * px + s * py, c * py - s * px):
            return True
    return False
