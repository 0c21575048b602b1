"""A cavern, grown by a cellular automaton."""

import math

import numpy as np
from scipy import ndimage
from scipy.sparse import coo_array
from scipy.sparse.csgraph import minimum_spanning_tree

from multisrt.environments.environment import Environment
from multisrt.environments.formats.bitmap import polygons_from_grid
from multisrt.environments.generators.as_drawn import on_millimetres, starts_among
from multisrt.environments.generators.parameters import call_text, number, rounded_up, seed_number
from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.numerics.kernel import BoolArray, FloatArray, IntArray

TOLERANCE_CELLS = 0.25
"""Maximum displacement of walls by which the outline of the cells is smoothed, in cells."""

ROCK = (0.43, 0.53)
"""Share of rock in the noise that the automaton starts from, at difficulty 0 and 1."""

GENERATIONS = 5
MIN_CELLS = 12
"""Minimum number of cells in each row and column."""

MIN_CHAMBER = 24
"""Places of the square below which a chamber is filled instead of being joined to the others."""

MIN_FREE = 0.2
"""Minimum share of free places; with fewer, the share of rock in the noise is reduced."""


def cavern(
    *, size_m: float = 30.0, difficulty: float = 0.5, passage_m: float = 1.2, seed: int = 0
) -> Environment:
    """Draw a cavern: chambers and pillars of no regular shape, joined by narrow tunnels.

    The majority rule of a cellular automaton turns random cells of rock into a cavern. Free space
    is what a square of 2 x 2 cells can cover; chambers between which the square cannot move are
    joined by tunnels of its width. A disc of diameter ``0.9 * passage_m`` therefore reaches
    everything.

    ``cave`` is a bundled map, not this generator.

    Parameters
    ----------
    size_m : float
        Inner width and height, 10 to 1000 m, rounded down to whole cells.
    difficulty : float
        From 0 (a wide cave with pillars) to 1 (a labyrinth of small chambers): the share of rock
        grows, and with it the length of walls per free area.
    passage_m : float
        Width of the narrowest tunnels, 0.8 to 6 m. Chambers and pillars scale with it.
    seed : int
        Seed of the rock.

    Returns
    -------
    Environment
        The world, in metres, with suggested starts.

    Raises
    ------
    InvalidInputError
        If a parameter is out of range or there is no room for chambers.

    Notes
    -----
    Source: L. Johnson, G. N. Yannakakis and J. Togelius, Cellular automata for real-time
    generation of infinite cave levels, 2010; differs in: one bounded world, chambers joined by a
    minimum spanning tree of tunnels, and an outline that is straightened like that of a bitmap.

    Examples
    --------
    >>> easy, hard = cavern(size_m=20, difficulty=0), cavern(size_m=20, difficulty=1)
    >>> easy.area_m2 > hard.area_m2
    True
    """
    size_m = number("cavern", "size_m", size_m, 10.0, 1000.0)
    difficulty = number("cavern", "difficulty", difficulty, 0.0, 1.0)
    passage_m = number("cavern", "passage_m", passage_m, 0.8, 6.0)
    seed = seed_number("cavern", seed)

    cell_m = passage_m / (2.0 - 2.0 * TOLERANCE_CELLS)
    cells = math.floor(size_m / cell_m + 1e-9)
    if cells < MIN_CELLS:
        raise InvalidInputError(
            f"cavern: size_m={size_m:g} has no room for chambers with passage_m={passage_m:g}; "
            f"give a size_m of at least {rounded_up(MIN_CELLS * cell_m)} m, or a narrower passage"
        )
    noise = np.random.default_rng(seed).random((cells, cells))
    rock = ROCK[0] + difficulty * (ROCK[1] - ROCK[0])
    places = _joined(_grown(noise, rock))
    while places.sum() < MIN_FREE * places.size:
        rock -= 0.02
        places = _joined(_grown(noise, rock))
    free = polygons_from_grid(_covered(places), cell_m, tolerance_cells=TOLERANCE_CELLS)
    roomy = ndimage.binary_erosion(places, np.ones((3, 3), np.bool_))
    row, column = np.nonzero(roomy if roomy.any() else places)
    near, middle, far = 0.0, cells * cell_m / 2, cells * cell_m
    return Environment(
        "cavern",
        on_millimetres(free),
        starts=starts_among(
            np.column_stack([column + 1.0, row + 1.0]) * cell_m,
            [(middle, middle), (near, near), (far, far), (near, far), (far, near)],
        ),
        origin=call_text(
            "cavern", size_m=size_m, difficulty=difficulty, passage_m=passage_m, seed=seed
        ),
    )


