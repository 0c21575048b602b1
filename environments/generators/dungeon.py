"""A dungeon: rooms, and winding corridors between them with loops and dead ends."""

from typing import NamedTuple

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import dijkstra
from shapely import Polygon

from multisrt.environments.environment import Environment
from multisrt.environments.formats.bitmap import polygons_between_lines
from multisrt.environments.generators.as_drawn import starts_among
from multisrt.environments.generators.difficulty import between
from multisrt.environments.generators.parameters import call_text, number, rounded_up, seed_number
from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.numerics import libm
from multisrt.geometry.numerics.kernel import BoolArray, FloatArray, IntArray

PLOT = 7
"""Cells in each row and column of a plot, which has one room or none."""

MIN_CELLS = 2 * PLOT
"""Minimum number of cells in each row and column: with less there would be one room."""

WALL_M = 0.4
"""Minimum width of walls, in metres."""

ROOMS = (0.95, 0.5)
"""Share of the plots with a room, at difficulty 0 and 1."""

WINDING = (0.5, 3.0)
"""Exponent of the random costs of cells, at difficulty 0 and 1; with 0 corridors are straight."""

LOOPS = (1.0, 0.0)
"""Share of the rooms with a corridor to a second room, at difficulty 0 and 1."""

DEAD_ENDS = 2.5
"""Corridors that lead nowhere at difficulty 1, for each plot."""


class _Rooms(NamedTuple):
    """Rooms by their first and last columns and rows of cells, as ``(n,)`` arrays."""

    left: IntArray
    right: IntArray
    low: IntArray
    high: IntArray

    def cells(self, columns: int) -> IntArray:
        """Return the cell in the middle of each room, numbered row by row."""
        found: IntArray = (self.low + self.high) // 2 * columns + (self.left + self.right) // 2
        return found


def dungeon(
    *, size_m: float = 40.0, difficulty: float = 0.5, passage_m: float = 1.4, seed: int = 0
) -> Environment:
    """Draw a square dungeon.

    Rooms and corridors cover cells of a grid with walls between them. Corridors are the cheapest
    paths over cells of random cost, from every room to one room and from some rooms to a second
    one. All cells are as wide as `passage_m`, so that a disc of diameter ``0.9 * passage_m``
    reaches everything.

    Parameters
    ----------
    size_m : float
        Inner width and height, 16 to 1000 m, with room for 2 x 2 plots; free space may be smaller.
    difficulty : float
        From 0 to 1: there are fewer rooms and fewer loops, corridors are more winding, and up to
        2.5 corridors for each plot of 7 x 7 cells lead nowhere. The length of walls per free area
        and the number of dead ends grow with it.
    passage_m : float
        Width of the corridors, 0.8 to 6 m.
    seed : int
        Seed of the rooms and the corridors.

    Returns
    -------
    Environment
        The world, in metres, with suggested starts.

    Raises
    ------
    InvalidInputError
        If a parameter is out of range or there is no room for four plots.

    Examples
    --------
    >>> dungeon(size_m=30).origin
    'dungeon(size_m=30, difficulty=0.5, passage_m=1.4, seed=0)'
    """
    size_m = number("dungeon", "size_m", size_m, 16.0, 1000.0)
    difficulty = number("dungeon", "difficulty", difficulty, 0.0, 1.0)
    passage_m = number("dungeon", "passage_m", passage_m, 0.8, 6.0)
    seed = seed_number("dungeon", seed)
    columns = int((size_m + WALL_M) / (passage_m + WALL_M) + 1e-9)
    if columns < MIN_CELLS:
        least = MIN_CELLS * (passage_m + WALL_M) - WALL_M
        raise InvalidInputError(
            f"dungeon: size_m={size_m:g} has no room for rooms with passage_m={passage_m:g}; "
            f"give a size_m of at least {rounded_up(least)} m, or a narrower passage"
        )

    rng = np.random.default_rng(seed)
    rooms = _rooms(columns, between(ROOMS, difficulty), rng)
    middles = rooms.cells(columns)
    inside = _inside(rooms, columns)
    winding = between(WINDING, difficulty)
    first, second = int(middles[0]), int(middles[-1])
    blind = rng.permutation(np.flatnonzero(~inside.ravel()))
    ends = blind[: round(DEAD_ENDS * difficulty * (columns / PLOT) ** 2)]
    looped = middles[rng.random(len(middles)) < between(LOOPS, difficulty)]
    edges = np.vstack(
        [
            _corridors(columns, first, np.concatenate([middles, ends]), winding, inside, rng),
            _corridors(columns, second, np.append(looped, first), winding, inside, rng),
        ]
    )
    cells = _Cells(size_m, passage_m, columns)
    near, middle, far = 0.0, size_m / 2, size_m
    return Environment(
        "dungeon",
        cells.drawn(rooms, edges),
        starts=starts_among(
            cells.middles(rooms),
            [(middle, middle), (near, near), (far, far), (near, far), (far, near)],
        ),
        origin=call_text(
            "dungeon", size_m=size_m, difficulty=difficulty, passage_m=passage_m, seed=seed
        ),
    )


