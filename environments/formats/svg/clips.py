"""Clip paths of SVG applied to areas; the cost is bounded before they are computed."""

from pathlib import Path
from typing import Final, NamedTuple

import numpy as np
import shapely
from shapely import Polygon
from shapely.geometry.base import BaseGeometry

from multisrt.environments.formats.regions import (
    MAX_POINTS,
    EdgePairs,
    count_pairs,
    edges_of,
    require_few_crossings,
    too_many_crossings,
)
from multisrt.environments.formats.svg.lengths import matrix
from multisrt.environments.formats.svg.shapes import fill_area, outline
from multisrt.environments.formats.svg.tree import Clip, Document, Drawn
from multisrt.geometry.errors import MapFormatError
from multisrt.geometry.numerics import libm
from multisrt.geometry.numerics.arrays import FloatArray

MAX_CUT_POINTS: Final = 10_000_000
"""Upper bound of the points of all areas that are clipped and of their clip paths, summed."""

POINTS_PER_CUT: Final = 100
"""Fixed cost of clipping one area, in points."""

POINTS_PER_COUNT: Final = 400
"""Fixed cost of counting the crossings of an area with a clip path, in points."""

SMALL_PRODUCT: Final = 10_000
"""Product of the numbers of edges up to which crossings are not counted."""


class _Mask(NamedTuple):
    """The area inside a clip path, and its edges x0, y0, x1, y1, in metres."""

    area: BaseGeometry
    edges: FloatArray


class Clipper:
    """Cuts areas to the clip paths of a document.

    Parameters
    ----------
    document : Document
        The document.
    """

    def __init__(self, document: Document) -> None:
        self._document = document
        self._path: Path = document.path
        self._masks: dict[tuple[int, bytes], _Mask] = {}
        self._mask_points = self._cut_points = 0
        self._pairs = EdgePairs(0, 0, 0)

    def cut(self, one: Drawn, area: BaseGeometry) -> BaseGeometry:
        """Return the part of an area inside the clip paths of its shape, in metres.

        Parameters
        ----------
        one : Drawn
            The shape.
        area : Polygon or MultiPolygon
            Its area in metres.

        Raises
        ------
        MapFormatError
            If the clip paths of the document have too many points, clip too much, or cross the
            clipped areas too often.
        SvgError
            If an attribute of a clip path is wrong.
        """
        for clip in one.clips:
            key = (id(clip.element), clip.matrix.tobytes())
            if key not in self._masks:
                self._masks[key] = self._mask(clip, one.viewport)
            if area.is_empty:
                break
            mask = self._masks[key]
            self._count(area, mask)
            area = area & mask.area
        return area

    def _count(self, area: BaseGeometry, mask: _Mask) -> None:
        points = int(shapely.get_num_coordinates(area))
        self._cut_points += points + len(mask.edges) + POINTS_PER_CUT
        if self._cut_points > MAX_CUT_POINTS:
            raise MapFormatError(
                f"{self._path}: its clip paths cut too many shapes; remove the clip paths, or "
                "simplify them"
            )
        if points * len(mask.edges) <= SMALL_PRODUCT:
            return
        self._cut_points += POINTS_PER_COUNT
        low, high = np.split(shapely.total_bounds([area]), 2)
        ends = mask.edges.reshape(-1, 2, 2)
        near = (ends.max(axis=1) >= low).all(axis=1) & (ends.min(axis=1) <= high).all(axis=1)
        if not near.any():
            return
        found = count_pairs(np.vstack([edges_of([area]), mask.edges[near]]))
        self._pairs = self._pairs.plus(found)
        if self._pairs.are_too_many:
            raise too_many_crossings(self._path)

    def _mask(self, clip: Clip, viewport: tuple[float, float]) -> _Mask:
        own = matrix(clip.element.attributes.get("transform", ""))
        areas: list[BaseGeometry] = []
        for one in self._document.drawn(clip.element, libm.product(clip.matrix, own), viewport):
            if one.element.name == "image":
                continue
            lines = outline(one)
            self._mask_points += sum(len(points) for points, _ in lines.metres)
            if self._mask_points > MAX_POINTS:
                raise MapFormatError(
                    f"{self._path}: its clip paths have more than {MAX_POINTS:,} points, counted "
                    "again for every transform; simplify them"
                )
            areas.append(fill_area(self._path, one, lines, "clip-rule"))
        require_few_crossings(self._path, areas)
        area = shapely.union_all(np.asarray(areas)) if areas else Polygon()
        return _Mask(area, edges_of([area]))
