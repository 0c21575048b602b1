"""Maps of the ROS map server: a YAML file that describes an image."""

import math
import re
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import shapely

from multisrt.environments.cleaning import Cleaning
from multisrt.environments.environment import Environment
from multisrt.environments.formats.files import (
    build_environment,
    grid_polygons,
    named_file,
    no_such_file,
    read_text,
    refuse_resolution,
    refuse_threshold,
    require_resolution,
    straightened,
)
from multisrt.environments.formats.image import Pixels, read_pixels
from multisrt.environments.formats.map_format import Beginning, MapFormat
from multisrt.geometry.errors import MAX_REASON, MapFormatError, reason_of, shortened, shown
from multisrt.geometry.numerics import libm
from multisrt.geometry.numerics.kernel import BoolArray, FloatArray

if TYPE_CHECKING:
    import yaml

MAX_YAML_BYTES = 2**16
"""Upper bound of the size of YAML files, in bytes (64 KiB)."""

REQUIRED_KEYS = ("image", "resolution", "origin", "negate", "occupied_thresh", "free_thresh")


def read_map_server(
    path: Path,
    *,
    resolution_m: float | None = None,
    threshold: float | None = None,
    name: str | None = None,
) -> Environment:
    """Read a map as the ROS map server does.

    A pixel with shade x of 255, the mean of its colour channels, has the occupancy
    ``p = (255 - x) / 255``, or ``x / 255`` if ``negate`` is set. It is occupied if
    ``p > occupied_thresh``, else free if ``p < free_thresh``. Anything else is unknown in the
    mode ``trinary`` and partly occupied or, where transparent, unknown in the mode ``scale``;
    neither is free space here. As in the server, ``trinary`` includes alpha as a channel of the
    mean; ``scale`` ignores it and treats every transparent pixel as unknown. Pixels of 16 bits are
    scaled to 255. An ``occupied_thresh`` below ``free_thresh``, which is probably a mistake, is
    taken as it is, as in the server, and noted in `Environment.cleaning`.

    Parameters
    ----------
    path : Path
        The YAML file. Its ``image`` is in its folder or below; ``origin`` is the
        pose x, y (m), yaw (rad) of the image's lower left corner; a yaw rotates the world.
    resolution_m, threshold
        Rejected: the file states its own.
    name : str, optional
        By default the file's name without suffix.

    Raises
    ------
    MapFormatError
        If the file is not YAML or has an alias, a key is missing, wrong or repeated, the
        image is missing or damaged, the mode is ``raw``, or no pixel is free.

    Notes
    -----
    Source: documentation of map_server (ROS 1) and nav2_map_server (ROS 2); differs in: the
    mode ``raw``, whose pixels are costs and not occupancies, is refused.
    """
    refuse_resolution(path, resolution_m)
    refuse_threshold(path, threshold)
    entries = _entries(path)
    resolution = require_resolution(path, _number(path, entries, "resolution"))
    x, y, yaw = _origin(path, entries)
    occupied_thresh = _share(path, entries, "occupied_thresh")
    free_thresh = _share(path, entries, "free_thresh")
    negate = _flag(path, entries, "negate")
    mode = _mode(path, entries)
    pixels = read_pixels(_image_path(path, entries))
    free = _free_cells(
        pixels,
        negate=negate,
        occupied_thresh=occupied_thresh,
        free_thresh=free_thresh,
        mode=mode,
    )
    if not free.any():
        raise MapFormatError(
            f"{path}: no pixel's occupancy is below free_thresh {free_thresh:g}, "
            "so there is no free space; check free_thresh and negate"
        )
    cos, sin = math.cos(yaw), math.sin(yaw)
    turn = np.array([[cos, sin], [-sin, cos]])

    def placed(points: FloatArray) -> FloatArray:
        moved: FloatArray = (libm.product(points, turn) if yaw else points) + (x, y)
        return moved

    polygons = grid_polygons(path, free, resolution)
    return build_environment(
        path,
        shapely.transform(polygons, placed),
        name=name,
        origin=f"{path.name} with {entries['image']}, {resolution:g} m per pixel",
        cleaning=_order_of_thresholds(occupied_thresh, free_thresh)
        + straightened(polygons, resolution),
    )


def _order_of_thresholds(occupied_thresh: float, free_thresh: float) -> Cleaning:
    if occupied_thresh >= free_thresh:
        return Cleaning()
    return Cleaning(
        notes=(
            f"occupied_thresh {occupied_thresh:g} is below free_thresh {free_thresh:g}: were they "
            f"swapped? Read as ROS does, occupied above {occupied_thresh:g} and free below",
        )
    )


