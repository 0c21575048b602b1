"""The window of the lattice that an occupancy stores: one value per cell in each layer."""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np

from multisrt.geometry.grids.raster import (
    MAX_CELL_INDEX,
    OFFSET_X,
    OFFSET_Y,
    Window,
    moved,
    window_over,
)
from multisrt.geometry.numerics.arrays import BoolArray, ByteArray, FloatArray
from multisrt.geometry.numerics.boxes import bounds_of
from multisrt.geometry.numerics.kernel import kernel

UNKNOWN: Final = 0
"""No region holds the cell's centre."""
FREE: Final = 1
"""A region holds the cell's centre, and no surface passes through the cell."""
OCCUPIED: Final = 2
"""A surface passes through the cell."""

# Bits of a cell's marks.
NEAR: Final = 1
"""The cell's centre is closer to a surface than the body's radius."""
FRONTIER: Final = 2
"""The cell is free and one of its four neighbours is unknown."""
GROUPED: Final = 4
"""The cell is in a group: it was frontier when groups were last put together."""

CELL_BYTES: Final = 3
"""Memory of one cell in all layers together, in bytes."""


class Layers(NamedTuple):
    """A window of the lattice: where it lies, and one array ``[row, column]`` per layer.

    Attributes
    ----------
    cell_m : float
        Width of a cell in metres.
    row, column : int
        Lattice row and column of the first cell of the arrays.
    states : (rows, columns) array of uint8
        `UNKNOWN`, `FREE` or `OCCUPIED`.
    passable : (rows, columns) array of bool
        Whether the cell is free and not `NEAR` a surface.
    marks : (rows, columns) array of uint8
        Bits `NEAR`, `FRONTIER` and `GROUPED`.
    """

    cell_m: float
    row: int
    column: int
    states: ByteArray
    passable: BoolArray
    marks: ByteArray


def empty_layers(cell_m: float) -> Layers:
    """Return layers without any cell."""
    return Layers(
        cell_m=cell_m,
        row=0,
        column=0,
        states=np.zeros((0, 0), np.uint8),
        passable=np.zeros((0, 0), np.bool_),
        marks=np.zeros((0, 0), np.uint8),
    )


def grown(layers: Layers, bounds: tuple[float, float, float, float]) -> Layers:
    """Return layers that also hold some bounds, or the same object if they already do.

    Parameters
    ----------
    layers : Layers
        The present window. Its arrays are copied, not changed.
    bounds : (x0, y0, x1, y1)
        What the window shall hold, in metres.

    Returns
    -------
    Layers
        New cells are unknown.

    Raises
    ------
    InvalidInputError
        If there would be too many cells.
    """
    held = Window(layers.row, layers.column, *layers.states.shape)
    window = window_over(bounds, layers.cell_m, held, CELL_BYTES)
    if window == held:
        return layers
    return Layers(
        cell_m=layers.cell_m,
        row=window.row,
        column=window.column,
        states=moved(layers.states, held, window),
        passable=moved(layers.passable, held, window),
        marks=moved(layers.marks, held, window),
    )


@kernel
def holds_region(layers: Layers, boundary: FloatArray, margin_m: float) -> bool:
    """Whether the window holds a polygon and a margin around it.

    Parameters
    ----------
    layers : Layers
        The window.
    boundary : (n, 2) array
        Corners of the polygon in metres.
    margin_m : float
        Width of the margin in metres.

    Returns
    -------
    bool
        False also if a corner is not finite or beyond `MAX_CELL_INDEX`.
    """
    cell = layers.cell_m
    farthest = MAX_CELL_INDEX * cell
    for i in range(boundary.shape[0]):
        if not (abs(boundary[i, 0]) < farthest and abs(boundary[i, 1]) < farthest):
            return False
    rows, columns = layers.states.shape
    x0, y0, x1, y1 = bounds_of(boundary)
    return (
        int(np.floor((x0 - margin_m) / cell + OFFSET_X)) >= layers.column
        and int(np.floor((y0 - margin_m) / cell + OFFSET_Y)) >= layers.row
        and int(np.floor((x1 + margin_m) / cell + OFFSET_X)) < layers.column + columns
        and int(np.floor((y1 + margin_m) / cell + OFFSET_Y)) < layers.row + rows
    )
