"""Pictures of teams: groups (GPR, GER), the master's coordination, and support."""

from __future__ import annotations

import math
from functools import cache

import numpy as np
import shapely
from setting import BODY, FLAT, RANGE_M, region_at
from sketch import Bounds, Sketch

import multisrt as ms
from multisrt.events import Decision, Motion, NodeAdded, Organized, Supports
from multisrt.geometry.regions.boundary import OBSTACLE
from multisrt.planners.motion.kinematics import Differential
from multisrt.robots.multi_srt.groups import are_coupled, group_of
from multisrt.robots.multi_srt.messages import Path, RobotState
from multisrt.run import Run

Place = tuple[float, float]

# Groups: where four robots stand, and to where one of them still moves.
ROBOTS: dict[int, Place] = {0: (3.0, 5.6), 1: (5.6, 2.6), 2: (9.2, 2.4), 3: (24.6, 5.4)}
TARGETS: dict[int, Place] = ROBOTS | {2: (11.6, 1.6)}
WIDE: Bounds = (-1.2, -2.6, 28.8, 9.8)


def state(robot: int) -> RobotState:
    """Return what a robot reports of itself."""
    at, target = ROBOTS[robot], TARGETS[robot]
    moves = at != target
    path: Path = ((0.0, *at, 0.0), (4.0, *target, 0.0)) if moves else ((0.0, *at, 0.0),)
    return RobotState(
        robot=robot,
        said=0,
        step=0,
        phase="moving" if moves else "waiting",
        key=(),
        path=path,
        arrival_s=4.0 if moves else 0.0,
        node=None,
        frontier_m=0.0,
        waited=0,
        tree=None,
        footprint="disc:0.25",
        kinematics=Differential(),
        range_m=RANGE_M,
        have=(),
    )


def gpr() -> str:
    """Draw which robots are coupled: targets nearer than twice the range."""
    states = {robot: state(robot) for robot in ROBOTS}
    group = group_of(0, states, are_coupled)
    sketch = Sketch("GPR: robots whose targets are nearer than twice the range, in a chain", WIDE)
    for robot in ROBOTS:
        sketch.circle(*TARGETS[robot], RANGE_M, f"a{robot}")
    for i in states:
        for j in states:
            if i < j and are_coupled(states[i], states[j]):
                sketch.line([TARGETS[i], TARGETS[j]], "bold")
    for robot, at in ROBOTS.items():
        if at != TARGETS[robot]:
            sketch.line([at, TARGETS[robot]], f"d{robot}")
            sketch.dot(*TARGETS[robot], "target")
        sketch.dot(*at, f"r{robot}", 6)
        sketch.text(*at, str(robot), dy=-14)
    sketch.sample("bold", "coupled")
    sketch.sample("target", "target of a robot that moves")
    sketch.sample("a0", f"range; the GPR of robot 0: {', '.join(map(str, group))}")
    return sketch.svg()


STANDING: dict[int, Place] = {0: (2.6, 6.4), 1: (5.6, 2.6), 2: (12.6, 7.2), 3: (12.6, 1.4)}


def ger() -> str:
    """Draw which of them are engaged: local safe regions that overlap."""
    regions = {robot: region_at(FLAT, *at) for robot, at in STANDING.items()}
    sketch = Sketch("GER: of the GPR, those whose local safe regions overlap", (0, 0, 14, 8.4))
    for robot, region in regions.items():
        sketch.area(region.polygon(), f"a{robot}")
    shared = [
        a.polygon().intersection(b.polygon())
        for i, a in regions.items()
        for j, b in regions.items()
        if i < j and a.overlaps(b)
    ]
    for part in shared:
        sketch.area(part, "other")
    sketch.walls(FLAT)
    for robot, at in STANDING.items():
        sketch.dot(*at, f"r{robot}", 6)
        group = group_of(robot, regions, lambda a, b: a.overlaps(b))
        sketch.text(*at, f"GER {', '.join(map(str, group))}", dy=-14)
    sketch.sample("other", "in two regions")
    return sketch.svg()


# Coordination and support: from runs. -------------------------------------------------------


@cache
def run(world: str = "rooms") -> Run:
    """Return a run of four robots that start close together."""
    return ms.explore(world, strategy="srt-radial", robots=4, starts="clustered", seed=0)


def place_of(robot: int, time_s: float, world: str = "rooms") -> Place:
    """Return where a robot stood at a time between its motions."""
    at = run(world).recording.starts[robot][:2]
    for motion in run(world).recording.of(Motion):
        if motion.robot == robot and motion.waypoints[-1][0] <= time_s:
            at = motion.waypoints[-1][1:3]
    return at


def organized() -> Organized:
    """Return when the master first gave new targets."""
    return next(e for e in run().recording.of(Organized) if "new target" in e.orders.values())