def _grown(noise: FloatArray, rock: float) -> BoolArray:
    """Return the cells of rock after all generations; everything beyond the border is rock."""
    solid = noise < rock
    for _ in range(GENERATIONS):
        around = ndimage.convolve(
            solid.astype(np.uint8), np.ones((3, 3), np.uint8), mode="constant", cval=1
        )
        solid = around >= 5
    return solid


def _places(free: BoolArray) -> BoolArray:
    """Return the places of a square of 2 x 2 cells in free cells, by its lower left cell."""
    found: BoolArray = free[:-1, :-1] & free[1:, :-1] & free[:-1, 1:] & free[1:, 1:]
    return found


def _covered(places: BoolArray) -> BoolArray:
    """Return the cells that a square of 2 x 2 cells covers at its places."""
    rows, columns = places.shape
    free = np.zeros((rows + 1, columns + 1), dtype=np.bool_)
    for row in (0, 1):
        for column in (0, 1):
            free[row : row + rows, column : column + columns] |= places
    return free


def _joined(solid: BoolArray) -> BoolArray:
    """Return the places of the square in large chambers and in the tunnels that join them."""
    places = _places(~solid)
    chambers, count = ndimage.label(places)
    if count == 0:
        return places
    sizes = np.bincount(chambers.ravel())
    sizes[0] = 0
    kept = sizes >= min(MIN_CHAMBER, sizes.max())
    large: BoolArray = kept[chambers]
    chambers, count = ndimage.label(large)
    if count > 1:
        _dig(large, chambers.astype(np.int64), count)
    return large


def _dig(places: BoolArray, chambers: IntArray, count: int) -> None:
    """Join chambers along a minimum spanning tree of the shortest paths through rock."""
    away, nearest = ndimage.distance_transform_edt(~places, return_indices=True)
    owner = chambers[tuple(nearest)]
    index = np.arange(places.size).reshape(places.shape)
    one = np.concatenate([index[:, :-1].ravel(), index[:-1].ravel()])
    other = np.concatenate([index[:, 1:].ravel(), index[1:].ravel()])
    owners = owner.ravel()
    border = owners[one] != owners[other]
    one, other = one[border], other[border]
    cost = away.ravel()[one] + away.ravel()[other] + 1.0
    pair = np.sort(np.column_stack([owners[one], owners[other]]) - 1, axis=1)
    order = np.lexsort((one, cost, pair[:, 1], pair[:, 0]))
    _, first = np.unique(pair[order], axis=0, return_index=True)
    best = order[first]
    graph = coo_array((np.round(cost[best], 6), (pair[best, 0], pair[best, 1])), (count, count))
    tree = minimum_spanning_tree(graph.tocsr()).tocoo()
    of_pair = {(int(a), int(b)): int(k) for (a, b), k in zip(pair[best], best, strict=True)}
    for a, b in zip(*tree.coords, strict=True):
        k = of_pair[int(a), int(b)]
        for cell in (one[k], other[k]):
            row, column = np.unravel_index(cell, places.shape)
            _carve(places, (int(row), int(column)), tuple(nearest[:, row, column]))


def _carve(places: BoolArray, start: tuple[int, int], end: tuple[int, int]) -> None:
    """Add the places of a tunnel with one bend."""
    (row, column), (last_row, last_column) = start, end
    places[min(row, last_row) : max(row, last_row) + 1, column] = True
    places[last_row, min(column, last_column) : max(column, last_column) + 1] = True
