"""Maps as grids: what robots know, and the truth, on one lattice of cells.

A cell of a map is free if its centre lies in a region that the robot knows, and occupied if an
observed surface passes through it, as in `multisrt.geometry.grids.occupancy`.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterator
from typing import Final, NamedTuple

import numpy as np
import shapely
from numpy.typing import NDArray

from multisrt.environments.environment import Environment
from multisrt.events import AnyEvent, Learned, NodeAdded, NodeName, Sensed
from multisrt.exporting.options import ExportOptions
from multisrt.geometry.configuration import Configuration
from multisrt.geometry.errors import ClearanceError, InvalidInputError
from multisrt.geometry.grids.occupancy import FREE, OCCUPIED, Occupancy
from multisrt.geometry.grids.polygon_fill import paint_polygon
from multisrt.geometry.numerics.arrays import BoolArray, ByteArray, FloatArray
from multisrt.geometry.regions.boundary import OBSTACLE
from multisrt.geometry.regions.edge_index import EdgeIndex
from multisrt.geometry.regions.safe_region import LocalSafeRegion, local_safe_region
from multisrt.recording import Recording
from multisrt.simulation.sensing import measured

Cells = NDArray[np.int8]
"""`UNKNOWN_CELL`, `FREE_CELL` or `OCCUPIED_CELL`, ``(rows, columns)``; row 0 is the lowest y."""

UNKNOWN_CELL, FREE_CELL, OCCUPIED_CELL = -1, 0, 100
"""Values of cells, as in maps of ROS."""

DEFAULT_CELL_M: Final = 0.1
"""Width of a cell in metres, unless the world is too large for it."""

MAX_DEFAULT_CELLS: Final = 1_000_000
"""Number of cells of a map above which the default width of a cell is doubled."""

MAX_CELLS: Final = 400_000_000
"""Upper bound of the cells of all maps of a team together."""

_VALUES: Final = np.full(3, UNKNOWN_CELL, np.int8)
_VALUES[FREE], _VALUES[OCCUPIED] = FREE_CELL, OCCUPIED_CELL


class Grid(NamedTuple):
    """The lattice of all maps of a run.

    Attributes
    ----------
    cell_m : float
        Width of a cell in metres.
    bounds : (x0, y0, x1, y1)
        The rectangle that its cells cover at least, in metres.
    x0, y0 : float
        Lower left corner of the first cell in metres.
    rows, columns : int
        Number of cells.
    """

    cell_m: float
    bounds: tuple[float, float, float, float]
    x0: float
    y0: float
    rows: int
    columns: int

    def empty(self) -> Occupancy:
        """Return an empty occupancy with the cells of the grid."""
        return Occupancy(self.cell_m, self.cell_m, self.bounds)

    def centres(self, mask: BoolArray) -> FloatArray:
        """Return the centres of the cells of a mask, ``(n, 2)``, row by row."""
        row, column = np.nonzero(mask)
        corner = np.array([self.x0, self.y0])
        centres: FloatArray = corner + self.cell_m * (np.column_stack([column, row]) + 0.5)
        return centres


def grid_of(recording: Recording, environment: Environment, options: ExportOptions) -> Grid:
    """Return the lattice of the maps of a run: it holds the world and all regions.

    Raises
    ------
    InvalidInputError
        If the maps of all robots together would have more than `MAX_CELLS` cells.
    """
    x0, y0, x1, y1 = environment.bounds
    for node in recording.of(NodeAdded):
        low, high = recording.region(node).min(axis=0), recording.region(node).max(axis=0)
        x0, y0, x1, y1 = min(x0, low[0]), min(y0, low[1]), max(x1, high[0]), max(y1, high[1])
    cell_m = options.cell_m or DEFAULT_CELL_M
    while options.cell_m is None and (x1 - x0) * (y1 - y0) > MAX_DEFAULT_CELLS * cell_m**2:
        cell_m *= 2.0
    cells = (math.ceil((x1 - x0) / cell_m) + 8) * (math.ceil((y1 - y0) / cell_m) + 8)
    robots = len(recording.starts)
    if cells * robots > MAX_CELLS:
        raise InvalidInputError(
            f"maps of {cells} cells for {robots} robots are more than {MAX_CELLS} cells: choose "
            f"cells wider than {cell_m:g} m"
        )
    # With room for the margin that an occupancy keeps around regions, so that it never has to grow.
    beyond_m = 3.0 * cell_m
    bounds = float(x0 - beyond_m), float(y0 - beyond_m), float(x1 + beyond_m), float(y1 + beyond_m)
    held = Occupancy(cell_m, cell_m, bounds)
    return Grid(cell_m, bounds, held.x0, held.y0, *held.cells.shape)


def truth_of(environment: Environment, grid: Grid) -> Cells:
    """Return the true world as cells; every cell is free or occupied."""
    walls, free = grid.empty(), np.zeros((grid.rows, grid.columns), np.bool_)
    for part in environment.free.geoms:
        for ring in (part.exterior, *part.interiors):
            corners = shapely.get_coordinates(ring)[:-1]
            tags = np.full(len(corners), OBSTACLE, np.int8)
            walls.add(LocalSafeRegion(x=0.0, y=0.0, range_m=1.0, boundary=corners, tags=tags))
            inside = np.zeros_like(free)
            paint_polygon(corners, grid.x0, grid.y0, grid.cell_m, inside)
            free ^= inside
    occupied = (walls.cells == OCCUPIED) | ~free
    return np.where(occupied, OCCUPIED_CELL, FREE_CELL).astype(np.int8)


def frontier_of(cells: Cells) -> BoolArray:
    """Return which cells are frontier: free cells beside an unknown one.

    Examples
    --------
    >>> cells = np.array([[-1, 0, 0, 100], [100, 0, 0, 100]], np.int8)
    >>> frontier_of(cells).astype(int).tolist()
    [[0, 1, 0, 0], [0, 0, 0, 0]]
    """
    unknown = cells == UNKNOWN_CELL
    beside = np.zeros_like(unknown)
    beside[1:] |= unknown[:-1]
    beside[:-1] |= unknown[1:]
    beside[:, 1:] |= unknown[:, :-1]
    beside[:, :-1] |= unknown[:, 1:]
    frontier: BoolArray = beside & (cells == FREE_CELL)
    return frontier


def values_of(cells: ByteArray) -> Cells:
    """Return the cells of an occupancy as values of a map."""
    values: Cells = _VALUES[cells]
    return values


class ShownRegions:
    """The regions that robots came to know by the events of a run.

    These are the regions of the nodes that a robot made, and of those that it learned of; for a
    robot that records no nodes, the regions that its scans showed.

    Parameters
    ----------
    recording : Recording
        The run.
    environment : Environment
        Its world.
    """

    def __init__(self, recording: Recording, environment: Environment) -> None:
        self._recording = recording
        self._nodes = {(node.robot, node.serial): node for node in recording.of(NodeAdded)}
        self._with_nodes = {node.robot for node in recording.of(NodeAdded)}
        self._robots = recording.spec.robots
        range_m = max(robot.range_finder.range_m for robot in self._robots)
        self._index = EdgeIndex(environment.edges, range_m / 3.0)
        self._regions: dict[NodeName, LocalSafeRegion] = {}

    def by(self, event: AnyEvent) -> Iterator[LocalSafeRegion]:
        """Yield the regions that the robot of an event came to know by it.

        The region of a node is the same object for all robots that know it.

        Raises
        ------
        InvalidInputError
            If a scan of a robot without nodes was not taken in free space.
        """
        match event:
            case NodeAdded():
                yield self._region(event)
            case Learned():
                for name in event.nodes:
                    yield self._region(self._nodes[name])
            case Sensed() if event.robot not in self._with_nodes:
                yield self._shown(event)

    def _region(self, node: NodeAdded) -> LocalSafeRegion:
        name = node.robot, node.serial
        if name not in self._regions:
            x, y, _ = node.configuration
            self._regions[name] = LocalSafeRegion(
                x=x,
                y=y,
                range_m=self._robots[node.robot].range_finder.range_m,
                boundary=self._recording.region(node),
                tags=np.frombuffer(node.tags.encode(), np.int8) - np.int8(ord("0")),
            )
        return self._regions[name]

    def _shown(self, scan: Sensed) -> LocalSafeRegion:
        place = Configuration(*scan.configuration)
        try:
            taken = measured(self._robots[scan.robot], self._index, place, scan.time_s)
        except ClearanceError as error:
            raise InvalidInputError(
                f"a scan of the recording was not taken in free space: {error}"
            ) from None
        return local_safe_region(taken, "radial")


class KnownMaps:
    """The maps of all robots, which grow with the events of a run.

    Parameters
    ----------
    recording : Recording
        The run.
    environment : Environment
        Its world.
    grid : Grid
        The lattice of the maps.
    """

    def __init__(self, recording: Recording, environment: Environment, grid: Grid) -> None:
        self._shown = ShownRegions(recording, environment)
        self._maps = [grid.empty() for _ in recording.starts]
        self._revisions: dict[int, int] = defaultdict(lambda: -1)

    def add(self, event: AnyEvent) -> None:
        """Add what a robot came to know by an event; see `ShownRegions.by`."""
        for region in self._shown.by(event):
            self._maps[event.robot].add(region)

    def changed(self) -> Iterator[tuple[int, Cells]]:
        """Yield the maps that have changed since they were last yielded, with their robots."""
        for robot, known in enumerate(self._maps):
            if known.revision != self._revisions[robot]:
                self._revisions[robot] = known.revision
                yield robot, values_of(known.cells)
