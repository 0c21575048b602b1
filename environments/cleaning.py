"""Repairs of free space, and what they changed: rings, overlaps, specks, gaps and vertices.

Every step returns its result and a `Cleaning`; the cleaning of several steps is their sum.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Final, TypeVar

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import GeometryType, MultiPolygon, Polygon
from shapely.geometry.base import BaseGeometry

from multisrt.geometry.errors import InvalidInputError, counted
from multisrt.geometry.numerics.arrays import FloatArray

GeometryArray = NDArray[np.object_]

Geometry = TypeVar("Geometry", bound=BaseGeometry)

COLLINEAR_M: Final = 1e-6
"""Vertices at most this far from the line between their neighbours are superfluous, in metres."""

MIN_TOLERANCE_SHARE: Final = 1e-3
"""Share of the tolerance below which it is not reduced further."""

ARC_SEGMENTS: Final = 16
"""Segments of a quarter of a circle in the arcs of dilated and eroded areas."""

ROUNDING_M: Final = 1e-6
"""Lengths that differ by at most this count as equal, in metres.

Gaps are closed if they are narrower than the stated width by more than this, and specks dropped if
they are larger than the stated size by at most this.
"""

ZERO_M: Final = 1e-100
"""Coordinates whose absolute value is below this are 0, in metres."""

FIXING: Final = "'multisrt environments check FILE --fix OUT' writes a repaired copy"
"""Remedy that errors about rings suggest."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Cleaning:
    """Changes made to a map when it was read or repaired.

    Attributes
    ----------
    closed_rings : int
        Number of open rings that were closed by repeating their first position.
    repaired_polygons : int
        Number of polygons whose rings crossed or touched themselves or one another.
    repaired_m2 : float
        Area in square metres in which the repaired polygons differ from their rings filled by the
        even-odd rule.
    united_polygons : int
        Number of polygons of free space that overlapped others.
    united_m2 : float
        Area of their overlaps in square metres; where n polygons overlap it counts n - 1 times.
    dropped_parts, dropped_obstacles : int
        Numbers of parts of free space and of obstacles that were dropped as too small.
    dropped_m2 : float
        Their area in square metres.
    closed_gaps : int
        Number of gaps between obstacles that were closed.
    closed_m2 : float
        Their area in square metres.
    removed_vertices : int
        Number of vertices that were removed as repeated or superfluous.
    removed_starts : int
        Number of suggested starts that are not in free space.
    displacement_m : float
        Largest distance in metres from a removed vertex to the boundary without it.
    straightened_m : float
        Upper bound, in metres, of the distance between the walls and the borders of the cells of
        a grid or an image.
    notes : tuple of str
        What else a reader left out of the file, or found in it that was probably not meant.

    Examples
    --------
    >>> done = Cleaning(closed_rings=1) + Cleaning(dropped_obstacles=2, dropped_m2=0.001)
    >>> print(done)
    1 open ring closed; 2 obstacles dropped as too small (0.001 m2)
    >>> bool(done), bool(Cleaning())
    (True, False)
    """

    closed_rings: int = 0
    repaired_polygons: int = 0
    repaired_m2: float = 0.0
    united_polygons: int = 0
    united_m2: float = 0.0
    dropped_parts: int = 0
    dropped_obstacles: int = 0
    dropped_m2: float = 0.0
    closed_gaps: int = 0
    closed_m2: float = 0.0
    removed_vertices: int = 0
    removed_starts: int = 0
    displacement_m: float = 0.0
    straightened_m: float = 0.0
    notes: tuple[str, ...] = ()

    def __bool__(self) -> bool:
        """Return whether anything was changed."""
        return self != Cleaning()

    def __add__(self, other: Cleaning) -> Cleaning:
        """Return the changes of both: distances are added, too, and notes joined."""
        summed = {
            field.name: getattr(self, field.name) + getattr(other, field.name)
            for field in fields(self)
        }
        return Cleaning(**summed)

    def __str__(self) -> str:
        """Return what was changed as text on one line; empty if nothing was."""
        dropped = " and ".join(
            counted(number, one, several)
            for number, one, several in (
                (self.dropped_parts, "part of free space", "parts of free space"),
                (self.dropped_obstacles, "obstacle", "obstacles"),
            )
            if number
        )
        moved = f", moved by up to {_metres(self.displacement_m)}" if self.displacement_m else ""
        said = (
            (self.straightened_m, f"walls straightened within {_metres(self.straightened_m)}"),
            (self.closed_rings, f"{counted(self.closed_rings, 'open ring')} closed"),
            (
                self.repaired_polygons,
                f"{counted(self.repaired_polygons, 'polygon')} repaired that crossed "
                f"{'itself' if self.repaired_polygons == 1 else 'themselves'} "
                f"({_area(self.repaired_m2)} changed)",
            ),
            (
                self.united_polygons,
                f"{self.united_polygons} overlapping polygons united ({_area(self.united_m2)})",
            ),
            (dropped, f"{dropped} dropped as too small ({_area(self.dropped_m2)})"),
            (
                self.closed_gaps,
                f"{counted(self.closed_gaps, 'narrow gap')} closed ({_area(self.closed_m2)})",
            ),
            (
                self.removed_vertices,
                f"{counted(self.removed_vertices, 'vertex', 'vertices')} removed{moved}",
            ),
            (
                self.removed_starts,
                f"{counted(self.removed_starts, 'suggested start')} removed as not in free space",
            ),
        )
        return "; ".join([*self.notes, *(text for happened, text in said if happened)])


