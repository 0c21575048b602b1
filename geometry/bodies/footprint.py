"""Footprints: the shape of a robot's body on the floor, about its reference point."""

import math
from collections.abc import Callable, Sequence
from functools import cached_property, lru_cache

import numpy as np
import shapely
from numpy.typing import ArrayLike
from shapely import MultiPolygon, Polygon

from multisrt.geometry.configuration import Configuration
from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.numerics.kernel import FloatArray

DISC_SIDES = 128
"""Sides of the regular polygon that stands for a disc where a polygon is asked for."""

MIN_INSCRIBED_RADIUS_M = 1e-6
"""The reference point of a body is at least this far inside it."""

MAX_SIZE_M = 1e6
"""No part of a body is farther than this from its reference point."""

BODIES_KEPT = 256
"""So many bodies that were read are kept for those who read them again."""

FORMS = (
    "write disc:RADIUS, box:LENGTHxWIDTH or polygon:X,Y X,Y X,Y ... in metres, "
    "for example disc:0.25, box:0.6x0.4 or polygon:-0.2,-0.1 0.3,0 -0.2,0.1"
)


class Footprint:
    """A body about its reference point (0, 0), with x pointing forward.

    Immutable; equal footprints have the same form and numbers. Build one with `disc`, `box`,
    `polygon` or `parse`; ``str`` gives the text that `parse` reads.

    A disc is exact where radii are used (collision, clearance, width). Where a polygon is asked
    for (`vertices`, `placed`, `swept`) it is the regular polygon of `DISC_SIDES` sides drawn
    around the disc: it holds the whole disc and reaches at most 0.0302 % of the radius beyond.

    Examples
    --------
    >>> body = Footprint.parse("box:0.6x0.4")
    >>> body.width_m, body.is_convex, str(body)
    (0.4, True, 'box:0.6x0.4')
    >>> Footprint.disc(0.25).placed((1.0, 2.0, 0.0)).bounds
    (0.75, 1.75, 1.25, 2.25)
    """

    def __init__(self, text: str, vertices: FloatArray, radius_m: float | None) -> None:
        self._text = text
        self._vertices = vertices
        self._radius = radius_m
        self._vertices.setflags(write=False)

    @classmethod
    def disc(cls, radius_m: float) -> "Footprint":
        """Give a disc around the reference point.

        Raises
        ------
        InvalidInputError
            If the radius is not a positive, finite number of metres.
        """
        radius = _size(radius_m, "radius of a disc", 1.0)
        # Sides touch the disc at the axes, so that bounding boxes are exact.
        angle = (np.arange(DISC_SIDES) + 0.5) * (2.0 * math.pi / DISC_SIDES)
        reach = radius / math.cos(math.pi / DISC_SIDES)
        around = reach * np.column_stack([np.cos(angle), np.sin(angle)])
        return cls(f"disc:{_number(radius)}", around, radius)

    @classmethod
    def box(cls, length_m: float, width_m: float) -> "Footprint":
        """Give a rectangle centred on the reference point, its length along x.

        Raises
        ------
        InvalidInputError
            If length or width is not a positive, finite number of metres.
        """
        length = _size(length_m, "length of a box", 2.0)
        width = _size(width_m, "width of a box", 2.0)
        x, y = length / 2.0, width / 2.0
        corners = np.array([(-x, -y), (x, -y), (x, y), (-x, y)])
        return cls(f"box:{_number(length)}x{_number(width)}", corners, None)

    @classmethod
    def polygon(cls, vertices: ArrayLike) -> "Footprint":
        """Give a body with any simple outline, convex or not.

        Parameters
        ----------
        vertices : (n, 2) array_like
            Corners in order, either way round, in metres about the reference point; the first
            may be repeated at the end. They are kept counter-clockwise from the first.

        Raises
        ------
        InvalidInputError
            If the outline is not finite, has fewer than three corners, crosses itself, or
            does not hold the reference point in its interior.
        """
        corners = _outline(vertices)
        text = "polygon:" + " ".join(f"{_number(x)},{_number(y)}" for x, y in corners.tolist())
        return cls(text, corners, None)

    @classmethod
    def parse(cls, text: str) -> "Footprint":
        """Read a footprint from text such as ``disc:0.25``, ``box:0.6x0.4`` or ``polygon:...``.

        Raises
        ------
        InvalidInputError
            If the text has none of these forms or the body is not usable.
        """
        return _parsed(text)

    @property
    def is_disc(self) -> bool:
        """Whether the body is a disc, whose heading does not matter."""
        return self._radius is not None

    @property
    def radius_m(self) -> float:
        """Radius of a disc.

        Raises
        ------
        InvalidInputError
            If the body is not a disc.
        """
        if self._radius is None:
            raise InvalidInputError(
                f"footprint {self} has no radius; take its inscribed or circumscribed radius"
            )
        return self._radius

    @property
    def vertices(self) -> FloatArray:
        """Outline as ``(n, 2)`` corners, counter-clockwise, read-only; around a disc."""
        return self._vertices

    @cached_property
    def inscribed_radius_m(self) -> float:
        """Distance from the reference point to the outline."""
        if self._radius is not None:
            return self._radius
        return _distance_to_outline(self._vertices)

    @cached_property
    def circumscribed_radius_m(self) -> float:
        """Distance from the reference point to the farthest point of the body."""
        if self._radius is not None:
            return self._radius
        return float(np.hypot(*self._vertices.T).max())

    @cached_property
    def width_m(self) -> float:
        """Width of the narrowest straight passage that the body fits through.

        The least extent of its convex hull over all directions.
        """
        if self._radius is not None:
            return 2.0 * self._radius
        hull = _convex_hull(self._vertices)
        along = np.roll(hull, -1, axis=0) - hull
        normals = np.column_stack([-along[:, 1], along[:, 0]]) / np.hypot(*along.T)[:, None]
        offsets = normals @ hull.T
        return float((offsets.max(axis=1) - offsets.min(axis=1)).min())

    @cached_property
    def is_convex(self) -> bool:
        """Whether the body is convex."""
        return _is_convex(self._vertices)

    @cached_property
    def is_star_shaped(self) -> bool:
        """Whether every point of the body is in sight of the reference point within it."""
        ends = np.roll(self._vertices, -1, axis=0)
        slack = 1e-12 * self.circumscribed_radius_m**2
        return bool((_cross(self._vertices, ends) >= -slack).all())

    @cached_property
    def planning_vertices(self) -> FloatArray:
        """Outline for a planner, ``(n, 2)``, counter-clockwise, read-only.

        The body itself if it is star-shaped about the reference point, else its convex hull:
        a region seen from one place is star-shaped, so a body that fits in it has to be.
        """
        if self.is_star_shaped:
            return self._vertices
        hull = _convex_hull(self._vertices)
        hull.setflags(write=False)
        return hull

    @cached_property
    def convex_pieces(self) -> tuple[FloatArray, ...]:
        """Convex polygons, counter-clockwise, that share no area and together are the body."""
        if self.is_convex:
            return (self._vertices,)
        return tuple(self._vertices[piece] for piece in _convex_partition(self._vertices))

    def placed(self, configuration: Sequence[float]) -> Polygon:
        """Give the body at a configuration ``(x, y, heading)``, in the frame of the configuration.

        Raises
        ------
        InvalidInputError
            If the configuration is not three finite numbers.
        """
        return Polygon(self._at(self._vertices, checked_configuration(configuration)))

    def swept(self, start: Sequence[float], end: Sequence[float]) -> Polygon | MultiPolygon:
        """Give the area that the body sweeps on a straight line with constant heading.

        Exact for polygons. For a disc it is the capsule drawn around by the disc's polygon.

        Raises
        ------
        InvalidInputError
            If a configuration is not three finite numbers, or the headings differ (those of a
            disc may).
        """
        first, last = checked_configuration(start), checked_configuration(end)
        require_constant_heading(self, first, last)
        step = np.array([last[0] - first[0], last[1] - first[1]])
        hulls = [
            Polygon(sweep_convex(self._at(piece, first), step)) for piece in self.convex_pieces
        ]
        if len(hulls) == 1:
            return hulls[0]
        area = shapely.union_all(hulls)
        assert isinstance(area, (Polygon, MultiPolygon))
        return area

    def _at(self, points: FloatArray, configuration: Configuration) -> FloatArray:
        x, y, heading = configuration
        return place(points, x, y, 0.0 if self.is_disc else heading)

    def __str__(self) -> str:
        return self._text

    def __repr__(self) -> str:
        return f"Footprint.parse({self._text!r})"

    def __eq__(self, other: object) -> bool:
        return self._text == other._text if isinstance(other, Footprint) else NotImplemented

    def __hash__(self) -> int:
        return hash(self._text)

    def __reduce__(self) -> tuple[Callable[[str], "Footprint"], tuple[str]]:
        return Footprint.parse, (self._text,)


