"""Clearance of a part of free space: a tree of widest paths on its medial axis.

The boundary is sampled so densely that the Delaunay triangulation of the samples has all pieces of
the boundary as edges. Its triangles then partition free space, and their circumcentres
approximate its medial axis. The link between two neighbouring triangles has the radius of the
largest disc that passes from one centre to the other. In a maximum spanning tree of these links,
the path between any two places is a widest one, so that the tree determines where a disc of any
radius can go.

Source: D. T. Lee, Medial axis transformation of a planar shape, 1982; T. C. Hu, The maximum
capacity route problem, 1961; differs in: samples of the boundary in place of its segments. The
ends of passages are exact, since they are computed from segments and added to the samples.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np
import shapely
from scipy import sparse
from scipy.sparse import csgraph
from scipy.spatial import Delaunay, cKDTree
from shapely import Polygon

from multisrt.geometry.numerics import libm
from multisrt.geometry.numerics.kernel import BoolArray, FloatArray, IntArray, kernel

SPACING_M: Final = 0.05
"""Upper bound of the distance between neighbouring samples, in metres."""

SPACING_SHARE: Final = 1.0 / 400.0
"""Upper bound of that distance as a share of the side of a square with the area of the part."""

MAX_SAMPLES: Final = 400_000
"""Number of samples above which they are spaced more widely."""

MAX_EVEN: Final = 10_000
"""Number of samples above which they are spaced widely at first where free space is wide, and more
closely where a piece of the boundary is not much shorter than free space is wide beside it: a
triangulation of points along long walls takes time that grows with the square of their number."""

WIDE_SHARE: Final = 1.0 / 200.0
"""That wide spacing as a share of the area over the length of the boundary."""

LARGE_SINE: Final = 1.0 / 32.0
"""A piece is long where a triangle beside it sees it at an angle with a larger sine."""

MIN_SPACING_SHARE: Final = 1.0 / 4.0
"""Pieces of the boundary near other samples are halved down to this share of the spacing."""

MIN_PIECE_SHARE: Final = 1.0 / 64.0
"""Pieces of the boundary that are not edges are halved down to this share of the spacing."""

CROWDED_ROUNDS: Final = 2
"""Upper bound of the rounds in which pieces of the boundary are halved near other samples."""

MAX_ROUNDS: Final = 8
"""Upper bound of the rounds in which pieces of the boundary are halved."""

FLAT: Final = 1e-9
"""Height of a flat triangle, as a share of the side of a square with the area of the part."""

WIDENING: Final = 1.005
"""A passage has places on both sides that are wider by this factor."""

LIMIT_SHARE: Final = 0.01
"""A passage limits the largest body if at least this share of free space is behind it."""

CORNER_SHARE: Final = 1.05 * (1.0 - math.pi / 4.0)
"""Area that a disc leaves in a right-angled corner, in squares of its radius, plus 5 %."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Passage:
    """A place at which free space is narrower than on both sides.

    Attributes
    ----------
    ends : ((x, y), (x, y))
        The two places on the boundary between which it is narrowest, in metres.
    beyond_m2 : float
        Area of free space on its smaller side, in square metres, which bodies on the larger side
        reach only through this passage or narrower ones.
    """

    ends: tuple[tuple[float, float], tuple[float, float]]
    beyond_m2: float

    @property
    def width_m(self) -> float:
        """Distance between the ends in metres: discs pass up to half of it in radius."""
        return math.dist(*self.ends)

    @property
    def centre(self) -> tuple[float, float]:
        """The point midway between the ends, in metres."""
        (x0, y0), (x1, y1) = self.ends
        return (x0 + x1) / 2.0, (y0 + y1) / 2.0


@dataclass(frozen=True, slots=True, kw_only=True)
class LargestBody:
    """The largest disc that reaches nearly everything; see `ClearanceTree.largest_body`.

    Attributes
    ----------
    radius_m : float
        Its radius in metres.
    limit : Passage or None
        The passage that larger discs do not pass; None if free space narrows gradually, so that
        no single passage limits the disc.
    """

    radius_m: float
    limit: Passage | None


