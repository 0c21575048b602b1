"""Floor plans in DXF as worlds."""

from __future__ import annotations

import logging
import re
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from multisrt.environments.environment import Environment
from multisrt.environments.formats.dxf.entities import Drawer, Line, Part
from multisrt.environments.formats.files import (
    FileStarts,
    build_environment,
    refuse_threshold,
    require_file,
    require_resolution,
)
from multisrt.environments.formats.map_format import Beginning, MapFormat
from multisrt.environments.formats.plan import Role, layers_of, role_names
from multisrt.environments.formats.regions import (
    Pen,
    filled,
    opened,
    require_few_crossings,
    sides_of_stroke,
    stroked,
    union_of,
)
from multisrt.extras import extra
from multisrt.geometry.errors import MapFormatError, reason_of

if TYPE_CHECKING:
    from ezdxf.document import Drawing

WALL_THICKNESS_M: Final = 0.02
"""Thickness of walls made from lines without a width, in metres."""

MAX_DXF_BYTES: Final = 32 * 2**20
"""Upper bound of the size of DXF files, in bytes (32 MiB)."""

MIN_RESOLUTION_M: Final = 1e-6
"""Smallest size of a drawing unit, in metres."""

PEN: Final = Pen("square", "mitre", 2.0)
"""Square ends close the corners of lines that miss each other by less than the thickness."""

SNAP_M: Final = 1e-3
"""Grid in metres to which the ends of single lines are rounded to join them to outlines."""


def read_dxf(
    path: Path,
    *,
    resolution_m: float | None = None,
    threshold: float | None = None,
    name: str | None = None,
    repair: bool = False,
) -> Environment:
    """Read a floor plan from the model space of a DXF file.

    Lines in CAD have no thickness: each becomes a wall of 2 cm, or of its own width if a polyline
    has one. Two lines for the faces of a wall thus enclose a separate part of free space.

    **By layers.** An entity has the role of the first of these words in the name of its layer, or
    else in that of the block that contains it: ``door``, ``obstacle`` (also ``column``,
    ``furniture``), ``wall`` (also ``window``, ``glaz``), ``start``, ``free`` (also ``outline``);
    ``A-WALL-FULL`` is a wall. If any entity is a wall, an obstacle or free, only entities with a
    role count:

    - *walls*: lines and curves as above, hatches and solids as areas;
    - *obstacles*: closed outlines, also of single lines, as areas; other lines as walls;
    - *free*: closed outlines as areas. Without any, free space is the bounding box of all walls;
    - *doors*: closed outlines are openings in walls; other lines are ignored;
    - *starts*: points, the centres of outlines, and the base points of blocks are suggested
      starts.

    **Without such layers** all lines and solid hatches are walls. Text, dimensions, images, and
    layers that are off or frozen are always ignored.

    Parameters
    ----------
    path : Path
        DXF, ASCII or binary, of AutoCAD R12 or later, of at most 32 MiB.
    resolution_m : float, optional
        Metres per drawing unit. By default the unit in the header (``$INSUNITS``); required if
        there is none.
    threshold
        Rejected: a drawing is not an image.
    name : str, optional
        By default the file's name without suffix.
    repair : bool, optional
        Whether starts that are not in free space are left out instead of refused.

    Raises
    ------
    MapFormatError
        If the file is not DXF, has no unit and no resolution is given, has no walls or no free
        space, has a start outside of it, or draws walls by entities that cannot be read.
    MissingExtraError
        If ezdxf is not installed (``multisrt[dxf]``).

    Notes
    -----
    Source: Autodesk, DXF Reference; differs in: heights are ignored, external references are not
    read.

    Examples
    --------
    >>> import ezdxf
    >>> from pathlib import Path
    >>> drawing = ezdxf.new(units=ezdxf.units.M)
    >>> corners = [(0, 0), (6, 0), (6, 4), (0, 4)]
    >>> outline = {"layer": "Outline"}
    >>> _ = drawing.modelspace().add_lwpolyline(corners, close=True, dxfattribs=outline)
    >>> _ = drawing.modelspace().add_line((3, 1), (3, 3), dxfattribs={"layer": "A-WALL"})
    >>> drawing.saveas("plan.dxf")
    >>> round(read_dxf(Path("plan.dxf")).area_m2, 4)
    23.9596
    """
    refuse_threshold(path, threshold)
    size = require_file(path)
    if size > MAX_DXF_BYTES:
        raise MapFormatError(
            f"{path} has {size:,} bytes; files of this format are read up to {MAX_DXF_BYTES:,}"
        )
    with extra("dxf", "a floor plan in DXF"):
        import ezdxf
    try:
        drawing = _loaded(path, ezdxf)
        scale = _metres_per_unit(path, drawing, resolution_m)
        # Points that are not finite are refused.
        with np.errstate(all="ignore"):
            parts, starts = Drawer(path, drawing, scale).drawn()
    except MapFormatError:
        raise
    except Exception as error:  # a damaged file makes the library raise almost anything
        why = reason_of(error) if str(error) else "it ends too early, or parts of it are missing"
        raise MapFormatError(
            f"{path} is a damaged DXF file: {why}; copy it again, or open it and save it anew"
        ) from error
    free, rule = _free_space(path, parts)
    origin = (
        f"{path.name} at {scale:g} m per unit, {rule}, lines {WALL_THICKNESS_M * 100:g} cm thick"
    )
    layers = layers_of((part.layer, part.role) for part in parts) if _has_names(parts) else None
    return build_environment(
        path,
        free,
        name=name,
        origin=origin,
        starts=FileStarts(starts, repair=repair),
        layers=layers,
    )


