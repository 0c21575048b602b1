"""Readers of map files, one format in each module."""

from pathlib import Path
from typing import Protocol

from multisrt.environments.environment import Environment
from multisrt.environments.formats.files import require_file
from multisrt.environments.formats.geojson import read_geojson
from multisrt.environments.formats.image import read_image
from multisrt.environments.formats.imr import read_imr
from multisrt.environments.formats.map_server import read_map_server
from multisrt.environments.formats.moving_ai import read_moving_ai
from multisrt.environments.formats.wkt import read_wkt
from multisrt.geometry.errors import MapFormatError

__all__ = [
    "FORMATS",
    "Reader",
    "read_environment",
    "read_geojson",
    "read_image",
    "read_imr",
    "read_map_server",
    "read_moving_ai",
    "read_wkt",
]


class Reader(Protocol):
    """Reader of one format, which rejects options that do not apply to it."""

    def __call__(
        self,
        path: Path,
        *,
        resolution_m: float | None = None,
        threshold: float | None = None,
        name: str | None = None,
    ) -> Environment:
        """Return the world of a file, or raise a MapFormatError; see `read_environment`."""


FORMATS: dict[str, Reader] = {
    ".yaml": read_map_server,
    ".yml": read_map_server,
    ".png": read_image,
    ".pgm": read_image,
    ".pbm": read_image,
    ".ppm": read_image,
    ".pnm": read_image,
    ".bmp": read_image,
    ".gif": read_image,
    ".jpg": read_image,
    ".jpeg": read_image,
    ".tif": read_image,
    ".tiff": read_image,
    ".geojson": read_geojson,
    ".json": read_geojson,
    ".wkt": read_wkt,
    ".map": read_moving_ai,
    ".txt": read_imr,
}
"""Readers by suffix in lower case."""


def read_environment(
    path: str | Path,
    *,
    resolution_m: float | None = None,
    threshold: float | None = None,
    name: str | None = None,
) -> Environment:
    """Return the world of a map file, whose suffix determines the format.

    Parameters
    ----------
    path : str or Path
        ROS map server (.yaml), image (.png, .pgm, ...), GeoJSON (.geojson, .json), well-known
        text (.wkt), MovingAI grid (.map) or IMR polygons (.txt).
    resolution_m : float, optional
        Metres per pixel or cell. Required for images and MovingAI grids; other formats have a
        scale of their own and do not accept it.
    threshold : float, optional
        Lightness in [0, 1] above which a pixel of an image is free; only for images.
    name : str, optional
        Name of the world; by default the name of the file without its suffix.

    Returns
    -------
    Environment
        The world, in metres.

    Raises
    ------
    MapFormatError
        If the suffix is not in ``FORMATS``, or the file cannot be read; the message names the
        file, the place in it and the remedy.

    Examples
    --------
    >>> from multisrt.environments.catalog import MAPS
    >>> read_environment(MAPS / "library.wkt", name="reading room").name
    'reading room'
    """
    path = Path(path)
    require_file(path)
    reader = FORMATS.get(path.suffix.lower())
    if reader is None:
        raise MapFormatError(
            f"{path} has the suffix {path.suffix!r}; readable are {', '.join(FORMATS)}"
        )
    return reader(path, resolution_m=resolution_m, threshold=threshold, name=name)
