"""Areas that a run covered: over time, by several robots, and lost with robots that died."""

from __future__ import annotations

import itertools
import math
from bisect import bisect_left
from collections import defaultdict
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from multisrt.analysis.explorable import Explorable, explorable, viewers
from multisrt.environments.environment import Environment
from multisrt.events import Died, Learned, NodeAdded, NodeName
from multisrt.geometry.configuration import Configuration
from multisrt.geometry.grids.raster import Raster
from multisrt.geometry.numerics.kernel import BoolArray, FloatArray
from multisrt.recording import Recording
from multisrt.spec import RunSpec


class CoverageMeter:
    """The share of the explorable area that is covered, node by node.

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
        The area that counts: what the team could see.
    steps : list of (time_s, share)
        The share covered after every node.
    """

    def __init__(
        self, spec: RunSpec, environment: Environment, starts: tuple[Configuration, ...]
    ) -> None:
        self.explorable: Explorable = explorable(environment, viewers(spec, starts))
        seen = self.explorable.raster
        # Cells that do not count are marked from the start: each newly painted cell counts.
        self._raster = Raster(seen.cell_m, environment.bounds)
        self._raster.cells |= ~seen.cells
        self._all = int(np.count_nonzero(seen.cells))
        self._covered = 0
        self.steps: list[tuple[float, float]] = []

    @property
    def share(self) -> float:
        """The share covered so far, from 0 to 1."""
        return self._covered / self._all

    def add(self, time_s: float, region: FloatArray) -> None:
        """Add the region of a node, ``(n, 2)`` corners in metres, that was made at a time."""
        self._covered += self._raster.paint_inside(region)
        self.steps.append((time_s, self.share))

    def time_to(self, share: float) -> float | None:
        """Return when a share was covered, in seconds; None if it never was."""
        return next((time for time, covered in self.steps if covered >= share), None)

    def times_by_percent(self) -> tuple[float | None, ...]:
        """Return when each percent was covered, from 0 to 100; None if it never was."""
        times, shares = [0.0], [0.0]
        for time, share in self.steps:
            times.append(time)
            shares.append(share)
        # Coverage never falls.
        first = (bisect_left(shares, percent / 100) for percent in range(101))
        return tuple(times[k] if k < len(times) else None for k in first)

    def integral_of_rest(self, end_s: float) -> float:
        """Return the time integral of the share not yet covered, from 0 to an end."""
        times = [0.0, *(min(time, end_s) for time, _ in self.steps), end_s]
        rests = [1.0, *(1.0 - covered for _, covered in self.steps)]
        return math.fsum(
            rest * (b - a) for rest, (a, b) in zip(rests, itertools.pairwise(times), strict=True)
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class TeamAreas:
    """Parts of the explorable area that were seen twice, or lost.

    Attributes
    ----------
    overlap_m2 : float
        Area that at least two robots saw.
    lost_m2 : float
        Area that robots saw which died, and that is in no region that a survivor knows at the end.
    lost_by_robot_m2 : tuple of float
        The part of the lost area that each robot saw; 0 for survivors. Area that two of the dead
        saw counts for both.
    """

    overlap_m2: float
    lost_m2: float
    lost_by_robot_m2: tuple[float, ...]


def team_areas(recording: Recording, what: Explorable) -> TeamAreas:
    """Measure the areas that were seen twice, and those lost with robots that died.

    Parameters
    ----------
    recording : Recording
        The run.
    what : Explorable
        The area that counts.
    """
    robots = range(len(recording.spec.robots))
    regions: dict[int, dict[int, FloatArray]] = defaultdict(dict)
    for node in recording.of(NodeAdded):
        regions[node.robot][node.serial] = recording.region(node)
    once = np.zeros_like(what.raster.cells)
    twice = np.zeros_like(once)
    if len(robots) > 1:
        for robot in robots:
            own = _painted(what, regions[robot].values())
            twice |= once & own
            once |= own
    lost, lost_by_robot = _lost(recording, what, regions)
    return TeamAreas(
        overlap_m2=_count(twice) * what.cell_m2,
        lost_m2=_count(lost) * what.cell_m2,
        lost_by_robot_m2=tuple(_count(lost_by_robot[r]) * what.cell_m2 for r in robots),
    )


def _lost(
    recording: Recording, what: Explorable, regions: dict[int, dict[int, FloatArray]]
) -> tuple[BoolArray, list[BoolArray]]:
    # Lost cells, of the team and by robot.
    robots = range(len(recording.spec.robots))
    dead = {event.robot for event in recording.of(Died)}
    nothing = np.zeros_like(what.raster.cells)
    if not dead:
        return nothing, [nothing for _ in robots]
    passed_on: set[NodeName] = {
        name for event in recording.of(Learned) if event.robot not in dead for name in event.nodes
    }
    kept = _painted(
        what,
        (
            region
            for robot in robots
            for serial, region in regions[robot].items()
            if robot not in dead or (robot, serial) in passed_on
        ),
    )
    by_robot = [
        _painted(what, regions[robot].values()) & ~kept if robot in dead else nothing
        for robot in robots
    ]
    return np.logical_or.reduce(by_robot), by_robot


def _painted(what: Explorable, regions: Iterable[FloatArray]) -> BoolArray:
    # The explorable cells that lie in some regions.
    like = what.raster
    raster = Raster(like.cell_m)
    raster.column, raster.row = like.column, like.row
    raster.cells = np.zeros_like(like.cells)
    for region in regions:
        raster.paint_inside(region)
    return raster.cells & like.cells


def _count(cells: BoolArray) -> int:
    return int(np.count_nonzero(cells))
