"""Collision of bodies with a world and with one another, at rest and in motion, by FCL.

What stays farther off all edges of the world than the body reaches needs no FCL, nor does a disc
that moves straight: the edges near its way tell.

Everything is solid and three-dimensional for FCL. Obstacles are prisms that stand on the floor
z = 0; bodies reach through the floor, from below it to above the obstacles. So a body inside an
obstacle cuts its bottom face, an obstacle inside a body is inside a convex solid, and both are
found; and the distance in space is the distance on the floor. Discs are spheres centred on the
floor, whose distance to a mesh FCL has in closed form.

Static answers are exact to rounding. Touching counts as a collision. Motions with a turn, and
two bodies that move at once, are followed by conservative advancement: a step is as long as the
clearance lets no point of the body reach anything. So that a body can slide along a wall, no
step is shorter than the resolution (1 mm): a contact that is reported is real, and one that is
missed is nowhere deeper than half the resolution.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import fcl
import numpy as np
import shapely
from shapely import MultiPolygon, Polygon
from shapely.geometry.base import BaseGeometry

from multisrt.geometry.bodies.clearance import rings_of
from multisrt.geometry.bodies.footprint import (
    Footprint,
    checked_configuration,
    place,
    require_constant_heading,
    sweep_convex,
)
from multisrt.geometry.bodies.solids import (
    MOST_TILES,
    TILE_M,
    convex_prism,
    polygons_of,
    standing_prisms,
    tiles_of,
)
from multisrt.geometry.configuration import Configuration
from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.regions.edge_index import EdgeIndex, no_edge_within, winding_number

RESOLUTION_M = 1e-3
"""Default length of the shortest step along a motion."""

CONTACT_PRECISION_M = 1e-6
"""How precisely the place of a contact is found, as a length of motion."""

STRAIGHT_RAD = 1e-8
"""A way that turns by less is straight: its arc's centre is too far away to compute with."""

# The distance is FCL's return value. A result that is already nearer keeps the bindings from
# filling it with arrays for nearest points that nobody reads.
_COLLISION_REQUEST = fcl.CollisionRequest()
_DISTANCE_REQUEST = fcl.DistanceRequest()
_UNUSED_RESULT = fcl.DistanceResult(-math.inf)


class Body:
    """A footprint made ready for collision queries; make it once and use it again.

    It holds FCL objects that every query moves: share it between robots, not between threads.
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
        """The shape of the body."""
        return self._footprint

    @property
    def turning_radius_m(self) -> float:
        """How far the body's farthest point travels for each radian of a turn; 0 for a disc."""
        return 0.0 if self._footprint.is_disc else self._footprint.circumscribed_radius_m

    def __repr__(self) -> str:
        return f"Body({self._footprint!r})"