@dataclass(frozen=True, eq=False)
class ClearanceTree:
    """The tree of widest paths in a connected part of free space.

    Nodes are triangles, and links join neighbours; see the module's documentation.

    Attributes
    ----------
    part : Polygon
        The part of free space.
    centres : (n, 2) array
        Centres of the triangles' circles, in metres.
    radii : (n,) array
        Their radii: the clearances of the centres.
    areas : (n,) array
        Areas of the triangles, in square metres.
    links : (n - 1, 2) array of int
        The links of the tree as pairs of triangles, by decreasing clearance.
    clearances : (n - 1,) array
        Radius of the largest disc that passes each link, in metres.
    ends : (n - 1, 2, 2) array
        Ends of the edge that the triangles of each link share, in metres.
    peaks : (n - 1,) array
        For each link, the smaller of the largest clearances on its two sides, in metres.
    """

    part: Polygon
    centres: FloatArray
    radii: FloatArray
    areas: FloatArray
    links: IntArray
    clearances: FloatArray
    ends: FloatArray
    peaks: FloatArray

    @cached_property
    def beyond_m2(self) -> FloatArray:
        """Area on the smaller side of each link, in square metres."""
        count = len(self.areas)
        order, parent = csgraph.breadth_first_order(
            _graph(self.links, count), 0, directed=False, return_predecessors=True
        )
        below = _sums_of_subtrees(order.astype(np.int64), parent.astype(np.int64), self.areas)
        first, second = self.links.T
        child = np.where(parent[second] == first, second, first)
        side = below[child]
        smaller: FloatArray = np.minimum(side, self.areas.sum() - side)
        return smaller

    def passages(self, min_beyond_m2: float, *, apart_m: float = 0.0) -> tuple[Passage, ...]:
        """Return the passages that cut off something, the narrowest first.

        A passage between two places that a wider path joins is none.

        Parameters
        ----------
        min_beyond_m2 : float
            Least area on the smaller side of a passage, in square metres.
        apart_m : float, optional
            A passage nearer than this to a narrower one is left out if the area between them is
            below the least area, as they then separate the same places. A gap between rough walls
            is narrow at many places.

        Returns
        -------
        tuple of Passage
            Empty if free space is nowhere narrower than on both sides.

        Examples
        --------
        Two rooms of 4 x 4 m with a door of 0.8 m:

        >>> wall = shapely.box(4, 0, 4.2, 1) | shapely.box(4, 1.8, 4.2, 4)
        >>> (door,) = clearance_tree(shapely.box(0, 0, 8.2, 4) - wall).passages(1.0)
        >>> round(door.width_m, 6), round(door.beyond_m2, 1)
        (0.8, 16.1)
        """
        links = self._narrow_links(min_beyond_m2)
        found = {int(link): self._passage(int(link)) for link in links}
        order = sorted(found, key=lambda link: (found[link].width_m, found[link].centre))
        if apart_m > 0.0 and len(order) > 1:
            order = self._merged(found, order, apart_m, min_beyond_m2)
        return tuple(found[link] for link in order)

    def _merged(
        self, found: dict[int, Passage], order: list[int], apart_m: float, min_between_m2: float
    ) -> list[int]:
        """Return those of some links that are not too near a narrower one between the same places.

        The links cut free space into areas, which they join to a tree.
        """
        links, centres = np.array(order), [found[link].centre for link in order]
        near = cKDTree(centres).query_ball_point(centres, apart_m)
        _, area = csgraph.connected_components(
            _graph(np.delete(self.links, links, axis=0), len(self.areas)), directed=False
        )
        areas_m2: FloatArray = np.bincount(area, weights=self.areas).astype(np.float64)
        joints = area[self.links[links]]
        kept: list[int] = []
        for number, others in enumerate(near):
            if not any(
                other in kept and _between_m2(joints, areas_m2, number, other) < min_between_m2
                for other in others
            ):
                kept.append(number)
        return [order[number] for number in kept]

    def _narrow_links(self, min_beyond_m2: float) -> IntArray:
        return np.flatnonzero(
            (self.peaks > WIDENING * self.clearances) & (self.beyond_m2 >= min_beyond_m2)
        )

    def _passage(self, link: int) -> Passage:
        (x0, y0), (x1, y1) = self.ends[link].tolist()
        return Passage(ends=((x0, y0), (x1, y1)), beyond_m2=float(self.beyond_m2[link]))

    def reached_share(self, radius_m: float) -> float:
        """Return the share of free space that a disc reaches from its best place.

        The remainders in corners of 90 degrees or more count as reached.

        Parameters
        ----------
        radius_m : float
            Radius of the disc, in metres.
        """
        return self._share_by_links(int(np.count_nonzero(self.clearances >= radius_m)), radius_m)

    def largest_body(self, share: float) -> LargestBody:
        """Return the largest disc that reaches a given share of free space.

        Parameters
        ----------
        share : float
            Share of the area that the disc reaches from its best place, from 0 to 1. The remainders
            in corners of 90 degrees or more count as reached.

        Returns
        -------
        LargestBody
            Its radius is exact if a passage limits it, else accurate to about 0.1 %.

        Examples
        --------
        >>> wall = shapely.box(4, 0, 4.2, 1) | shapely.box(4, 1.8, 4.2, 4)
        >>> largest = clearance_tree(shapely.box(0, 0, 8.2, 4) - wall).largest_body(0.9)
        >>> round(largest.radius_m, 6), largest.limit is not None
        (0.4, True)
        """
        if not len(self.links):
            return LargestBody(radius_m=float(self.radii.max()), limit=None)
        # The largest disc just passes some link: bisect over the links.
        low, high = 0, len(self.clearances) - 1
        while low < high:
            middle = (low + high) // 2
            if self._share_by_links(middle + 1, float(self.clearances[middle])) >= share:
                high = middle
            else:
                low = middle + 1
        radius = float(self.clearances[low])
        equal = np.isclose(self.clearances, radius, rtol=1e-9, atol=0.0)
        matters = self.beyond_m2 >= LIMIT_SHARE * self.areas.sum()
        doors = np.flatnonzero(equal & matters & (self.peaks > WIDENING * self.clearances))
        if not doors.size:
            return LargestBody(radius_m=radius, limit=None)
        door = doors[np.argmax(self.beyond_m2[doors])]
        return LargestBody(radius_m=radius, limit=self._passage(int(door)))

    def _share_by_links(self, passed: int, radius_m: float) -> float:
        # Share that a disc reaches if it passes the first `passed` links.
        count, total = len(self.areas), float(self.areas.sum())
        if self.radii.max() < radius_m:
            return 0.0
        _, joined = csgraph.connected_components(_graph(self.links[:passed], count), directed=False)
        sizes = np.bincount(joined, weights=self.areas)
        sizes[joined[self.radii < radius_m]] = 0.0  # single triangles that are too narrow
        reached = joined == np.argmax(sizes)
        # Around it are pockets, each behind one link.
        first, second = self.links.T
        outer = ~(reached[first] | reached[second])
        mouths = np.flatnonzero(reached[first] != reached[second])
        _, pocket = csgraph.connected_components(_graph(self.links[outer], count), directed=False)
        pocket_m2 = np.bincount(pocket, weights=self.areas)
        inner = np.where(reached[first[mouths]], second[mouths], first[mouths])
        left = pocket_m2[pocket[inner]] - self._bulges(mouths, radius_m)
        left = left[left > CORNER_SHARE * radius_m**2]
        return 1.0 - float(left.sum()) / total

    def _bulges(self, links: IntArray, radius_m: float) -> FloatArray:
        # Area of each pocket that the disc covers: the circular segment on its mouth as chord.
        along = self.ends[links, 1] - self.ends[links, 0]
        half = np.minimum(1.0, np.hypot(*along.T) / (2.0 * radius_m))
        angle = 2.0 * libm.arcsin(half)
        bulges: FloatArray = 0.5 * radius_m**2 * (angle - libm.sin(angle))
        return bulges


