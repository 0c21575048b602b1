"""A city: streets and squares, blocks of buildings of many shapes with alleys between them."""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from shapely import Polygon, box

from multisrt.environments.environment import Environment
from multisrt.environments.generators.as_drawn import polygon_around, starts_among
from multisrt.environments.generators.difficulty import between
from multisrt.environments.generators.parameters import call_text, number, rounded_up, seed_number
from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.numerics import libm
from multisrt.geometry.numerics.kernel import FloatArray

WIDER_M = 8.0
"""Width added to the passage in the streets at difficulty 0, in metres."""

AVENUE = 1.7
"""Width of an avenue, as a multiple of a street's."""

QUARTER_M = 160.0
"""Width from which a part of the city is split by an avenue, in metres."""

BLOCK_M = 42.0
"""Maximum width of a block between streets, in metres."""

MIN_BLOCK_M = 4.0
"""Minimum width of the part of the city that is not the street around it, in metres."""

LOT_M = (26.0, 13.0)
"""Maximum width of a building's lot, at difficulty 0 and 1, in metres."""

SQUARES = (0.25, 0.04)
"""Share of the blocks that are squares, at difficulty 0 and 1."""

COURTS = (0.1, 0.7)
"""Share of the buildings around a court, at difficulty 0 and 1."""

MIN_COURT_M = 8.0
"""Minimum width of a building around a court that robots enter, in metres."""

TREE_M = 0.5
"""Radius of the trees on squares, in metres."""

ROUND = np.linspace(0.0, math.tau, 16, endpoint=False)
OCTAGON = np.linspace(0.0, math.tau, 8, endpoint=False) + math.tau / 16


class _Lot(NamedTuple):
    """A rectangle of ground, in metres."""

    x0: float
    y0: float
    x1: float
    y1: float

    @property
    def width_m(self) -> float:
        return self.x1 - self.x0

    @property
    def height_m(self) -> float:
        return self.y1 - self.y0

    def split(self, gap_m: float, share: float) -> "tuple[_Lot, _Lot]":
        """Divide the longer side at a share of it, with a gap between the parts."""
        if self.width_m >= self.height_m:
            left = round(self.x0 + share * (self.width_m - gap_m), 3)
            return self._replace(x1=left), self._replace(x0=round(left + gap_m, 3))
        low = round(self.y0 + share * (self.height_m - gap_m), 3)
        return self._replace(y1=low), self._replace(y0=round(low + gap_m, 3))


def city(
    *, size_m: float = 60.0, difficulty: float = 0.5, passage_m: float = 1.6, seed: int = 0
) -> Environment:
    """Draw a square part of a city.

    The ground is split recursively by avenues and streets, and blocks by alleys, so that streets
    meet at crossings and T-junctions. Each lot has one building: a box, an L, a T, a cross, a
    tower, or wings around a court. No alley or gate is narrower than `passage_m`, so that a disc
    of diameter ``0.9 * passage_m`` reaches everything.

    Parameters
    ----------
    size_m : float
        Inner width and height, 24 to 1000 m.
    difficulty : float
        From 0 to 1: streets shrink from the passage plus 8 m to 1.5 passages, lots become smaller,
        squares rarer, and more buildings have a court with one gate. The length of walls per free
        area grows with it.
    passage_m : float
        Width of the narrowest alleys and gates, 0.8 to 4 m.
    seed : int
        Seed of the streets and the buildings.

    Returns
    -------
    Environment
        The world, in metres, with suggested starts.

    Raises
    ------
    InvalidInputError
        If a parameter is out of range or there is no room for a block.

    Examples
    --------
    >>> city(size_m=40, seed=2).origin
    'city(size_m=40, difficulty=0.5, passage_m=1.6, seed=2)'
    """
    size_m = number("city", "size_m", size_m, 24.0, 1000.0)
    difficulty = number("city", "difficulty", difficulty, 0.0, 1.0)
    passage_m = number("city", "passage_m", passage_m, 0.8, 4.0)
    seed = seed_number("city", seed)

    street_m = round(max(1.5 * passage_m, passage_m + (1.0 - difficulty) * WIDER_M), 3)
    least = 2 * street_m + MIN_BLOCK_M
    if size_m < least:
        raise InvalidInputError(
            f"city: size_m={size_m:g} has no room for a block between streets of {street_m:.3g} m; "
            f"give a size_m of at least {rounded_up(least)} m, a narrower passage or a greater "
            "difficulty"
        )
    rng = np.random.default_rng(seed)
    lot_m = max(between(LOT_M, difficulty), 4 * passage_m)
    buildings: list[Polygon] = []
    blocks = _blocks(size_m, street_m, rng)
    order, share = rng.permutation(len(blocks)), between(SQUARES, difficulty)
    squares = set(order[: round(share * len(blocks))].tolist())
    for place, block in enumerate(blocks):
        if place in squares:
            buildings += _square(block, passage_m, rng)
            continue
        for lot in _lots(block, lot_m, passage_m, rng):
            court = rng.random() < between(COURTS, difficulty)
            buildings.append(_building(lot, passage_m, court, rng))
    side = street_m / 2
    near, far = side, size_m - side
    return Environment(
        "city",
        polygon_around(box(0.0, 0.0, size_m, size_m), buildings),
        starts=starts_among(
            np.array([(x, y) for x in (near, far) for y in (near, far)]),
            [(near, near), (far, far), (near, far), (far, near)],
        ),
        origin=call_text(
            "city", size_m=size_m, difficulty=difficulty, passage_m=passage_m, seed=seed
        ),
    )


