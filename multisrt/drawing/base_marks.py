"""The base station on maps of runs: where it is, and the border of what it knows."""

from __future__ import annotations

import shapely

from multisrt.drawing.areas import seen_first
from multisrt.drawing.colours import BASE, BASE_MM, DELIVERED
from multisrt.drawing.sheet import LegendEntry, Sheet
from multisrt.drawing.svg import child
from multisrt.events import BaseLearned, NodeAdded
from multisrt.recording import Recording

SIMPLER_MM = 0.015
"""Tolerance of the outlines of regions, in millimetres on paper."""


def draw_base(sheet: Sheet, recording: Recording, absent: frozenset[str]) -> None:
    """Draw the base station of a run, if it has one, and add it to the legend.

    Parameters
    ----------
    sheet : Sheet
        Where to draw.
    recording : Recording
        The run.
    absent : frozenset of str
        Layers that are left out; see `multisrt.drawing.layers`.
    """
    base = recording.spec.base
    if base is None:
        return
    learned = {tuple(name) for event in recording.of(BaseLearned) for name in event.nodes}
    if learned and "delivered" not in absent:
        regions = [
            shapely.simplify(shapely.Polygon(node.boundary), SIMPLER_MM * sheet.mm)
            for node in recording.of(NodeAdded)
            if (node.robot, node.serial) in learned
        ]
        known = seen_first(regions, [0] * len(regions), 10.0**-sheet.pen.decimals)
        if known:
            layer = sheet.layer("known to the base", DELIVERED)
            child(layer, "path", d=sheet.pen.rings(known[0]))
            sheet.legend.append(LegendEntry(label="border of what the base knows", style=DELIVERED))
    if "base" not in absent:
        layer = sheet.layer("base", BASE)
        child(layer, "path", d=sheet.pen.marker("house", *base.place, sheet.metres(BASE_MM)))
        sheet.legend.append(
            LegendEntry(label="base station", style=BASE, marker="house", size_mm=BASE_MM)
        )
