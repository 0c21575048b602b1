"""Plain images as maps: light pixels are free, dark ones are not."""

import io
import math
import re
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from multisrt.environments.environment import Environment
from multisrt.environments.formats.files import (
    MAX_CELLS,
    FileStarts,
    build_environment,
    grid_polygons,
    require_file,
    require_number,
    require_resolution,
    straightened,
)
from multisrt.environments.formats.map_format import Beginning, MapFormat
from multisrt.environments.formats.row_blocks import row_blocks
from multisrt.environments.formats.start_mark import marked_starts
from multisrt.geometry.errors import MapFormatError, reason_of
from multisrt.geometry.numerics.kernel import BoolArray

if TYPE_CHECKING:
    from PIL.Image import Image

FREE_SHARE_OF_WHITE = 0.9
"""Default threshold of free pixels, as a share of the white of the map."""

WHITE_PERCENTILE = 99
"""Percentile of lightness that is taken as the white of a map."""

LUMA = (299, 587, 114)
"""Weights of red, green and blue in the lightness of a pixel (ITU-R BT.601)."""

# An explicit list, since Pillow also has formats that start other programs.
PILLOW_FORMATS = ("PNG", "PPM", "BMP", "JPEG", "GIF", "TIFF")


def read_image(
    path: Path,
    *,
    resolution_m: float | None = None,
    threshold: float | None = None,
    name: str | None = None,
) -> Environment:
    """Read an image whose light pixels are free space.

    The lower left corner of the image is the origin, y is up. Lightness is the grey value, or the
    luma of a colour, as a share of the largest that the image's depth allows. Pixels that are
    not fully opaque are not free. A small square in free space, of a level used nowhere else,
    marks a suggested start; see `start_mark`.

    Parameters
    ----------
    path : Path
        PNG, PGM (and PBM, PPM), BMP, GIF, JPEG or TIFF with 1, 8 or 16 bits a channel.
    resolution_m : float
        Side of a pixel in metres. Required, since the pixels per inch stated in an image are those
        of a screen or a printer, and world files beside an image do not state their unit.
    threshold : float, optional
        Lightness in [0, 1] above which a pixel is free. By default 0.9 of the map's white, which
        is the 99th percentile of lightness.
    name : str, optional
        By default the file's name without suffix.

    Raises
    ------
    MapFormatError
        If the file is not a readable image, is larger than 64 million pixels, or has no free
        pixel.

    Notes
    -----
    The default threshold separates free space from the light greys of unknown cells in SLAM maps
    and of furniture in floor plans, and adapts to maps that draw free space in grey. Otsu's method,
    which separates the two main groups of greys, fails where there are few walls: with 4 % of
    pixels black, 52 % at 205 (unknown) and 44 % at 254, its threshold is 0.
    """
    resolution_m = require_resolution(path, resolution_m)
    pixels = read_pixels(path)
    levels, full = pixels.weighted(LUMA)
    free, threshold = free_pixels(path, levels, threshold, full=full, opaque=pixels.opaque)
    polygons = grid_polygons(path, free, resolution_m)
    return build_environment(
        path,
        polygons,
        name=name,
        origin=f"{path.name} at {resolution_m:g} m per pixel, free above lightness {threshold:.3g}",
        starts=FileStarts(marked_starts(levels, free, resolution_m)),
        cleaning=straightened(polygons, resolution_m),
    )


