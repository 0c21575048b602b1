"""The measures of a run are consistent with each other and with the union of its regions."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from typing import Final

import numpy as np
import shapely
from shapely import Polygon
from shapely.geometry.base import BaseGeometry

from multisrt.analysis.explorable import explorable, viewers
from multisrt.analysis.measuring import Curves, measure_with_curves
from multisrt.analysis.metrics import Metrics
from multisrt.campaign.invariants.open_frontier import GRID_M, WALL_M, union_of
from multisrt.campaign.judged_run import JudgedRun
from multisrt.campaign.violations import Violation
from multisrt.events import Blocked, Died, Sent
from multisrt.geometry.bodies.footprint import Footprint
from multisrt.geometry.configuration import Configuration
from multisrt.geometry.regions.boundary import arc_tolerance

NAME: Final = "measures-consistent"

AREA: Final = 3e-4
"""Maximum error of an area, as a share of what is explorable: three times what is promised."""

ROUNDING: Final = 1e-9
"""Maximum error of what is computed from the same numbers."""

RECOUNTED: Final = 1e-6
"""Maximum error of what is counted again, as a share, and in metres or seconds."""

PLANNED: Final = 0.01
"""Maximum error of the share that an informed plan counts in cells."""

ROOM_M: Final = 0.02
"""Room around a body, in metres, with which an informed plan lets it pass."""

ONE_IN: Final = 3
"""Every third run is measured."""


def measures_consistent(run: JudgedRun) -> Violation | None:
    """Check that the measures of a run are consistent with each other and with its regions.

    The covered area is at most the seen area, this at most the explorable area, this at most the
    free space around the starts; the delivered area is at most the covered area. Coverage never
    decreases: each percent is reached no earlier than the previous one, and delivered no earlier
    than covered; 90, 95 and 99 % are reached in this order and before the end. The covered area is
    at most the union of the nodes' regions, computed as an overlay of polygons; with exact range
    finders it is at least that union without its parts that are not explorable. The same holds for
    the delivered area and the nodes that the base station knows. The tolerance is
    3e-4 of the explorable area; the accuracy of the measures is 1e-4. Regions and what
    scans showed approximate the same arc by different chords: the tolerance of chords is allowed in
    addition, along the border of the union away from walls.

    Path lengths, waiting times and numbers of messages, receptions, nodes, deaths and protective
    stops are those of the recorded events. The integral of the coverage lies between the sums over
    the percents, and the delivery delay between the differences of such sums. No body was nearer to
    a wall, where a motion began or ended, than the minimum clearance. The regions of the nodes that
    were added, or delivered, by the times to 90, 95 and 99 % have these shares of the area. Robots
    carry data while they live and know a node that the base station does not know. An informed plan
    that is complete shows at least its share, to 0.01, of what discs of 2 cm more than the bodies'
    circumscribed radius could explore, if there is room for these at the starts. It counts the
    share in cells, which may miss the slivers between a laser's beams: not judged with lasers.

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
        *_delivered(run, metrics, curves),
        *_overlaid(run, metrics),
        *_planned(run, metrics),
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


def _delivered(run: JudgedRun, m: Metrics, curves: Curves) -> Iterator[str]:
    if m.delivery_delay_s is not None and m.coverage > 0.0:
        soonest, latest = _integral_s(curves.covered_at_s, run.end_s)
        first, last = _integral_s(curves.delivered_at_s, run.end_s)
        lowest_s, highest_s = (first - latest) / m.coverage, (last - soonest) / m.coverage
        slack_s = RECOUNTED * (1.0 + run.end_s) / m.coverage
        if not lowest_s - slack_s <= m.delivery_delay_s <= highest_s + slack_s:
            yield (
                f"delivery_delay_s is {m.delivery_delay_s:.6f}, but by percents from "
                f"{lowest_s:.6f} to {highest_s:.6f}"
            )
    if m.carrying_s is not None and _all_add_nodes(run):
        carried_s = math.fsum(_carried_s(run, robot) for robot in run.robots) / len(run.robots)
        if abs(m.carrying_s - carried_s) > RECOUNTED * (1.0 + carried_s):
            yield f"carrying_s is {m.carrying_s:.6f}, but {carried_s:.6f} by nodes"