class CollisionWorld:
    """A world's obstacles, made ready once for any number of queries.

    Whatever is not free space is an obstacle, without end to all sides.

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
        tile = max(TILE_M, (x1 - x0) / MOST_TILES, (y1 - y0) / MOST_TILES)
        tiles = [part for whole in polygons_of(solid) for part in tiles_of(whole, tile)]
        self._obstacles = fcl.CollisionObject(standing_prisms(tiles, "world"))
        rings = rings_of(free)
        edges = np.hstack([rings[:-1], rings[1:]])
        self._index = EdgeIndex(edges[np.isfinite(edges).all(axis=1)], tile)
        self._bodies: dict[Footprint, Body] = {}

    def body(self, footprint: Footprint) -> Body:
        """Give the body of a footprint, made at the first call."""
        if footprint not in self._bodies:
            self._bodies[footprint] = Body(footprint)
        return self._bodies[footprint]

    def pose_is_free(self, body: Body, configuration: Sequence[float]) -> bool:
        """Whether a body lies in free space without touching an obstacle.

        Raises
        ------
        InvalidInputError
            If the configuration is not three finite numbers.
        """
        return self._pose_is_free(body, checked_configuration(configuration))

    def clearance(self, body: Body, configuration: Sequence[float]) -> float:
        """Distance from a body to the nearest obstacle in metres; 0 where it is not free.

        Raises
        ------
        InvalidInputError
            If the configuration is not three finite numbers.
        """
        return self._clearance(body, checked_configuration(configuration))

    def straight_motion_is_free(
        self, body: Body, start: Sequence[float], end: Sequence[float]
    ) -> bool:
        """Whether a body can move in a straight line, its heading kept; exact, without steps.

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
            # A disc sweeps whatever is nearer than its radius to the way of its centre.
            return self._keeps_off(first, last, footprint.radius_m)
        step = np.array([last[0] - first[0], last[1] - first[1]])
        swept = (
            fcl.CollisionObject(convex_prism(sweep_convex(place(piece, *first), step)))
            for piece in footprint.convex_pieces
        )
        return not any(_touch((solid,), self._obstacles) for solid in swept)

    def rotation_is_free(
        self,
        body: Body,
        configuration: Sequence[float],
        turn: float,
        *,
        resolution_m: float = RESOLUTION_M,
    ) -> bool:
        """Whether a body can turn in place about its reference point by a signed angle.

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
            What moves.
        start, end : (x, y, heading)
            First and last configuration.
        turn : float, optional
            Signed angle from the first heading to the last, which may go round more than once;
            by default the shorter way.
        arc : bool
            How the reference point moves: on a straight line, or on the circular arc on which
            the motion looks the same from the body all the time (constant twist: a car whose
            wheels stand still, or a differential drive at constant speeds). The heading turns
            evenly in both.
        resolution_m : float
            Length of the shortest step; contacts up to half as deep may be missed.

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
        """
        motion = _motion(body, start, end, turn, arc)
        _require_resolution(resolution_m)
        # Most motions stay so far off all obstacles that the body's heading does not matter.
        reach = body.footprint.circumscribed_radius_m + motion.bulge
        if self._keeps_off(motion.start, motion.pose(1.0), reach + CONTACT_PRECISION_M):
            return None
        return _advance(
            lambda fraction: self._clearance(body, motion.pose(fraction)),
            lambda fraction: self._pose_is_free(body, motion.pose(fraction)),
            motion.length + body.turning_radius_m * abs(motion.turn),
            resolution_m,
        )

    def _pose_is_free(self, body: Body, pose: Configuration) -> bool:
        if not self._within_frame(pose):
            return False
        _move(body._movers, pose)
        return not _touch(body._movers, self._obstacles)

    def _clearance(self, body: Body, pose: Configuration) -> float:
        if not self._within_frame(pose):
            return 0.0
        _move(body._movers, pose)
        return _gap(body._movers, self._obstacles)

    def _keeps_off(self, start: Configuration, end: Configuration, distance_m: float) -> bool:
        # Whether a line lies in free space and farther than a distance from all obstacles.
        index = self._index
        return self._is_in_free_space(start) and no_edge_within(
            *start[:2], *end[:2], distance_m, index.grid
        )

    def _is_in_free_space(self, pose: Configuration) -> bool:
        return winding_number(*pose[:2], self._index.grid) > 0

    def _within_frame(self, pose: Configuration) -> bool:
        """Whether the reference point, which is part of the body, is not outside of everything."""
        x0, y0, x1, y1 = self._bounds
        return x0 < pose[0] < x1 and y0 < pose[1] < y1


def bodies_collide(
    body_a: Body,
    configuration_a: Sequence[float],
    body_b: Body,
    configuration_b: Sequence[float],
) -> bool:
    """Whether two bodies overlap or touch; they may be the same `Body` in two places.

    Raises
    ------
    InvalidInputError
        If a configuration is not three finite numbers.
    """
    return _touch(
        *_pair(
            body_a,
            checked_configuration(configuration_a),
            body_b,
            checked_configuration(configuration_b),
        )
    )


def body_distance(
    body_a: Body,
    configuration_a: Sequence[float],
    body_b: Body,
    configuration_b: Sequence[float],
) -> float:
    """Distance between two bodies in metres, 0 where they overlap or touch.

    Raises
    ------
    InvalidInputError
        If a configuration is not three finite numbers.
    """
    return _apart(
        body_a,
        checked_configuration(configuration_a),
        body_b,
        checked_configuration(configuration_b),
    )


