"""The area that only one robot of a team knew, and that would have been lost with it."""

from __future__ import annotations

import itertools
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass
from operator import attrgetter

import numpy as np
from numpy.typing import NDArray

from multisrt.events import Died, Learned, NodeAdded, NodeName
from multisrt.geometry.grids.raster import Raster, runs_inside
from multisrt.geometry.numerics.boxes import bounds_of
from multisrt.geometry.numerics.kernel import FloatArray, IntArray, kernel
from multisrt.recording import Recording

CELL_M = 0.1
"""Default width of the cells in which known areas are counted, in metres."""


@dataclass(frozen=True, slots=True, kw_only=True)
class KnownToOne:
    """Area that only one robot knew, and that would have been lost with it.

    Attributes
    ----------
    integral_m2s : tuple of float
        For each robot the time integral of the area that it alone knew (m2 s).
    final_m2 : tuple of float
        For each robot the area that it alone knew at the end.
    """

    integral_m2s: tuple[float, ...]
    final_m2: tuple[float, ...]


def area_known_to_one(recording: Recording, *, cell_m: float = CELL_M) -> KnownToOne:
    """Integrate over time the area that only one robot knew.

    A robot knows the regions of the nodes that it made and of those that it learned of; a robot
    that dies knows nothing any more. Areas are counted in cells by their centres. They change only
    at events, so that the integral over time is exact.

    Parameters
    ----------
    recording : Recording
        The run.
    cell_m : float
        Width of a cell in metres.

    Returns
    -------
    KnownToOne
        Zeros where no robot made a node.

    Raises
    ------
    InvalidInputError
        If the width is not positive, or so small that there would be too many cells.

    Examples
    --------
    >>> from multisrt import CatalogEnvironment, RunSpec, area_known_to_one, simulate
    >>> recording = simulate(RunSpec(environment=CatalogEnvironment(name="apartment"), seed=1))
    >>> known = area_known_to_one(recording, cell_m=0.2)
    >>> len(known.final_m2), known.final_m2[0] > 10.0
    (1, True)
    """
    robots, end = len(recording.starts), recording.footer.time_s
    nodes = recording.of(NodeAdded)
    if not nodes:
        return KnownToOne(integral_m2s=(0.0,) * robots, final_m2=(0.0,) * robots)
    regions = {(node.robot, node.serial): recording.region(node) for node in nodes}
    areas = _Areas(regions, cell_m, robots)
    integral, since = np.zeros(robots), 0.0
    for time, learned, dead in _moments_of_knowledge(recording):
        integral += areas.alone * (time - since)
        since = time
        for name, who in learned.items():
            areas.learn(name, who)
        if dead:
            areas.forget(dead)
    integral += areas.alone * (end - since)
    return KnownToOne(
        integral_m2s=tuple((integral * cell_m**2).tolist()),
        final_m2=tuple((areas.alone * cell_m**2).tolist()),
    )


def _moments_of_knowledge(
    recording: Recording,
) -> Iterator[tuple[float, dict[NodeName, list[int]], list[int]]]:
    # For each moment: the nodes that were learned, each with the robots that did, and the dead.
    events = [*recording.of(NodeAdded), *recording.of(Learned), *recording.of(Died)]
    by_time = attrgetter("time_s")
    events.sort(key=by_time)
    for time, moment in itertools.groupby(events, key=by_time):
        learned: dict[NodeName, list[int]] = defaultdict(list)
        dead = []
        for event in moment:
            match event:
                case NodeAdded():
                    learned[event.robot, event.serial].append(event.robot)
                case Learned():
                    for name in event.nodes:
                        learned[name].append(event.robot)
                case Died():
                    dead.append(event.robot)
        yield time, learned, dead


NOBODY, SEVERAL = -1, -2
"""Marks of cells that no robot knows, or several do; others have the number of the one robot."""


class _Areas:
    """Which robots know each node, and for each cell the one robot that knows it, if any."""

    def __init__(self, regions: dict[NodeName, FloatArray], cell_m: float, robots: int) -> None:
        self.alone: IntArray = np.zeros(robots, np.int64)
        x0, y0, x1, y1 = bounds_of(np.concatenate(list(regions.values())))
        self._window = Raster(cell_m, (x0, y0, x1, y1))
        self._regions = regions
        self._runs: dict[NodeName, NDArray[np.int32]] = {}
        self._known_by: dict[NodeName, set[int]] = defaultdict(set)
        shape = self._window.cells.shape
        self._owners: NDArray[np.int32] = np.full(shape, NOBODY, np.int32)

    def learn(self, node: NodeName, robots: list[int]) -> None:
        """Add a node to the knowledge of some robots."""
        known_by = self._known_by[node]
        shared = len(known_by) > 1
        known_by.update(robots)
        # Cells that several robots know already do not change.
        if not shared:
            self._share(node)

    def forget(self, robots: list[int]) -> None:
        """Remove all knowledge of some robots."""
        self.alone[:] = 0
        self._owners[:] = NOBODY
        for node, known_by in self._known_by.items():
            known_by.difference_update(robots)
            self._share(node)

    def _share(self, node: NodeName) -> None:
        known_by = self._known_by[node]
        if not known_by:
            return
        if node not in self._runs:
            window = self._window
            boundary = self._regions[node]
            self._runs[node] = _runs(boundary, window.x0, window.y0, window.cell_m)
        owner = SEVERAL if len(known_by) > 1 else min(known_by)
        _share(self._runs[node], owner, self._owners, self.alone)


@kernel
def _runs(boundary: FloatArray, x0: float, y0: float, cell: float) -> NDArray[np.int32]:
    # The cells of a polygon in the grid, as (row, first column, column after the last).
    low_x, low_y, high_x, high_y = bounds_of(boundary)
    column, row = int((low_x - x0) / cell), int((low_y - y0) / cell)
    rows, columns = int((high_y - y0) / cell) + 1 - row, int((high_x - x0) / cell) + 1 - column
    runs = runs_inside(boundary, x0 + column * cell, y0 + row * cell, cell, rows, columns)
    for k in range(runs.shape[0]):
        runs[k, 0] += row
        runs[k, 1] += column
        runs[k, 2] += column
    return runs


@kernel
def _share(runs: NDArray[np.int32], owner: int, owners: NDArray[np.int32], alone: IntArray) -> None:
    # Marks cells as known to one robot more, or to several, and counts those known to one.
    for k in range(runs.shape[0]):
        row = runs[k, 0]
        for column in range(runs[k, 1], runs[k, 2]):
            before = owners[row, column]
            if before in (owner, SEVERAL):
                continue
            if before == NOBODY:
                owners[row, column] = owner
                if owner >= 0:
                    alone[owner] += 1
            else:
                owners[row, column] = SEVERAL
                alone[before] -= 1
