"""Straight ways of a body inside a region that it knows to be free (MOVE_TO of Multi-SRT)."""

from __future__ import annotations

import math

import numpy as np

from multisrt.geometry.configuration import Configuration, wrap_angle
from multisrt.geometry.numerics.kernel import FloatArray
from multisrt.planners.motion.body import PlanningBody
from multisrt.planners.motion.kinematics import (
    Car,
    Differential,
    Holonomic,
    Kinematics,
    turns_between,
)
from multisrt.planners.motion.trajectory import Trajectory


def reach(
    body: PlanningBody,
    kinematics: Kinematics,
    boundary: FloatArray,
    start: Configuration,
    direction: float,
    limit: float,
) -> float:
    """How far a body gets straight in a direction, after turning to it where it must.

    A car is taken to look in the direction already: how it gets to do so is not asked here.

    Returns
    -------
    float
        Metres, at most `limit`; 0 where it cannot turn or move at all.
    """
    if body.is_disc or isinstance(kinematics, Holonomic):
        return body.travel(boundary, start, direction, limit)
    turned = Configuration(start.x, start.y, wrap_angle(direction))
    distance = body.travel(boundary, turned, direction, limit)
    if isinstance(kinematics, Car):
        return distance
    if distance > 0.0 and not any(
        body.can_turn(boundary, start, turn) for turn in turns_between(start.heading, direction)
    ):
        return 0.0
    return distance


def reach_fan(
    body: PlanningBody,
    kinematics: Kinematics,
    boundary: FloatArray,
    start: Configuration,
    directions: FloatArray,
    limit: float,
) -> FloatArray:
    """Give `reach` for many directions."""
    if body.is_disc:
        return body.disc_fan(boundary, start, directions, limit)
    return np.array(
        [reach(body, kinematics, boundary, start, t, limit) for t in directions.tolist()]
    )


def steer(
    body: PlanningBody,
    kinematics: Holonomic | Differential,
    boundary: FloatArray,
    start: Configuration,
    x: float,
    y: float,
) -> Trajectory | None:
    """Plan the straight way to a place inside a region.

    Parameters
    ----------
    body, kinematics
        What moves, and how.
    boundary : (n, 2) array
        The region.
    start : Configuration
        Where the body is.
    x, y : float
        Where it shall be.

    Returns
    -------
    Trajectory or None
        None where no way of turning and driving stays in the region. A differential body
        drives forwards if it can, and backwards where it has no room to turn round.
    """
    distance = math.hypot(x - start.x, y - start.y)
    direction = math.atan2(y - start.y, x - start.x)
    if isinstance(kinematics, Holonomic):
        passes = body.passes(boundary, start, direction, distance)
        return kinematics.drive(start, x, y) if passes else None
    for wanted in (direction, direction + math.pi):
        for turn in turns_between(start.heading, wanted):
            if body.can_turn(boundary, start, turn):
                turned = kinematics.turn(start, turn)
                at = turned.end
                if body.passes(boundary, at, direction, distance):
                    return turned.then(kinematics.drive(at, x, y))
                if body.is_disc:
                    # It passes in no other heading either.
                    return None
    return None


def turn_and_drive(
    kinematics: Holonomic | Differential, start: Configuration, x: float, y: float
) -> Trajectory:
    """Plan the straight way to a place where there is room for any heading."""
    if isinstance(kinematics, Holonomic):
        return kinematics.drive(start, x, y)
    if (x, y) == (start.x, start.y):
        return kinematics.turn(start, 0.0)
    direction = math.atan2(y - start.y, x - start.x)
    turned = kinematics.turn(start, turns_between(start.heading, direction)[0])
    return turned.then(kinematics.drive(turned.end, x, y))
