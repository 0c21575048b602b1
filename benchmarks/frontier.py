"""What frontier bidding costs: whole missions, decisions in large maps, fields and rasters."""

from __future__ import annotations

import itertools
import math
import sys
import time
from collections.abc import Generator, Iterator
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import shapely

from benchmarks import worlds
from benchmarks.harness import Claim, in_turns, show
from multisrt.analysis.coverage import CoverageMeter
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
from multisrt.robots.frontier.rules import choose_closest
from multisrt.robots.knowledge import Node, NodeId
from multisrt.simulation.simulate import simulate
from multisrt.simulation.worlds import inline
from multisrt.spec import CatalogEnvironment, RangeFinderSpec, RobotSpec, RunSpec, StopRule

MAPS = Path(__file__).resolve().parents[1].parent / "shared" / "maps"
"""Public maps; what needs them is skipped where they are not."""

GRID_ROOM = "explore_bench/grid_room_1.pgm"
GRID_ROOM_CELL_M = 0.1
GRID_ROOM_STARTS = ((9.85, 3.35), (10.35, 12.55))
GRID_ROOM_RANGE_M = 3.5
COVERED = 0.98
RULES = ("closest", "greedy", "minpos", "utility", "self-bidding", "rules")

MOST_MISSION_S = 0.5
MOST_TRAVEL_M = {"minpos": 41.0, "best of all": 36.0}
MOST_STEP_S = 0.003

CROWD, CROWD_BEAMS, CROWD_WORLD, CROWD_RUN_S = 10, 360, "office", 60.0
RANGE_M, RADIUS_M, CELL_M = 4.0, 0.25, 0.1
NEWS = 24
ROUNDS = 3


def main() -> None:
    """Print every claim with its figures; exit with 1 where one is not met."""
    all_met = show(claims())
    sys.exit(0 if show_figures() and all_met else 1)


def claims() -> Iterator[Claim]:
    """Measure one claim after the other."""
    yield mission()
    yield crowd()
    yield decision_in_large_map()
    yield repair()
    yield raster_in_large_map()


def show_figures() -> bool:
    """Print how far robots drive in the room of the public map; tell whether it is little."""
    world = grid_room()
    if world is None:
        print(f"\n{GRID_ROOM} is not here: travel skipped")
        return True
    print(f"\n{'strategy':>14} {'time s':>8} {'longest m':>10}  to {COVERED:.0%}, two robots")
    longest = {}
    for name in RULES:
        recording = simulate(grid_room_spec(name), world)
        until = covered_s(recording, world)
        longest[name] = math.inf if until is None else max(travelled_m(recording, until))
        print(f"{name:>14} {math.inf if until is None else until:8.1f} {longest[name]:10.1f}")
    longest["best of all"] = min(longest.values())
    all_met = True
    for name, most in MOST_TRAVEL_M.items():
        met = longest[name] <= most
        all_met = all_met and met
        print(
            f"{name:>14} {'':8} {longest[name]:10.1f}  <= {most:g}  {'met' if met else 'NOT MET'}"
        )
    return all_met


# Whole missions ------------------------------------------------------------------------------


def mission() -> Claim:
    """Time of computing that a mission takes until most of the world is covered."""
    text = f"closest, two robots, to {COVERED:.0%} of a room: {MOST_MISSION_S:g} s"
    world = grid_room()
    if world is None:
        return Claim(text=text, note=f"{GRID_ROOM} is not here: skipped", skipped=True)
    spec = grid_room_spec("closest")
    until = covered_s(simulate(spec, world), world)
    assert until is not None, "the mission ended before"
    spent = math.inf
    for _ in range(ROUNDS):
        begin, end = time.process_time(), math.inf

        def watch(event: AnyEvent) -> None:
            nonlocal end
            if isinstance(event, NodeAdded) and event.time_s <= until:
                end = time.process_time()

        simulate(spec, world, watch=watch)
        spent = min(spent, end - begin)
    return Claim(
        text=text,
        ours_us=spent * 1e6,
        theirs_us=MOST_MISSION_S * 1e6,
        at_most=1.0,
        note=f"{until:.0f} s of the mission, {until / spent:.0f} times as fast",
    )


@cache
def grid_room() -> Environment | None:
    """The world of rooms that lie in a grid, if the public maps are here."""
    path = MAPS / GRID_ROOM
    return read_environment(path, resolution_m=GRID_ROOM_CELL_M) if path.is_file() else None


