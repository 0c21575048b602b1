"""Where the robots of a team start: scattered, clustered, at random, or at the base station."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from functools import lru_cache

import numpy as np
import shapely
from numpy.random import Generator as RandomGenerator
from shapely import Point, Polygon
from shapely.geometry.base import BaseGeometry

from multisrt.environments.area_text import area_text
from multisrt.environments.environment import Environment
from multisrt.environments.formats.geojson import degrees_hint
from multisrt.environments.parts import enclosing, inside
from multisrt.geometry.bodies.collision import Body, body_distance
from multisrt.geometry.bodies.footprint import Footprint
from multisrt.geometry.configuration import Configuration
from multisrt.geometry.errors import InvalidInputError, counted
from multisrt.geometry.numerics.kernel import BoolArray, FloatArray
from multisrt.geometry.regions.edge_index import EdgeIndex
from multisrt.geometry.regions.visibility import visibility_polygon
from multisrt.planners.motion.kinematics import Car
from multisrt.simulation.base_station import require_free
from multisrt.simulation.random_streams import RandomStreams
from multisrt.simulation.rooms import body_fits, misfit, needed_clearance
from multisrt.spec import RunSpec

GAP_M = 0.25
"""Distance in metres between the circumscribed circles of two bodies that are placed."""

CANDIDATES = 30
"""Number of random positions that are drawn for a robot.

