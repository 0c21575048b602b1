"""The model of a world: free space as polygons with holes, in metres."""

import hashlib
import math
from collections.abc import Iterable, Sequence
from functools import cached_property

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import GeometryType, MultiPolygon, Point, Polygon
from shapely.geometry.base import BaseGeometry

from multisrt.geometry.errors import ClearanceError, InvalidInputError
from multisrt.geometry.numerics.arrays import FloatArray

GeometryArray = NDArray[np.object_]

SLIVER_WIDTH_M = 1e-3
"""Parts of free space and obstacles that are nowhere wider than this are dropped."""

MAX_COORDINATE_M = 1e7
"""Coordinates beyond this leave too few digits for millimetres."""


class Environment:
    """A world to explore: free space with obstacles as its holes and surroundings.

    Immutable. Free space may fall apart into several components; a robot explores the one
    that it starts in.

    Parameters
    ----------
    name : str
        What tables and pictures call it.
    free : Polygon or MultiPolygon
        Free space in metres, x to the right, y up. Self-crossing outlines are refused.
    starts : sequence of (x, y)
        Suggested starts, in order of preference.
    origin : str
        Where the world comes from: the generator's call or the file's name.

    Raises
    ------
    InvalidInputError
        If free space is empty, has coordinates that are not finite, or crosses itself; the
        message names the place.

    Examples
    --------
    >>> import shapely
    >>> outline, pillar = shapely.box(0, 0, 10, 10), shapely.box(4, 4, 6, 6)
    >>> hall = Environment.from_outline("hall", outline, [pillar])
    >>> hall.area_m2, hall.edges.shape
    (96.0, (8, 4))
    """

    def __init__(
        self,
        name: str,
        free: BaseGeometry,
        *,
        starts: Sequence[tuple[float, float]] = (),
        origin: str = "",
    ) -> None:
        _require_valid(free, name)
        solid = _without_slivers(_polygons(free))
        if not solid.size:
            raise InvalidInputError(
                f"environment {name!r}: free space is empty; "
                "a world needs at least one area wider than 1 mm"
            )
        parts = MultiPolygon([_without_sliver_holes(part) for part in solid])
        free_space = shapely.orient_polygons(shapely.normalize(parts))
        self._name = name
        self._free: MultiPolygon = free_space
        self._origin = origin
        self._starts = tuple((float(x), float(y)) for x, y in starts)
        shapely.prepare(self._free)
        for x, y in self._starts:
            if not shapely.contains_xy(self._free, x, y):
                raise InvalidInputError(
                    f"environment {name!r}: suggested start ({x:g}, {y:g}) is not in free space"
                )

    @classmethod
    def from_outline(
        cls,
        name: str,
        outline: BaseGeometry,
        obstacles: Iterable[BaseGeometry] = (),
        *,
        starts: Sequence[tuple[float, float]] = (),
        origin: str = "",
    ) -> "Environment":
        """Build a world from its outline and the obstacles in it, which may overlap.

        Parameters
        ----------
        name, starts, origin
            As for the class.
        outline : Polygon or MultiPolygon
            The outer walls; free space lies inside.
        obstacles : iterable of Polygon or MultiPolygon
            What stands in it. They are united, so they may overlap, touch each other and
            reach over the outline.

        Raises
        ------
        InvalidInputError
            If an outline or an obstacle crosses itself or is not finite.
        """
        _require_valid(outline, name)
        solid = list(obstacles)
        for obstacle in solid:
            _require_valid(obstacle, name)
        free = outline.difference(shapely.union_all(solid)) if solid else outline
        return cls(name, free, starts=starts, origin=origin)

    @property
    def name(self) -> str:
        """What tables and pictures call this world."""
        return self._name

    @property
    def free(self) -> MultiPolygon:
        """Free space: exteriors counter-clockwise, holes clockwise."""
        return self._free

    @property
    def starts(self) -> tuple[tuple[float, float], ...]:
        """Suggested starts, in order of preference."""
        return self._starts

    @property
    def origin(self) -> str:
        """Where the world comes from: the generator's call or the file's name."""
        return self._origin

    @property
    def area_m2(self) -> float:
        """Area of free space, all components."""
        return float(self._free.area)

    @property
    def bounds(self) -> tuple[float, float, float, float]:
        """The least x, least y, greatest x and greatest y of free space."""
        x0, y0, x1, y1 = self._free.bounds
        return float(x0), float(y0), float(x1), float(y1)

    @cached_property
    def edges(self) -> FloatArray:
        """The boundary as ``(n, 4)`` directed edges x0, y0, x1, y1, free space on their left."""
        rings = [ring for part in self._free.geoms for ring in (part.exterior, *part.interiors)]
        coordinates = [np.asarray(ring.coords)[:, :2] for ring in rings]
        edges = np.vstack([np.hstack([ring[:-1], ring[1:]]) for ring in coordinates])
        edges.setflags(write=False)
        return edges

    @cached_property
    def digest(self) -> str:
        """SHA-256 of the free space's coordinates: equal worlds have equal digests."""
        return hashlib.sha256(shapely.to_wkb(self._free, byte_order=1)).hexdigest()

    @cached_property
    def _components(self) -> tuple[Polygon, ...]:
        # Always the same objects: what is computed of a component is found again at once.
        return tuple(self._free.geoms)

    def contains(self, x: float, y: float) -> bool:
        """Whether a point lies in the interior of free space."""
        return bool(shapely.contains_xy(self._free, x, y))

    def clearance(self, x: float, y: float) -> float:
        """Distance from a point to the nearest obstacle in metres; 0 where it is not free."""
        if not self.contains(x, y):
            return 0.0
        return float(self._free.boundary.distance(Point(x, y)))

    def component(self, x: float, y: float) -> Polygon:
        """Give the connected component of free space around a point.

        Raises
        ------
        ClearanceError
            If the point is not in free space.
        """
        for part in self._components:
            if shapely.contains_xy(part, x, y):
                return part
        raise ClearanceError(
            f"({x:g}, {y:g}) is not in the free space of {self._name!r}: "
            "it is inside an obstacle or outside the outline (clearance 0 m)",
            0.0,
        )

    def __repr__(self) -> str:
        x0, y0, x1, y1 = self.bounds
        return (
            f"Environment({self._name!r}, {x1 - x0:.4g} x {y1 - y0:.4g} m, "
            f"{self.area_m2:.4g} m2 free, {len(self.edges)} edges)"
        )

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Environment):
            return NotImplemented
        return self._name == other._name and self.digest == other.digest

    def __hash__(self) -> int:
        return hash((self._name, self.digest))