def _rooms(columns: int, share: float, rng: np.random.Generator) -> _Rooms:
    """Return rooms of 2 to 6 cells in plots; the last row and column of a plot stay without."""
    plots = columns // PLOT
    spare = columns - plots * PLOT
    stands = rng.random(plots * plots) < share
    stands[[0, -1]] = True
    corner_y, corner_x = np.divmod(np.flatnonzero(stands), plots)
    size = rng.integers(2, PLOT - 1, (2, len(corner_x)), endpoint=True)
    shift = np.floor(rng.random((2, len(corner_x))) * (PLOT - size)).astype(np.int64)
    left = corner_x * PLOT + spare // 2 + shift[0]
    low = corner_y * PLOT + spare // 2 + shift[1]
    return _Rooms(left, left + size[0] - 1, low, low + size[1] - 1)


def _inside(rooms: _Rooms, columns: int) -> BoolArray:
    """Return which cells are in rooms."""
    inside = np.zeros((columns, columns), dtype=np.bool_)
    for left, right, low, high in zip(*rooms, strict=True):
        inside[low : high + 1, left : right + 1] = True
    return inside


def _corridors(
    columns: int,
    root: int,
    ends: IntArray,
    winding: float,
    inside: BoolArray,
    rng: np.random.Generator,
) -> IntArray:
    """Return the steps of the cheapest paths from ends to a root as ``(n, 2)`` pairs of cells."""
    index = np.arange(columns * columns).reshape(columns, columns)
    one = np.concatenate([index[:, :-1].ravel(), index[:-1].ravel()])
    other = np.concatenate([index[:, 1:].ravel(), index[1:].ravel()])
    cost = np.where(inside.ravel(), 0.5, 0.02 + libm.power(rng.random(columns * columns), winding))
    weights = np.round(cost[one] + cost[other], 9)
    graph = coo_array((weights, (one, other)), (columns * columns,) * 2).tocsr()
    _, before = dijkstra(graph, directed=False, indices=np.array(root), return_predecessors=True)
    reached = np.zeros(columns * columns, dtype=np.bool_)
    reached[root] = True
    current = np.unique(ends[~reached[ends]])
    while current.size:
        reached[current] = True
        current = np.unique(before[current])
        current = current[~reached[current]]
    reached[root] = False
    taken = np.flatnonzero(reached)
    return np.sort(np.column_stack([taken, before[taken]]), axis=1)


class _Cells:
    """The grid in the world: where cells and walls are."""

    def __init__(self, size_m: float, passage_m: float, columns: int) -> None:
        pitch = (size_m - passage_m) / (columns - 1)
        self.lows: FloatArray = np.round(np.arange(columns) * pitch, 3)
        self.highs: FloatArray = np.round(self.lows + passage_m, 3)
        self.columns = columns

    def middles(self, rooms: _Rooms) -> FloatArray:
        """Return the middles of rooms, ``(n, 2)`` in metres."""
        x = (self.lows[rooms.left] + self.highs[rooms.right]) / 2
        y = (self.lows[rooms.low] + self.highs[rooms.high]) / 2
        return np.column_stack([x, y])

    def drawn(self, rooms: _Rooms, steps: IntArray) -> Polygon:
        """Return rooms and corridors, the latter by pairs of neighbouring cells."""
        # Cells have even numbers here, and the walls between them odd ones.
        open_ = np.zeros((2 * self.columns - 1,) * 2, dtype=np.bool_)
        row, column = np.divmod(steps, self.columns)
        open_[2 * row, 2 * column] = True
        open_[row.sum(axis=1), column.sum(axis=1)] = True
        for left, right, low, high in zip(*rooms, strict=True):
            open_[2 * low : 2 * high + 1, 2 * left : 2 * right + 1] = True
        # A post is open where all four walls around it are.
        walls = open_[::2, 1::2], open_[1::2, ::2]
        open_[1::2, 1::2] = walls[0][:-1] & walls[0][1:] & walls[1][:, :-1] & walls[1][:, 1:]
        lines = np.column_stack([self.lows, self.highs]).ravel()
        (free,) = polygons_between_lines(open_, lines, lines).geoms
        return free
