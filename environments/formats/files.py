"""Steps that readers share: open a file of bounded size, check options, build the world."""

import json
import re
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path, PurePosixPath
from typing import Any, Final, NamedTuple

import numpy as np
import shapely
from shapely import MultiPolygon, Point
from shapely.geometry.base import BaseGeometry

from multisrt.environments.cleaning import FIXING, Cleaning
from multisrt.environments.environment import (
    MAX_COORDINATE_M,
    MIN_LENGTH_M,
    SLIVER_WIDTH_M,
    Environment,
)
from multisrt.environments.formats.bitmap import (
    Resolution,
    displacement_bound_m,
    polygons_from_grid,
)
from multisrt.environments.layers import Layers
from multisrt.geometry.errors import (
    InvalidInputError,
    MapFormatError,
    escaped,
    reason_of,
    shortened,
    shown,
)
from multisrt.geometry.numerics.kernel import BoolArray

MAX_TEXT_BYTES = 64 * 2**20
"""Upper bound of the size of text files, in bytes (64 MiB)."""

MAX_POLYGON_BYTES = 24 * 2**20
"""Upper bound of the size of text files with polygons, in bytes (24 MiB).

Files of small triangles take 105 to 140 times their size in memory.
"""

MAX_CELLS = 64_000_000
"""Upper bound of the size of images and grids, in pixels or cells."""

MAX_NAME_LENGTH: Final = 255
"""Upper bound of the length of the name of a file, with its folders, in a map file."""

MAX_STARTS = 1000
"""Upper bound of the suggested starts that are read from a file."""

RESOLUTION_OPTION = "--resolution, in Python ms.read_environment(file, resolution_m=...)"
"""How users give the metres per pixel, cell or unit of a drawing, for messages."""


def require_file(path: Path) -> int:
    """Return the size of a map file in bytes.

    Raises
    ------
    MapFormatError
        If the path does not exist, is not a regular file, or is empty.
    """
    try:
        if path.is_dir():
            raise MapFormatError(f"{path} is a folder; name the map file in it")
        if re.match(r"(https?|ftp|file):/", str(path)):
            raise MapFormatError(
                f"{path} is an address, and maps are read from files: download it, and name the "
                "file"
            )
        if not path.exists():
            raise MapFormatError(f"{path} does not exist; check the name and the folder")
        if not path.is_file():
            raise MapFormatError(f"{path} is not a regular file; copy the map into one")
        size = path.stat().st_size
    except MapFormatError:
        raise
    except (OSError, ValueError) as error:
        raise MapFormatError(f"{path} cannot be opened: {reason_of(error)}") from error
    if size == 0:
        raise MapFormatError(f"{path} is empty; copy or save the map again")
    return size


def read_text(path: Path, *, max_bytes: int = MAX_TEXT_BYTES) -> str:
    """Return the text of a file of bounded size, in UTF-8 with or without a byte order mark.

    Raises
    ------
    MapFormatError
        If there is no such file, it is empty, too large or not UTF-8.
    """
    size = require_file(path)
    if size > max_bytes:
        raise MapFormatError(
            f"{path} has {size:,} bytes; files of this format are read up to {max_bytes:,}"
        )
    try:
        return path.read_bytes().decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise MapFormatError(
            f"{path} is not UTF-8 text: byte {error.start} is 0x{error.object[error.start]:02x}; "
            "save it as UTF-8"
        ) from error
    except OSError as error:
        raise MapFormatError(f"{path} cannot be read: {reason_of(error)}") from error


