"""Floor plans in DXF: lines of CAD drawings as walls, by the names of layers."""

from __future__ import annotations

import logging
import re
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from multisrt.environments.environment import MAX_COORDINATE_M, Environment
from multisrt.environments.formats.curves import FLATNESS_M, cubic_points
from multisrt.environments.formats.files import (
    build_environment,
    refuse_threshold,
    require_file,
    require_resolution,
)
from multisrt.environments.formats.map_format import Beginning, MapFormat
from multisrt.environments.formats.plan import Role, role_names, role_of
from multisrt.environments.formats.regions import MAX_POINTS, filled, require_few_crossings
from multisrt.extras import extra
from multisrt.geometry.errors import MapFormatError
from multisrt.geometry.numerics.arrays import FloatArray

if TYPE_CHECKING:
    from ezdxf.document import Drawing
    from ezdxf.entities import DXFGraphic, Insert
    from ezdxf.math import Matrix44
    from ezdxf.path import Path as CadPath

WALL_THICKNESS_M: Final = 0.02
"""Thickness of the walls that lines without a width become, in metres."""

MAX_DXF_BYTES: Final = 32 * 2**20
"""Upper bound of the size of DXF files, in bytes (32 MiB)."""

MAX_ENTITIES: Final = 100_000
"""Upper bound of the entities that are drawn, those of blocks as often as they are inserted."""

MAX_BLOCK_DEPTH: Final = 32
"""Upper bound of the nesting of blocks."""

MAX_SPLINE_POINTS: Final = 5_000
"""Upper bound of the points of a spline."""

MIN_RESOLUTION_M: Final = 1e-6
"""Smallest size of a drawing unit, in metres."""

SNAP_M: Final = 1e-3
"""Grid to which the ends of single lines are moved when they are joined to outlines."""

ANNOTATIONS: Final = frozenset(
    {
        *("TEXT", "MTEXT", "ATTRIB", "ATTDEF", "RTEXT", "SHAPE", "ACAD_TABLE", "TOLERANCE"),
        *("DIMENSION", "ARC_DIMENSION", "LARGE_RADIAL_DIMENSION"),
        *("LEADER", "MLEADER", "MULTILEADER", "XLINE", "RAY", "SECTION", "LIGHT"),
        *("IMAGE", "WIPEOUT", "VIEWPORT", "OLEFRAME", "OLE2FRAME", "GEOPOSITIONMARKER"),
        *("PDFUNDERLAY", "DWFUNDERLAY", "DGNUNDERLAY"),
    }
)
"""Types of entities that are no part of a building."""

LINES: Final = frozenset(["LINE", "LWPOLYLINE", "POLYLINE", "ARC", "CIRCLE", "ELLIPSE", "SPLINE"])
AREAS: Final = frozenset(["HATCH", "MPOLYGON", "SOLID", "TRACE"])


class _Line(NamedTuple):
    points: FloatArray
    is_closed: bool
    width_m: float


class _Part(NamedTuple):
    """What an entity draws, in metres: lines, or rings of an area that is filled."""

    role: Role | None
    lines: list[_Line]
    rings: list[FloatArray]


