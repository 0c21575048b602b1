"""Pictures of how a world suits a body: what is out of reach, and the narrow passages."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Final

import shapely
from shapely import Polygon

from multisrt.analysis.clearance_tree import Passage
from multisrt.analysis.map_check import MapCheck
from multisrt.drawing.colours import INK, SUGGESTED_START, VERMILION, Style
from multisrt.drawing.environment_svg import START_MM
from multisrt.drawing.sheet import TEXT_MM, LegendEntry, Sheet
from multisrt.drawing.svg import child, length
from multisrt.recording import atomic_write

UNREACHABLE: Final = Style(stroke=VERMILION, width_mm=0.25)
SEPARATE: Final = Style(stroke=INK, width_mm=0.12)
PASSAGE: Final = Style(stroke=INK, width_mm=0.5)
BLOCKED: Final = Style(stroke=VERMILION, width_mm=0.8)

HATCH_MM: Final = 1.6
"""Distance of the lines of a hatching."""

RING_MM: Final = 2.2
"""Radius of the ring around a passage."""

MAX_MARKED: Final = 12
"""Number of passages that are marked besides those that the body does not pass."""

MAX_BLOCKED: Final = 60
"""Maximum number of marked passages that the body does not pass."""

APART_MM: Final = 11.0
"""Minimum distance between the widths that are written, in millimetres."""


def map_check_svg(check: MapCheck) -> str:
    """Return a picture of how a world suits a body.

    Areas out of reach of the body are hatched upwards, parts separate from the main part downwards.
    Narrow passages are marked with their widths: those that the body does not pass, and the
    narrowest others.

    Parameters
    ----------
    check : MapCheck
        The check of the world.

    Returns
    -------
    str
        An SVG document with metres as user units. Equal checks give equal documents.

    Examples
    --------
    >>> from multisrt.analysis.map_check import check_map
    >>> from multisrt.environments import environment
    >>> from multisrt.geometry.bodies.footprint import Footprint
    >>> "narrow passage" in map_check_svg(check_map(environment("museum"), Footprint.disc(0.25)))
    True
    """
    world = check.environment
    x0, y0, x1, y1 = world.bounds
    sheet = Sheet(
        world,
        [
            world.name,
            f"{length(x1 - x0)} x {length(y1 - y0)}, {length(world.area_m2)}² free",
            f"{check.footprint} reaches {100.0 * check.reached_share:.3g} % of the main part; "
            f"discs up to {length(check.largest.radius_m)} in radius reach "
            f"{100.0 * check.share:.3g} %",
        ],
        description=f"A check of a world. Origin: {world.origin or 'not known'}.",
    )
    sheet.draw_ground("free space")
    separate = [part for part in check.parts if part is not check.main]
    _hatch(sheet, "separate part", SEPARATE, separate, falling=True)
    _hatch(sheet, f"out of reach of {check.footprint}", UNREACHABLE, check.unreachable)
    sheet.draw_obstacles(world)
    blocked = _apart(check.blocking[::-1], sheet.metres(RING_MM))[:MAX_BLOCKED]
    others = _apart(check.passages[len(check.blocking) :], sheet.metres(RING_MM))[:MAX_MARKED]
    _mark(sheet, "narrow passage", PASSAGE, others)
    _mark(sheet, "passage that is too narrow", BLOCKED, blocked)
    if check.starts:
        kind = check.kind_of_start
        layer = sheet.layer(f"{kind}s", SUGGESTED_START)
        size = sheet.metres(START_MM)
        path = "".join(sheet.pen.marker("diamond", x, y, size) for x, y in check.starts)
        child(layer, "path", d=path)
        sheet.legend.append(
            LegendEntry(label=kind, style=SUGGESTED_START, marker="diamond", size_mm=START_MM)
        )
    _write_widths(sheet, (*blocked, *others))
    return sheet.svg()


def save_map_check_svg(check: MapCheck, path: str | Path) -> None:
    """Write the picture of a check to a file; see `map_check_svg`.

    Parameters
    ----------
    check : MapCheck
        The check of the world.
    path : str or Path
        The file, which is replaced if it exists. Its folder must exist.

    Raises
    ------
    InvalidInputError
        If the file cannot be written.
    """
    with atomic_write(Path(path)) as file:
        file.write(map_check_svg(check).encode())


def _hatch(
    sheet: Sheet, label: str, style: Style, areas: Sequence[Polygon], *, falling: bool = False
) -> None:
    if not areas:
        return
    layer = sheet.layer(label, style)
    lines = _lines_in(areas, HATCH_MM * sheet.mm, falling=falling)
    child(layer, "path", d="".join(sheet.pen.line(line) for line in lines))
    rings = (ring.coords for area in areas for ring in (area.exterior, *area.interiors))
    child(layer, "path", d=sheet.pen.rings(rings))
    sheet.legend.append(LegendEntry(label=label, style=style))


def _lines_in(
    areas: Sequence[Polygon], distance_m: float, *, falling: bool
) -> Iterable[list[tuple[float, float]]]:
    # Lines at 45 degrees, at fixed places so that neighbouring areas have lines in common.
    whole = shapely.union_all(areas)
    x0, y0, x1, y1 = whole.bounds
    slope = -1.0 if falling else 1.0
    step = distance_m * math.sqrt(2.0)
    heights = [y - slope * x for x in (x0, x1) for y in (y0, y1)]
    first, last = math.floor(min(heights) / step), math.ceil(max(heights) / step)
    lines = shapely.linestrings(
        [
            [(x0, slope * x0 + number * step), (x1, slope * x1 + number * step)]
            for number in range(first, last + 1)
        ]
    )
    cut = shapely.get_parts(shapely.intersection(lines, whole), return_index=False)
    for line in shapely.get_parts(cut):
        if line.geom_type == "LineString" and not line.is_empty:
            yield list(line.coords)


def _apart(passages: Sequence[Passage], distance_m: float) -> list[Passage]:
    # Without those near one that comes before.
    kept: list[Passage] = []
    for passage in passages:
        if all(math.dist(passage.centre, other.centre) > distance_m for other in kept):
            kept.append(passage)
    return kept


def _mark(sheet: Sheet, label: str, style: Style, passages: Sequence[Passage]) -> None:
    if not passages:
        return
    layer = sheet.layer(label, style)
    path = "".join(sheet.pen.line(passage.ends) for passage in passages)
    path += "".join(
        sheet.pen.marker("disc", *passage.centre, sheet.metres(RING_MM)) for passage in passages
    )
    child(layer, "path", d=path)
    sheet.legend.append(LegendEntry(label=label, style=style))


def _write_widths(sheet: Sheet, passages: Sequence[Passage]) -> None:
    # Beside the rings; where it is crowded, those that come first.
    layer = sheet.layer("widths")
    apart = APART_MM * sheet.mm
    written: list[tuple[float, float]] = []
    for passage in passages:
        x, y = passage.centre
        if all(math.hypot(x - other_x, y - other_y) > apart for other_x, other_y in written):
            written.append((x, y))
            place = (x, y + sheet.metres(RING_MM) + 0.8 * TEXT_MM * sheet.mm)
            sheet.label(layer, f"{passage.width_m:.2f} m", place, 0.9 * TEXT_MM, halo_mm=0.8)
