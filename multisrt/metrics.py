"""What is measured of a run, from its recording and the truth (never by a robot)."""

from __future__ import annotations

import itertools
import math
from collections import Counter
from collections.abc import Iterable

import msgspec
import numpy as np
import shapely

from multisrt.environments.environment import Environment
from multisrt.events import (
    ArcClosed,
    Collision,
    Decision,
    MapComplete,
    Motion,
    NodeAdded,
)
from multisrt.explorable import Explorable, explorable
from multisrt.geometry.configuration import Configuration
from multisrt.geometry.footprint import Footprint, place
from multisrt.geometry.kernel import FloatArray
from multisrt.geometry.raster import Raster
from multisrt.recording import Recording, RunOutcome
from multisrt.remaining_frontier import remaining_frontier
from multisrt.spec import RunSpec

THRESHOLDS = (0.90, 0.95, 0.99)
"""Shares of the explorable area whose times are reported: no two papers agree on one."""

TURN_STEP_RAD = math.radians(2.0)
"""Turns in place are measured in steps of this."""


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
    coverage : float
        Share of the explorable area that lies in a safe region, from 0 to 1.
    coverage_integral_s : float
        Time integral of the share not yet covered, up to the makespan: lower is better, and
        early coverage counts more.
    free_area_m2 : float
        Area of all free space of the world, reachable or not.
    explorable_area_m2 : float
        Area that can be seen from where the body can get to.
    covered_area_m2 : float
        Area of it that was covered.
    time_to_90_s, time_to_95_s, time_to_99_s : float or None
        When that share was covered; None if it never was.
    nodes : int
        Nodes of all trees.
    nodes_by_stage : dict
        How their places were found.
    decisions : int
        How many times a robot chose where to go.
    arcs_closed : dict
        Frontier arcs that were given up, by reason.
    frontier_left_m : float
        Length of frontier left open at the end.
    collisions : int
        Must be none.
    smallest_clearance_m : float
        Least distance between a body and an obstacle during the whole run.
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
    coverage: float
    coverage_integral_s: float
    free_area_m2: float
    explorable_area_m2: float
    covered_area_m2: float
    time_to_90_s: float | None
    time_to_95_s: float | None
    time_to_99_s: float | None
    nodes: int
    nodes_by_stage: dict[str, int]
    decisions: int
    arcs_closed: dict[str, int]
    frontier_left_m: float
    collisions: int
    smallest_clearance_m: float
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
    if environment is None:
        environment = recording.environment()
    spec, events, end = recording.spec, recording.events, recording.footer.time_s
    motions = [event for event in events if isinstance(event, Motion)]
    nodes = [event for event in events if isinstance(event, NodeAdded)]
    closed = [event for event in events if isinstance(event, ArcClosed)]
    left = [s for segments in remaining_frontier(recording).values() for s in segments]
    distances = [0.0] * len(spec.robots)
    for motion in motions:
        distances[motion.robot] += _length(motion)
    coverage = CoverageMeter(spec, environment, recording.starts)
    for node in nodes:
        coverage.add(node)
    reach, sweep = lower_bounds(spec, coverage.explorable, recording.starts)
    times = {share: coverage.time_to(share) for share in THRESHOLDS}
    return Metrics(
        outcome=recording.footer.outcome,
        exploration_time_s=min(
            (event.time_s for event in events if isinstance(event, MapComplete)), default=None
        ),
        makespan_s=end,
        total_distance_m=math.fsum(distances),
        distance_by_robot_m=tuple(distances),
        coverage=coverage.share,
        coverage_integral_s=coverage.integral_of_rest(end),
        free_area_m2=environment.area_m2,
        explorable_area_m2=coverage.explorable.area_m2,
        covered_area_m2=coverage.share * coverage.explorable.area_m2,
        time_to_90_s=times[0.90],
        time_to_95_s=times[0.95],
        time_to_99_s=times[0.99],
        nodes=len(nodes),
        nodes_by_stage=_counts(node.stage for node in nodes),
        decisions=sum(isinstance(event, Decision) for event in events),
        arcs_closed=_counts(event.reason for event in closed),
        frontier_left_m=math.fsum(math.hypot(x1 - x0, y1 - y0) for x0, y0, x1, y1 in left),
        collisions=sum(isinstance(event, Collision) for event in events),
        smallest_clearance_m=smallest_clearance(recording, environment),
        lower_bound_s=max(reach, sweep),
        lower_bound_reach_s=reach,
        lower_bound_area_s=sweep,
    )