def read_dxf(
    path: Path,
    *,
    resolution_m: float | None = None,
    threshold: float | None = None,
    name: str | None = None,
) -> Environment:
    """Read a floor plan from the model space of a DXF file.

    Lines of CAD have no thickness: each becomes a wall of 2 cm, or of its own width if a polyline
    has one. Two lines that are the faces of a wall thus enclose an area that no path leads to.

    **By layers.** An entity has the role of the first of these words in the name of its layer, or
    else of that of the block that it is in: ``door``, ``obstacle`` (also ``column``,
    ``furniture``), ``wall`` (also ``window``, ``glaz``), ``start``, ``free`` (also ``outline``,
    ``boundary``); ``A-WALL-FULL`` is a wall. If something is a wall, an obstacle or free, only
    what has a role counts:

    - *walls*: lines and curves as above, hatches and solids as areas;
    - *obstacles*: closed outlines, also of single lines, as areas; other lines as walls;
    - *free*: closed outlines as areas. Without any, free space is the box around all walls;
    - *doors*: closed outlines are openings in walls; other lines are left out;
    - *starts*: points, the centres of outlines, and the base points of blocks are suggested
      starts.

    **Without such layers** all lines and solid hatches are walls. Text, dimensions, images, and
    layers that are off or frozen never count.

    Parameters
    ----------
    path : Path
        DXF, ASCII or binary, of AutoCAD R12 or later, of at most 32 MiB.
    resolution_m : float, optional
        Metres per drawing unit. By default the unit of the header (``$INSUNITS``); required if
        that says that there is none.
    threshold
        Refused: a drawing is not an image.
    name : str, optional
        By default the file's name without suffix.

    Raises
    ------
    MapFormatError
        If the file is not DXF, has no unit and none is given, or has no walls, no free space, or
        walls that cannot be read.
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
        parts, starts = _Drawer(path, drawing, scale).drawn()
    except MapFormatError:
        raise
    except Exception as error:  # a damaged file makes the library raise almost anything
        raise MapFormatError(
            f"{path} is a damaged DXF file: {str(error)[:200] or type(error).__name__}; "
            "save it again"
        ) from error
    free, rule = _free_space(path, parts)
    origin = (
        f"{path.name} at {scale:g} m per unit, {rule}, lines {WALL_THICKNESS_M * 100:g} cm thick"
    )
    return build_environment(path, free, name=name, origin=origin, starts=starts)


def _loaded(path: Path, ezdxf: Any) -> Drawing:
    logger = logging.getLogger("ezdxf")
    level = logger.level
    # What the library repairs it reports at length; what it cannot repair it raises.
    logger.setLevel(logging.CRITICAL)
    try:
        drawing: Drawing = ezdxf.readfile(path)
    finally:
        logger.setLevel(level)
    return drawing


def _metres_per_unit(path: Path, drawing: Drawing, resolution_m: float | None) -> float:
    from ezdxf import units

    if resolution_m is None:
        unit = int(drawing.header.get("$INSUNITS", 0))
        if unit:
            resolution_m = float(units.conversion_factor(unit, units.M))
    return require_resolution(path, resolution_m, unit="drawing unit", least_m=MIN_RESOLUTION_M)


class _Drawer:
    """The entities of a drawing, with those of blocks as often as they are inserted."""

    def __init__(self, path: Path, drawing: Drawing, scale: float) -> None:
        self._path = path
        self._drawing = drawing
        self._scale = scale
        self._entities = self._points = 0
        self._starts: list[tuple[float, float]] = []

    def drawn(self) -> tuple[list[_Part], list[tuple[float, float]]]:
        """Return what is drawn and the suggested starts, in metres."""
        from ezdxf.math import Matrix44

        space = self._drawing.modelspace()
        return list(self._of(space, Matrix44(), "0", None, 0)), self._starts

    def _of(
        self, entities: Any, matrix: Matrix44, layer: str, role: Role | None, depth: int
    ) -> Iterator[_Part]:
        """Yield the parts of a block that is inserted on a layer."""
        if depth > MAX_BLOCK_DEPTH:
            raise MapFormatError(
                f"{self._path}: blocks are nested more than {MAX_BLOCK_DEPTH} deep"
            )
        for entity in entities:
            self._entities += 1
            if self._entities > MAX_ENTITIES:
                raise MapFormatError(
                    f"{self._path} draws more than {MAX_ENTITIES:,} entities; simplify it"
                )
            own = str(entity.dxf.get("layer", "0"))
            on = layer if own == "0" else own
            if entity.dxf.get("invisible", 0) or self._is_hidden(on):
                continue
            found = role_of([on]) or role
            if entity.dxftype() == "INSERT":
                yield from self._inserted(entity, matrix, on, found, depth)
            elif found is Role.START:
                self._starts.extend(self._centres(entity, matrix))
            else:
                yield from self._part(entity, matrix, on, found)

    def _is_hidden(self, name: str) -> bool:
        layers = self._drawing.layers
        if not layers.has_entry(name):
            return False
        layer = layers.get(name)
        return bool(layer.is_off() or layer.is_frozen())

    def _inserted(
        self, insert: Insert, matrix: Matrix44, layer: str, role: Role | None, depth: int
    ) -> Iterator[_Part]:
        from ezdxf.math import Matrix44

        copies = insert.mcount
        if copies > MAX_ENTITIES - self._entities:
            raise MapFormatError(
                f"{self._path} draws more than {MAX_ENTITIES:,} entities; simplify it"
            )
        for one in insert.multi_insert() if copies > 1 else (insert,):
            if role is Role.START:
                self._starts.append(self._place(matrix, [one.ocs().to_wcs(one.dxf.insert)])[0])
                continue
            block = one.block()
            if block is None:
                raise MapFormatError(
                    f"{self._path} inserts the block {one.dxf.name[:40]!r}, which it does not "
                    "define"
                )
            inner = Matrix44.chain(one.matrix44(), matrix)
            yield from self._of(block, inner, layer, role, depth + 1)

    def _place(self, matrix: Matrix44, points: Any) -> list[tuple[float, float]]:
        return [
            (p.x * self._scale, p.y * self._scale) for p in matrix.transform_vertices(list(points))
        ]

    def _centres(self, entity: DXFGraphic, matrix: Matrix44) -> Iterator[tuple[float, float]]:
        if entity.dxftype() == "POINT":
            yield from self._place(matrix, [entity.dxf.location])
        elif entity.dxftype() in LINES | AREAS:
            for path in self._paths(entity):
                points = self._flat(path, matrix)
                x, y = (points.min(axis=0) + points.max(axis=0)) / 2
                yield float(x), float(y)

    def _part(
        self, entity: DXFGraphic, matrix: Matrix44, layer: str, role: Role | None
    ) -> Iterator[_Part]:
        kind = entity.dxftype()
        if kind in ANNOTATIONS or kind == "POINT" or role is Role.START:
            return
        if kind == "MLINE":
            for line in entity.virtual_entities():  # type: ignore[attr-defined]
                yield from self._part(line, matrix, layer, role)
            return
        if kind in AREAS:
            rings = [self._flat(path, matrix) for path in self._paths(entity)]
            # Without layers a pattern may as well be that of a floor.
            is_pattern = kind == "HATCH" and not entity.dxf.get("solid_fill", 0)
            if role is not None or not is_pattern:
                yield _Part(role, [], rings)
        elif kind in LINES and not self._is_mesh(entity):
            width = self._width(entity, matrix)
            lines = []
            for path in self._paths(entity):
                points = self._flat(path, matrix)
                is_closed = len(points) > 2 and bool(
                    np.hypot(*(points[0] - points[-1])) <= 1e-6 * (1 + np.abs(points).max())
                )
                lines.append(_Line(points[:-1] if is_closed else points, is_closed, width))
            yield _Part(role, lines, [])
        else:
            raise MapFormatError(
                f"{self._path}: the {kind[:40]} on the layer {layer[:40]!r} is not read; explode "
                "it into lines, or hide its layer"
            )

    def _is_mesh(self, entity: Any) -> bool:
        return entity.dxftype() == "POLYLINE" and not (
            entity.is_2d_polyline or entity.is_3d_polyline
        )

    def _width(self, entity: Any, matrix: Matrix44) -> float:
        """Return the width of a polyline in metres; 0 if it has none."""
        if entity.dxftype() == "LWPOLYLINE":
            widths = [entity.dxf.get("const_width", 0.0)]
            if entity.has_width:
                widths += [max(start, end) for *_, start, end, _ in entity.get_points()]
        elif entity.dxftype() == "POLYLINE":
            widths = [entity.dxf.get(f"default_{end}_width", 0.0) for end in ("start", "end")]
        else:
            return 0.0
        x, y = matrix.ux, matrix.uy
        width = float(max(widths)) * self._scale * abs(x.x * y.y - x.y * y.x) ** 0.5
        if not 0 <= width <= MAX_COORDINATE_M:
            raise MapFormatError(f"{self._path} has a polyline that is {width:g} m wide")
        return width

    def _paths(self, entity: Any) -> list[CadPath]:
        from ezdxf import path as paths

        kind = entity.dxftype()
        if kind in ("HATCH", "MPOLYGON"):
            return list(paths.from_hatch(entity))
        if kind == "SPLINE":
            points = max(entity.control_point_count(), entity.fit_point_count())
            if points > MAX_SPLINE_POINTS:
                raise MapFormatError(
                    f"{self._path} has a spline of {points:,} points; splines are read up to "
                    f"{MAX_SPLINE_POINTS:,}"
                )
        path = paths.make_path(entity, segments=8)
        return [one for one in path.sub_paths() if len(one)]

    def _flat(self, path: CadPath, matrix: Matrix44) -> FloatArray:
        """Return the points of a path in metres, its curves within `FLATNESS_M`."""
        from ezdxf.path import Curve3To, Curve4To

        commands = path.commands()
        corners = [path.start]
        for command in commands:
            if isinstance(command, Curve4To):
                corners += [command.ctrl1, command.ctrl2]
            elif isinstance(command, Curve3To):
                corners.append(command.ctrl)
            corners.append(command.end)
        placed = np.array(self._place(matrix, corners))
        if not np.abs(placed).max() <= MAX_COORDINATE_M:
            raise MapFormatError(
                f"{self._path} has a point further than {MAX_COORDINATE_M:g} m away; check the "
                "unit ($INSUNITS) or give --resolution (resolution_m)"
            )
        pieces, at = [placed[:1]], 0
        for command in commands:
            if isinstance(command, Curve4To):
                curve, at = placed[at : at + 4], at + 3
                pieces.append(cubic_points(curve, FLATNESS_M))
            elif isinstance(command, Curve3To):
                (a, b, c), at = placed[at : at + 3], at + 2
                cubic = np.array([a, a + 2 / 3 * (b - a), c + 2 / 3 * (b - c), c])
                pieces.append(cubic_points(cubic, FLATNESS_M))
            else:
                at += 1
                pieces.append(placed[at : at + 1])
        points = np.concatenate(pieces)
        self._points += len(points)
        if self._points > MAX_POINTS:
            raise MapFormatError(
                f"{self._path} has more than {MAX_POINTS:,} points, with curves as polylines; "
                "simplify it"
            )
        return points


def _free_space(path: Path, parts: list[_Part]) -> tuple[BaseGeometry, str]:
    """Return free space, and in words what walls are."""
    has_names = any(part.role in (Role.FREE, Role.WALL, Role.OBSTACLE) for part in parts)
    rule = "walls by their layers" if has_names else "all lines are walls"
    chosen: dict[Role, list[_Part]] = {role: [] for role in Role}
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
    require_few_crossings(path, lines)
    walls, _ = _areas(path, chosen[Role.WALL], outlines=False)
    walls += [_wall(line) for part in chosen[Role.WALL] for line in part.lines]
    solid, loose = _areas(path, chosen[Role.OBSTACLE], outlines=True)
    solid += [_wall(line) for line in loose]
    doors, _ = _areas(path, chosen[Role.DOOR], outlines=True)
    require_few_crossings(path, [*walls, *solid, *doors])
    blocked = (_united(walls) - _united(doors)) | _united(solid)
    if chosen[Role.FREE]:
        free = _united(_areas(path, chosen[Role.FREE], outlines=True)[0])
        if free.is_empty:
            raise MapFormatError(
                f"{path}: no outline on the layers of free space is closed; join its lines"
            )
    else:
        if blocked.is_empty:
            raise MapFormatError(
                f"{path} has no walls: there are no lines in the model space on layers that are "
                f"shown; put walls on layers named {role_names()}"
            )
        free = shapely.box(*blocked.bounds)
    left = free - blocked
    if left.is_empty:
        raise MapFormatError(f"{path}: walls cover everything, so there is no free space")
    return left, rule


def _wall(line: _Line) -> BaseGeometry:
    """Return the area of a line with a thickness."""
    radius = max(line.width_m, WALL_THICKNESS_M) / 2
    points = line.points
    if line.is_closed:
        ring = shapely.LinearRing(points)
        return shapely.buffer(ring, radius, join_style="mitre", mitre_limit=2.0)
    along = shapely.LineString(points if len(points) > 1 else np.vstack([points, points]))
    # Square ends close the corners of lines that miss each other by less than the thickness.
    return shapely.buffer(along, radius, cap_style="square", join_style="mitre", mitre_limit=2.0)


def _areas(
    path: Path, parts: list[_Part], *, outlines: bool
) -> tuple[list[BaseGeometry], list[_Line]]:
    """Return the areas that are filled and those of closed outlines, and lines of no outline."""
    areas = [filled(path, part.rings, "evenodd") for part in parts if part.rings]
    loose: list[_Line] = []
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
                _Line(shapely.get_coordinates(line), False, 0.0)
                for line in (*shapely.get_parts(cuts), *shapely.get_parts(dangles))
            ]
    return [area for area in areas if not area.is_empty], loose


def _united(areas: list[BaseGeometry]) -> BaseGeometry:
    return shapely.union_all(np.asarray(areas, np.object_))


_BINARY: Final = b"AutoCAD Binary DXF\r\n\x1a\0"
_FIRST_TAGS: Final = re.compile(r"\s*(999\s*\n[^\n]*\n\s*)*0\s*\n\s*SECTION\s*\n")


def _is_dxf(beginning: Beginning) -> bool:
    return (
        beginning.raw.startswith(_BINARY)
        or _FIRST_TAGS.match(beginning.text.replace("\r\n", "\n").replace("\r", "\n")) is not None
    )


DXF = MapFormat(name="DXF", suffixes=(".dxf",), recognises=_is_dxf, read=read_dxf)
