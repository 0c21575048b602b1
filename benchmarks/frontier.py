"""What frontier bidding costs: whole missions, decisions in large maps, fields and rasters.

Two benchmarks explore `grid_room_1` of Explore-Bench, a published map. They look for it in the
folder that the environment variable `MULTISRT_MAPS` names, and are skipped where it is missing.
"""

from __future__ import annotations

import itertools
import math
import os
import time
from collections.abc import Generator, Iterator
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import shapely

from benchmarks import worlds
from benchmarks.harness import Benchmark, Claim, in_turns, show, skipped
from benchmarks.yardstick import yardstick_s
from multisrt.analysis.coverage import coverage
from multisrt.analysis.evidence import evidence
from multisrt.analysis.explorable import explorable, viewers
from multisrt.environments import read_environment
from multisrt.environments.catalog import environment
from multisrt.environments.environment import Environment
from multisrt.events import AnyEvent, GoalChosen, Motion, NodeAdded
from multisrt.geometry.bodies.footprint import Footprint
from multisrt.geometry.configuration import Configuration
from multisrt.geometry.grids.distance_field import DistanceField
from multisrt.geometry.grids.occupancy import Occupancy
from multisrt.geometry.regions.edge_index import EdgeIndex
from multisrt.geometry.regions.safe_region import LocalSafeRegion, local_safe_region
from multisrt.geometry.regions.scan import take_scan
from multisrt.planners.motion.kinematics import Differential
from multisrt.recording import Recording
from multisrt.robots import registry
from multisrt.robots.explorer import Action, Explorer, Note, Outcome, RobotSelf
from multisrt.robots.frontier.options import FrontierOptions
from multisrt.robots.frontier.robot import FrontierRobot
from multisrt.robots.frontier.wavefront_rules import choose_closest
from multisrt.robots.knowledge import Node, NodeId
from multisrt.robots.strategy import Strategy
from multisrt.simulation.simulate import simulate
from multisrt.simulation.worlds import inline
from multisrt.spec import CatalogEnvironment, RangeFinderSpec, RobotSpec, RunSpec, StopRule

MAPS = Path(os.environ.get("MULTISRT_MAPS", "maps"))
"""Folder of published maps."""

GRID_ROOM = "explore_bench/grid_room_1.pgm"
GRID_ROOM_CELL_M = 0.1
GRID_ROOM_STARTS = ((9.85, 3.35), (10.35, 12.55))
GRID_ROOM_RANGE_M = 3.5
COVERED = 0.98
RULES = ("closest", "greedy", "minpos", "utility", "self-bidding", "rules")

MAX_MISSION_YARDSTICKS = 45.0
"""Upper bound of a mission's computing time until the world is covered."""

MAX_TRAVEL_M = {"minpos": 41.0, "best of all": 36.0}
"""Upper bounds of the path of the robot that drives farthest until the world is covered."""

MAX_STEP_YARDSTICKS = 0.35
"""Upper bound of what a robot with a laser computes for a second of its mission."""

MAX_GROWTH = 1.5
"""Upper bound of a cost in a large map over that in a small one."""

LOCAL = ("srt-ball", "srt-star", "srt-radial", "closest")
"""Strategies whose decisions depend on what is near; those of the others compare all frontiers."""

MAX_LOCAL_GROWTH = 1.2
"""Upper bound of what a decision of theirs costs in a world four times as large."""

CROWD, CROWD_BEAMS, CROWD_WORLD, CROWD_RUN_S = 10, 360, "office", 60.0
RANGE_M, RADIUS_M, CELL_M = 4.0, 0.25, 0.1

NEWS = 24
"""Nodes after each of which a robot decides again."""

ROUNDS = 4
"""Number of measurements of a run, alternating with a yardstick; the shortest counts."""


def main() -> None:
    """Print the table of frontier bidding."""
    show(BENCHMARKS)


# Whole missions ------------------------------------------------------------------------------


def travel() -> Iterator[Claim | str]:
    """Measure how far robots drive until the world of the published map is covered."""
    world = grid_room()
    if world is None:
        yield skipped("travel of two robots", GRID_ROOM)
        return
    yield f"\n{'strategy':>14} {'time s':>8} {'longest m':>10}  to {COVERED:.0%}, two robots"
    longest = {}
    for name in RULES:
        recording = simulate(grid_room_spec(name), world)
        until = covered_s(recording, world)
        longest[name] = math.inf if until is None else max(travelled_m(recording, until))
        yield f"{name:>14} {math.inf if until is None else until:8.1f} {longest[name]:10.1f}"
    yield ""
    longest["best of all"] = min(longest.values())
    for name, limit in MAX_TRAVEL_M.items():
        yield Claim(
            text=f"longest way of two robots, {name}: {limit:g} m",
            ours=longest[name],
            theirs=limit,
            unit="m",
            at_most=1.0,
        )