def free_pixels(
    path: Path,
    levels: NDArray[np.uint8] | NDArray[np.uint32],
    threshold: float | None,
    *,
    full: int = 255,
    opaque: BoolArray | None = None,
) -> tuple[BoolArray, float]:
    """Return the mask of the free pixels of an image, and the threshold.

    Parameters
    ----------
    path : Path
        The file, for messages.
    levels : int array, shape (rows, columns)
        Lightness of the pixels, from 0 to `full`.
    threshold : float or None
        Lightness in [0, 1] above which a pixel is free; None for the default of `read_image`.
    full : int
        The largest possible level.
    opaque : bool array, shape (rows, columns), optional
        Mask of the pixels that may be free; by default all.

    Returns
    -------
    free : bool array, shape (rows, columns)
        Mask with at least one pixel.
    threshold : float
        The threshold that was used.

    Raises
    ------
    MapFormatError
        If the threshold is not in [0, 1], or no pixel is free.
    """
    if threshold is not None:
        threshold = require_number(path, "threshold", threshold)
        if not 0.0 <= threshold <= 1.0:
            raise MapFormatError(f"{path}: the threshold is {threshold:g}; lightness is in [0, 1]")
    else:
        threshold = FREE_SHARE_OF_WHITE * _white(levels, full, opaque) / full
    is_free = np.arange(full + 1) / full > threshold
    free = is_free[levels]
    if opaque is not None:
        free &= opaque
    if not free.any() and threshold == 0.0:
        is_blank = opaque is not None and not opaque.any()
        found = "no pixel is opaque" if is_blank else "every opaque pixel is black"
        raise MapFormatError(
            f"{path}: {found}, so there is no free space; draw free space light and opaque"
        )
    if not free.any():
        raise MapFormatError(
            f"{path}: no opaque pixel is lighter than {threshold:.3g}, so there is no free space; "
            "give a lower --threshold (threshold)"
        )
    return free, threshold


@dataclass(frozen=True, slots=True, kw_only=True)
class Pixels:
    """A decoded image, first row at the top.

    Attributes
    ----------
    channels : uint8 or uint16 array, shape (rows, columns) or (rows, columns, 3)
        Grey values, or red, green and blue.
    full : int
        The largest value that a channel can have: 255 or 65535.
    alpha : uint8 array, shape (rows, columns), optional
        Opacity; 255 is opaque.
    """

    channels: NDArray[np.uint8] | NDArray[np.uint16]
    full: int
    alpha: NDArray[np.uint8] | None

    @property
    def opaque(self) -> BoolArray | None:
        """Mask of the fully opaque pixels; None if all are."""
        return None if self.alpha is None else self.alpha == 255

    def weighted(self, weights: tuple[int, int, int]) -> tuple[NDArray[np.uint32], int]:
        """Return the weighted sum of red, green and blue of each pixel, and its largest value.

        For a grey image, the weights do not matter: it returns the grey values.
        """
        if self.channels.ndim == 2:
            return self.channels.astype(np.uint32), self.full
        levels = np.zeros(self.channels.shape[:2], np.uint32)
        for channel, weight in enumerate(weights):
            levels += np.uint32(weight) * self.channels[:, :, channel]
        return levels, sum(weights) * self.full


def read_pixels(path: Path) -> Pixels:
    """Return the pixels of an image of at most 64 million pixels.

    Raises
    ------
    MapFormatError
        If the file is missing, not an image of a readable format, too large or damaged.
    """
    from PIL import Image, UnidentifiedImageError

    require_file(path)
    with warnings.catch_warnings():
        # Sizes are checked before anything is decoded; other warnings concern metadata.
        warnings.simplefilter("ignore")
        try:
            with opened_image(path) as image:
                _require_size(path, *image.size)
                return _decoded(path, image)
        except MapFormatError:
            raise
        except UnidentifiedImageError as error:
            raise MapFormatError(
                f"{path} is not an image that can be read; "
                f"save it as one of {', '.join(PILLOW_FORMATS)}"
            ) from error
        except Image.DecompressionBombError as error:
            pixels = re.search(r"\d+", str(error))
            size = f"{int(pixels.group()):,} pixels" if pixels else "too many pixels"
            raise MapFormatError(
                f"{path} says that it has {size}; images are read up to {MAX_CELLS:,} pixels"
            ) from error
        except Exception as error:  # a damaged file makes decoders raise almost anything
            raise MapFormatError(
                f"{path} is a damaged image: {reason_of(error)}; copy it again, or open it "
                "and save it anew"
            ) from error


@contextmanager
def opened_image(path: Path) -> Iterator["Image"]:
    """Open an image of one of the `PILLOW_FORMATS`, without decoding it.

    Parameters
    ----------
    path : Path
        The file. Lengths that it states are not trusted: no read allocates more than it has bytes.

    Yields
    ------
    PIL.Image.Image
        The image, until the end of the block.
    """
    from PIL import Image

    with _BoundedReader(path) as file, Image.open(file, formats=PILLOW_FORMATS) as image:
        yield image


