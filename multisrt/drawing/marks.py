"""Marks that pictures of all kinds of runs share: areas seen, starts, ends, and stops."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

import numpy as np
import shapely

from multisrt.drawing.colours import (
    BADGE_MM,
    COLLISION,
    DEATH,
    DEATH_MM,
    END,
    END_MM,
    HALO,
    LATE_START,
    START,
    START_MM,
    STOP,
    STOP_MM,
    RobotStyles,
)
from multisrt.drawing.sheet import TEXT_MM, Sheet
from multisrt.drawing.svg import child
from multisrt.drawing.traces import Trace
from multisrt.events import Died
from multisrt.geometry.numerics.kernel import FloatArray

BADGE_SHARE: Final = 0.45
"""Radius of a start as a share of the distance to the next start, clipped to `BADGE_MM`."""


def draw_starts_and_ends(sheet: Sheet, traces: list[Trace]) -> None:
    """Mark the start and the last position of every robot, its death and its collisions."""
    team = len(traces) > 1
    badge_mm = _badge_mm(traces, sheet.mm)
    for trace in traces:
        if team:
            _draw_badge(sheet, trace, badge_mm)
        else:
            _draw_start(sheet, trace)
        _draw_end(sheet, trace, team)


def draw_stops(sheet: Sheet, trace: Trace) -> None:
    """Mark the places where the protective stop of a robot ended a motion."""
    if trace.stops:
        layer = sheet.layer(f"robot {trace.robot}: protective stops", STOP)
        places = dict.fromkeys(event.configuration[:2] for event in trace.stops)
        size = STOP_MM * sheet.mm
        path = "".join(sheet.pen.marker("octagon", x, y, size) for x, y in places)
        child(layer, "path", d=path)


def draw_areas(
    sheet: Sheet,
    areas: Mapping[int, list[FloatArray]],
    robots: int,
    label: str = "seen first",
) -> None:
    """Fill the rings of the area that each robot saw first with the colour of the robot."""
    for robot in range(robots):
        style = RobotStyles.of(robot).area
        layer = sheet.layer(f"robot {robot}: {label}", style, fill_rule="evenodd")
        if rings := areas.get(robot):
            child(layer, "path", d=sheet.pen.rings(rings))


def _draw_start(sheet: Sheet, trace: Trace) -> None:
    x, y, heading = trace.start
    layer = sheet.layer(f"robot {trace.robot}: start", LATE_START if trace.late else START)
    child(layer, "path", d=sheet.pen.marker("arrow", x, y, START_MM * sheet.mm, heading))


def _draw_badge(sheet: Sheet, trace: Trace, badge_mm: float) -> None:
    # The start of a robot in a team, with the number of the robot.
    x, y, heading = trace.start
    styles = RobotStyles.of(trace.robot)
    style = styles.late_start if trace.late else styles.start
    layer = sheet.layer(f"robot {trace.robot}: start", style.scaled(badge_mm / BADGE_MM[1]))
    child(layer, "path", d=sheet.pen.marker("pin", x, y, badge_mm * sheet.mm, heading))
    number = str(trace.robot)
    sheet.label(layer, number, (x, y), badge_mm * (1.5 if len(number) == 1 else 1.3))


def _draw_end(sheet: Sheet, trace: Trace, team: bool) -> None:
    if trace.death is not None:
        _draw_death(sheet, trace, trace.death)
    elif trace.is_away:
        x, y, heading = trace.end
        style = RobotStyles.of(trace.robot).end if team else END
        end = sheet.layer(f"robot {trace.robot}: end", style)
        child(end, "path", d=sheet.pen.marker("arrow", x, y, END_MM * sheet.mm, heading))
    if trace.collisions:
        layer = sheet.layer(f"robot {trace.robot}: collision", COLLISION)
        for event in trace.collisions:
            x, y, _ = event.configuration
            child(layer, "path", d=sheet.pen.marker("cross", x, y, START_MM * sheet.mm))


def _draw_death(sheet: Sheet, trace: Trace, death: Died) -> None:
    layer = sheet.layer(f"robot {trace.robot}: death")
    x, y, _ = death.configuration
    cross = sheet.pen.marker("cross", x, y, DEATH_MM * sheet.mm)
    for style in (HALO, DEATH):
        child(layer, "path", d=cross, **style.attributes(sheet.mm))
    beside = (x + 1.9 * DEATH_MM * sheet.mm, y + 1.5 * DEATH_MM * sheet.mm)
    sheet.label(layer, str(trace.robot), beside, TEXT_MM, halo_mm=0.8)


def _badge_mm(traces: list[Trace], mm: float) -> float:
    if len(traces) == 1:
        return BADGE_MM[1]
    starts = shapely.points([trace.start[:2] for trace in traces])
    apart = shapely.distance(starts[:, None], starts[None, :])
    np.fill_diagonal(apart, np.inf)
    crowd = float(np.quantile(apart.min(axis=0), 0.1))
    return float(np.clip(BADGE_SHARE * crowd / mm, *BADGE_MM))