def _between_m2(joints: IntArray, areas_m2: FloatArray, one: int, other: int) -> float:
    # The area between two links of a tree of areas, with all that it leads to.
    rest = np.delete(joints, [one, other], axis=0)
    _, side = csgraph.connected_components(_graph(rest, len(areas_m2)), directed=False)
    (middle,) = np.intersect1d(side[joints[one]], side[joints[other]])
    return float(areas_m2[side == middle].sum())


def clearance_tree(part: Polygon) -> ClearanceTree:
    """Return the tree of widest paths in a connected part of free space.

    Parameters
    ----------
    part : Polygon
        The part, in metres: one of `Environment.components`.

    Returns
    -------
    ClearanceTree
        The tree.

    Examples
    --------
    >>> corridor = clearance_tree(shapely.box(0, 0, 6, 1))
    >>> round(float(corridor.radii.max()), 2), round(float(corridor.areas.sum()), 6)
    (0.5, 6.0)
    """
    rings, scale = _rings(part), math.sqrt(part.area)
    tree = _tree_of(part, rings, scale, crowded_rounds=0)
    # Once more with the exact ends of passages among the samples.
    links = np.flatnonzero(
        (tree.peaks > WIDENING * tree.clearances) & (tree.beyond_m2 > 1e-4 * part.area)
    )
    if not links.size:
        return tree
    exact = _with_exact_ends(rings, tree.ends[links], 1.5 * _spacing(part, scale))
    return _tree_of(part, exact, scale, crowded_rounds=CROWDED_ROUNDS)