class _BoundedReader(io.BufferedReader):
    """A file of which no more is read than there is, because reading allocates what is asked."""

    def __init__(self, path: Path) -> None:
        super().__init__(io.FileIO(path))
        self._bytes = path.stat().st_size

    def read(self, size: int | None = -1, /) -> bytes:
        left = max(self._bytes - self.tell(), 0)
        return super().read(left if size is None or size < 0 else min(size, left))


def _require_size(path: Path, width: int, height: int) -> None:
    if width * height > MAX_CELLS:
        raise MapFormatError(
            f"{path} has {width} x {height} pixels; images are read up to {MAX_CELLS:,} pixels"
        )


def _decoded(path: Path, image: "Image") -> Pixels:
    """Return the pixels of an image of any mode of Pillow, with 8 or 16 bits per channel."""
    mode = image.mode
    if image.format == "PNG" and "transparency" in image.info:
        image.info["transparency"] = _transparent_of_png(path, image.info["transparency"])
    key = image.info.get("transparency")
    if mode.startswith("I"):
        values = np.asarray(image)
        if values.min() < 0 or values.max() > 65535:
            raise MapFormatError(
                f"{path} has grey values from {values.min()} to {values.max()}; "
                "they must be from 0 to 65535: save it with 8 or 16 bits"
            )
        alpha = None if key is None else np.where(values == key, 0, 255).astype(np.uint8)
        return Pixels(channels=values.astype(np.uint16), full=65535, alpha=alpha)
    if mode == "F":
        raise MapFormatError(
            f"{path} has floating-point pixels, whose white is not known; save it with 8 or 16 bits"
        )
    is_grey = mode in ("1", "L", "LA", "La")
    has_alpha = key is not None or mode in ("LA", "La", "PA", "RGBA", "RGBa")
    target = ("L" if is_grey else "RGB") + ("A" if has_alpha else "")
    values = np.asarray(image if mode == target else image.convert(target))
    if not has_alpha:
        return Pixels(channels=values, full=255, alpha=None)
    channels = values[:, :, 0] if is_grey else values[:, :, :3]
    return Pixels(channels=channels, full=255, alpha=values[:, :, -1])


def _transparent_of_png(path: Path, key: Any) -> Any:
    """Return the transparent colour of a PNG at the depth to which Pillow decodes it."""
    with path.open("rb") as file:
        depth, kind = file.read(26)[24:]
    if kind == 0 and depth in (2, 4):  # grey, which is stretched to 8 bits
        return key * 255 // (2**depth - 1)
    if kind == 2 and depth == 16:  # colours, whose lower 8 bits are dropped
        raise MapFormatError(
            f"{path} has a transparent colour of 16 bits a channel, which cannot be told from its "
            "neighbours; save it with an alpha channel or with 8 bits"
        )
    return key


def _white(
    levels: NDArray[np.uint8] | NDArray[np.uint32], full: int, opaque: BoolArray | None
) -> int:
    """Return the level that 99 % of the opaque pixels do not exceed."""
    histogram = np.zeros(full + 1, np.int64)
    for rows in row_blocks(levels.shape):  # counting needs eight bytes a pixel
        some = levels[rows]
        counted = some.ravel() if opaque is None else some[opaque[rows]]
        histogram += np.bincount(counted, minlength=full + 1)
    counts = np.cumsum(histogram)
    return int(np.searchsorted(counts, math.ceil(counts[-1] * WHITE_PERCENTILE / 100)))


SIGNATURES = (
    b"\x89PNG\r\n\x1a\n",
    b"\xff\xd8\xff",
    b"GIF8",
    b"II*\0",
    b"MM\0*",
    *(b"P%d%c" % (kind, space) for kind in range(1, 7) for space in b" \t\r\n#"),
)
"""First bytes of image files; the two letters of BMP alone are not distinctive."""


def _is_image(beginning: Beginning) -> bool:
    raw = beginning.raw
    # The header of a BMP has four bytes of zero, where text has none.
    return raw.startswith(SIGNATURES) or (raw.startswith(b"BM") and raw[6:10] == bytes(4))


IMAGE = MapFormat(
    name="image",
    suffixes=(
        ".png",
        ".pgm",
        ".pbm",
        ".ppm",
        ".pnm",
        ".bmp",
        ".gif",
        ".jpg",
        ".jpeg",
        ".tif",
        ".tiff",
    ),
    recognises=_is_image,
    read=read_image,
)
