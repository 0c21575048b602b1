"""The measures of a run are consistent with each other and with the union of its regions."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from typing import Final

import shapely
from shapely import Polygon
from shapely.geometry.base import BaseGeometry

from multisrt.analysis.measuring import Curves, measure_with_curves
from multisrt.analysis.metrics import Metrics
from multisrt.campaign.invariants.open_frontier import WALL_M
from multisrt.campaign.judged_run import JudgedRun
from multisrt.campaign.violations import Violation
from multisrt.geometry.regions.boundary import arc_tolerance

NAME: Final = "measures-consistent"

AREA: Final = 3e-4
"""Maximum error of an area, as a share of what is explorable: three times what is promised."""

ROUNDING: Final = 1e-9
"""Maximum error of what is computed from the same numbers."""

ONE_IN: Final = 3
"""Every third run is measured."""

GRID_M: Final = 1e-6
"""Corners of overlays are rounded to multiples of this, in metres."""


def measures_consistent(run: JudgedRun) -> Violation | None:
    """Check that the measures of a run are consistent with each other and with its regions.

    The covered area is at most the seen area, this at most the explorable area, this at most the
    free space around the starts; the delivered area is at most the covered area. Coverage never
    decreases: each percent is reached no earlier than the previous one, and delivered no earlier
    than covered; 90, 95 and 99 % are reached in this order and before the end. The covered area is
    at most the union of the nodes' regions, computed as an overlay of polygons; with exact range
    finders it is at least that union without its parts that are not explorable. The tolerance is
    3e-4 of the explorable area; the accuracy of the measures is 1e-4. Regions and what
    scans showed approximate the same arc by different chords: the tolerance of chords is allowed in
    addition, along the border of the union away from walls.

    Cost: that of `measure`, about 0.15 s, and of the union. It is the highest of all invariants, so
    only one run in `ONE_IN` (3) is measured, depending on the seed of its spec.
    """
    if run.recording.spec.seed % ONE_IN:
        return None
    metrics, curves = measure_with_curves(run.recording, run.environment)
    said = [*_nested(run, metrics), *_ordered(metrics, curves), *_overlaid(run, metrics)]
    return Violation(invariant=NAME, says=said[0]) if said else None


def _nested(run: JudgedRun, m: Metrics) -> tuple[str, ...]:
    slack = ROUNDING * max(1.0, m.free_area_m2)
    free_m2 = float(run.environment.free.area)
    chain = (
        ("covered", m.covered_area_m2),
        ("seen", m.seen_area_m2),
        ("explorable", m.explorable_area_m2),
        ("free around the starts", sum(part.area for part in _components(run))),
        ("free", free_m2),
    )
    found = [
        f"{less:.6f} m2 are {inner}, but {more:.6f} m2 are {outer}"
        for (inner, less), (outer, more) in itertools.pairwise(chain)
        if less > more + slack
    ]
    if (m.delivered_coverage or 0.0) > m.coverage + ROUNDING:
        found.append(f"{m.delivered_coverage:.9g} are delivered, but {m.coverage:.9g} covered")
    for name, value in (
        ("coverage", m.coverage),
        ("seen", m.seen),
        ("delivered_coverage", m.delivered_coverage or 0.0),
        ("overlap_share", m.overlap_share),
    ):
        if not -ROUNDING <= value <= 1.0 + ROUNDING:
            found.append(f"{name} is {value:.9g}, which is no share")
    for name, value in (
        ("overlap_area_m2", m.overlap_area_m2),
        ("lost_area_m2", m.lost_area_m2),
        ("known_to_one_m2", m.known_to_one_m2),
    ):
        if not -slack <= value <= m.seen_area_m2 + AREA * m.explorable_area_m2:
            found.append(f"{name} is {value:.6f}, but {m.seen_area_m2:.6f} m2 were seen")
    return tuple(found)


def _ordered(m: Metrics, curves: Curves) -> Iterator[str]:
    covered, delivered = curves.covered_at_s, curves.delivered_at_s
    for what, times_s in (("covered", covered), ("delivered", delivered)):
        for percent in _falling(times_s):
            yield f"{percent} % are {what} before {percent - 1} %: coverage falls"
    for percent, (one, other) in enumerate(zip(covered, delivered, strict=False)):
        if other is not None and (one is None or other < one - ROUNDING):
            yield f"{percent} % are delivered before they are covered"
    for what, named in (
        ("covered", (m.time_to_90_s, m.time_to_95_s, m.time_to_99_s)),
        ("delivered", (m.delivered_90_s, m.delivered_95_s, m.delivered_99_s)),
    ):
        if _falling((*named, m.makespan_s if named[-1] is not None else None)):
            yield f"90, 95, 99 % are {what}, and the run ends, at {named}, {m.makespan_s:.3f} s"
        reached = [time_s for time_s in named if time_s is not None]
        if any(not 0.0 <= time_s <= m.makespan_s + ROUNDING for time_s in reached):
            yield f"90, 95, 99 % are {what} at {named}, in a run of {m.makespan_s:.3f} s"
    known_s = m.known_complete_s
    if known_s is not None and not 0.0 <= known_s <= m.makespan_s + ROUNDING:
        yield f"the map is known complete at {known_s:.3f} s, in a run of {m.makespan_s:.3f} s"
    if m.lower_bound_s > m.makespan_s + 1e-6:
        yield f"the run takes {m.makespan_s:.3f} s, less than its bound of {m.lower_bound_s:.3f} s"


def _falling(times_s: Sequence[float | None]) -> list[int]:
    """Return the positions of times earlier than the previous one; None stands for never."""
    return [
        k
        for k, (one, other) in enumerate(itertools.pairwise(times_s), 1)
        if other is not None and (one is None or other < one - ROUNDING)
    ]


def _overlaid(run: JudgedRun, m: Metrics) -> Iterator[str]:
    noters = {robot for robot, _ in run.nodes}
    if len(noters) < len(run.robots):
        return  # what robots without nodes covered are their scans
    regions = [region if region.is_valid else _valid(region) for region in run.regions.values()]
    union = shapely.union_all(regions, grid_size=GRID_M)
    here = shapely.union_all(_components(run))
    within_m2 = float(shapely.intersection(union, here, grid_size=GRID_M).area)
    allowed_m2 = AREA * m.explorable_area_m2
    hidden_m2 = float(here.area) - m.explorable_area_m2
    if m.covered_area_m2 > within_m2 + allowed_m2:
        yield f"{m.covered_area_m2:.4f} m2 are covered, by regions of {within_m2:.4f} m2 together"
    # With a laser a region may hold what its beams did not show, which is not covered.
    is_exact = all(r.range_finder.beams is None for r in run.recording.spec.robots)
    arcs = shapely.difference(union.boundary, here.boundary.buffer(WALL_M, quad_segs=2))
    range_m = max(robot.range_finder.range_m for robot in run.recording.spec.robots)
    chords_m2 = float(arcs.length) * arc_tolerance(range_m)
    if is_exact and m.covered_area_m2 < within_m2 - hidden_m2 - allowed_m2 - chords_m2:
        yield (
            f"only {m.covered_area_m2:.4f} m2 are covered, by regions of {within_m2:.4f} m2 "
            f"together, of which at most {hidden_m2:.4f} m2 are not explorable"
        )


def _components(run: JudgedRun) -> list[Polygon]:
    found = {shapely.to_wkb(part): part for part in (run.component(robot) for robot in run.robots)}
    return list(found.values())


def _valid(region: Polygon) -> BaseGeometry:
    parts = shapely.get_parts(shapely.make_valid(region)).tolist()
    return shapely.MultiPolygon([part for part in parts if isinstance(part, Polygon)])
