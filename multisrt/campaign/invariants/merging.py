"""Maps do not depend on the order of merging, and closings apply only where they should."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, Final

import numpy as np

from multisrt.analysis.recorded_map import recorded_closing, recorded_node
from multisrt.campaign.judged_run import ROUNDING_M, JudgedRun
from multisrt.campaign.violations import Violation
from multisrt.events import ArcClosed, NodeName
from multisrt.geometry.bodies.footprint import Footprint
from multisrt.geometry.grids.occupancy import Occupancy
from multisrt.robots.exploration_map import Closing, Entry, ExplorationMap, Node
from multisrt.robots.frontier.scan_map import raster_for

NAME: Final = "merge-order"
CLOSINGS: Final = "closings-apply-where-valid"

MAX_ROBOTS: Final = 2
"""Number of robots of a run whose maps are merged again."""

MAX_NODES: Final = 40
"""Number of nodes of each that are merged."""


def merge_order(run: JudgedRun) -> Violation | None:
    """Check that the nodes and closings that a robot knew give the same map in any order.

    For up to two robots, drawn from the digest of the run, up to 40 nodes, in the order in which
    the robot came to know them, and then all closings of the run are merged as they are and in a
    random order. The frontiers of
    all nodes, the roots and the open nodes are exactly equal. For robots that bid for frontiers, a
    raster filled in both orders has the same cells, passable cells and frontier groups.

    Cost: some tens of milliseconds.
    """
    for robot, entries, others in _drawn(run):
        what = _differs(_merged(run, robot, entries), _merged(run, robot, others))
        if what is None and run.family == "frontier":
            what = _differs(_painted(run, robot, entries), _painted(run, robot, others))
        if what is not None:
            return Violation(
                invariant=NAME,
                says=f"what robot {robot} knew of {_nodes(entries)} nodes, merged in another "
                f"order, gives other {what}",
                robot=robot,
            )
    return None


def closings_apply_where_valid(run: JudgedRun) -> Violation | None:
    """Check that a robot omits arcs closed by others only if their reason applies to it.

    For the nodes and closings of `merge_order`: an arc that another robot closed as not reachable,
    or that a wider robot closed as too narrow, stays part of the frontier. A map into which such
    closings are merged is therefore exactly equal to the map without them.

    Cost: a few milliseconds, if there are such closings.
    """
    for robot, entries, _ in _drawn(run):
        width_m = Footprint.parse(run.recording.spec.robots[robot].footprint).width_m
        concerning = [entry for entry in entries if _concerns(entry, robot, width_m)]
        if len(concerning) == len(entries):
            continue
        what = _differs(_merged(run, robot, entries), _merged(run, robot, concerning))
        if what is not None:
            return Violation(
                invariant=CLOSINGS,
                says=f"what others gave up for themselves changes the map of robot {robot}: with "
                f"{len(entries) - len(concerning)} such arcs it has other {what}",
                robot=robot,
            )
    return None


def _concerns(entry: Entry, robot: int, width_m: float) -> bool:
    if not isinstance(entry, Closing) or entry.id.robot == robot:
        return True
    if entry.reason == "too narrow":
        return width_m > entry.width_m - ROUNDING_M
    return entry.reason == "seen from near"


def _drawn(run: JudgedRun) -> Iterator[tuple[int, list[Entry], list[Entry]]]:
    """Yield some robots, each with its entries in the order of the run and in a random order."""
    rng = np.random.default_rng(int(run.recording.footer.digest[:8] or "0", 16))
    robots = rng.permutation(len(run.robots))[:MAX_ROBOTS].tolist()
    for robot in robots:
        names = list(run.known[robot])
        kept = sorted(rng.permutation(len(names))[:MAX_NODES].tolist())
        entries = _entries(run, [names[k] for k in kept])
        others = [entries[k] for k in rng.permutation(len(entries)).tolist()]
        yield robot, entries, others


def _nodes(entries: list[Entry]) -> int:
    return sum(isinstance(entry, Node) for entry in entries)


def _entries(run: JudgedRun, names: list[NodeName]) -> list[Entry]:
    robots = run.recording.spec.robots
    entries: list[Entry] = [
        recorded_node(run.nodes[name], robots[name[0]].range_finder.range_m) for name in names
    ]
    widths = [Footprint.parse(spec.footprint).width_m for spec in robots]
    for serial, closed in enumerate(run.recording.of(ArcClosed)):
        if closed.reason != "blocked by a robot":
            width_m = widths[closed.robot]
            entries.append(recorded_closing(closed, closed.reason, serial, width_m))
    return entries


def _merged(run: JudgedRun, robot: int, entries: list[Entry]) -> dict[str, Any]:
    specs = run.recording.spec.robots
    known = ExplorationMap(
        reach_m=max(spec.range_finder.range_m for spec in specs),
        min_arc_m=Footprint.parse(specs[robot].footprint).width_m,
        gaps_count=bool(run.options.get("gaps_count", True)),
        robot=robot,
    )
    known.merge(entries)
    return {
        "nodes": sorted(node.id for node in known.nodes),
        "roots": known.roots(),
        "open nodes": known.open_nodes(),
        "frontiers": {
            node.id: sorted(map(tuple, known.frontier(node.id).tolist())) for node in known.nodes
        },
    }


def _painted(run: JudgedRun, robot: int, entries: list[Entry]) -> dict[str, Any]:
    footprint = Footprint.parse(run.recording.spec.robots[robot].footprint)
    raster = raster_for(footprint, run.options["cell_m"], run.options["margin_m"], robot)
    for entry in entries:
        if isinstance(entry, Node):
            raster.add(entry.region)
    return {
        "cells": _placed(raster, raster.cells),
        "passable cells": _placed(raster, raster.passable),
        "frontier groups": [
            (group.cells.tolist(), group.target, group.size_m)
            for group in raster.frontier_groups(0.0)
        ],
    }


def _placed(raster: Occupancy, layer: Any) -> bytes:
    # The cells in the lattice, whatever the window is.
    rows, columns = np.nonzero(layer)
    found = np.column_stack([rows + raster.row, columns + raster.column, layer[rows, columns]])
    return found.astype(np.int64).tobytes()


def _differs(one: dict[str, Any], other: dict[str, Any]) -> str | None:
    return next((what for what in one if one[what] != other[what]), None)
