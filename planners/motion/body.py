"""A body with its safety margin, and where it fits into known free space."""

from __future__ import annotations

import math
from typing import Final

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
from multisrt.planners.motion.margin import MIN_MARGIN_M
from multisrt.planners.motion.room import ROUNDING_M, Room

PAIRS_AT_ONCE: Final = 1024
"""Number of pairs of places whose regions are held in arrays together."""

LEAVES_M = 0.002
"""Length of a motion in metres after which a body that touched the border has `MIN_MARGIN_M`."""

TOUCH_M = 1e-7
"""Distance in metres by which a disc stays off what it already stands next to, and by which a
polygon that leaves the border that it touches counts as smaller."""

ROUNDING_RAD = 1e-9
"""A turn smaller than this is rounding, in radians."""


class PlanningBody:
    """A footprint with a safety margin.

    The margin is kept where there is room for it. A body that stands nearer to an obstacle may
    move on as near as it stands, but not nearer than its true outline.

    Parameters
    ----------
    footprint : Footprint
        The body.
    margin_m : float
        Distance in metres to keep from the border of known free space; at least `MIN_MARGIN_M`.

    Attributes
    ----------
    outer_radius_m : float
        Circumscribed radius of the footprint.
    roomy_radius_m : float
        Radius of the disc that needs to be free for the body to take any heading.
    ample_radius_m : float
        Circumscribed radius with the whole margin.

    Examples
    --------
    >>> body = PlanningBody(Footprint.disc(0.25), margin_m=0.05)
    >>> square = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]])
    >>> round(body.travel(square, Configuration(1.0, 2.0, 0.0), 0.0, limit=9.0), 3)
    2.7
    >>> body.disc_travel(square, 1.0, 1.0, 3.0, 3.0)
    True
    """

    def __init__(self, footprint: Footprint, margin_m: float) -> None:
        margin_m = max(margin_m, MIN_MARGIN_M)
        self.footprint = footprint
        self.margin_m = margin_m
        self.is_disc = footprint.is_disc
        self.outer_radius_m = footprint.circumscribed_radius_m
        # Places are chosen with at least this margin and left with less, so that a place once
        # chosen can be left again.
        self._place_margin = margin_m / 5.0
        self.roomy_radius_m = self.outer_radius_m + margin_m / 10.0
        self.ample_radius_m = self.outer_radius_m + margin_m
        if not self.is_disc:
            outline = np.ascontiguousarray(footprint.planning_vertices)
            # Tried in this order: the whole margin, less, and hardly any.
            self._grown = [
                _offset(outline, margin)
                for margin in (margin_m, margin_m / 2.0, self._place_margin, MIN_MARGIN_M)
            ]
            # A body that touches the border may leave it.
            self._touching = _offset(outline, -TOUCH_M)

    def travel(
        self,
        boundary: FloatArray,
        at: Configuration,
        direction: float,
        limit: float,
    ) -> float:
        """Return how far the body can move in a direction with a fixed heading inside a region.

        Parameters
        ----------
        boundary : (n, 2) array
            The region in metres; it contains the body.
        at : Configuration
            Configuration of the body.
        direction : float
            Direction of the motion in radians.
        limit : float
            Maximum distance of interest in metres.

        Returns
        -------
        float
            Metres, at most `limit`.
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
            room = max(0.0, room - self._place_margin)
        return room

    def passes(
        self, boundary: FloatArray, at: Configuration, direction: float, distance: float
    ) -> bool:
        """Whether a motion that `travel` found is free, also if rounding has rotated it.

        Parameters are those of `travel`, with the distance of the motion. Polygons are tested with
        the minimum margin, as the margin that `travel` kept is not known here.
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

    def leaves(
        self, boundary: FloatArray, at: Configuration, direction: float, distance: float
    ) -> bool:
        """Whether a motion is free by which a polygon that touches the border leaves it.

        Parameters are those of `passes`. It has the minimum margin once it has moved by `LEAVES_M`.
        """
        x, y, heading = at
        cosine, sine = math.cos(direction), math.sin(direction)
        touching = free_travel_polygon(
            boundary, self._touching, x, y, heading, cosine, sine, LEAVES_M
        )
        left = Configuration(x + LEAVES_M * cosine, y + LEAVES_M * sine, heading)
        return touching >= LEAVES_M and self.passes(boundary, left, direction, distance - LEAVES_M)

    def disc_fan(
        self, boundary: FloatArray, at: Configuration, directions: FloatArray, limit: float
    ) -> FloatArray:
        """Return `travel` of a disc for an array of directions, ``(k,)`` metres."""
        x, y, _ = at
        radius = self._kept(boundary, x, y)
        return free_travel_disc_fan(boundary, x, y, directions, radius, limit)

    def disc_travel(self, boundary: FloatArray, x: float, y: float, tx: float, ty: float) -> bool:
        """Whether the body can move straight from x, y to tx, ty in any heading."""
        return self.disc_reach(boundary, x, y, tx, ty) >= math.hypot(tx - x, ty - y)

    def disc_reach(self, boundary: FloatArray, x: float, y: float, tx: float, ty: float) -> float:
        """Return how far the body can move straight from x, y towards tx, ty in any heading."""
        distance = math.hypot(tx - x, ty - y)
        if distance == 0.0:
            return 0.0
        radius = self.roomy_radius_m
        return free_travel_disc(
            boundary, x, y, (tx - x) / distance, (ty - y) / distance, radius, distance
        )

    def bridges(self, places: FloatArray, rings: Rings, pairs: IntArray) -> BoolArray:
        """Return whether the body can move straight between pairs of places in any heading.

        It moves as far as possible in the region around the first place, and from there in that
        around the second.

        Parameters
        ----------
        places : (n, 2) array
            Places in metres.
        rings : Rings
            The region around each place.
        pairs : (m, 2) array of int
            Indices of the places.

        Returns
        -------
        (m,) array of bool
        """
        joined = np.empty(len(pairs), np.bool_)
        for first in range(0, len(pairs), PAIRS_AT_ONCE):
            part = slice(first, first + PAIRS_AT_ONCE)
            arrays = rings.arrays(np.unique(pairs[part]))
            joined[part] = disc_bridges(places, arrays, pairs[part], self.roomy_radius_m)
        return joined

    def has_room(self, boundary: FloatArray, at: Configuration, spare_m: float = 0.0) -> bool:
        """Whether the body at a position fits into a region in any heading, with some to spare."""
        return self.is_disc or self.is_roomy(boundary, at, spare_m)

    def is_roomy(self, boundary: FloatArray, at: Configuration, spare_m: float = 0.0) -> bool:
        """Whether a region has room for `roomy_radius_m` and more around a position."""
        return bool(disc_clearance(boundary, at.x, at.y) >= self.roomy_radius_m + spare_m)

    def _kept(self, boundary: FloatArray, x: float, y: float) -> float:
        """Return the radius that a disc keeps free on a motion from here."""
        radius = self.outer_radius_m
        room = disc_clearance(boundary, x, y) - TOUCH_M
        smallest = min(radius + self._place_margin, max(radius, room))
        return max(smallest, min(radius + self.margin_m, room))

    def room(self, boundary: FloatArray, *places: Configuration) -> Room | None:
        """Return the room of the body in a region, with as much margin as some places allow.

        Parameters
        ----------
        boundary : (n, 2) array
            The region's ring in metres, or its rings as `rings_of` returns them.
        *places : Configuration
            Configurations at which the body has to fit.

        Returns
        -------
        Room or None
            None if the body does not fit at one of them.
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
        """Whether the body can turn in place by a signed angle in radians inside a region."""
        if self.is_disc or abs(turn) < ROUNDING_RAD or self.has_room(boundary, at):
            return True
        x, y, heading = at
        return bool(rotation_is_free(boundary, self._grown[-1], x, y, heading, turn))


def _offset(outline: FloatArray, distance: float) -> FloatArray:
    ring = Polygon(outline).buffer(distance, join_style="mitre").exterior
    return np.ascontiguousarray(np.asarray(ring.normalize().coords)[:-1][::-1])
