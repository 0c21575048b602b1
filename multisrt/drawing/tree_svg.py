"""The picture of a run: its exploration trees, or the paths of frontier bidding."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Final

import numpy as np
import shapely

from multisrt.drawing.account import description, heading, legend, swatches, swatches_heading
from multisrt.drawing.areas import seen_first
from multisrt.drawing.axes import label_axes, on_axes
from multisrt.drawing.base_marks import SIMPLER_MM, draw_base
from multisrt.drawing.colours import (
    CLOSED,
    FRONTIER,
    NODE_MM,
    STAGE_MARKERS,
    RobotStyles,
    Style,
)
from multisrt.drawing.layers import left_out
from multisrt.drawing.marks import draw_areas, draw_starts_and_ends, draw_stops
from multisrt.drawing.paths_svg import draw_paths
from multisrt.drawing.sheet import MAX_MAP_MM, Sheet
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

MAX_OUTLINES: Final = 40
"""Upper bound of the regions of a team that are outlined one by one; of more, each robot's regions
are outlined as one."""


def tree_svg(recording: Recording, *, without: Iterable[str] = ()) -> str:
    """Return a picture of a run.

    It shows regions, edges and nodes of the trees and the open frontier. Of frontier bidding it
    shows the explored cells, the paths and the goals.

    Parameters
    ----------
    recording : Recording
        Recording of the run.
    without : iterable of str, optional
        Layers to leave out: names of `multisrt.drawing.LAYERS` that a map has.

    Returns
    -------
    str
        An SVG document with metres as user units. Inkscape shows the regions, edges, nodes etc.
        of each robot as layers. Equal recordings give equal documents.

    Raises
    ------
    InvalidInputError
        If the recording contradicts itself; the message says where. If there is no such layer.

    Examples
    --------
    >>> import multisrt as ms
    >>> run = ms.explore("open", robots=2, seed=1, max_time_s=10.0)
    >>> tree_svg(run.recording).count("<svg")
    1
    >>> "outline of a" in tree_svg(run.recording, without=["outlines"])
    False
    """
    return run_sheet(recording, without=without).svg()


def run_sheet(
    recording: Recording,
    status: str | None = None,
    draw_below: Callable[[Sheet], None] | None = None,
    *,
    without: Iterable[str] = (),
    bounds_mm: Sequence[tuple[float, float]] = MAX_MAP_MM,
    min_number_mm: float = 0.0,
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
    without : iterable of str, optional
        Layers to leave out; see `tree_svg`.
    bounds_mm : sequence of (width, height), optional
        Bounds of the map on paper; see `Sheet`.
    min_number_mm : float, optional
        Lower bound of the size of the numbers at starts, in millimetres on paper.

    Returns
    -------
    Sheet
        The sheet, with its legend.
    """
    absent = left_out(without)
    environment = recording.environment()
    traces = traces_of(recording)
    title = heading(recording, traces, status)
    sheet = Sheet(environment, title, description(recording), bounds_mm)
    sheet.min_number_mm = min_number_mm
    team = len(traces) > 1
    sheet.draw_ground("free space" if "areas" in absent else "free space that is on no map")
    if draw_below is not None:
        draw_below(sheet)
    if any(trace.scans for trace in traces):
        draw_paths(sheet, recording, environment, traces, absent)
    else:
        _draw_trees(sheet, recording, environment, traces, absent)
    if team:
        sheet.swatches = swatches(traces, absent)
        sheet.swatches_heading = swatches_heading(traces, absent)
    return sheet


