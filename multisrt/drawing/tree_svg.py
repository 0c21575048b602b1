"""The picture of exploration trees."""

from __future__ import annotations

from pathlib import Path
from typing import Final

import numpy as np
import shapely

from multisrt.drawing.account import description, heading, legend, swatches, swatches_heading
from multisrt.drawing.areas import seen_first
from multisrt.drawing.colours import (
    BADGE_MM,
    CLOSED,
    COLLISION,
    DEATH,
    DEATH_MM,
    END,
    END_MM,
    FRONTIER,
    HALO,
    LATE_START,
    NODE_MM,
    STAGES,
    START,
    START_MM,
    STOP,
    STOP_MM,
    RobotStyles,
    Style,
)
from multisrt.drawing.sheet import TEXT_MM, Sheet
from multisrt.drawing.svg import child
from multisrt.drawing.traces import Trace, joined, median_edge_m, traces_of
from multisrt.events import Died, NodeAdded
from multisrt.recording import Recording, written_whole

NODE_SHARE: Final = 0.2
"""A node's radius as a share of the median edge, within that range."""

BADGE_SHARE: Final = 0.45
"""That radius as a share of the distance to the next start, within that range."""

SIMPLER_MM: Final = 0.015
"""Outlines of regions are drawn to within this."""


def tree_svg(recording: Recording) -> str:
    """Draw a run's exploration tree: regions, edges, nodes, and what frontier was left.

    Parameters
    ----------
    recording : Recording
        What happened.

    Returns
    -------
    str
        An SVG document; its user units are metres. Every kind of thing of every robot is a
        layer of its own in Inkscape. Equal recordings give equal documents.

    Raises
    ------
    InvalidInputError
        If the recording contradicts itself; the message says where.
    """
    environment = recording.environment()
    traces = traces_of(recording)
    sheet = Sheet(environment, heading(recording, traces), description(recording))
    node_mm, badge_mm = _node_mm(traces, sheet.mm), _badge_mm(traces, sheet.mm)
    team = len(traces) > 1
    sheet.draw_ground("free space, not seen")
    if team:
        _draw_areas(sheet, recording)
    for trace in traces:
        styles = RobotStyles.of(trace.robot)
        _draw_regions(sheet, trace, styles.outline if team else styles.region)
    sheet.draw_obstacles(environment)
    for trace in traces:
        styles = RobotStyles.of(trace.robot)
        _draw_path(sheet, trace, styles.way if team else styles.path)
    for draw in (_draw_supporting, _draw_bridges, _draw_edges):
        for trace in traces:
            draw(sheet, trace)
    for trace in traces:
        _draw_nodes(sheet, trace, node_mm)
    for draw in (_draw_closed_arcs, _draw_frontier, _draw_stops):
        for trace in traces:
            draw(sheet, trace)
    for trace in traces:
        if team:
            _draw_badge(sheet, trace, badge_mm)
        else:
            _draw_start(sheet, trace)
        _draw_end(sheet, trace, team)
    sheet.legend += legend(traces)
    if team:
        sheet.swatches = swatches(traces)
        sheet.swatches_heading = swatches_heading(len(traces))
    return sheet.svg()


def save_tree_svg(recording: Recording, path: str | Path) -> None:
    """Draw a run's exploration tree into a file, wholly or not at all.

    Raises
    ------
    InvalidInputError
        If the recording contradicts itself, or the file cannot be written.
    """
    text = tree_svg(recording)
    with written_whole(Path(path)) as file:
        file.write(text.encode())


def _draw_areas(sheet: Sheet, recording: Recording) -> None:
    nodes = [event for event in recording.events if isinstance(event, NodeAdded)]
    regions = [_region(node, sheet.mm) for node in nodes]
    areas = seen_first(regions, [node.robot for node in nodes], 10.0**-sheet.pen.decimals)
    for robot in range(len(recording.starts)):
        style = RobotStyles.of(robot).area
        layer = sheet.layer(f"robot {robot}: seen first", style, fill_rule="evenodd")
        if rings := areas.get(robot):
            child(layer, "path", d=sheet.pen.rings(rings))


def _draw_regions(sheet: Sheet, trace: Trace, style: Style) -> None:
    layer = sheet.layer(f"robot {trace.robot}: regions", style)
    for node in trace.nodes.values():
        path = sheet.pen.rings([shapely.get_coordinates(_region(node, sheet.mm))])
        child(layer, "path", id=f"robot-{trace.robot}-region-{node.serial}", d=path)


