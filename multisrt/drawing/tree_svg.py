"""The picture of a run: its exploration trees, or the paths of frontier bidding."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Final

import numpy as np
import shapely

from multisrt.drawing.account import description, heading, legend, swatches, swatches_heading
from multisrt.drawing.areas import seen_first
from multisrt.drawing.axes import on_axes
from multisrt.drawing.colours import (
    CLOSED,
    FRONTIER,
    NODE_MM,
    STAGES,
    RobotStyles,
    Style,
)
from multisrt.drawing.marks import draw_areas, draw_starts_and_ends, draw_stops
from multisrt.drawing.paths_svg import draw_paths
from multisrt.drawing.sheet import Sheet
from multisrt.drawing.svg import child
from multisrt.drawing.traces import Trace, joined, median_edge_m, traces_of
from multisrt.environments.environment import Environment
from multisrt.events import NodeAdded
from multisrt.geometry.numerics.kernel import FloatArray
from multisrt.recording import Recording, atomic_write

if TYPE_CHECKING:
    from matplotlib.axes import Axes

NODE_SHARE: Final = 0.2
"""Radius of a node as a share of the median edge, clipped to `NODE_MM`."""

SIMPLER_MM: Final = 0.015
"""Tolerance of the outlines of regions, in millimetres on paper."""


def tree_svg(recording: Recording) -> str:
    """Return a picture of a run.

    It shows regions, edges and nodes of the trees and the open frontier. Of frontier bidding it
    shows the explored cells, the paths and the goals.

    Parameters
    ----------
    recording : Recording
        Recording of the run.

    Returns
    -------
    str
        An SVG document with metres as user units. Inkscape shows the regions, edges, nodes etc.
        of each robot as layers. Equal recordings give equal documents.

    Raises
    ------
    InvalidInputError
        If the recording contradicts itself; the message says where.

    Examples
    --------
    >>> import multisrt as ms
    >>> run = ms.explore("open", robots=2, seed=1, max_time_s=10.0)
    >>> tree_svg(run.recording).count("<svg")
    1
    """
    return run_sheet(recording).svg()


def run_sheet(
    recording: Recording,
    status: str | None = None,
    draw_below: Callable[[Sheet], None] | None = None,
) -> Sheet:
    """Return the sheet of `tree_svg`, for other formats.

    Parameters
    ----------
    recording : Recording
        Recording of the run.
    status : str, optional
        What the heading says instead of the outcome.
    draw_below : callable, optional
        Draws on the ground, below all else.
    """
    environment = recording.environment()
    traces = traces_of(recording)
    sheet = Sheet(environment, heading(recording, traces, status), description(recording))
    team = len(traces) > 1
    sheet.draw_ground("free space that is on no map")
    if draw_below is not None:
        draw_below(sheet)
    if any(trace.scans for trace in traces):
        draw_paths(sheet, recording, environment, traces)
    else:
        _draw_trees(sheet, recording, environment, traces)
    if team:
        sheet.swatches = swatches(traces)
        sheet.swatches_heading = swatches_heading(traces)
    return sheet


def save_tree_svg(recording: Recording, path: str | Path) -> None:
    """Write the picture of a run to a file; see `tree_svg`.

    The file appears once it is complete.

    Parameters
    ----------
    recording : Recording
        Recording of the run.
    path : str or Path
        The file, which is replaced if it exists. Its folder must exist.

    Raises
    ------
    InvalidInputError
        If the recording contradicts itself, or the file cannot be written.

    Examples
    --------
    >>> import multisrt as ms
    >>> save_tree_svg(ms.explore("open", seed=1, max_time_s=10.0).recording, "tree.svg")
    >>> Path("tree.svg").read_text().count("<svg")
    1
    """
    text = tree_svg(recording)
    with atomic_write(Path(path)) as file:
        file.write(text.encode())


def plot_run(recording: Recording, ax: Axes | None = None) -> Axes:
    """Draw the picture of a run on axes of matplotlib; see `multisrt.Run.plot`."""
    return on_axes(run_sheet(recording), ax)


def _draw_trees(
    sheet: Sheet, recording: Recording, environment: Environment, traces: list[Trace]
) -> None:
    team, node_mm = len(traces) > 1, _node_mm(traces, sheet.mm)
    if team:
        draw_areas(sheet, _areas(recording, sheet), len(traces))
    for trace in traces:
        styles = RobotStyles.of(trace.robot)
        _draw_regions(sheet, trace, styles.outline if team else styles.region)
    sheet.draw_obstacles(environment)
    for trace in traces:
        styles = RobotStyles.of(trace.robot)
        _draw_path(sheet, trace, styles.team_path if team else styles.path)
    for draw in (_draw_supporting, _draw_bridges, _draw_edges):
        for trace in traces:
            draw(sheet, trace)
    for trace in traces:
        _draw_nodes(sheet, trace, node_mm)
    for draw in (_draw_closed_arcs, _draw_frontier, draw_stops):
        for trace in traces:
            draw(sheet, trace)
    draw_starts_and_ends(sheet, traces)
    sheet.legend += legend(traces)


def _areas(recording: Recording, sheet: Sheet) -> dict[int, list[FloatArray]]:
    nodes = [event for event in recording.events if isinstance(event, NodeAdded)]
    regions = [_region(node, sheet.mm) for node in nodes]
    return seen_first(regions, [node.robot for node in nodes], 10.0**-sheet.pen.decimals)


def _draw_regions(sheet: Sheet, trace: Trace, style: Style) -> None:
    layer = sheet.layer(f"robot {trace.robot}: regions", style)
    for node in trace.nodes.values():
        path = sheet.pen.rings([shapely.get_coordinates(_region(node, sheet.mm))])
        child(layer, "path", id=f"robot-{trace.robot}-region-{node.serial}", d=path)


def _region(node: NodeAdded, mm: float) -> shapely.Polygon:
    # Arcs have more corners than are visible.
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


def _node_mm(traces: list[Trace], mm: float) -> float:
    edge = median_edge_m(traces)
    return NODE_MM[1] if edge is None else float(np.clip(NODE_SHARE * edge / mm, *NODE_MM))
