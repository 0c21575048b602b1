"""Worlds as polygons in text: well-known text and GeoJSON, with all digits of coordinates."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from typing import Any

import shapely
from shapely import LinearRing
from shapely.geometry.base import BaseGeometry

from multisrt.environments.environment import Environment
from multisrt.environments.formats.geojson import MIN_EXTENT_M
from multisrt.geometry.errors import InvalidInputError


def wkt_bytes(environment: Environment) -> bytes:
    r"""Return the free space of a world as a MULTIPOLYGON of well-known text, in metres.

    The format cannot hold suggested starts. Coordinates have the fewest digits from which the same
    numbers are read, including the sign of a zero.

    Parameters
    ----------
    environment : Environment
        The world.

    Examples
    --------
    >>> wkt_bytes(Environment("hall", shapely.box(0, 0, 4, 0.3))).decode()
    'MULTIPOLYGON (((0 0, 4 0, 4 0.3, 0 0.3, 0 0)))\n'

    Notes
    -----
    Source: OGC 06-103r4, Simple Feature Access, clause 7.
    """
    polygons = ", ".join(
        "(" + ", ".join(_ring(ring) for ring in (part.exterior, *part.interiors)) + ")"
        for part in environment.free.geoms
    )
    return f"MULTIPOLYGON ({polygons})\n".encode()


def _ring(ring: LinearRing) -> str:
    positions = (f"{digits(x)} {digits(y)}" for x, y in shapely.get_coordinates(ring).tolist())
    return f"({', '.join(positions)})"


def digits(value: float) -> str:
    """Return the shortest text from which the same number is read."""
    return repr(value).removesuffix(".0")


def geojson_bytes(environment: Environment) -> bytes:
    """Return a world as a FeatureCollection of GeoJSON, in metres.

    Each component of free space is a Polygon of kind ``free`` whose holes are the obstacles, and
    each suggested start a Point of kind ``start``, in their order. Each feature is on a line of its
    own.

    Parameters
    ----------
    environment : Environment
        The world.

    Raises
    ------
    InvalidInputError
        If the world is so small that its coordinates could be degrees.

    Examples
    --------
    >>> hall = Environment("hall", shapely.box(0, 0, 4, 3), starts=[(1, 2)])
    >>> [feature["properties"] for feature in json.loads(geojson_bytes(hall))["features"]]
    [{'kind': 'free'}, {'kind': 'start'}]

    Notes
    -----
    Source: RFC 7946; differs in: coordinates are metres in the frame of the world, not longitude
    and latitude.
    """
    x0, y0, x1, y1 = environment.bounds
    if max(x1 - x0, y1 - y0) < MIN_EXTENT_M:
        raise InvalidInputError(
            f"the world {environment.name!r} is {x1 - x0:.2g} x {y1 - y0:.2g} m: readers of "
            f"GeoJSON take worlds smaller than {MIN_EXTENT_M:g} m for degrees; write WKT"
        )
    shapes: list[tuple[BaseGeometry, str]] = [(part, "free") for part in environment.free.geoms]
    shapes += [(shapely.Point(start), "start") for start in environment.starts]
    return collection_bytes(
        environment.name,
        [({"kind": kind}, shapely.geometry.mapping(shape)) for shape, kind in shapes],
    )


def collection_bytes(
    name: str, features: Iterable[tuple[Mapping[str, Any], Mapping[str, Any]]]
) -> bytes:
    """Return a FeatureCollection of GeoJSON, with each feature on a line of its own.

    Parameters
    ----------
    name : str
        Name of the collection.
    features : iterable of (properties, geometry)
        The features, as JSON.
    """
    lines = ",\n".join(
        json.dumps({"type": "Feature", "properties": properties, "geometry": geometry})
        for properties, geometry in features
    )
    beginning = f'{{"type": "FeatureCollection", "name": {json.dumps(name)}, "features": ['
    return f"{beginning}\n{lines}\n]}}\n".encode()


def printable(text: str) -> str:
    """Return a text without line breaks and control characters, which XML cannot hold."""
    return "".join(sign if sign.isprintable() else "\N{REPLACEMENT CHARACTER}" for sign in text)
