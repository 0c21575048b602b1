"""Text grids of the MovingAI benchmarks, with one character per cell."""

import re
from pathlib import Path

import numpy as np

from multisrt.environments.environment import Environment
from multisrt.environments.formats.files import (
    MAX_CELLS,
    build_environment,
    grid_polygons,
    read_text,
    refuse_threshold,
    require_resolution,
    straightened,
)
from multisrt.environments.formats.map_format import Beginning, MapFormat
from multisrt.geometry.errors import MapFormatError, shown
from multisrt.geometry.numerics.kernel import BoolArray

FREE = ".GS"
"""Characters of free cells: ground, ground and swamp."""

BLOCKED = "@OTW"
"""Characters of occupied cells: out of bounds, out of bounds, trees and water."""


def read_moving_ai(
    path: Path,
    *,
    resolution_m: float | None = None,
    threshold: float | None = None,
    name: str | None = None,
) -> Environment:
    """Read a ``.map`` grid; the first line of cells is the northernmost.

    Parameters
    ----------
    path : Path
        Header ``type octile``, ``height H``, ``width W``, ``map``, then H lines of W cells.
    resolution_m : float
        Side of a cell in metres. The format does not contain it; there is no default.
    threshold
        Rejected: a cell is free or not.
    name : str, optional
        By default the file's name without suffix.

    Raises
    ------
    MapFormatError
        If the header is wrong, a line has another length, a character is unknown, or no cell is
        free.

    Notes
    -----
    Source: N. Sturtevant, Benchmarks for grid-based pathfinding, 2012; differs in: swamp, which
    in the game is entered only from swamp or ground, counts as ground. A scenario of the benchmark
    (`moving_ai_scenario`) adds suggested starts to its map.
    """
    refuse_threshold(path, threshold)
    resolution_m = require_resolution(path, resolution_m)
    polygons = grid_polygons(path, read_cells(path), resolution_m)
    return build_environment(
        path,
        polygons,
        name=name,
        origin=f"{path.name} at {resolution_m:g} m per cell",
        cleaning=straightened(polygons, resolution_m),
    )


def read_cells(path: Path) -> BoolArray:
    """Return the mask of the free cells of a ``.map`` grid, ``(rows, columns)`` from the top.

    Raises
    ------
    MapFormatError
        As `read_moving_ai`.
    """
    lines = read_text(path).splitlines()
    height, width = _header(path, lines)
    rows = lines[4 : 4 + height]
    if len(rows) < height:
        raise MapFormatError(f"{path} ends after {len(rows)} of {height} lines of cells")
    for number, row in enumerate(rows, start=5):
        if len(row) != width:
            raise MapFormatError(f"{path}, line {number} has {len(row)} cells, not {width}")
    cells = np.frombuffer("".join(rows).encode("utf-32-le"), np.uint32).reshape(height, width)
    free: BoolArray = np.isin(cells, [ord(sign) for sign in FREE])
    strange = np.argwhere(~free & ~np.isin(cells, [ord(sign) for sign in BLOCKED]))
    if strange.size:
        row, column = strange[0]
        raise MapFormatError(
            f"{path}, line {row + 5}, column {column + 1} is {rows[row][column]!r}; "
            f"cells must be one of {FREE}{BLOCKED}"
        )
    if not free.any():
        raise MapFormatError(f"{path} has no free cell: none of {FREE}")
    return free


def _header(path: Path, lines: list[str]) -> tuple[int, int]:
    """Return height and width in cells."""
    sizes = []
    for number, word in enumerate(("type", "height", "width", "map"), start=1):
        parts = lines[number - 1].split() if number <= len(lines) else []
        if not parts or parts[0] != word:
            found = lines[number - 1] if number <= len(lines) else "the end"
            raise MapFormatError(
                f"{path}, line {number} is {shown(found)}; a MovingAI map has {word} here"
            )
        if word in ("height", "width"):
            text = parts[1] if len(parts) == 2 else ""
            if not (text.isascii() and text.isdigit() and int(text[:9]) > 0 and len(text) < 9):
                raise MapFormatError(
                    f"{path}, line {number} is {shown(lines[number - 1])}; "
                    f"{word} must be a positive whole number"
                )
            sizes.append(int(text))
    height, width = sizes
    if height * width > MAX_CELLS:
        raise MapFormatError(
            f"{path} has {width} x {height} cells; grids are read up to {MAX_CELLS:,} cells"
        )
    return height, width


def _is_moving_ai(beginning: Beginning) -> bool:
    return re.match(r"\s*type\s+\w+\s+height\s+\d", beginning.text) is not None


MOVING_AI = MapFormat(
    name="MovingAI grid",
    suffixes=(".map",),
    recognises=_is_moving_ai,
    read=read_moving_ai,
)
