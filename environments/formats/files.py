"""What every reader does: open a file within bounds, check its options, build the world."""

import math
from collections.abc import Sequence
from pathlib import Path

from shapely import MultiPolygon
from shapely.geometry.base import BaseGeometry

from multisrt.environments.environment import SLIVER_WIDTH_M, Environment
from multisrt.environments.formats.bitmap import polygons_from_grid
from multisrt.geometry.errors import InvalidInputError, MapFormatError
from multisrt.geometry.numerics.kernel import BoolArray

MAX_TEXT_BYTES = 64 * 2**20
"""Largest text file that is read: 64 MiB."""

MAX_CELLS = 64_000_000
"""Largest image or grid that is read, in pixels or cells."""


def require_file(path: Path) -> int:
    """Return a file's size in bytes, or say why it cannot be a map.

    Raises
    ------
    MapFormatError
        If the path does not exist, is not a regular file, or is empty.
    """
    try:
        if path.is_dir():
            raise MapFormatError(f"{path} is a folder; name the map file in it")
        if not path.exists():
            raise MapFormatError(f"{path} does not exist; check the name and the folder")
        if not path.is_file():
            raise MapFormatError(f"{path} is not a regular file; copy the map into one")
        size = path.stat().st_size
    except (OSError, ValueError) as error:
        raise MapFormatError(f"{path} cannot be opened: {error}") from error
    if size == 0:
        raise MapFormatError(f"{path} is empty; copy or save the map again")
    return size


def read_text(path: Path, *, max_bytes: int = MAX_TEXT_BYTES) -> str:
    """Read a text file of bounded size, in UTF-8 with or without a byte order mark.

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
        raise MapFormatError(f"{path} cannot be read: {error}") from error


def require_resolution(path: Path, resolution_m: float | None) -> float:
    """Return the metres per pixel or cell of a file that does not tell its own scale.

    Raises
    ------
    MapFormatError
        If none was given, or it is not a finite number of at least 1 mm.
    """
    if resolution_m is None:
        raise MapFormatError(
            f"{path} does not say how large a cell is; "
            "give the metres per cell with --resolution (resolution_m)"
        )
    if not (math.isfinite(resolution_m) and resolution_m >= SLIVER_WIDTH_M):
        raise MapFormatError(
            f"{path}: the resolution is {resolution_m:g} m per cell; "
            f"it is a finite number of at least {SLIVER_WIDTH_M:g} m"
        )
    return float(resolution_m)


def refuse_resolution(path: Path, resolution_m: float | None) -> None:
    """Refuse a resolution for a file that is in metres or tells its own scale.

    Raises
    ------
    MapFormatError
        If one was given.
    """
    if resolution_m is not None:
        raise MapFormatError(f"{path} has its own scale; leave --resolution (resolution_m) away")


def refuse_threshold(path: Path, threshold: float | None) -> None:
    """Refuse a threshold for a file that is no picture or states its own thresholds.

    Raises
    ------
    MapFormatError
        If one was given.
    """
    if threshold is not None:
        raise MapFormatError(f"{path} is not a plain image; leave --threshold (threshold) away")


def grid_polygons(path: Path, free: BoolArray, resolution_m: float) -> MultiPolygon:
    """Return the polygons of a file's free cells, first row at the top.

    Raises
    ------
    MapFormatError
        If the grid is noise.
    """
    try:
        return polygons_from_grid(free[::-1], resolution_m)
    except InvalidInputError as error:
        raise MapFormatError(f"{path}: {error}") from error


def build_environment(
    path: Path,
    free: BaseGeometry,
    *,
    name: str | None,
    origin: str,
    starts: Sequence[tuple[float, float]] = (),
) -> Environment:
    """Build the world that a file describes; its name is the file's without the suffix.

    Raises
    ------
    MapFormatError
        If the free space is not one that a world can have.
    """
    try:
        return Environment(path.stem if name is None else name, free, starts=starts, origin=origin)
    except InvalidInputError as error:
        raise MapFormatError(f"{path}: {error}") from error


def shown(value: object) -> str:
    """Show a value from a file in a message: short, whatever it contains."""
    if isinstance(value, list | tuple | dict | set):
        return f"a {type(value).__name__} of {len(value)}"
    text = repr(value)
    return text if len(text) <= 60 else text[:57] + "..."
