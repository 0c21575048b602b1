"""Paths home over the raster of a robot that goes to frontiers, and to where it meets others.

The path home is the shortest over cells that are known to be passable, to a node from which the
base station is certain to hear the robot (`ContactPlaces`). It ends earlier where the base station
hears the robot on it. After the base station did not hear the robot at such a place, the only one
is that nearest to the base station, until it hears the robot again.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from multisrt.geometry.grids.distance_field import DistanceField
from multisrt.geometry.grids.grid_path import shortest_path
from multisrt.geometry.numerics.arrays import BoolArray, FloatArray
from multisrt.geometry.numerics.distances import length_of
from multisrt.robots.explorer import RobotSelf
from multisrt.robots.frontier.fields import indices_of
from multisrt.robots.frontier.goal import Goal, Place
from multisrt.robots.frontier.path_finder import PathFinder
from multisrt.robots.frontier.scan_map import ScanMap
from multisrt.robots.homing.contact import ContactPlaces
from multisrt.robots.knowledge import NodeId

STANDING_CELLS = 2
"""Maximum distance in cells from a node to the cell at which a robot that goes there stands."""


class HomePaths:
    """Paths home and between other places, over what a robot knows.

    Parameters
    ----------
    me : RobotSelf
        What the robot knows of itself; it has a base station.
    map : ScanMap
        What it knows.
    paths : PathFinder
        Its paths.
    is_unheard : callable
        Whether the base station did not hear the robot where it should have, and has not since.

    Attributes
    ----------
    contact : ContactPlaces
        Places from which the base station hears it.
    """

    def __init__(
        self, me: RobotSelf, map: ScanMap, paths: PathFinder, is_unheard: Callable[[], bool]
    ) -> None:
        self.contact = ContactPlaces(me)
        self._map = map
        self._paths = paths
        self._is_unheard = is_unheard
        self._was_unheard = False
        # By node where the robot is heard, the passable cell next to it.
        self._standing: dict[NodeId, tuple[int, int]] = {}
        self._sources: dict[Place, None] = {}
        self._field: DistanceField | None = None
        self._revision = -1

    @property
    def knows_contact(self) -> bool:
        """Whether a place is known where the base station hears the robot."""
        self.contact.update(self._map.entries)
        return len(self.contact.nodes) > 0

    def lengths(self, places: FloatArray) -> FloatArray:
        """Return the lengths of the paths home from places.

        Parameters
        ----------
        places : (m, 2) array
            Places in passable cells, in metres.

        Returns
        -------
        (m,) array
            Metres, too long by at most the diagonal of a cell; 0 where the base station hears the
            robot, ``inf`` where no path is known.
        """
        lengths: FloatArray = np.where(self._hears_at(places), 0.0, np.inf)
        away = np.isinf(lengths)
        if away.any() and (field := self._home_field()) is not None:
            lengths[away] = field.distance(indices_of(self._map.raster, places[away]))
        return lengths

    def length_from(self, place: Place) -> float:
        """Return the length of the path home from a place where the robot stands, in metres."""
        if self._hears(place):
            return 0.0
        centre = self._paths.centre_near(place)
        if centre is None:
            return math.inf
        return math.dist(place, centre) + float(self.lengths(np.array([centre]))[0])

    def length_between(self, here: Place, there: Place) -> float:
        """Return the length of the path between two places in metres, without regard to bodies."""
        field, centre = self._paths.field(*there), self._paths.centre_near(here)
        if field is None or centre is None:
            return math.inf
        return float(field.distance(indices_of(self._map.raster, np.array([centre])))[0])

    def path_from_home(self, place: Place) -> FloatArray | None:
        """Return the path from the base station to a place, without regard to bodies.

        Returns
        -------
        (n, 2) array or None
            Metres. If the robot knows no path to the base station itself, it begins where the base
            station hears the robot; None if the robot knows no path there either.
        """
        centre = self._paths.centre_near(place)
        if centre is None:
            return None
        index = indices_of(self._map.raster, np.array([centre]))
        for field in (self._paths.field(*self.contact.base), self._home_field()):
            if field is not None and math.isfinite(field.distance(index)[0]):
                return np.vstack([shortest_path(field, index[0]), [place]])
        return None

    def goal_home(self, here: Place) -> Goal | None:
        """Return where to go for the base station to hear the robot, around bodies.

        Parameters
        ----------
        here : (x, y)
            Where the robot is.

        Returns
        -------
        Goal or None
            None if no path is free.
        """
        raster = self._map.raster
        if self._hears(here):
            return Goal(*here, np.array([here]), 0.0)
        places = list(self._standing_places())
        nearest = self._end_from(here)
        paths = self._paths
        with paths.around_bodies():
            field = paths.own_field()
            if field is None:
                return None
            if nearest is not None:
                [cost_m] = field.distance(indices_of(raster, np.array([nearest])))
                if math.isfinite(cost_m):
                    return self._cut(paths.goal_at(field, *nearest))
            costs = field.distance(indices_of(raster, np.array(places).reshape(-1, 2)))
            if not np.isfinite(costs).any():
                return None
            found = paths.goal_at(field, *places[int(np.argmin(costs))])
        return self._cut(found)

    def goal_near(self, place: Place) -> Goal | None:
        """Return the passable cell nearest to a place as a goal, around bodies."""
        return self._paths.goal_near(place)

    def _end_from(self, here: Place) -> Place | None:
        """Return the place to which the path home leads, without regard to bodies."""
        field, centre = self._home_field(), self._paths.centre_near(here)
        if field is None or centre is None:
            return None
        index = indices_of(self._map.raster, np.array([centre]))
        if not math.isfinite(field.distance(index)[0]):
            return None
        x, y = shortest_path(field, index[0])[0].tolist()
        return x, y

    def _hears(self, place: Place) -> bool:
        """Return whether distance alone makes contact certain at a place."""
        return not self._is_unheard() and self.contact.certainly_in_range(*place)

    def _hears_at(self, places: FloatArray) -> BoolArray:
        """Return at which places, ``(m, 2)``, distance alone makes contact certain."""
        if self._is_unheard():
            return np.zeros(len(places), np.bool_)
        return self.contact.certainly_in_range_at(places)

    def _cut(self, goal: Goal) -> Goal:
        """Return a goal whose path ends where the base station first hears the robot."""
        path = goal.path
        for k in range(1, len(path)):
            (ax, ay), (bx, by) = path[k - 1].tolist(), path[k].tolist()
            leg_m = math.dist((ax, ay), (bx, by))
            steps = max(1, math.ceil(leg_m / self._map.raster.cell_m))
            for step in range(1, steps + 1):
                share = step / steps
                x, y = ax + share * (bx - ax), ay + share * (by - ay)
                if self._hears((x, y)):
                    cut = np.vstack([path[:k], [(x, y)]])
                    return Goal(x, y, cut, length_of(cut))
        return goal

    def _home_field(self) -> DistanceField | None:
        """Return the field of distances from the places where the base station hears the robot."""
        raster, is_unheard = self._map.raster, self._is_unheard()
        is_current = self._revision == raster.revision and is_unheard == self._was_unheard
        if is_current and self._field is not None:
            return self._field
        self._was_unheard = is_unheard
        places = self._standing_places()
        if not places:
            return None
        kept, changed = self._field, raster.changed_since(self._revision)
        if kept is None or kept.passable is not raster.passable or places != self._sources:
            kept = DistanceField(
                raster.passable, raster.cell_m, list(places), x0=raster.x0, y0=raster.y0
            )
        elif changed is not None:
            kept.repair(raster.window_of(changed))
        self._field, self._revision, self._sources = kept, raster.revision, places
        return kept

    def _standing_places(self) -> dict[Place, None]:
        """Return the places at which a robot stands that goes to where it is heard."""
        raster = self._map.raster
        self.contact.update(self._map.entries)
        cells = [*self._standing.values()]
        if cells:
            rows, columns = raster.indices_of(cells)
            still = raster.passable[rows, columns].tolist()
            pairs = zip(self._standing.items(), still, strict=True)
            self._standing = {node: cell for (node, cell), stands in pairs if stands}
        for node in self.contact.nodes.values():
            if node.id not in self._standing:
                cell = raster.passable_near(*node.configuration[:2], STANDING_CELLS)
                if cell is not None and self.contact.is_certain_beside(
                    node, raster.centre_of(*cell)
                ):
                    self._standing[node.id] = cell
        standing = {raster.centre_of(*cell): None for cell in self._standing.values()}
        if standing and self._is_unheard():
            base = self.contact.base
            return {min(standing, key=lambda place: math.dist(place, base)): None}
        return standing