def _polygons(geometry: BaseGeometry) -> GeometryArray:
    parts = shapely.get_parts(geometry)
    polygons: GeometryArray = parts[shapely.get_type_id(parts) == GeometryType.POLYGON]
    return polygons


def _require_valid(geometry: BaseGeometry, name: str) -> None:
    if geometry.geom_type not in ("Polygon", "MultiPolygon", "GeometryCollection"):
        raise InvalidInputError(
            f"environment {name!r}: free space and obstacles are polygons, not {geometry.geom_type}"
        )
    coordinates, index = shapely.get_coordinates(geometry, return_index=False), 0
    bad = np.flatnonzero(
        ~np.isfinite(coordinates).all(axis=1) | (np.abs(coordinates) > MAX_COORDINATE_M).any(axis=1)
    )
    if bad.size:
        index = int(bad[0])
        x, y = coordinates[index]
        raise InvalidInputError(
            f"environment {name!r}: vertex {index} is ({x:g}, {y:g}); coordinates are finite "
            f"numbers of metres, at most {MAX_COORDINATE_M:g}"
        )
    if not geometry.is_valid:
        raise InvalidInputError(
            f"environment {name!r}: a polygon is not valid: "
            f"{shapely.is_valid_reason(geometry)}; draw outlines that do not cross themselves"
        )


def _without_slivers(parts: GeometryArray) -> GeometryArray:
    # Eroding takes at most a strip along the boundary and a sector at each hole; what has more
    # area than that is none, which spares large worlds the erosion.
    radius = SLIVER_WIDTH_M / 2
    holes = shapely.get_num_interior_rings(parts)
    thin = shapely.area(parts) <= radius * shapely.length(parts) + holes * math.pi * radius**2
    thin[thin] = shapely.is_empty(shapely.buffer(parts[thin], -radius))
    return parts[~thin]


def _without_sliver_holes(part: Polygon) -> Polygon:
    holes = np.asarray(shapely.polygons(shapely.get_rings(part)[1:]), np.object_)
    solid = _without_slivers(holes)
    if solid.size == holes.size:
        return part
    return Polygon(part.exterior, [hole.exterior for hole in solid])