def read_json(path: Path, what: str) -> object:
    """Return the content of a JSON file; NaN and Infinity are read as floats.

    Parameters
    ----------
    path : Path
        The file, of at most `MAX_POLYGON_BYTES` bytes.
    what : str
        The format, for messages, such as ``"GeoJSON"``.

    Raises
    ------
    MapFormatError
        If the file cannot be read, is not JSON, or is nested too deep.
    """
    text = read_text(path, max_bytes=MAX_POLYGON_BYTES)
    try:
        return json.loads(text)
    except json.JSONDecodeError as error:
        raise MapFormatError(
            f"{path} is not JSON, line {error.lineno}, column {error.colno}: {error.msg}"
        ) from error
    except (ValueError, RecursionError) as error:
        raise MapFormatError(f"{path} is not {what}: {reason_of(error)}") from error


def named_file(folder: Path, name: str, place: str) -> Path | None:
    """Return the path of a file that a map file names, which is in a folder or below it.

    The only way from a name in a file to a path.

    Parameters
    ----------
    folder : Path
        Folder to which the name is relative and which it may not leave, also by a symbolic link.
    name : str
        The name, as written in the map file.
    place : str
        The map file and the place in it, for messages.

    Returns
    -------
    Path or None
        The path; None if there is no file or folder of that name.

    Raises
    ------
    MapFormatError
        If the name leads out of the folder, or cannot be the name of a file.

    Examples
    --------
    >>> Path("cave.png").touch()
    >>> named_file(Path(), "cave.png", "cave.world, line 1"), named_file(Path(), "x.png", "")
    (PosixPath('cave.png'), None)
    """
    if len(name) > MAX_NAME_LENGTH:
        raise MapFormatError(
            f"{place} names the file {shown(name)}; a name has at most {MAX_NAME_LENGTH} "
            "characters, with its folders"
        )
    try:
        found = folder / name
        is_inside = found.resolve().is_relative_to(folder.resolve())
        exists = is_inside and found.exists()
    except (OSError, ValueError, RuntimeError) as error:
        raise MapFormatError(
            f"{place} names the file {shown(name)}, which cannot be opened: {reason_of(error)}; "
            "correct the name"
        ) from error
    if not is_inside:
        raise MapFormatError(
            f"{place} names the file {shown(name)}, which is not in the folder of the map; "
            f"{_file_beside(folder, name) or 'copy it into that folder and correct the name'}"
        )
    return found if exists else None


def no_such_file(folder: Path, name: str, what: str) -> MapFormatError:
    """Return the error that a file that a map file names does not exist.

    Parameters
    ----------
    folder : Path
        Folder of the map.
    name : str
        The name, as written in the map file.
    what : str
        The map file and the place in it, and what it names there, for the message, such as
        ``"hall.yaml names the image"``.

    Returns
    -------
    MapFormatError
        It says if there is a file of that name beside the map, without the folders in the name.

    Examples
    --------
    >>> Path("cave.png").touch()
    >>> print(no_such_file(Path(), "bitmaps/cave.png", "cave.world, line 1 names the bitmap"))
    cave.world, line 1 names the bitmap bitmaps/cave.png, which is not in the folder of the map; \
cave.png is beside the map: write "cave.png", or move it to bitmaps
    """
    where = "the folder of the map" if folder == Path() else folder
    remedy = _file_beside(folder, name) or "copy it there or correct the name"
    return MapFormatError(f"{what} {shortened(name)}, which is not in {where}; {remedy}")


def _file_beside(folder: Path, name: str) -> str:
    """Return that there is a file of a name, without its folders, beside the map; else ""."""
    path = PurePosixPath(name)
    if len(path.parts) < 2:
        return ""
    try:
        beside = folder / path.name
        if not (beside.is_file() and beside.resolve().parent == folder.resolve()):
            return ""
    except (OSError, ValueError, RuntimeError):
        return ""
    is_below = not path.is_absolute() and ".." not in path.parts
    moved = f", or move it to {shortened(str(path.parent))}" if is_below else ""
    file = shortened(path.name, MAX_NAME_LENGTH)
    return f'{file} is beside the map: write "{file}"{moved}'