@dataclass(frozen=True, slots=True, kw_only=True)
class CleaningOptions:
    """What is removed from free space, apart from the repair of its rings.

    Attributes
    ----------
    speck_m : float
        Parts of free space and obstacles are dropped if the longer side of their bounding box is
        at most this, in metres, but for rounding (`ROUNDING_M`).
    gap_m : float
        Passages between obstacles that are narrower than this are closed, in metres.
    tolerance_m : float
        Vertices are removed if they are at most this far from the boundary without them, in
        metres.

    Raises
    ------
    InvalidInputError
        If a length is negative or not finite.
    """

    speck_m: float = 0.0
    gap_m: float = 0.0
    tolerance_m: float = 0.0

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            if not (math.isfinite(value) and value >= 0.0):
                raise InvalidInputError(
                    f"{field.name} is {value:g}; it must be a length in metres, at least 0"
                )


def closed_ring(
    positions: Sequence[tuple[float, float]],
) -> tuple[list[tuple[float, float]], Cleaning]:
    """Return the positions of a ring with the first one repeated at the end.

    Parameters
    ----------
    positions : sequence of (x, y)
        The positions in metres, at least one.

    Returns
    -------
    positions : list of (x, y)
        The closed ring.
    cleaning : Cleaning
        What was changed.

    Examples
    --------
    >>> closed_ring([(0, 0), (4, 0), (4, 3)])[0]
    [(0, 0), (4, 0), (4, 3), (0, 0)]
    """
    if positions[0] == positions[-1]:
        return list(positions), Cleaning()
    return [*positions, positions[0]], Cleaning(closed_rings=1)


def flushed(points: FloatArray) -> FloatArray:
    """Return coordinates of which those nearer to 0 than `ZERO_M` are 0.

    Quotients of the smallest numbers overflow in overlays.

    Parameters
    ----------
    points : float array
        Coordinates in metres.

    Returns
    -------
    float array
        The array itself if there are none.

    Examples
    --------
    >>> flushed(np.array([5e-324, -1e-200, 1e-9, 3.0])).tolist()
    [0.0, 0.0, 1e-09, 3.0]
    """
    tiny = (np.abs(points) < ZERO_M) & (points != 0.0)
    return np.where(tiny, 0.0, points) if tiny.any() else points


def without_denormals(geometry: Geometry) -> Geometry:
    """Return a geometry of which coordinates nearer to 0 than `ZERO_M` are 0; see `flushed`.

    Parameters
    ----------
    geometry : Geometry
        A geometry in metres.

    Returns
    -------
    Geometry
        The geometry itself if there are none.

    Examples
    --------
    >>> without_denormals(shapely.box(5e-324, 0, 2, 1)).bounds
    (0.0, 0.0, 2.0, 1.0)
    """
    points = shapely.get_coordinates(geometry)
    clear = flushed(points)
    if clear is points:
        return geometry
    moved: Geometry = shapely.set_coordinates(shapely.force_2d(geometry), clear)
    return moved


