"""Lower bounds of path lengths in a set of places, from the square cells that cover it.

The cells that a set touches hold it, so a path in the set is a path through those cells, and the
shortest path through the cells is at most as long. It turns only at corners of cells, and between
two corners the moves along the sides, along the diagonals and along those of two cells side by
side are never longer than it by more than a known factor. So distances on the graph of these
moves, divided by that factor, are lower bounds of the lengths of all paths in the set: however
narrow, slanted or slitted it is.

**Proof.** Let C be the union of the closed cells.

1. *Ends.* Let A and B be two sets of cells of C. A shortest path in C from A to B turns only at
   corners of cells, as C is bounded by their sides. Where it leaves A at an inner point of a side
   it does so at a right angle, along an axis: then either it runs into a corner of a cell further
   on, so that it lies on a line of the lattice and leaves A at a corner, too; or it ends at a side
   of B that is parallel, and can be shifted within its row or column of cells until it runs along
   a line of the lattice. The same holds at B. So a shortest path joins corners of A and B by
   segments between corners.
2. *Segments.* Let one of these lead from (0, 0) to (m, n), 0 <= n <= m, in widths of a cell; the
   other directions follow by symmetry. Rounding its ordinate down at every whole abscissa gives
   a staircase of steps E, one to the right, and D, one to the right and up. The segment passes
   through the inside of the cell of each step: above the side that E runs along, or with D as its
   diagonal. So that cell is in C. If 2 n <= m, no two D follow each other, as the ordinate grows
   by at most 1 over two steps, and the first step is an E. So each D has an E of its own before
   it, and both together are a move to (2, 1) within the two cells of these steps. If 2 n >= m,
   then no two E follow each other, the last step is a D, and each E has a D of its own behind it.
   In either case the segment's ends are joined by moves along (1, 0) and (2, 1), or (2, 1) and
   (1, 1), through cells of C; all point within 26.6 degrees of each other, and their sum of
   lengths is at most 1 / cos(13.3 degrees) times that of the segment: `LONGEST_DETOUR`.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np
import shapely
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra
from shapely.geometry.base import BaseGeometry

from multisrt.geometry.grids.polygon_fill import paint_polygon
from multisrt.geometry.numerics.kernel import BoolArray, FloatArray, IntArray, kernel

LONGEST_DETOUR: Final = 1.0 / math.cos(0.5 * math.atan(0.5))
"""Maximum ratio of a path along the graph to the shortest path through the cells: 1.0275."""

TOUCH_M: Final = 2e-3
"""Cells that a border comes so near to in metres count as touched, for rounding."""


class _Move(NamedTuple):
    # A move between two corners: its columns and rows, and the cells (row, column) that it runs
    # through or along, from the lower left corner of its box; those that it runs along are beside
    # a side, and one of the two is enough.
    columns: int
    rows: int
    cells: tuple[tuple[int, int], ...]
    is_along: bool = False


_MOVES: Final = (
    _Move(1, 0, ((-1, 0), (0, 0)), is_along=True),
    _Move(0, 1, ((0, -1), (0, 0)), is_along=True),
    _Move(1, 1, ((0, 0),)),
    _Move(1, -1, ((0, 0),)),
    _Move(2, 1, ((0, 0), (0, 1))),
    _Move(2, -1, ((0, 0), (0, 1))),
    _Move(1, 2, ((0, 0), (1, 0))),
    _Move(1, -2, ((0, 0), (1, 0))),
)


def _move_table() -> IntArray:
    # All moves in either direction, sorted by where they lead, as rows: columns, rows, the cells
    # (row, column, row, column) from the lower left corner of the move's box, whether one of the
    # two is enough.
    table = []
    for move in _MOVES:
        cells = (*move.cells[0], *move.cells[-1])
        for sign in (1, -1):
            table.append((sign * move.columns, sign * move.rows, *cells, int(move.is_along)))
    return np.array(sorted(table, key=lambda row: (row[1], row[0])), dtype=np.int64)


_MOVE_TABLE: Final = _move_table()

MARGIN: Final = 2
"""The columns and rows of the longest moves, by which cells are padded."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Lattice:
    """Square cells over a window of the plane.

    Attributes
    ----------
    x0, y0 : float
        Lower left corner in metres.
    cell_m : float
        Width of a cell in metres.
    rows, columns : int
        Number of rows and columns of cells; row 0 is the lowest y.
    """

    x0: float
    y0: float
    cell_m: float
    rows: int
    columns: int

    @classmethod
    def over(cls, area: BaseGeometry, cell_m: float) -> Lattice:
        """Return cells of a width in metres over an area, with some to spare around it."""
        x0, y0, x1, y1 = area.bounds
        return cls(
            x0=x0 - 1.5 * cell_m,
            y0=y0 - 1.5 * cell_m,
            cell_m=cell_m,
            rows=math.ceil((y1 - y0) / cell_m) + 3,
            columns=math.ceil((x1 - x0) / cell_m) + 3,
        )

    def touched(self, area: BaseGeometry) -> BoolArray:
        """Return the cells that polygons touch, and perhaps some that they nearly touch.

        Parameters
        ----------
        area : Polygon or MultiPolygon
            The polygons in metres.

        Returns
        -------
        (rows, columns) array of bool
            True at least for all cells whose closed square meets the polygons.

        Examples
        --------
        >>> square = shapely.box(0.0, 0.0, 2.0, 2.0)
        >>> cells = Lattice.over(square, 1.0).touched(square)
        >>> cells.astype(int).tolist()[1]
        [0, 1, 1, 1, 0]
        """
        cells = np.zeros((self.rows, self.columns), np.bool_)
        for part in shapely.get_parts(area):
            inside = np.zeros_like(cells)
            self.touch(shapely.get_coordinates(part.exterior)[:-1], inside)
            holes, borders = np.zeros_like(cells), np.zeros_like(cells)
            for ring in part.interiors:
                corners = shapely.get_coordinates(ring)[:-1]
                paint_polygon(corners, self.x0, self.y0, self.cell_m, holes)
                _mark_border(corners, self.x0, self.y0, self.cell_m, borders)
            cells |= (inside & ~holes) | borders
        return cells

    def touch(self, corners: FloatArray, cells: BoolArray) -> None:
        """Mark in place the cells that a polygon without holes touches, as `touched` does.

        A cell that its border does not touch lies inside if its centre does.

        Parameters
        ----------
        corners : (n, 2) array
            Its corners in metres, not closed.
        cells : (rows, columns) array of bool
            The cells.
        """
        paint_polygon(corners, self.x0, self.y0, self.cell_m, cells)
        _mark_border(corners, self.x0, self.y0, self.cell_m, cells)

    def cells_at(self, points: FloatArray) -> BoolArray:
        """Return the cells that hold some points, ``(k, 2)`` in metres, or nearly hold them."""
        cells = np.zeros((self.rows, self.columns), np.bool_)
        for k in range(len(points)):
            self.touch(points[k : k + 1], cells)
        return cells

    def areas(self, area: BaseGeometry) -> FloatArray:
        """Return how much of polygons lies in each cell.

        Parameters
        ----------
        area : Polygon or MultiPolygon
            The polygons in metres, within the window.

        Returns
        -------
        (rows, columns) array
            Areas in square metres, exact to rounding.

        Examples
        --------
        >>> square = shapely.box(0.0, 0.0, 1.0, 1.0)
        >>> Lattice.over(square, 1.0).areas(square)[1].tolist()
        [0.0, 0.25, 0.25, 0.0]
        """
        shares = np.zeros((self.rows, self.columns + 1))
        for ring in _rings_of(area):
            _add_shares((ring - np.array([self.x0, self.y0])) / self.cell_m, shares)
        areas: FloatArray = np.clip(np.cumsum(shares, axis=1), 0.0, 1.0) * self.cell_m**2
        return areas[:, :-1]