def mission() -> Iterator[Claim | str]:
    """Measure the computing time of a mission until the world is covered, in yardsticks."""
    text = f"closest, two robots, to {COVERED:.0%} of a room: yardstick"
    world = grid_room()
    if world is None:
        yield skipped(text, GRID_ROOM)
        return
    spec = grid_room_spec("closest")
    until = covered_s(simulate(spec, world), world)
    assert until is not None, "the mission ended before the world was covered"
    spent = yardstick = math.inf
    for _ in range(ROUNDS):
        yardstick = min(yardstick, yardstick_s())
        begin, end = time.process_time(), math.inf

        def watch(event: AnyEvent) -> None:
            nonlocal end
            if isinstance(event, NodeAdded) and event.time_s <= until:
                end = time.process_time()

        simulate(spec, world, watch=watch)
        spent = min(spent, end - begin)
    yield Claim(
        text=text,
        ours=spent * 1e6,
        theirs=yardstick * 1e6,
        at_most=MAX_MISSION_YARDSTICKS,
        note=f"{until:.0f} s of simulated time, {until / spent:.0f} times as fast",
    )


@cache
def grid_room() -> Environment | None:
    """Return the world of the published map; None if it is missing."""
    path = MAPS / GRID_ROOM
    return read_environment(path, resolution_m=GRID_ROOM_CELL_M) if path.is_file() else None


def grid_room_spec(strategy: str) -> RunSpec:
    """Return the spec of two robots in that world."""
    world = grid_room()
    assert world is not None
    finder = RangeFinderSpec(range_m=GRID_ROOM_RANGE_M)
    return RunSpec(
        environment=inline(world),
        strategy=strategy,
        robots=tuple(RobotSpec(start=start, range_finder=finder) for start in GRID_ROOM_STARTS),
    )


def covered_s(recording: Recording, world: Environment) -> float | None:
    """Return the time at which the share `COVERED` of the world was seen; None if it never was."""
    what = explorable(world, viewers(recording.spec, recording.starts))
    return coverage(evidence(recording, world, what)).time_to(COVERED)


def travelled_m(recording: Recording, until_s: float) -> list[float]:
    """Return the length of every robot's way until some time, in metres."""
    driven = [0.0] * len(recording.spec.robots)
    for event in recording.events:
        if isinstance(event, Motion):
            for (a_s, *a, _), (b_s, *b, _) in itertools.pairwise(event.waypoints):
                if a_s < until_s:
                    share = min(1.0, (until_s - a_s) / (b_s - a_s)) if b_s > a_s else 1.0
                    driven[event.robot] += share * math.dist(a, b)
    return driven


# Many robots ---------------------------------------------------------------------------------


class _Timed:
    """An explorer that adds the time that it computes to a sum of one entry."""

    def __init__(self, explorer: Explorer, spent_s: list[float]) -> None:
        self.explorer = explorer
        self.spent_s = spent_s

    def run(self) -> Generator[Action, Outcome, None]:
        actions = self.explorer.run()
        outcome: Outcome = None
        while True:
            begin = time.process_time()
            try:
                action = actions.send(outcome)
            except StopIteration:
                return
            finally:
                self.spent_s[0] += time.process_time() - begin
            outcome = yield action


