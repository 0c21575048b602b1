"""A body as its own planner sees it: what fits into a region of known free space."""

from __future__ import annotations

import math

import numpy as np
from shapely import Polygon

from multisrt.geometry.bodies.clearance import disc_clearance
from multisrt.geometry.bodies.fitting import rotation_is_free
from multisrt.geometry.bodies.footprint import Footprint
from multisrt.geometry.bodies.free_travel import (
    disc_bridges,
    free_travel_disc,
    free_travel_disc_fan,
    free_travel_polygon,
)
from multisrt.geometry.configuration import Configuration
from multisrt.geometry.numerics.kernel import BoolArray, FloatArray, IntArray
from multisrt.geometry.numerics.rings import Rings
from multisrt.planners.motion.room import ROUNDING_M, Room

TOUCH_M = 1e-7
"""How near a body may come to what it stands next to already."""

HAIR_M = 5e-4
"""The least margin: touching counts as a collision."""

NO_TURN_RAD = 1e-9
"""Smaller turns are rounding."""


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
        margin_m = max(margin_m, HAIR_M)
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
            # With the whole margin, less of it, and hardly any, to be tried in this order.
            self._grown = [
                _offset(outline, margin)
                for margin in (margin_m, margin_m / 2.0, self._least_margin, HAIR_M)
            ]

    def travel(
        self,
        boundary: FloatArray,
        at: Configuration,
        direction: float,
        limit: float,
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
        """
        x, y, heading = at
        cosine, sine = math.cos(direction), math.sin(direction)
        if self.is_disc:
            radius = self._kept(boundary, x, y)
            return free_travel_disc(boundary, x, y, cosine, sine, radius, limit)
        for outline in self._grown:
            room = free_travel_polygon(boundary, outline, x, y, heading, cosine, sine, limit)
            if room > 0.0:
                break
        if room < limit and outline is self._grown[-1]:
            room = max(0.0, room - self._least_margin)
        return room

    def passes(
        self, boundary: FloatArray, at: Configuration, direction: float, distance: float
    ) -> bool:
        """Whether a way is free that `travel` found, also if it is turned by rounding.

        It is asked with the least margin: how much of it `travel` kept is not known any more.
        """
        x, y, heading = at
        cosine, sine = math.cos(direction), math.sin(direction)
        if self.is_disc:
            travel = self.travel(boundary, at, direction, distance)
        else:
            travel = free_travel_polygon(
                boundary, self._grown[-1], x, y, heading, cosine, sine, distance
            )
        return travel >= distance - ROUNDING_M

    def disc_fan(
        self, boundary: FloatArray, at: Configuration, directions: FloatArray, limit: float
    ) -> FloatArray:
        """Give `travel` of a disc for many directions at once."""
        x, y, _ = at
        radius = self._kept(boundary, x, y)
        return free_travel_disc_fan(boundary, x, y, directions, radius, limit)

    def disc_travel(self, boundary: FloatArray, x: float, y: float, tx: float, ty: float) -> bool:
        """Whether the body gets straight to a place in whatever heading: as a disc around it."""
        return self.disc_reach(boundary, x, y, tx, ty) >= math.hypot(tx - x, ty - y)

    def disc_reach(self, boundary: FloatArray, x: float, y: float, tx: float, ty: float) -> float:
        """How far the body gets straight towards a place in whatever heading."""
        distance = math.hypot(tx - x, ty - y)
        if distance == 0.0:
            return 0.0
        radius = self.roomy_radius_m
        return free_travel_disc(
            boundary, x, y, (tx - x) / distance, (ty - y) / distance, radius, distance
        )

    def bridges(self, places: FloatArray, rings: Rings, pairs: IntArray) -> BoolArray:
        """Whether the body gets straight from place to place, in whatever heading.

        It goes as far as it gets in the region around the one, and from there in the other's.

        Parameters
        ----------
        places : (n, 2) array
            Where it is, and where it is to get.
        rings : Rings
            The regions around the places.
        pairs : (m, 2) array of int
            From which place to which.

        Returns
        -------
        (m,) array of bool
        """
        starts, corners, _, _ = rings.arrays
        return disc_bridges(places, corners, starts, pairs, self.roomy_radius_m)

    def has_room(self, boundary: FloatArray, at: Configuration) -> bool:
        """Whether a region holds the body in any heading."""
        return self.is_disc or disc_clearance(boundary, at.x, at.y) >= self.roomy_radius_m

    def _kept(self, boundary: FloatArray, x: float, y: float) -> float:
        # The radius that a disc keeps free around it on a way from here.
        radius = self.outer_radius_m
        room = disc_clearance(boundary, x, y) - TOUCH_M
        least = min(radius + self._least_margin, max(radius, room))
        return max(least, min(radius + self.margin_m, room))

    def room(self, boundary: FloatArray, *places: Configuration) -> Room | None:
        """Give the room in a region, with as much of the margin as there is at some places.

        Parameters
        ----------
        boundary : (n, 2) array
            The region's ring, or its rings as `rings_of` gives them.
        *places : Configuration
            Where the body stands, or is to stand.

        Returns
        -------
        Room or None
            None where the body does not fit at one of the places.
        """
        if self.is_disc:
            radius = min(self._kept(boundary, x, y) for x, y, _ in places)
            rooms = [Room(boundary, radius)]
        else:
            rooms = [Room(boundary, outline) for outline in self._grown]
        for room in rooms:
            if all(room.holds(place) for place in places):
                return room
        return None

    def can_turn(self, boundary: FloatArray, at: Configuration, turn: float) -> bool:
        """Whether the body can turn in place by a signed angle inside a region."""
        if self.is_disc or abs(turn) < NO_TURN_RAD or self.has_room(boundary, at):
            return True
        x, y, heading = at
        return bool(rotation_is_free(boundary, self._grown[-1], x, y, heading, turn))


def _offset(outline: FloatArray, distance: float) -> FloatArray:
    ring = Polygon(outline).buffer(distance, join_style="mitre").exterior
    return np.ascontiguousarray(np.asarray(ring.normalize().coords)[:-1][::-1])
