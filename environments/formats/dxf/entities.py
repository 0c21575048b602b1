"""The entities of a DXF drawing as lines and areas in metres."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np

from multisrt.environments.cleaning import flushed
from multisrt.environments.environment import MAX_COORDINATE_M
from multisrt.environments.formats.curves import FLATNESS_M, cubic_points
from multisrt.environments.formats.files import RESOLUTION_OPTION
from multisrt.environments.formats.plan import Role, role_within
from multisrt.environments.formats.regions import MAX_POINTS
from multisrt.geometry.errors import MapFormatError, shortened, shown
from multisrt.geometry.numerics.arrays import FloatArray

if TYPE_CHECKING:
    from ezdxf.document import Drawing
    from ezdxf.entities.dxfgfx import DXFGraphic
    from ezdxf.entities.insert import Insert
    from ezdxf.math import Matrix44
    from ezdxf.path import Path as CadPath

MAX_ENTITIES: Final = 100_000
"""Upper bound of the entities that are drawn; those of blocks count once for each insertion."""

MAX_BLOCK_DEPTH: Final = 32
"""Upper bound of the nesting of blocks."""

MAX_SPLINE_POINTS: Final = 5_000
"""Upper bound of the points of a spline."""

ANNOTATIONS: Final = frozenset(
    {
        *("TEXT", "MTEXT", "ATTRIB", "ATTDEF", "RTEXT", "SHAPE", "ACAD_TABLE", "TOLERANCE"),
        *("DIMENSION", "ARC_DIMENSION", "LARGE_RADIAL_DIMENSION"),
        *("LEADER", "MLEADER", "MULTILEADER", "XLINE", "RAY", "SECTION", "LIGHT"),
        *("IMAGE", "WIPEOUT", "VIEWPORT", "OLEFRAME", "OLE2FRAME", "GEOPOSITIONMARKER"),
        *("PDFUNDERLAY", "DWFUNDERLAY", "DGNUNDERLAY"),
    }
)
"""Types of entities that are not part of a building, and ignored."""

LINES: Final = frozenset(["LINE", "LWPOLYLINE", "POLYLINE", "ARC", "CIRCLE", "ELLIPSE", "SPLINE"])
AREAS: Final = frozenset(["HATCH", "MPOLYGON", "SOLID", "TRACE"])


class Line(NamedTuple):
    """A polyline in metres: points as ``(n, 2)``, whether it is closed, and its width, or 0."""

    points: FloatArray
    is_closed: bool
    width_m: float


class Part(NamedTuple):
    """What an entity draws, in metres: lines, or the rings of a filled area."""

    layer: str
    role: Role | None
    lines: list[Line]
    rings: list[FloatArray]


class Drawer:
    """The entities of a drawing, with those of blocks at each insertion.

    Parameters
    ----------
    path : Path
        The file, for messages.
    drawing : ezdxf.document.Drawing
        The drawing.
    scale : float
        Metres per drawing unit.
    """

    def __init__(self, path: Path, drawing: Drawing, scale: float) -> None:
        self._path = path
        self._drawing = drawing
        self._scale = scale
        self._entities = self._points = 0
        self._starts: list[tuple[float, float]] = []

    def drawn(self) -> tuple[list[Part], list[tuple[float, float]]]:
        """Return what is drawn and the suggested starts, in metres.

        Raises
        ------
        MapFormatError
            If too much is drawn, or an entity cannot be read. A damaged drawing may raise other
            errors.
        """
        from ezdxf.math import Matrix44

        space = self._drawing.modelspace()
        return list(self._parts_in(space, Matrix44(), "0", None, 0)), self._starts

    def _parts_in(
        self, entities: Any, matrix: Matrix44, layer: str, role: Role | None, depth: int
    ) -> Iterator[Part]:
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
            found = role_within([on], role)
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
    ) -> Iterator[Part]:
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
                    f"{self._path} inserts the block {shown(one.dxf.name)}, which is not defined"
                )
            inner = Matrix44.chain(one.matrix44(), matrix)
            yield from self._parts_in(block, inner, layer, role, depth + 1)

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
    ) -> Iterator[Part]:
        kind = entity.dxftype()
        if kind in ANNOTATIONS or kind == "POINT" or role is Role.START:
            return
        if kind == "MLINE":
            for line in entity.virtual_entities():  # type: ignore[attr-defined]
                yield from self._part(line, matrix, layer, role)
            return
        if kind in AREAS:
            rings = [self._flat(path, matrix) for path in self._paths(entity)]
            # Without a role, a pattern may show a floor as well as a wall.
            is_pattern = kind == "HATCH" and not entity.dxf.get("solid_fill", 0)
            if role is not None or not is_pattern:
                yield Part(layer, role, [], rings)
        elif kind in LINES and not self._is_mesh(entity):
            width = self._width(entity, matrix)
            lines = []
            for path in self._paths(entity):
                points = self._flat(path, matrix)
                is_closed = len(points) > 2 and bool(
                    np.hypot(*(points[0] - points[-1])) <= 1e-6 * (1 + np.abs(points).max())
                )
                lines.append(Line(points[:-1] if is_closed else points, is_closed, width))
            yield Part(layer, role, lines, [])
        else:
            raise MapFormatError(
                f"{self._path}: the {shortened(kind)} on the layer {shown(layer)} is not read; "
                "explode it into lines, or hide its layer"
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
        width = float(max(widths)) * self._scale * math.sqrt(abs(x.x * y.y - x.y * y.x))
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
        """Return the points of a path in metres, with curves as polylines within `FLATNESS_M`."""
        from ezdxf.path import Curve3To, Curve4To

        commands = path.commands()
        corners = [path.start]
        for command in commands:
            if isinstance(command, Curve4To):
                corners += [command.ctrl1, command.ctrl2]
            elif isinstance(command, Curve3To):
                corners.append(command.ctrl)
            corners.append(command.end)
        placed = flushed(np.array(self._place(matrix, corners)))
        if not np.abs(placed).max() <= MAX_COORDINATE_M:
            raise MapFormatError(
                f"{self._path} has a point further than {MAX_COORDINATE_M:g} m away; check the "
                f"unit ($INSUNITS) or give {RESOLUTION_OPTION}"
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
