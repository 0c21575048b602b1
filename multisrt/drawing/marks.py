"""Marks that pictures of all kinds of runs share: areas seen, starts, ends, and stops."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Final

from multisrt.drawing.badges import (
    BADGE_MM,
    Box,
    Disc,
    badge_radius_mm,
    box_at,
    label_place,
    spread,
)
from multisrt.drawing.colours import (
    BASE_MM,
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
from multisrt.drawing.svg import child, text_width
from multisrt.drawing.traces import Trace
from multisrt.environments.own_pictures import LINES_TO_STARTS, TO_START
from multisrt.events import Died
from multisrt.geometry.numerics.kernel import FloatArray
from multisrt.spec import BaseSpec

PIN_REACH: Final = 1.6
"""Distance of the tip of a badge from its centre, in radii."""


def draw_starts_and_ends(
    sheet: Sheet,
    traces: list[Trace],
    without: frozenset[str] = frozenset(),
    base: BaseSpec | None = None,
) -> None:
    """Mark the start and the last position of every robot, its death and its collisions.

    Numbers stand above all markers, and badges where they cover neither one another nor an end or
    the base station.

    Parameters
    ----------
    sheet : Sheet
        Where to draw.
    traces : list of Trace
        The robots.
    without : frozenset of str
        Layers that are left out; see `multisrt.drawing.layers`.
    base : BaseSpec, optional
        The base station of the run, which is drawn already.
    """
    team = len(traces) > 1
    ends = list(_ends(sheet, traces, without))
    if base is not None and "base" not in without:
        ends.append(Disc(*base.place, sheet.metres(BASE_MM)))
    for trace in traces:
        if "ends" not in without:
            _draw_end(sheet, trace, team)
        if "failures" not in without:
            _draw_collisions(sheet, trace)
    # Boxes of badges, which labels of deaths must not cover.
    taken: list[Box] = [box_at((x, y), (2.0 * r, 2.0 * r)) for x, y, r in ends]
    badges: list[Disc] = []
    if "starts" not in without and team:
        starts = [trace.start[:2] for trace in traces]
        radius_mm = badge_radius_mm(starts, sheet.metres(1.0))
        least_mm = sheet.min_number_mm / (sheet.weight * _number_share(str(len(traces) - 1)))
        radius_mm = max(radius_mm, least_mm)
        places = spread(starts, sheet.metres(radius_mm), ends, sheet.bounds)
        badges = [Disc(float(x), float(y), sheet.metres(radius_mm)) for x, y in places]
        reach = 2.0 * PIN_REACH * sheet.metres(radius_mm)
        taken += [box_at((x, y), (reach, reach)) for x, y, _ in badges]
    if "failures" not in without:
        for trace in traces:
            if trace.death is not None:
                _draw_death(sheet, trace, trace.death, taken)
    _draw_leaders(sheet, traces, badges)
    for trace, badge in zip(traces, badges, strict=False):
        _draw_badge(sheet, trace, badge)
    if "starts" not in without and not team:
        _draw_start(sheet, traces[0])


def draw_stops(sheet: Sheet, trace: Trace) -> None:
    """Mark the places where the protective stop of a robot ended a motion."""
    if trace.stops:
        layer = sheet.layer(f"robot {trace.robot}: protective stops", STOP)
        places = dict.fromkeys(event.configuration[:2] for event in trace.stops)
        size = sheet.metres(STOP_MM)
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


def _ends(sheet: Sheet, traces: list[Trace], without: frozenset[str]) -> Iterator[Disc]:
    # What the badges of starts keep clear of.
    for trace in traces:
        if trace.death is not None:
            if "failures" not in without:
                yield Disc(*trace.death.configuration[:2], sheet.metres(DEATH_MM))
        elif trace.is_away and "ends" not in without:
            yield Disc(*trace.end[:2], sheet.metres(0.8 * END_MM))
        if "failures" not in without:
            for event in trace.collisions:
                yield Disc(*event.configuration[:2], sheet.metres(START_MM))


def _draw_start(sheet: Sheet, trace: Trace) -> None:
    x, y, heading = trace.start
    layer = sheet.layer(f"robot {trace.robot}: start", LATE_START if trace.late else START)
    child(layer, "path", d=sheet.pen.marker("arrow", x, y, sheet.metres(START_MM), heading))


def _draw_leaders(sheet: Sheet, traces: list[Trace], badges: list[Disc]) -> None:
    # Lines from starts to badges that had to be moved, below all badges.
    moved = [
        (trace, badge)
        for trace, badge in zip(traces, badges, strict=False)
        if math.dist(trace.start[:2], badge[:2]) > 0.5 * badge.radius
    ]
    if not moved:
        return
    layer = sheet.layer(LINES_TO_STARTS)
    for trace, badge in moved:
        styles = RobotStyles.of(trace.robot)
        line = sheet.pen.line([trace.start[:2], badge[:2]])
        child(layer, "path", d=line, **sheet.attributes(styles.bridge))
        dot = sheet.pen.marker("disc", *trace.start[:2], 0.25 * badge.radius)
        child(layer, "path", d=dot, **sheet.attributes(replace(styles.node, stroke=None)))


def _draw_badge(sheet: Sheet, trace: Trace, badge: Disc) -> None:
    # The start of a robot in a team, with the number of the robot.
    heading = trace.start.heading
    radius_mm = badge.radius / sheet.metres(1.0)
    styles = RobotStyles.of(trace.robot)
    style = styles.late_start if trace.late else styles.start
    layer = sheet.layer(f"robot {trace.robot}: start", style.scaled(radius_mm / BADGE_MM[1]))
    pin = child(layer, "path", d=sheet.pen.marker("pin", badge.x, badge.y, badge.radius, heading))
    if badge[:2] != trace.start[:2]:
        decimals = sheet.pen.decimals + 1
        dx, dy = trace.start.x - badge.x, trace.start.y - badge.y
        pin.set(TO_START, f"{dx:.{decimals}f} {dy:.{decimals}f}")
    number = str(trace.robot)
    size_mm = radius_mm * sheet.weight * _number_share(number)
    sheet.label(layer, number, (badge.x, badge.y), size_mm)


def _number_share(number: str) -> float:
    # The size of the number of a badge, in radii of the badge.
    return 1.5 if len(number) == 1 else 1.3


def _draw_end(sheet: Sheet, trace: Trace, team: bool) -> None:
    if trace.death is None and trace.is_away:
        x, y, heading = trace.end
        style = RobotStyles.of(trace.robot).end if team else END
        end = sheet.layer(f"robot {trace.robot}: end", style)
        child(end, "path", d=sheet.pen.marker("arrow", x, y, sheet.metres(END_MM), heading))


def _draw_collisions(sheet: Sheet, trace: Trace) -> None:
    if trace.collisions:
        layer = sheet.layer(f"robot {trace.robot}: collision", COLLISION)
        for event in trace.collisions:
            x, y, _ = event.configuration
            child(layer, "path", d=sheet.pen.marker("cross", x, y, sheet.metres(START_MM)))


def _draw_death(sheet: Sheet, trace: Trace, death: Died, taken: list[Box]) -> None:
    # Its number stands where it covers no badge and no other number.
    layer = sheet.layer(f"robot {trace.robot}: death")
    x, y, _ = death.configuration
    cross = sheet.pen.marker("cross", x, y, sheet.metres(DEATH_MM))
    for style in (HALO, DEATH):
        child(layer, "path", d=cross, **sheet.attributes(style))
    number = str(trace.robot)
    size = sheet.metres(text_width(number, TEXT_MM)), sheet.metres(TEXT_MM)
    beside = label_place((x, y), size, sheet.metres(1.1 * DEATH_MM), taken)
    taken.append(box_at(beside, size))
    sheet.label(layer, number, beside, TEXT_MM * sheet.weight, halo_mm=0.8 * sheet.weight)
