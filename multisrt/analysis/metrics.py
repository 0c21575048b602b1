"""What is measured of a run, from its recording and the truth (never by a robot)."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable

import msgspec
import numpy as np

from multisrt.analysis.clearances import (
    smallest_clearance,
    smallest_distance_between_robots,
    tracks,
)
from multisrt.analysis.coverage import CoverageMeter, team_areas
from multisrt.analysis.explorable import Explorable
from multisrt.analysis.isolation import team_isolation
from multisrt.analysis.known_area import area_known_to_one
from multisrt.analysis.remaining_frontier import remaining_frontier
from multisrt.environments.environment import Environment
from multisrt.events import (
    ArcClosed,
    Blocked,
    Collision,
    Decision,
    Died,
    Ended,
    Joined,
    MapComplete,
    NodeAdded,
    Organized,
    Sent,
)
from multisrt.geometry.configuration import Configuration
from multisrt.recording import Recording, RunOutcome
from multisrt.spec import LateStart, RunSpec

THRESHOLDS = (0.90, 0.95, 0.99)
"""Shares of the explorable area whose times are reported: no two papers agree on one."""


class Metrics(msgspec.Struct, frozen=True, kw_only=True):
    """What is measured of a run.

    Attributes
    ----------
    outcome : {"complete", "stalled", "out_of_time"}
        How it ended.
    exploration_time_s : float or None
        When the first robot knew that no frontier is left; None if none came to know.
    makespan_s : float
        When the run ended, all robots home.
    total_distance_m : float
        Distance travelled by all robots.
    distance_by_robot_m : tuple of float
        The same, robot by robot.
    distance_spread_m : float
        Standard deviation of the distance over the robots, all of the team.
    waiting_time_s : float
        Time that all robots together stood still between their start and their last end. A robot
        that starts late counts from then, one that dies until then.
    waiting_time_by_robot_s : tuple of float
        The same, robot by robot.
    coverage : float
        Share of the explorable area that lies in a safe region of any robot, from 0 to 1.
    coverage_integral_s : float
        Time integral of the share not yet covered, up to the makespan: lower is better, and
        early coverage counts more.
    free_area_m2 : float
        Area of all free space of the world, reachable or not.
    explorable_area_m2 : float
        Area that any robot could see from where its body can get to from its start. Robots that
        die or start late count: it is the task that the team was given.
    covered_area_m2 : float
        Area of it that was covered.
    unseen_m2 : float
        Area of it that no robot saw.
    overlap_area_m2 : float
        Area of it that at least two robots saw.
    overlap_share : float
        The same as a share of the covered area, from 0 to 1; 0 where nothing was covered.
    lost_area_m2 : float
        Area of it that robots saw which died, and that no robot that lives on knows at the end.
    lost_area_by_robot_m2 : tuple of float
        What each of the dead saw of it; what two of them saw counts for both.
    isolated_total_s : float
        Time during which at least one robot was cut off from all others that lived; see
        `multisrt.analysis.isolation` for this and what follows.
    isolated_by_robot_s : tuple of float
        How long each robot was.
    isolated_longest_s : float
        The longest spell of one robot.
    beyond_range_m : float or None
        The largest distance of such a robot to the nearest other one, less the range of the
        radio; 0 if there was none, None for a radio without a range.
    split_s : float
        Time during which some robot that lived could not have reached another one.
    known_to_one_m2s : float
        Time integral of the area that only one robot knew (m2 s): what its loss would have cost.
    known_to_one_by_robot_m2s : tuple of float
        The same, robot by robot.
    known_to_one_m2 : float
        The area that only one robot knew at the end, whoever it was.
    time_to_90_s, time_to_95_s, time_to_99_s : float or None
        When that share was covered; None if it never was.
    nodes : int
        Nodes of all trees.
    nodes_by_robot : tuple of int
        The same, robot by robot.
    nodes_by_stage : dict
        How their places were found.
    decisions : int
        How many times a robot chose where to go.
    coordinations : int
        How many times a master organised its group.
    deadlocks : int
        How many times it could let nobody go.
    protective_stops : int
        How many motions ended before another robot's body.
    deaths : int
        How many robots died.
    messages : int
        How many times a robot sent something, whether or not anybody heard it.
    deliveries : int
        How many receivers the messages came to, relayed or not.
    lost_deliveries : int
        How many receivers in reach a message did not come to, by loss.
    bytes_sent : int
        Size of all messages, each counted once.
    messages_by_kind, bytes_by_kind : dict
        The same by type of message.
    arcs_closed : dict
        Frontier arcs that were given up, by reason.
    frontier_left_m : float
        Length of frontier left open at the end.
    collisions : int
        Must be none.
    smallest_clearance_m : float
        Least distance between a body and an obstacle during the whole run.
    smallest_distance_between_robots_m : float or None
        Least distance between two bodies during the whole run; None for a single robot.
    lower_bound_s : float
        No run can be shorter: the larger one of the two bounds below.
    lower_bound_reach_s : float
        Time to where the farthest point comes into range.
    lower_bound_area_s : float
        Time to sweep the explorable area with a range finder that never looks twice.
    """

    outcome: RunOutcome
    exploration_time_s: float | None
    makespan_s: float
    total_distance_m: float
    distance_by_robot_m: tuple[float, ...]
    distance_spread_m: float
    waiting_time_s: float
    waiting_time_by_robot_s: tuple[float, ...]
    coverage: float
    coverage_integral_s: float
    free_area_m2: float
    explorable_area_m2: float
    covered_area_m2: float
    unseen_m2: float
    overlap_area_m2: float
    overlap_share: float
    lost_area_m2: float
    lost_area_by_robot_m2: tuple[float, ...]
    isolated_total_s: float
    isolated_by_robot_s: tuple[float, ...]
    isolated_longest_s: float
    beyond_range_m: float | None
    split_s: float
    known_to_one_m2s: float
    known_to_one_by_robot_m2s: tuple[float, ...]
    known_to_one_m2: float
    time_to_90_s: float | None
    time_to_95_s: float | None
    time_to_99_s: float | None
    nodes: int
    nodes_by_robot: tuple[int, ...]
    nodes_by_stage: dict[str, int]
    decisions: int
    coordinations: int
    deadlocks: int
    protective_stops: int
    deaths: int
    messages: int
    deliveries: int
    lost_deliveries: int
    bytes_sent: int
    messages_by_kind: dict[str, int]
    bytes_by_kind: dict[str, int]
    arcs_closed: dict[str, int]
    frontier_left_m: float
    collisions: int
    smallest_clearance_m: float
    smallest_distance_between_robots_m: float | None
    lower_bound_s: float
    lower_bound_reach_s: float
    lower_bound_area_s: float


def measure(recording: Recording, environment: Environment | None = None) -> Metrics:
    """Measure a run.

    Parameters
    ----------
    recording : Recording
        What happened.
    environment : Environment, optional
        The world, if it is at hand already; else it is taken from the recording.
    """
    return measure_with_curve(recording, environment)[0]


def measure_with_curve(
    recording: Recording, environment: Environment | None = None
) -> tuple[Metrics, tuple[float | None, ...]]:
    """Measure a run as `measure` does, and how its coverage grew.

    Returns
    -------
    metrics : Metrics
        What is measured.
    covered_at_s : tuple of (float or None)
        When each percent of the explorable area was covered, from 0 to 100; None if it never was.
    """
    if environment is None:
        environment = recording.environment()
    spec, end = recording.spec, recording.footer.time_s
    nodes, sent = recording.of(NodeAdded), recording.of(Sent)
    organized = recording.of(Organized)
    left = [s for segments in remaining_frontier(recording).values() for s in segments]
    distances = [track.length_m() for track in tracks(recording)]
    waiting = waiting_times(recording)
    made = Counter(node.robot for node in nodes)
    coverage = CoverageMeter(spec, environment, recording.starts)
    for node in nodes:
        coverage.add(node.time_s, recording.region(node))
    areas = team_areas(recording, coverage.explorable)
    covered = coverage.share * coverage.explorable.area_m2
    cut_off = team_isolation(recording, environment)
    known = area_known_to_one(recording, cell_m=coverage.explorable.raster.cell_m)
    reach, sweep = lower_bounds(spec, coverage.explorable, recording.starts)
    times = {share: coverage.time_to(share) for share in THRESHOLDS}
    metrics = Metrics(
        outcome=recording.footer.outcome,
        exploration_time_s=min((event.time_s for event in recording.of(MapComplete)), default=None),
        makespan_s=end,
        total_distance_m=math.fsum(distances),
        distance_by_robot_m=tuple(distances),
        distance_spread_m=float(np.std(distances)),
        waiting_time_s=math.fsum(waiting),
        waiting_time_by_robot_s=waiting,
        coverage=coverage.share,
        coverage_integral_s=coverage.integral_of_rest(end),
        free_area_m2=environment.area_m2,
        explorable_area_m2=coverage.explorable.area_m2,
        covered_area_m2=covered,
        unseen_m2=(1.0 - coverage.share) * coverage.explorable.area_m2,
        overlap_area_m2=areas.overlap_m2,
        overlap_share=areas.overlap_m2 / covered if covered else 0.0,
        lost_area_m2=areas.lost_m2,
        lost_area_by_robot_m2=areas.lost_by_robot_m2,
        isolated_total_s=cut_off.total_s,
        isolated_by_robot_s=tuple(robot.total_s for robot in cut_off.robots),
        isolated_longest_s=cut_off.longest_s,
        beyond_range_m=cut_off.beyond_range_m,
        split_s=cut_off.split_s,
        known_to_one_m2s=math.fsum(known.integral_m2s),
        known_to_one_by_robot_m2s=known.integral_m2s,
        known_to_one_m2=math.fsum(known.final_m2),
        time_to_90_s=times[0.90],
        time_to_95_s=times[0.95],
        time_to_99_s=times[0.99],
        nodes=len(nodes),
        nodes_by_robot=tuple(made[robot] for robot in range(len(spec.robots))),
        nodes_by_stage=_counts(node.stage for node in nodes),
        decisions=len(recording.of(Decision)),
        coordinations=len(organized),
        deadlocks=sum(event.deadlock for event in organized),
        protective_stops=len(recording.of(Blocked)),
        deaths=len(recording.of(Died)),
        messages=len(sent),
        deliveries=sum(len(event.reached) for event in sent),
        lost_deliveries=sum(len(event.lost) for event in sent),
        bytes_sent=sum(event.size_bytes for event in sent),
        messages_by_kind=_counts(event.kind for event in sent),
        bytes_by_kind=_sums((event.kind, event.size_bytes) for event in sent),
        arcs_closed=_counts(event.reason for event in recording.of(ArcClosed)),
        frontier_left_m=math.fsum(math.hypot(x1 - x0, y1 - y0) for x0, y0, x1, y1 in left),
        collisions=len(recording.of(Collision)),
        smallest_clearance_m=smallest_clearance(recording, environment),
        smallest_distance_between_robots_m=smallest_distance_between_robots(recording),
        lower_bound_s=max(reach, sweep),
        lower_bound_reach_s=reach,
        lower_bound_area_s=sweep,
    )
    return metrics, coverage.times_by_percent()


def lower_bounds(
    spec: RunSpec, what: Explorable, starts: tuple[Configuration, ...]
) -> tuple[float, float]:
    """Two times below which no exploration of this world by this team can end.

    Returns
    -------
    reach_s : float
        Someone must come within range of the point that is farthest from its nearest start.
    area_s : float
        Robots that see `2 R_p` wide sweep no faster than that times their speed, and begin with
        one disc for each distinct start.
    """
    speed = max(robot.drive.speed_m_s for robot in spec.robots)
    range_m = max(robot.range_finder.range_m for robot in spec.robots)
    # A way measured on the raster may come out a little long.
    farthest = 0.99 * what.farthest_m(*starts) - what.raster.cell_m
    seen_at_once = len(set(starts)) * math.pi * range_m**2
    area = what.area_m2 - seen_at_once
    return (
        max(0.0, farthest - range_m) / speed,
        max(0.0, area) / (2.0 * range_m * speed * len(spec.robots)),
    )


def waiting_times(recording: Recording) -> tuple[float, ...]:
    """Time that each robot stood still between its start and its last end (s).

    A robot that starts late counts from then; if it never came to start, it has not waited. One
    that dies counts until then, one that never ended until the end of the run.
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


def _sums(sizes: Iterable[tuple[str, int]]) -> dict[str, int]:
    sums: Counter[str] = Counter()
    for name, size in sizes:
        sums[name] += size
    return dict(sorted(sums.items()))


def _counts(names: Iterable[str]) -> dict[str, int]:
    return dict(sorted(Counter(names).items()))
