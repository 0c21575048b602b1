"""A raster map of the known area, with its frontiers and paths."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import numpy as np

from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.grids.distance_field import DistanceField
from multisrt.geometry.grids.grid_path import shortest_path
from multisrt.geometry.grids.occupancy import FrontierGroup, Occupancy
from multisrt.geometry.grids.sight import in_sight
from multisrt.geometry.numerics.arrays import ByteArray, FloatArray
from multisrt.geometry.regions.safe_region import LocalSafeRegion
from multisrt.geometry.regions.scan import Scan
from multisrt.geometry.regions.shapes import Shape
from multisrt.robots.explorer import RobotSelf, Sighting
from multisrt.robots.frontier.bodies import discs_of
from multisrt.robots.frontier.fields import NEAR_BY_CELLS, DistanceFields, indices_of
from multisrt.robots.frontier.frontiers import Frontiers
from multisrt.robots.frontier.scan_map import ScanMap, raster_for
from multisrt.robots.knowledge import Entries, Entry, Node, NodeId
from multisrt.robots.toolkit.places import is_single, places_of


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Frontier:
    """A group of adjacent free cells next to unknown ones, and a place from which to look.

    Attributes
    ----------
    x, y : float
        The most central place in the group at which the body can stand, in metres.
    size_m : float
        Length of the group in metres.
    cells : (k, 2) array
        Centres of its cells in metres.
    """

    x: float
    y: float
    size_m: float
    cells: FloatArray

    @property
    def place(self) -> tuple[float, float]:
        """The place as a pair."""
        return self.x, self.y


class FrontierMap:
    """The map of one robot as a raster: free cells, frontiers, and paths to them.

    It is made from the robot's own scans and from data of other robots. Adding a scan takes a few
    milliseconds, regardless of the size of the map, because only changed parts are recomputed.

    Parameters
    ----------
    me : RobotSelf
        What the robot knows about itself: its body and its number.
    cell_m : float
        Width of a cell in metres; at most the body's width.
    margin_m : float
        Distance in metres that the body keeps from space that is not known to be free.
    shape : {"radial", "star", "ball"}
        The part of a scan that is taken as free; see `local_safe_region`.
    cones : int
        Number of equal cones of a star.
    min_frontier_m : float, optional
        Shorter frontiers are omitted. By default the body's width, because the body does not fit
        through a narrower opening.

    Attributes
    ----------
    raster : Occupancy
        The state of every cell, and the cells at which the body can stand. Read-only.
    entries : Entries
        The scans as nodes, its own and those of others, as robots send them. Read-only.
    region : LocalSafeRegion or None
        The local safe region of its own last scan, in which it can drive. None before the first.

    Raises
    ------
    InvalidInputError
        If the cells are wider than the body.

    Examples
    --------
    A robot in the middle of a hall of 20 m x 3 m sees 4 m to either side:

    >>> from multisrt.geometry.bodies.footprint import Footprint
    >>> from multisrt.geometry.configuration import Configuration
    >>> from multisrt.geometry.regions.edge_index import EdgeIndex
    >>> from multisrt.geometry.regions.scan import take_scan
    >>> from multisrt.planners.motion.kinematics import Differential
    >>> corners = np.array([[0.0, 0.0], [20.0, 0.0], [20.0, 3.0], [0.0, 3.0]])
    >>> hall = EdgeIndex(np.hstack([corners, np.roll(corners, -1, axis=0)]), 4.0 / 3.0)
    >>> me = RobotSelf(
    ...     robot=0,
    ...     start=Configuration(10.0, 1.5, 0.0),
    ...     footprint=Footprint.disc(0.25),
    ...     kinematics=Differential(),
    ...     range_m=4.0,
    ...     rng=np.random.default_rng(0),
    ... )
    >>> known = FrontierMap(me)
    >>> node = known.add(take_scan(hall, me.start, time_s=0.0, range_m=me.range_m))
    >>> frontiers = known.frontiers(me.start)
    >>> [(round(f.x, 1), round(f.size_m, 1)) for f in frontiers]
    [(6.1, 2.9), (14.0, 2.9)]
    >>> known.costs(me.start, frontiers).round(1).tolist()
    [3.9, 4.0]
    >>> known.costs([me.start, (7.0, 1.5)], frontiers).round(1).tolist()
    [[3.9, 4.0], [0.9, 7.0]]
    >>> known.path(me.start, frontiers[1]).shape
    (2, 2)
    """

    def __init__(
        self,
        me: RobotSelf,
        *,
        cell_m: float = 0.1,
        margin_m: float = 0.02,
        shape: Shape = "radial",
        cones: int = 16,
        min_frontier_m: float | None = None,
    ) -> None:
        self.raster: Occupancy = raster_for(me.footprint, cell_m, margin_m, me.robot)
        width_m = me.footprint.width_m
        self._map = ScanMap(me.robot, self.raster, shape, cones)
        self._frontiers = Frontiers(self.raster, width_m, min_frontier_m)
        self._fields = DistanceFields(self.raster)
        self._radius_m = me.footprint.circumscribed_radius_m
        # Fields past bodies, by the cell that they begin at; None while no body is in the way.
        self._past_bodies: dict[tuple[int, int], DistanceField] | None = None
        self._described: dict[int, tuple[FrontierGroup, Frontier]] = {}

    @property
    def entries(self) -> Entries:
        """The scans as nodes."""
        return self._map.entries

    @property
    def region(self) -> LocalSafeRegion | None:
        """The local safe region of the robot's own last scan."""
        return self._map.region

    # Data -----------------------------------------------------------------------------------

    def add(self, scan: Scan) -> Node | None:
        """Add a scan taken by this robot.

        Parameters
        ----------
        scan : Scan
            The outcome of `Sense`.

        Returns
        -------
        Node or None
            The scan as a node, to be recorded (``Note(node.added("scan"))``) and sent to the
            others; None if it showed nothing new. The first scan always returns a node.
        """
        return self._map.add(scan)

    def merge(self, entries: Iterable[Entry]) -> tuple[NodeId, ...]:
        """Add data of other robots, in any order and possibly repeated.

        Parameters
        ----------
        entries : iterable of Node or Closing
            Nodes returned by their `add`. Closings of arcs have no effect.

        Returns
        -------
        tuple of NodeId
            The new nodes, to be recorded (`multisrt.events.Learned`).
        """
        return self._map.merge(tuple(entries))

    def window(self, place: Any, half_width_m: float) -> ByteArray:
        """Return the states of the cells around a place.

        Parameters
        ----------
        place : (x, y), Configuration, ...
            The centre; see `places_of`.
        half_width_m : float
            Half the width of the window in metres, rounded up to whole cells.

        Returns
        -------
        (2 k + 1, 2 k + 1) array of uint8
            `UNKNOWN` (0), `FREE` (1) or `OCCUPIED` (2); row 0 is the lowest y. A new array.
        """
        [(x, y)] = _one(place, "place").tolist()
        reach = int(np.ceil(half_width_m / self.raster.cell_m - 1e-9))
        row, column = self.raster.cell_of(x, y)
        return self.raster.square(row - reach, column - reach, 2 * reach + 1)

    # Frontiers ------------------------------------------------------------------------------

    def frontiers(self, from_: Any = None) -> tuple[Frontier, ...]:
        """Return the frontiers, each with a place at which the body can stand.

        Parameters
        ----------
        from_ : place, optional
            Place of the body. Frontiers that it cannot reach from there are omitted, and those that
            it can reach only at another cell have that cell as their place. By default all
            frontiers are returned, whether there is a path or not.

        Returns
        -------
        tuple of Frontier
            The frontiers, in the order of their lowest cells, from left to right.
        """
        reach = None
        if from_ is not None:
            field = self._field(*_one(from_, "from_")[0].tolist())
            if field is None:
                return ()
            reach = field.reachable()
            self._frontiers.look_closer(reach, blocked=self._past_bodies is not None)
        found = [self._frontier(group, place) for group, place in self._frontiers.placed()]
        if reach is not None and found:
            reached = reach[tuple(indices_of(self.raster, places_of(found)).T)]
            found = [f for f, is_reached in zip(found, reached.tolist(), strict=True) if is_reached]
        self._described = {key: self._described[key] for key in map(id, self._groups())}
        return tuple(found)

    def is_frontier(self, place: Any) -> bool:
        """Whether a frontier lies within half the body's width of a place.

        Parameters
        ----------
        place : (x, y), Configuration, Frontier, ...
            The place; see `places_of`.
        """
        return self._frontiers.is_frontier(*_one(place, "place")[0].tolist())

    def give_up(self, place: Any) -> None:
        """Omit a place, and all places within half the body's width, from now on.

        Call it if a scan at a frontier has changed nothing, or if the frontier could not be
        reached. Other cells of the same frontier take its place.
        """
        [(x, y)] = _one(place, "place").tolist()
        self._frontiers.give_up((x, y))

    # Paths ----------------------------------------------------------------------------------

    def costs(self, from_: Any, to: Any) -> FloatArray:
        """Return the lengths of the shortest paths.

        Parameters
        ----------
        from_ : place or places
            Starts of the paths, of this robot or of others; see `places_of`.
        to : place or places
            Ends of the paths, such as `frontiers`.

        Returns
        -------
        (n, m) or (m,) array
            Lengths in metres; ``inf`` if there is no path. One row for each place of `from_`, or a
            one-dimensional array if that is a single place.

        Notes
        -----
        Paths lead over cells at which the body can stand with any heading. A path begins at the
        nearest such cell, at most 8 cells away. Lengths are those of `distance_field`, which are
        0.5 % too long on average.
        """
        starts, ends = places_of(from_, "from_"), places_of(to, "to")
        table = np.full((len(starts), len(ends)), np.inf)
        for row, (x, y) in enumerate(starts.tolist()):
            field = self._field(x, y)
            if field is not None:
                table[row] = self._distances(field, ends)
        return table[0] if is_single(from_) else table

    def path(self, from_: Any, to: Any) -> FloatArray | None:
        """Return the shortest path between two places.

        Parameters
        ----------
        from_, to : place
            Its ends; see `places_of`.

        Returns
        -------
        (k, 2) array or None
            Its vertices in metres, from `from_` to the cell of `to`; None if there is no path.
            `trajectory_inside` returns a motion along it.
        """
        start, end = _one(from_, "from_"), _one(to, "to")
        field = self._field(*start[0].tolist())
        if field is None or not np.isfinite(self._distances(field, end)[0]):
            return None
        line = shortest_path(field, indices_of(self.raster, end)[0])
        if len(line) > 1 and self._sees(start[0], line[1]):
            line = line[1:]
        path: FloatArray = np.vstack([start, line])
        return path

    @contextmanager
    def around(self, bodies: Iterable[Sighting], guard_m: float = 0.1) -> Iterator[None]:
        """Keep paths away from the bodies of other robots within a ``with`` block.

        Parameters
        ----------
        bodies : iterable of Sighting
            The bodies: the outcome of `Look`, or the body that blocked a motion.
        guard_m : float
            Distance between two bodies in metres, as in `Move`.
        """
        discs = discs_of(bodies, self._radius_m + guard_m)
        if not len(discs):
            yield
            return
        before, self._past_bodies = self._past_bodies, {}
        try:
            with self.raster.blocked(discs):
                yield
        finally:
            self._past_bodies = before

    def _field(self, x: float, y: float) -> DistanceField | None:
        if self._past_bodies is None:
            return self._fields.field(x, y)
        cell = self.raster.passable_near(x, y, NEAR_BY_CELLS)
        if cell is None:
            return None
        if cell not in self._past_bodies:
            self._past_bodies[cell] = self._fields.begin(self.raster.centre_of(*cell))
        return self._past_bodies[cell]

    def _sees(self, start: FloatArray, centre: FloatArray) -> bool:
        # Whether the body can go straight from a place to the centre of a cell.
        raster = self.raster
        x, y = ((start - (raster.x0, raster.y0)) / raster.cell_m).tolist()
        rows, columns = raster.passable.shape
        [(row, column)] = indices_of(raster, centre[None]).tolist()
        is_inside = 0.0 <= x < columns and 0.0 <= y < rows
        return is_inside and bool(in_sight(raster.passable, x, y, column, row))

    def _distances(self, field: DistanceField, places: FloatArray) -> FloatArray:
        # Places outside the window are not known, and no path leads there.
        cells = self.raster.cells_of(places)
        index = cells - np.array([self.raster.row, self.raster.column])
        inside = ((index >= 0) & (index < self.raster.cells.shape)).all(axis=1)
        lengths = np.full(len(places), np.inf)
        if inside.any():
            lengths[inside] = field.distance(index[inside])
        return lengths

    def _groups(self) -> list[FrontierGroup]:
        return [group for group in self._frontiers.groups() if id(group) in self._described]

    def _frontier(self, group: FrontierGroup, place: tuple[float, float]) -> Frontier:
        # The same object as before while neither the group nor its place has changed.
        known = self._described.get(id(group))
        if known is not None and known[0] is group and known[1].place == place:
            return known[1]
        cells = self.raster.centres_of(group.cells)
        cells.setflags(write=False)
        made = Frontier(x=place[0], y=place[1], size_m=group.size_m, cells=cells)
        self._described[id(group)] = group, made
        return made


def _one(place: Any, name: str) -> FloatArray:
    found = places_of(place, name)
    if len(found) != 1:
        raise InvalidInputError(f"{name} has {len(found)} places; give one")
    return found
