"""Well-known text as maps: one or several polygons in metres."""

import re
from functools import partial
from pathlib import Path

import numpy as np
import shapely
from shapely import Polygon
from shapely.geometry.base import BaseGeometry

from multisrt.environments.cleaning import FIXING, Cleaning, repaired, united, without_denormals
from multisrt.environments.environment import MAX_COORDINATE_M, Environment
from multisrt.environments.formats.files import (
    MAX_POLYGON_BYTES,
    build_environment,
    read_text,
    refuse_resolution,
    refuse_threshold,
)
from multisrt.environments.formats.map_format import Beginning, MapFormat
from multisrt.environments.formats.regions import require_few_overlaps
from multisrt.geometry.errors import MapFormatError, reason_of

MAX_DEPTH = 16
"""Upper bound of nested parentheses, since the parser recurses without bound."""


SRID = re.compile(r"\s*SRID\s*=\s*(\d{1,9})\s*;\s*", re.IGNORECASE | re.ASCII)
"""The number of a reference system before a geometry, in extended well-known text."""

DEGREES = frozenset({4258, 4267, 4269, 4326, 4979})
"""Numbers (EPSG) of common reference systems of longitude and latitude."""

FORM = "it must be POLYGON ((x y, x y, ...), ...), MULTIPOLYGON or GEOMETRYCOLLECTION"
"""Form of the text, for messages."""

OPEN_RING = "closed linestring"
"""What the parser's reason contains if a ring is open."""

REMEDIES = {
    OPEN_RING: f"repeat the first position of every ring at its end, or {FIXING}",
    "after end of geometry": "join several polygons as MULTIPOLYGON (((x y, ...)), ((x y, ...))) "
    "or GEOMETRYCOLLECTION",
}
"""Remedies by what the parser's reason contains; for other reasons it is the `FORM`."""


def read_wkt(
    path: Path,
    *,
    resolution_m: float | None = None,
    threshold: float | None = None,
    name: str | None = None,
    repair: bool = False,
) -> Environment:
    """Read free space from a POLYGON, MULTIPOLYGON or GEOMETRYCOLLECTION of them, in metres.

    The number of a reference system, ``SRID=...;`` as PostGIS writes it, is skipped.

    Parameters
    ----------
    path : Path
        One geometry, over any number of lines; at most 24 MiB. Third coordinates are ignored.
        Polygons are united; holes are obstacles.
    resolution_m, threshold
        Rejected: the file is in metres and not an image.
    name : str, optional
        By default the file's name without suffix.
    repair : bool, optional
        Whether rings that are open or cross are repaired instead of refused.

    Raises
    ------
    MapFormatError
        If the text is not such a geometry or its end is missing, a ring is open or crosses itself,
        a coordinate is not finite, or the reference system is longitude and latitude.
    """
    refuse_resolution(path, resolution_m)
    refuse_threshold(path, threshold)
    geometry, cleaning = _parsed(path, repair=repair)
    drawn = _polygons(path, geometry)
    for number, polygon in enumerate(drawn, start=1):
        _require_valid(path, number, polygon, repair=repair)
    require_few_overlaps(path, drawn)
    polygons: list[BaseGeometry] = []
    for polygon in drawn:
        valid, changed = repaired(polygon)
        cleaning += changed
        polygons.append(valid)
    free, overlaps = united(polygons)
    return build_environment(path, free, name=name, origin=path.name, cleaning=cleaning + overlaps)


def geometry_of(text: str, where: object, *, repair: bool = False) -> BaseGeometry:
    """Return the geometry of well-known text, whose coordinates may be anything.

    Parameters
    ----------
    text : str
        The text.
    where : object
        Where it stands, for messages.
    repair : bool, optional
        Whether rings that are open are closed instead of refused.

    Raises
    ------
    MapFormatError
        If it is no geometry.
    """
    signs = np.frombuffer(text.encode(errors="replace"), np.uint8)
    depth = np.cumsum((signs == ord("(")).astype(np.int8) - (signs == ord(")")), dtype=np.int32)
    if depth.max(initial=0) > MAX_DEPTH:
        raise MapFormatError(
            f"{where}: parentheses are nested more than {MAX_DEPTH} deep; flatten the collection"
        )
    try:
        with np.errstate(invalid="ignore", over="ignore"):
            return shapely.from_wkt(text, on_invalid="fix" if repair else "raise")
    except (shapely.errors.ShapelyError, ValueError) as error:
        left = int(depth[-1]) if depth.size else 0
        if left > 0 and any(reason in str(error) for reason in ("end of stream", OPEN_RING)):
            raise MapFormatError(
                f"{where} is cut off: it ends within {left} open "
                f"parenthes{'i' if left == 1 else 'e'}s; copy or save the map again"
            ) from error
        raise MapFormatError(f"{where} is not well-known text: {_reason(error)}") from error


