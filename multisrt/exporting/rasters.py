"""Maps as cells for a map server: free, occupied or unknown."""

from __future__ import annotations

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray

from multisrt.environments.environment import Environment
from multisrt.environments.formats.files import MAX_CELLS
from multisrt.exporting.grids import FREE_CELL, OCCUPIED_CELL, Cells, values_of
from multisrt.exporting.map_content import MapContent, Raster
from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.grids.occupancy import Occupancy
from multisrt.geometry.numerics.arrays import BoolArray, FloatArray

DEFAULT_CELL_M: Final = 0.05
"""Width of a cell in metres, unless the map is too large for it."""

MAX_DEFAULT_CELLS: Final = 16_000_000
"""Number of cells of a map above which the default width of a cell is doubled."""

MARGIN_CELLS: Final = 1
"""Number of cells of the margin around what is known."""

ROUNDING_CELLS: Final = 1e-6
"""Lengths that differ by less than this many cells count as equal."""


def raster_of(content: MapContent, cell_m: float | None) -> Raster:
    """Return a map as cells.

    Parameters
    ----------
    content : MapContent
        The map.
    cell_m : float or None
        Width of a cell in metres; None: `DEFAULT_CELL_M`, doubled until there are at most
        `MAX_DEFAULT_CELLS`.

    Returns
    -------
    Raster
        Its cells, with at least one more around what is known. Cells of a true world are free
        or occupied, as in `world_cells`, and their corners are at multiples of their width. Those
        of what robots knew are free if their centre lies in a region, occupied if an observed
        surface passes through them, and unknown otherwise, as in `Occupancy`.

    Raises
    ------
    InvalidInputError
        If there would be more cells than are read from a file.

    Examples
    --------
    >>> import shapely
    >>> hall = Environment("hall", shapely.box(0, 0, 2, 1))
    >>> raster = raster_of(MapContent(environment=hall), 0.5)
    >>> raster.cells[::-1].tolist()[1], raster.x0, raster.y0
    ([100, 0, 0, 0, 0, 100], -0.5, -0.5)
    """
    bounds = content.environment.bounds
    chosen_m = cell_m or DEFAULT_CELL_M
    while cell_m is None and math.prod(_shape(bounds, chosen_m)) > MAX_DEFAULT_CELLS:
        chosen_m *= 2.0
    rows, columns = _shape(bounds, chosen_m)
    if rows * columns > MAX_CELLS:
        raise InvalidInputError(
            f"a map of {columns} x {rows} cells is larger than the {MAX_CELLS:,} that are read: "
            f"choose cells wider than {chosen_m:g} m"
        )
    if content.regions is not None:
        return _known(content, chosen_m)
    row, column = (_first(low, chosen_m) for low in (bounds[1], bounds[0]))
    cells = world_cells(content.environment, chosen_m, (row, column), (rows, columns))
    return Raster(cells, column * chosen_m, row * chosen_m, chosen_m)


def _known(content: MapContent, cell_m: float) -> Raster:
    assert content.regions is not None
    x0, y0, x1, y1 = content.environment.bounds
    beyond_m = MARGIN_CELLS * cell_m
    bounds = x0 - beyond_m, y0 - beyond_m, x1 + beyond_m, y1 + beyond_m
    known = Occupancy(cell_m, cell_m, bounds)
    for region in content.regions:
        known.add(region)
    (bottom, left), (top, right) = (known.cell_of(*corner) for corner in (bounds[:2], bounds[2:]))
    own = (
        slice(bottom - known.row, top - known.row + 1),
        slice(left - known.column, right - known.column + 1),
    )
    x, y = known.centre_of(bottom, left)
    return Raster(values_of(known.cells[own]), x - 0.5 * cell_m, y - 0.5 * cell_m, cell_m)


def _first(low: float, cell_m: float) -> int:
    return math.floor(low / cell_m + ROUNDING_CELLS) - MARGIN_CELLS


def _shape(bounds: tuple[float, float, float, float], cell_m: float) -> tuple[int, int]:
    rows, columns = (
        math.ceil(high / cell_m - ROUNDING_CELLS) + MARGIN_CELLS - _first(low, cell_m)
        for low, high in (bounds[1::2], bounds[::2])
    )
    return rows, columns


def world_cells(
    environment: Environment, cell_m: float, first: tuple[int, int], shape: tuple[int, int]
) -> Cells:
    """Return a true world as cells, free or occupied.

    A cell is free if its centre lies in free space. Where a wall passes between the centres of two
    neighbouring cells, the nearer cell is occupied. The straight line between the centres of any
    two free neighbours is therefore free, and no wall opens, however thin it is.

    Parameters
    ----------
    environment : Environment
        The world.
    cell_m : float
        Width of a cell in metres.
    first : (row, column)
        Lower left cell, counted in cells from the origin.
    shape : (rows, columns)
        Number of cells.

    Returns
    -------
    (rows, columns) array of int8
        Row 0 is the lowest y.
    """
    (row, column), (rows, columns) = first, shape
    xs, ys = (
        (start + np.arange(count, dtype=np.float64) + 0.5) * cell_m
        for start, count in ((column, columns), (row, rows))
    )
    edges = environment.edges
    free, thin = _swept(edges, ys, xs)
    _, thin_upright = _swept(edges[:, [1, 0, 3, 2]], xs, ys)
    free &= ~thin & ~thin_upright.T
    return np.where(free, FREE_CELL, OCCUPIED_CELL).astype(np.int8)


def _swept(
    edges: FloatArray, lines: FloatArray, centres: FloatArray
) -> tuple[BoolArray, BoolArray]:
    """Sweep free space along the lines of constant y through the centres of cells.

    Returns which centres are free, and which cells are nearest to the middle of an obstacle
    between two centres, both ``(lines, centres)``.
    """
    low = np.searchsorted(lines, np.minimum(edges[:, 1], edges[:, 3]))
    high = np.searchsorted(lines, np.maximum(edges[:, 1], edges[:, 3]))
    crossings = high - low
    which = np.repeat(np.arange(len(edges)), crossings)
    line = np.arange(len(which)) - np.repeat(np.cumsum(crossings) - crossings - low, crossings)
    x0, y0, x1, y1 = edges[which].T
    # From the same end, whatever the direction of an edge.
    up = y0 < y1
    x0, y0, x1, y1 = (np.where(up, *ends) for ends in ((x0, x1), (y0, y1), (x1, x0), (y1, y0)))
    x = x0 + (lines[line] - y0) / (y1 - y0) * (x1 - x0)
    order = np.lexsort((x, line))
    line, x = line[order], x[order]
    after = np.searchsorted(centres, x)  # the first centre that is not before the crossing

    turns = np.zeros((len(lines), len(centres) + 1), np.bool_)
    np.logical_xor.at(turns, (line, after), True)
    free: BoolArray = np.logical_xor.accumulate(turns, axis=1)[:, :-1]

    begins = _first_of_each(line)
    is_exit = (np.arange(len(line)) - begins) % 2 == 1
    between = np.flatnonzero(is_exit[:-1] & (line[1:] == line[:-1]) & (after[1:] == after[:-1]))
    thin = np.zeros_like(free)
    if between.size:
        middle = 0.5 * (x[between] + x[between + 1])
        right = np.clip(after[between], 1, len(centres) - 1)
        left_is_nearer = middle - centres[right - 1] < centres[right] - middle
        thin[line[between], right - left_is_nearer] = True
    return free, thin


def _first_of_each(line: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return, for each element of an ascending array, the index of the first equal to it."""
    return np.searchsorted(line, line)