def edges_of(area: BaseGeometry) -> FloatArray:
    """Return the edges x0, y0, x1, y1 in metres of polygons, the polygons on their left."""
    edges: FloatArray = np.vstack([np.hstack([ring[:-1], ring[1:]]) for ring in _rings_of(area)])
    return edges


def _rings_of(area: BaseGeometry) -> Iterator[FloatArray]:
    # The corners of each ring of polygons, closed, the polygons on its left.
    for part in shapely.get_parts(shapely.orient_polygons(area)):
        yield shapely.get_coordinates(part.exterior)
        for ring in part.interiors:
            yield shapely.get_coordinates(ring)


class ShortestPaths:
    """Lower bounds of the lengths of paths through a set of cells.

    Parameters
    ----------
    lattice : Lattice
        The cells.
    cells : (rows, columns) array of bool
        Those that paths may run through.

    Examples
    --------
    From one end of a slanted corridor to the other; the path is 10 m long:

    >>> corridor = shapely.LineString([(0, 0), (6, 8)]).buffer(0.05)
    >>> lattice = Lattice.over(corridor, 0.1)
    >>> paths = ShortestPaths(lattice, lattice.touched(corridor))
    >>> ends = [lattice.touched(shapely.Point(*end).buffer(0.01)) for end in [(0, 0), (6, 8)]]
    >>> lengths = paths.between([paths.corners(end) for end in ends])
    >>> bool(9.5 < lengths[0, 1] < 10.0)
    True
    """

    __slots__ = ("_graph", "_number")

    def __init__(self, lattice: Lattice, cells: BoolArray) -> None:
        # Numbers of the corners of the cells, -1 for others.
        is_corner = np.zeros((lattice.rows + 1, lattice.columns + 1), np.bool_)
        for down, left in ((0, 0), (0, 1), (1, 0), (1, 1)):
            is_corner[down : down + lattice.rows, left : left + lattice.columns] |= cells
        self._number: IntArray = np.full(is_corner.shape, -1, np.int64)
        self._number[is_corner] = np.arange(np.count_nonzero(is_corner))
        # A margin for the moves that would leave the window.
        graph = _graph(np.pad(cells, MARGIN), self._number, _MOVE_TABLE)
        count = int(np.count_nonzero(is_corner))
        scaled = graph[2] * (lattice.cell_m / LONGEST_DETOUR)
        self._graph: csr_array = csr_array((scaled, graph[1], graph[0]), shape=(count, count))

    def corners(self, cells: BoolArray) -> IntArray:
        """Return the numbers of the corners of cells, of those that paths may run through."""
        numbers = [
            self._number[r : r + cells.shape[0], c : c + cells.shape[1]][cells]
            for r, c in ((0, 0), (0, 1), (1, 0), (1, 1))
        ]
        found: IntArray = np.unique(np.concatenate(numbers))
        return found[found >= 0]

    def from_any(self, corners: IntArray) -> FloatArray:
        """Return lower bounds in metres of the paths from the nearest of some corners to all.

        Parameters
        ----------
        corners : (k,) array of int
            Numbers of corners.

        Returns
        -------
        (n,) array
            By the number of the corner; ``inf`` where there is no path.
        """
        lengths: FloatArray = dijkstra(self._graph, indices=corners, min_only=True)
        return lengths

    def to_cells(self, lengths: FloatArray, rows: IntArray, columns: IntArray) -> FloatArray:
        """Return lower bounds in metres of the paths to some of the cells.

        Parameters
        ----------
        lengths : (n,) array
            Those to the corners, as from `from_any`.
        rows, columns : (k,) arrays of int
            The cells; each is one that paths may run through.

        Returns
        -------
        (k,) array
            The least of those to the corners of each cell.
        """
        corners = [self._number[rows + r, columns + c] for r in (0, 1) for c in (0, 1)]
        least: FloatArray = lengths[np.array(corners)].min(axis=0)
        return least

    def between(self, sets: list[IntArray]) -> FloatArray:
        """Return lower bounds in metres of the paths between any two of some sets of corners.

        Parameters
        ----------
        sets : list of (k,) arrays of int
            Numbers of the corners of each set; none is empty.

        Returns
        -------
        (n, n) array
            Symmetric; ``inf`` where there is no path.
        """
        members = np.concatenate(sets)
        firsts = np.concatenate(([0], np.cumsum([len(each) for each in sets])[:-1]))
        lengths = np.array(
            [np.minimum.reduceat(self.from_any(each)[members], firsts) for each in sets]
        )
        both_ways: FloatArray = np.minimum(lengths, lengths.T)
        return both_ways


