"""The small picture of a run, for pages that show many: who saw what first, and the paths."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import shapely

from multisrt.drawing.areas import seen_first
from multisrt.drawing.base_marks import draw_base
from multisrt.drawing.colours import RobotStyles
from multisrt.drawing.marks import draw_areas, draw_starts_and_ends
from multisrt.drawing.sheet import Sheet
from multisrt.drawing.svg import child
from multisrt.drawing.traces import traces_of
from multisrt.events import NodeAdded
from multisrt.geometry.numerics.kernel import FloatArray
from multisrt.recording import Recording

TOLERANCE_MM: Final = 0.35
"""Maximum difference of outlines and paths from those of the run, in millimetres on paper."""

MIN_PART_MM: Final = 2.5
"""Side of a square as large as the smallest part of an area that is drawn, in millimetres."""

PATH_MM: Final = 0.45
"""Width of paths, in millimetres on paper."""


def small_svg(recording: Recording, title: str) -> str:
    """Return a small picture of a run, without texts but the numbers of robots.

    It shows the area of each robot of a team that it saw first, paths, starts and ends, the base
    station and the border of what it knows. Outlines and paths are simplified; `tree_svg` has all
    details.

    Parameters
    ----------
    recording : Recording
        Recording of the run.
    title : str
        Title of the document.

    Returns
    -------
    str
        An SVG document of some kilobytes. Equal recordings give equal documents.

    Raises
    ------
    InvalidInputError
        If the recording contradicts itself; the message says where.

    Examples
    --------
    >>> import multisrt as ms
    >>> from multisrt.drawing import tree_svg
    >>> run = ms.explore("open", robots=2, seed=1, max_time_s=10.0)
    >>> len(small_svg(run.recording, "two")) < len(tree_svg(run.recording))
    True
    """
    environment, traces = recording.environment(), traces_of(recording)
    sheet = Sheet(environment, [title], "")
    sheet.pen = replace(sheet.pen, decimals=max(0, sheet.pen.decimals - 1))
    tolerance = TOLERANCE_MM * sheet.mm
    sheet.draw_ground("")
    if len(traces) > 1:
        draw_areas(sheet, _areas(recording, tolerance), len(traces))
    sheet.draw_obstacles(environment)
    for trace in traces:
        style = RobotStyles.of(trace.robot).team_path if len(traces) > 1 else RobotStyles.of(0).path
        layer = sheet.layer("", replace(style, width_mm=PATH_MM, dashes_mm=()))
        if trace.motions and len(trace.path) > 1:
            path = shapely.simplify(shapely.LineString(trace.path), tolerance)
            child(layer, "path", d=sheet.pen.line(shapely.get_coordinates(path)))
    draw_base(sheet, recording, environment, frozenset())
    draw_starts_and_ends(sheet, traces, base=recording.spec.base)
    return sheet.map_svg(title)


def _areas(recording: Recording, tolerance: float) -> dict[int, list[FloatArray]]:
    nodes = [event for event in recording.events if isinstance(event, NodeAdded)]
    regions = [shapely.simplify(shapely.Polygon(node.boundary), tolerance) for node in nodes]
    areas = seen_first(regions, [node.robot for node in nodes], tolerance)
    least = (MIN_PART_MM / TOLERANCE_MM * tolerance) ** 2
    return {
        robot: [_simpler(ring, tolerance) for ring in rings if shapely.Polygon(ring).area > least]
        for robot, rings in areas.items()
    }


def _simpler(ring: FloatArray, tolerance: float) -> FloatArray:
    return shapely.get_coordinates(shapely.simplify(shapely.LinearRing(ring), tolerance))
