"""The picture of a run that is under way: what it has come to, and where the robots are."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from itertools import pairwise
from typing import Final

import shapely

from multisrt.analysis.scans import scanned_regions
from multisrt.drawing.areas import seen_first
from multisrt.drawing.colours import GOAL_MM, INK, RobotStyles, Style
from multisrt.drawing.marks import draw_areas
from multisrt.drawing.sheet import LegendEntry, Sheet
from multisrt.drawing.svg import child
from multisrt.drawing.tree_svg import run_sheet
from multisrt.events import NodeAdded, Sensed
from multisrt.geometry.bodies.footprint import Footprint
from multisrt.planners.motion.trajectory import leg_points
from multisrt.recording import Recording
from multisrt.simulation.stepping import RobotState

AHEAD: Final = Style(stroke=INK, width_mm=0.3, dashes_mm=(0.7, 0.5))
"""The remainder of a motion."""

GOAL: Final = Style(fill="#ffffff", stroke=INK, width_mm=0.3)
DEAD: Final = Style(fill=INK, stroke=INK, width_mm=0.2)


def state_svg(recording: Recording, robots: Sequence[RobotState]) -> str:
    """Return a picture of the present state of a run.

    It shows the true world and what `tree_svg` shows of the run so far; for robots that record no
    nodes the area that their scans showed; and the bodies of all robots with the motions that
    they are on and the goals of these.

    Parameters
    ----------
    recording : Recording
        The run so far.
    robots : sequence of RobotState
        The present state of each robot.

    Returns
    -------
    str
        An SVG document.

    Examples
    --------
    >>> import multisrt as ms
    >>> from multisrt.simulation.stepping import Stepping
    >>> run = Stepping(ms.RunSpec(environment=ms.CatalogEnvironment(name="open"), seed=1))
    >>> for step in run:
    ...     if step.time_s > 10.0:
    ...         break
    >>> state_svg(run.recording, run.robots).count("<svg")
    1
    """
    now_s = recording.footer.time_s
    only_scans = recording.of(Sensed) and not recording.of(NodeAdded)
    draw_below = partial(_draw_seen, recording) if only_scans else None
    sheet = run_sheet(recording, f"at {now_s:,.1f} s", draw_below)
    for robot in robots:
        _draw_ahead(sheet, robot)
    for robot in robots:
        _draw_body(sheet, robot, recording.spec.robots[robot.robot].footprint)
    styles = RobotStyles.of_any() if len(robots) > 1 else RobotStyles.of(0)
    # The last position of each robot is where it is.
    sheet.legend = [
        replace(entry, label="direction of a robot") if entry.label == "end" else entry
        for entry in sheet.legend
    ]
    sheet.legend.append(LegendEntry(label="body of a robot", style=styles.end))
    if any(robot.motion is not None for robot in robots):
        sheet.legend += [
            LegendEntry(label="path ahead", style=AHEAD),
            LegendEntry(label="end of the motion", style=GOAL, marker="diamond", size_mm=GOAL_MM),
        ]
    return sheet.svg()


def _draw_seen(recording: Recording, sheet: Sheet) -> None:
    scans = recording.of(Sensed)
    shown = scanned_regions(recording, recording.environment())
    regions = [shapely.Polygon(corners) for corners in shown if len(corners)]
    by = [scan.robot for scan, corners in zip(scans, shown, strict=True) if len(corners)]
    if regions:
        grid_m = 10.0**-sheet.pen.decimals
        areas = seen_first(regions, by, grid_m)
        draw_areas(sheet, areas, len(recording.spec.robots), "scanned first")


def _draw_ahead(sheet: Sheet, robot: RobotState) -> None:
    if robot.ahead is None:
        return
    waypoints = robot.ahead.waypoints
    points = [(robot.configuration.x, robot.configuration.y)]
    for a, b in pairwise(waypoints):
        points += leg_points(a, b)
    layer = sheet.layer(f"robot {robot.robot}: path ahead", AHEAD)
    child(layer, "path", d=sheet.pen.line(points))
    goal = sheet.layer(f"robot {robot.robot}: end of the motion", GOAL)
    end = robot.ahead.end
    mark = sheet.pen.marker("diamond", end.x, end.y, sheet.metres(1.6 * GOAL_MM))
    child(goal, "path", d=mark)


def _draw_body(sheet: Sheet, robot: RobotState, footprint: str) -> None:
    style = DEAD if robot.state == "dead" else RobotStyles.of(robot.robot).end
    layer = sheet.layer(f"robot {robot.robot}: body", style)
    outline = Footprint.parse(footprint).placed(robot.configuration)
    child(layer, "path", d=sheet.pen.rings([shapely.get_coordinates(outline)]))
