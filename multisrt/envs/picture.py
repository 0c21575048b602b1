"""The truth on a raster of fixed size: the state for centralised training, and a picture."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
import shapely
from numpy.typing import NDArray

from multisrt.drawing.colours import ROBOT_COLOURS
from multisrt.environments.environment import Environment
from multisrt.geometry.grids.polygon_fill import paint_polygon
from multisrt.geometry.numerics.arrays import BoolArray, FloatArray

SEEN, FREE, ROBOTS = range(3)
"""The layers of a state: what the team has seen, free space, and where robots are."""

PICTURE_CELLS: Final = 384
"""Rows and columns of a picture."""

DISC_CELLS: Final = 5
"""Radius of a robot in a picture, in cells."""

WALL, UNSEEN, WHITE = (40, 40, 40), (170, 170, 170), (255, 255, 255)
"""Colours of obstacles, of free space that was not seen, and of what was."""


class TruthRaster:
    """A square of cells that holds a world, and what of it has been seen.

    Parameters
    ----------
    world : Environment
        The world. Its longer side fills the square, which begins at its lower left corner.
    cells : int
        Number of rows and columns; row 0 is the lowest.
    """

    def __init__(self, world: Environment, cells: int) -> None:
        self._x0, self._y0, x1, y1 = world.bounds
        self._cell_m = max(x1 - self._x0, y1 - self._y0) / cells
        self._seen: BoolArray = np.zeros((cells, cells), np.bool_)
        self._painted = 0
        along = (np.arange(cells) + 0.5) * self._cell_m
        x, y = np.meshgrid(self._x0 + along, self._y0 + along)
        self._free: BoolArray = np.asarray(shapely.contains_xy(world.free, x, y))

    def state(self, regions: list[FloatArray], places: FloatArray) -> NDArray[np.float32]:
        """Return the layers `SEEN`, `FREE` and `ROBOTS`, of 0 and 1.

        Parameters
        ----------
        regions : list of (n, 2) array
            What scans have shown, in metres; those of the last call come first.
        places : (k, 2) array
            Where robots are, in metres.

        Returns
        -------
        (3, cells, cells) array of float32
        """
        self._paint(regions)
        layers = np.zeros((3, *self._seen.shape), np.float32)
        layers[SEEN], layers[FREE] = self._seen, self._free
        rows, columns = self._cells_of(places)
        layers[ROBOTS, rows, columns] = 1.0
        return layers

    def picture(self, regions: list[FloatArray], places: FloatArray) -> NDArray[np.uint8]:
        """Return a picture; the parameters are those of `state`.

        Returns
        -------
        (cells, cells, 3) array of uint8
            Red, green and blue; the first row is the uppermost.
        """
        self._paint(regions)
        image: NDArray[Any] = np.full((*self._seen.shape, 3), WALL, np.uint8)
        image[self._free] = UNSEEN
        image[self._seen] = WHITE
        row, column = np.indices(self._seen.shape)
        for robot, (r, c) in enumerate(zip(*self._cells_of(places), strict=True)):
            disc = np.hypot(row - r, column - c) <= DISC_CELLS
            image[disc] = list(bytes.fromhex(ROBOT_COLOURS[robot % len(ROBOT_COLOURS)][1:]))
        return image[::-1].copy()

    def _paint(self, regions: list[FloatArray]) -> None:
        for region in regions[self._painted :]:
            paint_polygon(region, self._x0, self._y0, self._cell_m, self._seen)
        self._painted = len(regions)

    def _cells_of(self, places: FloatArray) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        last = len(self._seen) - 1
        index = np.floor((places - (self._x0, self._y0)) / self._cell_m).astype(np.int64)
        index = np.clip(index, 0, last)
        return index[:, 1], index[:, 0]