def repaired(polygon: Polygon) -> tuple[BaseGeometry, Cleaning]:
    """Return a valid polygon, with the loops of its rings united and holes cut out.

    Parameters
    ----------
    polygon : Polygon
        The polygon, in metres, with finite coordinates.

    Returns
    -------
    geometry : Polygon or MultiPolygon
        The polygon itself if it is valid; empty if it has no area.
    cleaning : Cleaning
        What was changed.

    Examples
    --------
    Two triangles of 1 m2, drawn as a bow tie in one ring:

    >>> bow = Polygon([(0, 0), (2, 2), (2, 0), (0, 2)])
    >>> tie, cleaning = repaired(bow)
    >>> tie.area, str(cleaning)
    (2.0, '1 polygon repaired that crossed itself (0 m2 changed)')

    Notes
    -----
    Source: GEOS, MakeValid with the method "structure".
    """
    polygon = without_denormals(polygon)
    if polygon.is_valid:
        return polygon, Cleaning()
    valid = areas(shapely.make_valid(polygon, method="structure", keep_collapsed=False))
    changed = float(valid.symmetric_difference(_even_odd(polygon)).area)
    return valid, Cleaning(repaired_polygons=1, repaired_m2=changed)


def _even_odd(polygon: Polygon) -> BaseGeometry:
    """Return the area of the rings of a polygon by the even-odd rule.

    Not by one call of make_valid, which counts an edge that two rings share only once.
    """
    rings = np.asarray(shapely.get_rings(polygon), np.object_)
    lines = shapely.union_all([shapely.LineString(ring.coords) for ring in rings])
    faces = shapely.get_parts(shapely.polygonize(shapely.get_parts(lines)))
    filled = np.asarray(shapely.make_valid(shapely.polygons(rings), method="linework"), np.object_)
    inside, _ = shapely.STRtree(filled).query(shapely.point_on_surface(faces), predicate="within")
    odd = np.bincount(inside, minlength=len(faces)) % 2 == 1
    return shapely.union_all(faces[odd])


def united(polygons: Sequence[BaseGeometry]) -> tuple[BaseGeometry, Cleaning]:
    """Return the union of polygons, and how many of them overlapped others.

    Parameters
    ----------
    polygons : sequence of Polygon or MultiPolygon
        Valid polygons. Those that only touch do not overlap.

    Returns
    -------
    union : Polygon or MultiPolygon
        Their union.
    cleaning : Cleaning
        How many overlapped, and the area of the overlaps.

    Examples
    --------
    >>> rooms = [shapely.box(0, 0, 3, 2), shapely.box(2, 0, 5, 2), shapely.box(5, 0, 6, 2)]
    >>> space, cleaning = united(rooms)
    >>> space.area, str(cleaning)
    (12.0, '2 overlapping polygons united (2 m2)')
    """
    union = shapely.union_all(polygons)
    if len(polygons) < 2:
        return union, Cleaning()
    shapes = np.asarray(polygons, np.object_)
    first, second = shapely.STRtree(shapes).query(shapes, predicate="intersects")
    once = first < second
    first, second = first[once], second[once]
    overlaps = shapely.relate_pattern(shapes[first], shapes[second], "T********")
    involved = np.union1d(first[overlaps], second[overlaps])
    if not involved.size:
        return union, Cleaning()
    twice = shapely.area(shapes[involved]).sum() - shapely.union_all(shapes[involved]).area
    return union, Cleaning(united_polygons=len(involved), united_m2=max(0.0, float(twice)))


def areas(geometry: BaseGeometry) -> MultiPolygon:
    """Return the polygons of a geometry, without its points and lines."""
    return MultiPolygon(list(polygons_of(geometry)))


def polygons_of(geometry: BaseGeometry) -> GeometryArray:
    """Return the polygons of a geometry, which may be a collection of several kinds."""
    parts = shapely.get_parts(shapely.get_parts(geometry))
    polygons: GeometryArray = parts[
        (shapely.get_type_id(parts) == GeometryType.POLYGON) & ~shapely.is_empty(parts)
    ]
    return polygons