def crowd() -> Iterator[Claim]:
    """Measure mapping and decisions of many robots with lasers, in yardsticks."""
    closest = registry.strategy("closest")
    spent_s = [0.0]

    def explorer(me: RobotSelf, options: Any) -> Explorer:
        return _Timed(closest.explorer(me, options), spent_s)

    registry.register(
        Strategy(
            name="closest-timed",
            summary=closest.summary,
            options=closest.options,
            explorer=explorer,
        )
    )
    robot = RobotSpec(range_finder=RangeFinderSpec(range_m=RANGE_M, beams=CROWD_BEAMS))
    spec = RunSpec(
        environment=CatalogEnvironment(name=CROWD_WORLD),
        strategy="closest-timed",
        robots=(robot,) * CROWD,
        stop=StopRule(max_time_s=CROWD_RUN_S),
        seed=1,
    )
    world = environment(CROWD_WORLD)
    simulate(spec, world)  # compiles
    least = whole = yardstick = math.inf
    for _ in range(ROUNDS):
        yardstick = min(yardstick, yardstick_s())
        spent_s[0] = 0.0
        begin = time.process_time()
        recording = simulate(spec, world)
        whole = min(whole, time.process_time() - begin)
        least = min(least, spent_s[0])
    steps = CROWD * recording.footer.time_s
    yield Claim(
        text=f"{CROWD} robots, {CROWD_BEAMS} beams, a robot's second: yardstick",
        ours=least / steps * 1e6,
        theirs=yardstick * 1e6,
        at_most=MAX_STEP_YARDSTICKS,
        note=f"mapping and decisions; with the simulation {1e3 * whole / steps:.2f} ms",
    )


# Large maps ----------------------------------------------------------------------------------


def decision_in_large_map(near_m: float = 12.0, far_m: float = 24.0) -> Iterator[Claim]:
    """Measure decisions of `closest` after news, in maps of two sizes."""
    side = 60.0
    free = worlds.office(side, 12, seed=7)
    index = EdgeIndex(worlds.edges(free), RANGE_M / 3.0)
    places = worlds.viewpoints(free, 3000, seed=8)
    middle = np.full(2, side / 2.0)
    from_middle = np.abs(places - middle).max(axis=1)
    # Everything around the robot is known, except some rooms beside it, where the news comes
    # from. They are small enough that the nearest frontier is theirs in both maps.
    hole = np.hypot(*(places - middle - (6.0, 0.0)).T) < 5.0
    start = places[int(np.argmin(np.where(hole, np.inf, np.hypot(*(places - middle).T))))]
    small = _robot_at(start, index, places[(from_middle < near_m) & ~hole])
    large = _robot_at(start, index, places[(from_middle < far_m) & ~hole])
    order = np.argsort(np.hypot(*(places[hole] - start).T))
    news = [
        _node(index, x, y, NodeId(2, i))
        for i, (x, y) in enumerate(places[hole][order][:NEWS].tolist())
    ]
    goals: dict[int, list[tuple[float, float] | None]] = {id(small): [], id(large): []}

    def decide(robot: FrontierRobot, node: Node) -> None:
        robot.map.merge((node,))
        for note in choose_closest(robot, "news"):
            assert isinstance(note, Note)
            assert isinstance(note.event, GoalChosen)
            goals[id(robot)].append(note.event.goal)

    times = in_turns(
        news,
        {"small": lambda node: decide(small, node), "large": lambda node: decide(large, node)},
        repeats=1,
    )
    same = goals[id(small)] == goals[id(large)] and None not in goals[id(small)]
    groups = len(small.frontiers.groups()), len(large.frontiers.groups())
    yield Claim(
        text="decision of closest, map 4 times as large: the small map",
        ours=times["large"],
        theirs=times["small"],
        at_most=MAX_GROWTH,
        holds=same,
        note=f"{groups[0]} and {groups[1]} frontiers; goals are {'' if same else 'not '}the same",
    )


def missions_in_large_world(width_m: float = 30.0) -> Iterator[Claim]:
    """Measure what whole missions cost a node, in worlds of two sizes with the same rooms."""
    sides = {
        factor: Environment("rooms", worlds.office(factor * width_m, 6 * factor, desks=1, seed=3))
        for factor in (1, 2)
    }
    for name in LOCAL:
        specs = {
            factor: RunSpec(
                environment=inline(world), strategy=name, robots=(RobotSpec(),) * 2, seed=1
            )
            for factor, world in sides.items()
        }
        simulate(specs[1], sides[1])  # compiles
        cost = dict.fromkeys(sides, math.inf)
        for _ in range(ROUNDS):
            for factor, spec in specs.items():
                begin = time.process_time()
                recording = simulate(spec, sides[factor])
                spent = time.process_time() - begin
                nodes = sum(isinstance(event, NodeAdded) for event in recording.events)
                cost[factor] = min(cost[factor], spent / nodes)
        yield Claim(
            text=f"a node of {name}, world 4 times as large: the small world",
            ours=cost[2] * 1e6,
            theirs=cost[1] * 1e6,
            at_most=MAX_LOCAL_GROWTH,
        )


