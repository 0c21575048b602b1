"""Runs against their lower bounds: ``python -m benchmarks.bounds --worlds 10000``.

Draws small worlds that are hard on bounds (slanted, narrow, slitted, with thin walls and small
bodies), explores each, and compares the time of every tenth of the run with the bounds for the
share that was covered by then. Prints each case that beats one, and exits with 1 if any did.
What counts is the area that bodies can reach, in polygons of shapely: the bounds hold for it as
for all that is explorable.
"""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np
import shapely
from shapely import MultiPolygon, Polygon, affinity
from shapely.geometry.base import BaseGeometry

from multisrt import MultiSrtError, explore
from multisrt.analysis.bounds import LowerBounds, lower_bounds
from multisrt.analysis.explorable import explorable, viewers
from multisrt.environments.environment import Environment
from multisrt.events import NodeAdded
from multisrt.recording import Recording
from multisrt.spec import DriveSpec, RangeFinderSpec, RobotSpec

STRATEGIES: Final = ("srt-radial", "closest", "minpos")

GRID_M: Final = 1e-9
"""Grid of the overlay of regions, in metres."""

ROUNDING_S: Final = 1e-6
"""A bound that is beaten by no more than this is not beaten."""


@dataclass(frozen=True, slots=True)
class Case:
    """A world with a team.

    Attributes
    ----------
    world : Environment
        The world.
    robots : tuple of RobotSpec
        The team.
    strategy : str
        How it explores.
    """

    world: Environment
    robots: tuple[RobotSpec, ...]
    strategy: str


@dataclass(frozen=True, slots=True)
class Reachable:
    """The places that bodies can reach, as what is to be seen.

    Attributes
    ----------
    area_m2 : float
        Their area.
    reachable : Polygon or MultiPolygon
        The places, in metres.
    """

    area_m2: float
    reachable: Polygon | MultiPolygon


@dataclass(frozen=True, slots=True)
class Reached:
    """What a run had covered by a time, and the bounds for it.

    Attributes
    ----------
    time_s : float
        The time.
    share : float
        The share of the places that bodies can reach.
    bounds : LowerBounds
        The bounds for the share.
    """

    time_s: float
    share: float
    bounds: LowerBounds

    @property
    def is_beaten(self) -> bool:
        """Whether the share was covered before a bound."""
        return self.time_s < self.bounds.largest_s - ROUNDING_S


def main() -> None:
    """Explore the worlds; exit with 1 if any run beat a bound."""
    parser = argparse.ArgumentParser(description="runs against their lower bounds")
    parser.add_argument("--worlds", type=int, default=1000, help="number of worlds")
    parser.add_argument("--first", type=int, default=0, help="number of the first world")
    options = parser.parse_args()
    explored, beaten, tightest = 0, 0, 0.0
    for number in range(options.first, options.first + options.worlds):
        case = draw(number)
        if case is None:
            continue
        explored += 1
        for reached in reached_by(case):
            tightest = max(tightest, reached.bounds.largest_s / max(reached.time_s, 1e-9))
            if reached.is_beaten:
                beaten += 1
                print(f"world {number}, {case.strategy}, {len(case.robots)} robots: {reached}")
        if explored % 100 == 0:
            print(f"{explored} worlds, {beaten} bounds beaten, tightest {tightest:.3f}", flush=True)
    print(f"{explored} worlds, {beaten} bounds beaten, tightest {tightest:.3f}")
    sys.exit(1 if beaten else 0)


def draw(number: int) -> Case | None:
    """Return a case by its number; None if its world has no room for the team."""
    rng = np.random.default_rng(number)
    kind = KINDS[number % len(KINDS)]
    free, body_m = kind(rng)
    free = affinity.rotate(free, float(rng.choice([0.0, 45.0, rng.uniform(0.0, 90.0)])))
    parts = shapely.get_parts(shapely.make_valid(free))
    largest = max(parts, key=lambda part: float(part.area))
    room = largest.buffer(-1.05 * body_m - 1e-3)
    places = max(shapely.get_parts(room), key=lambda part: float(part.area), default=Polygon())
    count = int(rng.integers(1, 4))
    starts = _starts(rng, places, count, 2.2 * body_m)
    if len(starts) < count:
        return None
    range_m = float(rng.choice([1.0, 2.0, 4.0]))
    robots = tuple(
        RobotSpec(
            start=start,
            footprint=f"disc:{body_m:.4f}",
            drive=DriveSpec(speed_m_s=float(rng.choice([0.5, 1.0])), turn_rate_rad_s=20.0),
            range_finder=RangeFinderSpec(
                range_m=range_m, beams=int(rng.choice([90, 360])) if number % 5 == 4 else None
            ),
        )
        for start in starts
    )
    strategy = STRATEGIES[int(rng.integers(len(STRATEGIES)))]
    return Case(Environment(f"world {number}", largest), robots, strategy)


