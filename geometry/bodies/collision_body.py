"""Footprints as solids for FCL, and their contact and distance."""

from __future__ import annotations

import math

import fcl
import numpy as np
from shapely import Polygon

from multisrt.geometry.bodies.footprint import Footprint
from multisrt.geometry.bodies.solids import convex_prism, standing_prisms
from multisrt.geometry.configuration import Configuration

# The distance is FCL's return value. A result that is already nearer keeps the bindings from
# filling it with arrays for nearest points that are never read.
_COLLISION_REQUEST = fcl.CollisionRequest()
_DISTANCE_REQUEST = fcl.DistanceRequest()
_UNUSED_RESULT = fcl.DistanceResult(-math.inf)


class Body:
    """A footprint prepared for collision queries.

    It holds FCL objects that every query moves: it can be shared between robots, but not between
    threads.

    Parameters
    ----------
    footprint : Footprint
        Shape of the body.

    Examples
    --------
    >>> Body(Footprint.box(0.6, 0.8)).turning_radius_m
    0.5
    >>> Body(Footprint.disc(0.25)).turning_radius_m
    0.0
    """

    def __init__(self, footprint: Footprint) -> None:
        self._footprint = footprint
        if footprint.is_disc:
            self._movers = (fcl.CollisionObject(fcl.Sphere(footprint.radius_m)),)
            self._obstacle = fcl.CollisionObject(fcl.Sphere(footprint.radius_m))
        else:
            self._movers = tuple(
                fcl.CollisionObject(convex_prism(piece)) for piece in footprint.convex_pieces
            )
            outline = Polygon(footprint.vertices)
            self._obstacle = fcl.CollisionObject(standing_prisms([outline], f"body {footprint}"))

    @property
    def footprint(self) -> Footprint:
        """Shape of the body."""
        return self._footprint

    @property
    def turning_radius_m(self) -> float:
        """Distance that the body's farthest point moves per radian of a turn; 0 for a disc."""
        return 0.0 if self._footprint.is_disc else self._footprint.circumscribed_radius_m

    def movers_at(self, pose: Configuration) -> tuple[fcl.CollisionObject, ...]:
        """Return the body's convex pieces at a pose, until the next call."""
        _move(self._movers, pose)
        return self._movers

    def obstacle_at(self, pose: Configuration) -> fcl.CollisionObject:
        """Return the whole body as an obstacle for others at a pose, until the next call."""
        _move((self._obstacle,), pose)
        return self._obstacle

    def __repr__(self) -> str:
        return f"Body({self._footprint!r})"


def touch(movers: tuple[fcl.CollisionObject, ...], obstacle: fcl.CollisionObject) -> bool:
    """Whether any of some convex solids touches or overlaps an obstacle."""
    return any(fcl.collide(mover, obstacle, _COLLISION_REQUEST) > 0 for mover in movers)


def gap(movers: tuple[fcl.CollisionObject, ...], obstacle: fcl.CollisionObject) -> float:
    """Return the distance between convex solids and an obstacle in metres, 0 in contact.

    In contact FCL's own value is not always defined.
    """
    if touch(movers, obstacle):
        return 0.0
    distances = [
        fcl.distance(mover, obstacle, _DISTANCE_REQUEST, _UNUSED_RESULT) for mover in movers
    ]
    return max(0.0, float(min(distances)))


def placed_pair(
    body_a: Body, pose_a: Configuration, body_b: Body, pose_b: Configuration
) -> tuple[tuple[fcl.CollisionObject, ...], fcl.CollisionObject]:
    """Return two bodies at their poses, one as the mover and the other as an obstacle.

    A disc moves and a polygon stands, because FCL is exact for a sphere against a mesh, but not
    against a convex solid. Both may be the same `Body`.
    """
    if body_b.footprint.is_disc:
        body_a, pose_a, body_b, pose_b = body_b, pose_b, body_a, pose_a
    return body_a.movers_at(pose_a), body_b.obstacle_at(pose_b)


def _move(objects: tuple[fcl.CollisionObject, ...], pose: Configuration) -> None:
    x, y, heading = pose
    turned = (math.cos(0.5 * heading), 0.0, 0.0, math.sin(0.5 * heading))
    moved = np.array((x, y, 0.0))
    for placed in objects:
        placed.setQuatRotation(turned)
        placed.setTranslation(moved)