@kernel
def _mark_border(corners: FloatArray, x0: float, y0: float, cell: float, cells: BoolArray) -> None:
    # Mark the cells that a closed chain of segments touches, or comes as near as `TOUCH_M`.
    rows, columns = cells.shape
    n = corners.shape[0]
    for k in range(n):
        ax, ay = corners[k, 0] - x0, corners[k, 1] - y0
        bx, by = corners[(k + 1) % n, 0] - x0, corners[(k + 1) % n, 1] - y0
        dx, dy = bx - ax, by - ay
        first_column = int(max(0.0, (min(ax, bx) - TOUCH_M) / cell))
        last_column = int(min(columns - 1.0, (max(ax, bx) + TOUCH_M) / cell))
        first_row = int(max(0.0, (min(ay, by) - TOUCH_M) / cell))
        last_row = int(min(rows - 1.0, (max(ay, by) + TOUCH_M) / cell))
        # Separating axis along the segment's normal.
        reach = (abs(dx) + abs(dy)) * (0.5 * cell + TOUCH_M)
        for i in range(first_row, last_row + 1):
            for j in range(first_column, last_column + 1):
                if abs(((j + 0.5) * cell - ax) * dy - ((i + 0.5) * cell - ay) * dx) <= reach:
                    cells[i, j] = True