def first_contact_between(
    body_a: Body,
    start_a: Sequence[float],
    end_a: Sequence[float],
    body_b: Body,
    start_b: Sequence[float],
    end_b: Sequence[float],
    *,
    turn_a: float | None = None,
    turn_b: float | None = None,
    arc_a: bool = False,
    arc_b: bool = False,
    gap_m: float = 0.0,
    resolution_m: float = RESOLUTION_M,
) -> float | None:
    """Find when two bodies that move over the same time first meet, or come too near.

    Exact for two discs on straight lines; else by conservative advancement.

    Parameters
    ----------
    body_a, body_b : Body
        What moves; one that stands has equal first and last configurations.
    start_a, end_a, start_b, end_b : (x, y, heading)
        Where they are when the time begins and when it ends; speeds are constant between.
    turn_a, turn_b, arc_a, arc_b, resolution_m
        As in `CollisionWorld.first_contact`.
    gap_m : float
        The distance that counts as contact, and any below it; 0: they touch.

    Returns
    -------
    float or None
        Fraction of the time, from 0 to 1, at which they are still farther apart than the gap
        but within a micrometre of motion of it; 0 if they start in contact; None if they never
        meet.

    Raises
    ------
    InvalidInputError
        As in `CollisionWorld.first_contact`, or if the gap is negative or not finite.
    """
    if not 0.0 <= gap_m < math.inf:
        raise InvalidInputError(f"a gap of {gap_m:g} m; it is 0 or more, and finite")
    a = _motion(body_a, start_a, end_a, turn_a, arc_a)
    b = _motion(body_b, start_b, end_b, turn_b, arc_b)
    if a.center is None and b.center is None:
        approach = math.hypot(a.step[0] - b.step[0], a.step[1] - b.step[1])
    else:
        approach = a.length + b.length
    turning = body_a.turning_radius_m * abs(a.turn) + body_b.turning_radius_m * abs(b.turn)

    def beyond_gap(fraction: float) -> float:
        return _apart(body_a, a.pose(fraction), body_b, b.pose(fraction)) - gap_m

    # Until the circles around the bodies come within the gap, the bodies do not.
    x, y = b.start.x - a.start.x, b.start.y - a.start.y
    vx, vy = b.step[0] - a.step[0], b.step[1] - a.step[1]
    reach = body_a.footprint.circumscribed_radius_m + body_b.footprint.circumscribed_radius_m
    reach += gap_m
    if body_a.footprint.is_disc and body_b.footprint.is_disc and a.center is b.center is None:
        return _last_apart(x, y, vx, vy, reach)
    begin = _first_within(x, y, vx, vy, reach + a.bulge + b.bulge + CONTACT_PRECISION_M)
    if begin is None:
        return None
    _require_resolution(resolution_m)
    return _advance(
        beyond_gap,
        lambda fraction: beyond_gap(fraction) > 0.0,
        approach + turning,
        resolution_m,
        begin,
    )


def _apart(body_a: Body, pose_a: Configuration, body_b: Body, pose_b: Configuration) -> float:
    if body_a.footprint.is_disc and body_b.footprint.is_disc:
        between = math.hypot(pose_b[0] - pose_a[0], pose_b[1] - pose_a[1])
        return max(0.0, between - (body_a.footprint.radius_m + body_b.footprint.radius_m))
    return _gap(*_pair(body_a, pose_a, body_b, pose_b))


def _first_within(x: float, y: float, vx: float, vy: float, radius: float) -> float | None:
    """Fraction at which a point that moves from (x, y) by (vx, vy) enters a disc at the origin."""
    distance = math.hypot(x, y)
    if distance <= radius:
        return 0.0
    closing = -(x * vx + y * vy)
    speed, aside = math.hypot(vx, vy), abs(x * vy - y * vx)
    if closing <= 0.0 or aside > radius * speed:
        return None
    root = math.sqrt((radius * speed - aside) * (radius * speed + aside))
    fraction = (distance - radius) * (distance + radius) / (closing + root)
    return fraction if fraction <= 1.0 else None


def _last_apart(x: float, y: float, vx: float, vy: float, radius: float) -> float | None:
    """Fraction, as `_first_within`, at which the point is still outside by half the precision."""
    fraction = _first_within(x, y, vx, vy, radius)
    if fraction is None or fraction == 0.0:
        return fraction
    back = 0.5 * CONTACT_PRECISION_M / math.hypot(vx, vy)
    while True:
        # More than once only for a way that all but misses the disc.
        fraction = max(0.0, fraction - back)
        if math.hypot(x + fraction * vx, y + fraction * vy) > radius:
            return fraction
        back *= 2.0


@dataclass(frozen=True, slots=True, kw_only=True)
class _Motion:
    """A motion at constant speed and turn rate, on a line or, about a centre, on an arc."""

    start: Configuration
    step: tuple[float, float]
    turn: float
    center: tuple[float, float] | None
    length: float

    @property
    def bulge(self) -> float:
        """No more than this far the motion is from one straight to its end, at any moment."""
        return 0.0 if self.center is None else self.length * abs(self.turn) / 8.0

    def pose(self, fraction: float) -> Configuration:
        x, y, heading = self.start
        turned = fraction * self.turn
        if self.center is None:
            dx, dy = self.step
            return Configuration(x + fraction * dx, y + fraction * dy, heading + turned)
        cx, cy = self.center
        c, s = math.cos(turned), math.sin(turned)
        ox, oy = x - cx, y - cy
        return Configuration(cx + c * ox - s * oy, cy + s * ox + c * oy, heading + turned)