def require_resolution(
    path: Path,
    resolution_m: float | None,
    *,
    unit: str = "cell",
    min_m: float = SLIVER_WIDTH_M,
) -> float:
    """Return the metres per pixel, cell or unit of a drawing, for a file without a scale.

    Parameters
    ----------
    path : Path
        The file, for messages.
    resolution_m : float or None
        The option of the reader.
    unit : str
        What the resolution is the size of, for messages.
    min_m : float
        Minimum in metres; by default 1 mm, the width below which space is not free.

    Raises
    ------
    MapFormatError
        If the resolution is None or no length of `require_length`.
    """
    if resolution_m is None:
        raise MapFormatError(
            f"{path} does not say how large a {unit} is; "
            f"give the metres per {unit} with {RESOLUTION_OPTION}"
        )
    resolution_m = require_number(path, "resolution", resolution_m)
    return require_length(
        str(path), "the resolution", resolution_m, unit=f"m per {unit}", min_m=min_m
    )


def require_length(
    place: str, what: str, length_m: float, *, unit: str = "m", min_m: float = MIN_LENGTH_M
) -> float:
    """Return a length of a map that others are multiplied with or divided by.

    Parameters
    ----------
    place : str
        The file and the place in it, for messages.
    what : str
        What has the length, for messages.
    length_m : float
        The length in metres.
    unit : str
        Its unit, for messages, such as ``"m per cell"``.
    min_m : float
        Minimum in metres.

    Raises
    ------
    MapFormatError
        If the length is not finite, below the minimum, or above `MAX_COORDINATE_M`: products and
        quotients of lengths must neither overflow nor vanish.

    Examples
    --------
    >>> require_length("hall.yaml", "the resolution", 1e308, unit="m per cell")
    Traceback (most recent call last):
        ...
    multisrt.geometry.errors.MapFormatError: hall.yaml: the resolution is 1e+308 m per cell; \
it must be a finite number, at least 1e-06 and at most 1e+07 m
    """
    if not min_m <= length_m <= MAX_COORDINATE_M:
        raise MapFormatError(
            f"{place}: {what} is {length_m:g} {unit}; it must be a finite number, at least "
            f"{min_m:g} and at most {MAX_COORDINATE_M:g} m"
        )
    return length_m


def require_number(path: Path, what: str, value: Any) -> float:
    """Return an option of a reader as a float.

    Raises
    ------
    MapFormatError
        If it is not a number.
    """
    if not isinstance(value, bool | str):
        with suppress(TypeError, ValueError, OverflowError):
            return float(value)
    raise MapFormatError(f"{path}: the {what} must be a number, not {shown(value)}")


def refuse_resolution(path: Path, resolution_m: float | None) -> None:
    """Reject a resolution, for a format with its own scale.

    Raises
    ------
    MapFormatError
        If it is not None.
    """
    if resolution_m is not None:
        raise MapFormatError(f"{path} has its own scale; leave out --resolution (resolution_m)")


def refuse_threshold(path: Path, threshold: float | None) -> None:
    """Reject a threshold, for a format other than a plain image.

    Raises
    ------
    MapFormatError
        If it is not None.
    """
    if threshold is not None:
        raise MapFormatError(f"{path} is not a plain image; leave out --threshold (threshold)")


def grid_polygons(path: Path, free: BoolArray, resolution_m: Resolution) -> MultiPolygon:
    """Return the polygons of the free cells of a grid whose first row is at the top.

    Parameters
    ----------
    path : Path
        The file, for messages.
    free : bool array, shape (rows, columns)
        True where a cell is free.
    resolution_m : float or (x, y)
        Side of a cell in metres, or its width and its height.

    Raises
    ------
    MapFormatError
        If the grid has too many corners.
    """
    try:
        return polygons_from_grid(free[::-1], resolution_m)
    except InvalidInputError as error:
        raise MapFormatError(f"{path}: {error}") from error