def grid_room_spec(strategy: str) -> RunSpec:
    """Two robots in that world."""
    world = grid_room()
    assert world is not None
    finder = RangeFinderSpec(range_m=GRID_ROOM_RANGE_M)
    return RunSpec(
        environment=inline(world),
        strategy=strategy,
        robots=tuple(RobotSpec(start=start, range_finder=finder) for start in GRID_ROOM_STARTS),
    )


def covered_s(recording: Recording, world: Environment) -> float | None:
    """When most of the world was covered; None if it never was."""
    starts = tuple(Configuration(*start) for start in recording.header.starts)
    meter = CoverageMeter(recording.spec, world, starts)
    for event in recording.events:
        if isinstance(event, NodeAdded):
            meter.add(event.time_s, event.region())
    return meter.time_to(COVERED)


def travelled_m(recording: Recording, until_s: float) -> list[float]:
    """How far every robot has driven by some time."""
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
    """An explorer that notes how long it computes."""

    spent_s = 0.0

    def __init__(self, explorer: Explorer) -> None:
        self.explorer = explorer

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
                _Timed.spent_s += time.process_time() - begin
            outcome = yield action


def crowd() -> Claim:
    """Mapping and decisions of many robots with lasers."""
    closest = registry.strategy("closest")

    def explorer(me: RobotSelf, options: Any) -> Explorer:
        return _Timed(closest.explorer(me, options))

    registry.register(
        registry.Strategy(
            name="closest, timed",
            summary=closest.summary,
            options=closest.options,
            explorer=explorer,
        )
    )
    robot = RobotSpec(range_finder=RangeFinderSpec(range_m=RANGE_M, beams=CROWD_BEAMS))
    spec = RunSpec(
        environment=CatalogEnvironment(name=CROWD_WORLD),
        strategy="closest, timed",
        robots=(robot,) * CROWD,
        stop=StopRule(max_time_s=CROWD_RUN_S),
        seed=1,
    )
    world = environment(CROWD_WORLD)
    least, whole = math.inf, math.inf
    for _ in range(ROUNDS + 1):
        _Timed.spent_s = 0.0
        begin = time.process_time()
        recording = simulate(spec, world)
        whole = min(whole, time.process_time() - begin)
        least = min(least, _Timed.spent_s)
    steps = CROWD * recording.footer.time_s
    return Claim(
        text=f"{CROWD} robots, {CROWD_BEAMS} beams: a robot's second, {1e3 * MOST_STEP_S:g} ms",
        ours_us=least / steps * 1e6,
        theirs_us=MOST_STEP_S * 1e6,
        at_most=1.0,
        note=f"mapping and decisions; with the simulation {1e3 * whole / steps:.2f} ms",
    )


# Large maps ----------------------------------------------------------------------------------


def decision_in_large_map(near_m: float = 12.0, far_m: float = 24.0) -> Claim:
    """A decision of `closest` after something new was seen, in maps of two sizes."""
    side = 60.0
    free = worlds.office(side, 12, seed=7)
    index = EdgeIndex(worlds.edges(free), RANGE_M / 3.0)
    places = worlds.viewpoints(free, 3000, seed=8)
    middle = np.full(2, side / 2.0)
    from_middle = np.abs(places - middle).max(axis=1)
    # Around the robot everything is known but some rooms beside it, from where the news comes:
    # not so much that the nearest frontier of both maps would not be there.
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
    return Claim(
        text="decision of closest, map 4 times as large",
        ours_us=times["large"],
        theirs_us=times["small"],
        at_most=1.5,
        holds=same,
        note=f"{groups[0]} and {groups[1]} frontiers; goals are {'' if same else 'not '}the same",
    )


def raster_in_large_map() -> Claim:
    """Painting of a region into what a robot knows, in maps of two sizes."""
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
    return Claim(
        text="region into the raster, map 16 times as large",
        ours_us=times["many"],
        theirs_us=times["few"],
        at_most=1.5,
    )


# Fields --------------------------------------------------------------------------------------


def repair() -> Claim:
    """Distances after a change of the map: a repaired field against a new one."""
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
    return Claim(
        text="distances after a change, 400 x 400 cells: a new field",
        ours_us=float(np.median(ours)) * 1e6,
        theirs_us=float(np.median(theirs)) * 1e6,
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


if __name__ == "__main__":
    main()
