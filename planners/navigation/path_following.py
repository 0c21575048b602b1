"""Following of paths: as far as the newest region proves them free.

A path is a polyline planned on a map of cells. What is driven are its legs, each certified by
the exact kernels of straight ways inside the region that was sensed last: turn and drive for a
differential body, straight for a holonomic one.
"""

from __future__ import annotations

import math

import numpy as np

from multisrt.geometry.configuration import Configuration
from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.numerics.kernel import FloatArray, kernel
from multisrt.planners.motion.body import PlanningBody
from multisrt.planners.motion.kinematics import Car, Kinematics
from multisrt.planners.motion.steering import reach, steer
from multisrt.planners.motion.trajectory import Trajectory

LEAST_M = 0.01
"""A shorter piece of a path is not worth a motion."""

SAME_PLACE_M = 1e-9
"""Corners of a path that are nearer to each other are one."""


def ahead(path: FloatArray, at: Configuration) -> FloatArray:
    """Give what is left of a path from the point of it that is nearest to the robot.

    Where several are equally near, the last of them counts.

    Parameters
    ----------
    path : (k, 2) array
        The polyline's corners in metres, at least one.
    at : Configuration
        Where the robot is.

    Returns
    -------
    (m, 2) array
        That point and the corners after it, no two in a row at one place.
    """
    return _rest(_polyline(path), at.x, at.y)


def follow(
    body: PlanningBody,
    kinematics: Kinematics,
    boundary: FloatArray,
    at: Configuration,
    path: FloatArray,
    *,
    limit_m: float = math.inf,
    least_m: float = LEAST_M,
) -> Trajectory | None:
    """Plan the longest beginning of a path that stays in a region.

    The robot drives leg by leg. The leg that does not fit as a whole is the last, shortened to
    where the body still fits. A robot beside its path goes straight to the first corner after
    the path's beginning where it can, and to the beginning where it cannot.

    Parameters
    ----------
    body, kinematics
        What moves, and how.
    boundary : (n, 2) array
        The region, which holds the body.
    at : Configuration
        Where it is.
    path : (k, 2) array
        What is left of its path, see `ahead`.
    limit_m : float
        How much of the path is wanted, in metres.
    least_m : float
        How much is worth a motion.

    Returns
    -------
    Trajectory or None
        None where nothing is left of the path, or less than `least_m` of it is possible though
        it does not end there.

    Raises
    ------
    InvalidInputError
        For a path of no corner or one that is not finite, and for a car, whose ways are curves.
    """
    if isinstance(kinematics, Car):
        raise InvalidInputError(
            "a car does not follow straight legs; plan its curves with car_way, "
            "or use a holonomic or differential drive"
        )
    corners = _polyline(path)
    if len(corners) > 1 and (
        math.dist(corners[0], at[:2]) < least_m
        or steer(body, kinematics, boundary, at, *_within(at, corners[1], limit_m)) is not None
    ):
        corners = corners[1:]
    way: Trajectory | None = None
    driven = 0.0
    for corner in corners:
        here = at if way is None else way.end
        x, y = _within(here, corner, limit_m - driven)
        distance = math.dist((x, y), here[:2])
        if distance < SAME_PLACE_M:
            continue
        leg = steer(body, kinematics, boundary, here, x, y)
        fits = leg is not None
        if leg is None:
            direction = math.atan2(y - here.y, x - here.x)
            distance = reach(body, kinematics, boundary, here, direction, distance)
            x, y = _within(here, corner, distance)
            if distance >= SAME_PLACE_M:
                leg = steer(body, kinematics, boundary, here, x, y)
        if leg is not None:
            driven += distance
            way = leg if way is None else way.then(leg)
        if not fits:
            return way if driven >= least_m else None
    return way


def _within(here: Configuration, corner: FloatArray, distance: float) -> tuple[float, float]:
    # The place of a straight way to a corner at which so much of it has been driven.
    x, y = corner.tolist()
    whole = math.hypot(x - here.x, y - here.y)
    if whole <= distance:
        return x, y
    share = max(0.0, distance) / whole
    return here.x + share * (x - here.x), here.y + share * (y - here.y)


def _polyline(path: FloatArray) -> FloatArray:
    corners = np.ascontiguousarray(path, dtype=np.float64)
    if corners.ndim != 2 or corners.shape[1:] != (2,) or not len(corners):
        raise InvalidInputError(f"a path is a (k, 2) array with k > 0, not {corners.shape}")
    if not np.isfinite(corners).all():
        raise InvalidInputError("the corners of a path are finite numbers of metres")
    return _distinct(corners)


@kernel
def _distinct(corners: FloatArray) -> FloatArray:
    # Corners at which the one before is repeated are left out.
    kept = np.ones(len(corners), np.bool_)
    for i in range(1, len(corners)):
        dx, dy = corners[i, 0] - corners[i - 1, 0], corners[i, 1] - corners[i - 1, 1]
        kept[i] = math.hypot(dx, dy) > SAME_PLACE_M
    return corners[kept]


@kernel
def _rest(corners: FloatArray, x: float, y: float) -> FloatArray:
    # From the last of the points that are nearest to a place.
    legs = len(corners) - 1
    if legs == 0:
        return corners
    feet, distances = np.empty((legs, 2)), np.empty(legs)
    for i in range(legs):
        ax, ay = corners[i, 0], corners[i, 1]
        dx, dy = corners[i + 1, 0] - ax, corners[i + 1, 1] - ay
        along = ((x - ax) * dx + (y - ay) * dy) / (dx * dx + dy * dy)
        share = min(1.0, max(0.0, along))
        feet[i, 0], feet[i, 1] = ax + share * dx, ay + share * dy
        distances[i] = math.hypot(feet[i, 0] - x, feet[i, 1] - y)
    near = distances.min() + SAME_PLACE_M
    leg = legs - 1
    while distances[leg] > near:
        leg -= 1
    return _distinct(np.concatenate((feet[leg : leg + 1], corners[leg + 1 :])))
