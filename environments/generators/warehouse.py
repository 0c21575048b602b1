"""A warehouse: rows of shelves, aisles and cross aisles, and a loading zone."""

import numpy as np
import shapely
from shapely import Polygon, box

from multisrt.environments.environment import Environment
from multisrt.environments.generators.as_drawn import polygon_around, starts_among
from multisrt.environments.generators.parameters import call_text, number, seed_number
from multisrt.geometry.numerics.kernel import FloatArray

SHELF_M = 2.2
"""Depth of two rows of shelves back to back, in metres."""

BACK_M = 1.1
"""Depth of the shelves that close one end of an aisle, in metres."""

WIDER_M = 2.0
"""Width added to the passage in the aisles at difficulty 0, in metres."""

BLOCK_M = (8.0, 24.0)
"""Length of a row of shelves between two cross aisles, at difficulty 0 and 1, in metres."""

CLOSED = 0.6
"""Share of the aisles that are closed at one end, at difficulty 1."""

MISSING = 0.06
"""Share of the rows of shelves that are left out."""

PALLET_M = (1.2, 2.4)
"""Depth and largest width of a stack of pallets in the loading zone, in metres."""


def warehouse(
    *, size_m: float = 32.0, difficulty: float = 0.5, passage_m: float = 1.2, seed: int = 0
) -> Environment:
    """Draw a square warehouse.

    Rows of shelves stand in blocks between cross aisles; there are aisles along the walls, too. The
    loading zone along the lower wall has stacks of pallets. Every aisle is open at one end at
    least and nothing is narrower than `passage_m`, so that a disc of diameter
    ``0.9 * passage_m`` reaches everything.

    Parameters
    ----------
    size_m : float
        Inner width and height, 14 to 1000 m.
    difficulty : float
        From 0 to 1: aisles shrink from the passage plus 2 m to the passage, cross aisles become
        rarer, and up to 0.6 of the aisles are closed at one end. The share of free space with a
        clearance of a metre shrinks with it, and the number of dead ends grows.
    passage_m : float
        Width of the narrowest aisles, 0.8 to 2 m.
    seed : int
        Seed of the widths of the aisles, the rows that are left out, the closed aisles and the
        pallets.

    Returns
    -------
    Environment
        The world, in metres, with suggested starts.

    Raises
    ------
    InvalidInputError
        If a parameter is out of range.

    Examples
    --------
    >>> warehouse(size_m=20).bounds
    (0.0, 0.0, 20.0, 20.0)
    """
    size_m = number("warehouse", "size_m", size_m, 14.0, 1000.0)
    difficulty = number("warehouse", "difficulty", difficulty, 0.0, 1.0)
    passage_m = number("warehouse", "passage_m", passage_m, 0.8, 2.0)
    seed = seed_number("warehouse", seed)

    rng = np.random.default_rng(seed)
    aisle_m = passage_m + (1.0 - difficulty) * WIDER_M
    zone_m = round(min(max(0.2 * size_m, 5.0), 25.0), 2)
    lefts = _lefts(size_m, aisle_m, rng)
    lows, highs = _blocks(zone_m, size_m, aisle_m, difficulty)
    shelves = _shelves(lefts, lows, highs, CLOSED * difficulty, rng)
    pallets = _pallets(size_m, zone_m, passage_m, 0.15 + 0.35 * difficulty, rng)
    side, along = aisle_m / 2, zone_m - passage_m / 2
    return Environment(
        "warehouse",
        polygon_around(box(0.0, 0.0, size_m, size_m), [*shelves, *pallets]),
        starts=starts_among(
            np.array([[x, y] for x in (side, size_m - side) for y in (along, size_m - side)]),
            [(0.0, zone_m), (size_m, zone_m), (0.0, size_m), (size_m, size_m)],
        ),
        origin=call_text(
            "warehouse", size_m=size_m, difficulty=difficulty, passage_m=passage_m, seed=seed
        ),
    )


def _lefts(size_m: float, aisle_m: float, rng: np.random.Generator) -> FloatArray:
    """Return the left sides of the rows, with aisles of at least `aisle_m` around each."""
    rows = int((size_m - aisle_m) / (SHELF_M + 1.12 * aisle_m))
    shares = rng.dirichlet(np.full(rows + 1, 6.0))
    aisles: FloatArray = aisle_m + (size_m - rows * SHELF_M - (rows + 1) * aisle_m) * shares
    lefts: FloatArray = np.round(
        np.cumsum(aisles[:-1]) + SHELF_M * np.arange(rows, dtype=np.float64), 3
    )
    return lefts


def _blocks(
    zone_m: float, size_m: float, aisle_m: float, difficulty: float
) -> tuple[FloatArray, FloatArray]:
    """Return the lower and upper ends of the rows of each block between cross aisles."""
    length = BLOCK_M[0] + difficulty * (BLOCK_M[1] - BLOCK_M[0])
    depth = size_m - aisle_m - zone_m
    blocks = max(1, round((depth + aisle_m) / (length + aisle_m)))
    pitch = (depth + aisle_m) / blocks
    lows = zone_m + pitch * np.arange(blocks)
    return np.round(lows, 3), np.round(lows + pitch - aisle_m, 3)


def _shelves(
    lefts: FloatArray,
    lows: FloatArray,
    highs: FloatArray,
    closed: float,
    rng: np.random.Generator,
) -> list[Polygon]:
    """Return the rows of shelves, joined where an aisle between two is closed at one end."""
    shape = (len(lows), len(lefts))
    stands = rng.random(shape) >= MISSING
    ends, at_top = rng.random(shape), rng.random(shape) < 0.5
    shelves: list[Polygon] = []
    for block, (low, high) in enumerate(zip(lows, highs, strict=True)):
        joined: list[Polygon] = []
        for row in np.flatnonzero(stands[block]):
            left, right = lefts[row], np.round(lefts[row] + SHELF_M, 3)
            joined.append(box(left, low, right, high))
            after = row + 1
            if after < len(lefts) and stands[block, after] and ends[block, row] < closed:
                edge = np.round(high - BACK_M, 3) if at_top[block, row] else low
                joined.append(box(right, edge, lefts[after], np.round(edge + BACK_M, 3)))
                continue
            shelves.append(_union(joined))
            joined = []
    return shelves


def _pallets(
    size_m: float, zone_m: float, passage_m: float, share: float, rng: np.random.Generator
) -> list[Polygon]:
    """Return stacks of pallets in the loading zone, a passage apart from everything else."""
    depth, width = PALLET_M
    rows = int((zone_m - passage_m) / (depth + passage_m))
    columns = int((size_m - passage_m) / (width + passage_m))
    row, column = np.divmod(np.flatnonzero(rng.random(rows * columns) < share), max(columns, 1))
    pitch = (size_m - passage_m) / max(columns, 1)
    widths = rng.choice([0.8, 1.2, width], len(row))
    x = passage_m + column * pitch + rng.random(len(row)) * (pitch - passage_m - widths)
    y = passage_m + row * ((zone_m - passage_m) / max(rows, 1))
    return [
        box(left, low, left + wide, low + depth)
        for left, low, wide in zip(np.round(x, 3), np.round(y, 3), widths, strict=True)
    ]


def _union(boxes: list[Polygon]) -> Polygon:
    """Return the union of a chain of touching boxes."""
    joined = boxes[0] if len(boxes) == 1 else shapely.union_all(boxes).simplify(0.0)
    assert isinstance(joined, Polygon)
    return joined
