"""Numpy arrays as maps: occupancy grids and grey images in ``.npy`` files."""

import itertools
import math
import re
import warnings
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.lib import format as npy_format
from numpy.typing import NDArray

from multisrt.environments.environment import Environment
from multisrt.environments.formats.files import (
    MAX_CELLS,
    build_environment,
    grid_polygons,
    refuse_threshold,
    require_file,
    require_resolution,
    straightened,
)
from multisrt.environments.formats.image import free_pixels
from multisrt.environments.formats.map_format import Beginning, MapFormat
from multisrt.environments.formats.row_blocks import row_blocks
from multisrt.geometry.errors import MapFormatError, reason_of, shortened
from multisrt.geometry.numerics.kernel import BoolArray

FREE_OCCUPANCY: Final = 0.25
"""Maximum occupancy of a free cell: the ``free`` threshold with which ROS saves maps."""

MAX_HEADER_BYTES: Final = 10_000
"""Upper bound of the length of the header, which is a Python literal."""

MAX_HEADER_DEPTH: Final = 8
"""Upper bound of the brackets in each other in the header; those of structures have four."""

MAX_SIDE: Final = 2**63 - 1
"""Upper bound of the sides that numpy allows; a header may hold any whole number."""

AS_OCCUPANCIES: Final = "save occupancies as int8 (0 to 100, -1 unknown) or bool (True occupied)"
"""Remedy for numbers whose meaning is not clear."""

MAGIC: Final = b"\x93NUMPY"


def read_numpy_array(
    path: Path,
    *,
    resolution_m: float | None = None,
    threshold: float | None = None,
    name: str | None = None,
) -> Environment:
    """Read a grid from a ``.npy`` file, whose first row is at the top.

    The data type determines the meaning of the numbers:

    ===================  =========================================================
    bool                 occupancy: True is occupied, False is free
    int8 or wider        occupancy of a ROS ``OccupancyGrid``: 0 to 100, or -1 for
                         the unknown; free up to 25
    float                probability of occupancy, 0 to 1, or NaN for the unknown;
                         free up to 0.25
    uint8                grey values of an image: light is free, as in `read_image`
    ===================  =========================================================

    Parameters
    ----------
    path : Path
        A two-dimensional array as `numpy.save` writes it, of at most 64 million cells. The first
        row is at the top, as in a printed array and in ``imshow``; the ``data`` of an
        ``OccupancyGrid`` begin with the lowest row, so save ``numpy.flipud`` of the grid.
    resolution_m : float
        Side of a cell in metres. The format does not contain it; there is no default.
    threshold : float, optional
        Lightness in [0, 1] above which a cell is free; only for uint8.
    name : str, optional
        By default the file's name without suffix.

    Raises
    ------
    MapFormatError
        If the file is not such an array, holds Python objects, has numbers out of range, uint8
        numbers that may be occupancies, or integers up to 1, which may be per cent or truth values;
        or if no cell is free.

    Notes
    -----
    Source: numpy, NEP 1 (format of ``.npy`` files); ROS, ``nav_msgs/OccupancyGrid`` and the
    thresholds of ``map_saver``; differs in: unknown cells are not free.

    Examples
    --------
    >>> import numpy as np
    >>> from pathlib import Path
    >>> room = np.zeros((4, 6), dtype=bool)
    >>> room[1:3, 2] = True
    >>> np.save("room.npy", room)
    >>> read_numpy_array(Path("room.npy"), resolution_m=0.5).area_m2
    5.5
    """
    array = mapped(path)
    resolution_m = require_resolution(path, resolution_m)
    if array.dtype == np.uint8:
        _require_grey(path, array)
        free, threshold = free_pixels(path, array, threshold)
        rule = f"free above lightness {threshold:.3g}"
    else:
        refuse_threshold(path, threshold)
        free = _free_cells(path, array)
        rule = f"free up to occupancy {FREE_OCCUPANCY:g}"
        if not free.any():
            raise MapFormatError(
                f"{path}: no cell has an occupancy of at most {FREE_OCCUPANCY:g}, so there is no "
                "free space; occupied is True, 100 or 1.0, and free is False or 0"
            )
    polygons = grid_polygons(path, free, resolution_m)
    return build_environment(
        path,
        polygons,
        name=name,
        origin=f"{path.name} at {resolution_m:g} m per cell, {rule}",
        cleaning=straightened(polygons, resolution_m),
    )


def mapped(path: Path) -> NDArray[Any]:
    """Return the array of a file, mapped into memory after its header has been checked."""
    size = require_file(path)
    try:
        with path.open("rb") as file:
            shape, fortran_order, dtype = _header(path, file)
            start = file.tell()
    except OSError as error:
        raise MapFormatError(f"{path} cannot be read: {reason_of(error)}") from error
    if not (dtype.kind in "bif" or dtype == np.uint8):
        raise MapFormatError(
            f"{path} has numbers of type {_type_name(dtype)}; a map has bool, uint8, int8 (or "
            "wider) or float: convert it with astype"
        )
    if len(shape) != 2:
        raise MapFormatError(f"{path} has the shape {_shown(shape)}; a grid has rows and columns")
    cells = math.prod(shape)
    if cells == 0:
        raise MapFormatError(f"{path} has the shape {_shown(shape)}, which has no cells")
    if cells > MAX_CELLS:
        raise MapFormatError(
            f"{path} has {shape[0]} x {shape[1]} cells; grids are read up to {MAX_CELLS:,} cells"
        )
    if size - start < cells * dtype.itemsize:
        raise MapFormatError(
            f"{path} ends after {size - start:,} of {cells * dtype.itemsize:,} bytes of numbers; "
            "copy or save it again"
        )
    return np.memmap(
        path,
        dtype=dtype,
        mode="r",
        offset=start,
        shape=shape,
        order="F" if fortran_order else "C",
    )


