"""Footprints: the shape of a robot's body on the floor, about its reference point."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import cached_property, lru_cache
from typing import Final

import numpy as np
import shapely
from numpy.typing import ArrayLike
from shapely import MultiPolygon, Polygon

from multisrt.geometry.bodies.outlines import (
    MAX_SIZE_M,
    MIN_INSCRIBED_RADIUS_M,
    checked_outline,
    convex_hull,
    convex_partition,
    cross,
    distance_to_outline,
    is_convex,
    sweep_convex,
)
from multisrt.geometry.configuration import Configuration
from multisrt.geometry.errors import InvalidInputError, shown
from multisrt.geometry.numerics import libm
from multisrt.geometry.numerics.arrays import FloatArray

DISC_SIDES: Final = 128
"""Sides of the regular polygon that represents a disc where a polygon is needed."""

MAX_PARSED: Final = 256
"""Number of parsed footprints that are cached."""

HEADING_TOLERANCE_RAD: Final = 1e-6
"""Maximum turn of a motion that counts as one of constant heading."""

FORMS = (
    "write disc:RADIUS, box:LENGTHxWIDTH or polygon:X,Y X,Y X,Y ... in metres, "
    "for example disc:0.25, box:0.6x0.4 or polygon:-0.2,-0.1 0.3,0 -0.2,0.1"
)


class Footprint:
    """The outline of a body about its reference point (0, 0), with x pointing forward.

    Build one with `disc`, `box`, `polygon` or `parse`; ``str`` returns the text that `parse`
    reads. Footprints are immutable, and equal if they have the same form and numbers.

    A disc is exact in all computations with radii (collision, clearance, width). If a polygon is
    needed (`vertices`, `placed`, `swept`), it is the circumscribed regular polygon of `DISC_SIDES`
    sides, which exceeds the radius by at most 0.0302 %.

    Parameters
    ----------
    text : str
        The text accepted by `parse`.
    vertices : (n, 2) array
        Corners in metres, counter-clockwise; made read-only.
    radius_m : float or None
        Radius of a disc in metres.

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
    def disc(cls, radius_m: float) -> Footprint:
        """Return a disc around the reference point.

        Parameters
        ----------
        radius_m : float
            Radius in metres.

        Returns
        -------
        Footprint

        Raises
        ------
        InvalidInputError
            If the radius is not a number from `MIN_INSCRIBED_RADIUS_M` to `MAX_SIZE_M`.

        Examples
        --------
        >>> Footprint.disc(0.25).width_m
        0.5
        """
        radius = _size(radius_m, "radius of a disc", 1.0)
        # Sides touch the disc on the axes, so that bounding boxes are exact.
        angle = (np.arange(DISC_SIDES) + 0.5) * (2.0 * math.pi / DISC_SIDES)
        reach = radius / math.cos(math.pi / DISC_SIDES)
        around = reach * np.column_stack([libm.cos(angle), libm.sin(angle)])
        return cls(f"disc:{_number(radius)}", around, radius)

    @classmethod
    def box(cls, length_m: float, width_m: float) -> Footprint:
        """Return a rectangle centred on the reference point.

        Parameters
        ----------
        length_m, width_m : float
            Extent along x and along y in metres.

        Returns
        -------
        Footprint

        Raises
        ------
        InvalidInputError
            If length or width is not a number from twice `MIN_INSCRIBED_RADIUS_M` to
            `MAX_SIZE_M`.

        Examples
        --------
        >>> Footprint.box(0.6, 0.4).vertices.tolist()
        [[-0.3, -0.2], [0.3, -0.2], [0.3, 0.2], [-0.3, 0.2]]
        """
        length = _size(length_m, "length of a box", 2.0)
        width = _size(width_m, "width of a box", 2.0)
        x, y = length / 2.0, width / 2.0
        corners = np.array([(-x, -y), (x, -y), (x, y), (-x, y)])
        return cls(f"box:{_number(length)}x{_number(width)}", corners, None)

    @classmethod
    def polygon(cls, vertices: ArrayLike) -> Footprint:
        """Return a body with any simple outline, convex or not.

        Parameters
        ----------
        vertices : (n, 2) array_like
            Corners in order, in either direction, in metres about the reference point; the first
            may be repeated at the end. They are stored counter-clockwise from the first.

        Returns
        -------
        Footprint

        Raises
        ------
        InvalidInputError
            If a corner is not finite or has a coordinate beyond `MAX_SIZE_M`, if there are fewer
            than three corners, if the outline crosses or touches itself, or if the reference point
            is not inside by at least `MIN_INSCRIBED_RADIUS_M`.

        Examples
        --------
        >>> str(Footprint.polygon([(-0.2, -0.1), (0.3, 0.0), (-0.2, 0.1)]))
        'polygon:-0.2,-0.1 0.3,0 -0.2,0.1'
        """
        corners = checked_outline(vertices)
        text = "polygon:" + " ".join(f"{_number(x)},{_number(y)}" for x, y in corners.tolist())
        return cls(text, corners, None)

    @classmethod
    def parse(cls, text: str) -> Footprint:
        """Return the footprint described by a text.

        Parameters
        ----------
        text : str
            ``disc:RADIUS``, ``box:LENGTHxWIDTH`` or ``polygon:X,Y X,Y X,Y ...``, in metres.

        Returns
        -------
        Footprint

        Raises
        ------
        InvalidInputError
            If the text has none of these forms, or the body is not valid.

        Examples
        --------
        >>> Footprint.parse("disc:0.25") == Footprint.disc(0.25)
        True
        >>> Footprint.parse("polygon:-0.2,-0.1 0.3,0 -0.2,0.1").is_convex
        True
        """
        return _parsed(text)

    @property
    def is_disc(self) -> bool:
        """Whether the body is a disc, whose heading does not matter."""
        return self._radius is not None

    @property
    def radius_m(self) -> float:
        """Radius of a disc in metres.

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
        """Corners of the outline, ``(n, 2)`` in metres, counter-clockwise, read-only."""
        return self._vertices

    @cached_property
    def inscribed_radius_m(self) -> float:
        """Distance from the reference point to the outline in metres."""
        if self._radius is not None:
            return self._radius
        return distance_to_outline(self._vertices)

    @cached_property
    def circumscribed_radius_m(self) -> float:
        """Distance from the reference point to the farthest point of the body in metres."""
        if self._radius is not None:
            return self._radius
        return float(np.hypot(*self._vertices.T).max())

    @cached_property
    def width_m(self) -> float:
        """Width in metres of the narrowest straight passage that the body fits through.

        This is the smallest extent of its convex hull over all directions.
        """
        if self._radius is not None:
            return 2.0 * self._radius
        hull = convex_hull(self._vertices)
        along = np.roll(hull, -1, axis=0) - hull
        normals = np.column_stack([-along[:, 1], along[:, 0]]) / np.hypot(*along.T)[:, None]
        offsets = libm.product(normals, hull.T)
        return float((offsets.max(axis=1) - offsets.min(axis=1)).min())

    @cached_property
    def is_convex(self) -> bool:
        """Whether the body is convex."""
        return is_convex(self._vertices)

    @cached_property
    def is_star_shaped(self) -> bool:
        """Whether the line from the reference point to every point of the body lies within it."""
        ends = np.roll(self._vertices, -1, axis=0)
        slack = 1e-12 * self.circumscribed_radius_m**2
        return bool((cross(self._vertices, ends) >= -slack).all())

    @cached_property
    def planning_vertices(self) -> FloatArray:
        """Corners of the outline that planners use, ``(n, 2)``, counter-clockwise, read-only.

        The body itself if it is star-shaped about the reference point, otherwise its convex
        hull: a region seen from one place is star-shaped, and so must be a body inside it.
        """
        if self.is_star_shaped:
            return self._vertices
        hull = convex_hull(self._vertices)
        hull.setflags(write=False)
        return hull

    @cached_property
    def convex_pieces(self) -> tuple[FloatArray, ...]:
        """Convex polygons, ``(n, 2)`` counter-clockwise, that partition the body."""
        if self.is_convex:
            return (self._vertices,)
        return tuple(self._vertices[piece] for piece in convex_partition(self._vertices))

    def placed(self, configuration: Sequence[float]) -> Polygon:
        """Return the body at a configuration.

        Parameters
        ----------
        configuration : (x, y, heading)
            Metres and radians.

        Returns
        -------
        Polygon
            In the frame of the configuration.

        Raises
        ------
        InvalidInputError
            If the configuration is not three finite numbers.

        Examples
        --------
        >>> Footprint.box(2.0, 1.0).placed((5.0, 5.0, 0.0)).bounds
        (4.0, 4.5, 6.0, 5.5)
        """
        return Polygon(self._at(self._vertices, checked_configuration(configuration)))

    def swept(self, start: Sequence[float], end: Sequence[float]) -> Polygon | MultiPolygon:
        """Return the area that the body sweeps on a straight line with constant heading.

        Parameters
        ----------
        start, end : (x, y, heading)
            First and last configuration in metres and radians.

        Returns
        -------
        Polygon or MultiPolygon
            Exact for polygons; for a disc, the area swept by its circumscribed polygon.

        Raises
        ------
        InvalidInputError
            If a configuration is not three finite numbers, or the headings differ (those of a
            disc may).

        Examples
        --------
        >>> Footprint.box(2.0, 1.0).swept((0.0, 0.0, 0.0), (3.0, 0.0, 0.0)).bounds
        (-1.0, -0.5, 4.0, 0.5)
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

    def outline_at(self, configuration: Configuration) -> FloatArray | None:
        """Return the corners of the body at a configuration, for `LaserScan.covered`.

        Those of a disc are the corners of a polygon around it, which reaches beyond it by 0.03 % of
        its radius.

        Parameters
        ----------
        configuration : Configuration
            Metres and radians.

        Returns
        -------
        (n, 2) array or None
            Counter-clockwise, in the frame of the configuration; None for a body that is not
            star-shaped about its reference point.

        Examples
        --------
        >>> Footprint.box(2.0, 1.0).outline_at(Configuration(5.0, 5.0, 0.0)).max(axis=0).tolist()
        [6.0, 5.5]
        """
        return self._at(self._vertices, configuration) if self.is_star_shaped else None

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

    def __reduce__(self) -> tuple[Callable[[str], Footprint], tuple[str]]:
        return Footprint.parse, (self._text,)