A scattered robot takes the one farthest from all others, one that starts at random the first where
it has room beside them.
"""

SUBDIVISION = 3
"""Steps of the lattice of a cluster from one position for a robot to the next."""

ROOM = 1.1
"""Clearance that a placed robot has from walls, as a multiple of its circumscribed radius."""

ROOM_AT_BASE = 1.01
"""Room around the middle of a team at the base station, as a multiple of what its robots need, so
that it is not on the border of where they have room."""

SIGHT_M = 10.0
"""Maximum distance of the middle of a team from the base station at which it starts, in metres."""

MAX_REASONS = 3
"""Number of suggested starts of which is told why they do not suit a robot."""

CIRCLE_PRECISION_M = 0.01
"""Precision of the largest circle in free space, in metres."""


def starts_of(
    spec: RunSpec, environment: Environment, streams: RandomStreams | None = None
) -> tuple[Configuration, ...]:
    """Return the configurations in which the robots of a run start.

    Robots with a start in the spec start there. A single robot without one starts at the first
    suggested start of the environment that its body fits at or, if the environment suggests none,
    at a position drawn uniformly where it has room in any heading, but not in a part that lies
    around a building (`multisrt.environments.parts.inside`). In a team, robots are
    scattered, each at the one of `CANDIDATES` such positions that is farthest from the others,
    with a random heading; or each at such a position where it has room beside the others; or at the
    suggested starts, in their order; or clustered around the first one, which starts like a single
    robot, and in its heading, at the nodes of a hexagonal lattice that are in its sight or have the
    shortest paths; or so around the place nearest to the base station, in its sight, with room,
    in a random heading.

    Parameters
    ----------
    spec : RunSpec
        The run.
    environment : Environment
        The world.
    streams : RandomStreams, optional
        The random streams of the run; by default those of its seed.

    Returns
    -------
    tuple of Configuration
        One for each robot, in one connected component of free space.

    Raises
    ------
    ClearanceError
        If a body does not fit at its start; the message gives the distance from free space, or the
        clearance there and the one that the body needs, and the nearest place where it fits.
    InvalidInputError
        If starts lie in different components, bodies overlap or touch, the team does not fit, or
        the turning circle of a car fits nowhere.
    """
    streams = streams or RandomStreams(spec.seed)
    footprints = [Footprint.parse(robot.footprint) for robot in spec.robots]
    starts: dict[int, Configuration] = {}
    for number, robot in enumerate(spec.robots):
        if robot.start is not None:
            starts[number] = Configuration(*robot.start)
            _require_fit(environment, footprints[number], starts[number])
    component = _common_component(environment, starts)
    _require_apart(footprints, starts)
    if len(starts) < len(footprints):
        if spec.starts == "suggested":
            _take_suggested(environment, component if starts else None, footprints, starts)
        elif spec.starts == "base":
            _gather_at_base(streams, environment, spec, footprints, starts)
        elif len(footprints) == 1:
            starts[0] = _alone(streams, environment, footprints[0])
        elif spec.starts == "clustered":
            _gather_at_first(streams, environment, footprints, starts)
        else:
            take = _farthest if spec.starts == "scattered" else _first
            _place(streams, environment, component, footprints, starts, take)
    ordered = tuple(starts[number] for number in range(len(footprints)))
    _require_turning_circles(spec, environment, footprints, ordered[0])
    return ordered


def drawn_start(
    environment: Environment, footprint: Footprint, rng: RandomGenerator
) -> Configuration:
    """Return a random configuration, uniform where a body has room in any heading.

    It is not in a part that lies around a building (`multisrt.environments.parts.inside`).

    Raises
    ------
    InvalidInputError
        If the body fits nowhere.
    """
    place = _drawn_place(_default_room(environment, footprint), rng)
    return Configuration(place.x, place.y, float(rng.uniform(-math.pi, math.pi)))


# What is asked of starts --------------------------------------------------------------------


def _require_fit(environment: Environment, footprint: Footprint, start: Configuration) -> None:
    if not body_fits(environment, footprint, start):
        raise misfit(environment, footprint, start)


def _common_component(environment: Environment, starts: dict[int, Configuration]) -> Polygon:
    # The component of all starts, or the main one if there are none.
    if not starts:
        return inside(environment)[0]
    first = min(starts)
    component = environment.component(*starts[first][:2])
    for number, (x, y, _) in starts.items():
        if not shapely.contains_xy(component, x, y):
            raise InvalidInputError(
                f"robots {first} and {number} start at ({starts[first].x:g}, "
                f"{starts[first].y:g}) and ({x:g}, {y:g}) of {environment.name!r}, which no path "
                "through free space connects; let all start in one connected area"
            )
    return component


def _require_apart(footprints: list[Footprint], starts: dict[int, Configuration]) -> None:
    for a, at_a in starts.items():
        for b, at_b in starts.items():
            between = at_a.distance(at_b)
            ample = footprints[a].circumscribed_radius_m + footprints[b].circumscribed_radius_m
            if b <= a or between > ample:
                continue
            if body_distance(Body(footprints[a]), at_a, Body(footprints[b]), at_b) > 0.0:
                continue
            least = footprints[a].inscribed_radius_m + footprints[b].inscribed_radius_m
            needed = f"{least:.3g} to {ample:.3g} m, by their headings"
            if footprints[a].is_disc and footprints[b].is_disc:
                needed = f"more than {ample:g} m"
            raise InvalidInputError(
                f"robots {a} and {b} touch or overlap at their starts: ({at_a.x:g}, {at_a.y:g}) "
                f"and ({at_b.x:g}, {at_b.y:g}) are {between:.4g} m apart, and the bodies "
                f"{footprints[a]} and {footprints[b]} need {needed}; move one of them"
            )


def _require_turning_circles(
    spec: RunSpec, environment: Environment, footprints: list[Footprint], start: Configuration
) -> None:
    drives = [robot.drive.kinematics() for robot in spec.robots]
    cars = [(n, drive.turning_radius_m) for n, drive in enumerate(drives) if isinstance(drive, Car)]
    if not cars:
        return
    component = environment.component(start.x, start.y)
    circle = shapely.maximum_inscribed_circle(component, tolerance=CIRCLE_PRECISION_M)
    room = float(shapely.length(circle))
    for number, radius in cars:
        beside = footprints[number].inscribed_radius_m
        if radius + beside > room + CIRCLE_PRECISION_M:
            most = room - beside
            remedy = f"about {most:.2f} m would fit" if most > 0.0 else "none would fit"
            raise InvalidInputError(
                f"robot {number} is a car with a turning radius of {radius:g} m, whose turning "
                f"circle fits nowhere in the free space of {environment.name!r} around its "
                f"start: {remedy}; choose a smaller turning radius or a wider world"
            )


# A robot alone ------------------------------------------------------------------------------


def _alone(streams: RandomStreams, environment: Environment, footprint: Footprint) -> Configuration:
    if environment.starts:
        return _suggested(environment, footprint)
    area = _default_room(environment, footprint)
    start = _drawn_place(area, streams.of("starts"))
    _require_fit(environment, footprint, start)
    return start


def _suggested(environment: Environment, footprint: Footprint) -> Configuration:
    # The first suggested start that a body fits at. Map files suggest starts for other bodies.
    starts = [Configuration(*place) for place in environment.starts]
    for start in starts:
        if body_fits(environment, footprint, start):
            return start
    raise misfit(environment, footprint, starts[0])


def _take_suggested(
    environment: Environment,
    component: Polygon | None,
    footprints: list[Footprint],
    starts: dict[int, Configuration],
) -> None:
    # In their order, without those at which a body does not fit or that are cut off from the first.
    left, given = list(environment.starts), len(starts)
    for number in range(len(footprints)):
        if number in starts:
            continue
        reasons = []
        for place in tuple(left):
            start = Configuration(*place)
            if why := _unsuitable(environment, component, footprints, starts, number, start):
                reasons.append(why)
                continue
            left.remove(place)
            starts[number] = start
            component = component or environment.component(*place)
            break
        else:
            raise _too_few_suggested(
                environment, len(starts) - given, len(footprints) - given, reasons, alone=not given
            )


def _unsuitable(
    environment: Environment,
    component: Polygon | None,
    footprints: list[Footprint],
    starts: dict[int, Configuration],
    number: int,
    start: Configuration,
) -> str:
    # Why a robot cannot take a suggested start; empty if it can.
    place, footprint = f"({start.x:g}, {start.y:g})", footprints[number]
    if not body_fits(environment, footprint, start):
        return (
            f"the body {footprint} does not fit at {place}, where the clearance is "
            f"{environment.clearance(start.x, start.y):.6g} m and it needs "
            f"{needed_clearance(footprint)}"
        )
    if component is not None and not shapely.contains_xy(component, start.x, start.y):
        return f"{place} is in another part of free space"
    try:
        _require_apart(footprints, {**starts, number: start})
    except InvalidInputError:
        return f"{place} is too near to another robot"
    return ""


def _too_few_suggested(
    environment: Environment, taken: int, wanted: int, reasons: list[str], *, alone: bool
) -> InvalidInputError:
    # `reasons` are those of the starts that are left; `alone` says that no robot has a start given.
    number, otherwise = len(environment.starts), "in another way (--start, --starts)"
    smaller = any("does not fit" in reason for reason in reasons)
    why = "; ".join(reasons[:MAX_REASONS])
    if (more := len(reasons) - MAX_REASONS) > 0:
        why += f"; and so for {counted(more, 'more start')}"
    why = f"{why}: " if why else ""
    if not number:
        said = f"no starts: place robots {otherwise}"
    elif not taken:
        said = (
            f"{counted(number, 'start')}, at which no robot has room: {why}"
            f"{'choose smaller bodies, or ' * smaller}place robots {otherwise}"
        )
    else:
        said = (
            f"{counted(number, 'start')}, with room for {taken} of the {wanted} robots "
            f"together: {why}choose {'smaller bodies or ' * smaller}fewer robots, "
            f"{'let the others stand around the first (--starts clustered), ' * alone}"
            f"or place the others {otherwise}"
        )
    return InvalidInputError(f"{environment.name!r} suggests {said}")


def _default_room(environment: Environment, footprint: Footprint) -> Polygon:
    # In all of free space but the part around a building.
    parts = inside(environment)
    is_all = len(parts) == len(environment.components)
    free = environment.free if is_all else shapely.MultiPolygon(parts)
    return _largest_room(environment, free, footprint)


def _largest_room(environment: Environment, free: BaseGeometry, footprint: Footprint) -> Polygon:
    # The largest area of positions with room in any heading.
    radius = footprint.circumscribed_radius_m
    parts = [part for part in shapely.get_parts(_roomy(free, radius)) if not part.is_empty]
    if not parts:
        layers = environment.layers
        around, hint = enclosing(environment), degrees_hint(environment)
        where = f"{environment.name!r}"
        if around is not None:
            where = (
                f"the parts of {where} around which that of {area_text(around.area.area)} m2 lies"
            )
        remedy = f"choose a smaller body{' or its start' * (around is not None)}"
        if layers is not None and layers.problem:
            remedy = layers.problem
        raise InvalidInputError(
            f"the body {footprint} fits nowhere in {where}: it needs a clearance of "
            f"{radius:.3g} m; {remedy}{'; ' * bool(hint)}{hint}"
        )
    largest: Polygon = max(parts, key=lambda part: part.area)
    return largest


def _roomy(free: BaseGeometry, radius: float) -> BaseGeometry:
    return free.buffer(-ROOM * radius)


def _drawn_place(area: Polygon, rng: RandomGenerator) -> Configuration:
    shapely.prepare(area)
    x0, y0, x1, y1 = area.bounds
    while True:
        x, y = rng.uniform((x0, y0), (x1, y1))
        if shapely.contains_xy(area, x, y):
            return Configuration(float(x), float(y))


# A scattered team, or one at random places --------------------------------------------------

_Take = Callable[[FloatArray, FloatArray, FloatArray], tuple[float, float] | None]
"""Takes one of several places, by where others stand and how far from each it must be."""


def _place(
    streams: RandomStreams,
    environment: Environment,
    component: Polygon,
    footprints: list[Footprint],
    starts: dict[int, Configuration],
    take: _Take,
) -> None:
    for number, footprint in enumerate(footprints):
        if number in starts:
            continue
        radius = footprint.circumscribed_radius_m
        room = _room(environment, component, footprint)
        others = np.array([starts[other][:2] for other in starts]).reshape(-1, 2)
        needed = np.array(
            [radius + GAP_M + footprints[other].circumscribed_radius_m for other in starts]
        )
        rng = streams.of("starts", number)
        place = take(room.draw(rng), others, needed)
        if place is None:
            # If all draws were too near the others, draw from what these leave free.
            taken = shapely.union_all(shapely.buffer(shapely.points(others), needed))
            left = _Room(room.area.difference(taken))
            place = take(left.draw(rng), others, needed) if left.is_open else None
        if place is None:
            raise _does_not_fit(environment, len(starts), len(footprints))
        starts[number] = Configuration(*place, float(rng.uniform(-math.pi, math.pi)))


def _farthest(
    places: FloatArray, others: FloatArray, needed: FloatArray
) -> tuple[float, float] | None:
    # The position farthest from all others, of those that are far enough from each.
    if not len(others):
        return float(places[0, 0]), float(places[0, 1])
    apart = np.hypot(*(places[:, None] - others).transpose(2, 0, 1))
    nearest = np.where((apart >= needed).all(axis=1), apart.min(axis=1), -math.inf)
    best = int(np.argmax(nearest))
    return (float(places[best, 0]), float(places[best, 1])) if nearest[best] > 0.0 else None


def _first(
    places: FloatArray, others: FloatArray, needed: FloatArray
) -> tuple[float, float] | None:
    # The first position that is far enough from each, so that all such are equally likely.
    apart = np.hypot(*(places[:, None] - others).transpose(2, 0, 1))
    fits = (apart >= needed).all(axis=1)
    if not fits.any():
        return None
    x, y = places[np.argmax(fits)].tolist()
    return x, y


class _Room:
    """An area from which positions are drawn uniformly."""

    def __init__(self, area: BaseGeometry) -> None:
        self.area = area
        triangles = shapely.get_parts(shapely.constrained_delaunay_triangles(area))
        self._corners = shapely.get_coordinates(triangles).reshape(-1, 4, 2)[:, :3]
        self._shares = np.cumsum(shapely.area(triangles))

    @property
    def is_open(self) -> bool:
        """Whether its area is positive."""
        return len(self._shares) > 0 and self._shares[-1] > 0.0

    def draw(self, rng: RandomGenerator) -> FloatArray:
        """Return `CANDIDATES` random positions, ``(n, 2)``."""
        which, u, v = rng.random((3, CANDIDATES))
        chosen = np.searchsorted(self._shares, which * self._shares[-1], side="right")
        a, b, c = self._corners[np.minimum(chosen, len(self._shares) - 1)].transpose(1, 0, 2)
        # Points in the other half of the parallelogram are mirrored into the triangle.
        beyond = u + v > 1.0
        u, v = np.where(beyond, 1.0 - u, u), np.where(beyond, 1.0 - v, v)
        places: FloatArray = a + u[:, None] * (b - a) + v[:, None] * (c - a)
        return places


@lru_cache(maxsize=16)
def _room(environment: Environment, component: Polygon, footprint: Footprint) -> _Room:
    # Triangulated once for many runs in one world.
    return _Room(_largest_room(environment, component, footprint))


# A clustered team ---------------------------------------------------------------------------


def _gather_at_first(
    streams: RandomStreams,
    environment: Environment,
    footprints: list[Footprint],
    starts: dict[int, Configuration],
) -> None:
    if not starts:
        starts[0] = _alone(streams, environment, footprints[0])
    first = min(starts)
    beside_m = footprints[first].circumscribed_radius_m
    _cluster(environment, footprints, starts, starts[first], beside_m=beside_m)


def _gather_at_base(
    streams: RandomStreams,
    environment: Environment,
    spec: RunSpec,
    footprints: list[Footprint],
    starts: dict[int, Configuration],
) -> None:
    assert spec.base is not None
    require_free(spec.base, environment)
    base = spec.base.place
    waiting = [body for number, body in enumerate(footprints) if number not in starts]
    radius = max(body.circumscribed_radius_m for body in waiting)
    # The nearest place in sight of it: the nearest of all may be in the next room.
    sight, _ = visibility_polygon(EdgeIndex(environment.edges, SIGHT_M / 3.0), *base, SIGHT_M)
    room = _roomy(environment.component(*base), ROOM_AT_BASE * radius)
    room = shapely.intersection(room, shapely.make_valid(Polygon(sight)))
    if room.is_empty:
        raise InvalidInputError(
            f"the largest body that starts at the base station ({base[0]:g}, {base[1]:g}) of "
            f"{environment.name!r} has no room in its sight, within {SIGHT_M:g} m: it needs a "
            f"clearance of {ROOM * radius:.3g} m; move the base station, or take smaller robots"
        )
    x, y = shapely.get_coordinates(shapely.shortest_line(room, Point(base)))[0].tolist()
    heading = float(streams.of("starts").uniform(-math.pi, math.pi))
    anchor = Configuration(x, y, heading)
    _cluster(environment, footprints, starts, anchor, beside_m=0.0)
    _common_component(environment, starts)


def _cluster(
    environment: Environment,
    footprints: list[Footprint],
    starts: dict[int, Configuration],
    anchor: Configuration,
    *,
    beside_m: float,
) -> None:
    # At the anchor and around it, beside the robots that stand already, of which one of this
    # circumscribed radius may stand at the anchor.
    waiting = [number for number in range(len(footprints)) if number not in starts]
    radius = max(footprints[number].circumscribed_radius_m for number in waiting)
    lattice = _Lattice(
        environment.component(anchor.x, anchor.y),
        anchor,
        # One lattice for all, with room for the largest body beside that one and beside itself.
        pitch=radius + max(radius, beside_m) + GAP_M,
        radius=radius,
        passage=min(footprint.inscribed_radius_m for footprint in footprints),
    )
    taken = np.array([start[:2] for start in starts.values()]).reshape(-1, 2)
    needed = np.array(
        [radius + GAP_M + footprints[number].circumscribed_radius_m for number in starts]
    )
    places = lattice.nearest(len(waiting), taken, needed)
    if len(places) < len(waiting):
        raise _does_not_fit(environment, len(starts) + len(places), len(footprints))
    for number, (x, y) in zip(waiting, places, strict=True):
        starts[number] = Configuration(x, y, anchor.heading)


_Node = tuple[int, int]
_AROUND: tuple[_Node, ...] = ((1, 0), (0, 1), (-1, 1), (-1, 0), (0, -1), (1, -1))


class _Lattice:
    """A hexagonal lattice about a position, as far as free space connects its nodes.

    Robots may stand at the nodes whose numbers are multiples of `SUBDIVISION`; the other nodes
    are there to find paths round corners and through doors.
    """

    def __init__(
        self,
        component: Polygon,
        center: Configuration,
        *,
        pitch: float,
        radius: float,
        passage: float,
    ) -> None:
        self._component = component
        # No path leads through a slit that is much narrower than any body.
        self._passable = component.buffer(-0.5 * passage)
        self._roomy = _roomy(component, radius)
        for area in (self._component, self._passable, self._roomy):
            shapely.prepare(area)
        self._center = center
        self._step = pitch / SUBDIVISION

    def nearest(
        self, count: int, taken: FloatArray, needed: FloatArray
    ) -> list[tuple[float, float]]:
        """Return positions for robots, the nearest first.

        The distance is the straight one for positions in sight, else that along the lattice.

        Parameters
        ----------
        count : int
            Maximum number of positions.
        taken : (n, 2) array
            Where other robots stand.
        needed : (n,) array
            Minimum distance of a position from each of them, in metres.
        """
        found: list[tuple[float, _Node]] = []
        for hops, ring in enumerate(self._rings()):
            # The straight distance of nodes `hops` away is at least that many rows.
            found.sort()
            if len(found) >= count and found[count - 1][0] <= hops * self._step * math.sqrt(0.75):
                break
            nodes = [node for node in ring if node[0] % SUBDIVISION == node[1] % SUBDIVISION == 0]
            if not nodes:
                continue
            places = self._places(nodes)
            apart = np.hypot(*(places[:, None] - taken).transpose(2, 0, 1))
            has_room = shapely.contains_xy(self._roomy, *places.T) & (apart >= needed).all(axis=1)
            in_sight = self._connects(self._component, [(0, 0)] * len(nodes), nodes)
            for node, fits, straight in zip(nodes, has_room, in_sight, strict=True):
                if fits:
                    q, r = node
                    length = math.sqrt(q * q + q * r + r * r) if straight else hops
                    found.append((length * self._step, node))
        places = self._places([node for _, node in sorted(found)[:count]])
        return [(float(x), float(y)) for x, y in places]

    def _rings(self) -> Iterator[list[_Node]]:
        # The nodes that are 0, 1, 2, ... hops away, by breadth-first search.
        ring: list[_Node] = [(0, 0)]
        seen = {(0, 0)}
        while ring:
            yield ring
            pairs = [
                (node, (node[0] + dq, node[1] + dr))
                for node in ring
                for dq, dr in _AROUND
                if (node[0] + dq, node[1] + dr) not in seen
            ]
            ring = []
            if not pairs:
                return
            free = self._connects(self._passable, *map(list, zip(*pairs, strict=True)))
            for (_, node), is_free in zip(pairs, free, strict=True):
                if is_free and node not in seen:
                    seen.add(node)
                    ring.append(node)

    def _places(self, nodes: list[_Node]) -> FloatArray:
        q, r = np.array(nodes, dtype=np.float64).reshape(-1, 2).T
        x = self._center.x + self._step * (q + 0.5 * r)
        return np.column_stack([x, self._center.y + self._step * math.sqrt(0.75) * r])

    def _connects(self, area: BaseGeometry, here: list[_Node], there: list[_Node]) -> BoolArray:
        lines = np.stack([self._places(here), self._places(there)], axis=1)
        return np.asarray(shapely.covers(area, shapely.linestrings(lines)), dtype=np.bool_)


def _does_not_fit(environment: Environment, fitting: int, team: int) -> InvalidInputError:
    return InvalidInputError(
        f"of the {team} robots, {fitting} fit at the start into {environment.name!r}, "
        f"{GAP_M:g} m apart; take fewer or smaller robots, a larger world, or give their starts"
    )