def _parsed(path: Path, *, repair: bool) -> tuple[BaseGeometry, Cleaning]:
    text = _without_srid(path, read_text(path, max_bytes=MAX_POLYGON_BYTES))
    geometry = geometry_of(text, path, repair=repair)
    # Coordinates that are not finite are refused later, with their position.
    with np.errstate(invalid="ignore", over="ignore"):
        flat = without_denormals(shapely.force_2d(geometry))
    return flat, Cleaning(closed_rings=_open_rings(text) if repair else 0)


def _without_srid(path: Path, text: str) -> str:
    """Return a text without the number of its reference system; longitude and latitude fail."""
    found = SRID.match(text)
    if found is None:
        return text
    if int(found[1]) in DEGREES:
        raise MapFormatError(
            f"{path}: SRID={found[1]} is longitude and latitude; coordinates are metres; project "
            "them first"
        )
    return text[found.end() :]


def _reason(error: Exception) -> str:
    """Return what the parser found, and what to do about it."""
    # Looked for before the reason is shortened: it may cite the whole text.
    remedies = [remedy for mistake, remedy in REMEDIES.items() if mistake in str(error)]
    reason = re.sub(r"^(Parse|IllegalArgument)Exception: ", "", reason_of(error))
    return f"{reason}; {(remedies or [FORM])[0]}"


def _open_rings(text: str) -> int:
    rings = (ring.split(",") for ring in re.findall(r"\(([^()]+)\)", text))
    return sum(ring[0].split() != ring[-1].split() for ring in rings)


def _polygons(path: Path, geometry: BaseGeometry) -> list[Polygon]:
    parts = shapely.get_parts(geometry)
    while any(part.geom_type in ("GeometryCollection", "MultiPolygon") for part in parts):
        parts = shapely.get_parts(parts)
    for number, part in enumerate(parts, start=1):
        if not isinstance(part, Polygon):
            raise MapFormatError(
                f"{path}, part {number} is a {part.geom_type}; free space is made of polygons"
            )
    polygons = [part for part in parts if not part.is_empty]
    if not polygons:
        raise MapFormatError(f"{path} has no polygon that is not empty; there is no free space")
    return polygons


def _require_valid(path: Path, number: int, polygon: Polygon, *, repair: bool) -> None:
    for ring, line in enumerate((polygon.exterior, *polygon.interiors), start=1):
        points = shapely.get_coordinates(line)
        bad = np.flatnonzero(~(np.abs(points) <= MAX_COORDINATE_M).all(axis=1))
        if bad.size:
            x, y = points[bad[0]]
            raise MapFormatError(
                f"{path}, polygon {number}, ring {ring}, position {bad[0] + 1} is ({x:g}, {y:g}); "
                f"coordinates are finite numbers of metres, at most {MAX_COORDINATE_M:g}"
            )
    if not (polygon.is_valid or repair):
        raise MapFormatError(
            f"{path}, polygon {number} is not valid: {shapely.is_valid_reason(polygon)}; "
            f"draw rings that do not cross, or {FIXING}"
        )


def _is_wkt(beginning: Beginning) -> bool:
    pattern = rf"({SRID.pattern})?\s*(POLYGON|MULTIPOLYGON|GEOMETRYCOLLECTION)\s*[Z(]"
    return re.match(pattern, beginning.text, re.IGNORECASE) is not None


WKT = MapFormat(
    name="well-known text",
    suffixes=(".wkt",),
    recognises=_is_wkt,
    read=read_wkt,
    repair=partial(read_wkt, repair=True),
)