@lru_cache(maxsize=BODIES_KEPT)
def _parsed(text: str) -> Footprint:
    # Bodies do not change, and robots mostly have the same.
    form, colon, numbers = text.strip().partition(":")
    readers: dict[str, Callable[[str], Footprint]] = {
        "disc": lambda words: Footprint.disc(float(words)),
        "box": lambda words: Footprint.box(*_pair(words, "x")),
        "polygon": lambda words: Footprint.polygon([_pair(word, ",") for word in words.split()]),
    }
    if not colon or form.strip() not in readers:
        raise InvalidInputError(f"footprint {text!r} is not known; {FORMS}")
    try:
        return readers[form.strip()](numbers)
    except InvalidInputError as problem:
        raise InvalidInputError(f"footprint {text!r}: {problem}") from None
    except ValueError:
        raise InvalidInputError(f"footprint {text!r} cannot be read; {FORMS}") from None


def checked_configuration(configuration: Sequence[float]) -> Configuration:
    """Give three numbers as a configuration.

    Raises
    ------
    InvalidInputError
        If it is not three finite numbers.
    """
    try:
        x, y, heading = map(float, configuration)
    except (TypeError, ValueError):
        raise InvalidInputError(
            f"configuration {configuration!r} is not three numbers: give x, y in metres and "
            "the heading in radians"
        ) from None
    if not (math.isfinite(x) and math.isfinite(y) and math.isfinite(heading)):
        raise InvalidInputError(
            f"configuration ({x:g}, {y:g}, {heading:g}) is not finite: give x, y in metres and "
            "the heading in radians"
        )
    return Configuration(x, y, heading)


