"""Shortest paths of one robot over what it knows to be passable, around bodies in its way."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from contextlib import contextmanager

import numpy as np
from scipy import ndimage

from multisrt.geometry.bodies.clearance import paths_keep_clear
from multisrt.geometry.grids.distance_field import DistanceField
from multisrt.geometry.grids.euclidean_field import EuclideanField
from multisrt.geometry.grids.grid_path import shortest_path
from multisrt.geometry.numerics.distances import length_of
from multisrt.planners.motion.body import PlanningBody
from multisrt.robots.explorer import Sighting
from multisrt.robots.frontier.bodies import Bodies, discs_of
from multisrt.robots.frontier.course import Course
from multisrt.robots.frontier.fields import NEAR_BY_CELLS, DistanceFields, indices_of
from multisrt.robots.frontier.goal import Goal, Place
from multisrt.robots.frontier.options import FrontierOptions
from multisrt.robots.frontier.scan_map import ScanMap
from multisrt.robots.protective_stop import planned_gap

ROUNDING_M = 1e-9
"""Distances that differ by less than this are equal."""


class PathFinder:
    """Shortest paths from where a robot stands.

    Parameters
    ----------
    body : PlanningBody
        Its body.
    options : FrontierOptions
        Its parameters.
    course : Course
        Where it is.
    map : ScanMap
        What it knows.
    bodies : Bodies
        The bodies in its way.
    """

    def __init__(
        self,
        body: PlanningBody,
        options: FrontierOptions,
        course: Course,
        map: ScanMap,
        bodies: Bodies,
    ) -> None:
        self._body = body
        self._options = options
        self._course = course
        self._map = map
        self._bodies = bodies
        self._fields = DistanceFields(map.raster)
        self._discs = discs_of(())
        self._blocked = b""

    @contextmanager
    def around_bodies(self, sightings: Iterable[Sighting] = ()) -> Iterator[None]:
        """Block the cells that bodies keep this robot from, for the duration of a block.

        Parameters
        ----------
        sightings : iterable of Sighting
            Bodies besides those in the way; of one robot, these count.
        """
        bodies = {s.robot: s for s in (*self._bodies.sightings(), *sightings)}
        if not bodies and not len(self._discs):
            yield
            return
        discs = discs_of(bodies.values(), self._body.outer_radius_m)
        before = self._discs, self._blocked
        self._discs, self._blocked = discs, self._blocked + discs.tobytes()
        try:
            with self._map.raster.blocked(discs + np.array([0.0, 0.0, self._options.guard_m])):
                yield
        finally:
            self._discs, self._blocked = before

    def field(self, x: float, y: float) -> DistanceField | None:
        """Return the distances from a place; see `DistanceFields.field`."""
        return self._fields.field(x, y)

    def own_field(self) -> DistanceField | None:
        """Return the distances from where the robot stands; to be called in `around_bodies`.

        Ask for lengths only while the same bodies block cells.

        Returns
        -------
        DistanceField or None
            None if no path begins near the robot.
        """
        raster, (x, y, _) = self._map.raster, self._course.at
        cell = self.first_cell()
        if cell is None:
            return None
        # From the exact place, so that a path does not begin with a turn to the cell's centre,
        # unless that path turned out not to be free, as beside a wall.
        here = cell == raster.cell_of(x, y) and not self._course.is_stuck
        source = (x, y) if here else raster.centre_of(*cell)
        return self._fields.own(source, self._blocked)

    def first_cell(self) -> tuple[int, int] | None:
        """Return the cell at which the robot's paths begin; to be called in `around_bodies`.

        It is the nearest passable cell. Beside a wall or a body that may be one from which no path
        leads, or one that can be reached only past the body; then it is the nearest cell from
        which a path leads and to which the robot can drive straight. If bodies are in the way and
        the robot stands on a passable cell, it is this cell.

        Returns
        -------
        (row, column) or None
            None if there is no such cell within `NEAR_BY_CELLS`.
        """
        raster, (x, y, _) = self._map.raster, self._course.at
        nearest = raster.passable_near(x, y, NEAR_BY_CELLS)
        is_own = nearest == raster.cell_of(x, y)
        # Bodies all around a passable cell may give way.
        if nearest is None or (is_own and (len(self._discs) or self._leads_straight(*nearest))):
            return nearest
        around = raster.passable_centres(x, y, (NEAR_BY_CELLS - 0.5) * raster.cell_m)
        cells = raster.cells_of(around)
        corner = cells.min(axis=0)
        window = np.zeros(cells.max(axis=0) - corner + 1, np.bool_)
        window[tuple((cells - corner).T)] = True
        labels = ndimage.label(window)[0]
        # A path leads on from the components that touch the rim of the window.
        rim = np.abs(cells - raster.cell_of(x, y)).max(axis=1) >= NEAR_BY_CELLS
        own = labels[tuple((cells - corner).T)]
        leads = np.isin(own, own[rim])
        keeps_off = is_own or self._keeps_off_bodies(raster.centre_of(*nearest))
        if keeps_off and leads[(cells == nearest).all(axis=1)].any():
            return nearest
        away = np.hypot(*(around - (x, y)).T)
        for k in np.flatnonzero(leads)[np.argsort(away[leads], kind="stable")].tolist():
            place_x, place_y = around[k].tolist()
            if self._keeps_off_bodies((place_x, place_y)) and self._body.disc_travel(
                self._map.boundary, x, y, place_x, place_y
            ):
                row, column = cells[k].tolist()
                return row, column
        return nearest if keeps_off else None

    def _leads_straight(self, row: int, column: int) -> bool:
        # Whether passable cells lead from one in a row or column for `NEAR_BY_CELLS`.
        raster, far = self._map.raster, NEAR_BY_CELLS + 1
        i, j = row - raster.row, column - raster.column
        along_row, along_column = raster.passable[i], raster.passable[:, j]
        rays = along_row[j:], along_row[j::-1], along_column[i:], along_column[i::-1]
        return any(len(ray) >= far and bool(ray[:far].all()) for ray in rays)

    def goal_at(self, field: DistanceField, x: float, y: float) -> Goal:
        """Return a place as a goal, with the path to it.

        Parameters
        ----------
        field : DistanceField
            Distances from where the robot stands.
        x, y : float
            The place in metres, which the field reaches.
        """
        raster = self._map.raster
        index = indices_of(raster, np.array([[x, y]]))[0]
        if self._options.paths == "eedt":
            path = EuclideanField(
                raster.passable, raster.cell_m, field.sources[0], x0=raster.x0, y0=raster.y0
            ).path(index)
        else:
            path = shortest_path(field, index)
        whole = np.concatenate(([self._course.at[:2]], path))
        return Goal(x, y, whole, length_of(whole))

    def centre_near(self, place: Place) -> Place | None:
        """Return the centre of the passable cell nearest to a place; None if none is near."""
        cell = self._map.raster.passable_near(*place, NEAR_BY_CELLS)
        return None if cell is None else self._map.raster.centre_of(*cell)

    def goal_near(self, place: Place) -> Goal | None:
        """Return the passable cell nearest to a place as a goal, around bodies."""
        with self.around_bodies():
            centre, field = self.centre_near(place), self.own_field()
            if centre is None or field is None:
                return None
            index = indices_of(self._map.raster, np.array([centre]))
            if not math.isfinite(field.distance(index)[0]):
                return None
            return self.goal_at(field, *centre)

    def detour_to(self, goal: Goal, sightings: Iterable[Sighting], limit_m: float) -> Goal | None:
        """Return a goal with a path around bodies.

        Parameters
        ----------
        goal : Goal
            The goal.
        sightings : iterable of Sighting
            Bodies besides those in the way.
        limit_m : float
            Length in metres above which the path is too long.

        Returns
        -------
        Goal or None
            None if there is no path, or none that is short enough.
        """
        with self.around_bodies(sightings):
            field = self.own_field()
            index = indices_of(self._map.raster, np.array([goal.place]))
            if field is None or not field.distance(index)[0] <= limit_m:
                return None
            around = self.goal_at(field, goal.x, goal.y)
        return around if around.cost_m <= limit_m else None

    def _keeps_off_bodies(self, place: Place) -> bool:
        """Whether the robot can drive straight to a place without being stopped by a body."""
        x, y, _ = self._course.at
        guard_m, discs = self._options.guard_m, self._discs.copy()
        for disc in discs:
            apart, radii = math.dist(disc[:2], (x, y)), disc[2]
            # No motion is stopped beyond the guard distance.
            gap = min(guard_m, planned_gap(max(0.0, apart - radii), guard_m))
            disc[2] = min(apart - ROUNDING_M, radii + gap)
        return bool(paths_keep_clear(np.array([[x, y, *place]]), discs)[0])