@kernel
def _add_shares(ring: FloatArray, shares: FloatArray) -> None:
    # Adds what a closed ring of a polygon contributes to the shares of cells that lie in it: the
    # share of a cell is the sum over its row up to it (Green's theorem). A piece of an edge within
    # one cell has all of its height to its left or right: the part of its cell to its right, and
    # all cells further on. Lengths are in widths of a cell; the last column is beyond all cells.
    rows, columns = shares.shape[0], shares.shape[1] - 1
    for k in range(ring.shape[0] - 1):
        (ax, ay), (bx, by) = ring[k], ring[k + 1]
        if ay == by:
            continue
        slope = (bx - ax) / (by - ay)
        sign = 1.0 if by < ay else -1.0
        low, high = min(ay, by), max(ay, by)
        left, right = min(ax, bx), max(ax, bx)
        for row in range(int(low), min(rows - 1, int(high)) + 1):
            y0, y1 = max(low, float(row)), min(high, row + 1.0)
            x0 = min(right, max(left, ax + (y0 - ay) * slope))
            x1 = min(right, max(left, ax + (y1 - ay) * slope))
            if x1 < x0:
                x0, x1 = x1, x0
            for column in range(int(x0), min(columns - 1, int(x1)) + 1):
                u0, u1 = max(x0, float(column)), min(x1, column + 1.0)
                part = (u1 - u0) / (x1 - x0) if x1 > x0 else 1.0
                height = sign * (y1 - y0) * part
                beside = 0.5 * (u0 + u1) - column
                shares[row, column] += height * (1.0 - beside)
                shares[row, column + 1] += height * beside


@kernel
def _graph(
    room: BoolArray, number: IntArray, moves: IntArray
) -> tuple[IntArray, IntArray, FloatArray]:
    # The moves between corners in compressed rows: where each row begins, where its moves lead,
    # and their lengths in widths of a cell. `room` holds the cells with a margin.
    count = number.max() + 1
    begins = np.zeros(count + 1, np.int64)
    leads_to = np.empty(count * moves.shape[0], np.int64)
    lengths = np.empty(count * moves.shape[0])
    total = 0
    for r in range(number.shape[0]):
        for c in range(number.shape[1]):
            if number[r, c] < 0:
                continue
            for m in range(moves.shape[0]):
                columns, rows, down_a, left_a, down_b, left_b, is_along = moves[m]
                low, left = r + min(0, rows) + MARGIN, c + min(0, columns) + MARGIN
                if r + rows < 0 or r + rows >= number.shape[0]:
                    continue
                if c + columns < 0 or c + columns >= number.shape[1]:
                    continue
                first = room[low + down_a, left + left_a]
                other = room[low + down_b, left + left_b]
                if (first or other) if is_along else (first and other):
                    leads_to[total] = number[r + rows, c + columns]
                    lengths[total] = np.hypot(columns, rows)
                    total += 1
            begins[number[r, c] + 1] = total
    return begins, leads_to[:total].copy(), lengths[:total].copy()
