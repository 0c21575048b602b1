"""Pictures of frontier bidding: the paths and goals of robots, and what the team knows."""

from __future__ import annotations

from multisrt.drawing.account import paths_legend
from multisrt.drawing.base_marks import draw_base
from multisrt.drawing.colours import CUT_OFF, FRONTIER_CELLS, GOAL_MM, KNOWN, RobotStyles
from multisrt.drawing.marks import draw_areas, draw_starts_and_ends, draw_stops
from multisrt.drawing.scanned import (
    frontier_left,
    goals_of,
    isolated_paths,
    min_frontier_m,
    rings_of,
    team_raster,
)
from multisrt.drawing.sheet import Sheet
from multisrt.drawing.svg import child
from multisrt.drawing.traces import Trace
from multisrt.environments.environment import Environment
from multisrt.events import Point
from multisrt.geometry.grids.occupancy import UNKNOWN
from multisrt.recording import Recording


def draw_paths(
    sheet: Sheet,
    recording: Recording,
    environment: Environment,
    traces: list[Trace],
    absent: frozenset[str] = frozenset(),
) -> None:
    """Draw what the team knows, by the robot that saw it first, and all paths and goals.

    Layers that are `absent` are left out; see `multisrt.drawing.layers`.

    Raises
    ------
    InvalidInputError
        If the options of the recording are not those of frontier bidding.
    """
    raster, first = team_raster(recording)
    left = [] if "frontier" in absent else frontier_left(raster, min_frontier_m(recording))
    cut_off = {} if "isolation" in absent else isolated_paths(recording, environment, traces)
    goals = {trace.robot: goals_of(recording, trace.robot) for trace in traces}
    if "areas" not in absent:
        areas = {trace.robot: rings_of(raster, first == trace.robot) for trace in traces}
        draw_areas(sheet, areas, len(traces))
    if "outlines" not in absent:
        known = sheet.layer("known", KNOWN)
        child(known, "path", d=sheet.pen.rings(rings_of(raster, raster.cells != UNKNOWN)))
    sheet.draw_obstacles(environment)
    for robot, paths in cut_off.items():
        layer = sheet.layer(f"robot {robot}: cut off", CUT_OFF)
        child(layer, "path", d="".join(map(sheet.pen.line, paths)))
    for trace in traces if "paths" not in absent else ():
        _draw_path(sheet, trace)
    if left:
        layer = sheet.layer("frontier left", FRONTIER_CELLS, fill_rule="evenodd")
        child(layer, "path", d=sheet.pen.rings(left))
    for trace in traces if "goals" not in absent else ():
        _draw_goals(sheet, trace.robot, goals[trace.robot])
    for trace in traces if "stops" not in absent else ():
        draw_stops(sheet, trace)
    at_base = draw_base(sheet, recording, environment, absent)
    draw_starts_and_ends(sheet, traces, absent, recording.spec.base)
    there = {"goals": any(goals.values()), "frontier": bool(left), "isolation": bool(cut_off)}
    sheet.legend += paths_legend(
        traces, absent, frozenset(name for name, is_there in there.items() if is_there)
    )
    sheet.legend += at_base


def _draw_path(sheet: Sheet, trace: Trace) -> None:
    layer = sheet.layer(f"robot {trace.robot}: path", RobotStyles.of(trace.robot).edge)
    if trace.motions:
        child(layer, "path", d="".join(map(sheet.pen.line, trace.stretches)))


def _draw_goals(sheet: Sheet, robot: int, goals: list[Point]) -> None:
    if goals:
        layer = sheet.layer(f"robot {robot}: goals", RobotStyles.of(robot).node)
        size = sheet.metres(GOAL_MM)
        child(layer, "path", d="".join(sheet.pen.marker("diamond", x, y, size) for x, y in goals))
