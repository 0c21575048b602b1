"""Targets: the frontiers that are worth going to, and what became of attempts to go there."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np

from multisrt.geometry.grids.occupancy import FrontierGroup, Occupancy
from multisrt.geometry.numerics.arrays import BoolArray, FloatArray, IntArray
from multisrt.geometry.numerics.distances import nearest_points
from multisrt.robots.frontier.fields import indices_of
from multisrt.robots.frontier.goal import Place


class Frontiers:
    """Frontier groups of a raster, the place to go to for each, and the places given up.

    Parameters
    ----------
    raster : Occupancy
        The raster.
    width_m : float
        Width of the body in metres.
    min_length_m : float or None
        Groups of frontier cells that are shorter than this are dropped; by default, than the width.
    """

    def __init__(
        self, raster: Occupancy, width_m: float, min_length_m: float | None = None
    ) -> None:
        self._raster = raster
        self._width_m = width_m
        self._min_length_m = width_m if min_length_m is None else min_length_m
        self._given_up: dict[Place, None] = {}
        # Places to which a car found no path, with the revision of the raster by which it did, and
        # the robots whose bodies it had to drive round.
        self._no_path: dict[Place, tuple[int, frozenset[int]]] = {}
        # By identity, as groups are kept until their cells change; the values keep them alive.
        self._unreachable: dict[int, FrontierGroup] = {}
        self._substitutes: dict[int, tuple[FrontierGroup, Place]] = {}
        self._seen_in_vain: dict[Place, None] = {}

    def groups(self) -> list[FrontierGroup]:
        """Return the groups of frontier cells that are long enough."""
        return self._raster.frontier_groups(self._min_length_m)

    def targets(self) -> FloatArray:
        """Return the places to go to: one for each group where the body can stand.

        Groups found unreachable are left out until they change, or are looked at again; see
        `look_closer`.

        Returns
        -------
        (m, 2) array
            Metres.
        """
        if not self._substitutes and not self._given_up:
            # In the common case the raster converts the targets of all groups at once.
            cells = [group.target for group in self._reachable() if group.target is not None]
            return self._raster.centres_of(cells)
        return np.array([place for _, place in self.placed()]).reshape(-1, 2)

    @property
    def leaves_out(self) -> bool:
        """Whether `targets` leaves out groups found unreachable: there may be a path by now."""
        return any(id(group) in self._unreachable for group in self.groups())

    def placed(self) -> list[tuple[FrontierGroup, Place]]:
        """Return the groups of `targets`, each with the place to go to."""
        return self._placed(self._reachable())

    def look_closer(self, reach: BoolArray, *, blocked: bool) -> bool:
        """Look for other targets in groups whose own one cannot be reached.

        The cells of a group need not be connected by passable cells: it may begin behind a gap
        too narrow for the body and end in the open. Groups without any target in reach are
        unreachable until they change, or this is called again.

        Parameters
        ----------
        reach : (rows, columns) array of bool
            The cells of the raster to which the robot has a path.
        blocked : bool
            Whether bodies block cells. Groups out of reach are then not taken as
            unreachable, as the bodies may leave.

        Returns
        -------
        bool
            Whether `targets` has gained or changed any.
        """
        found = False
        known, self._unreachable, substitutes = self._unreachable, {}, {}
        placed = self._placed(self.groups())
        places = np.array([place for _, place in placed]).reshape(-1, 2)
        in_reach = reach[tuple(indices_of(self._raster, places).T)]
        out_of_reach = []
        for (group, _), is_in_reach in zip(placed, in_reach.tolist(), strict=True):
            if id(group) in self._substitutes:
                substitutes[id(group)] = self._substitutes[id(group)]
            if is_in_reach:
                found |= id(group) in known
            else:
                out_of_reach.append(group)
        for group, cells in zip(
            out_of_reach, self._cells_in_reach(out_of_reach, reach), strict=True
        ):
            if len(cells):
                substitutes[id(group)] = group, self._most_central(group, cells)
                found = True
            elif not blocked:
                self._unreachable[id(group)] = group
        self._substitutes = substitutes
        return found

    def is_frontier(self, x: float, y: float) -> bool:
        """Whether a frontier cell lies within half the body's width of a place."""
        return self._raster.has_frontier_near(x, y, 0.5 * self._width_m)

    # What became of goals -----------------------------------------------------------------

    def note_reached(self, place: Place, at: Place) -> None:
        """Record that a goal counts as reached with the robot at `at`.

        If it is still a frontier, it was reached without result: it is given up if the robot stands
        there, and otherwise can be reached only by driving all the way.
        """
        if not self.is_frontier(*place):
            return
        if math.dist(at, place) < 0.5 * self._width_m:
            self.give_up(place)
        self._seen_in_vain[place] = None

    def was_seen_in_vain(self, place: Place) -> bool:
        """Whether a place was reached and still was a frontier."""
        return place in self._seen_in_vain

    def give_up(self, place: Place) -> None:
        """Exclude a place, and all within half the body's width, from the targets permanently."""
        self._given_up[place] = None

    @property
    def has_given_up(self) -> bool:
        """Whether a group with places to go to is at a place that was given up."""
        groups = [group for group in self.groups() if group.target is not None]
        if not groups:
            return False
        cells = np.concatenate([group.cells for group in groups])
        return bool(self._are_given_up(self._raster.centres_of(cells)).any())

    def is_given_up(self, place: Place) -> bool:
        """Whether a place, or one within half the body's width of it, is given up."""
        near_m = 0.5 * self._width_m
        return any(math.dist(place, given_up) <= near_m for given_up in self._given_up)

    def note_no_path(self, place: Place, bodies: Iterable[int]) -> None:
        """Record that a car found no path to a place round the bodies of robots; see `reopen`."""
        self._no_path[place] = self._raster.revision, frozenset(bodies)

    def has_no_path_past_bodies(self) -> bool:
        """Whether a frontier was given up to which a car found no path round bodies."""
        return any(
            barring and place in self._given_up and self.is_frontier(*place)
            for place, (_, barring) in self._no_path.items()
        )

    def reopen(self, bodies: Iterable[int]) -> bool:
        """Return to the targets the places to which a car found no path, if something has changed.

        Whether there is a path for a car depends on its configuration, on the space that it knows
        for turning round, and on the bodies in the way.

        Parameters
        ----------
        bodies : iterable of int
            The robots whose bodies are in the way now.

        Returns
        -------
        bool
            Whether there were any.
        """
        standing = frozenset(bodies)
        again = [
            place
            for place, (known, barring) in self._no_path.items()
            if known != self._raster.revision or not barring <= standing
        ]
        for place in again:
            del self._no_path[place]
            self._given_up.pop(place, None)
        return len(again) > 0

    def _placed(self, groups: list[FrontierGroup]) -> list[tuple[FrontierGroup, Place]]:
        placed = [(group, self._target(group)) for group in groups]
        return [(group, place) for group, place in placed if place is not None]

    def _reachable(self) -> list[FrontierGroup]:
        return [group for group in self.groups() if id(group) not in self._unreachable]

    def _target(self, group: FrontierGroup) -> Place | None:
        """Return the place to go to for a group; None if there is none."""
        if group.target is None:
            return None
        place = self._raster.centre_of(*group.target)
        if id(group) in self._substitutes:
            place = self._substitutes[id(group)][1]
        if not self._given_up:
            return place
        # Another of its cells may show what could not be seen from a place given up.
        cells, _ = self._open_cells([group])
        if not len(cells):
            return None
        if any(place == (x, y) for x, y in cells.tolist()):
            return place
        return self._most_central(group, cells)

    def _cells_in_reach(self, groups: list[FrontierGroup], reach: BoolArray) -> list[FloatArray]:
        """Return the centres of each group's open cells to which there is a path."""
        centres, owner = self._open_cells(groups)
        is_in_reach = reach[tuple(indices_of(self._raster, centres).T)]
        centres, owner = centres[is_in_reach], owner[is_in_reach]
        begins = np.searchsorted(owner, np.arange(1, len(groups)))
        return np.split(centres, begins) if groups else []

    def _open_cells(self, groups: list[FrontierGroup]) -> tuple[FloatArray, IntArray]:
        """Return the centres of passable cells that are not near a place given up.

        Returns
        -------
        centres : (n, 2) array
            Metres, group by group.
        owner : (n,) array of int
            The group to which each belongs.
        """
        if not groups:
            return np.empty((0, 2)), np.empty(0, np.int64)
        cells = np.concatenate([group.cells for group in groups])
        owner = np.repeat(np.arange(len(groups)), [len(group.cells) for group in groups])
        is_open = self._raster.passable[self._raster.indices_of(cells)]
        centres, owner = self._raster.centres_of(cells[is_open]), owner[is_open]
        is_open = ~self._are_given_up(centres)
        return centres[is_open], owner[is_open]

    def _are_given_up(self, places: FloatArray) -> BoolArray:
        """Return which places ``(n, 2)``, or ones within half the width of them, are given up."""
        given_up = np.array(list(self._given_up)).reshape(-1, 2)
        are: BoolArray = nearest_points(given_up, places) <= 0.5 * self._width_m
        return are

    def _most_central(self, group: FrontierGroup, places: FloatArray) -> Place:
        """Return the place nearest to the centroid of a group."""
        middle = self._raster.centres_of(group.cells).mean(axis=0)
        x, y = places[int(np.argmin(np.hypot(*(places - middle).T)))].tolist()
        return x, y
