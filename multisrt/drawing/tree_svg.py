"""The picture of an exploration tree."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Final

import numpy as np
import shapely

from multisrt.drawing.colours import (
    CLOSED,
    COLLISION,
    END,
    FRONTIER,
    START,
    RobotStyles,
)
from multisrt.drawing.sheet import LegendEntry, Sheet
from multisrt.drawing.svg import Marker, child
from multisrt.drawing.traces import Trace, joined, median_edge_m, traces_of
from multisrt.events import Stage
from multisrt.recording import Recording, written_whole

NODE_MM: Final = (0.3, 0.8)
"""Nodes are drawn with a radius in this range: smaller where they stand close together."""

NODE_SHARE: Final = 0.2
"""A node's radius as a share of the median edge, within that range."""

SIMPLER_MM: Final = 0.015
"""Outlines of regions are drawn to within this."""

START_MM: Final = 2.0
END_MM: Final = 1.7

STAGES: Final[dict[Stage, tuple[Marker, str]]] = {
    "root": ("square", "root node"),
    "draw": ("disc", "node drawn at random"),
    "approach": ("triangle", "node on the way to a frontier"),
    "complete": ("diamond", "node for a frontier left behind"),
}
"""How nodes are marked by how the planner found their place."""

OUTCOMES: Final = {"complete": "complete", "stalled": "stalled", "out_of_time": "out of time"}


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
    sheet = Sheet(environment, _heading(recording, traces), _description(recording))
    node_mm = _node_mm(traces, sheet.mm)
    sheet.draw_ground("free space, not seen")
    for trace in traces:
        _draw_regions(sheet, trace)
    sheet.draw_obstacles(environment)
    for draw in (_draw_path, _draw_edges):
        for trace in traces:
            draw(sheet, trace)
    for trace in traces:
        _draw_nodes(sheet, trace, node_mm)
    for draw in (_draw_closed_arcs, _draw_frontier, _draw_ends):
        for trace in traces:
            draw(sheet, trace)
    if len(traces) > 1:
        _draw_numbers(sheet, traces)
    sheet.legend += _legend(traces)
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


def _draw_regions(sheet: Sheet, trace: Trace) -> None:
    layer = sheet.layer(f"robot {trace.robot}: regions", RobotStyles.of(trace.robot).region)
    for node in trace.nodes.values():
        # Round arcs have more corners than anybody can see.
        outline = shapely.simplify(shapely.Polygon(node.boundary), SIMPLER_MM * sheet.mm)
        path = sheet.pen.rings([shapely.get_coordinates(outline)])
        child(layer, "path", id=f"robot-{trace.robot}-region-{node.serial}", d=path)


def _draw_path(sheet: Sheet, trace: Trace) -> None:
    layer = sheet.layer(f"robot {trace.robot}: path", RobotStyles.of(trace.robot).path)
    if trace.motions:
        child(layer, "path", d=sheet.pen.line(trace.path))


def _draw_edges(sheet: Sheet, trace: Trace) -> None:
    layer = sheet.layer(f"robot {trace.robot}: tree", RobotStyles.of(trace.robot).edge)
    if edges := trace.edges():
        child(layer, "path", d="".join(sheet.pen.line(edge) for edge in edges))


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


def _draw_ends(sheet: Sheet, trace: Trace) -> None:
    x, y, heading = trace.start
    start = sheet.layer(f"robot {trace.robot}: start", START)
    child(start, "path", d=sheet.pen.marker("arrow", x, y, START_MM * sheet.mm, heading))
    if _is_away(trace):
        x, y, heading = trace.end
        end = sheet.layer(f"robot {trace.robot}: end", END)
        child(end, "path", d=sheet.pen.marker("arrow", x, y, END_MM * sheet.mm, heading))
    if trace.collisions:
        layer = sheet.layer(f"robot {trace.robot}: collision", COLLISION)
        for event in trace.collisions:
            x, y, _ = event.configuration
            child(layer, "path", d=sheet.pen.marker("cross", x, y, START_MM * sheet.mm))


def _draw_numbers(sheet: Sheet, traces: list[Trace]) -> None:
    layer = sheet.layer("robots' numbers")
    for trace in traces:
        sheet.label(layer, str(trace.robot), trace.start.x, trace.start.y)


def _legend(traces: list[Trace]) -> list[LegendEntry]:
    # Only what there is on the map.
    styles = RobotStyles.of(0)
    team = len(traces) > 1
    nodes = [node for trace in traces for node in trace.nodes.values()]
    entries = [LegendEntry(label="local safe region", style=styles.region.scaled(2.0))]
    if team:
        entries += [
            LegendEntry(label=f"tree of robot {t.robot}", style=RobotStyles.of(t.robot).edge)
            for t in traces
        ]
    elif any(trace.edges() for trace in traces):
        entries.append(LegendEntry(label="edge of the tree", style=styles.edge))
    for stage, (marker, label) in STAGES.items():
        if stage != "root" and any(node.stage == stage for node in nodes):
            entries.append(
                LegendEntry(label=label, style=styles.node, marker=marker, size_mm=NODE_MM[1])
            )
    if any(trace.is_off_tree() for trace in traces):
        entries.append(LegendEntry(label="way travelled off the tree", style=styles.path))
    if any(trace.frontier for trace in traces):
        entries.append(LegendEntry(label="frontier left open", style=FRONTIER))
    reasons = {event.reason for trace in traces for event in trace.closed}
    entries += [
        LegendEntry(label=f"frontier given up: {reason}", style=style)
        for reason, style in CLOSED.items()
        if reason in reasons
    ]
    entries.append(LegendEntry(label="start", style=START, marker="arrow", size_mm=START_MM))
    if any(map(_is_away, traces)):
        entries.append(LegendEntry(label="end", style=END, marker="arrow", size_mm=END_MM))
    if any(trace.collisions for trace in traces):
        entries.append(
            LegendEntry(label="collision", style=COLLISION, marker="cross", size_mm=START_MM)
        )
    return entries


def _heading(recording: Recording, traces: list[Trace]) -> list[str]:
    spec, footer = recording.spec, recording.footer
    team = f", {len(traces)} robots" if len(traces) > 1 else ""
    nodes = sum(len(trace.nodes) for trace in traces)
    distance = math.fsum(trace.distance_m for trace in traces)
    lines = [
        f"{spec.strategy} in {recording.header.world}{team}, seed {spec.seed}",
        f"{OUTCOMES[footer.outcome]} after {footer.time_s:,.0f} s: "
        f"{nodes:,} node{'s' if nodes != 1 else ''}, {distance:,.0f} m travelled",
    ]
    left = math.fsum(math.hypot(x1 - x0, y1 - y0) for t in traces for x0, y0, x1, y1 in t.frontier)
    if left:
        lines[-1] += f", {left:,.1f} m of frontier left open"
    if footer.outcome == "stalled":
        lines.append(footer.reason)
    if spec.options:
        lines.append("with " + ", ".join(f"{k} = {v}" for k, v in spec.options.items()))
    return lines


def _description(recording: Recording) -> str:
    return (
        f"A run of multisrt {recording.header.versions.get('multisrt', '')}, "
        f"digest {recording.footer.digest}."
    )


def _node_mm(traces: list[Trace], mm: float) -> float:
    edge = median_edge_m(traces)
    return NODE_MM[1] if edge is None else float(np.clip(NODE_SHARE * edge / mm, *NODE_MM))


def _is_away(trace: Trace) -> bool:
    # Not where it started, to the eye.
    return trace.end.distance(trace.start) > 1e-3
