"""A body as its own planner sees it: what fits into a region of known free space."""

from __future__ import annotations

import math

import numpy as np
from shapely import Polygon

from multisrt.geometry.clearance import (
    disc_clearance,
    free_travel_disc,
    free_travel_disc_fan,
    free_travel_polygon,
    rotation_is_free,
)
from multisrt.geometry.configuration import Configuration
from multisrt.geometry.footprint import Footprint
from multisrt.geometry.kernel import FloatArray

TOUCH_M = 1e-7
"""A way that was driven before may touch the region's boundary by rounding."""


class PlanningBody:
    """A footprint with a safety margin around it.

    The margin is kept where the body has that much room; where it stands nearer to something,
    it may go on as near as it stands, but no nearer than its true outline.

    Parameters
    ----------
    footprint : Footprint
        The body.
    margin_m : float
        How far the planner stays away from the border of what it knows to be free.
    """

    def __init__(self, footprint: Footprint, margin_m: float) -> None:
        self.footprint = footprint
        self.margin_m = margin_m
        self.is_disc = footprint.is_disc
        self.outer_radius_m = footprint.circumscribed_radius_m
        # What every place that is chosen has at least, and what is asked for less than that of
        # a place that was: so a place once chosen can be left again.
        self._least_margin = margin_m / 5.0
        self.roomy_radius_m = self.outer_radius_m + margin_m / 10.0
        self.ample_radius_m = self.outer_radius_m + margin_m
        if not self.is_disc:
            outline = np.ascontiguousarray(footprint.planning_vertices)
            self._outline: FloatArray = outline
            self._wide = _offset(outline, margin_m)
            self._narrow = _offset(outline, -TOUCH_M)

    def travel(
        self,
        boundary: FloatArray,
        at: Configuration,
        direction: float,
        limit: float,
        *,
        known_way: bool = False,
    ) -> float:
        """How far the body can move in a direction, keeping its heading, inside a region.

        Parameters
        ----------
        boundary : (n, 2) array
            The region, which holds the body.
        at : Configuration
            Where the body is.
        direction : float
            Direction of the motion in radians.
        limit : float
            How far is asked for, in metres.
        known_way : bool
            The body has been this way before: no margin is kept.
        """
        x, y, heading = at
        cosine, sine = math.cos(direction), math.sin(direction)
        if self.is_disc:
            radius = self.outer_radius_m - TOUCH_M if known_way else self._kept(boundary, x, y)
            return free_travel_disc(boundary, x, y, cosine, sine, radius, limit)
        if known_way:
            return free_travel_polygon(boundary, self._narrow, x, y, heading, cosine, sine, limit)
        room = free_travel_polygon(boundary, self._wide, x, y, heading, cosine, sine, limit)
        if room > 0.0:
            return room
        return free_travel_polygon(boundary, self._outline, x, y, heading, cosine, sine, limit)

    def disc_fan(
        self, boundary: FloatArray, at: Configuration, directions: FloatArray, limit: float
    ) -> FloatArray:
        """Give `travel` of a disc for many directions at once."""
        x, y, _ = at
        radius = self._kept(boundary, x, y)
        return free_travel_disc_fan(boundary, x, y, directions, radius, limit)

    def disc_travel(self, boundary: FloatArray, x: float, y: float, tx: float, ty: float) -> bool:
        """Whether the body gets straight to a place in whatever heading: as a disc around it."""
        distance = math.hypot(tx - x, ty - y)
        if distance == 0.0:
            return True
        radius = self.roomy_radius_m
        travel = free_travel_disc(
            boundary, x, y, (tx - x) / distance, (ty - y) / distance, radius, distance
        )
        return travel >= distance

    def _kept(self, boundary: FloatArray, x: float, y: float) -> float:
        # The radius that a disc keeps free around it on a way from here.
        radius = self.outer_radius_m
        room = disc_clearance(boundary, x, y) - TOUCH_M
        least = min(radius + self._least_margin, max(radius, room))
        return max(least, min(radius + self.margin_m, room))

    def can_turn(self, boundary: FloatArray, at: Configuration, turn: float) -> bool:
        """Whether the body can turn in place by a signed angle inside a region."""
        if self.is_disc or turn == 0.0:
            return True
        x, y, heading = at
        if disc_clearance(boundary, x, y) >= self.outer_radius_m:
            return True
        return bool(rotation_is_free(boundary, self._narrow, x, y, heading, turn))


def _offset(outline: FloatArray, distance: float) -> FloatArray:
    ring = Polygon(outline).buffer(distance, join_style="mitre").exterior
    return np.ascontiguousarray(np.asarray(ring.normalize().coords)[:-1][::-1])