def _region(node: NodeAdded, mm: float) -> shapely.Polygon:
    # Round arcs have more corners than anybody can see.
    return shapely.simplify(shapely.Polygon(node.boundary), SIMPLER_MM * mm)


def _draw_path(sheet: Sheet, trace: Trace, style: Style) -> None:
    layer = sheet.layer(f"robot {trace.robot}: path", style)
    if trace.motions:
        child(layer, "path", d=sheet.pen.line(trace.path))


def _draw_supporting(sheet: Sheet, trace: Trace) -> None:
    if trace.supporting:
        style = RobotStyles.of(trace.robot).support
        layer = sheet.layer(f"robot {trace.robot}: supporting moves", style)
        child(layer, "path", d="".join(map(sheet.pen.line, trace.supporting)))


def _draw_bridges(sheet: Sheet, trace: Trace) -> None:
    if trace.bridges:
        style = RobotStyles.of(trace.robot).bridge
        layer = sheet.layer(f"robot {trace.robot}: bridges", style)
        child(layer, "path", d="".join(map(sheet.pen.line, trace.bridges)))


def _draw_edges(sheet: Sheet, trace: Trace) -> None:
    layer = sheet.layer(f"robot {trace.robot}: tree", RobotStyles.of(trace.robot).edge)
    for tree, edges in trace.edges.items():
        path = "".join(map(sheet.pen.line, edges))
        child(layer, "path", id=f"robot-{trace.robot}-edges-in-tree-{tree}", d=path)


def _draw_nodes(sheet: Sheet, trace: Trace, node_mm: float) -> None:
    styles = RobotStyles.of(trace.robot)
    layer = sheet.layer(f"robot {trace.robot}: nodes", styles.node.scaled(node_mm / NODE_MM[1]))
    for stage, (marker, _) in STAGES.items():
        places = [node.configuration[:2] for node in trace.nodes.values() if node.stage == stage]
        if places:
            size = node_mm * sheet.mm
            path = "".join(sheet.pen.marker(marker, x, y, size) for x, y in places)
            child(layer, "path", id=f"robot-{trace.robot}-nodes-{stage}", d=path)


def _draw_closed_arcs(sheet: Sheet, trace: Trace) -> None:
    layer = sheet.layer(f"robot {trace.robot}: frontier given up")
    for reason, style in CLOSED.items():
        arcs = [event.arc for event in trace.closed if event.reason == reason]
        lines = [line for arc in arcs for line in joined(arc)]
        if lines:
            path = "".join(map(sheet.pen.line, lines))
            child(layer, "path", d=path, **style.attributes(sheet.mm))


def _draw_frontier(sheet: Sheet, trace: Trace) -> None:
    layer = sheet.layer(f"robot {trace.robot}: frontier", FRONTIER)
    if trace.frontier:
        child(layer, "path", d="".join(map(sheet.pen.line, joined(trace.frontier))))


def _draw_stops(sheet: Sheet, trace: Trace) -> None:
    if trace.stops:
        layer = sheet.layer(f"robot {trace.robot}: protective stops", STOP)
        places = dict.fromkeys(event.configuration[:2] for event in trace.stops)
        size = STOP_MM * sheet.mm
        path = "".join(sheet.pen.marker("octagon", x, y, size) for x, y in places)
        child(layer, "path", d=path)


def _draw_start(sheet: Sheet, trace: Trace) -> None:
    x, y, heading = trace.start
    layer = sheet.layer(f"robot {trace.robot}: start", LATE_START if trace.late else START)
    child(layer, "path", d=sheet.pen.marker("arrow", x, y, START_MM * sheet.mm, heading))


def _draw_badge(sheet: Sheet, trace: Trace, badge_mm: float) -> None:
    # Where a robot of a team started, with its number.
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


def _node_mm(traces: list[Trace], mm: float) -> float:
    edge = median_edge_m(traces)
    return NODE_MM[1] if edge is None else float(np.clip(NODE_SHARE * edge / mm, *NODE_MM))


def _badge_mm(traces: list[Trace], mm: float) -> float:
    if len(traces) == 1:
        return BADGE_MM[1]
    starts = shapely.points([trace.start[:2] for trace in traces])
    apart = shapely.distance(starts[:, None], starts[None, :])
    np.fill_diagonal(apart, np.inf)
    crowd = float(np.quantile(apart.min(axis=0), 0.1))
    return float(np.clip(BADGE_SHARE * crowd / mm, *BADGE_MM))
