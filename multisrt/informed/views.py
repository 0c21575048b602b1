"""Views from places, as sets of cells.

A raster steers the search; the drive is measured exactly afterwards. Sets are arrays of 64-bit
words with one bit for each cell, so that unions and counts of them are quick.
"""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import Polygon

from multisrt.geometry.configuration import Configuration
from multisrt.geometry.grids.polygon_fill import paint_polygon, runs_inside
from multisrt.geometry.numerics import libm
from multisrt.geometry.numerics.kernel import BoolArray, FloatArray, IntArray, kernel
from multisrt.geometry.regions.edge_index import EdgeIndex
from multisrt.geometry.regions.safe_region import local_safe_region
from multisrt.geometry.regions.scan import take_scan

Bits = NDArray[np.uint64]
"""A set of cells: bit i of word w stands for cell ``64 w + i``."""

MIN_CELL_M, MAX_CELLS = 0.1, 40_000
"""Minimum width of the cells in metres, and maximum number of cells in the bounds."""

MAX_BORDER_PLACES = 6_000
"""Places on the border of an area from which the cells that can be seen are found."""

TILT_RAD = 0.19
"""Direction of the rows of cells: not that of the walls of most worlds, along which beams leave
narrow slivers that no centre, or every one, would lie in."""

_TILT = np.array(
    [[math.cos(TILT_RAD), math.sin(TILT_RAD)], [-math.sin(TILT_RAD), math.cos(TILT_RAD)]]
)


class Sensor:
    """The range finder of a robot, and what it sees of a world.

    Parameters
    ----------
    index : EdgeIndex
        The edges of the world.
    range_m : float
        Its range in metres.
    beams : int or None
        Number of its beams; None for the exact visibility polygon.
    """

    def __init__(self, index: EdgeIndex, range_m: float, beams: int | None) -> None:
        self._index = index
        self.range_m = range_m
        self._beams = beams

    def region(self, x: float, y: float) -> FloatArray:
        """Return what a scan at a place shows to be free, ``(n, 2)`` corners in metres.

        What the body covers is left out: plans are made for any heading.
        """
        scan = take_scan(self._index, Configuration(x, y, 0.0), 0.0, self.range_m, self._beams)
        return local_safe_region(scan, "radial").boundary


class Cells:
    """The cells that a team can see, numbered.

    Parameters
    ----------
    bounds : (x0, y0, x1, y1)
        Of the world, in metres.
    area_m2 : float
        Its free area.
    seen_from : iterable of (Polygon, Sensor)
        The areas in which robots can be, and their range finders.
    regions : iterable of (n, 2) array
        What is seen from the starts.

    Attributes
    ----------
    count : int
        Number of cells.
    cell_m : float
        Their width in metres.
    """

    def __init__(
        self,
        bounds: tuple[float, float, float, float],
        area_m2: float,
        seen_from: Iterable[tuple[Polygon, Sensor]],
        regions: Iterable[FloatArray],
    ) -> None:
        corners = _tilted(shapely.get_coordinates(shapely.box(*bounds)))
        (x0, y0), (x1, y1) = corners.min(axis=0).tolist(), corners.max(axis=0).tolist()
        self.cell_m = cell = max(MIN_CELL_M, math.sqrt(area_m2 / MAX_CELLS))
        self._x0, self._y0 = x0, y0
        shape = (math.ceil((y1 - y0) / cell) + 1, math.ceil((x1 - x0) / cell) + 1)
        cells = np.zeros(shape, np.bool_)
        for area, sensor in seen_from:
            if not area.is_empty:
                self._paint_seen_from(cells, area, sensor)
        for region in regions:
            paint_polygon(_tilted(region), self._x0, self._y0, cell, cells)
        self.count = int(np.count_nonzero(cells))
        self._numbers = np.full(shape, -1, np.int32)
        self._numbers[cells] = np.arange(self.count, dtype=np.int32)

    @property
    def words(self) -> int:
        """Number of words of a set of cells."""
        return (self.count + 63) // 64

    def none(self) -> Bits:
        """Return the empty set."""
        return np.zeros(self.words, np.uint64)

    def all(self) -> Bits:
        """Return the set of all cells."""
        bits = np.zeros(64 * self.words, np.bool_)
        bits[: self.count] = True
        return np.packbits(bits, bitorder="little").view(np.uint64)

    def within(self, region: FloatArray) -> Bits:
        """Return the cells whose centres lie in a polygon, ``(n, 2)`` corners in metres."""
        return _bits_within(
            _tilted(region), self._x0, self._y0, self.cell_m, self._numbers, self.words
        )

    def _paint_seen_from(self, cells: BoolArray, area: Polygon, sensor: Sensor) -> None:
        filled = np.zeros_like(cells)
        for ring in (area.exterior, *area.interiors):
            inner = np.zeros_like(cells)
            corners = _tilted(shapely.get_coordinates(ring))
            paint_polygon(corners, self._x0, self._y0, self.cell_m, inner)
            filled ^= inner
        cells |= filled
        # What lies outside of the area is seen across its border, so from a place of the border.
        step = max(self.cell_m, area.length / MAX_BORDER_PLACES)
        border = np.unique(shapely.get_coordinates(shapely.segmentize(area.boundary, step)), axis=0)
        for x, y in border.tolist():
            region = _tilted(sensor.region(x, y))
            paint_polygon(region, self._x0, self._y0, self.cell_m, cells)


def _tilted(points: FloatArray) -> FloatArray:
    return libm.product(points, _TILT)


def count(bits: Bits) -> int:
    """Return the number of cells of a set."""
    return int(np.bitwise_count(bits).sum())


def numbers_in(bits: Bits) -> IntArray:
    """Return the numbers of the cells of a set, ascending."""
    return np.flatnonzero(np.unpackbits(bits.view(np.uint8), bitorder="little"))


@kernel
def _bits_within(
    region: FloatArray,
    x0: float,
    y0: float,
    cell: float,
    numbers: NDArray[np.int32],
    words: int,
) -> Bits:
    bits = np.zeros(words, np.uint64)
    for row, begin, end in runs_inside(region, x0, y0, cell, *numbers.shape):
        for column in range(begin, end):
            number = numbers[row, column]
            if number >= 0:
                bits[number >> 6] |= np.uint64(1) << np.uint64(number & 63)
    return bits