def _free_cells(
    pixels: Pixels, *, negate: bool, occupied_thresh: float, free_thresh: float, mode: str
) -> BoolArray:
    """Return the mask of free pixels."""
    levels, full = pixels.weighted((1, 1, 1))
    if mode == "trinary" and pixels.alpha is not None:
        # The server decodes grey with alpha to four channels.
        if pixels.channels.ndim == 2:
            levels, full = 3 * levels, 3 * full
        # Alpha has 8 bits, as have the channels beside it, except with a transparent 16-bit grey.
        levels = levels + np.uint32(pixels.full // 255) * pixels.alpha
        full += pixels.full
    # Occupancy by level, as the server computes it: exact where a threshold meets a level.
    level = np.arange(full + 1)
    occupancy = (level if negate else full - level) / full
    is_free = (occupancy < free_thresh) & ~(occupancy > occupied_thresh)
    free = is_free[levels]
    if mode == "scale" and pixels.opaque is not None:
        free &= pixels.opaque
    return free


def _entries(path: Path) -> dict[object, object]:
    import yaml

    try:
        text = read_text(path, max_bytes=MAX_YAML_BYTES)
        # Aliases that are merged repeatedly would grow without bound.
        if "*" in text and any(isinstance(event, yaml.AliasEvent) for event in yaml.parse(text)):
            raise MapFormatError(f"{path} has an alias (*name); write out the value in its place")
        _refuse_repeated_keys(path, yaml.compose(text, Loader=yaml.SafeLoader))
        loaded = yaml.safe_load(text)
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark
        place = f", line {mark.line + 1}, column {mark.column + 1}" if mark else ""
        problem = shortened(str(error.problem), MAX_REASON)
        raise MapFormatError(f"{path} is not YAML{place}: {problem}") from error
    except MapFormatError:
        raise
    except Exception as error:  # values with wrong tags make the library raise almost anything
        raise MapFormatError(f"{path} is not YAML: {reason_of(error)}") from error
    if not isinstance(loaded, dict):
        raise MapFormatError(
            f"{path} is not a map: it has no keys; a map_server YAML has {', '.join(REQUIRED_KEYS)}"
        )
    missing = [key for key in REQUIRED_KEYS if loaded.get(key) is None]
    if missing:
        raise MapFormatError(
            f"{path} lacks {', '.join(missing)}; "
            f"a map_server YAML has {', '.join(REQUIRED_KEYS)} and optionally mode"
        )
    return loaded


def _refuse_repeated_keys(path: Path, root: "yaml.Node | None") -> None:
    import yaml

    lines: dict[str, int] = {}
    for key, _ in root.value if isinstance(root, yaml.MappingNode) else ():
        if not isinstance(key, yaml.ScalarNode):
            continue
        line = key.start_mark.line + 1
        if key.value in lines:
            raise MapFormatError(
                f"{path}, line {line} states {shown(key.value)} again, after line "
                f"{lines[key.value]}; remove one of them"
            )
        lines[key.value] = line


def _image_path(path: Path, entries: dict[object, object]) -> Path:
    image = entries["image"]
    if not isinstance(image, str):
        raise MapFormatError(f"{path}: image is {shown(image)}; it must be the name of a file")
    found = named_file(path.parent, image, f"{path}: image")
    if found is None:
        raise no_such_file(path.parent, image, f"{path} names the image")
    return found


def _origin(path: Path, entries: dict[object, object]) -> tuple[float, float, float]:
    origin = entries["origin"]
    if not isinstance(origin, list) or len(origin) != 3:
        raise MapFormatError(f"{path}: origin is {shown(origin)}; it must be a list [x, y, yaw]")
    x, y, yaw = (
        _finite(path, f"origin, number {number}", value)
        for number, value in enumerate(origin, start=1)
    )
    return x, y, yaw


def _share(path: Path, entries: dict[object, object], key: str) -> float:
    value = _number(path, entries, key)
    if not 0 <= value <= 1:
        raise MapFormatError(f"{path}: {key} is {value:g}; it must be an occupancy in [0, 1]")
    return value


def _flag(path: Path, entries: dict[object, object], key: str) -> bool:
    value = entries[key]
    if value not in (0, 1, "0", "1"):
        raise MapFormatError(f"{path}: {key} is {shown(value)}; it must be 0 or 1")
    return value in (1, "1")


def _mode(path: Path, entries: dict[object, object]) -> str:
    mode = entries.get("mode", "trinary")
    word = mode.lower() if isinstance(mode, str) else ""
    if word == "raw":
        raise MapFormatError(
            f"{path}: mode is raw, which stores costs instead of occupancies; "
            "save the map in the mode trinary or scale"
        )
    if word not in ("trinary", "scale"):
        raise MapFormatError(f"{path}: mode is {shown(mode)}; it must be trinary or scale")
    return word


def _number(path: Path, entries: dict[object, object], key: str) -> float:
    return _finite(path, key, entries[key])


def _finite(path: Path, place: str, value: object) -> float:
    number = math.nan
    # YAML 1.1 reads 5e-2 as text.
    if isinstance(value, int | float | str) and not isinstance(value, bool):
        try:
            number = float(value)
        except (ValueError, OverflowError):
            number = math.nan
    if not math.isfinite(number):
        raise MapFormatError(f"{path}: {place} is {shown(value)}; it must be a finite number")
    return number


def _is_map_server(beginning: Beginning) -> bool:
    return re.search(r"^\s*image\s*:", beginning.text, re.MULTILINE) is not None


MAP_SERVER = MapFormat(
    name="ROS map server",
    suffixes=(".yaml", ".yml"),
    recognises=_is_map_server,
    read=read_map_server,
)