def _motion(
    body: Body, start: Sequence[float], end: Sequence[float], turn: float | None, arc: bool
) -> _Motion:
    first, last = checked_configuration(start), checked_configuration(end)
    if turn is None:
        turn = math.remainder(last[2] - first[2], 2.0 * math.pi)
    elif not math.isfinite(turn):
        raise InvalidInputError(f"a turn of {turn:g} is not finite; give radians")
    elif abs(math.remainder(first.heading + turn - last.heading, 2.0 * math.pi)) > 1e-6:
        raise InvalidInputError(
            f"a turn of {turn:g} rad does not lead from heading {first.heading:g} to "
            f"{last.heading:g}; give the signed angle between them, or leave it out for the "
            "shorter way"
        )
    turn = float(turn)
    dx, dy = last[0] - first[0], last[1] - first[1]
    chord = math.hypot(dx, dy)
    if not arc or chord == 0.0 or abs(turn) < STRAIGHT_RAD:
        return _Motion(start=first, step=(dx, dy), turn=turn, center=None, length=chord)
    half = math.sin(turn / 2.0)
    if abs(half) < 0.25 * STRAIGHT_RAD:
        raise InvalidInputError(
            f"no arc leads from ({first[0]:g}, {first[1]:g}) to ({last[0]:g}, {last[1]:g}) with a "
            f"turn of {turn:g} rad: whole turns on a circle end where they begin"
        )
    # The centre lies on the chord's bisector, to the left for a turn to the left.
    away = 0.5 * math.cos(turn / 2.0) / half
    center = (first[0] + dx / 2.0 - dy * away, first[1] + dy / 2.0 + dx * away)
    length = abs(turn * chord / (2.0 * half))
    return _Motion(start=first, step=(dx, dy), turn=turn, center=center, length=length)


def _require_resolution(resolution: float) -> None:
    if not (math.isfinite(resolution) and resolution > 0.0):
        raise InvalidInputError(f"a resolution of {resolution:g} m; it is positive and finite")


def _advance(
    gap: Callable[[float], float],
    is_free: Callable[[float], bool],
    length: float,
    resolution: float,
    begin: float = 0.0,
) -> float | None:
    """Conservative advancement: the fraction of a motion up to its first contact, or None.

    No point comes nearer to what it might hit than by ``length`` times the fraction passed, so
    a step may use up the whole gap. Up to ``begin`` there is no contact.
    """
    distance = gap(begin)
    if distance <= 0.0:
        return begin
    fraction = begin
    while fraction * length < length:
        before = fraction
        fraction = min(1.0, fraction + max(distance, resolution) / length)
        distance = gap(fraction)
        if distance <= 0.0:
            return _bisect(is_free, before, fraction, CONTACT_PRECISION_M / length)
    return None


def _bisect(
    is_free: Callable[[float], bool], free: float, contact: float, precision: float
) -> float:
    """Narrow down the last free fraction before a contact."""
    while contact - free > precision:
        middle = 0.5 * (free + contact)
        if middle in (free, contact):
            break
        if is_free(middle):
            free = middle
        else:
            contact = middle
    return free


def _pair(
    body_a: Body, pose_a: Configuration, body_b: Body, pose_b: Configuration
) -> tuple[tuple[fcl.CollisionObject, ...], fcl.CollisionObject]:
    """Place two bodies, one of them as the mover and the other as an obstacle.

    A disc moves and a polygon stands: FCL is exact for a sphere against a mesh, not against a
    convex solid.
    """
    if body_b.footprint.is_disc:
        body_a, pose_a, body_b, pose_b = body_b, pose_b, body_a, pose_a
    _move(body_a._movers, pose_a)
    _move((body_b._obstacle,), pose_b)
    return body_a._movers, body_b._obstacle


def _move(objects: tuple[fcl.CollisionObject, ...], pose: Configuration) -> None:
    x, y, heading = pose
    turned = (math.cos(0.5 * heading), 0.0, 0.0, math.sin(0.5 * heading))
    moved = np.array((x, y, 0.0))
    for placed in objects:
        placed.setQuatRotation(turned)
        placed.setTranslation(moved)


def _touch(movers: tuple[fcl.CollisionObject, ...], obstacle: fcl.CollisionObject) -> bool:
    return any(fcl.collide(mover, obstacle, _COLLISION_REQUEST) > 0 for mover in movers)


def _gap(movers: tuple[fcl.CollisionObject, ...], obstacle: fcl.CollisionObject) -> float:
    """Distance between solids, 0 on contact, for which FCL's own value is not always defined."""
    if _touch(movers, obstacle):
        return 0.0
    distances = [
        fcl.distance(mover, obstacle, _DISTANCE_REQUEST, _UNUSED_RESULT) for mover in movers
    ]
    return max(0.0, float(min(distances)))


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
