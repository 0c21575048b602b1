"""Scenarios of the MovingAI benchmarks: start positions on a grid."""

import re
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from typing import Final

from multisrt.environments.cleaning import Cleaning
from multisrt.environments.environment import Environment
from multisrt.environments.formats.files import (
    MAX_CELLS,
    FileStarts,
    build_environment,
    grid_polygons,
    named_file,
    no_such_file,
    read_text,
    refuse_threshold,
    require_resolution,
    straightened,
)
from multisrt.environments.formats.map_format import Beginning, MapFormat
from multisrt.environments.formats.moving_ai import read_cells
from multisrt.geometry.errors import MapFormatError, shown
from multisrt.geometry.numerics.kernel import BoolArray

FIELDS: Final = "bucket, map, map width, map height, start x, start y, goal x, goal y, length"
"""The fields of a line."""

VERSIONS: Final = ("1", "1.0")
"""Versions that are read."""


def read_moving_ai_scenario(
    path: Path,
    *,
    resolution_m: float | None = None,
    threshold: float | None = None,
    name: str | None = None,
) -> Environment:
    r"""Read a ``.scen`` file: the grid that it names, with its starts as suggested starts.

    Suggested starts are the centres of the cells in which the problems of the scenario start, in
    its order, each once, at most 1000. Goals are not used.

    Parameters
    ----------
    path : Path
        A line ``version 1``, then a line for each problem. The lines name the map by a path
        relative to the folder of the scenario; failing that, a map of that name beside the
        scenario is used.
    resolution_m : float
        Side of a cell of the map in metres; see `read_moving_ai`.
    threshold
        Rejected: a cell is free or not.
    name : str, optional
        By default the file's name without suffix.

    Raises
    ------
    MapFormatError
        If the version is another one, a line has other fields, the map is missing, outside the
        folder or unreadable, lines name several maps, or a start is not in a free cell.

    Notes
    -----
    Source: N. Sturtevant, Benchmarks for grid-based pathfinding, 2012, and the page on file
    formats of the benchmarks. If the width and height of a line are not those of the map, its
    positions refer to a grid of that size over the map, and a start is the cell of the map that
    contains the centre of its cell; `Environment.cleaning` notes that.

    Examples
    --------
    >>> with open("room.map", "w") as file:
    ...     _ = file.write("\n".join(["type octile", "height 2", "width 3", "map", "..@", "..."]))
    >>> with open("room.scen", "w") as file:
    ...     _ = file.write("version 1\n0 room.map 3 2 0 1 1 0 1.41421")
    >>> read_moving_ai_scenario(Path("room.scen"), resolution_m=0.5).starts
    ((0.25, 0.25),)
    """
    refuse_threshold(path, threshold)
    resolution_m = require_resolution(path, resolution_m)
    problems = _problems(path)
    map_path = _map_path(path, problems[0])
    cells = read_cells(map_path)
    height, _ = cells.shape
    starts = [_start(cells, problem, map_path) for problem in problems]
    polygons = grid_polygons(map_path, cells, resolution_m)
    return build_environment(
        path,
        polygons,
        name=name,
        origin=f"{path.name} with {map_path.name} at {resolution_m:g} m per cell",
        starts=FileStarts(
            [
                ((column + 0.5) * resolution_m, (height - row - 0.5) * resolution_m)
                for column, row in starts
            ]
        ),
        cleaning=_scaled(path, problems, cells, map_path) + straightened(polygons, resolution_m),
    )


def _scaled(path: Path, problems: list["_Problem"], cells: BoolArray, map_path: Path) -> Cleaning:
    height, width = cells.shape
    for problem in problems:
        if problem.size != (width, height):
            columns, rows = problem.size
            return Cleaning(
                notes=(
                    f"{problem.place.removeprefix(f'{path}, ')} states a grid of {columns} x "
                    f"{rows} cells, but {map_path.name} has {width} x {height}: is it the map of "
                    "this scenario? Starts scaled to it",
                )
            )
    return Cleaning()


@dataclass(frozen=True, slots=True)
class _Problem:
    """A line: its place, the map, the size of the grid, and the start in it from the top left."""

    place: str
    map: str
    size: tuple[int, int]
    start: tuple[int, int]


def _problems(path: Path) -> list[_Problem]:
    lines = read_text(path).splitlines()
    version = lines[0].split() if lines else []
    if len(version) != 2 or version[0].lower() != "version" or version[1] not in VERSIONS:
        raise MapFormatError(
            f"{path}, line 1 is {shown(lines[0] if lines else '')}; "
            "only version 1 is read, whose first line is version 1"
        )
    problems = [
        _problem(f"{path}, line {number}", line)
        for number, line in enumerate(lines[1:], start=2)
        if line.strip()
    ]
    if not problems:
        raise MapFormatError(f"{path} has no problem that names a map; add a line {FIELDS}")
    for problem in problems:
        if problem.map != problems[0].map:
            raise MapFormatError(
                f"{problem.place} names the map {shown(problem.map)}, and an earlier line "
                f"{shown(problems[0].map)}; keep the problems of each map in a file of its own"
            )
    return problems


def _problem(place: str, line: str) -> _Problem:
    # Names of maps may contain spaces where tabs separate the fields.
    fields = [word.strip() for word in line.split("\t")] if "\t" in line else line.split()
    numbers = [*fields[2:6]]
    if len(fields) != 9 or not all(re.fullmatch(r"[0-9]{1,8}", word) for word in numbers):
        raise MapFormatError(f"{place} is {shown(line)}; it has the fields {FIELDS}")
    width, height, x, y = (int(word) for word in numbers)
    if width * height > MAX_CELLS:
        raise MapFormatError(
            f"{place} states a grid of {width} x {height} cells; grids are read up to "
            f"{MAX_CELLS:,} cells"
        )
    if not (x < width and y < height):
        raise MapFormatError(
            f"{place}: the start ({x}, {y}) is not in the grid of {width} x {height} cells that "
            "the line states; count columns and rows from 0"
        )
    return _Problem(place, fields[1], (width, height), (x, y))


def _map_path(path: Path, problem: _Problem) -> Path:
    for name in (problem.map, PurePosixPath(problem.map).name):
        found = named_file(path.parent, name, problem.place)
        if found is not None and found.is_file():
            return found
    raise no_such_file(path.parent, problem.map, f"{problem.place} names the map")


def _start(cells: BoolArray, problem: _Problem, map_path: Path) -> tuple[int, int]:
    """Return the column and row of the map's cell in which a problem starts."""
    (height, width), (x, y) = cells.shape, problem.start
    column = (2 * x + 1) * width // (2 * problem.size[0])
    row = (2 * y + 1) * height // (2 * problem.size[1])
    if not cells[row, column]:
        raise MapFormatError(
            f"{problem.place}: the start ({x}, {y}) is not in a free cell of {map_path.name}; "
            "is it the map of this scenario?"
        )
    return column, row


def _is_scenario(beginning: Beginning) -> bool:
    return re.match(r"\s*version\s+\d+(\.\d+)?\s*\n", beginning.text, re.IGNORECASE) is not None


MOVING_AI_SCENARIO = MapFormat(
    name="MovingAI scenario",
    suffixes=(".scen",),
    recognises=_is_scenario,
    read=read_moving_ai_scenario,
)
