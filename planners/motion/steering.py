"""Motions of a body to a place in a region that is known to be free (MOVE_TO of Multi-SRT)."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence

import numpy as np
import shapely
from shapely import Polygon
from shapely.affinity import translate
from shapely.geometry.base import BaseGeometry
from shapely.geometry.polygon import orient

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
from multisrt.planners.motion.margin import MIN_MARGIN_M
from multisrt.planners.motion.trajectory import Trajectory, standing_at

MIN_SAVED_S = 1e-6
"""Minimum time in seconds that a curve has to save."""

PULL_OUT_STEPS = 32
"""Number of distances at which room to turn is looked for, up to four radii of the body."""

PULL_OUT_SIDES = 16
"""Number of directions in which a holonomic body looks for room to turn."""

PULL_OUT_TURNS = tuple(sign * math.radians(k) for k in range(0, 95, 5) for sign in (1, -1))[1:]
"""Turns before a body drives to where it has room to turn, in radians, the smallest first."""


def reach(
    body: PlanningBody,
    kinematics: Kinematics,
    boundary: FloatArray,
    start: Configuration,
    direction: float,
    limit: float,
) -> float:
    """Return how far a body can move straight in a direction, after turning to it if necessary.

    Parameters
    ----------
    body, kinematics
        The body that moves, and how. A car is assumed to face the direction already.
    boundary : (n, 2) array
        The region in metres; it contains the body.
    start : Configuration
        Configuration of the body.
    direction : float
        Direction of the motion in radians.
    limit : float
        Maximum distance of interest in metres.

    Returns
    -------
    float
        Metres, at most `limit`; 0 if the body cannot turn or move.

    Examples
    --------
    >>> from multisrt.geometry.bodies.footprint import Footprint
    >>> body = PlanningBody(Footprint.disc(0.25), margin_m=0.05)
    >>> square = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]])
    >>> distance = reach(body, Holonomic(), square, Configuration(1.0, 2.0, 0.0), 0.0, 9.0)
    >>> round(distance, 3)  # up to the margin before the wall at x = 4
    2.7
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
    """Return `reach` for an array of directions, ``(k,)``."""
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
    *,
    saves_turns: bool = False,
) -> Trajectory | None:
    """Return the motion to a place inside a region: straight after a turn, or after a curve.

    Parameters
    ----------
    body, kinematics
        The body that moves, and how.
    boundary : (n, 2) array
        The region in metres; it contains the body.
    start : Configuration
        Configuration of the body.
    x, y : float
        The place in metres.
    saves_turns : bool
        Whether a differential body turns on the way where it is sooner there and there is room for
        the curve, and also drives backwards where it would have to turn by more than a right angle
        to drive forwards. Otherwise it turns first, and drives backwards only where it has no room
        to turn.

    Returns
    -------
    Trajectory or None
        None if neither a turn nor a curve with a straight motion stays in the region.

    Examples
    --------
    >>> from multisrt.geometry.bodies.footprint import Footprint
    >>> body = PlanningBody(Footprint.disc(0.25), margin_m=0.05)
    >>> square = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]])
    >>> steer(body, Holonomic(), square, Configuration(1.0, 2.0, 0.0), 3.0, 2.0).length_m
    2.0
    >>> steer(body, Holonomic(), square, Configuration(1.0, 2.0, 0.0), 3.9, 2.0) is None
    True
    """
    distance = math.hypot(x - start.x, y - start.y)
    direction = math.atan2(y - start.y, x - start.x)
    if isinstance(kinematics, Holonomic):
        passes = body.passes(boundary, start, direction, distance)
        return kinematics.drive(start, x, y) if passes else None
    if saves_turns:
        curve = _quickest_curve(body, kinematics, boundary, start, x, y)
        if curve is not None:
            return curve
    headings = [direction, direction + math.pi]
    if saves_turns and math.cos(direction - start.heading) < 0.0:
        headings.reverse()
    for wanted in headings:
        for turn in turns_between(start.heading, wanted):
            if body.can_turn(boundary, start, turn):
                turned = kinematics.turn(start, turn)
                at = turned.end
                if body.passes(boundary, at, direction, distance):
                    return turned.then(kinematics.drive(at, x, y))
                if body.is_disc:
                    # A disc passes in no other heading either.
                    return None
    return None


def _quickest_curve(
    body: PlanningBody,
    kinematics: Differential,
    boundary: FloatArray,
    start: Configuration,
    x: float,
    y: float,
) -> Trajectory | None:
    """Return the quickest motion in a curve; None if none saves time and stays in the region.

    A body that is no disc keeps the largest margin that it has at the start.
    """
    ahead = math.atan2(y - start.y, x - start.x) - start.heading
    turn = math.asin(abs(math.sin(ahead)))  # forwards or backwards
    straight_s = math.hypot(x - start.x, y - start.y) / kinematics.speed_m_s
    first_turned_s = straight_s + turn / kinematics.turn_rate_rad_s
    curves = [kinematics.curve(start, x, y, backwards=backwards) for backwards in (False, True)]
    quicker = [c for c in curves if c is not None and c.duration_s < first_turned_s - MIN_SAVED_S]
    if not quicker or (room := body.room(boundary, start)) is None:
        return None
    quicker.sort(key=lambda curve: curve.duration_s)
    return next((curve for curve in quicker if room.lets_pass(curve.waypoints)), None)


