"""GeoJSON as maps: polygons in metres, distinguished by a property ``kind``."""

import json
import math
import re
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path

import shapely
from shapely import Polygon
from shapely.geometry.base import BaseGeometry

from multisrt.environments.cleaning import (
    FIXING,
    Cleaning,
    closed_ring,
    repaired,
    united,
    without_denormals,
)
from multisrt.environments.environment import MAX_COORDINATE_M, Environment
from multisrt.environments.formats.files import (
    FileStarts,
    build_environment,
    read_json,
    refuse_resolution,
    refuse_threshold,
)
from multisrt.environments.formats.map_format import Beginning, MapFormat
from multisrt.environments.formats.regions import require_few_overlaps
from multisrt.geometry.errors import MapFormatError, counted, shown
from multisrt.geometry.regions.overlay import difference_of

KINDS = {
    "outline": "free",
    "free": "free",
    "boundary": "free",
    "obstacle": "obstacle",
    "start": "start",
}
"""Kinds of features, by the value of the property ``kind`` (or ``type``)."""

MAX_DEPTH = 16
"""Upper bound of the collections that are nested; the place of each is in messages."""

MAX_DEGREES = 1.0
"""Extent below which coordinates may be degrees rather than metres."""

MIN_EXTENT_M = 0.1
"""Minimum extent of a world in metres; a smaller one has coordinates in degrees."""


def read_geojson(
    path: Path,
    *,
    resolution_m: float | None = None,
    threshold: float | None = None,
    name: str | None = None,
    repair: bool = False,
) -> Environment:
    """Read a GeoJSON file whose coordinates are metres.

    Geometry, Feature and FeatureCollection are read. The property ``kind``, or else ``type``, of a
    feature, in upper or lower case, states what it is:

    - ``outline``, ``free`` or ``boundary``, or neither property: a Polygon or MultiPolygon of free
      space with obstacles as holes. Free space is the union of all of them.
    - ``obstacle``: a Polygon or MultiPolygon that is subtracted from free space.
    - ``start``: a Point or MultiPoint of suggested starts, in the order of the file.

    A feature whose geometry is null is left out, and counted in `Environment.cleaning`.

    Parameters
    ----------
    path : Path
        At most 24 MiB. Third coordinates are ignored.
    resolution_m, threshold
        Rejected: the file is in metres and not an image.
    name : str, optional
        By default the file's name without suffix.
    repair : bool, optional
        Whether rings that are open or cross are repaired, and starts that are not in free space
        left out, instead of refused.

    Raises
    ------
    MapFormatError
        If the file is not GeoJSON, or has another geometry or kind, a ring that is open, too
        short or crosses itself, a coordinate that is not finite, coordinates in degrees, or no
        free space, or a start is not in free space. The message gives feature, ring and position,
        counted from 1.
    """
    refuse_resolution(path, resolution_m)
    refuse_threshold(path, threshold)
    root = _Place(str(path))
    document = read_json(path, "GeoJSON")
    if isinstance(document, dict) and "type" not in document:
        raise root.error(
            'this JSON is neither GeoJSON, which has a "type", nor a floor plan of HouseExpo, '
            'which has "verts"',
            "choose another file, or convert it to one of these",
        )
    _refuse_degrees(root, document)
    world = _World(repair=repair)
    _add(world, root, document, "free", 0)
    require_few_overlaps(path, [polygon for _, polygon, _ in world.polygons])
    for place, polygon, kind in world.polygons:
        _unite(world, place, polygon, kind)
    if not world.free:
        raise root.error("there is no free space", "add a Polygon of kind outline")
    free, overlaps = united(world.free)
    x0, y0, x1, y1 = free.bounds
    if max(x1 - x0, y1 - y0) < MIN_EXTENT_M:
        raise root.error(
            f"free space is {x1 - x0:.2g} x {y1 - y0:.2g} m",
            "coordinates are metres, not degrees; project them first",
        )
    return build_environment(
        path,
        difference_of(free, world.obstacles),
        name=name,
        origin=path.name,
        starts=FileStarts(
            [start for _, start in world.starts],
            places=[place.text for place, _ in world.starts],
            repair=repair,
        ),
        cleaning=_unlocated(world.unlocated) + world.cleaning + overlaps,
    )


