"""Polygon text files of the IMR maps: a border and obstacles, in three layouts."""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Final

import shapely
from shapely import Polygon
from shapely.geometry.base import BaseGeometry

from multisrt.environments.cleaning import FIXING, Cleaning, repaired, without_denormals
from multisrt.environments.environment import MAX_COORDINATE_M, Environment
from multisrt.environments.formats.files import (
    MAX_POLYGON_BYTES,
    build_environment,
    read_text,
    refuse_resolution,
    refuse_threshold,
    require_length,
)
from multisrt.environments.formats.map_format import Beginning, MapFormat
from multisrt.environments.formats.regions import require_few_overlaps
from multisrt.geometry.errors import MapFormatError, shown
from multisrt.geometry.regions.overlay import difference_of

SECTIONS: Final = ("[SCALE]", "[BORDER]", "[OBSTACLE]")
"""Sections of the layout with coordinates in each polygon."""

SECTIONS_OF_MAP_POINTS: Final = ("[INFO]", "[MAP_POINTS]", "[MAP_BORDER]", "[MAP_OBSTACLE]")
"""Sections of the layout ``FORMAT=MAP_POINTS``."""

UNUSED_SECTIONS: Final = (
    "[MAP_CONVEX_REGION]",
    "[MESH_NODES]",
    "[MESH_TRIANGLES]",
    "[MESH_BOUNDARY_NODES]",
    "[TRIMESH_CONVEX_REGION]",
    "[TRIMESH_CONVEX_REGION_TRIANGLES]",
)
"""Sections of the layout ``FORMAT=MAP_POINTS`` that follow from the polygons, and are not read."""

SECTIONS_OF_NAMED: Final = ("[NAME]", "[LIMITS]", "[POINTS]", "[BORDER]", "[NUM_HOLES]", "[HOLE]")
"""Sections of the layout that begins with ``[NAME]``."""

FREE_TEXT: Final = ("[NAME]", "[INFO]", *UNUSED_SECTIONS)
"""Sections whose content is text, or is not read."""

Point = tuple[float, float]


def read_imr(
    path: Path,
    *,
    resolution_m: float | None = None,
    threshold: float | None = None,
    name: str | None = None,
    repair: bool = False,
) -> Environment:
    """Read a polygon map of the Intelligent and Mobile Robotics group (CTU Prague).

    A file is in one of three layouts, which its sections distinguish:

    - ``[SCALE]`` with the metres per unit (1 without it), ``[BORDER]`` and every ``[OBSTACLE]``
      with lines ``x y``;
    - ``[INFO]`` with ``FORMAT=MAP_POINTS``, ``[MAP_POINTS]`` with lines ``index x y`` in metres,
      ``[MAP_BORDER]`` and every ``[MAP_OBSTACLE]`` with indices of points;
    - ``[NAME]``, ``[LIMITS]``, ``[POINTS]`` with a count and lines ``index x y`` in metres,
      ``[BORDER]`` with a count and lines ``position index``, ``[NUM_HOLES]`` with a count, and
      every ``[HOLE]`` with its number, a count and lines ``position index``.

    Parameters
    ----------
    path : Path
        Polygons are not closed, and may have either orientation. Obstacles may overlap. Points are
        numbered from 0, in their order.
    resolution_m, threshold
        Rejected: the file states its own scale and is not an image.
    name : str, optional
        By default the file's name without suffix.
    repair : bool
        Whether rings that cross are repaired instead of refused.

    Raises
    ------
    MapFormatError
        If a section is unknown, missing or has too few points, a line does not hold the numbers
        that belong there, a count is wrong, there is no point of an index, or a ring crosses
        itself.

    Notes
    -----
    Source: the loader of the library TřiVis (J. Mikula, CTU Prague); differs in: obstacles are
    cut off at the border instead of being moved into it, and other sections and wrong counts are
    errors.
    """
    refuse_resolution(path, resolution_m)
    refuse_threshold(path, threshold)
    sections = list(_sections(path))
    headings = [section.heading for section in sections]
    if "[NAME]" in headings:
        polygons = _named_polygons(sections)
    elif "[INFO]" in headings or "[MAP_POINTS]" in headings:
        polygons = _map_points_polygons(sections)
    else:
        polygons = _plain_polygons(sections)
    borders: list[BaseGeometry] = []
    obstacles: list[BaseGeometry] = []
    cleaning = Cleaning()
    require_few_overlaps(path, [polygon for _, _, polygon in polygons])
    for is_border, section, polygon in polygons:
        if not (polygon.is_valid or repair):
            raise section.error(
                f"is not a valid polygon: {shapely.is_valid_reason(polygon)}; "
                f"draw outlines that do not cross themselves, or {FIXING}"
            )
        whole, changed = repaired(polygon)
        cleaning += changed
        (borders if is_border else obstacles).append(whole)
    if len(borders) != 1:
        raise MapFormatError(f"{path} has {len(borders)} borders; a map has one")
    free = difference_of(borders[0], obstacles)
    return build_environment(path, free, name=name, origin=path.name, cleaning=cleaning)