class CoverageMeter:
    """Counts the share of the explorable area that is covered, node by node.

    Parameters
    ----------
    spec : RunSpec
        The run.
    environment : Environment
        The truth.
    starts : sequence of Configuration
        Where the robots start.

    Attributes
    ----------
    explorable : Explorable
        What is measured against: what the first robot could see.
    steps : list of (time_s, share)
        The share covered after every node.
    """

    def __init__(
        self, spec: RunSpec, environment: Environment, starts: tuple[Configuration, ...]
    ) -> None:
        robot = spec.robots[0]
        self.explorable: Explorable = explorable(
            environment, Footprint.parse(robot.footprint), robot.range_finder.range_m, starts[0]
        )
        seen = self.explorable.raster
        # Cells that do not count are marked from the beginning: what is painted new counts.
        self._raster = Raster(seen.cell_m, environment.bounds)
        self._raster.cells |= ~seen.cells
        self._all = int(np.count_nonzero(seen.cells))
        self._covered = 0
        self.steps: list[tuple[float, float]] = []

    @property
    def share(self) -> float:
        """Share covered so far, from 0 to 1."""
        return self._covered / self._all

    def add(self, node: NodeAdded) -> None:
        """Count what a node adds."""
        self._covered += self._raster.paint_inside(np.asarray(node.boundary))
        self.steps.append((node.time_s, self.share))

    def time_to(self, share: float) -> float | None:
        """When a share was covered; None if it never was."""
        return next((time for time, covered in self.steps if covered >= share), None)

    def integral_of_rest(self, end_s: float) -> float:
        """Time integral of the share not yet covered, from 0 to an end."""
        times = [0.0, *(time for time, _ in self.steps), end_s]
        rests = [1.0, *(1.0 - covered for _, covered in self.steps)]
        return math.fsum(
            rest * (b - a) for rest, (a, b) in zip(rests, itertools.pairwise(times), strict=True)
        )


def lower_bounds(
    spec: RunSpec, what: Explorable, starts: tuple[Configuration, ...]
) -> tuple[float, float]:
    """Two times below which no exploration of this world by this team can end.

    Returns
    -------
    reach_s : float
        Someone must come within range of the point that is farthest from all starts.
    area_s : float
        Robots that see `2 R_p` wide sweep no faster than that times their speed, and begin with
        one disc for each distinct start.
    """
    speed = max(robot.drive.speed_m_s for robot in spec.robots)
    range_m = max(robot.range_finder.range_m for robot in spec.robots)
    # A way measured on the raster may come out a little long.
    farthest = 0.99 * what.farthest_m(starts[0]) - what.raster.cell_m
    seen_at_once = len(set(starts)) * math.pi * range_m**2
    area = what.area_m2 - seen_at_once
    return (
        max(0.0, farthest - range_m) / speed,
        max(0.0, area) / (2.0 * range_m * speed * len(spec.robots)),
    )


def smallest_clearance(recording: Recording, environment: Environment) -> float:
    """Least distance between a body and an obstacle, over all motions; by shapely alone."""
    walls = [shapely.LineString(edge) for edge in environment.edges.reshape(-1, 2, 2)]
    tree = shapely.STRtree(walls)
    smallest = math.inf
    for number, robot in enumerate(recording.spec.robots):
        footprint = Footprint.parse(robot.footprint)
        legs = [recording.header.starts[number]]
        shapes = _swept(footprint, (0.0, *legs[0]), (0.0, *legs[0]))
        for event in recording.events:
            if isinstance(event, Motion) and event.robot == number:
                for a, b in itertools.pairwise(event.waypoints):
                    shapes += _swept(footprint, a, b)
        _, distances = tree.query_nearest(shapes, return_distance=True, all_matches=False)
        radius = footprint.radius_m if footprint.is_disc else 0.0
        smallest = min(smallest, float(distances.min()) - radius)
    return smallest


def _swept(
    footprint: Footprint, a: tuple[float, ...], b: tuple[float, ...]
) -> list[shapely.Geometry]:
    # What a leg covers; for a disc the way of its centre, from which the radius is taken off.
    if footprint.is_disc:
        if a[1:3] == b[1:3]:
            return [shapely.Point(a[1:3])]
        return [shapely.LineString([a[1:3], b[1:3]])]
    if a[3] == b[3]:
        return [footprint.swept(Configuration(*a[1:]), Configuration(*b[1:]))]
    steps = max(2, math.ceil(abs(b[3] - a[3]) / TURN_STEP_RAD) + 1)
    poses: FloatArray = np.linspace(a[1:], b[1:], steps)
    outlines = [place(footprint.vertices, *pose) for pose in poses.tolist()]
    swept: list[shapely.Geometry] = np.asarray(shapely.polygons(np.stack(outlines))).tolist()
    return swept


def _length(motion: Motion) -> float:
    return math.fsum(
        math.hypot(b[1] - a[1], b[2] - a[2]) for a, b in itertools.pairwise(motion.waypoints)
    )


def _counts(names: Iterable[str]) -> dict[str, int]:
    return dict(sorted(Counter(names).items()))
