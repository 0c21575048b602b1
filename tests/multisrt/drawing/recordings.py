"""Recordings to draw: of real runs, and of teams whose motions are given."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import msgspec
import numpy as np
import shapely

from multisrt.environments.environment import Environment
from multisrt.events import (
    AnyEvent,
    ArcClosed,
    Decision,
    Ended,
    Motion,
    NodeAdded,
    Purpose,
    Segment,
    Stage,
)
from multisrt.geometry.configuration import Configuration
from multisrt.geometry.regions.edge_index import EdgeIndex
from multisrt.geometry.regions.safe_region import local_safe_region
from multisrt.geometry.regions.scan import take_scan
from multisrt.recording import Footer, Recording, header_of
from multisrt.simulation.simulate import simulate
from multisrt.simulation.worlds import inline
from multisrt.spec import RobotSpec, RunSpec, StopRule

Place = tuple[float, float]
Pose = tuple[float, float, float]


def run(
    world: Environment, *, start: Place | None = None, max_time_s: float = 86_400.0, **spec: Any
) -> Recording:
    """Return the recording of a robot that is simulated alone."""
    robot = RobotSpec(start=start)
    stop = StopRule(max_time_s=max_time_s)
    described = inline(world)
    return simulate(RunSpec(environment=described, robots=(robot,), stop=stop, **spec), world)


def of_robot(event: AnyEvent, robot: int) -> AnyEvent:
    """Return an event of another robot, with all nodes those of that robot."""
    changes: dict[str, Any] = {"robot": robot}
    match event:
        case NodeAdded(parent=(_, serial)):
            changes["parent"] = robot, serial
        case Decision(node=(_, serial)) | ArcClosed(node=(_, serial)):
            changes["node"] = robot, serial
    return msgspec.structs.replace(event, **changes)


def team(*runs: Recording) -> Recording:
    """Put runs of one world together, as if each robot knew nothing of the others."""
    spec = msgspec.structs.replace(runs[0].spec, robots=tuple(r.spec.robots[0] for r in runs))
    starts = tuple(r.header.starts[0] for r in runs)
    events = [
        of_robot(event, number)
        for number, recording in enumerate(runs)
        for event in recording.events
    ]
    header = msgspec.structs.replace(runs[0].header, spec=spec, starts=starts)
    return replace(runs[0], header=header, events=tuple(sorted(events, key=lambda e: e.time_s)))


HALL = Environment("hall", shapely.box(0, 0, 20, 8))
HALL_INDEX = EdgeIndex(
    np.array([(0, 0, 20, 0), (20, 0, 20, 8), (20, 8, 0, 8), (0, 8, 0, 0)], float), 1.0
)


def node(
    time_s: float,
    robot: int,
    serial: int,
    place: Place,
    parent: tuple[int, int] | None = None,
    stage: Stage = "draw",
) -> NodeAdded:
    """Return a node in the hall and what is seen from it within 4 m."""
    scan = take_scan(HALL_INDEX, Configuration(*place), 0.0, 4.0)
    region = local_safe_region(scan, "radial")
    return NodeAdded(
        time_s=time_s,
        robot=robot,
        serial=serial,
        parent=parent,
        configuration=(*place, 0.0),
        stage=stage if parent else "root",
        boundary=tuple(map(tuple, region.boundary.tolist())),
        tags="".join(map(str, region.tags.tolist())),
    )


def motion(time_s: float, robot: int, *places: Place, purpose: Purpose = "explore") -> Motion:
    """Return a motion without turns through places of the hall, a second each."""
    waypoints = tuple((time_s + k, x, y, 0.0) for k, (x, y) in enumerate(places))
    return Motion(time_s=time_s, robot=robot, waypoints=waypoints, purpose=purpose)


def end(time_s: float, robot: int, frontier: tuple[Segment, ...] = ()) -> Ended:
    """Return the end of a robot that is done."""
    return Ended(time_s=time_s, robot=robot, reason="done", complete=True, frontier=frontier)


def recorded(
    starts: Sequence[Place | Pose],
    events: Sequence[AnyEvent],
    world: Environment = HALL,
    **spec: Any,
) -> Recording:
    """Return the recording of a team whose events are given."""
    robots = tuple(RobotSpec(start=start) for start in starts)
    run_spec = RunSpec(environment=inline(world), robots=robots, **spec)
    header = header_of(run_spec, world, tuple(Configuration(*start) for start in starts))
    footer = Footer(time_s=100.0, outcome="complete", reason="done", digest="0")
    return Recording(header=header, events=tuple(events), footer=footer)


A, B = (2.0, 3.0), (5.0, 3.0)  # of robot 0
C, D, E = (18.0, 3.0), (15.0, 3.0), (10.0, 3.0)  # of robot 1; E is seen by neither B nor D
F = (11.5, 4.0)  # of robot 0 in the tree of robot 1