# Sections -----------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class _Section:
    """A heading and the rows of numbers below it, each with its line."""

    path: Path
    line: int
    heading: str
    rows: list[list[float]] = field(default_factory=list)
    lines: list[int] = field(default_factory=list)

    def error(self, what: str) -> MapFormatError:
        return MapFormatError(f"{self.path}, line {self.line}: {self.heading} {what}")

    def error_in(self, row: int, what: str) -> MapFormatError:
        return MapFormatError(f"{self.path}, line {self.lines[row]}: {what}")

    def count(self, at: int, most: int | None = None) -> int:
        """Return a row that is one whole number of at least 0."""
        row = self.rows[at] if at < len(self.rows) else []
        if len(row) != 1 or not row[0].is_integer() or row[0] < 0:
            raise self.error("must be followed by a line with one whole number")
        if most is not None and row[0] > most:
            raise self.error(f"has {row[0]:g} where at most {most} is possible")
        return int(row[0])

    def counted(self, start: int) -> range:
        """Return the rows after a count in row `start`, which they must agree with."""
        count, found = self.count(start), len(self.rows) - start - 1
        if count != found:
            raise self.error(f"says that {count:g} lines follow, and {found} do")
        return range(start + 1, len(self.rows))


def _sections(path: Path) -> Iterator[_Section]:
    known = {*SECTIONS, *SECTIONS_OF_MAP_POINTS, *UNUSED_SECTIONS, *SECTIONS_OF_NAMED}
    section: _Section | None = None
    for number, line in enumerate(
        read_text(path, max_bytes=MAX_POLYGON_BYTES).splitlines(), start=1
    ):
        heading, _, text = line.strip().partition(" ")
        if heading in known:
            if section is not None:
                yield section
            section = _Section(path, number, heading)
        else:
            text = line
        text = text.strip()
        if not text:
            continue
        if section is None or text.startswith("["):
            raise MapFormatError(
                f"{path}, line {number} is {shown(text)}; "
                f"a polygon map has the sections {', '.join(SECTIONS)} or those of the layouts "
                "FORMAT=MAP_POINTS or [NAME]"
            )
        if section.heading == "[INFO]" and text.startswith("FORMAT=") and text[7:] != "MAP_POINTS":
            raise MapFormatError(
                f"{path}, line {number} is {shown(text)}; the format is MAP_POINTS"
            )
        if section.heading not in FREE_TEXT:
            section.rows.append(_row(path, number, text))
            section.lines.append(number)
    if section is not None:
        yield section


def _row(path: Path, number: int, text: str) -> list[float]:
    try:
        row = [float(word) for word in text.split()]
    except ValueError:
        row = []
    if not row or not all(math.isfinite(value) for value in row):
        raise MapFormatError(
            f"{path}, line {number} is {shown(text)}; it must consist of finite numbers"
        )
    return row


# Layouts ------------------------------------------------------------------------------------


Polygons = list[tuple[bool, _Section, Polygon]]
"""For each polygon, whether it is the border, its section, and the polygon in metres."""


def _plain_polygons(sections: list[_Section]) -> Polygons:
    scale = 1.0
    for section in sections:
        if section.heading == "[SCALE]":
            if len(section.rows) != 1 or len(section.rows[0]) != 1:
                raise section.error("must be followed by one positive number")
            scale = require_length(
                f"{section.path}, line {section.lines[0]}",
                "the scale",
                section.rows[0][0],
                unit="m per unit",
            )
    polygons = []
    for section in sections:
        if section.heading in ("[BORDER]", "[OBSTACLE]"):
            if any(len(row) != 2 for row in section.rows):
                raise section.error("must be followed by at least three lines x y")
            points = [(x * scale, y * scale) for x, y in section.rows]
            polygons.append((section.heading == "[BORDER]", section, _polygon(section, points)))
        elif section.heading != "[SCALE]":
            raise section.error(f"does not belong to a layout with {', '.join(SECTIONS)}")
    return polygons