def without_slivers(parts: GeometryArray, width_m: float) -> tuple[MultiPolygon, Cleaning]:
    """Return polygons without those polygons and holes that are nowhere as wide as stated.

    Parameters
    ----------
    parts : array of Polygon
        Valid polygons that do not overlap.
    width_m : float
        The width in metres.

    Returns
    -------
    polygons : MultiPolygon
        The remaining polygons; it may be empty.
    cleaning : Cleaning
        What was dropped.

    Examples
    --------
    >>> hall = shapely.box(0, 0, 4, 3) - shapely.box(1, 1, 1.0004, 2)
    >>> space, cleaning = without_slivers(np.array([hall]), 1e-3)
    >>> len(space.geoms[0].interiors), str(cleaning)
    (0, '1 obstacle dropped as too small (0.0004 m2)')
    """
    thin = _are_slivers(parts, width_m)
    kept = parts[~thin]
    holed = np.flatnonzero(shapely.get_num_interior_rings(kept))
    rings, owner = shapely.get_rings(kept[holed], return_index=True)
    # The first ring of each polygon is its outline.
    is_hole = np.zeros(len(rings), np.bool_)
    is_hole[1:] = owner[1:] == owner[:-1]
    holes = np.asarray(shapely.polygons(rings[is_hole]), np.object_)
    thin_holes = _are_slivers(holes, width_m)
    stays = np.ones(len(rings), np.bool_)
    stays[np.flatnonzero(is_hole)[thin_holes]] = False
    for number in np.unique(owner[~stays]):
        shell, *inner = rings[(owner == number) & stays]
        kept[holed[number]] = Polygon(shell, inner)
    return MultiPolygon(list(kept)), Cleaning(
        dropped_parts=int(thin.sum()),
        dropped_obstacles=int(thin_holes.sum()),
        dropped_m2=float(shapely.area(parts[thin]).sum() + shapely.area(holes[thin_holes]).sum()),
    )


def _are_slivers(parts: GeometryArray, width_m: float) -> NDArray[np.bool_]:
    # An erosion removes at most a strip along the boundary and a sector at each hole. A part with
    # more area than that is no sliver, and need not be eroded.
    radius = width_m / 2
    holes = shapely.get_num_interior_rings(parts)
    thin: NDArray[np.bool_] = (
        shapely.area(parts) <= radius * shapely.length(parts) + holes * math.pi * radius**2
    )
    thin[thin] = shapely.is_empty(shapely.buffer(parts[thin], -radius))
    return thin


def cleaned(free: BaseGeometry, options: CleaningOptions) -> tuple[MultiPolygon, Cleaning]:
    """Return free space without narrow gaps, specks and superfluous vertices.

    Parameters
    ----------
    free : Polygon or MultiPolygon
        Valid free space, in metres.
    options : CleaningOptions
        What is removed. Repeated and collinear vertices always are.

    Returns
    -------
    free : MultiPolygon
        Valid free space; it may be empty.
    cleaning : Cleaning
        What was changed.

    Examples
    --------
    >>> walls = [shapely.box(4, 0, 5, 1.8), shapely.box(4, 2, 5, 4), shapely.box(1, 1, 1.02, 1.03)]
    >>> hall = shapely.box(0, 0, 9, 4) - shapely.union_all(walls)
    >>> space, cleaning = cleaned(hall, CleaningOptions(speck_m=0.05, gap_m=0.3))
    >>> len(space.geoms), cleaning.closed_gaps, round(cleaning.closed_m2, 2)
    (2, 1, 0.19)
    >>> cleaning.dropped_obstacles
    1
    """
    space, gaps = _without_gaps(areas(free), options.gap_m)
    space, specks = _without_specks(space, options.speck_m)
    space, vertices = _without_vertices(space, options.tolerance_m)
    return space, gaps + specks + vertices


def _without_gaps(free: MultiPolygon, gap_m: float) -> tuple[MultiPolygon, Cleaning]:
    """Close the places that no disc of the width covers and that separate places that it does."""
    radius = gap_m / 2.0 - ROUNDING_M
    if radius <= 0.0:
        return free, Cleaning()
    eroded = polygons_of(shapely.buffer(free, -radius, quad_segs=ARC_SEGMENTS))
    roomy = shapely.buffer(eroded, radius, quad_segs=ARC_SEGMENTS)
    narrow = polygons_of(free.difference(shapely.buffer(shapely.union_all(roomy), ROUNDING_M)))
    # A corner or a nook has one border with roomy space, a gap two or more.
    walls = shapely.buffer(free.boundary, 2.0 * ROUNDING_M, quad_segs=1)
    mouths = shapely.difference(shapely.boundary(narrow), walls)
    is_gap = np.array([_number_of_lines(mouth) > 1 for mouth in mouths], np.bool_)
    is_gap &= shapely.area(narrow) > ROUNDING_M * gap_m
    # In a thin wall discs from both sides meet in the gap, and leave only cracks beside it.
    tree = shapely.STRtree(roomy)
    meets, other = tree.query(roomy, "intersects")
    lenses = shapely.intersection(roomy[meets], roomy[other])[meets < other]
    beside, _ = tree.query(narrow, "dwithin", 2.0 * ROUNDING_M)
    is_gap |= np.bincount(beside, minlength=len(narrow)) > 1
    found = shapely.union_all([*narrow[is_gap], *lenses])
    if found.is_empty:
        return free, Cleaning()
    # Dilated a little, so that no crack of free space remains beside them.
    closed = shapely.buffer(found, 4.0 * ROUNDING_M, join_style="mitre")
    space = areas(free.difference(closed))
    return space, Cleaning(
        closed_gaps=len(polygons_of(closed)), closed_m2=float(free.area) - float(space.area)
    )