def require_constant_heading(
    footprint: Footprint, start: Configuration, end: Configuration
) -> None:
    """Check that a body keeps its heading from start to end; a disc always does.

    Raises
    ------
    InvalidInputError
        If the headings differ by more than a microradian.
    """
    turn = math.remainder(end[2] - start[2], 2.0 * math.pi)
    if not footprint.is_disc and abs(turn) > 1e-6:
        raise InvalidInputError(
            f"straight motion of {footprint} from heading {start[2]:g} to {end[2]:g} rad: "
            "the heading of a straight motion is constant; turn first, or check the motion as "
            "one that turns"
        )


def place(points: FloatArray, x: float, y: float, heading: float) -> FloatArray:
    """Turn ``(n, 2)`` points about the origin by a heading, then move them by ``(x, y)``."""
    c, s = math.cos(heading), math.sin(heading)
    placed: FloatArray = points @ np.array([[c, s], [-s, c]]) + np.array([x, y])
    return placed


def sweep_convex(polygon: FloatArray, step: FloatArray) -> FloatArray:
    """Give the convex outline ``(m, 2)`` that a convex polygon sweeps when moved by ``step``.

    Edges that face the motion are carried along, the others stay; two sides of the length of
    the step join them.
    """
    edges = np.roll(polygon, -1, axis=0) - polygon
    ahead = step[0] * edges[:, 1] - step[1] * edges[:, 0] > 0.0
    outline = []
    for vertex, here, before in zip(polygon, ahead, np.roll(ahead, 1), strict=True):
        if here != before:
            outline.append(vertex + step if before else vertex)
        outline.append(vertex + step if here else vertex)
    return np.array(outline)


def _outline(vertices: ArrayLike) -> FloatArray:
    try:
        corners = np.array(vertices, dtype=np.float64)
    except (TypeError, ValueError):
        raise InvalidInputError("a polygon's corners are pairs of numbers of metres") from None
    if corners.ndim != 2 or corners.shape[1] != 2:
        raise InvalidInputError(
            f"a polygon's corners have shape (n, 2), not {corners.shape}: give x and y of each"
        )
    bad = np.flatnonzero(~(np.abs(corners) <= MAX_SIZE_M).all(axis=1))
    if bad.size:
        x, y = corners[bad[0]]
        raise InvalidInputError(
            f"corner {bad[0]} of a polygon is ({x:g}, {y:g}); corners are finite and within "
            f"{MAX_SIZE_M:g} m"
        )
    corners += 0.0  # -0.0 and 0.0 are the same place and shall have the same text
    repeated = (corners == np.roll(corners, 1, axis=0)).all(axis=1)
    corners = np.ascontiguousarray(corners[~repeated] if not repeated.all() else corners[:1])
    if len(corners) > 1 and repeated[0]:
        # The first corner was repeated at the end: the outline still begins with it.
        corners = np.roll(corners, 1, axis=0)
    if len(corners) < 3:
        raise InvalidInputError(
            f"a polygon has at least three different corners; this one has {len(corners)}"
        )
    shape = Polygon(corners)
    if not shape.is_valid:
        raise InvalidInputError(
            f"a polygon's outline is not simple: {shapely.is_valid_reason(shape)}; list the "
            "corners in order, so that it neither crosses nor touches itself"
        )
    if not shape.exterior.is_ccw:
        corners = np.roll(corners[::-1], 1, axis=0)
    gap = _distance_to_outline(corners)
    if not shapely.contains_xy(shape, 0.0, 0.0) or gap < MIN_INSCRIBED_RADIUS_M:
        where = "outside" if not shapely.intersects_xy(shape, 0.0, 0.0) else "at the edge of"
        raise InvalidInputError(
            f"the reference point (0, 0) is {where} the polygon, {gap:g} m from its outline; "
            "it has to be inside: give the corners about a point of the body"
        )
    return corners