@dataclass(frozen=True, slots=True)
class _Place:
    """A place in the file, for messages."""

    text: str

    def at(self, part: str, number: int) -> "_Place":
        return _Place(f"{self.text}, {part} {number}")

    def error(self, what: str, remedy: str) -> MapFormatError:
        return MapFormatError(f"{self.text}: {what}; {remedy}")


@dataclass(slots=True)
class _World:
    repair: bool
    polygons: list[tuple["_Place", Polygon, str]] = field(default_factory=list)
    free: list[BaseGeometry] = field(default_factory=list)
    obstacles: list[BaseGeometry] = field(default_factory=list)
    starts: list[tuple["_Place", tuple[float, float]]] = field(default_factory=list)
    cleaning: Cleaning = field(default_factory=Cleaning)
    unlocated: int = 0


def _refuse_degrees(place: _Place, document: object) -> None:
    """Reject a reference system of longitude and latitude."""
    crs = document.get("crs") if isinstance(document, dict) else None
    named = json.dumps(crs) if isinstance(crs, dict) else ""
    if "CRS84" in named or "EPSG::4326" in named or "EPSG:4326" in named:
        raise place.error(
            "the coordinate reference system is longitude and latitude",
            "coordinates are metres; project them first",
        )


def _add(world: _World, place: _Place, item: object, kind: str, depth: int) -> None:
    """Add a FeatureCollection, Feature or geometry in `depth` others to the world."""
    if depth > MAX_DEPTH:
        raise place.error(f"collections are nested more than {MAX_DEPTH} deep", "flatten them")
    if not isinstance(item, dict):
        raise place.error(f"expected a GeoJSON object, found {shown(item)}", "see RFC 7946")
    match item.get("type"):
        case "FeatureCollection":
            for number, feature in enumerate(_list(place, item, "features"), start=1):
                there = place.at("feature", number)
                if not isinstance(feature, dict) or feature.get("type") != "Feature":
                    raise there.error("this is not a Feature", "a collection holds only Features")
                _add(world, there, feature, kind, depth + 1)
        case "Feature" if "geometry" in item and item["geometry"] is None:
            world.unlocated += 1  # RFC 7946, section 3.2
        case "Feature":
            own = _kind(place, item.get("properties"))
            _add(world, place, item.get("geometry"), own, depth + 1)
        case "GeometryCollection":
            for number, geometry in enumerate(_list(place, item, "geometries"), start=1):
                _add(world, place.at("geometry", number), geometry, kind, depth + 1)
        case _:
            _add_geometry(world, place, item, kind)


def _add_geometry(world: _World, place: _Place, item: dict[str, object], kind: str) -> None:
    """Add a single geometry to the world."""
    match item.get("type"):
        case "Polygon" if kind != "start":
            _add_polygon(world, place, _list(place, item, "coordinates"), kind)
        case "MultiPolygon" if kind != "start":
            for number, rings in enumerate(_list(place, item, "coordinates"), start=1):
                _add_polygon(world, place.at("polygon", number), rings, kind)
        case "Point" if kind == "start":
            world.starts.append((place, _position(place, item.get("coordinates"))))
        case "MultiPoint" if kind == "start":
            for number, position in enumerate(_list(place, item, "coordinates"), start=1):
                there = place.at("position", number)
                world.starts.append((there, _position(there, position)))
        case other:
            raise place.error(
                f"a geometry of type {shown(other)} cannot be {kind}",
                "free space and obstacles are Polygon or MultiPolygon, starts are Point or "
                'MultiPoint with "kind": "start"',
            )


def _unlocated(number: int) -> Cleaning:
    said = f"{counted(number, 'feature')} without a place left out"
    return Cleaning(notes=(said,) if number else ())


def _kind(place: _Place, properties: object) -> str:
    if properties is None:
        return "free"
    if not isinstance(properties, dict):
        raise place.error(f"properties are {shown(properties)}", "they must be an object or null")
    word = properties.get("kind", properties.get("type"))
    if word is None:
        return "free"
    if not isinstance(word, str) or word.lower() not in KINDS:
        raise place.error(f"the kind is {shown(word)}", f"it must be one of {', '.join(KINDS)}")
    return KINDS[word.lower()]


