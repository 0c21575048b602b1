"""Maps as solids for three-dimensional programs: STL and GLB."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any, Final

import numpy as np
import shapely
from shapely import MultiPolygon, Polygon
from shapely.geometry.base import BaseGeometry

from multisrt.exporting.looks import colour_of
from multisrt.exporting.map_content import Line, MapContent, MapOptions
from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.numerics.arrays import FloatArray

if TYPE_CHECKING:
    from trimesh import Trimesh

GRID_M: Final = 1e-4
"""Grid in metres to which corners of solids are rounded, unless far from the origin."""

MAX_GRID_M: Final = 1e-3
"""Upper bound of that grid, in metres."""

SINGLE_DIGITS: Final = 22
"""Binary digits of coordinates in single precision, as in these files, with one to spare."""

MAX_CUTS: Final = 20
"""Upper bound of the rounds that separate touching rings; one or two are usually enough."""

FLOOR_M: Final = 0.02
"""Thickness of the floor, which lies below z = 0."""

RIBBONS_M: Final = {"edges": (0.05, 0.02, 0.10), "paths": (0.10, 0.02, 0.05)}
"""Height above the floor, thickness and width of ribbons by layer, in metres."""

WALL_COLOUR, FLOOR_COLOUR = (0.35, 0.35, 0.35, 1.0), (0.93, 0.93, 0.93, 1.0)


def walls_of(content: MapContent, thickness_m: float) -> MultiPolygon:
    """Return the ground plan of the walls of a map.

    Parameters
    ----------
    content : MapContent
        The map.
    thickness_m : float
        Thickness in metres of walls of which only one side is known.

    Returns
    -------
    MultiPolygon
        For a true world, its obstacles and a wall around each component; for what robots knew, a
        wall behind each observed surface, and none between known and unknown space. Corners are
        rounded to `GRID_M`, and walls that touch at a point are separated there by a square of
        four times that width.

    Raises
    ------
    InvalidInputError
        If the world is too far from the origin for single precision.

    Examples
    --------
    >>> from multisrt.environments.environment import Environment
    >>> hall = Environment("hall", shapely.box(0, 0, 4, 3))
    >>> round(walls_of(MapContent(environment=hall), 0.5).area, 9)
    8.0
    """
    free = content.environment.free
    if content.regions is None:
        filled = shapely.polygons(shapely.get_exterior_ring(shapely.get_parts(free)))
        solid = shapely.union_all(shapely.buffer(filled, thickness_m, join_style="mitre"))
    else:
        solid = content.surfaces().buffer(thickness_m, cap_style="flat", join_style="mitre")
    return apart(solid.difference(free), _grid_m(content))


def apart(area: BaseGeometry, grid_m: float) -> MultiPolygon:
    """Return polygons with corners on a grid whose rings do not touch, not even at points.

    A solid over touching rings has an upright edge with four faces, and is not watertight. Where
    rings touch, a square with a side of four grid widths is cut out.
    """
    # Rounding of slivers in GEOS divides by zero without consequence.
    with np.errstate(divide="ignore", invalid="ignore"):
        snapped = _polygons(shapely.set_precision(area, grid_m))
        for _ in range(MAX_CUTS):
            points = _touching(snapped)
            if not len(points):
                break
            half = 2.0 * grid_m
            squares = shapely.union_all(shapely.box(*(points - half).T, *(points + half).T))
            snapped = _polygons(shapely.difference(snapped, squares, grid_size=grid_m))
    return snapped


def stl_bytes(content: MapContent, options: MapOptions) -> bytes:
    """Return the walls of a map as a binary STL file, with the trees and paths of its lines.

    Coordinates are metres, z is up; walls stand at z = 0, and there is no floor. Every solid is
    closed; ribbons of all robots are united.

    Parameters
    ----------
    content : MapContent
        The map.
    options : MapOptions
        Height and thickness of walls.

    Raises
    ------
    InvalidInputError
        If the world is too far from the origin, or has no walls.
    """
    from trimesh.exchange.stl import export_stl
    from trimesh.util import concatenate

    walls = walls_of(content, options.thickness_m)
    if walls.is_empty:
        raise InvalidInputError(
            f"{content.environment.name!r}: no wall has been seen, so there is no solid"
        )
    solids = [_prism(walls, 0.0, options.height_m, "walls")]
    for layer in RIBBONS_M:
        lines = [line for line in content.lines if line.layer == layer]
        if lines:
            solids.append(_ribbon(layer, lines, _grid_m(content)))
    written: bytes = export_stl(concatenate(solids))
    return written


def glb_bytes(content: MapContent, options: MapOptions) -> bytes:
    """Return a map as a binary glTF file: walls, floor, and the trees and paths of its lines.

    Coordinates are metres. As glTF requires, y is up: a point (x, y, z) of the world is (x, z, -y)
    in the file, which programs such as Blender rotate back. The nodes are ``walls``, ``floor``,
    ``robot_N_edges`` and ``robot_N_paths``; every solid is closed.

    Parameters
    ----------
    content : MapContent
        The map.
    options : MapOptions
        Height and thickness of walls.

    Raises
    ------
    InvalidInputError
        If the world is too far from the origin.

    Notes
    -----
    Source: Khronos Group, glTF 2.0 Specification.
    """
    from trimesh import Scene

    grid_m, scene = _grid_m(content), Scene()
    walls = walls_of(content, options.thickness_m)
    if not walls.is_empty:
        _add(scene, "walls", _prism(walls, 0.0, options.height_m, "walls"), WALL_COLOUR)
    floor = apart(content.environment.free, grid_m)
    _add(scene, "floor", _prism(floor, -FLOOR_M, 0.0, "the floor"), FLOOR_COLOUR)
    for line in content.lines:
        name = f"robot_{line.robot}_{line.layer}"
        _add(scene, name, _ribbon(line.layer, [line], grid_m), colour_of(line.robot))
    written: bytes = scene.export(file_type="glb")
    return written


def _add(scene: Any, name: str, solid: Trimesh, colour: tuple[float, ...]) -> None:
    from trimesh.visual import TextureVisuals
    from trimesh.visual.material import PBRMaterial

    x, y, z = solid.vertices.T
    solid.vertices = np.column_stack([x, z, -y])
    material = PBRMaterial(
        name=name, baseColorFactor=colour, metallicFactor=0.0, roughnessFactor=1.0
    )
    solid.visual = TextureVisuals(material=material)
    scene.add_geometry(solid, node_name=name, geom_name=name)


def _grid_m(content: MapContent) -> float:
    farthest_m = max(map(abs, content.environment.bounds))
    grid_m = max(GRID_M, 2.0 ** math.ceil(math.log2(farthest_m) - SINGLE_DIGITS))
    if grid_m > MAX_GRID_M:
        raise InvalidInputError(
            f"{content.environment.name!r} reaches {farthest_m:.0f} m from the origin, where "
            "single precision does not resolve millimetres: move it to the origin"
        )
    return grid_m


def _ribbon(layer: str, lines: Iterable[Line], grid_m: float) -> Trimesh:
    above_m, thickness_m, width_m = RIBBONS_M[layer]
    pieces = shapely.union_all([line.pieces for line in lines])
    area = apart(pieces.buffer(width_m / 2.0, quad_segs=2), grid_m)
    return _prism(area, above_m, above_m + thickness_m, f"the {layer}")


def _prism(area: MultiPolygon, z0: float, z1: float, what: str) -> Trimesh:
    """Return closed solids over polygons, between two heights."""
    from trimesh.creation import extrude_triangulation

    # Triangles must share whole edges; those of earcut may end in the middle of another's.
    triangles = shapely.get_parts(shapely.constrained_delaunay_triangles(area))
    corners = shapely.get_coordinates(triangles).reshape(-1, 4, 2)[:, :3]
    (ux, uy), (vx, vy) = ((corners[:, k] - corners[:, 0]).T for k in (1, 2))
    clockwise = ux * vy < uy * vx
    corners[clockwise] = corners[clockwise, ::-1]
    points, indices = np.unique(corners.reshape(-1, 2), axis=0, return_inverse=True)
    solid = extrude_triangulation(points, indices.reshape(-1, 3), z1 - z0)
    # Rounded as in the files, so that the solid that is written is checked.
    levels = np.where(solid.vertices[:, 2] > 0.5 * (z1 - z0), z1, z0)
    solid.vertices = np.column_stack([solid.vertices[:, :2], levels]).astype(np.float32)
    expected = area.area * (z1 - z0)
    if not (solid.is_watertight and abs(solid.volume - expected) <= 1e-3 * expected):
        raise InvalidInputError(
            f"{what} of the map have outlines that nearly touch themselves, over which no closed "
            "solid was found: simplify them"
        )
    return solid


def _polygons(area: BaseGeometry) -> MultiPolygon:
    return MultiPolygon([part for part in shapely.get_parts(area) if isinstance(part, Polygon)])


def _touching(area: MultiPolygon) -> FloatArray:
    """Return the points at which rings touch themselves or others, ``(n, 2)``."""
    noded = shapely.get_parts(shapely.node(shapely.boundary(area)))
    segments: list[FloatArray] = []
    for line in noded:
        corners = shapely.get_coordinates(line)
        segments += [corners[:-1], corners[1:]]
    if not segments:
        return np.empty((0, 2))
    points, ends = np.unique(np.concatenate(segments), axis=0, return_counts=True)
    touching: FloatArray = points[ends > 2]
    return touching
