"""The room that a body has in a region: where it can be, and which ways it can go."""

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
"""A way that was found to be so long may come out shorter by this."""


class Room:
    """A region as a body of one size sees it; all is exact, without steps.

    Parameters
    ----------
    boundary : (n, 2) array
        The region's ring, or its rings as `rings_of` gives them.
    outline : (k, 2) array or float
        The body with what it keeps away from the boundary: its corners about the reference
        point, counter-clockwise, or the radius of a disc.
    """

    def __init__(self, boundary: FloatArray, outline: FloatArray | float) -> None:
        self.boundary = boundary
        self.outline = outline
        # A corner of each ring: of one that the body would hold as a whole, it would hold that.
        gaps = np.flatnonzero(np.isnan(boundary[:-1, 0]))
        self._corners = np.ascontiguousarray(boundary[gaps + 1])

    @property
    def bounds(self) -> tuple[float, float, float, float]:
        """Give the least x and y of the region, and the greatest."""
        low, high = np.nanmin(self.boundary, axis=0), np.nanmax(self.boundary, axis=0)
        return float(low[0]), float(low[1]), float(high[0]), float(high[1])

    def holds(self, at: Configuration) -> bool:
        """Whether the body can be at a configuration."""
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
        """Whether the body can follow a motion, given by its waypoints (time, x, y, heading)."""
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
        # On an arc the body turns as a whole about the arc's centre, which it does not hold.
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
    """Whether a body at a configuration covers any of some points."""
    c, s = math.cos(heading), math.sin(heading)
    for k in range(points.shape[0]):
        px, py = points[k, 0] - x, points[k, 1] - y
        if inside(outline, c * px + s * py, c * py - s * px):
            return True
    return False