def _add_polygon(world: _World, place: _Place, rings: object, kind: str) -> None:
    if not isinstance(rings, list) or not rings:
        raise place.error("this polygon has no rings", "give an outer ring and its holes")
    shell, *holes = [
        _ring(world, place.at("ring", number), ring) for number, ring in enumerate(rings, start=1)
    ]
    world.polygons.append((place, without_denormals(Polygon(shell, holes)), kind))


def _unite(world: _World, place: _Place, drawn: Polygon, kind: str) -> None:
    """Add a polygon to free space or to the obstacles, repaired if need be."""
    polygon: BaseGeometry = drawn
    if not drawn.is_valid:
        if not world.repair:
            raise place.error(
                f"the polygon is not valid: {shapely.is_valid_reason(drawn)}",
                f"draw rings that do not cross, or {FIXING}",
            )
        polygon, changed = repaired(drawn)
        world.cleaning += changed
    if not polygon.is_empty:
        (world.free if kind == "free" else world.obstacles).append(polygon)


def _ring(world: _World, place: _Place, ring: object) -> list[tuple[float, float]]:
    if not isinstance(ring, list):
        raise place.error(f"the ring is {shown(ring)}", "it must be a list of positions")
    positions = [
        _position(place.at("position", number), position)
        for number, position in enumerate(ring, start=1)
    ]
    if world.repair and len(positions) > 2:
        positions, changed = closed_ring(positions)
        world.cleaning += changed
    if len(positions) < 4:
        raise place.error(
            f"the ring has {len(positions)} positions",
            f"it needs at least four, the last equal to the first; {FIXING}",
        )
    if positions[0] != positions[-1]:
        raise place.error(
            f"the ring is open: it starts at {positions[0]} and ends at {positions[-1]}",
            f"repeat the first position at the end, or {FIXING}",
        )
    return positions


def _position(place: _Place, position: object) -> tuple[float, float]:
    if not isinstance(position, list) or len(position) < 2:
        raise place.error(f"the position is {shown(position)}", "it must be [x, y] in metres")
    x, y = (_coordinate(place, value) for value in position[:2])
    return x, y


def _coordinate(place: _Place, value: object) -> float:
    number = math.nan
    if isinstance(value, int | float) and not isinstance(value, bool):
        # Compared before the conversion: integers of JSON have no bound.
        number = float(value) if abs(value) <= MAX_COORDINATE_M else math.inf
    if not math.isfinite(number):
        raise place.error(
            f"a coordinate is {shown(value)}",
            f"it must be a number of metres, at most {MAX_COORDINATE_M:g}",
        )
    return number


def _list(place: _Place, item: dict[str, object], key: str) -> list[object]:
    value = item.get(key)
    if not isinstance(value, list):
        raise place.error(f"{key} is {shown(value)}", "it must be a list")
    return value


def degrees_hint(environment: Environment) -> str:
    """Return a hint for a world whose GeoJSON file may be in degrees; empty if it cannot be.

    Parameters
    ----------
    environment : Environment
        A world that is too small for a body.

    Examples
    --------
    >>> town = Environment("town", shapely.box(8.5, 47.3, 8.9, 47.7), origin="town.geojson")
    >>> degrees_hint(town)
    'if its coordinates are degrees, project them first: those of GeoJSON must be metres'
    >>> degrees_hint(Environment("town", shapely.box(8.5, 47.3, 8.9, 47.7)))
    ''
    """
    x0, y0, x1, y1 = environment.bounds
    is_geojson = Path(environment.origin).suffix.lower() in GEOJSON.suffixes
    is_small = max(x1 - x0, y1 - y0) < MAX_DEGREES
    if not is_geojson or not is_small or max(-x0, x1) > 180.0 or max(-y0, y1) > 90.0:
        return ""
    return "if its coordinates are degrees, project them first: those of GeoJSON must be metres"


def _is_geojson(beginning: Beginning) -> bool:
    kinds = "Feature|FeatureCollection|GeometryCollection|(Multi)?(Polygon|Point|LineString)"
    return beginning.text.lstrip().startswith("{") and (
        re.search(rf'"type"\s*:\s*"({kinds})"', beginning.text) is not None
    )


GEOJSON = MapFormat(
    name="GeoJSON",
    suffixes=(".geojson", ".json"),
    recognises=_is_geojson,
    read=read_geojson,
    repair=partial(read_geojson, repair=True),
)