def to_room_to_turn(
    body: PlanningBody,
    kinematics: Holonomic | Differential,
    boundary: FloatArray,
    start: Configuration,
    spare_m: float = 0.0,
) -> Trajectory | None:
    """Return a straight motion, after the smallest turn, to where a body fits in any heading.

    A holonomic body does not turn, and goes in one of `PULL_OUT_SIDES` directions.

    Parameters
    ----------
    body, kinematics
        The body that moves, and how.
    boundary : (n, 2) array
        The region in metres; it contains the body.
    start : Configuration
        Configuration of the body, in which it has no room to turn in place.
    spare_m : float
        Minimum distance to the border of the region in metres that the body is to have in any
        heading, besides its margin.

    Returns
    -------
    Trajectory or None
        The shortest after that turn, forwards or backwards; None if the body has room already, or
        no such motion of up to four of its radii stays in the region.

    Examples
    --------
    >>> from multisrt.geometry.bodies.footprint import Footprint
    >>> body = PlanningBody(Footprint.parse("box:0.6x0.4"), margin_m=0.02)
    >>> square = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]])
    >>> motion = to_room_to_turn(body, Differential(), square, Configuration(0.35, 2.0, 0.0))
    >>> motion.start.x < motion.end.x, body.has_room(square, motion.end)
    (True, True)
    """
    if body.has_room(boundary, start, spare_m):
        return None
    steps = np.arange(1, PULL_OUT_STEPS + 1) * (4.0 * body.outer_radius_m / PULL_OUT_STEPS)
    for first, directions in _ways_out(body, kinematics, boundary, start):
        for distance, direction in itertools.product(steps.tolist(), directions):
            x = start.x + distance * math.cos(direction)
            y = start.y + distance * math.sin(direction)
            end = Configuration(x, y, first.end.heading)
            has_room = body.has_room(boundary, end, spare_m)
            if has_room and (
                body.passes(boundary, first.end, direction, distance)
                or body.leaves(boundary, first.end, direction, distance)
            ):
                return first.then(kinematics.drive(first.end, x, y))
    return None


def _ways_out(
    body: PlanningBody,
    kinematics: Holonomic | Differential,
    boundary: FloatArray,
    start: Configuration,
) -> Iterator[tuple[Trajectory, Sequence[float]]]:
    """Yield motions with which a body can begin, and the directions in which it goes on."""
    if isinstance(kinematics, Holonomic):
        yield standing_at(start), [math.tau * k / PULL_OUT_SIDES for k in range(PULL_OUT_SIDES)]
        return
    for turn in PULL_OUT_TURNS:
        if body.can_turn(boundary, start, turn):
            ahead = start.heading + turn
            yield kinematics.turn(start, turn), (ahead, ahead + math.pi)


def clear_of(
    boundary: FloatArray, own: Polygon, others: Sequence[Polygon], apart_m: float
) -> FloatArray | None:
    """Return the part of a region in which a body stays as far from others as it is, or farther.

    Parameters
    ----------
    boundary : (n, 2) array
        The region in metres; it contains the body.
    own : Polygon
        The body where it is.
    others : sequence of Polygon
        The other bodies, which count as convex.
    apart_m : float
        A body that is farther away than this may come as near as this.

    Returns
    -------
    (m, 2) array or None
        It lacks what is behind the others, as seen by the body. None if the body touches one.

    Examples
    --------
    >>> square = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]])
    >>> own, other = shapely.box(1.0, 1.0, 1.5, 1.5), shapely.box(2.0, 1.0, 2.5, 1.5)
    >>> left = shapely.Polygon(clear_of(square, own, [other], apart_m=0.1))
    >>> [left.covers(shapely.Point(x, 1.2)) for x in (1.89, 1.91, 3.0)], left.covers(own)
    ([True, False, False], True)
    """
    if not others:
        return boundary
    beyond_m = 2.0 * float(np.ptp(boundary, axis=0).sum())
    region: BaseGeometry = Polygon(boundary)
    for other in others:
        line = shapely.shortest_line(own, other.convex_hull)
        if line.length <= 2.0 * MIN_MARGIN_M:
            return None
        apart = other.convex_hull.buffer(min(line.length - 2.0 * MIN_MARGIN_M, apart_m))
        (x0, y0), (x1, y1) = shapely.get_coordinates(line).tolist()
        scale = beyond_m / line.length
        behind = translate(apart, scale * (x1 - x0), scale * (y1 - y0))
        region = region.difference(shapely.union(apart, behind).convex_hull)
    parts = shapely.get_parts(region).tolist()
    part = next((part for part in parts if part.intersects(own.representative_point())), None)
    return None if part is None else shapely.get_coordinates(orient(part).exterior)[:-1]


def turn_and_drive(
    kinematics: Holonomic | Differential, start: Configuration, x: float, y: float
) -> Trajectory:
    """Return the straight motion to a place, without looking for obstacles.

    Parameters
    ----------
    kinematics : Holonomic or Differential
        How the body moves. A differential drive turns first, the shorter way.
    start : Configuration
        Where the motion begins.
    x, y : float
        The place in metres.

    Returns
    -------
    Trajectory

    Examples
    --------
    >>> motion = turn_and_drive(Differential(), Configuration(0.0, 0.0, 0.0), 0.0, 2.0)
    >>> len(motion.waypoints), motion.length_m
    (3, 2.0)
    """
    if isinstance(kinematics, Holonomic):
        return kinematics.drive(start, x, y)
    if (x, y) == (start.x, start.y):
        return kinematics.turn(start, 0.0)
    direction = math.atan2(y - start.y, x - start.x)
    turned = kinematics.turn(start, turns_between(start.heading, direction)[0])
    return turned.then(kinematics.drive(turned.end, x, y))
