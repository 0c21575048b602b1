"""Floor plans of the HouseExpo data set: the outline of a flat or house, in metres."""

import re
from functools import partial
from pathlib import Path
from typing import Final

import numpy as np
from shapely import Polygon
from shapely.geometry.base import BaseGeometry

from multisrt.environments.cleaning import FIXING, Cleaning, repaired, without_denormals
from multisrt.environments.environment import MAX_COORDINATE_M, Environment
from multisrt.environments.formats.files import (
    build_environment,
    read_json,
    refuse_resolution,
    refuse_threshold,
)
from multisrt.environments.formats.map_format import Beginning, MapFormat
from multisrt.environments.formats.regions import crossing_of, filled, require_few_overlaps
from multisrt.geometry.errors import MapFormatError, counted, shown

MAX_NAME_LENGTH: Final = 80
"""Upper bound of the length of an ``id`` that is used as name, in characters."""


def read_house_expo(
    path: Path,
    *,
    resolution_m: float | None = None,
    threshold: float | None = None,
    name: str | None = None,
    repair: bool = False,
) -> Environment:
    """Read a HouseExpo floor plan: free space is the inside of its outline.

    Doors are openings in these plans, so that rooms are connected and one outline holds all of
    them. The outline may touch itself where two rooms are separated by a wall without thickness,
    but not cross itself.

    Parameters
    ----------
    path : Path
        JSON with ``verts``, a list of [x, y] in metres, not closed. ``bbox`` and
        ``room_category`` are not used.
    resolution_m, threshold
        Rejected: the file is in metres and not an image.
    name : str, optional
        By default the ``id`` of the plan if it has a printable one of at most 80 characters, else
        the file's name without suffix.
    repair : bool, optional
        Whether an outline that crosses itself is repaired instead of refused.

    Raises
    ------
    MapFormatError
        If the file is not JSON, has no ``verts``, a vertex is not a pair of finite numbers, or
        the outline crosses itself or has no area.

    Notes
    -----
    Source: T. Li et al., HouseExpo: A Large-scale 2D Indoor Layout Dataset for Learning-based
    Algorithms on Mobile Robots, IROS 2020, and its README.

    Examples
    --------
    >>> with open("plan.json", "w") as file:
    ...     _ = file.write('{"verts": [[0, 0], [5.2, 0], [5.2, 3.5], [0, 3.5]], "id": "flat"}')
    >>> flat = read_house_expo(Path("plan.json"))
    >>> flat.name, round(flat.area_m2, 6)
    ('flat', 18.2)
    """
    refuse_resolution(path, resolution_m)
    refuse_threshold(path, threshold)
    plan = read_json(path, "a floor plan of HouseExpo")
    vertices = plan.get("verts") if isinstance(plan, dict) else None
    if not isinstance(plan, dict) or not isinstance(vertices, list) or len(vertices) < 3:
        has = (
            f"{counted(len(vertices), 'vertex', 'vertices')} in"
            if isinstance(vertices, list)
            else "no"
        )
        raise MapFormatError(
            f"{path} has {has} verts; a floor plan of HouseExpo has a list of at least three [x, y]"
        )
    drawn = without_denormals(
        Polygon([_vertex(path, number, at) for number, at in enumerate(vertices, start=1)])
    )
    outline, cleaning = _inside(path, drawn, repair=repair)
    house = plan.get("id")
    is_name = isinstance(house, str) and 0 < len(house) <= MAX_NAME_LENGTH
    if name is None and is_name and str(house).isprintable():
        name = str(house)
    return build_environment(path, outline, name=name, origin=path.name, cleaning=cleaning)


def _inside(path: Path, drawn: Polygon, *, repair: bool) -> tuple[BaseGeometry, Cleaning]:
    if drawn.is_valid:
        return drawn, Cleaning()
    require_few_overlaps(path, [drawn])
    ring = np.asarray(drawn.exterior.coords)[:-1]
    crossing = crossing_of(path, ring)
    if crossing is None:
        return filled(path, [ring], "evenodd"), Cleaning()
    if repair:
        return repaired(drawn)
    x, y = crossing
    raise MapFormatError(
        f"{path}: the outline crosses itself at ({x:g}, {y:g}); draw an outline that does not "
        f"cross itself, or {FIXING}"
    )


def _vertex(path: Path, number: int, vertex: object) -> tuple[float, float]:
    if isinstance(vertex, list) and len(vertex) == 2:
        x, y = vertex
        if _is_coordinate(x) and _is_coordinate(y):
            return float(x), float(y)
    raise MapFormatError(
        f"{path}, vertex {number} is {shown(vertex)}; it must be [x, y], finite numbers of metres, "
        f"at most {MAX_COORDINATE_M:g}"
    )


def _is_coordinate(value: object) -> bool:
    if isinstance(value, bool) or not isinstance(value, int | float):
        return False
    return abs(value) <= MAX_COORDINATE_M


def _is_house_expo(beginning: Beginning) -> bool:
    text = beginning.text.lstrip()
    return text.startswith("{") and re.search(r'"verts"\s*:', text) is not None


HOUSE_EXPO = MapFormat(
    name="HouseExpo",
    suffixes=(".json",),
    recognises=_is_house_expo,
    read=read_house_expo,
    repair=partial(read_house_expo, repair=True),
)