def _header(path: Path, file: Any) -> tuple[tuple[int, ...], bool, np.dtype[Any]]:
    """Return shape, whether columns come first, and type; leave the file at the numbers."""
    if file.read(len(MAGIC)) != MAGIC:
        raise MapFormatError(f"{path} is not a .npy file; write it with numpy.save")
    version = tuple(file.read(2))
    readers = {
        (1, 0): (2, npy_format.read_array_header_1_0),
        (2, 0): (4, npy_format.read_array_header_2_0),
    }
    if version not in readers:
        raise MapFormatError(
            f"{path} has version {'.'.join(map(str, version)) or 'none'} of the .npy format; "
            "grids have version 1.0"
        )
    digits, read_header = readers[version]
    length = int.from_bytes(file.read(digits), "little")
    if length > MAX_HEADER_BYTES:
        raise MapFormatError(
            f"{path} has a header of {length:,} bytes; grids have at most {MAX_HEADER_BYTES:,}"
        )
    _require_literal(path, file.read(length).decode("latin-1"))
    file.seek(len(MAGIC) + 2)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # headers that Python 2 wrote
            shape, fortran_order, dtype = read_header(file, max_header_size=MAX_HEADER_BYTES)
    except Exception as error:  # the header is a literal: parsing it raises almost anything
        raise _damaged_header(path) from error
    if any(abs(side) > MAX_SIDE for side in shape):
        raise _damaged_header(path)
    if any(isinstance(side, bool) or side < 0 for side in shape):
        raise MapFormatError(f"{path} has the shape {_shown(shape)}; sides are not negative")
    return shape, fortran_order, dtype


_TEXT: Final = re.compile(r"""'[^'\\]*'|"[^"\\]*\"""")
_WORD: Final = re.compile(r"True|False|-?\d[\d.]*L?|[\s()\[\]{},:]")


def _require_literal(path: Path, header: str) -> None:
    """Reject a header that is nested deeply, on which Python's parser runs out of its memory.

    Texts, numbers, truth values and brackets are allowed, brackets up to `MAX_HEADER_DEPTH` deep.
    """
    bare = _TEXT.sub("", header)
    depth = itertools.accumulate((sign in "([{") - (sign in ")]}") for sign in bare)
    if _WORD.sub("", bare) or max(depth, default=0) > MAX_HEADER_DEPTH:
        raise _damaged_header(path)


def _damaged_header(path: Path) -> MapFormatError:
    return MapFormatError(f"{path} has a damaged header; write it with numpy.save")


def _shown(shape: tuple[int, ...]) -> str:
    return shortened(str(shape))


def _type_name(dtype: np.dtype[Any]) -> str:
    return "object (pickled Python)" if dtype.hasobject else shortened(str(dtype))


def _require_grey(path: Path, array: NDArray[np.uint8]) -> None:
    """Reject uint8 numbers that look like occupancies, which are high where grey is low."""
    used = np.zeros(256, np.bool_)
    for rows in row_blocks(array.shape):  # so that the mapped array is not copied
        used[array[rows]] = True
    greatest = int(np.flatnonzero(used)[-1])
    is_ros = used[100] and used[255] and not used[101:255].any()
    if greatest <= 100 or is_ros:
        found = "0 to 100 and 255" if is_ros else f"up to {greatest}"
        raise MapFormatError(
            f"{path} has uint8 numbers {found}, which may be occupancies or grey values: "
            f"{AS_OCCUPANCIES}, and grey values up to 255"
        )


def _free_cells(path: Path, array: NDArray[Any]) -> BoolArray:
    free = np.empty(array.shape, np.bool_)
    if array.dtype.kind == "b":
        # In a file from elsewhere, bytes of bools may be other than 0 and 1.
        np.equal(array.view(np.uint8), 0, out=free)
        return free
    is_whole = array.dtype.kind == "i"
    greatest = -1
    least, full = (-1, 100) if is_whole else (0, 1)
    for rows in row_blocks(array.shape):  # since comparisons allocate memory
        some = array[rows]
        strange = np.argwhere((some < least) | (some > full))
        if strange.size:
            row, column = strange[0]
            unknown = "-1" if is_whole else "NaN"
            raise MapFormatError(
                f"{path}, row {rows.start + row}, column {column} is {some[row, column]:g}; "
                f"occupancies of type {array.dtype} are 0 to {full}, or {unknown} for the unknown"
            )
        free[rows] = (some >= 0) & (some <= FREE_OCCUPANCY * full)
        greatest = max(greatest, some.max(initial=-1))
    if is_whole and greatest == 1:
        raise MapFormatError(
            f"{path} has {array.dtype} numbers up to 1, which may be 1 per cent or occupied: "
            f"{AS_OCCUPANCIES}"
        )
    return free


def _is_numpy_array(beginning: Beginning) -> bool:
    return beginning.raw.startswith(MAGIC)


NUMPY_ARRAY = MapFormat(
    name="numpy array",
    suffixes=(".npy",),
    recognises=_is_numpy_array,
    read=read_numpy_array,
)
