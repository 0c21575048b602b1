"""The area that robots have seen, as pieces by the picture in which they appear."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from itertools import groupby
from typing import Final, NamedTuple

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from multisrt.analysis.scans import scanned_regions
from multisrt.drawing.animation.pace import Pace
from multisrt.environments.environment import Environment
from multisrt.events import NodeAdded, Sensed
from multisrt.geometry.numerics.kernel import FloatArray
from multisrt.geometry.regions.overlay import union_on_grid
from multisrt.recording import Recording

MIN_PIECE: Final = 3.0
"""Area below which new area waits for more to be seen, in squares of the tolerance."""


class Piece(NamedTuple):
    """Area that a robot was the first to see.

    Attributes
    ----------
    picture : int
        The picture in which it appears.
    robot : int
        The robot.
    rings : list of (n, 2) array
        Its rings in metres, all of its parts with their holes; closed.
    """

    picture: int
    robot: int
    rings: list[FloatArray]


def pieces(
    recording: Recording, environment: Environment, pace: Pace, tolerance_m: float
) -> Iterator[Piece]:
    """Yield the area that a run showed, in order.

    Areas are those of local safe regions, or of scans in runs without nodes. Each place belongs
    to the robot that saw it first. Pieces overlap by twice the tolerance, so that no seams show.

    Parameters
    ----------
    recording : Recording
        The run.
    environment : Environment
        Its world.
    pace : Pace
        When what is shown.
    tolerance_m : float
        Bound of the distance of outlines from the true ones, in metres.

    Yields
    ------
    Piece
        In the order of their pictures.
    """
    seen: BaseGeometry = shapely.Polygon()
    shown = groupby(_regions(recording, environment), lambda one: pace.picture_after(one[0]))
    for picture, group in shown:
        new: list[BaseGeometry] = []
        for robot, region in _by_robot(group, tolerance_m):
            around = shapely.box(*region.bounds)
            known = union_on_grid([_areal(seen.intersection(around)), *new])
            piece = _areal(shapely.difference(region, known, grid_size=tolerance_m / 8.0))
            rings = _rings(piece, tolerance_m)
            if rings:
                new.append(piece)
                yield Piece(picture, robot, rings)
        if new:
            seen = shapely.union_all([seen, *new], grid_size=tolerance_m / 8.0)


def _regions(
    recording: Recording, environment: Environment
) -> Iterator[tuple[float, int, FloatArray]]:
    nodes = recording.of(NodeAdded)
    if nodes:
        for node in nodes:
            yield node.time_s, node.robot, recording.region(node)
        return
    shown = scanned_regions(recording, environment)
    for scan, corners in zip(recording.of(Sensed), shown, strict=True):
        if len(corners):
            yield scan.time_s, scan.robot, corners


def _by_robot(
    group: Iterable[tuple[float, int, FloatArray]], tolerance_m: float
) -> Iterator[tuple[int, BaseGeometry]]:
    # In the order in which robots saw the first of it.
    regions: dict[int, list[FloatArray]] = {}
    for _, robot, corners in group:
        regions.setdefault(robot, []).append(corners)
    for robot, own in regions.items():
        shapes = shapely.make_valid(np.array([shapely.Polygon(corners) for corners in own]))
        parts = [_areal(shape) for shape in shapes]
        yield robot, shapely.union_all(parts, grid_size=tolerance_m / 8.0)


def _areal(shape: BaseGeometry) -> BaseGeometry:
    # Overlays leave lines and points behind where borders touch.
    if shape.geom_type in ("Polygon", "MultiPolygon"):
        return shape
    parts = shapely.get_parts(shape)
    return shapely.MultiPolygon(
        [single for part in parts for single in shapely.get_parts(part) if single.area > 0.0]
    )


def _rings(piece: BaseGeometry, tolerance_m: float) -> list[FloatArray]:
    whole = [
        part
        for part in shapely.get_parts(piece)
        if part.geom_type == "Polygon" and _is_visible(part, tolerance_m)
    ]
    if not whole:
        return []
    wide = shapely.buffer(shapely.multipolygons(whole), tolerance_m, join_style="mitre")
    simple = shapely.simplify(wide, tolerance_m / 2.0)
    return [
        shapely.get_coordinates(ring)
        for part in shapely.get_parts(simple)
        for ring in (part.exterior, *part.interiors)
        if len(ring.coords) > 3
    ]


def _is_visible(part: shapely.Polygon, tolerance_m: float) -> bool:
    # Slivers along the borders of regions are left out.
    if part.area < MIN_PIECE * tolerance_m**2:
        return False
    return not shapely.buffer(part, -0.5 * tolerance_m).is_empty