def _tree_of(
    part: Polygon, rings: list[FloatArray], scale: float, *, crowded_rounds: int
) -> ClearanceTree:
    spacing_m = _spacing(part, scale)
    wide_m = WIDE_SHARE * part.area / part.length
    if wide_m > spacing_m and part.length > MAX_EVEN * spacing_m:
        samples, after = _graded(*_sampled(rings, wide_m), spacing_m)
    else:
        samples, after = _sampled(rings, spacing_m)
    samples, triangles, neighbours = _triangulated(samples, after, spacing_m, crowded_rounds)
    places = samples[triangles]
    areas = 0.5 * np.abs(_cross(places[:, 1] - places[:, 0], places[:, 2] - places[:, 0]))
    sides = np.hypot(*np.moveaxis(places - np.roll(places, 1, axis=1), -1, 0)).max(axis=1)
    inside = 2.0 * areas > FLAT * scale * sides
    shapely.prepare(part)
    inside[inside] = shapely.contains_xy(part, places[inside].mean(axis=1))
    first, corner = _neighbours(inside, neighbours)
    _, joined = csgraph.connected_components(
        _graph(np.column_stack([first, neighbours[first, corner]]), len(triangles)), directed=False
    )
    # Cracks thinner than the spacing of samples can separate a few triangles from the others.
    inside &= joined == np.argmax(np.bincount(joined, weights=np.where(inside, areas, 0.0)))
    first, corner = _neighbours(inside, neighbours)
    second = neighbours[first, corner]
    ends = np.stack(
        [
            samples[triangles[first, (corner + 1) % 3]],
            samples[triangles[first, (corner + 2) % 3]],
        ],
        axis=1,
    )
    numbers = np.cumsum(inside) - 1
    centres, radii = _circles(places[inside])
    first, second = numbers[first], numbers[second]
    clearances = _clearances(centres, radii, first, second, ends)
    order = np.argsort(-clearances, kind="stable")
    kept, peaks = _spanning_tree(first[order], second[order], radii)
    chosen = order[kept]
    return ClearanceTree(
        part=part,
        centres=centres,
        radii=radii,
        areas=areas[inside],
        links=np.column_stack([first[chosen], second[chosen]]),
        clearances=clearances[chosen],
        ends=ends[chosen],
        peaks=peaks,
    )


def _neighbours(inside: BoolArray, neighbours: IntArray) -> tuple[IntArray, IntArray]:
    # Each pair of neighbouring triangles once: one of them, and its corner opposite the other.
    later = neighbours > np.arange(len(inside))[:, None]
    first, corner = np.nonzero(inside[:, None] & later & inside[neighbours])
    return first, corner


def _rings(part: Polygon) -> list[FloatArray]:
    # Without the first corner repeated at the end.
    return [shapely.get_coordinates(ring)[:-1] for ring in (part.exterior, *part.interiors)]


def _spacing(part: Polygon, scale: float) -> float:
    return max(min(SPACING_M, SPACING_SHARE * scale), part.length / MAX_SAMPLES)


def _sampled(rings: list[FloatArray], spacing_m: float) -> tuple[FloatArray, IntArray]:
    """Return samples of the rings, and the number of the next sample in the same ring."""
    samples, after, count = [], [], 0
    for ring in rings:
        along = np.roll(ring, -1, axis=0) - ring
        pieces = np.maximum(1, np.ceil(np.hypot(*along.T) / spacing_m)).astype(np.int64)
        edge = np.repeat(np.arange(len(ring)), pieces)
        number = np.arange(len(edge)) - np.repeat(np.cumsum(pieces) - pieces, pieces)
        samples.append(ring[edge] + (number / pieces[edge])[:, None] * along[edge])
        after.append(count + (np.arange(len(edge)) + 1) % len(edge))
        count += len(edge)
    return np.vstack(samples), np.concatenate(after)


def _graded(samples: FloatArray, after: IntArray, spacing_m: float) -> tuple[FloatArray, IntArray]:
    """Return more samples where pieces of the boundary are longer than the spacing, and too long.

    Those are too long that are not edges of a Delaunay triangulation, and those that are seen at a
    large angle.
    """
    while True:
        may = np.hypot(*(samples[after] - samples).T) > (1.0 + FLAT) * spacing_m
        if not may.any():
            return samples, after
        triangles = Delaunay(samples - samples.mean(axis=0)).simplices.astype(np.int64)
        missing, sines, crowded = _seen_from(samples, after, triangles)
        bad = np.flatnonzero(may & (missing | crowded | (sines > LARGE_SINE)))
        if not bad.size:
            return samples, after
        samples, after = _halved(samples, after, bad)