def _size(value: float, name: str, parts: float) -> float:
    """Check a length, of which ``1 / parts`` lies on one side of the reference point."""
    try:
        size = float(value)
    except (TypeError, ValueError):
        raise InvalidInputError(f"the {name} is {value!r}; give a number of metres") from None
    if not parts * MIN_INSCRIBED_RADIUS_M <= size <= MAX_SIZE_M:
        raise InvalidInputError(
            f"the {name} is {size:g} m; it lies between {parts * MIN_INSCRIBED_RADIUS_M:g} and "
            f"{MAX_SIZE_M:g} m"
        )
    return size


def _pair(text: str, separator: str) -> tuple[float, float]:
    first, second = text.split(separator)
    return float(first), float(second)


def _number(value: float) -> str:
    """Write a number so that it reads back exactly, whole ones without a fraction."""
    return repr(value).removesuffix(".0")


def _cross(a: FloatArray, b: FloatArray) -> FloatArray:
    return np.asarray(a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0])


def _distance_to_outline(vertices: FloatArray) -> float:
    return float(shapely.distance(Polygon(vertices).exterior, shapely.Point(0.0, 0.0)))


def _convex_hull(vertices: FloatArray) -> FloatArray:
    hull = shapely.orient_polygons(shapely.convex_hull(shapely.multipoints(vertices)))
    return np.ascontiguousarray(shapely.get_coordinates(hull)[:-1])


def _is_convex(corners: FloatArray) -> bool:
    """Whether a simple counter-clockwise outline turns left, or goes straight on, everywhere."""
    ahead = np.roll(corners, -1, axis=0) - corners
    behind = corners - np.roll(corners, 1, axis=0)
    slack = 1e-12 * np.hypot(*ahead.T) * np.hypot(*behind.T)
    return bool((_cross(behind, ahead) >= -slack).all())


def _convex_partition(vertices: FloatArray) -> list[list[int]]:
    """Cut a simple outline into convex pieces, each a list of its corners' numbers.

    Source: Hertel and Mehlhorn, Fast triangulation of simple polygons, 1983: triangulate, then
    take away every diagonal that convexity does not need. At most four times as many pieces as
    the best partition has.
    """
    number = {(x, y): i for i, (x, y) in enumerate(vertices.tolist())}
    triangles = shapely.constrained_delaunay_triangles(Polygon(vertices))
    pieces = [
        [number[x, y] for x, y in shapely.get_coordinates(triangle)[:-1].tolist()]
        for triangle in shapely.get_parts(shapely.orient_polygons(triangles))
    ]
    sides = {(a, b) for piece in pieces for a, b in _sides(piece)}
    for a, b in sorted(side for side in sides if side[0] < side[1] and side[::-1] in sides):
        left = next(piece for piece in pieces if (a, b) in _sides(piece))
        right = next(piece for piece in pieces if (b, a) in _sides(piece))
        merged = _from(left, b) + _from(right, a)[1:-1]
        if _is_convex(vertices[merged]):
            pieces = [piece for piece in pieces if piece is not left and piece is not right]
            pieces.append(merged)
    return pieces


def _sides(piece: list[int]) -> list[tuple[int, int]]:
    return list(zip(piece, piece[1:] + piece[:1], strict=True))


def _from(piece: list[int], first: int) -> list[int]:
    at = piece.index(first)
    return piece[at:] + piece[:at]