def _blocks(size_m: float, street_m: float, rng: np.random.Generator) -> list[_Lot]:
    """Return the blocks between avenues and streets, with a street around all of them."""
    far = round(size_m - street_m, 3)
    parts, blocks = [_Lot(street_m, street_m, far, far)], []
    while parts:
        part = parts.pop()
        longest = max(part.width_m, part.height_m)
        if longest <= BLOCK_M:
            blocks.append(part)
            continue
        gap = round(street_m * (AVENUE if longest > QUARTER_M else rng.uniform(1.0, 1.25)), 3)
        parts += part.split(gap, rng.uniform(0.38, 0.62))
    return blocks


def _lots(block: _Lot, lot_m: float, passage_m: float, rng: np.random.Generator) -> list[_Lot]:
    """Return the lots of a block, with alleys between them."""
    parts, lots = [block], []
    while parts:
        part = parts.pop()
        if max(part.width_m, part.height_m) <= lot_m:
            lots.append(part)
            continue
        gap = round(passage_m * rng.uniform(1.0, 1.6), 3)
        parts += part.split(gap, rng.uniform(0.4, 0.6))
    return lots


def _square(block: _Lot, passage_m: float, rng: np.random.Generator) -> list[Polygon]:
    """Return the monument of a square, and trees around it where there is room for them."""
    x, y = (block.x0 + block.x1) / 2, (block.y0 + block.y1) / 2
    half_x, half_y = block.width_m / 2 - TREE_M, block.height_m / 2 - TREE_M
    radius = min(2.0, 0.25 * min(block.width_m, block.height_m))
    monument = _regular(x, y, radius, OCTAGON)
    if min(half_x, half_y) < radius + 2 * passage_m + TREE_M:
        return [monument]
    step = max(3.5, 1.2 * (passage_m + 2 * TREE_M))
    along_x = np.linspace(-half_x, half_x, max(2, int(2 * half_x / step) + 1))
    along_y = np.linspace(-half_y, half_y, max(2, int(2 * half_y / step) + 1))
    ring = [(dx, dy) for dx in along_x for dy in (-half_y, half_y)]
    ring += [(dx, dy) for dx in (-half_x, half_x) for dy in along_y[1:-1]]
    stands = rng.random(len(ring)) < 0.8
    return [monument] + [
        _regular(x + dx, y + dy, TREE_M, OCTAGON)
        for (dx, dy), stand in zip(ring, stands, strict=True)
        if stand
    ]


