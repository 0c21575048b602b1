"""Readers of map files: one module, or one package, for each format."""

import re
from pathlib import Path
from typing import Final

from multisrt.environments.environment import Environment
from multisrt.environments.formats.dxf import DXF, read_dxf
from multisrt.environments.formats.files import require_resolution
from multisrt.environments.formats.geojson import GEOJSON, read_geojson
from multisrt.environments.formats.house_expo import HOUSE_EXPO, read_house_expo
from multisrt.environments.formats.image import IMAGE, read_image
from multisrt.environments.formats.imr import IMR, read_imr
from multisrt.environments.formats.map_format import Beginning, MapFormat, Reader, beginning_of
from multisrt.environments.formats.map_server import MAP_SERVER, read_map_server
from multisrt.environments.formats.moving_ai import MOVING_AI, read_moving_ai
from multisrt.environments.formats.moving_ai_scenario import (
    MOVING_AI_SCENARIO,
    read_moving_ai_scenario,
)
from multisrt.environments.formats.mresim import is_team, refuse_team_alone, with_team
from multisrt.environments.formats.numpy_array import NUMPY_ARRAY, read_numpy_array
from multisrt.environments.formats.stage import STAGE, read_stage
from multisrt.environments.formats.svg import SVG, read_svg
from multisrt.environments.formats.wkt import WKT, read_wkt
from multisrt.geometry.errors import MapFormatError

__all__ = [
    "FORMATS",
    "Beginning",
    "MapFormat",
    "Reader",
    "format_of",
    "read_dxf",
    "read_environment",
    "read_geojson",
    "read_house_expo",
    "read_image",
    "read_imr",
    "read_map_server",
    "read_moving_ai",
    "read_moving_ai_scenario",
    "read_numpy_array",
    "read_stage",
    "read_svg",
    "read_wkt",
]

FORMATS: Final[tuple[MapFormat, ...]] = (
    MAP_SERVER,
    IMAGE,
    GEOJSON,
    WKT,
    STAGE,
    MOVING_AI,
    MOVING_AI_SCENARIO,
    IMR,
    HOUSE_EXPO,
    NUMPY_ARRAY,
    SVG,
    DXF,
)
"""The formats that can be read."""

_OTHERS: Final = {
    rb"RIFF....WEBP": "a WebP image; save it as PNG",
    rb"PK\x03\x04": "a zip archive, as .npz files are; unzip it, and name the map in it",
    rb"\x1f\x8b": "compressed by gzip, as .svgz files are; unpack it, and name the map in it",
}
"""How files of formats that cannot be read begin, and what to do with them."""


def format_of(path: Path) -> MapFormat:
    """Return the format of a map file, by its content or else by its suffix.

    Parameters
    ----------
    path : Path
        The file.

    Raises
    ------
    MapFormatError
        If the file does not exist or cannot be read, or has neither the content nor the suffix of
        a known format.

    Examples
    --------
    >>> from multisrt.environments.catalog import MAPS
    >>> format_of(MAPS / "library.wkt").name
    'well-known text'
    """
    beginning = beginning_of(path)
    for known in FORMATS:
        if known.recognises(beginning):
            return known
    if is_team(beginning):
        raise refuse_team_alone(path)
    # The reader of that format reports what is wrong with the file.
    for known in FORMATS:
        if path.suffix.lower() in known.suffixes:
            return known
    for begins, what in _OTHERS.items():
        if re.match(begins, beginning.raw, re.DOTALL):
            raise MapFormatError(f"{path} is {what}")
    readable = ", ".join(f"{known.name} ({' '.join(known.suffixes)})" for known in FORMATS)
    raise MapFormatError(
        f"{path} is not a map: no format is known by its content or by its suffix {path.suffix!r}; "
        f"readable formats: {readable}"
    )


def read_environment(
    path: str | Path,
    *,
    resolution_m: float | None = None,
    threshold: float | None = None,
    starts_from: str | Path | None = None,
    name: str | None = None,
    repair: bool = False,
) -> Environment:
    """Return the world of a map file; the content of the file determines its format.

    Parameters
    ----------
    path : str or Path
        A file of one of the `FORMATS`: ROS map server, image, GeoJSON, well-known text, Stage
        world, MovingAI grid or scenario, IMR polygons, HouseExpo, numpy array, SVG or DXF.
    resolution_m : float, optional
        Metres per pixel, cell, or unit of a drawing. Required for images, numpy arrays, MovingAI
        grids and scenarios, and for drawings without a scale; it overrides the scale that a
        drawing states. Other formats have a scale of their own and do not accept it.
    threshold : float, optional
        Lightness in [0, 1] above which a pixel or paint is free; only for images, numpy arrays of
        grey values, and SVG drawings without names.
    starts_from : str or Path, optional
        An MRESim team file, whose robots' pixels become the suggested starts; only for images.
    name : str, optional
        Name of the world; by default that of the file without its suffix, or the ``id`` of a
        HouseExpo plan.
    repair : bool, optional
        Whether rings that are open or cross are repaired, and suggested starts that are not in free
        space left out, instead of refused, in formats of polygons. `Environment.cleaning` records
        the changes.

    Returns
    -------
    Environment
        The world, in metres.

    Raises
    ------
    MapFormatError
        If the format is not known, the file cannot be read, or an option does not apply to it;
        the message names the file, the place in it and the remedy.
    MissingExtraError
        If the file is a DXF drawing and ezdxf is not installed (``multisrt[dxf]``).

    Examples
    --------
    >>> from multisrt.environments.catalog import MAPS
    >>> read_environment(MAPS / "library.wkt", name="reading room").name
    'reading room'
    """
    path = Path(path)
    known = format_of(path)
    if starts_from is not None and known is not IMAGE:
        raise MapFormatError(
            f"{path} is not a plain image, and a team file names pixels of one; "
            "leave out --starts-from (starts_from)"
        )
    read = known.repair if repair and known.repair is not None else known.read
    world = read(path, resolution_m=resolution_m, threshold=threshold, name=name)
    if starts_from is None:
        return world
    return with_team(world, path, require_resolution(path, resolution_m), Path(starts_from))