@lru_cache(maxsize=MAX_PARSED)
def _parsed(text: str) -> Footprint:
    # Footprints are immutable, and the robots of a team mostly have the same.
    form, colon, numbers = text.strip().partition(":")
    readers: dict[str, Callable[[str], Footprint]] = {
        "disc": lambda words: Footprint.disc(float(words)),
        "box": lambda words: Footprint.box(*_pair(words, "x")),
        "polygon": lambda words: Footprint.polygon([_pair(word, ",") for word in words.split()]),
    }
    if not colon or form.strip() not in readers:
        raise InvalidInputError(f"footprint {shown(text)} is not known; {FORMS}")
    try:
        return readers[form.strip()](numbers)
    except InvalidInputError as problem:
        raise InvalidInputError(f"footprint {shown(text)}: {problem}") from None
    except ValueError:
        raise InvalidInputError(f"footprint {shown(text)} cannot be read; {FORMS}") from None


def checked_configuration(configuration: Sequence[float]) -> Configuration:
    """Return three numbers as a configuration.

    Parameters
    ----------
    configuration : (x, y, heading)
        Metres and radians.

    Returns
    -------
    Configuration

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
    """Check that the heading of a body is constant from start to end; that of a disc may differ.

    Parameters
    ----------
    footprint : Footprint
        The body.
    start, end : Configuration
        First and last configuration in metres and radians.

    Raises
    ------
    InvalidInputError
        If the headings differ by more than `HEADING_TOLERANCE_RAD`.
    """
    turn = math.remainder(end[2] - start[2], 2.0 * math.pi)
    if not footprint.is_disc and abs(turn) > HEADING_TOLERANCE_RAD:
        raise InvalidInputError(
            f"straight motion of {footprint} from heading {start[2]:g} to {end[2]:g} rad: "
            "the heading of a straight motion is constant; turn first, or check the motion as "
            "one that turns"
        )


def place(points: FloatArray, x: float, y: float, heading: float) -> FloatArray:
    """Return points turned about the origin by a heading and then moved by ``(x, y)``.

    Parameters
    ----------
    points : (n, 2) array
        Points in metres.
    x, y, heading : float
        Metres and radians.

    Returns
    -------
    (n, 2) array

    Examples
    --------
    >>> place(np.array([(1.0, 0.0)]), 2.0, 3.0, math.pi / 2).tolist()
    [[2.0, 4.0]]
    """
    c, s = math.cos(heading), math.sin(heading)
    placed: FloatArray = libm.product(points, np.array([[c, s], [-s, c]])) + np.array([x, y])
    return placed


def _size(value: float, name: str, parts: float) -> float:
    # Check a length, of which 1 / parts lies on one side of the reference point.
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
    # A number as text that reads back exactly, without a fraction if it is whole.
    return repr(value).removesuffix(".0")