def _triangulated(
    samples: FloatArray, after: IntArray, spacing_m: float, crowded_rounds: int
) -> tuple[FloatArray, IntArray, IntArray]:
    """Return a Delaunay triangulation in which pieces of the boundary are edges.

    Pieces that are not edges are halved, and in the first rounds also those with a sample in their
    diametral circle.
    """
    origin = samples.mean(axis=0)
    for number in range(MAX_ROUNDS):
        found = Delaunay(samples - origin)
        lengths = np.hypot(*(samples[after] - samples).T)
        missing, _, crowded = _seen_from(samples, after, found.simplices.astype(np.int64))
        missing &= lengths > MIN_PIECE_SHARE * spacing_m
        crowded &= lengths > MIN_SPACING_SHARE * spacing_m
        bad = np.flatnonzero(missing | (crowded & (number < crowded_rounds)))
        if not bad.size:
            break
        samples, after = _halved(samples, after, bad)
    return samples, found.simplices.astype(np.int64), found.neighbors.astype(np.int64)


def _halved(samples: FloatArray, after: IntArray, bad: IntArray) -> tuple[FloatArray, IntArray]:
    """Return the samples with one in the middle of each of some pieces."""
    middles = 0.5 * (samples[bad] + samples[after[bad]])
    new = len(samples) + np.arange(len(bad))
    after = np.concatenate([after, after[bad]])
    after[bad] = new
    return np.vstack([samples, middles]), after


def _seen_from(
    samples: FloatArray, after: IntArray, triangles: IntArray
) -> tuple[BoolArray, FloatArray, BoolArray]:
    """Return how pieces of the boundary are seen from the triangles beside them.

    Returns
    -------
    missing : (n,) array of bool
        Pieces that are not edges of triangles.
    sines : (n,) array
        The larger sine of the angles at which the two triangles see a piece.
    crowded : (n,) array of bool
        Pieces that are seen at an obtuse angle: a sample is in their diametral circle.
    """
    count = len(samples)
    # Each triangle's corners, and opposite to each the edge between the other two.
    apex = triangles.ravel()
    a = np.roll(triangles, -1, axis=1).ravel()
    b = np.roll(triangles, -2, axis=1).ravel()
    edges = np.minimum(a, b) * count + np.maximum(a, b)
    here = np.arange(count)
    pieces = np.minimum(here, after) * count + np.maximum(here, after)
    order = np.argsort(pieces)
    at = np.searchsorted(pieces[order], edges)
    at[at == count] = 0
    piece = order[at]
    matches = pieces[piece] == edges
    piece, apex, a, b = piece[matches], apex[matches], a[matches], b[matches]
    to_a, to_b = samples[a] - samples[apex], samples[b] - samples[apex]
    missing = np.ones(count, np.bool_)
    missing[piece] = False
    product, twice = np.hypot(*to_a.T) * np.hypot(*to_b.T), np.abs(_cross(to_a, to_b))
    obtuse = np.einsum("ij,ij->i", to_a, to_b) < -1e-9 * product
    flat = twice <= 1e-9 * np.hypot(*(to_a - to_b).T) ** 2
    crowded, sines = np.zeros(count, np.bool_), np.zeros(count)
    crowded[piece[obtuse & ~flat]] = True
    np.maximum.at(sines, piece[~flat], (twice / product)[~flat])
    return missing, sines, crowded