def save_tree_svg(recording: Recording, path: str | Path, *, without: Iterable[str] = ()) -> None:
    """Write the picture of a run to a file; see `tree_svg`.

    The file appears once it is complete.

    Parameters
    ----------
    recording : Recording
        Recording of the run.
    path : str or Path
        The file, which is replaced if it exists. Its folder must exist.
    without : iterable of str, optional
        Layers to leave out; see `tree_svg`.

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
    text = tree_svg(recording, without=without)
    with atomic_write(Path(path)) as file:
        file.write(text.encode())


def plot_run(recording: Recording, ax: Axes | None = None, *, without: Iterable[str] = ()) -> Axes:
    """Draw the picture of a run on axes of matplotlib; see `multisrt.Run.plot`."""
    drawn = on_axes(run_sheet(recording, without=without), ax)
    label_axes(drawn, "x (m)", "y (m)")
    return drawn


def _draw_trees(
    sheet: Sheet,
    recording: Recording,
    environment: Environment,
    traces: list[Trace],
    absent: frozenset[str],
) -> None:
    team = len(traces) > 1
    merged = team and sum(len(trace.nodes) for trace in traces) > MAX_OUTLINES
    if team and "areas" not in absent:
        draw_areas(sheet, _areas(recording, sheet), len(traces))
    for trace in traces:
        _draw_regions(sheet, trace, _region_style(trace.robot, team, absent), merged)
    sheet.draw_obstacles(environment)
    for name, draw in (
        ("paths", partial(_draw_path, team=team)),
        ("support", _draw_supporting),
        ("bridges", _draw_bridges),
        ("edges", _draw_edges),
        ("nodes", partial(_draw_nodes, node_mm=_node_mm(traces, sheet.metres(1.0)))),
        ("given-up", _draw_closed_arcs),
        ("frontier", _draw_frontier),
        ("stops", draw_stops),
    ):
        for trace in traces if name not in absent else ():
            draw(sheet, trace)
    at_base = draw_base(sheet, recording, environment, absent)
    draw_starts_and_ends(sheet, traces, absent, recording.spec.base)
    sheet.legend += legend(traces, absent, merged=merged) + at_base


def _region_style(robot: int, team: bool, absent: frozenset[str]) -> Style | None:
    # Regions of a single robot are filled one by one; those of a team are outlines.
    styles = RobotStyles.of(robot)
    style = styles.outline if team else styles.region
    if "outlines" in absent:
        style = replace(style, stroke=None)
    if "areas" in absent:
        style = replace(style, fill=None)
    return style if style.fill or style.stroke else None


def _areas(recording: Recording, sheet: Sheet) -> dict[int, list[FloatArray]]:
    nodes = [event for event in recording.events if isinstance(event, NodeAdded)]
    regions = [_region(node, sheet.mm) for node in nodes]
    return seen_first(regions, [node.robot for node in nodes], 10.0**-sheet.pen.decimals)


def _draw_regions(sheet: Sheet, trace: Trace, style: Style | None, merged: bool) -> None:
    if style is None:
        return
    layer = sheet.layer(f"robot {trace.robot}: regions", style)
    if merged:
        regions = [_region(node, sheet.mm) for node in trace.nodes.values()]
        if rings := seen_first(regions, [0] * len(regions), 10.0**-sheet.pen.decimals):
            child(layer, "path", d=sheet.pen.rings(rings[0]))
        return
    for node in trace.nodes.values():
        path = sheet.pen.rings([shapely.get_coordinates(_region(node, sheet.mm))])
        child(layer, "path", id=f"robot-{trace.robot}-region-{node.serial}", d=path)


def _region(node: NodeAdded, mm: float) -> shapely.Polygon:
    # Arcs have more corners than are visible.
    return shapely.simplify(shapely.Polygon(node.boundary), SIMPLER_MM * mm)


def _draw_path(sheet: Sheet, trace: Trace, team: bool) -> None:
    styles = RobotStyles.of(trace.robot)
    layer = sheet.layer(f"robot {trace.robot}: path", styles.team_path if team else styles.path)
    if trace.off_tree:
        child(layer, "path", d="".join(map(sheet.pen.line, trace.off_tree)))


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
    for stage, marker in STAGE_MARKERS.items():
        places = [node.configuration[:2] for node in trace.nodes.values() if node.stage == stage]
        if places:
            size = sheet.metres(node_mm)
            path = "".join(sheet.pen.marker(marker, x, y, size) for x, y in places)
            child(layer, "path", id=f"robot-{trace.robot}-nodes-{stage}", d=path)


def _draw_closed_arcs(sheet: Sheet, trace: Trace) -> None:
    layer = sheet.layer(f"robot {trace.robot}: frontier given up")
    for reason, style in CLOSED.items():
        arcs = [event.arc for event in trace.closed if event.reason == reason]
        lines = [line for arc in arcs for line in joined(arc)]
        if lines:
            path = "".join(map(sheet.pen.line, lines))
            child(layer, "path", d=path, **sheet.attributes(style))


def _draw_frontier(sheet: Sheet, trace: Trace) -> None:
    layer = sheet.layer(f"robot {trace.robot}: frontier", FRONTIER)
    if trace.frontier:
        child(layer, "path", d="".join(map(sheet.pen.line, joined(trace.frontier))))


def _node_mm(traces: list[Trace], mm: float) -> float:
    edge = median_edge_m(traces)
    return NODE_MM[1] if edge is None else float(np.clip(NODE_SHARE * edge / mm, *NODE_MM))