def _carried_s(run: JudgedRun, robot: int) -> float:
    """Return for how long a robot knew a node that the base station did not know, in seconds."""
    last_s = min(run.present_s(robot)[1], run.end_s)
    spans_s = [
        (known_s, min(run.base_knows_s.get(name, math.inf), last_s))
        for name, known_s in run.known[robot].items()
    ]
    total_s = until_s = 0.0
    for begin_s, end_s in sorted(spans_s):
        total_s += max(0.0, end_s - max(begin_s, until_s))
        until_s = max(until_s, end_s)
    return total_s


def _all_add_nodes(run: JudgedRun) -> bool:
    return len({robot for robot, _ in run.nodes}) == len(run.robots)


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
    if not _all_add_nodes(run):
        return  # what robots without nodes covered are their scans
    here = shapely.union_all(_components(run))
    allowed_m2 = AREA * m.explorable_area_m2
    hidden_m2 = float(here.area) - m.explorable_area_m2
    # With a laser a region may hold what its beams did not show, which is not covered.
    is_exact = _has_exact_scans(run)
    range_m = max(robot.range_finder.range_m for robot in run.recording.spec.robots)
    added_s = {name: node.time_s for name, node in run.nodes.items()}
    covered_s = m.time_to_90_s, m.time_to_95_s, m.time_to_99_s
    delivered_s = m.delivered_90_s, m.delivered_95_s, m.delivered_99_s
    delivered_m2 = (m.delivered_coverage or 0.0) * m.explorable_area_m2
    for what, area_m2, since_s, times_s in (
        ("covered", m.covered_area_m2, added_s, covered_s),
        ("delivered", delivered_m2, run.base_knows_s, delivered_s),
    ):
        union = union_of(run.regions[name] for name in since_s)
        within_m2 = _area_m2(union, here)
        if area_m2 > within_m2 + allowed_m2:
            yield f"{area_m2:.4f} m2 are {what}, by regions of {within_m2:.4f} m2 together"
        arcs = shapely.difference(union.boundary, here.boundary.buffer(WALL_M, quad_segs=2))
        chords_m2 = float(arcs.length) * arc_tolerance(range_m)
        if is_exact and area_m2 < within_m2 - hidden_m2 - allowed_m2 - chords_m2:
            yield (
                f"only {area_m2:.4f} m2 are {what}, by regions of {within_m2:.4f} m2 together, "
                f"of which at most {hidden_m2:.4f} m2 are not explorable"
            )
        for percent, time_s in zip((90, 95, 99), times_s, strict=True):
            if time_s is None:
                continue
            then = union_of(run.regions[name] for name in since_s if since_s[name] <= time_s)
            then_m2 = _area_m2(then, here)
            if then_m2 < 0.01 * percent * m.explorable_area_m2 - allowed_m2:
                yield f"{percent} % are {what} at {time_s:.2f} s, by regions of {then_m2:.4f} m2"


def _planned(run: JudgedRun, m: Metrics) -> Iterator[str]:
    spec = run.recording.spec
    if spec.strategy != "informed" or m.outcome != "complete" or not _has_exact_scans(run):
        return
    starts = [Configuration(*start) for start in run.recording.header.starts]
    discs = tuple(
        (Footprint.disc(body.circumscribed_radius_m + ROOM_M), range_m, start)
        for body, range_m, start in viewers(spec, starts)
    )
    for robot, (disc, _, (x, y, _)) in enumerate(discs):
        clearance_m = run.component(robot).boundary.distance(shapely.Point(x, y))
        if clearance_m < disc.circumscribed_radius_m:
            return
    share = run.options["share"]
    seen = m.seen * m.explorable_area_m2 / explorable(run.environment, discs).area_m2
    if seen < share - PLANNED:
        yield f"only {seen:.4f} of the area are seen by an informed plan for {share:g}"


def _has_exact_scans(run: JudgedRun) -> bool:
    return all(robot.range_finder.beams is None for robot in run.recording.spec.robots)


def _area_m2(area: BaseGeometry, here: BaseGeometry) -> float:
    return float(shapely.intersection(area, here, grid_size=GRID_M).area)


def _components(run: JudgedRun) -> list[Polygon]:
    found = {shapely.to_wkb(part): part for part in (run.component(robot) for robot in run.robots)}
    return list(found.values())
