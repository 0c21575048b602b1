"""Maps of the ROS map server: a YAML file that describes a PGM image."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Final

import numpy as np

from multisrt.exporting.grids import FREE_CELL, OCCUPIED_CELL
from multisrt.exporting.map_content import MapContent, MapOptions, Raster
from multisrt.exporting.rasters import raster_of
from multisrt.geometry.errors import InvalidInputError

FREE_LEVEL, OCCUPIED_LEVEL, UNKNOWN_LEVEL = 254, 0, 205
"""Grey values of cells, as map_saver writes them."""

OCCUPIED_THRESH: Final = 0.65
FREE_THRESH: Final = 0.196
"""Below the occupancy of unknown pixels, 50/255."""


def map_server_files(content: MapContent, path: Path, options: MapOptions) -> dict[Path, bytes]:
    """Return a map as the files of the map server: a YAML file, and an image beside it.

    Parameters
    ----------
    content : MapContent
        The map.
    path : Path
        The YAML file; the image has the same name with the suffix ``.pgm``.
    options : MapOptions
        Width of a pixel.

    Raises
    ------
    InvalidInputError
        If there would be too many pixels, or none would be free.

    Notes
    -----
    Source: documentation and map_saver of map_server (ROS 1) and nav2_map_server (ROS 2).
    """
    raster = raster_of(content, options.cell_m)
    if not raster.free_m2:
        raise InvalidInputError(
            f"cells of {raster.cell_m:g} m are too wide for {path.name}: none of the "
            f"{raster.cells.shape[1]} x {raster.cells.shape[0]} cells would be free; choose "
            "narrower cells"
        )
    image = path.with_suffix(".pgm")
    lines = (
        f"image: {json.dumps(image.name, ensure_ascii=False)}",
        "mode: trinary",
        f"resolution: {_decimal(raster.cell_m)}",
        f"origin: [{_decimal(raster.x0)}, {_decimal(raster.y0)}, 0.0]",
        "negate: 0",
        f"occupied_thresh: {OCCUPIED_THRESH}",
        f"free_thresh: {FREE_THRESH}",
    )
    return {path: ("\n".join(lines) + "\n").encode(), image: pgm_bytes(raster)}


def pgm_bytes(raster: Raster) -> bytes:
    """Return cells as a binary PGM, whose first row is the highest."""
    levels = np.full(raster.cells.shape, UNKNOWN_LEVEL, np.uint8)
    levels[raster.cells == FREE_CELL] = FREE_LEVEL
    levels[raster.cells == OCCUPIED_CELL] = OCCUPIED_LEVEL
    rows, columns = raster.cells.shape
    return f"P5\n{columns} {rows}\n255\n".encode() + levels[::-1].tobytes()


def _decimal(value: float) -> str:
    """Return a number with a point and no exponent, since YAML 1.1 reads one as text."""
    text = f"{value:.9f}".rstrip("0")
    return "0.0" if float(text) == 0.0 else text + "0" * text.endswith(".")