def reached_by(case: Case) -> Iterator[Reached]:
    """Explore a world, and yield what was covered at every tenth of its nodes and at the end."""
    try:
        run = explore(
            case.world, robots=case.robots, strategy=case.strategy, seed=1, max_time_s=600.0
        )
    except MultiSrtError:
        # No strategy for this drive, sensor or body.
        return
    recording = run.recording
    whole = explorable(case.world, viewers(recording.spec, recording.starts))
    what = Reachable(area_m2=float(whole.reachable.area), reachable=whole.reachable)
    for time_s, share in _shares(recording, what):
        bounds = lower_bounds(
            recording.spec, case.world, what, recording.starts, share, witnesses=True
        )
        yield Reached(time_s, share, bounds)


def _shares(recording: Recording, what: Reachable) -> Iterator[tuple[float, float]]:
    nodes = recording.of(NodeAdded)
    covered: BaseGeometry = Polygon()
    shapely.prepare(what.reachable)
    # Overlays of hundreds of regions one by one pile up vertices where edges all but coincide.
    step = max(1, math.ceil(len(nodes) / 10))
    for tenth in (nodes[k : k + step] for k in range(0, len(nodes), step)):
        regions = [shapely.make_valid(Polygon(recording.region(node))) for node in tenth]
        covered = shapely.union_all([covered, *regions], grid_size=GRID_M)
        seen = float(covered.intersection(what.reachable).area)
        yield tenth[-1].time_s, min(1.0, seen / what.area_m2)


def _starts(
    rng: np.random.Generator, places: Polygon, count: int, apart_m: float
) -> list[tuple[float, float]]:
    found: list[tuple[float, float]] = []
    if places.is_empty:
        return found
    x0, y0, x1, y1 = places.bounds
    tried = rng.uniform((x0, y0), (x1, y1), (4000, 2))
    for x, y in tried[shapely.contains_xy(places, tried)].tolist():
        if len(found) < count and all(math.dist((x, y), other) > apart_m for other in found):
            found.append((x, y))
    return found


World = tuple[BaseGeometry, float]
"""Free space, and the radius of the bodies in it."""


def _corridor(rng: np.random.Generator) -> World:
    width = float(np.exp(rng.uniform(np.log(0.1), np.log(1.5))))
    length = float(rng.uniform(4.0, 25.0))
    return shapely.box(0.0, 0.0, length, width), float(rng.uniform(0.25, 0.4)) * width


def _comb(rng: np.random.Generator) -> World:
    tooth, wall = float(rng.uniform(0.12, 0.8)), float(rng.uniform(0.01, 0.3))
    count, depth = int(rng.integers(3, 12)), float(rng.uniform(0.5, 6.0))
    pitch = tooth + wall
    spine = shapely.box(0.0, -float(rng.uniform(1.0, 2.0)) * tooth, count * pitch, 0.0)
    teeth = [shapely.box(k * pitch, -0.01, k * pitch + tooth, depth) for k in range(count)]
    return shapely.union_all([spine, *teeth]), float(rng.uniform(0.2, 0.4)) * tooth


def _diamond(rng: np.random.Generator) -> World:
    side = float(rng.uniform(3.0, 12.0))
    hall = affinity.rotate(shapely.box(0.0, 0.0, side, side), 45.0)
    share = float(rng.uniform(0.1, 0.85))
    pillar = affinity.scale(hall, share, share)
    return hall.difference(pillar), 0.02 * side


def _branches(rng: np.random.Generator) -> World:
    width = float(rng.uniform(0.15, 0.8))
    points = [rng.uniform(0.0, 12.0, 2)]
    lines = []
    for _ in range(int(rng.integers(2, 9))):
        points.append(rng.uniform(0.0, 12.0, 2))
        lines.append(shapely.LineString([points[int(rng.integers(len(points) - 1))], points[-1]]))
    corridors = shapely.union_all(lines).buffer(0.5 * width, join_style="mitre")
    return corridors, float(rng.uniform(0.2, 0.4)) * width


def _stones(rng: np.random.Generator) -> World:
    side = float(rng.uniform(3.0, 10.0))
    stones = [
        affinity.rotate(
            shapely.box(x, y, x + rng.uniform(0.05, 1.5), y + rng.uniform(0.01, 0.6)),
            float(rng.uniform(0.0, 180.0)),
        )
        for x, y in rng.uniform(0.0, side, (int(rng.integers(2, 25)), 2))
    ]
    free = shapely.box(0.0, 0.0, side, side).difference(shapely.union_all(stones))
    return free, float(rng.uniform(0.05, 0.25))


def _rooms(rng: np.random.Generator) -> World:
    room, wall = float(rng.uniform(1.5, 4.0)), float(rng.uniform(0.01, 0.2))
    door, count = float(rng.uniform(0.5, 1.0)), int(rng.integers(2, 4))
    side = room * count
    walls = []
    for k in range(1, count):
        for j in range(count):
            at = j * room + float(rng.uniform(0.1, 0.9)) * (room - door)
            for low, high in ((j * room - wall, at), (at + door, (j + 1) * room)):
                across = (k * room - wall, k * room)
                walls.append(shapely.box(across[0], low, across[1], high))
                walls.append(shapely.box(low, across[0], high, across[1]))
    free = shapely.box(0.0, 0.0, side, side).difference(shapely.union_all(walls))
    return free, 0.3 * door


KINDS: Final = (_corridor, _comb, _diamond, _branches, _stones, _rooms)
"""The function that draws free space, in turn."""


if __name__ == "__main__":
    main()
