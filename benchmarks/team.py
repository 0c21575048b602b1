"""What a larger team costs: time per robot-step, messages per node, memory of a large map.

Teams of all sizes explore the same kind of ground at the same density: copies of the smallest
team's field, side by side. Runs end at a fixed simulated time, before any robot is done, so that
all do the same kind of work. The number of runs of each size is such that the sizes have equal
numbers of robots in total.
"""

from __future__ import annotations

import resource
import sys
import time
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import cache
from multiprocessing import get_context

import shapely
from shapely import affinity

from benchmarks import worlds
from benchmarks.harness import Benchmark, Claim
from benchmarks.kernels import R, map_of
from multisrt.environments.catalog import environment
from multisrt.environments.environment import Environment
from multisrt.events import AnyEvent, Decision, Motion, NodeAdded, Sent
from multisrt.geometry.regions.edge_index import EdgeIndex
from multisrt.recording import Recording
from multisrt.simulation.simulate import simulate
from multisrt.simulation.worlds import inline
from multisrt.spec import RadioSpec, RobotSpec, RunSpec, StopRule

TEAMS = (4, 16, 64)
TILE_M = 50.0
"""Width of the field that four robots explore: 25 m by 25 m for each."""

RADIO_RANGE_M = 15.0
RUN_S = 120.0
"""Simulated time of a run."""

ROUNDS = 3
"""Number of alternating measurements of teams of all sizes; the median counts."""

MAX_GROWTH = 1.6
"""Upper bound of a robot-step's time in a larger team over that in the smallest."""

LARGE_MAP = 10_000
"""Nodes of the map whose memory is measured."""

MAX_MEMORY_MB = 1000.0
"""Upper bound of the peak memory of a process that builds it."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Traffic:
    """What a team sent in a run: numbers of nodes, messages, bytes and receptions."""

    robots: int
    unlimited: bool
    nodes: int
    messages: int
    size_bytes: int
    deliveries: int

    def line(self) -> str:
        """Return a line of the table of traffic."""
        return (
            f"{self.robots:6} {'unlimited' if self.unlimited else f'{RADIO_RANGE_M:g} m':>10} "
            f"{self.nodes:6} {self.messages / self.nodes:9.1f} "
            f"{self.deliveries / self.nodes:11.1f} {self.size_bytes / self.nodes:9.0f}"
        )


def robot_steps() -> Iterator[Claim]:
    """Measure the time of a robot-step in teams of all sizes, alternating between them."""
    for robots in TEAMS:
        field(robots)
        step_s(robots, 1)  # compiles, and builds the world's solids
    rounds = [
        {robots: step_s(robots, TEAMS[-1] // robots) for robots in TEAMS} for _ in range(ROUNDS)
    ]
    small = TEAMS[0]
    for robots in TEAMS[1:]:
        middle = sorted(rounds, key=lambda times: times[robots] / times[small])[ROUNDS // 2]
        ratios = [times[robots] / times[small] for times in rounds]
        yield Claim(
            text=f"robot-step, team of {robots} against teams of {small}",
            ours=middle[robots] * 1e6,
            theirs=middle[small] * 1e6,
            at_most=MAX_GROWTH,
            note=f"median of {ROUNDS} rounds, from {min(ratios):.2f} to {max(ratios):.2f}",
        )


def messages() -> Iterator[str]:
    """Count what teams of two sizes send, with a limited and with an unlimited radio."""
    yield (
        f"\n{'robots':>6} {'radio':>10} {'nodes':>6} {'messages':>9} {'deliveries':>11} "
        f"{'bytes':>9}  per node, srt-radial, {RUN_S:g} s"
    )
    for robots in TEAMS[:2]:
        for unlimited in (False, True):
            yield traffic(robots, unlimited).line()
    yield ""


def memory() -> Iterator[Claim]:
    """Measure the memory of a large map."""
    yield Claim(
        text=f"peak memory with a map of {LARGE_MAP:,} nodes: {MAX_MEMORY_MB:,.0f} MB",
        ours=memory_of_map(LARGE_MAP),
        theirs=MAX_MEMORY_MB,
        unit="MB",
        at_most=1.0,
    )


BENCHMARKS: dict[str, Benchmark] = {
    "robot-steps of larger teams": robot_steps,
    "messages of teams": messages,
    "memory of a large map": memory,
}


def step_s(robots: int, runs: int) -> float:
    """Return the time per motion or decision of a robot, over runs with different seeds."""
    spent, steps = 0.0, 0
    for seed in range(runs):
        begin = None

        def note_begin(_: AnyEvent) -> None:
            # Preparations before the first event (starts, edges, solids) are once per run.
            nonlocal begin
            if begin is None:
                begin = time.perf_counter()

        recording = simulate(_spec(robots, seed), field(robots), watch=note_begin)
        assert begin is not None
        assert recording.footer.outcome == "out_of_time", recording.footer.reason
        spent += time.perf_counter() - begin
        steps += sum(isinstance(event, Motion | Decision) for event in recording.events)
    return spent / steps


def traffic(robots: int, unlimited: bool) -> Traffic:
    """Count what a team sends in one run."""
    recording: Recording = simulate(_spec(robots, 0, unlimited), field(robots))
    sent = [event for event in recording.events if isinstance(event, Sent)]
    return Traffic(
        robots=robots,
        unlimited=unlimited,
        nodes=sum(isinstance(event, NodeAdded) for event in recording.events),
        messages=len(sent),
        size_bytes=sum(event.size_bytes for event in sent),
        deliveries=sum(len(event.reached) for event in sent),
    )


@cache
def field(robots: int) -> Environment:
    """Return a field with obstacles for four robots, or several without walls between them."""
    tile = environment("clutter", size_m=TILE_M, seed=1).free
    side = round((robots / TEAMS[0]) ** 0.5)
    tiles = [
        affinity.translate(tile, TILE_M * column, TILE_M * row)
        for column in range(side)
        for row in range(side)
    ]
    return Environment(f"field of {TILE_M * side:g} m", shapely.union_all(tiles))


def memory_of_map(nodes: int) -> float:
    """Return the peak memory in MB of a new process that builds a map of a number of nodes."""
    # Not forked from here: a child would begin with all the memory that this process has.
    with ProcessPoolExecutor(1, mp_context=get_context("forkserver")) as pool:
        return pool.submit(_build_map, nodes).result()


def _build_map(nodes: int) -> float:
    free = worlds.office(240.0, 48, seed=4)
    index = EdgeIndex(worlds.edges(free), R / 3.0)
    known = map_of(index, worlds.viewpoints(free, nodes, seed=6))
    assert len(known) == nodes
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak / 1e6 if sys.platform == "darwin" else peak * 1024 / 1e6


def _spec(robots: int, seed: int, unlimited: bool = False) -> RunSpec:
    return RunSpec(
        environment=inline(field(robots)),
        strategy="srt-radial",
        robots=(RobotSpec(),) * robots,
        starts="scattered",
        radio=RadioSpec(range_m=None if unlimited else RADIO_RANGE_M),
        stop=StopRule(max_time_s=RUN_S),
        seed=seed,
    )