def raster_in_large_map() -> Iterator[Claim]:
    """Measure the painting of regions into what a robot knows, in maps of two sizes."""
    free = worlds.office(120.0, 24, seed=3)
    index = EdgeIndex(worlds.edges(free), RANGE_M / 3.0)
    places = worlds.viewpoints(free, 4000, seed=5)
    few, many = Occupancy(CELL_M, RADIUS_M), Occupancy(CELL_M, RADIUS_M)
    near = np.abs(places - 60.0).max(axis=1) < 15.0
    new = [_region(index, *place) for place in places[near][:60].tolist()]
    for place in places[near][60:].tolist():
        few.add(_region(index, *place))
    for place in places[~near].tolist() + places[near][60:].tolist():
        many.add(_region(index, *place))
    times = in_turns(new, {"few": few.add, "many": many.add}, repeats=1)
    yield Claim(
        text="region into the raster, map 16 times as large: the small map",
        ours=times["many"],
        theirs=times["few"],
        at_most=MAX_GROWTH,
    )


# Fields --------------------------------------------------------------------------------------


def repair() -> Iterator[Claim]:
    """Measure distances after a change of the map: a repaired field against a new one."""
    free = worlds.rooms()
    size = round(40.0 / CELL_M)
    centres = (np.arange(size, dtype=np.float64) + 0.5) * CELL_M
    x, y = np.meshgrid(centres, centres)
    cells = shapely.contains_xy(free, x, y)
    sources, changes = worlds.viewpoints(free, 2, seed=24)[:1], worlds.viewpoints(free, 81, seed=25)
    asked = np.floor(worlds.viewpoints(free, 12, seed=26)[:, ::-1] / CELL_M).astype(int)
    kept = DistanceField(cells, CELL_M, sources)
    answers: dict[str, np.ndarray] = {}
    same = True

    def change(place: np.ndarray) -> tuple[int, int, int, int]:
        column, row = np.floor(place / CELL_M).astype(int).tolist()
        window = (row, row + 2, column, column + 2)
        cells[row : row + 2, column : column + 2] ^= True
        return window

    def repaired(place: np.ndarray) -> None:
        kept.repair(change(place))
        answers["kept"] = kept.distance(asked)

    def anew(_: np.ndarray) -> None:
        nonlocal same
        answers["new"] = DistanceField(cells, CELL_M, sources).distance(asked)
        same = same and np.array_equal(answers["kept"], answers["new"])

    ours: list[float] = []
    theirs: list[float] = []
    for place in [p for p in changes if np.hypot(*(p - sources[0])) > 2.0]:
        for side, times in ((repaired, ours), (anew, theirs)):
            begin = time.perf_counter()
            side(place)
            times.append(time.perf_counter() - begin)
    yield Claim(
        text="distances after a change, 400 x 400 cells: a new field",
        ours=float(np.median(ours)) * 1e6,
        theirs=float(np.median(theirs)) * 1e6,
        at_least=1.0,
        holds=same,
        note="equal to the bit" if same else "not equal",
    )


def _robot_at(start: np.ndarray, index: EdgeIndex, places: np.ndarray) -> FrontierRobot:
    robot = FrontierRobot(
        RobotSelf(
            robot=0,
            start=Configuration(*start.tolist()),
            footprint=Footprint.parse(f"disc:{RADIUS_M}"),
            kinematics=Differential(),
            range_m=RANGE_M,
            rng=np.random.default_rng(0),
        ),
        FrontierOptions(cell_m=CELL_M),
    )
    all_places = [start.tolist(), *places.tolist()]
    robot.map.merge(tuple(_node(index, x, y, NodeId(1, i)) for i, (x, y) in enumerate(all_places)))
    return robot


def _node(index: EdgeIndex, x: float, y: float, name: NodeId) -> Node:
    at = Configuration(x, y)
    return Node(id=name, configuration=at, region=_region(index, x, y), parent=None, time_s=0.0)


def _region(index: EdgeIndex, x: float, y: float) -> LocalSafeRegion:
    return local_safe_region(take_scan(index, Configuration(x, y), 0.0, RANGE_M), "radial")


BENCHMARKS: dict[str, Benchmark] = {
    "mission": mission,
    "many robots": crowd,
    "decision in a large map": decision_in_large_map,
    "missions in a large world": missions_in_large_world,
    "repair of a field": repair,
    "raster of a large map": raster_in_large_map,
    "travel": travel,
}


if __name__ == "__main__":
    main()