def straightened(free: BaseGeometry, resolution_m: Resolution) -> Cleaning:
    """Return the changes that `grid_polygons` made to the walls of a grid.

    Parameters
    ----------
    free : MultiPolygon
        Its result, which may have been stretched. If all edges are parallel to an axis, no wall
        was moved.
    resolution_m : float or (x, y)
        Side of a cell in metres, or its width and its height.

    Examples
    --------
    >>> room, stairs = np.ones((4, 6), bool), np.tri(8, 8, dtype=bool)
    >>> polygons = [grid_polygons(Path("map.png"), free, 0.5) for free in (room, stairs)]
    >>> [str(straightened(free, 0.5)) for free in polygons]
    ['', 'walls straightened within 0.336 m']
    """
    points, ring = shapely.get_coordinates(
        shapely.get_rings(shapely.get_parts(free)), return_index=True
    )
    along = np.diff(points, axis=0)[ring[1:] == ring[:-1]]
    if not (along != 0.0).all(axis=1).any():
        return Cleaning()
    return Cleaning(straightened_m=displacement_bound_m(resolution_m))


class FileStarts(NamedTuple):
    """The suggested starts of a file.

    Attributes
    ----------
    points : sequence of (x, y)
        The starts, in metres. Of equal ones the first counts, and of many the first `MAX_STARTS`.
    places : sequence of str
        For each start the file and the place in it, for messages; if empty, the file.
    repair : bool or None
        Whether starts outside free space are left out instead of refused; None if the reader
        repairs nothing.
    """

    points: Sequence[tuple[float, float]] = ()
    places: Sequence[str] = ()
    repair: bool | None = None

    def distinct(self) -> "FileStarts":
        """Return the starts that count."""
        first: dict[tuple[float, float], int] = {}
        for number, point in enumerate(self.points):
            first.setdefault(point, number)
        kept = list(first.values())[:MAX_STARTS]
        return FileStarts(
            [self.points[number] for number in kept],
            [self.places[number] for number in kept] if self.places else (),
            self.repair,
        )


NO_STARTS: Final = FileStarts()


def build_environment(
    path: Path,
    free: BaseGeometry,
    *,
    name: str | None,
    origin: str,
    starts: FileStarts = NO_STARTS,
    cleaning: Cleaning | None = None,
    layers: Layers | None = None,
    outlined_obstacles: bool = False,
) -> Environment:
    """Return the world of a file; its default name is that of the file without suffix.

    Parameters
    ----------
    path : Path
        The file, for the name and for messages.
    free, name, origin, cleaning, layers, outlined_obstacles
        As for `Environment`.
    starts : FileStarts, optional
        The suggested starts.

    Raises
    ------
    MapFormatError
        If the free space is not valid, or a start is not in it.
    """
    name = path.stem if name is None else name
    of_file: dict[str, Any] = {"layers": layers, "outlined_obstacles": outlined_obstacles}
    starts = starts.distinct()
    origin = escaped(origin)  # may hold names from the file
    try:
        return Environment(
            name, free, starts=starts.points, origin=origin, cleaning=cleaning, **of_file
        )
    except InvalidInputError as error:
        if not starts.points:
            raise MapFormatError(f"{path}: {error}") from error
    world = build_environment(path, free, name=name, origin=origin, cleaning=cleaning, **of_file)
    inside = [world.contains(*start) for start in starts.points]
    if not starts.repair:
        first = inside.index(False)
        place = starts.places[first] if starts.places else path
        x, y = starts.points[first]
        raise MapFormatError(
            f"{place}: the suggested start ({x:g}, {y:g}) is not in free space, but "
            f"{world.free.distance(Point(x, y)):.3g} m away from it; move it or remove it"
            + ("" if starts.repair is None else f"; {FIXING} without it")
        )
    return Environment(
        name,
        world.free,
        starts=[start for start, is_inside in zip(starts.points, inside, strict=True) if is_inside],
        origin=origin,
        cleaning=world.cleaning + Cleaning(removed_starts=inside.count(False)),
        **of_file,
    )
