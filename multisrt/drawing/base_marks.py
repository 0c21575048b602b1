"""The base station on maps of runs: where it is, and the border of what it knows."""

from __future__ import annotations

import math
from typing import Final

import numpy as np
import shapely

from multisrt.drawing.colours import BASE, BASE_MM, DELIVERED
from multisrt.drawing.sheet import LegendEntry, Sheet
from multisrt.drawing.svg import child
from multisrt.environments.environment import Environment
from multisrt.events import BaseLearned, NodeAdded
from multisrt.geometry.numerics.kernel import FloatArray
from multisrt.recording import Recording

SIMPLER_MM: Final = 0.015
"""Tolerance of the outlines of regions, in millimetres on paper."""

WALL_MM: Final = DELIVERED.width_mm
"""A border that is nearer to a wall runs along it; gaps of up to twice this width in what the base
station knows are no border. In millimetres on paper."""

MIN_BORDER_MM: Final = DELIVERED.dashes_mm[0]
"""Shorter pieces of the border are left out, in millimetres on paper: less than a dash."""

AROUND: Final = 1.8
"""A base station at which a single robot starts is larger by this, as the start is drawn on it."""


def draw_base(
    sheet: Sheet, recording: Recording, environment: Environment, absent: frozenset[str]
) -> list[LegendEntry]:
    """Draw the base station of a run, if it has one.

    Parameters
    ----------
    sheet : Sheet
        Where to draw.
    recording : Recording
        The run.
    environment : Environment
        Its world.
    absent : frozenset of str
        Layers that are left out; see `multisrt.drawing.layers`.

    Returns
    -------
    list of LegendEntry
        What was drawn.
    """
    base = recording.spec.base
    if base is None:
        return []
    entries = []
    if "delivered" not in absent and (border := _border(sheet, recording, environment)):
        layer = sheet.layer("known to the base", DELIVERED)
        child(layer, "path", d="".join(map(sheet.pen.line, border)))
        entries.append(LegendEntry(label="border of what the base knows", style=DELIVERED))
    if "base" not in absent:
        layer = sheet.layer("base", BASE)
        size = sheet.metres(BASE_MM)
        starts = recording.starts
        if (
            len(starts) == 1
            and "starts" not in absent
            and math.dist(starts[0][:2], base.place) < size
        ):
            size *= AROUND
        child(layer, "path", d=sheet.pen.marker("house", *base.place, size))
        entries.append(
            LegendEntry(label="base station", style=BASE, marker="house", size_mm=BASE_MM)
        )
    return entries


def _border(sheet: Sheet, recording: Recording, environment: Environment) -> list[FloatArray]:
    # Where what the base station knows ends in free space, and not at a wall.
    learned = {tuple(name) for event in recording.of(BaseLearned) for name in event.nodes}
    regions = [
        shapely.simplify(shapely.Polygon(node.boundary), SIMPLER_MM * sheet.mm)
        for node in recording.of(NodeAdded)
        if (node.robot, node.serial) in learned
    ]
    # Unions need valid shapes with corners on a grid.
    grid_m = 10.0**-sheet.pen.decimals
    shapes = shapely.set_precision(shapely.make_valid(np.asarray(regions, object)), grid_m)
    wide_m = WALL_MM * sheet.mm
    wider = shapely.buffer(shapely.union_all(shapes, grid_size=grid_m), wide_m, join_style="mitre")
    known = shapely.buffer(wider, -wide_m, join_style="mitre")
    walls = shapely.buffer(environment.free.boundary, wide_m)
    free = shapely.difference(known.boundary, walls)
    return [
        shapely.get_coordinates(line)
        for line in shapely.get_parts(shapely.line_merge(free))
        if line.length >= MIN_BORDER_MM * sheet.mm
    ]