def _circles(places: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return centres and radii of the circumcircles of triangles."""
    b, c = places[:, 1] - places[:, 0], places[:, 2] - places[:, 0]
    twice = 2.0 * _cross(b, c)
    bb, cc = np.einsum("ij,ij->i", b, b), np.einsum("ij,ij->i", c, c)
    offset = np.column_stack([c[:, 1] * bb - b[:, 1] * cc, b[:, 0] * cc - c[:, 0] * bb])
    offset /= twice[:, None]
    return places[:, 0] + offset, np.hypot(*offset.T)


def _clearances(
    centres: FloatArray, radii: FloatArray, first: IntArray, second: IntArray, ends: FloatArray
) -> FloatArray:
    """Return the smallest clearance on the path between the centres of neighbours.

    The path lies on the bisector of the ends of their common edge: it is narrowest midway between
    these, if it passes there.
    """
    along = ends[:, 1] - ends[:, 0]
    middle = 0.5 * (ends[:, 0] + ends[:, 1])
    one = _cross(along, centres[first] - middle)
    other = _cross(along, centres[second] - middle)
    at_ends = np.minimum(radii[first], radii[second])
    clearances: FloatArray = np.where(one * other <= 0.0, 0.5 * np.hypot(*along.T), at_ends)
    return np.minimum(clearances, at_ends)


def _with_exact_ends(
    rings: list[FloatArray], ends: FloatArray, within_m: float
) -> list[FloatArray]:
    """Return the rings with the ends of passages as corners.

    A passage lies between two edges of the boundary near its ends; their nearest points are its
    exact ends.
    """
    starts = np.vstack(rings)
    stops = np.vstack([np.roll(ring, -1, axis=0) for ring in rings])
    edges = np.asarray(shapely.linestrings(np.stack([starts, stops], axis=1)), np.object_)
    tree = shapely.STRtree(edges)
    inserted: dict[int, list[tuple[float, float]]] = {}
    reach = np.minimum(within_m, 0.25 * np.hypot(*(ends[:, 1] - ends[:, 0]).T))
    for pair, around in zip(ends, reach, strict=True):
        here, there = (tree.query(shapely.Point(end), "dwithin", distance=around) for end in pair)
        if np.intersect1d(here, there).size or not (here.size and there.size):
            continue
        gaps = shapely.distance(edges[here][:, None], edges[there][None, :])
        one, other = np.unravel_index(np.argmin(gaps), gaps.shape)
        chosen = int(here[one]), int(there[other])
        exact = shapely.get_coordinates(shapely.shortest_line(edges[chosen[0]], edges[chosen[1]]))
        for edge, (x, y) in zip(chosen, exact.tolist(), strict=True):
            inserted.setdefault(edge, []).append((x, y))
    return _with_corners(rings, inserted)


def _with_corners(
    rings: list[FloatArray], inserted: dict[int, list[tuple[float, float]]]
) -> list[FloatArray]:
    found, number = [], 0
    for ring in rings:
        corners: list[FloatArray] = []
        for corner, following in zip(ring, np.roll(ring, -1, axis=0), strict=True):
            corners.append(corner[None])
            if number in inserted:
                places = np.unique(np.array(inserted[number]), axis=0)
                far = np.hypot(*(places - corner).T)
                whole = math.dist(corner, following)
                inner = (far > 1e-9 * whole) & (far < (1.0 - 1e-9) * whole)
                corners.append(places[inner][np.argsort(far[inner])])
            number += 1
        found.append(np.vstack(corners))
    return found


def _graph(links: IntArray, count: int) -> sparse.csr_array:
    ones = np.ones(len(links), np.int8)
    return sparse.csr_array((ones, (links[:, 0], links[:, 1])), shape=(count, count))


def _cross(a: FloatArray, b: FloatArray) -> FloatArray:
    product: FloatArray = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
    return product


@kernel
def _spanning_tree(
    first: IntArray, second: IntArray, radii: FloatArray
) -> tuple[IntArray, FloatArray]:
    """Return the links of a spanning tree, taken in the order given (Kruskal's algorithm).

    Returns the numbers of the links, and for each the smaller of the largest radii on its sides
    among what the links before it have joined.
    """
    count = len(radii)
    parent = np.arange(count)
    peak = radii.copy()
    kept = np.empty(count - 1, np.int64)
    peaks = np.empty(count - 1, np.float64)
    n = 0
    for k in range(len(first)):
        a, b = first[k], second[k]
        while parent[a] != a:
            parent[a] = parent[parent[a]]
            a = parent[a]
        while parent[b] != b:
            parent[b] = parent[parent[b]]
            b = parent[b]
        if a == b:
            continue
        if peak[a] < peak[b]:
            a, b = b, a
        parent[b] = a
        kept[n] = k
        peaks[n] = peak[b]
        n += 1
    return kept[:n], peaks[:n]


@kernel
def _sums_of_subtrees(order: IntArray, parent: IntArray, values: FloatArray) -> FloatArray:
    """Return for each node the sum of values of its subtree, in a tree in breadth-first order."""
    sums = values.copy()
    for k in range(len(order) - 1, 0, -1):
        sums[parent[order[k]]] += sums[order[k]]
    return sums