def _loaded(path: Path, ezdxf: Any) -> Drawing:
    logger = logging.getLogger("ezdxf")
    level = logger.level
    # The library logs what it repairs, and raises what it cannot repair.
    logger.setLevel(logging.CRITICAL)
    try:
        drawing: Drawing = ezdxf.readfile(path)
    finally:
        logger.setLevel(level)
    return drawing


def _metres_per_unit(path: Path, drawing: Drawing, resolution_m: float | None) -> float:
    from ezdxf import units
    from ezdxf.enums import InsertUnits

    if resolution_m is None:
        unit = InsertUnits(int(drawing.header.get("$INSUNITS", 0)))
        if unit is not InsertUnits.Unitless:
            resolution_m = float(units.conversion_factor(unit, InsertUnits.Meters))
    return require_resolution(path, resolution_m, unit="drawing unit", min_m=MIN_RESOLUTION_M)


def _has_names(parts: list[Part]) -> bool:
    return any(part.role in (Role.FREE, Role.WALL, Role.OBSTACLE) for part in parts)


def _free_space(path: Path, parts: list[Part]) -> tuple[BaseGeometry, str]:
    """Return free space, and the rule for walls in words."""
    has_names = _has_names(parts)
    rule = "walls by their layers" if has_names else "all lines are walls"
    chosen: dict[Role, list[Part]] = {role: [] for role in Role}
    for part in parts:
        role = part.role if has_names else Role.WALL
        if role is not None:
            chosen[role].append(part)
    lines = [
        shapely.LineString(np.vstack([line.points, line.points[:1]]) if line.is_closed else line[0])
        for some in chosen.values()
        for part in some
        for line in part.lines
        if len(line.points) > 1
    ]
    sides = [
        sides_of_stroke(line.points, _radius(line))
        for role in (Role.WALL, Role.OBSTACLE)
        for part in chosen[role]
        for line in part.lines
    ]
    require_few_crossings(path, lines, sides)
    walls, _ = _areas(path, chosen[Role.WALL], outlines=False)
    walls += [_wall(line) for part in chosen[Role.WALL] for line in part.lines]
    solid, loose = _areas(path, chosen[Role.OBSTACLE], outlines=True)
    solid += [_wall(line) for line in loose]
    doors, _ = _areas(path, chosen[Role.DOOR], outlines=True)
    require_few_crossings(path, [*walls, *solid, *doors])
    blocked = opened(union_of(walls), union_of(doors)) | union_of(solid)
    if chosen[Role.FREE]:
        free = union_of(_areas(path, chosen[Role.FREE], outlines=True)[0])
        if free.is_empty:
            raise MapFormatError(
                f"{path}: no outline on the layers of free space is closed; join its lines"
            )
    else:
        if blocked.is_empty:
            raise MapFormatError(
                f"{path} has no walls: there are no lines in the model space on visible "
                f"layers; put walls on layers named {role_names()}"
            )
        free = shapely.box(*blocked.bounds)
    left = free - blocked
    if left.is_empty:
        raise MapFormatError(f"{path}: walls cover everything, so there is no free space")
    return left, rule


def _radius(line: Line) -> float:
    return max(line.width_m, WALL_THICKNESS_M) / 2


def _wall(line: Line) -> BaseGeometry:
    """Return the area of a line with a thickness."""
    return stroked(line.points, line.is_closed, _radius(line), PEN)


def _areas(
    path: Path, parts: list[Part], *, outlines: bool
) -> tuple[list[BaseGeometry], list[Line]]:
    """Return the areas of fills and of closed outlines, and the lines that close none."""
    areas = [filled(path, part.rings, "evenodd") for part in parts if part.rings]
    loose: list[Line] = []
    if outlines:
        lines = [line for part in parts for line in part.lines]
        areas += [filled(path, [line.points], "evenodd") for line in lines if line.is_closed]
        single = [line for line in lines if not line.is_closed and len(line.points) > 1]
        if single:
            strings = np.array([shapely.LineString(line.points) for line in single], np.object_)
            noded = shapely.union_all(shapely.set_precision(strings, SNAP_M))
            faces, cuts, dangles, _ = shapely.polygonize_full(shapely.get_parts(noded))
            areas += list(shapely.get_parts(faces))
            loose = [
                Line(shapely.get_coordinates(line), False, 0.0)
                for line in (*shapely.get_parts(cuts), *shapely.get_parts(dangles))
            ]
    return [area for area in areas if not area.is_empty], loose


_BINARY: Final = b"AutoCAD Binary DXF\r\n\x1a\0"
_FIRST_TAGS: Final = re.compile(r"\s*(999\s*\n[^\n]*\n\s*)*0\s*\n\s*SECTION\s*\n")


def _is_dxf(beginning: Beginning) -> bool:
    return (
        beginning.raw.startswith(_BINARY)
        or _FIRST_TAGS.match(beginning.text.replace("\r\n", "\n").replace("\r", "\n")) is not None
    )


DXF = MapFormat(
    name="DXF",
    suffixes=(".dxf",),
    recognises=_is_dxf,
    read=read_dxf,
    repair=partial(read_dxf, repair=True),
)
