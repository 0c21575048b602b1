"""Collision of a body with a world, at rest and in motion, by FCL.

A body whose distance from all edges of the world exceeds its own reach needs no FCL, and neither
does a disc on a straight line: the edges near its path decide.

Everything is solid and three-dimensional for FCL. Obstacles are prisms that stand on the floor
z = 0; bodies reach through the floor, from below it to above the obstacles. So a body inside an
obstacle cuts its bottom face, an obstacle inside a body is inside a convex solid, and both are
found; and the distance in space is the distance on the floor. Discs are spheres centred on the
floor, whose distance to a mesh FCL has in closed form.

Static answers are exact to rounding. Touching counts as a collision. Motions with a turn are
followed by conservative advancement: a step is as long as the
clearance lets no point of the body reach anything. So that a body can slide along a wall, no
step is shorter than the resolution (1 mm): a contact that is reported is real, and one that is
missed is nowhere deeper than half the resolution.

Queries about two bodies are in `meetings`; their names can be imported from here as well.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import fcl
import numpy as np
import shapely
from shapely import MultiPolygon, Polygon
from shapely.geometry.base import BaseGeometry

from multisrt.geometry.bodies.advancement import (
    CONTACT_PRECISION_M,
    RESOLUTION_M,
    first_contact_fraction,
    require_resolution,
)
from multisrt.geometry.bodies.clearance import rings_of
from multisrt.geometry.bodies.collision_body import Body, gap, touch
from multisrt.geometry.bodies.footprint import (
    Footprint,
    checked_configuration,
    place,
    require_constant_heading,
)
from multisrt.geometry.bodies.meetings import (
    bodies_collide,
    body_distance,
    first_meeting,
)
from multisrt.geometry.bodies.motion import Motion
from multisrt.geometry.bodies.outlines import sweep_convex
from multisrt.geometry.bodies.solids import (
    MAX_TILES,
    TILE_M,
    convex_prism,
    polygons_of,
    standing_prisms,
    tiles_of,
)
from multisrt.geometry.configuration import Configuration
from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.regions.edge_index import EdgeIndex, no_edge_within, winding_number

__all__ = [
    "RESOLUTION_M",
    "Body",
    "CollisionWorld",
    "Motion",
    "bodies_collide",
    "body_distance",
    "first_meeting",
]


class CollisionWorld:
    """The obstacles of a world, prepared for collision queries.

    Whatever is not free space is an obstacle, to infinity on all sides. A world and its bodies
    are moved by every query: share them between robots, but not between threads.

    Parameters
    ----------
    free : Polygon or MultiPolygon
        Free space in metres.

    Raises
    ------
    InvalidInputError
        If free space is empty, not valid, not finite, or not made of polygons.

    Examples
    --------
    >>> import shapely
    >>> world = CollisionWorld(shapely.box(0, 0, 4, 3))
    >>> body = world.body(Footprint.disc(0.5))
    >>> world.pose_is_free(body, (1.0, 1.0, 0.0)), world.clearance(body, (1.0, 1.0, 0.0))
    (True, 0.5)
    >>> world.straight_motion_is_free(body, (1.0, 1.0, 0.0), (5.0, 1.0, 0.0))
    False
    """

    def __init__(self, free: Polygon | MultiPolygon) -> None:
        _require_area(free)
        frame = shapely.box(*shapely.bounds(free)).buffer(1.0, join_style="mitre")
        solid = frame.difference(free)
        self._bounds: tuple[float, float, float, float] = frame.bounds
        x0, y0, x1, y1 = self._bounds
        tile = max(TILE_M, (x1 - x0) / MAX_TILES, (y1 - y0) / MAX_TILES)
        tiles = [part for whole in polygons_of(solid) for part in tiles_of(whole, tile)]
        self._obstacles = fcl.CollisionObject(standing_prisms(tiles, "world"))
        rings = rings_of(free)
        edges = np.hstack([rings[:-1], rings[1:]])
        self._index = EdgeIndex(edges[np.isfinite(edges).all(axis=1)], tile)
        self._bodies: dict[Footprint, Body] = {}

    def body(self, footprint: Footprint) -> Body:
        """Return the body of a footprint, which is the same object at every call."""
        if footprint not in self._bodies:
            self._bodies[footprint] = Body(footprint)
        return self._bodies[footprint]

    def pose_is_free(self, body: Body, configuration: Sequence[float]) -> bool:
        """Whether a body lies in free space without touching an obstacle.

        Parameters
        ----------
        body : Body
            The body.
        configuration : (x, y, heading)
            Where it is, in metres and radians.

        Raises
        ------
        InvalidInputError
            If the configuration is not three finite numbers.
        """
        return self._pose_is_free(body, checked_configuration(configuration))

    def clearance(self, body: Body, configuration: Sequence[float]) -> float:
        """Return the distance from a body to the nearest obstacle.

        Parameters
        ----------
        body : Body
            The body.
        configuration : (x, y, heading)
            Where it is, in metres and radians.

        Returns
        -------
        float
            Metres; 0 where the body is not free.

        Raises
        ------
        InvalidInputError
            If the configuration is not three finite numbers.
        """
        return self._clearance(body, checked_configuration(configuration))

    def straight_motion_is_free(
        self, body: Body, start: Sequence[float], end: Sequence[float]
    ) -> bool:
        """Whether a body can move on a straight line with constant heading.

        This is exact: the area that the body sweeps is tested as a whole.

        Parameters
        ----------
        body : Body
            The body.
        start, end : (x, y, heading)
            First and last configuration in metres and radians.

        Raises
        ------
        InvalidInputError
            If a configuration is not three finite numbers, or the headings differ (those of a
            disc may).
        """
        first, last = checked_configuration(start), checked_configuration(end)
        footprint = body.footprint
        require_constant_heading(footprint, first, last)
        if not self._within_frame(first):
            return False
        if first[:2] == last[:2]:
            return self._pose_is_free(body, first)
        if footprint.is_disc:
            # A disc sweeps whatever is within its radius of its centre's path.
            return self._keeps_off(first, last, footprint.radius_m)
        step = np.array([last[0] - first[0], last[1] - first[1]])
        swept = (
            fcl.CollisionObject(convex_prism(sweep_convex(place(piece, *first), step)))
            for piece in footprint.convex_pieces
        )
        return not any(touch((solid,), self._obstacles) for solid in swept)

    def rotation_is_free(
        self,
        body: Body,
        configuration: Sequence[float],
        turn: float,
        *,
        resolution_m: float = RESOLUTION_M,
    ) -> bool:
        """Whether a body can turn in place about its reference point.

        Parameters
        ----------
        body : Body
            The body.
        configuration : (x, y, heading)
            Where it starts, in metres and radians.
        turn : float
            Signed angle in radians, counter-clockwise positive.
        resolution_m : float
            Length of the shortest step of the outermost point in metres; contacts up to half as
            deep may be missed.

        Raises
        ------
        InvalidInputError
            If the configuration or the turn is not finite, or the resolution not positive.
        """
        start = checked_configuration(configuration)
        if body.footprint.is_disc and math.isfinite(turn):
            return self._pose_is_free(body, start)
        end = (start[0], start[1], start[2] + turn)
        return self.first_contact(body, start, end, turn, resolution_m=resolution_m) is None

    def first_contact(
        self,
        body: Body,
        start: Sequence[float],
        end: Sequence[float],
        turn: float | None = None,
        *,
        arc: bool = False,
        resolution_m: float = RESOLUTION_M,
    ) -> float | None:
        """Find how far along a motion a body first meets an obstacle.

        Parameters
        ----------
        body : Body
            The body.
        start, end : (x, y, heading)
            First and last configuration in metres and radians.
        turn : float, optional
            Signed angle from the first heading to the last, which may be more than one turn; by
            default the shorter way.
        arc : bool
            Whether the reference point moves on a circular arc; see `Motion.between`.
        resolution_m : float
            Length of the shortest step in metres; contacts up to half as deep may be missed.

        Returns
        -------
        float or None
            Fraction of the motion, from 0 to 1, at which the body is still free but within a
            micrometre of contact; 0 if it starts in contact; None if it never meets anything.

        Raises
        ------
        InvalidInputError
            If a number is not finite, the turn does not lead to the last heading, or no arc
            joins the configurations.

        Examples
        --------
        >>> import shapely
        >>> world = CollisionWorld(shapely.box(0, 0, 4, 3))
        >>> body = world.body(Footprint.disc(0.5))
        >>> round(world.first_contact(body, (1.0, 1.0, 0.0), (5.0, 1.0, 0.0)), 6)
        0.625
        """
        motion = Motion.between(start, end, turn, arc=arc)
        require_resolution(resolution_m)
        # Most motions stay so far off all obstacles that the body's heading does not matter.
        reach = body.footprint.circumscribed_radius_m + motion.bulge
        if self._keeps_off(motion.start, motion.end, reach + CONTACT_PRECISION_M):
            return None
        return first_contact_fraction(
            lambda fraction: self._clearance(body, motion.pose(fraction)),
            lambda fraction: self._pose_is_free(body, motion.pose(fraction)),
            motion.length + body.turning_radius_m * abs(motion.turn),
            resolution_m,
        )

    def _pose_is_free(self, body: Body, pose: Configuration) -> bool:
        if not self._within_frame(pose):
            return False
        return not touch(body.movers_at(pose), self._obstacles)

    def _clearance(self, body: Body, pose: Configuration) -> float:
        if not self._within_frame(pose):
            return 0.0
        return gap(body.movers_at(pose), self._obstacles)

    def _keeps_off(self, start: Configuration, end: Configuration, distance_m: float) -> bool:
        # Whether a line lies in free space and is farther than a distance from all obstacles.
        index = self._index
        return self._is_in_free_space(start) and no_edge_within(
            *start[:2], *end[:2], distance_m, index.grid
        )

    def _is_in_free_space(self, pose: Configuration) -> bool:
        return winding_number(*pose[:2], self._index.grid) > 0

    def _within_frame(self, pose: Configuration) -> bool:
        # Whether the reference point, which is part of the body, is not beyond the frame.
        x0, y0, x1, y1 = self._bounds
        return x0 < pose[0] < x1 and y0 < pose[1] < y1


def _require_area(free: BaseGeometry) -> None:
    if not isinstance(free, (Polygon, MultiPolygon)):
        raise InvalidInputError(
            f"world: free space is a Polygon or MultiPolygon, not {type(free).__name__}"
        )
    if free.is_empty:
        raise InvalidInputError("world: free space is empty; a world needs room for a body")
    if not np.isfinite(shapely.get_coordinates(free)).all():
        raise InvalidInputError("world: free space has coordinates that are not finite numbers")
    if not free.is_valid:
        raise InvalidInputError(
            f"world: free space is not valid: {shapely.is_valid_reason(free)}; draw outlines "
            "that do not cross themselves"
        )
