"""The measures of a run are consistent with each other and with the union of its regions."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Iterator, Sequence
from typing import Final

import numpy as np
import shapely
from shapely import Polygon
from shapely.geometry.base import BaseGeometry

from multisrt.analysis.measuring import Curves, measure_with_curves
from multisrt.analysis.metrics import Metrics
from multisrt.campaign.invariants.open_frontier import WALL_M
from multisrt.campaign.invariants.starting import silent_spells
from multisrt.campaign.judged_run import JudgedRun
from multisrt.campaign.violations import Violation
from multisrt.events import Blocked, Died, Sent
from multisrt.geometry.regions.boundary import arc_tolerance

NAME: Final = "measures-consistent"

AREA: Final = 3e-4
"""Maximum error of an area, as a share of what is explorable: three times what is promised."""

ROUNDING: Final = 1e-9
"""Maximum error of what is computed from the same numbers."""

RECOUNTED: Final = 1e-6
"""Maximum error of what is counted again, as a share, and in metres or seconds."""

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

    Path lengths, waiting times and numbers of messages, receptions, nodes, deaths and protective
    stops are those of the recorded events. The integral of the coverage lies between the sums over
    the percents. No body was nearer to a wall, where a motion began or ended, than the minimum
    clearance. A robot whose radio is silent is isolated, if all others are active. The regions of
    the nodes that were added by the times to 90, 95 and 99 % have these shares of the area.

    Cost: that of `measure`, about 0.15 s, and of the union. It is the highest of all invariants, so
    only one run in `ONE_IN` (3) is measured, depending on the seed of its spec.
    """
    if run.recording.spec.seed % ONE_IN:
        return None
    metrics, curves = measure_with_curves(run.recording, run.environment)
    said = [
        *_nested(run, metrics),
        *_ordered(metrics, curves),
        *_recounted(run, metrics, curves),
        *_overlaid(run, metrics),
    ]
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


def _recounted(run: JudgedRun, m: Metrics, curves: Curves) -> Iterator[str]:
    recording = run.recording
    sent = recording.of(Sent)
    lengths_m = [float(track.lengths.sum()) for track in run.tracks]
    waited_s = [_waited_s(run, robot) for robot in run.robots]
    counts: tuple[tuple[str, float], ...] = (
        ("total_distance_m", math.fsum(lengths_m)),
        ("waiting_time_s", math.fsum(waited_s)),
        ("messages", len(sent)),
        ("deliveries", sum(len(message.reached) for message in sent)),
        ("lost_deliveries", sum(len(message.lost) for message in sent)),
        ("bytes_sent", sum(message.size_bytes for message in sent)),
        ("nodes", len(run.nodes)),
        ("deaths", len(recording.of(Died))),
        ("protective_stops", len(recording.of(Blocked))),
    )
    each: tuple[tuple[str, Sequence[float]], ...] = (
        ("distance_by_robot_m", lengths_m),
        ("waiting_time_by_robot_s", waited_s),
    )
    compared = [(name, getattr(m, name), count) for name, count in counts]
    for name, values in each:
        compared += [(name, *pair) for pair in zip(getattr(m, name), values, strict=True)]
    for name, said, count in compared:
        if abs(said - count) > RECOUNTED * (1.0 + abs(count)):
            yield f"{name} is {said:.9g}, but {count:.9g} as recorded"
    lowest_s, highest_s = _integral_s(curves.covered_at_s, run.end_s)
    slack_s = RECOUNTED * (1.0 + run.end_s)
    if not lowest_s - slack_s <= m.coverage_integral_s <= highest_s + slack_s:
        yield (
            f"coverage_integral_s is {m.coverage_integral_s:.6f}, but by percents from "
            f"{lowest_s:.6f} to {highest_s:.6f}"
        )
    clearance_m = min(_clearance_m(run, robot) for robot in run.robots)
    if m.min_clearance_m > max(0.0, clearance_m) + RECOUNTED:
        yield f"min_clearance_m is {m.min_clearance_m:.6f}, but a body is {clearance_m:.6f} m away"
    if len(run.robots) > 1 and all(run.present_s(n) == (0.0, math.inf) for n in run.robots):
        for robot in run.robots:
            silent_s = sum(
                min(end_s, run.end_s) - begin_s
                for begin_s, end_s in silent_spells(run, robot)
                if begin_s < run.end_s
            )
            if m.isolated_by_robot_s[robot] < silent_s - 1e-5:
                yield f"robot {robot} is silent for {silent_s:.3f} s, and not isolated for as long"


def _waited_s(run: JudgedRun, robot: int) -> float:
    begin_s, dead_s = run.present_s(robot)
    ended_s = run.ends[robot].time_s if robot in run.ends else run.end_s
    end_s = min(ended_s, dead_s, run.end_s)
    if begin_s >= end_s:
        return 0.0
    legs = run.tracks[robot].legs
    driven = legs[(legs[:, 1:4] != legs[:, 5:8]).any(axis=1)]
    spans_s = np.clip(driven[:, 4], begin_s, end_s) - np.clip(driven[:, 0], begin_s, end_s)
    return end_s - begin_s - float(spans_s.sum())


def _integral_s(times_s: Sequence[float | None], end_s: float) -> tuple[float, float]:
    """Return bounds of the integral of the share not covered, by when percents were covered."""
    reached = [time_s for time_s in times_s if time_s is not None]
    lasting = np.diff([*reached, end_s])
    rest = 1.0 - 0.01 * np.arange(len(reached))
    return float((np.maximum(rest - 0.01, 0.0) * lasting).sum()), float((rest * lasting).sum())


def _clearance_m(run: JudgedRun, robot: int) -> float:
    body, legs = run.bodies[robot], run.tracks[robot].legs
    shapes = np.array(body.at(np.vstack([legs[:, 1:4], legs[:, 5:8]])))
    found = run.walls.tree.query_nearest(shapes, return_distance=True, all_matches=False)
    return float(found[1].min()) - body.radius_m


def _overlaid(run: JudgedRun, m: Metrics) -> Iterator[str]:
    noters = {robot for robot, _ in run.nodes}
    if len(noters) < len(run.robots):
        return  # what robots without nodes covered are their scans
    union = _union(run.regions.values())
    here = shapely.union_all(_components(run))
    within_m2 = float(shapely.intersection(union, here, grid_size=GRID_M).area)
    allowed_m2 = AREA * m.explorable_area_m2
    hidden_m2 = float(here.area) - m.explorable_area_m2
    if m.covered_area_m2 > within_m2 + allowed_m2:
        yield f"{m.covered_area_m2:.4f} m2 are covered, by regions of {within_m2:.4f} m2 together"
    for percent, time_s in ((90, m.time_to_90_s), (95, m.time_to_95_s), (99, m.time_to_99_s)):
        if time_s is None:
            continue
        then = _union(run.regions[name] for name, n in run.nodes.items() if n.time_s <= time_s)
        then_m2 = float(shapely.intersection(then, here, grid_size=GRID_M).area)
        if then_m2 < 0.01 * percent * m.explorable_area_m2 - allowed_m2:
            yield f"{percent} % are covered at {time_s:.2f} s, by regions of {then_m2:.4f} m2"
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


def _union(regions: Iterable[Polygon]) -> BaseGeometry:
    valid = [region if region.is_valid else _valid(region) for region in regions]
    return shapely.union_all(valid, grid_size=GRID_M)


def _valid(region: Polygon) -> BaseGeometry:
    parts = shapely.get_parts(shapely.make_valid(region)).tolist()
    return shapely.MultiPolygon([part for part in parts if isinstance(part, Polygon)])
