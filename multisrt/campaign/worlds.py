"""Worlds of a campaign: generated, transformed, narrow and unusual ones, and bundled maps.

A campaign has `POOL` worlds, which its seed determines, so that few have to be built for many
missions. Some of them cannot be built, as their parameters exclude each other; missions in them are
drawn again.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import lru_cache
from typing import Final, Literal

import msgspec
import shapely
from shapely import LineString, Point, Polygon, affinity, box
from shapely.geometry.base import BaseGeometry

from multisrt.campaign.chance import Chance, rounded
from multisrt.environments.catalog import default_parameters, names
from multisrt.environments.environment import Environment
from multisrt.geometry.errors import InvalidInputError
from multisrt.simulation.worlds import build_environment
from multisrt.spec import CatalogEnvironment, InlineEnvironment, Scalar
from multisrt.spec.environments import EnvironmentSpec

POOL: Final = 400
"""Number of worlds of a campaign."""

STREAM: Final = 0
"""Key of the random streams of worlds, after the seed of the campaign."""

KINDS: Final = {"generated": 0.45, "turned": 0.13, "passages": 0.2, "odd": 0.2, "bundled": 0.02}
"""Kinds of worlds, with weights."""

SIZES_M: Final = {"small": (5.0, 10.0), "usual": (8.0, 16.0), "large": (14.0, 28.0)}
"""Widths of generated worlds, in metres."""

GROWTH: Final = 1.25
"""Factor by which they grow where a generator makes no world that small."""

MAX_TRIES: Final = 10
"""Draws of one generated world; most of them fail as rooms, cells or plots become too narrow."""

GRID_M: Final = 1e-3
"""Grid of the coordinates of worlds that are drawn here, in metres."""

MAX_AREA_M2: Final = 900.0
"""Largest area of free space of a world that is not a bundled map."""


def world(seed: int, number: int) -> EnvironmentSpec:
    """Return a world of a campaign.

    Parameters
    ----------
    seed : int
        Seed of the campaign.
    number : int
        Number of the world, from 0 to `POOL` - 1.

    Returns
    -------
    CatalogEnvironment or InlineEnvironment
        The world.

    Raises
    ------
    InvalidInputError
        If no world of the kind that was drawn can be built.

    Examples
    --------
    >>> world(1, 2) == world(1, 2)
    True
    """
    chance = Chance(seed, STREAM, number)
    match chance.weighted(KINDS):
        case "generated":
            return _generated(chance)
        case "turned":
            return _turned(chance)
        case "passages":
            return _inline("passages", _passages(chance))
        case "odd":
            name = chance.one_of(tuple(ODD))
            return _inline(name, ODD[name](chance))
    return CatalogEnvironment(name=chance.one_of([n for n in names() if not default_parameters(n)]))


def world_of(spec: EnvironmentSpec) -> Environment:
    """Return a world, built once for many missions of a process.

    Parameters
    ----------
    spec : EnvironmentSpec
        The world.

    Returns
    -------
    Environment
        The world; equal specs give the same object as long as it is kept.

    Raises
    ------
    InvalidInputError
        If it cannot be built.

    Examples
    --------
    >>> world_of(CatalogEnvironment(name="open")).area_m2
    400.0
    """
    return _built(msgspec.json.encode(spec))


@lru_cache(maxsize=POOL)
def _built(spec: bytes) -> Environment:
    described: EnvironmentSpec = msgspec.json.decode(spec, type=EnvironmentSpec)
    return build_environment(described)


def _inline(name: str, free: BaseGeometry) -> InlineEnvironment:
    return InlineEnvironment(name=name, wkt=shapely.to_wkt(free, rounding_precision=-1))


# Generated worlds ---------------------------------------------------------------------------


def _generated(chance: Chance) -> CatalogEnvironment:
    name = chance.one_of([name for name in names() if default_parameters(name)])
    low, high = SIZES_M[chance.weighted({"small": 0.72, "usual": 0.25, "large": 0.03})]
    for _ in range(MAX_TRIES):
        parameters = {
            parameter: _parameter(parameter, default, chance, (low, high))
            for parameter, default in default_parameters(name)
            if _is_size(parameter, default) or chance.happens(0.6)
        }
        drawn = CatalogEnvironment(name=name, parameters=parameters, seed=chance.whole(0, 9999))
        try:
            area_m2 = world_of(drawn).area_m2
        except InvalidInputError:
            low, high = GROWTH * low, GROWTH * high
            continue
        if area_m2 <= MAX_AREA_M2:
            return drawn
        low, high = low / GROWTH, high / GROWTH
    raise InvalidInputError(f"none of {MAX_TRIES} draws of {name} is possible and small")


def _is_size(parameter: str, default: float) -> bool:
    return parameter.endswith("_m") and default >= 15.0


def _parameter(
    parameter: str, default: float, chance: Chance, sizes_m: tuple[float, float]
) -> Scalar:
    if isinstance(default, bool):
        return chance.happens(0.5)
    if isinstance(default, int):
        return max(chance.whole(0, 3), round(default * chance.magnitude(0.2, 1.0)))
    if _is_size(parameter, default):
        return chance.number(*sizes_m)
    if 0.0 <= default <= 1.0 and not parameter.endswith("_m"):
        return chance.number(0.0, 1.0)
    return rounded(default * chance.magnitude(0.7, 1.6))


def _turned(chance: Chance) -> InlineEnvironment:
    """Return a generated world that is turned, at times skewed, mirrored or far from the origin."""
    built = world_of(_generated(chance))
    free = affinity.rotate(built.free, chance.number(-180.0, 180.0), origin=(0.0, 0.0))
    if chance.happens(0.3):
        free = affinity.skew(free, chance.number(-15.0, 15.0), origin=(0.0, 0.0))
    if chance.happens(0.2):
        free = affinity.scale(free, -1.0, 1.0, origin=(0.0, 0.0))
    if chance.happens(0.2):
        far_m = chance.magnitude(100.0, 50_000.0)
        free = affinity.translate(free, far_m, -0.37 * far_m)
    return _inline(f"turned-{built.name}", _part(free))


# Worlds drawn here --------------------------------------------------------------------------


def _passages(chance: Chance) -> Polygon:
    """Return a tree of passages, some of them with rooms, at right angles or at any."""
    width_m = chance.number(0.55, 1.8)
    square = chance.happens(0.4)
    slant = chance.number(0.0, 90.0) if chance.happens(0.5) else 0.0
    joints = [(0.0, 0.0)]
    parts: list[BaseGeometry] = []
    for _ in range(chance.whole(2, 8)):
        x, y = chance.one_of(joints)
        angle = 90.0 * chance.whole(0, 3) if square else chance.number(0.0, 360.0)
        length_m = chance.number(1.5, 7.0)
        end = (
            x + length_m * math.cos(math.radians(angle)),
            y + length_m * math.sin(math.radians(angle)),
        )
        joints.append(end)
        half_m = width_m / 2 * (chance.number(1.0, 1.6) if chance.happens(0.3) else 1.0)
        cap: Literal["square", "round"] = "square" if square or chance.happens(0.5) else "round"
        parts.append(LineString([(x, y), end]).buffer(half_m, cap_style=cap, quad_segs=4))
    for joint in joints:
        if chance.happens(0.4):
            half_m = chance.number(0.6, 2.2)
            room = box(-half_m, -half_m * chance.number(0.6, 1.0), half_m, half_m)
            if chance.happens(0.4):
                room = Point(0.0, 0.0).buffer(half_m, quad_segs=3)
            parts.append(affinity.translate(room, *joint))
    return _part(affinity.rotate(shapely.union_all(parts), slant, origin=(0.0, 0.0)))


def _closet(chance: Chance) -> Polygon:
    """Return a room hardly larger than a few bodies."""
    room = box(0.0, 0.0, chance.number(0.9, 3.5), chance.number(0.9, 3.5))
    return _part(affinity.rotate(room, chance.number(0.0, 90.0)))


def _ring(chance: Chance) -> Polygon:
    """Return a passage around a block, with many corners or few."""
    corners = chance.whole(1, 12)
    radius_m, width_m = chance.number(2.0, 6.0), chance.number(0.7, 2.0)
    outer = Point(0.0, 0.0).buffer(radius_m, quad_segs=corners)
    inner = Point(0.0, 0.0).buffer(max(0.3, radius_m - width_m), quad_segs=corners)
    return _part(outer.difference(inner))


def _comb(chance: Chance) -> Polygon:
    """Return a passage with dead ends at regular distances."""
    teeth, width_m = chance.whole(2, 6), chance.number(0.7, 1.4)
    pitch_m, length_m = width_m + chance.number(0.1, 1.0), chance.number(0.5, 4.0)
    parts = [box(0.0, 0.0, teeth * pitch_m, width_m)]
    parts += [box(i * pitch_m, 0.0, i * pitch_m + width_m, length_m) for i in range(teeth)]
    slant = chance.number(0.0, 90.0) if chance.happens(0.5) else 0.0
    return _part(affinity.rotate(shapely.union_all(parts), slant, origin=(0.0, 0.0)))


def _saw(chance: Chance) -> Polygon:
    """Return a hall whose walls are zigzags."""
    width_m, height_m = chance.number(4.0, 12.0), chance.number(3.0, 8.0)
    teeth, depth_m = chance.whole(3, 25), chance.number(0.05, 1.0)
    xs = [width_m * i / (2 * teeth) for i in range(2 * teeth + 1)]
    low = [(x, depth_m * (i % 2)) for i, x in enumerate(xs)]
    high = [(x, height_m - depth_m * (i % 2)) for i, x in enumerate(reversed(xs))]
    return _part(Polygon(low + high))


def _pillars(chance: Chance) -> Polygon:
    """Return a hall with thin pillars and thin walls that stand free."""
    width_m, height_m = chance.number(5.0, 12.0), chance.number(5.0, 12.0)
    hall: BaseGeometry = box(0.0, 0.0, width_m, height_m)
    for _ in range(chance.whole(1, 14)):
        x, y = chance.number(0.5, width_m - 0.5), chance.number(0.5, height_m - 0.5)
        radius_m = chance.magnitude(0.01, 0.5)
        pillar: BaseGeometry = Point(x, y).buffer(radius_m, quad_segs=chance.whole(1, 3))
        if chance.happens(0.3):
            thin = box(x, y, x + chance.number(0.2, 3.0), y + chance.magnitude(0.01, 0.1))
            pillar = affinity.rotate(thin, chance.number(0.0, 180.0))
        hall = hall.difference(pillar)
    return _part(hall)


def _star(chance: Chance) -> Polygon:
    """Return a room with long points."""
    points, inner = chance.whole(3, 9), chance.number(0.8, 2.5)
    corners = []
    for i in range(2 * points):
        radius_m = inner if i % 2 else inner * chance.number(1.2, 4.0)
        angle = math.pi * i / points
        corners.append((radius_m * math.cos(angle), radius_m * math.sin(angle)))
    return _part(Polygon(corners))


def _doors(chance: Chance) -> Polygon:
    """Return rooms in a row, with doors hardly wider than bodies."""
    rooms, wall_m = chance.whole(2, 4), chance.magnitude(0.02, 0.5)
    side_m, door_m = chance.number(2.0, 5.0), chance.number(0.45, 1.0)
    parts = []
    for i in range(rooms):
        x = i * (side_m + wall_m)
        parts.append(box(x, 0.0, x + side_m, side_m))
        if i:
            y = chance.number(0.0, side_m - door_m)
            parts.append(box(x - wall_m, y, x, y + door_m))
    slant = chance.number(0.0, 90.0) if chance.happens(0.5) else 0.0
    return _part(affinity.rotate(shapely.union_all(parts), slant, origin=(0.0, 0.0)))


def _spiral(chance: Chance) -> Polygon:
    """Return a passage that winds inwards at right angles."""
    pitch_m, turns = chance.number(1.3, 2.2), chance.whole(3, 8)
    places = [(0.0, 0.0)]
    for i in range(turns):
        dx, dy = ((1, 0), (0, 1), (-1, 0), (0, -1))[i % 4]
        length_m = pitch_m * (turns - i)
        x, y = places[-1]
        places.append((x + dx * length_m, y + dy * length_m))
    width_m = chance.number(0.6, pitch_m - 0.3)
    passage = LineString(places).buffer(width_m / 2, cap_style="square", join_style="mitre")
    return _part(passage)


def _areas(chance: Chance) -> BaseGeometry:
    """Return areas that nothing connects: a room in the block of a court, and at times others."""
    half_m, wall_m = chance.number(1.5, 3.0), chance.magnitude(0.02, 0.5)
    room = box(-half_m, -half_m, half_m, half_m)
    block = room.buffer(wall_m, join_style="mitre")
    parts = [room, block.buffer(chance.number(0.8, 2.5), join_style="mitre").difference(block)]
    for _ in range(chance.whole(0, 2)):
        beside_m = shapely.union_all(parts).bounds[2] + wall_m
        parts.append(affinity.translate(room, beside_m + half_m, chance.number(-2.0, 2.0)))
    turned = affinity.rotate(shapely.union_all(parts), chance.number(0.0, 90.0), origin=(0.0, 0.0))
    return shapely.set_precision(turned, GRID_M)


ODD: Final[dict[str, Callable[[Chance], BaseGeometry]]] = {
    "closet": _closet,
    "ring": _ring,
    "comb": _comb,
    "saw": _saw,
    "pillars": _pillars,
    "star": _star,
    "doors": _doors,
    "spiral": _spiral,
    "areas": _areas,
}
"""Worlds with something odd about each, by name."""


def _part(free: BaseGeometry) -> Polygon:
    """Return the largest part of free space, on the grid."""
    snapped = shapely.set_precision(free, GRID_M)
    parts = [part for part in shapely.get_parts(snapped) if isinstance(part, Polygon)]
    largest = max(parts, key=lambda part: part.area, default=None)
    if largest is None or largest.area > MAX_AREA_M2:
        raise InvalidInputError("a world of a campaign is one area that is not too large")
    return largest
