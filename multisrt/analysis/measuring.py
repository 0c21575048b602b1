"""Measures of a run, computed from its recording and the true world."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable
from typing import Any, NamedTuple

import numpy as np

from multisrt.analysis.bids import bids_by_radius
from multisrt.analysis.bounds import lower_bounds
from multisrt.analysis.clearances import (
    smallest_clearance,
    smallest_distance_between_robots,
)
from multisrt.analysis.coverage import (
    Coverage,
    coverage,
    known_complete_s,
    lost_areas_m2,
)
from multisrt.analysis.delivery import Delivery, delivery, mean_s
from multisrt.analysis.evidence import Evidence, evidence
from multisrt.analysis.explorable import Explorable, explorable, viewers
from multisrt.analysis.given_up import given_up_m2
from multisrt.analysis.isolation import team_isolation
from multisrt.analysis.known_area import known_to_one
from multisrt.analysis.metrics import Metrics, is_between
from multisrt.analysis.poses import tracks
from multisrt.analysis.remaining_frontier import remaining_frontier
from multisrt.environments.environment import Environment
from multisrt.events import (
    ArcClosed,
    Blocked,
    Collision,
    Decided,
    Decision,
    DiagramLeft,
    Died,
    Ended,
    Joined,
    NodeAdded,
    Organized,
    Sent,
)
from multisrt.geometry.errors import InvalidInputError
from multisrt.recording import Recording
from multisrt.spec import LateStart

MAX_HORIZON_S = 1e12
"""Upper bound of the horizon of integrals, in seconds."""


def measure(
    recording: Recording,
    environment: Environment | None = None,
    *,
    horizon_s: float | None = None,
    witnesses: bool = False,
) -> Metrics:
    """Measure a run.

    Parameters
    ----------
    recording : Recording
        The run.
    environment : Environment, optional
        The world, if it has been built already; by default it is built from the recording.
    horizon_s : float, optional
        Upper limit of integrals over time, in seconds; by default the end of the run. Compared runs
        need a common horizon, because area that is not covered when a run ends stays uncovered.
    witnesses : bool, default False
        Whether to compute `Metrics.lower_bound_witness_s`, which takes about a second for each
        world.

    Returns
    -------
    Metrics
        The measures of the run.

    Raises
    ------
    InvalidInputError
        If the recording has no valid world, or nodes but no scans, or the horizon is not a positive
        time.

    Examples
    --------
    >>> from multisrt import CatalogEnvironment, RunSpec, measure, simulate
    >>> spec = RunSpec(environment=CatalogEnvironment(name="apartment"), seed=1)
    >>> recording = simulate(spec)
    >>> metrics = measure(recording)
    >>> metrics.lower_bound_s < metrics.known_complete_s <= metrics.makespan_s
    True
    >>> metrics.reached(0.95), metrics.coverage <= metrics.seen <= 1.0
    (True, True)
    >>> later = measure(recording, horizon_s=metrics.makespan_s + 100.0)
    >>> later.coverage_integral_s >= metrics.coverage_integral_s
    True
    """
    return measure_with_curves(recording, environment, horizon_s=horizon_s, witnesses=witnesses)[0]


class Curves(NamedTuple):
    """The growth of coverage during a run.

    Attributes
    ----------
    covered_at_s : tuple of (float or None)
        Time at which each percent of the explorable area was covered, from 0 to 100 (s); None if
        it never was.
    delivered_at_s : tuple of (float or None)
        The same for the area known to the base station; empty without one.
    """

    covered_at_s: tuple[float | None, ...]
    delivered_at_s: tuple[float | None, ...] = ()


def measure_with_curves(
    recording: Recording,
    environment: Environment | None = None,
    *,
    horizon_s: float | None = None,
    witnesses: bool = False,
) -> tuple[Metrics, Curves]:
    """Measure a run and the growth of its coverage.

    Parameters
    ----------
    recording, environment, horizon_s, witnesses
        As for `measure`.

    Returns
    -------
    metrics : Metrics
        The measures of the run.
    curves : Curves
        When each percent of the explorable area was covered, and delivered.
    """
    if horizon_s is None:
        horizon_s = recording.footer.time_s
    elif not is_between(horizon_s, 0.0, MAX_HORIZON_S):
        raise InvalidInputError(
            f"the horizon of integrals is a positive number of seconds, not {horizon_s!r}"
        )
    if environment is None:
        environment = recording.environment()
    what = explorable(environment, viewers(recording.spec, recording.starts))
    proof = evidence(recording, environment, what)
    covered = coverage(proof)
    delivered = delivery(proof, covered)
    metrics = Metrics(
        **_time(proof, covered),
        **_distance(recording),
        **_area(proof, covered, environment, horizon_s),
        **_knowledge(proof, covered, horizon_s),
        **_base(delivered, covered, horizon_s),
        **_isolation(recording, environment),
        **_radio(recording),
        **_effort(recording),
        **_safety(recording, environment),
        **_bounds(recording, environment, what, covered, witnesses=witnesses),
    )
    at_base = () if delivered is None else delivered.times_by_percent()
    return metrics, Curves(covered.times_by_percent(), at_base)


def waiting_times(recording: Recording) -> tuple[float, ...]:
    """Return the time that each robot stood still between its start and its last end, in seconds.

    A robot that starts late counts from then; one that never started has not waited. One that
    dies counts until then, one that never ended until the end of the run.
    """
    end = recording.footer.time_s
    late = [fault.robot for fault in recording.spec.faults if isinstance(fault, LateStart)]
    begin = {robot: math.inf if robot in late else 0.0 for robot in range(len(recording.starts))}
    last = dict.fromkeys(begin, end)
    for joined in recording.of(Joined):
        begin[joined.robot] = joined.time_s
    for ended in recording.of(Ended):
        last[ended.robot] = ended.time_s
    for died in recording.of(Died):
        last[died.robot] = min(last[died.robot], died.time_s)
    waited = []
    for robot, track in enumerate(tracks(recording)):
        since, until = begin[robot], last[robot]
        spans = np.clip(track.moving_spans(), since, until)
        moving = math.fsum(spans[:, 1] - spans[:, 0])
        waited.append(max(0.0, until - since - moving) if since < until else 0.0)
    return tuple(waited)


# One function for each of the METRIC_GROUPS.


def _time(proof: Evidence, covered: Coverage) -> dict[str, Any]:
    recording = proof.recording
    waiting = waiting_times(recording)
    return {
        "outcome": recording.footer.outcome,
        "known_complete_s": known_complete_s(proof, covered),
        "makespan_s": recording.footer.time_s,
        "time_to_90_s": covered.time_to(0.90),
        "time_to_95_s": covered.time_to(0.95),
        "time_to_99_s": covered.time_to(0.99),
        "waiting_time_s": math.fsum(waiting),
        "waiting_time_by_robot_s": waiting,
    }


def _distance(recording: Recording) -> dict[str, Any]:
    distances = [track.length_m() for track in tracks(recording)]
    return {
        "total_distance_m": math.fsum(distances),
        "distance_by_robot_m": tuple(distances),
        "distance_spread_m": float(np.std(distances)),
    }


def _area(
    proof: Evidence, covered: Coverage, environment: Environment, horizon_s: float
) -> dict[str, Any]:
    explorable_m2 = proof.explorable.area_m2
    lost_m2, lost_by_robot_m2 = lost_areas_m2(proof, covered)
    left = [s for segments in remaining_frontier(proof.recording).values() for s in segments]
    seen_m2 = covered.seen * explorable_m2
    return {
        "coverage": covered.share,
        "seen": covered.seen,
        "coverage_integral_s": covered.integral_of_rest(horizon_s),
        "free_area_m2": environment.area_m2,
        "explorable_area_m2": explorable_m2,
        "covered_area_m2": covered.share * explorable_m2,
        "seen_area_m2": seen_m2,
        "unseen_m2": explorable_m2 - seen_m2,
        "given_up_m2": given_up_m2(proof, covered, left),
        "overlap_area_m2": covered.overlap_m2,
        "overlap_share": min(1.0, covered.overlap_m2 / seen_m2) if seen_m2 else 0.0,
        "lost_area_m2": lost_m2,
        "lost_area_by_robot_m2": lost_by_robot_m2,
        "frontier_left_m": math.fsum(math.hypot(x1 - x0, y1 - y0) for x0, y0, x1, y1 in left),
    }


def _knowledge(proof: Evidence, covered: Coverage, horizon_s: float) -> dict[str, Any]:
    known = known_to_one(proof, covered, horizon_s)
    return {
        "known_to_one_m2s": math.fsum(known.integral_m2s),
        "known_to_one_by_robot_m2s": known.integral_m2s,
        "known_to_one_m2": math.fsum(known.final_m2),
    }


def _base(delivered: Delivery | None, covered: Coverage, horizon_s: float) -> dict[str, Any]:
    if delivered is None:
        return {}
    return {
        "delivered_coverage": min(delivered.share, covered.share),
        "delivered_90_s": delivered.time_to(0.90),
        "delivered_95_s": delivered.time_to(0.95),
        "delivered_99_s": delivered.time_to(0.99),
        "delivery_delay_s": delivered.mean_delay_s(covered, horizon_s),
        "carrying_s": mean_s(delivered.carrying_s),
    }


def _isolation(recording: Recording, environment: Environment) -> dict[str, Any]:
    team = team_isolation(recording, environment)
    return {
        "isolated_total_s": team.total_s,
        "isolated_by_robot_s": tuple(robot.total_s for robot in team.robots),
        "isolated_longest_s": team.longest_s,
        "beyond_range_m": team.beyond_range_m,
        "split_s": team.split_s,
    }


def _radio(recording: Recording) -> dict[str, Any]:
    sent = recording.of(Sent)
    return {
        "messages": len(sent),
        "deliveries": sum(len(event.reached) for event in sent),
        "lost_deliveries": sum(len(event.lost) for event in sent),
        "bytes_sent": sum(event.size_bytes for event in sent),
        "messages_by_kind": _counts(event.kind for event in sent),
        "bytes_by_kind": _sums((event.kind, event.size_bytes) for event in sent),
    }


def _effort(recording: Recording) -> dict[str, Any]:
    nodes, organized = recording.of(NodeAdded), recording.of(Organized)
    made = Counter(node.robot for node in nodes)
    return {
        "nodes": len(nodes),
        "nodes_by_robot": tuple(made[robot] for robot in range(len(recording.spec.robots))),
        "nodes_by_stage": _counts(node.stage for node in nodes),
        "decisions": len(recording.of(Decision)) + len(recording.of(Decided)),
        "coordinations": len(organized),
        "deadlocks": sum(event.deadlock for event in organized),
        "arcs_closed": _counts(event.reason for event in recording.of(ArcClosed)),
        "diagram_left": _counts(event.because for event in recording.of(DiagramLeft)),
        "bids_by_radius": _counts(bids_by_radius(recording).elements()),
    }


def _safety(recording: Recording, environment: Environment) -> dict[str, Any]:
    return {
        "collisions": len(recording.of(Collision)),
        "protective_stops": len(recording.of(Blocked)),
        "deaths": len(recording.of(Died)),
        "min_clearance_m": smallest_clearance(recording, environment),
        "min_distance_between_robots_m": smallest_distance_between_robots(recording),
    }


def _bounds(
    recording: Recording,
    environment: Environment,
    what: Explorable,
    covered: Coverage,
    *,
    witnesses: bool,
) -> dict[str, Any]:
    spec, starts = recording.spec, recording.starts
    share = min(1.0, covered.share)
    bounds = lower_bounds(spec, environment, what, starts, share, witnesses=witnesses)
    return {
        "lower_bound_s": bounds.largest_s,
        "lower_bound_reach_s": bounds.reach_s,
        "lower_bound_area_s": bounds.area_s,
        "lower_bound_witness_s": bounds.witness_s,
    }


def _sums(sizes: Iterable[tuple[str, int]]) -> dict[str, int]:
    sums: Counter[str] = Counter()
    for name, size in sizes:
        sums[name] += size
    return dict(sorted(sums.items()))


def _counts(names: Iterable[str]) -> dict[str, int]:
    return dict(sorted(Counter(names).items()))