def crossing(title: str, *, after: bool) -> str:
    """Draw the paths of a group, as planned or as the master arranged them."""
    event = organized()
    targets = event.after if after else event.before
    at = {robot: place_of(robot, event.time_s) for robot in targets}
    spots = np.array([*at.values(), *event.before.values(), *event.after.values()])
    centre = 0.5 * (spots.min(axis=0) + spots.max(axis=0))
    half = 0.5 * np.ptp(spots, axis=0).max() + 1.4
    x, y = centre.tolist()
    sketch = Sketch(title, (x - half, y - 0.72 * half, x + half, y + 0.72 * half))
    sketch.walls(run().environment)
    for robot, place in at.items():
        if place != targets[robot]:
            swept = shapely.LineString([place, targets[robot]]).buffer(BODY.radius_m)
            sketch.area(swept, f"a{robot}")
    for robot, place in at.items():
        if place != targets[robot]:
            sketch.line([place, targets[robot]], f"d{robot}")
            sketch.dot(*targets[robot], "target")
        sketch.dot(*place, f"r{robot}", 9)
        sketch.text(*place, str(robot))
        if after:
            sketch.text(*targets[robot], event.orders[robot], dy=-14)
    if not after:
        pairs = ", ".join(f"{i} and {j}" for i, j in event.conflicts)
        sketch.sample("target", f"target; in conflict: {pairs}")
    else:
        sketch.sample("target", f"target; robot {event.robot} is master")
    return sketch.svg()


def conflicts() -> str:
    """Draw the paths that the robots planned."""
    return crossing("CHECK_FEASIBILITY: which planned paths conflict", after=False)


def orders() -> str:
    """Draw what the master made of them."""
    return crossing("ORGANIZE: what the master makes of the targets", after=True)


def support(title: str, *, chosen: bool) -> str:
    """Draw the trees when a robot chooses one, and its path there."""
    world = "apartment"
    recording = run(world).recording
    events = [e for e in recording.of(Supports) if e.tree is not None]
    event = max(events, key=lambda e: max(e.open_frontier_m.values()))
    sketch = Sketch(title, run(world).environment.bounds)
    nodes = [n for n in recording.of(NodeAdded) if n.time_s <= event.time_s]
    named = {(n.robot, n.serial): n for n in nodes}
    union = shapely.union_all([shapely.Polygon(n.boundary) for n in nodes])
    if not chosen:
        for robot in range(4):
            own = [shapely.Polygon(n.boundary) for n in nodes if n.robot == robot]
            sketch.area(shapely.simplify(shapely.union_all(own), 0.05), f"a{robot}")
        for node in nodes:
            border = np.array(node.boundary)
            ends = np.roll(border, -1, axis=0)
            is_open = np.array(list(node.tags)) != str(OBSTACLE)
            middle = 0.5 * (border + ends)
            inside = shapely.contains_xy(shapely.buffer(union, -0.05), *middle.T)
            sketch.segments(np.hstack([border, ends])[is_open & ~inside], "frontier")
    else:
        sketch.area(shapely.simplify(union, 0.05), "known")
    sketch.walls(run(world).environment)
    for node in nodes:
        if node.parent is not None and node.parent in named:
            start = named[node.parent].configuration[:2]
            sketch.line([start, node.configuration[:2]], f"l{node.robot}")
    for robot in range(4):
        at = place_of(robot, event.time_s, world)
        sketch.dot(*at, f"r{robot}", 6)
    if chosen:
        for motion in recording.of(Motion):
            if motion.robot == event.robot and motion.time_s >= event.time_s:
                if motion.purpose != "support":
                    break
                sketch.line([w[1:3] for w in motion.waypoints], "path")
        sketch.sample("path", f"way of robot {event.robot}, in support of tree {event.tree}")
    else:
        for tree, open_m in event.open_frontier_m.items():
            active = event.active_robots.get(tree, 0)
            sketch.sample(f"l{tree}", f"tree {tree}: {open_m:.0f} m open, {active} active")
        sketch.sample("frontier", "open frontier")
    return sketch.svg()


def open_frontiers() -> str:
    """Draw the trees that a robot may support."""
    return support("SUPPORT_OTHERS: the trees, and what is open in each", chosen=False)


def transfer() -> str:
    """Draw the path of the robot in support."""
    return support("SUPPORT_OTHERS: the robot goes to the tree and extends it", chosen=True)


def step() -> str:
    """Draw one turn of BUILD_SRT: a node, its region, the target."""
    recording = run().recording
    decision = next(
        d for d in recording.of(Decision) if d.choice == "draw" and d.robot == 0 and d.draws
    )
    node = next(n for n in recording.of(NodeAdded) if (n.robot, n.serial) == tuple(decision.node))
    x, y, heading = node.configuration
    sketch = Sketch("One turn of BUILD_SRT", (x - 6, y - 4.6, x + 6, y + 4.6))
    sketch.area(shapely.Polygon(node.boundary), "a0")
    sketch.walls(run().environment)
    assert decision.target is not None
    sketch.line([(x, y), decision.target], "d0")
    sketch.dot(*decision.target, "target")
    sketch.dot(x, y, "r0", 7)
    sketch.line(
        [(x, y), (x + 0.6 * math.cos(heading), y + 0.6 * math.sin(heading))], "bold", arrow=True
    )
    sketch.sample("a0", "local safe region")
    sketch.sample("target", "target")
    return sketch.svg()


FIGURES = {
    "multi-srt-gpr": gpr,
    "multi-srt-ger": ger,
    "multi-srt-step": step,
    "coordination-conflicts": conflicts,
    "coordination-orders": orders,
    "support-open-frontiers": open_frontiers,
    "support-transfer": transfer,
}
