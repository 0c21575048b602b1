"""Polygon text files of the IMR maps: a border and obstacles in scaled units."""

import math
from functools import partial
from pathlib import Path

import shapely
from shapely import Polygon
from shapely.geometry.base import BaseGeometry

from multisrt.environments.cleaning import FIXING, Cleaning, repaired
from multisrt.environments.environment import MAX_COORDINATE_M, Environment
from multisrt.environments.formats.files import (
    build_environment,
    read_text,
    refuse_resolution,
    refuse_threshold,
    shown,
)
from multisrt.environments.formats.map_format import Beginning, MapFormat
from multisrt.geometry.errors import MapFormatError

SECTIONS = ("[SCALE]", "[BORDER]", "[OBSTACLE]")


def read_imr(
    path: Path,
    *,
    resolution_m: float | None = None,
    threshold: float | None = None,
    name: str | None = None,
    repair: bool = False,
) -> Environment:
    """Read a polygon map in sections ``[SCALE]``, ``[BORDER]`` and ``[OBSTACLE]``.

    Parameters
    ----------
    path : Path
        ``[SCALE]`` is followed by the metres per unit (1 without it), ``[BORDER]`` and every
        ``[OBSTACLE]`` by lines ``x y``, not closed, in either sense. Obstacles may overlap.
    resolution_m, threshold
        Refused: the file states its own scale and is not an image.
    name : str, optional
        By default the file's name without suffix.
    repair : bool, optional
        Whether rings that cross are repaired instead of refused.

    Raises
    ------
    MapFormatError
        If a section is unknown, missing or has too few points, a line has no two numbers, or
        a ring crosses itself.
    """
    refuse_resolution(path, resolution_m)
    refuse_threshold(path, threshold)
    scale = 1.0
    borders: list[BaseGeometry] = []
    obstacles: list[BaseGeometry] = []
    cleaning = Cleaning()
    sections = _sections(path)
    for number, section, rows in sections:
        if section == "[SCALE]":
            if len(rows) != 1 or len(rows[0]) != 1 or not rows[0][0] > 0:
                raise MapFormatError(
                    f"{path}, line {number}: [SCALE] is followed by one positive number"
                )
            scale = rows[0][0]
    for number, section, rows in sections:
        if section != "[SCALE]":
            polygon, changed = _polygon(path, number, section, rows, scale=scale, repair=repair)
            cleaning += changed
            (borders if section == "[BORDER]" else obstacles).append(polygon)
    if len(borders) != 1:
        raise MapFormatError(f"{path} has {len(borders)} sections [BORDER]; a map has one")
    free = borders[0].difference(shapely.union_all(obstacles))
    return build_environment(path, free, name=name, origin=path.name, cleaning=cleaning)


def _sections(path: Path) -> list[tuple[int, str, list[list[float]]]]:
    """Return the line number, heading and rows of numbers of each section."""
    sections: list[tuple[int, str, list[list[float]]]] = []
    for number, line in enumerate(read_text(path).splitlines(), start=1):
        text = line.strip()
        if not text:
            continue
        if text in SECTIONS:
            sections.append((number, text, []))
            continue
        if not sections or text.startswith("["):
            raise MapFormatError(
                f"{path}, line {number} is {shown(text)}; "
                f"a polygon map has the sections {', '.join(SECTIONS)}"
            )
        try:
            row = [float(word) for word in text.split()]
        except ValueError:
            row = []
        if not row or not all(math.isfinite(value) for value in row):
            raise MapFormatError(
                f"{path}, line {number} is {shown(text)}; it is made of finite numbers"
            )
        sections[-1][2].append(row)
    return sections


def _polygon(
    path: Path, number: int, section: str, rows: list[list[float]], *, scale: float, repair: bool
) -> tuple[BaseGeometry, Cleaning]:
    place = f"{path}, line {number}: {section}"
    if len(rows) < 3 or any(len(row) != 2 for row in rows):
        raise MapFormatError(f"{place} is followed by at least three lines x y")
    points = [(x * scale, y * scale) for x, y in rows]
    if not all(abs(value) <= MAX_COORDINATE_M for point in points for value in point):
        raise MapFormatError(
            f"{place} has a coordinate beyond {MAX_COORDINATE_M:g} m; check [SCALE]"
        )
    polygon = Polygon(points)
    if not (polygon.is_valid or repair):
        raise MapFormatError(
            f"{place} is not a valid polygon: {shapely.is_valid_reason(polygon)}; "
            f"draw outlines that do not cross themselves, or {FIXING}"
        )
    return repaired(polygon)


def _is_imr(beginning: Beginning) -> bool:
    return beginning.first_line in SECTIONS


IMR = MapFormat(
    name="IMR polygons",
    suffixes=(".txt",),
    recognises=_is_imr,
    read=read_imr,
    repair=partial(read_imr, repair=True),
)
