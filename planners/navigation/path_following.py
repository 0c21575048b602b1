"""Path following, as far as the region sensed last shows the path to be free.

A path is a polyline planned on a grid. Its legs are driven straight, a differential drive turning
in place between them, or in a curve where that saves time if it is to save turns. Each motion is
verified exactly inside the region.
"""

from __future__ import annotations

import math

import numpy as np

from multisrt.geometry.configuration import Configuration
from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.numerics.boxes import all_below
from multisrt.geometry.numerics.kernel import FloatArray, kernel
from multisrt.planners.motion.body import PlanningBody
from multisrt.planners.motion.kinematics import Car, Differential, Holonomic, Kinematics
from multisrt.planners.motion.steering import reach, steer
from multisrt.planners.motion.trajectory import Trajectory

MIN_MOTION_M = 0.01
"""Default minimum length of a motion along a path in metres."""

SAME_CORNER_M = 1e-9
"""Consecutive corners of a path closer than this count as one, in metres; so do distances to it."""

AHEAD_M = (3.0, 2.0, 1.5, 1.0, 0.5, 0.25)
"""Distances ahead on its path, in metres, at which a robot beside it that saves turns joins it: the
first that it can reach."""


def ahead(path: FloatArray, at: Configuration) -> FloatArray:
    """Return the rest of a path from its point nearest to the robot on.

    Parameters
    ----------
    path : (k, 2) array
        Corners of the polyline in metres, at least one.
    at : Configuration
        Configuration of the robot.

    Returns
    -------
    (m, 2) array
        The nearest point, the last of equally near ones, and the corners after it. Repeated
        corners are left out.

    Raises
    ------
    InvalidInputError
        If the path has no corner, or one that is not finite.

    Examples
    --------
    >>> path = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 3.0]])
    >>> ahead(path, Configuration(1.0, 0.5, 0.0)).tolist()
    [[1.0, 0.0], [4.0, 0.0], [4.0, 3.0]]
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
    until_s: float = math.inf,
    saves_turns: bool = False,
) -> Trajectory | None:
    """Return the motion along the longest beginning of a path that stays in a region.

    The first leg that does not fit is shortened to where the body still fits, and is the last. A
    robot beside its path moves straight to the second corner if it can, else to the first. If it
    saves turns, it first tries places on the leg between these.

    Parameters
    ----------
    body, kinematics
        The body that moves, and how.
    boundary : (n, 2) array
        The region in metres; it contains the body.
    at : Configuration
        Configuration of the body.
    path : (k, 2) array
        The rest of its path in metres, see `ahead`.
    limit_m : float
        Maximum length of the motion in metres, measured along the path: a curve may be longer.
    until_s : float
        Time in seconds up to which the motion is needed. Legs that begin later are left out.
    saves_turns : bool
        Whether legs are driven in curves or backwards to save turns, see `steer`.

    Returns
    -------
    Trajectory or None
        None if the path ends here, or less than `MIN_MOTION_M` of it is free.

    Raises
    ------
    InvalidInputError
        If the path has no corner, or one that is not finite, or the body is a car.

    Examples
    --------
    >>> from multisrt.geometry.bodies.footprint import Footprint
    >>> from multisrt.planners.motion.kinematics import Holonomic
    >>> body = PlanningBody(Footprint.disc(0.25), margin_m=0.05)
    >>> square = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]])
    >>> path = np.array([[1.0, 1.0], [3.0, 1.0], [3.0, 9.0]])
    >>> motion = follow(body, Holonomic(), square, Configuration(1.0, 1.0, 0.0), path)
    >>> round(motion.end.x, 3), round(motion.end.y, 3)
    (3.0, 3.7)
    """
    if isinstance(kinematics, Car):
        raise InvalidInputError(
            "a car does not follow straight legs; plan its curves with car_trajectory, "
            "or use a holonomic or differential drive"
        )
    corners = _polyline(path)
    if len(corners) > 1 and (
        math.dist(corners[0], at[:2]) < MIN_MOTION_M
        or steer(body, kinematics, boundary, at, *_within(at, corners[1], limit_m)) is not None
    ):
        corners = corners[1:]
    elif saves_turns and len(corners) > 1:
        corners = _joined_ahead(body, kinematics, boundary, at, corners)
    motion: Trajectory | None = None
    driven = 0.0
    for corner in corners:
        if motion is not None and motion.duration_s >= until_s and driven >= MIN_MOTION_M:
            break
        here = at if motion is None else motion.end
        x, y = _within(here, corner, limit_m - driven)
        distance = math.dist((x, y), here[:2])
        if distance < SAME_CORNER_M:
            continue
        leg = steer(body, kinematics, boundary, here, x, y, saves_turns=saves_turns)
        fits = leg is not None
        if leg is None:
            direction = math.atan2(y - here.y, x - here.x)
            distance = reach(body, kinematics, boundary, here, direction, distance)
            x, y = _within(here, corner, distance)
            if distance >= SAME_CORNER_M:
                leg = steer(body, kinematics, boundary, here, x, y, saves_turns=saves_turns)
        if leg is not None:
            driven += distance
            motion = leg if motion is None else motion.then(leg)
        if not fits:
            return motion if driven >= MIN_MOTION_M else None
    return motion


def _joined_ahead(
    body: PlanningBody,
    kinematics: Holonomic | Differential,
    boundary: FloatArray,
    at: Configuration,
    corners: FloatArray,
) -> FloatArray:
    """Return a path that a robot beside it joins farther ahead, where it can, than at its foot.

    A curve leaves its path, and ends there if it is cut short. Back to the foot it is a turn aside.
    """
    foot, leg = corners[0], corners[1] - corners[0]
    length_m = math.hypot(*leg.tolist())
    for ahead_m in AHEAD_M:
        if ahead_m < length_m:
            place = foot + leg * (ahead_m / length_m)
            x, y = place.tolist()
            if steer(body, kinematics, boundary, at, x, y) is not None:
                return np.vstack([place[None], corners[1:]])
    return corners


def _within(here: Configuration, corner: FloatArray, distance: float) -> tuple[float, float]:
    """Return the point at a distance on the straight line to a corner, at most the corner."""
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
    if not all_below(corners, math.inf):
        raise InvalidInputError("the corners of a path are finite numbers of metres")
    return _distinct(corners)


@kernel
def _distinct(corners: FloatArray) -> FloatArray:
    """Return the corners without those that repeat the one before."""
    kept = np.ones(len(corners), np.bool_)
    for i in range(1, len(corners)):
        dx, dy = corners[i, 0] - corners[i - 1, 0], corners[i, 1] - corners[i - 1, 1]
        kept[i] = math.hypot(dx, dy) > SAME_CORNER_M
    return corners[kept]


@kernel
def _rest(corners: FloatArray, x: float, y: float) -> FloatArray:
    """Return the rest of a polyline from the last of its points nearest to a place on."""
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
    near = distances.min() + SAME_CORNER_M
    leg = legs - 1
    while distances[leg] > near:
        leg -= 1
    return _distinct(np.concatenate((feet[leg : leg + 1], corners[leg + 1 :])))