def _number_of_lines(geometry: BaseGeometry) -> int:
    return len(shapely.get_parts(shapely.line_merge(geometry)))


def _without_specks(free: MultiPolygon, speck_m: float) -> tuple[MultiPolygon, Cleaning]:
    """Drop parts and holes with a small bounding box."""
    if speck_m == 0.0:
        return free, Cleaning()
    largest = speck_m + ROUNDING_M
    parts = polygons_of(free)
    large = _extents(parts) > largest
    kept, obstacles, area = [], 0, float(shapely.area(parts[~large]).sum())
    for part in parts[large]:
        holes = np.asarray(part.interiors, np.object_)
        stays = _extents(holes) > largest
        dropped = shapely.area(shapely.polygons(holes[~stays])).sum() if len(holes) else 0.0
        area += float(dropped)
        obstacles += int((~stays).sum())
        kept.append(Polygon(part.exterior, holes[stays].tolist()) if (~stays).any() else part)
    return MultiPolygon(kept), Cleaning(
        dropped_parts=int((~large).sum()), dropped_obstacles=obstacles, dropped_m2=area
    )


def _extents(shapes: GeometryArray) -> NDArray[np.float64]:
    bounds = shapely.bounds(shapes).reshape(-1, 4)
    extents: NDArray[np.float64] = (bounds[:, 2:] - bounds[:, :2]).max(axis=1, initial=0.0)
    return extents


def _without_vertices(free: MultiPolygon, tolerance_m: float) -> tuple[MultiPolygon, Cleaning]:
    """Remove vertices of the boundary, such that it keeps its topology."""
    before = shapely.get_coordinates(free)
    bound, share = max(tolerance_m, COLLINEAR_M), 1.0
    while True:
        simple = _simplified(free, share * bound)
        boundary = simple.boundary
        shapely.prepare(boundary)
        distance = float(shapely.distance(shapely.points(before), boundary).max())
        # At the start of a ring, both simplifications remove vertices: their distances add up.
        if distance <= bound + COLLINEAR_M or share < MIN_TOLERANCE_SHARE:
            break
        share /= 2.0
    after = shapely.get_coordinates(simple)
    if len(after) == len(before):
        return free, Cleaning()
    rings = shapely.get_rings(polygons_of(free)), shapely.get_rings(polygons_of(simple))
    return simple, Cleaning(
        removed_vertices=len(before) - len(rings[0]) - len(after) + len(rings[1]),
        displacement_m=distance if distance > 2.0 * COLLINEAR_M else 0.0,
    )


def _simplified(free: MultiPolygon, tolerance_m: float) -> MultiPolygon:
    simple = shapely.simplify(free, tolerance_m, preserve_topology=True)
    # The first vertex of a ring is never removed: start each ring at another one.
    turned = areas(_with_rings_turned(simple))
    simple = areas(shapely.simplify(turned, COLLINEAR_M, preserve_topology=True))
    if not simple.is_valid:  # rings that a removed vertex left touching
        simple = areas(shapely.make_valid(simple, method="structure", keep_collapsed=False))
    return simple


def _with_rings_turned(free: BaseGeometry) -> BaseGeometry:
    def turned(ring: BaseGeometry) -> NDArray[np.float64]:
        corners = shapely.get_coordinates(ring)[:-1]
        corners = np.roll(corners, len(corners) // 2, axis=0)
        return np.vstack([corners, corners[:1]])

    return MultiPolygon(
        [
            Polygon(turned(part.exterior), [turned(hole) for hole in part.interiors])
            for part in polygons_of(free)
        ]
    )


def _area(square_metres: float) -> str:
    text = f"{square_metres:.3g}" if square_metres < 100.0 else f"{square_metres:,.0f}"
    return f"{text} m2"


def _metres(metres: float) -> str:
    return f"{metres:.3g} m"