def _building(lot: _Lot, passage_m: float, court: bool, rng: np.random.Generator) -> Polygon:
    """Return a building that fills its lot, with a court if one is wanted and fits."""
    wide, high = lot.width_m, lot.height_m
    wing = max(2.0, 0.22 * min(wide, high))
    if court and min(wide, high) >= max(MIN_COURT_M, 2 * wing + 1.2 * passage_m):
        drawn = _court(wide, high, wing, passage_m, rng)
    else:
        # Notches of a small building would be narrower than the passage.
        shapes = _SHAPES if min(wide, high) >= 4 * passage_m else _SHAPES[:NOTCHLESS]
        drawn = shapes[int(rng.integers(len(shapes)))](wide, high, rng)
    middle = np.array([wide / 2, high / 2])
    flip = np.where(rng.random(2) < 0.5, -1.0, 1.0)
    corner = np.array([lot.x0, lot.y0])
    return Polygon(np.round((drawn - middle) * flip + middle + corner, 3))


def _regular(x: float, y: float, radius: float, turns: FloatArray) -> Polygon:
    return Polygon(
        np.round(np.column_stack([x + radius * libm.cos(turns), y + radius * libm.sin(turns)]), 3)
    )


# Buildings as ``(n, 2)`` corners in a lot of the given width and height, with notches of about a
# half or a third of it.


def _box(wide: float, high: float, rng: np.random.Generator) -> FloatArray:
    return np.array([(0.0, 0.0), (wide, 0.0), (wide, high), (0.0, high)])


def _tower(wide: float, high: float, rng: np.random.Generator) -> FloatArray:
    """Return a round tower, or a box where it would be an oval."""
    if min(wide, high) < 0.7 * max(wide, high):
        return _box(wide, high, rng)
    unit = np.column_stack([libm.cos(ROUND), libm.sin(ROUND)])
    corners: FloatArray = (1.0 + unit) * [wide / 2, high / 2]
    return corners


def _chamfered(wide: float, high: float, rng: np.random.Generator) -> FloatArray:
    cut = rng.uniform(0.15, 0.3) * min(wide, high)
    return np.array(
        [
            *((cut, 0.0), (wide - cut, 0.0), (wide, cut), (wide, high - cut)),
            *((wide - cut, high), (cut, high), (0.0, high - cut), (0.0, cut)),
        ]
    )


def _l_shape(wide: float, high: float, rng: np.random.Generator) -> FloatArray:
    x, y = rng.uniform(0.35, 0.65) * wide, rng.uniform(0.35, 0.65) * high
    return np.array([(0.0, 0.0), (wide, 0.0), (wide, y), (x, y), (x, high), (0.0, high)])


def _t_shape(wide: float, high: float, rng: np.random.Generator) -> FloatArray:
    left, right, y = 0.3 * wide, 0.7 * wide, rng.uniform(0.35, 0.65) * high
    return np.array(
        [
            *((0.0, high), (0.0, y), (left, y), (left, 0.0)),
            *((right, 0.0), (right, y), (wide, y), (wide, high)),
        ]
    )


def _cross(wide: float, high: float, rng: np.random.Generator) -> FloatArray:
    a, b, c, d = 0.3 * wide, 0.7 * wide, 0.3 * high, 0.7 * high
    return np.array(
        [
            *((a, 0.0), (b, 0.0), (b, c), (wide, c), (wide, d), (b, d)),
            *((b, high), (a, high), (a, d), (0.0, d), (0.0, c), (a, c)),
        ]
    )


def _court(
    wide: float, high: float, wing: float, passage_m: float, rng: np.random.Generator
) -> FloatArray:
    """Return wings around a court with a gate in the lower one."""
    gate = rng.uniform(passage_m, max(passage_m, 0.6 * (wide - 2 * wing)))
    left = rng.uniform(wing, wide - wing - gate)
    right = left + gate
    return np.array(
        [
            *((0.0, 0.0), (left, 0.0), (left, wing), (wing, wing), (wing, high - wing)),
            *((wide - wing, high - wing), (wide - wing, wing), (right, wing), (right, 0.0)),
            *((wide, 0.0), (wide, high), (0.0, high)),
        ]
    )


_SHAPES: tuple[Callable[[float, float, np.random.Generator], FloatArray], ...] = (
    _box,
    _tower,
    _chamfered,
    _l_shape,
    _t_shape,
    _cross,
)

NOTCHLESS = 3
"""Number of leading shapes without a notch."""