def _map_points_polygons(sections: list[_Section]) -> Polygons:
    _require_known(sections, (*SECTIONS_OF_MAP_POINTS, *UNUSED_SECTIONS))
    points = _points(sections, "[MAP_POINTS]", lambda section: range(len(section.rows)))
    return [
        (
            section.heading == "[MAP_BORDER]",
            section,
            _polygon(section, _indexed(section, range(len(section.rows)), points, 0)),
        )
        for section in sections
        if section.heading in ("[MAP_BORDER]", "[MAP_OBSTACLE]")
    ]


def _named_polygons(sections: list[_Section]) -> Polygons:
    _require_known(sections, SECTIONS_OF_NAMED)
    points = _points(sections, "[POINTS]", lambda section: section.counted(0))
    polygons: Polygons = []
    holes: set[int] = set()
    for section in sections:
        if section.heading == "[BORDER]":
            vertices = _indexed(section, section.counted(0), points, 1)
            polygons.append((True, section, _polygon(section, vertices)))
        elif section.heading == "[HOLE]":
            # The number and the count of a hole are on one line or on two.
            if section.rows and len(section.rows[0]) == 2:
                section.rows[:1] = [[value] for value in section.rows[0]]
                section.lines[:1] = [section.lines[0]] * 2
            holes.add(section.count(0))
            vertices = _indexed(section, section.counted(1), points, 1)
            polygons.append((False, section, _polygon(section, vertices)))
    for section in sections:
        if section.heading == "[NUM_HOLES]":
            count = section.count(0)
            # Counted first: the number may be any.
            if len(holes) != count or holes != set(range(count)) or len(polygons) != count + 1:
                raise section.error(
                    f"is {count:g}; the sections [HOLE] are not numbered from 0 to {count - 1:g}"
                )
    return polygons


def _require_known(sections: list[_Section], known: tuple[str, ...]) -> None:
    for section in sections:
        if section.heading not in known:
            raise section.error(f"does not belong to a layout with {', '.join(known)}")


def _points(
    sections: list[_Section], heading: str, rows_of: Callable[[_Section], range]
) -> list[Point]:
    found = [section for section in sections if section.heading == heading]
    if len(found) != 1:
        path = sections[0].path
        raise MapFormatError(f"{path} has {len(found)} sections {heading}; a map has one")
    (section,) = found
    points: list[Point] = []
    for at in rows_of(section):
        row = section.rows[at]
        if len(row) != 3 or row[0] != len(points):
            raise section.error_in(
                at, f"a point is a line index x y, and the index here must be {len(points)}"
            )
        points.append((row[1], row[2]))
    return points


def _indexed(section: _Section, rows: range, points: list[Point], at: int) -> list[Point]:
    """Return the points whose indices are in column `at` of rows, or in all columns if it is 0."""
    found = []
    for row in rows:
        values = section.rows[row]
        if at and len(values) != at + 1:
            raise section.error_in(row, "a vertex is a line position index")
        for value in values[at:]:
            if not (value.is_integer() and 0 <= value < len(points)):
                raise section.error_in(
                    row, f"{value:g} is not the index of a point; they are 0 to {len(points) - 1}"
                )
            found.append(points[int(value)])
    return found


def _polygon(section: _Section, points: list[Point]) -> Polygon:
    if len(points) < 3:
        raise section.error("must be followed by at least three lines or points")
    if not all(abs(value) <= MAX_COORDINATE_M for point in points for value in point):
        raise section.error(f"has a coordinate beyond {MAX_COORDINATE_M:g} m; check the scale")
    return without_denormals(Polygon(points))


def _is_imr(beginning: Beginning) -> bool:
    heading = beginning.first_line.partition(" ")[0]
    return heading in (*SECTIONS, *SECTIONS_OF_MAP_POINTS, *SECTIONS_OF_NAMED)


IMR = MapFormat(
    name="IMR polygons",
    suffixes=(".txt",),
    recognises=_is_imr,
    read=read_imr,
    repair=partial(read_imr, repair=True),
)
