"""The model of a world: free space as polygons with holes, in metres."""

import hashlib
from collections.abc import Iterable, Sequence
from functools import cached_property
from importlib import import_module
from types import ModuleType
from typing import TYPE_CHECKING

import numpy as np
import shapely
from shapely import MultiPolygon, Point, Polygon
from shapely.geometry.base import BaseGeometry

from multisrt.environments.area_text import extent_text
from multisrt.environments.cleaning import (
    Cleaning,
    polygons_of,
    without_denormals,
    without_slivers,
)
from multisrt.environments.layers import Layers
from multisrt.geometry.errors import ClearanceError, InvalidInputError, shown
from multisrt.geometry.numerics.arrays import FloatArray
from multisrt.geometry.regions.overlay import difference_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes

SLIVER_WIDTH_M = 1e-3
"""Width in metres below which parts of free space and obstacles are dropped."""

MAX_COORDINATE_M = 1e7
"""Upper bound of the absolute value of coordinates, in metres."""

MIN_LENGTH_M = 1e-6
"""Lower bound of the sides of cells, the sizes of models and the units of drawings, in metres.

Doubles of up to `MAX_COORDINATE_M` are at most 2e-9 apart, so that such a cell keeps its shape.
"""


class Environment:
    """A world to explore: free space, bounded by obstacles.

    Immutable and hashable. Free space may have several components; a robot explores the one
    that it starts in.

    Parameters
    ----------
    name : str
        Name in tables and pictures.
    free : Polygon or MultiPolygon
        Free space in metres, x to the right, y up; obstacles are its holes and surroundings.
    starts : sequence of (x, y), optional
        Suggested starts in metres, in order of preference.
    origin : str, optional
        Source of the world: the call of a generator or the name of a file.
    cleaning : Cleaning, optional
        Changes that were made to the map before. Parts of free space and obstacles that are
        nowhere 1 mm wide are dropped here, and added to these changes.
    layers : Layers, optional
        Layers of the drawing that it was read from, if their names determine what is free.
    outlined_obstacles : bool, optional
        Whether obstacles may be drawn as outlines, whose insides are separate parts of free space
        that are not to be explored.

    Raises
    ------
    InvalidInputError
        If free space is empty, has coordinates that are not finite, or crosses itself, or if a
        suggested start is not in it; the message names the place.

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
        cleaning: Cleaning | None = None,
        layers: Layers | None = None,
        outlined_obstacles: bool = False,
    ) -> None:
        free = without_denormals(free)
        _require_valid(free, name)
        parts, dropped = without_slivers(polygons_of(free), SLIVER_WIDTH_M)
        if parts.is_empty:
            raise InvalidInputError(
                f"environment {shown(name)}: free space is empty; "
                "a world needs at least one area wider than 1 mm"
            )
        free_space = shapely.orient_polygons(shapely.normalize(parts))
        self._name = name
        self._free: MultiPolygon = free_space
        self._origin = origin
        self._layers = layers
        self._outlined_obstacles = outlined_obstacles
        self._cleaning = dropped if cleaning is None else cleaning + dropped
        self._starts = tuple((float(x), float(y)) for x, y in starts)
        shapely.prepare(self._free)
        for x, y in self._starts:
            if not shapely.contains_xy(self._free, x, y):
                raise InvalidInputError(
                    f"environment {shown(name)}: suggested start ({x:g}, {y:g}) is not in free "
                    "space"
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
        """Return a world given by its outline and the obstacles in it.

        Parameters
        ----------
        name, starts, origin
            As for the class.
        outline : Polygon or MultiPolygon
            Outer walls, in metres; free space is inside.
        obstacles : iterable of Polygon or MultiPolygon
            Obstacles in metres. They may overlap, touch each other and extend beyond the
            outline.

        Returns
        -------
        Environment
            The world; its free space is the outline without the obstacles.

        Raises
        ------
        InvalidInputError
            If the outline or an obstacle crosses itself or has coordinates that are not finite,
            or if no free space is left.

        Examples
        --------
        >>> import shapely
        >>> pillars = [shapely.box(x, 2, x + 1, 3) for x in (2, 5)]
        >>> Environment.from_outline("hall", shapely.box(0, 0, 8, 5), pillars).area_m2
        38.0
        """
        _require_valid(outline, name)
        solid = list(obstacles)
        for obstacle in solid:
            _require_valid(obstacle, name)
        return cls(name, difference_of(outline, solid), starts=starts, origin=origin)

    @property
    def name(self) -> str:
        """Name in tables and pictures."""
        return self._name

    @property
    def free(self) -> MultiPolygon:
        """Free space in metres: exteriors counter-clockwise, holes clockwise."""
        return self._free

    @property
    def starts(self) -> tuple[tuple[float, float], ...]:
        """Suggested starts (x, y) in metres, in order of preference."""
        return self._starts

    @property
    def origin(self) -> str:
        """Source of the world: the call of a generator or the name of a file; may be empty."""
        return self._origin

    @property
    def cleaning(self) -> Cleaning:
        """Changes that readers and repairs made to the map; not part of the digest."""
        return self._cleaning

    @property
    def layers(self) -> Layers | None:
        """Layers of the drawing that were read and left out; not part of the digest.

        None if the world is not from a drawing that is read by the names of layers.
        """
        return self._layers

    @property
    def outlined_obstacles(self) -> bool:
        """Whether separate parts may be insides of obstacles; not part of the digest."""
        return self._outlined_obstacles

    @property
    def area_m2(self) -> float:
        """Area of all components of free space, in square metres."""
        return float(self._free.area)

    @property
    def bounds(self) -> tuple[float, float, float, float]:
        """Minimum x, minimum y, maximum x and maximum y of free space, in metres."""
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
        """SHA-256 of the coordinates of free space, in hexadecimal digits."""
        return hashlib.sha256(shapely.to_wkb(self._free, byte_order=1)).hexdigest()

    @cached_property
    def components(self) -> tuple[Polygon, ...]:
        """The connected components of free space; the same objects at every access."""
        return tuple(self._free.geoms)

    def plot(self, ax: "Axes | None" = None) -> "Axes":
        """Draw the world on matplotlib axes, in the colours of its SVG picture.

        Parameters
        ----------
        ax : matplotlib.axes.Axes, optional
            Axes to draw on; their aspect becomes equal. By default those of a new pyplot figure
            with title and legend.

        Returns
        -------
        matplotlib.axes.Axes
            The axes; units are metres.

        Raises
        ------
        MissingExtraError
            If matplotlib is not installed (``multisrt[plots]``).

        Examples
        --------
        >>> import shapely
        >>> from matplotlib.figure import Figure
        >>> ax = Environment("hall", shapely.box(0, 0, 4, 3)).plot(Figure().add_subplot())
        >>> bool(ax.dataLim.width > 4.0)
        True
        """
        axes: Axes = _pictures().plot_environment(self, ax)
        return axes

    def _repr_svg_(self) -> str:
        svg: str = _pictures().environment_svg(self)
        return svg

    def contains(self, x: float, y: float) -> bool:
        """Return whether a point lies in the interior of free space.

        Parameters
        ----------
        x, y : float
            The point, in metres.

        Returns
        -------
        bool
            False on the boundary.

        Examples
        --------
        >>> import shapely
        >>> hall = Environment("hall", shapely.box(0, 0, 4, 4))
        >>> hall.contains(1.0, 2.0), hall.contains(0.0, 2.0)
        (True, False)
        """
        return bool(shapely.contains_xy(self._free, x, y))

    def clearance(self, x: float, y: float) -> float:
        """Return the distance from a point to the nearest obstacle.

        Parameters
        ----------
        x, y : float
            The point, in metres.

        Returns
        -------
        float
            Distance in metres; 0 for a point that is not in free space.

        Examples
        --------
        >>> import shapely
        >>> hall = Environment("hall", shapely.box(0, 0, 4, 4))
        >>> hall.clearance(1.0, 2.0), hall.clearance(9.0, 9.0)
        (1.0, 0.0)
        """
        if not self.contains(x, y):
            return 0.0
        return float(self._free.boundary.distance(Point(x, y)))

    def component(self, x: float, y: float) -> Polygon:
        """Return the connected component of free space that contains a point.

        Parameters
        ----------
        x, y : float
            The point, in metres.

        Returns
        -------
        Polygon
            The component; the same object for all points in it.

        Raises
        ------
        ClearanceError
            If the point is not in free space.

        Examples
        --------
        >>> import shapely
        >>> two = shapely.union_all([shapely.box(0, 0, 2, 2), shapely.box(3, 0, 6, 2)])
        >>> Environment("two rooms", two).component(4.0, 1.0).area
        6.0
        """
        for part in self.components:
            if shapely.contains_xy(part, x, y):
                return part
        away = float(self._free.distance(Point(x, y)))
        raise ClearanceError(
            f"({x:g}, {y:g}) is not in the free space of {shown(self._name)}: it is "
            + (
                f"in an obstacle or outside the outline, {away:.3g} m from free space"
                if away
                else "on its border"
            ),
            0.0,
        )

    def __repr__(self) -> str:
        extent = extent_text(self.bounds, self.area_m2)
        return f"Environment({self._name!r}, {extent}, {len(self.edges)} edges)"

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Environment):
            return NotImplemented
        return self._name == other._name and self.digest == other.digest

    def __hash__(self) -> int:
        return hash((self._name, self.digest))


def _require_valid(geometry: BaseGeometry, name: str) -> None:
    if geometry.geom_type not in ("Polygon", "MultiPolygon", "GeometryCollection"):
        raise InvalidInputError(
            f"environment {shown(name)}: free space and obstacles are polygons, not "
            f"{geometry.geom_type}"
        )
    coordinates, index = shapely.get_coordinates(geometry, return_index=False), 0
    bad = np.flatnonzero(
        ~np.isfinite(coordinates).all(axis=1) | (np.abs(coordinates) > MAX_COORDINATE_M).any(axis=1)
    )
    if bad.size:
        index = int(bad[0])
        x, y = coordinates[index]
        raise InvalidInputError(
            f"environment {shown(name)}: vertex {index} is ({x:g}, {y:g}); coordinates are finite "
            f"numbers of metres, at most {MAX_COORDINATE_M:g}"
        )
    if not geometry.is_valid:
        raise InvalidInputError(
            f"environment {shown(name)}: a polygon is not valid: "
            f"{shapely.is_valid_reason(geometry)}; draw outlines that do not cross themselves"
        )


def _pictures() -> ModuleType:
    # Loaded by name: pictures are made of worlds, and no run depends on how they are drawn.
    return import_module("multisrt.drawing")
