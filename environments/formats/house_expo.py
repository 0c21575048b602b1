"""Floor plans of the HouseExpo data set: the outline of a flat or house, in metres."""

import re
from pathlib import Path
from typing import Final

import shapely
from shapely import Polygon
from shapely.geometry.base import BaseGeometry

from multisrt.environments.cleaning import without_denormals
from multisrt.environments.environment import MAX_COORDINATE_M, Environment
from multisrt.environments.formats.files import (
    build_environment,
    read_json,
    refuse_resolution,
    refuse_threshold,
)
from multisrt.environments.formats.map_format import Beginning, MapFormat
from multisrt.environments.formats.regions import require_few_overlaps
from multisrt.geometry.errors import MapFormatError, shown

MAX_NAME_LENGTH: Final = 80
"""Upper bound of the length of an ``id`` that is used as name, in characters."""


def read_house_expo(
    path: Path,
    *,
    resolution_m: float | None = None,
    threshold: float | None = None,
    name: str | None = None,
) -> Environment:
    """Read a HouseExpo floor plan: free space is the inside of its outline.

    Doors are openings in these plans, so that rooms are connected and one outline holds all of
    them. The outline may touch itself where two rooms are separated by a wall without thickness;
    its inside is determined by the even-odd rule, as in the simulator of the data set.

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

    Raises
    ------
    MapFormatError
        If the file is not JSON, has no ``verts``, a vertex is not a pair of finite numbers, or
        the outline has no area.

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
        raise MapFormatError(
            f"{path} has no verts; a floor plan of HouseExpo has a list of at least three [x, y]"
        )
    outline: BaseGeometry = without_denormals(
        Polygon([_vertex(path, number, at) for number, at in enumerate(vertices, start=1)])
    )
    if not outline.is_valid:
        require_few_overlaps(path, [outline])
        outline = shapely.make_valid(outline, method="linework")
    house = plan.get("id")
    is_name = isinstance(house, str) and 0 < len(house) <= MAX_NAME_LENGTH
    if name is None and is_name and str(house).isprintable():
        name = str(house)
    return build_environment(path, outline, name=name, origin=path.name)


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
)
