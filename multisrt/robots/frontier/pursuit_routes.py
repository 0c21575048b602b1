"""Routes of a robot and its teammates over frontiers, as one robot plans them for a pursuit."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from multisrt.geometry.configuration import Configuration
from multisrt.geometry.grids.grid_path import shortest_path
from multisrt.geometry.numerics.arrays import BoolArray, FloatArray
from multisrt.geometry.numerics.distances import length_of
from multisrt.planners.assignment.team_routes import TeamRoutes, team_routes
from multisrt.planners.navigation.path_following import ahead
from multisrt.robots.explorer import RobotSelf
from multisrt.robots.frontier.course import Course
from multisrt.robots.frontier.fields import indices_of
from multisrt.robots.frontier.goal import Place
from multisrt.robots.frontier.messages import RobotReport
from multisrt.robots.frontier.path_finder import PathFinder
from multisrt.robots.frontier.scan_map import ScanMap


class PathLengths:
    """Paths and their lengths over what a robot knows, without regard to bodies.

    Parameters
    ----------
    me : RobotSelf
        What the robot knows of itself.
    map : ScanMap
        What it knows.
    paths : PathFinder
        Its paths.

    Attributes
    ----------
    number : int
        Number of the robot.
    """

    def __init__(self, me: RobotSelf, map: ScanMap, paths: PathFinder) -> None:
        self.number = me.robot
        self._map = map
        self._paths = paths

    def costs(self, places: Sequence[Place], targets: FloatArray) -> FloatArray:
        """Return the lengths of paths from places to targets, ``(k, m)`` metres."""
        found = np.full((len(places), len(targets)), np.inf)
        indices = indices_of(self._map.raster, targets)
        for row, place in enumerate(places):
            field = self._paths.field(*place)
            if field is not None:
                found[row] = field.distance(indices)
        return found

    def path_between(self, here: Place, there: Place) -> FloatArray | None:
        """Return the path between two places, ``(n, 2)`` metres; None if there is none."""
        field = self._paths.field(*here)
        index = indices_of(self._map.raster, np.array([there]))
        if field is None or not math.isfinite(field.distance(index)[0]):
            return None
        return shortest_path(field, index[0])


class RouteTable:
    """Routes of all robots over the targets, for one decision whether to pursue.

    Parameters
    ----------
    lengths : PathLengths
        Lengths of paths.
    targets : (m, 2) array
        The targets in metres.
    reports : sequence of RobotReport
        The latest reports of the others.
    known : mapping of int to (m,) array of bool
        For each of the others, by number and in the same order, which targets it knows.
    course : Course
        Where this robot is.
    """

    def __init__(
        self,
        lengths: PathLengths,
        targets: FloatArray,
        reports: Sequence[RobotReport],
        known: Mapping[int, BoolArray],
        course: Course,
    ) -> None:
        self._lengths = lengths
        self._targets = targets
        self._robots = [lengths.number, *(report.robot for report in reports)]
        # A robot goes to its goal before it chooses another.
        ends = [r.place[:2] if r.goal is None else r.goal for r in reports]
        self._starts = lengths.costs([course.at[:2], *ends], targets)
        found = lengths.costs([(x, y) for x, y in targets.tolist()], targets)
        # The march along a path gives slightly different lengths from either end.
        self._path_lengths = np.minimum(found, found.T)
        self._before = np.array([0.0, *(report.remaining_m for report in reports)])
        self._known = np.array([np.ones(len(targets), np.bool_), *known.values()])

    def row_of(self, robot: int) -> int:
        """Return the row of a robot."""
        return self._robots.index(robot)

    def separate_routes(self) -> TeamRoutes:
        """Return the routes if no teammate is pursued."""
        costs = np.where(self._known, self._starts, np.inf)
        return team_routes(costs, self._path_lengths, initial_lengths=self._before)

    def routes_after_meeting(
        self, teammate: int, place: Place, before_m: float, passed: tuple[int, ...]
    ) -> TeamRoutes:
        """Return the routes if a teammate is met.

        Parameters
        ----------
        teammate : int
            Number of the teammate.
        place : (x, y)
            Place of the meeting in metres.
        before_m : float
            Length that both robots have driven by then, in metres.
        passed : tuple of int
            Targets that the teammate has passed by then, which are left out.
        """
        starts, before, known = self._starts.copy(), self._before.copy(), self._known.copy()
        rows = [0, self.row_of(teammate)]
        starts[rows] = self._lengths.costs([place], self._targets)[0]
        before[rows] = before_m
        known[rows] = True
        left = np.setdiff1d(np.arange(len(self._targets)), passed)
        return team_routes(
            np.where(known, starts, np.inf)[:, left],
            self._path_lengths[np.ix_(left, left)],
            initial_lengths=before,
        )

    def route(
        self, report: RobotReport, planned: tuple[int, ...]
    ) -> tuple[FloatArray, list[tuple[int, float]]]:
        """Return a teammate's route from where it was, and the targets with the lengths up to them.

        Parameters
        ----------
        report : RobotReport
            Its latest report.
        planned : tuple of int
            Targets that it visits after its goal, in order.
        """
        path = np.array(report.path or [report.place[:2]]).reshape(-1, 2)
        route = [report.place[:2], *map(tuple, ahead(path, Configuration(*report.place)).tolist())]
        passes = []
        for target in planned:
            x, y = self._targets[target].tolist()
            leg = self._lengths.path_between(route[-1], (x, y))
            if leg is None:
                break
            route += [(a, b) for a, b in leg.tolist()]
            passes.append((target, length_of(np.array(route))))
        return np.array(route), passes


def cells_of(route: FloatArray, cell_m: float) -> tuple[FloatArray, FloatArray]:
    """Return places along a route, one for each cell and the end, and their lengths along it.

    Parameters
    ----------
    route : (n, 2) array
        Its corners in metres.
    cell_m : float
        Length of a cell in metres.

    Returns
    -------
    cells : (k, 2) array
        The places in metres.
    at_m : (k,) array
        Length along the route up to each, in metres.

    Examples
    --------
    >>> cells_of(np.array([[0.0, 0.0], [7.0, 0.0]]), 3.0)[1].tolist()
    [0.0, 3.0, 6.0, 7.0]
    """
    legs = np.hypot(*np.diff(route, axis=0).T) if len(route) > 1 else np.empty(0)
    along = np.concatenate([[0.0], np.cumsum(legs)])
    at_m = np.append(np.arange(0.0, along[-1], cell_m), along[-1]) if along[-1] else np.zeros(1)
    cells = np.column_stack([np.interp(at_m, along, route[:, k]) for k in (0, 1)])
    return cells, at_m
