"""Motions through places, for every kind of drive."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Any

import numpy as np
import shapely
from shapely import Polygon
from shapely.geometry.base import BaseGeometry

from multisrt.geometry.configuration import Configuration, wrap_angle
from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.numerics.arrays import FloatArray
from multisrt.geometry.regions.safe_region import LocalSafeRegion
from multisrt.planners.motion.body import PlanningBody
from multisrt.planners.motion.car import car_out_and_back, car_trajectory
from multisrt.planners.motion.curves import curve
from multisrt.planners.motion.kinematics import (
    Car,
    Differential,
    Holonomic,
    Kinematics,
    turns_between,
)
from multisrt.planners.motion.steering import turn_and_drive
from multisrt.planners.motion.trajectory import Trajectory, standing_at
from multisrt.planners.navigation.path_following import follow
from multisrt.robots.explorer import RobotSelf
from multisrt.robots.toolkit.places import rows_of

Region = LocalSafeRegion | FloatArray | BaseGeometry
"""Space known to be free: a region, a ring ``(n, 2)`` in metres, or a polygon of shapely."""


def trajectory(
    kinematics: Kinematics, start: Configuration, places: Any, *, headings: bool = False
) -> Trajectory:
    """Return the motion through places, regardless of obstacles.

    A holonomic body goes straight from place to place; a differential one turns in place before
    each straight leg, in the shorter direction; a car drives the shortest curves, and passes each
    place in the direction of the next one.

    Parameters
    ----------
    kinematics : Holonomic, Differential or Car
        The kinematics of the body: ``me.kinematics``.
    start : Configuration
        Its present configuration: the `configuration` of the last `Moved`.
    places : (n, 2) or (n, 3) array_like, or a single place
        The places in order; see `places_of`. A place where the body already is is omitted.
    headings : bool
        Whether the third numbers of places are headings in radians to be taken there. By default
        only x and y are used.

    Returns
    -------
    Trajectory
        The motion at maximum speed, which begins exactly at `start`; a single waypoint if there is
        no place to go to.

    Raises
    ------
    InvalidInputError
        If a place is invalid, or `headings` is true although places have none or the body is
        holonomic, which keeps its heading.

    Examples
    --------
    >>> here = Configuration(0.0, 0.0, 0.0)
    >>> corner = np.array([[2.0, 0.0], [2.0, 1.0]])
    >>> trajectory(Differential(), here, corner).end
    Configuration(x=2.0, y=1.0, heading=1.5707963267948966)
    >>> trajectory(Holonomic(), here, corner).length_m
    3.0
    >>> motion = trajectory(Car(), here, [(2.0, 0.0, math.pi)], headings=True)
    >>> motion.end.heading == math.pi, motion.length_m > 2.0
    (True, True)
    """
    rows = _rows(kinematics, places, headings)
    motion = standing_at(_floats(start))
    for number, row in enumerate(rows):
        here = motion.end
        x, y = row[:2]
        if isinstance(kinematics, Car):
            heading = row[2] if headings else _onward(here, row, rows[number + 1 :])
            leg = curve(kinematics, here, Configuration(x, y, heading))
        else:
            leg = turn_and_drive(kinematics, here, x, y)
            if headings and isinstance(kinematics, Differential):
                turn = turns_between(leg.end.heading, row[2])[0]
                leg = leg.then(kinematics.turn(leg.end, turn))
        motion = motion.then(leg)
    return motion


def trajectory_inside(
    me: RobotSelf,
    start: Configuration,
    places: Any,
    region: Region,
    *,
    margin_m: float = 0.01,
    limit_m: float = math.inf,
    headings: bool = False,
) -> Trajectory | None:
    """Return the motion along places, as far as the body stays in a region known to be free.

    Every leg is verified exactly. The first leg that does not fit is shortened to the part where
    the body fits, and is the last one; a car ends at the last place to which it finds a motion. A
    path through the whole map can thus be followed from scan to scan, each time inside the region
    of the last scan.

    Parameters
    ----------
    me : RobotSelf
        What the robot knows about itself: its body and its kinematics.
    start : Configuration
        Its present configuration, inside the region.
    places : (n, 2) or (n, 3) array_like, or a single place
        The places in order, such as a path of `FrontierMap`; see `places_of`. If the body is at the
        first place, it is omitted.
    region : LocalSafeRegion, (n, 2) array or polygon of shapely
        Space known to be free. For cars it may have holes and several parts.
    margin_m : float
        Distance in metres that the body keeps from the border of the region if there is room.
    limit_m : float
        Maximum length of the motion in metres; not for cars.
    headings : bool
        For cars, whether the third numbers of places are headings to arrive with. By default the
        car arrives with the first of several headings for which it finds a motion.

    Returns
    -------
    Trajectory or None
        The motion; None if less than a centimetre of the path is free.

    Raises
    ------
    InvalidInputError
        If there is no place, or one is invalid, headings are given for a body other than a car,
        or the region has several rings and the body is not a car.

    Examples
    --------
    >>> from multisrt.geometry.bodies.footprint import Footprint
    >>> me = RobotSelf(
    ...     robot=0,
    ...     start=Configuration(1.0, 1.0, 0.0),
    ...     footprint=Footprint.disc(0.25),
    ...     kinematics=Holonomic(),
    ...     range_m=4.0,
    ...     rng=np.random.default_rng(0),
    ... )
    >>> square = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]])
    >>> motion = trajectory_inside(me, me.start, [(3.0, 1.0), (3.0, 9.0)], square)
    >>> round(motion.end.x, 2), round(motion.end.y, 2)
    (3.0, 3.74)
    """
    rows = _rows(me.kinematics, places, headings, may_turn=False)
    if not len(rows):
        raise InvalidInputError("there is no place to go to; give at least one")
    start = _floats(start)
    body = PlanningBody(me.footprint, margin_m)
    if isinstance(me.kinematics, Car):
        return _car_inside(me, me.kinematics, body, start, rows, region)
    path = np.vstack([[start[:2]], [row[:2] for row in rows]])
    return follow(body, me.kinematics, _ring(region), start, path, limit_m=limit_m)


def _car_inside(
    me: RobotSelf,
    car: Car,
    body: PlanningBody,
    start: Configuration,
    rows: list[list[float]],
    region: Region,
) -> Trajectory | None:
    # Leg by leg; a plan by sampling has the seed 1, so that chance makes no difference.
    area = region if isinstance(region, BaseGeometry) else _ring(region)
    motion: Trajectory | None = None
    for row in rows:
        here = start if motion is None else motion.end
        if math.dist(here[:2], row[:2]) < SAME_PLACE_M:
            continue
        if len(row) == 3:
            leg = car_trajectory(body, car, area, here, Configuration(*row), 1)
        else:
            found = car_out_and_back(body, car, area, here, row[0], row[1], 1)
            leg = None if found is None else found[0]
        if leg is None:
            break
        motion = leg if motion is None else motion.then(leg)
    return motion


SAME_PLACE_M = 1e-9
"""Places closer than this are one, in metres."""


def _rows(
    kinematics: Kinematics, places: Any, headings: bool, *, may_turn: bool = True
) -> list[list[float]]:
    rows = rows_of(places)
    numbers: list[list[float]] = rows[:, : 2 + headings].tolist()
    if not headings:
        return numbers
    if len(rows) and rows.shape[1] != 3:
        raise InvalidInputError("places have no headings; give x, y and heading of each (n, 3)")
    if isinstance(kinematics, Holonomic) or not (may_turn or isinstance(kinematics, Car)):
        name = type(kinematics).__name__.lower()
        raise InvalidInputError(f"a {name} body cannot arrive with a given heading; give x and y")
    return numbers


def _ring(region: Region) -> FloatArray:
    if isinstance(region, LocalSafeRegion):
        return region.boundary
    if isinstance(region, Polygon) and not region.interiors:
        return np.ascontiguousarray(shapely.get_coordinates(region.normalize())[-2::-1])
    if isinstance(region, BaseGeometry):
        raise InvalidInputError(
            f"a {region.geom_type} of several rings is no region for a body that drives straight; "
            "give a polygon without holes, such as the region of a scan"
        )
    ring = np.ascontiguousarray(region, np.float64)
    if ring.ndim != 2 or ring.shape[1] != 2 or len(ring) < 3 or not np.isfinite(ring).all():
        raise InvalidInputError(
            f"a region is a ring (n, 2) of at least 3 finite corners, not {ring.shape}"
        )
    return ring


def _onward(here: Configuration, row: list[float], later: list[list[float]]) -> float:
    # The direction of the next place, at the last one that in which it is reached.
    for a, b in pairwise([row, *later]):
        if math.dist(a[:2], b[:2]) >= SAME_PLACE_M:
            return wrap_angle(math.atan2(b[1] - a[1], b[0] - a[0]))
    if math.dist(here[:2], row[:2]) < SAME_PLACE_M:
        return here.heading
    return wrap_angle(math.atan2(row[1] - here.y, row[0] - here.x))


def _floats(start: Configuration) -> Configuration:
    x, y, heading = map(float, start)
    return Configuration(x, y, heading)
