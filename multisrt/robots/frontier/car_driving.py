"""How a car drives along paths: which motion it makes, and when it gives a goal up.

A motion is driven to its end as long as the goal stays the same, unless it is stopped.
"""

from __future__ import annotations

import math
from collections.abc import Generator
from dataclasses import dataclass

import numpy as np

from multisrt.geometry.numerics.distances import length_of
from multisrt.geometry.numerics.kernel import FloatArray
from multisrt.planners.motion.kinematics import Car
from multisrt.planners.motion.trajectory import Trajectory
from multisrt.planners.navigation.right_of_way import place_aside
from multisrt.robots.explorer import Action, Moved, Outcome, RobotSelf
from multisrt.robots.frontier.bodies import Bodies
from multisrt.robots.frontier.car_planning import MIN_LENGTH_M, CarPlanner
from multisrt.robots.frontier.car_route import Route
from multisrt.robots.frontier.course import Course
from multisrt.robots.frontier.goal import Place
from multisrt.robots.frontier.options import FrontierOptions
from multisrt.robots.frontier.scan_map import ScanMap


@dataclass(slots=True)
class Attempt:
    """How driving to one goal has gone.

    Attributes
    ----------
    nearest_m : float
        Minimum length of the path that was left.
    in_vain : int
        Number of motions since that did not bring the car nearer, with nothing new in the map.
    revision : int
        Revision of the raster at the last motion.
    """

    nearest_m: float = math.inf
    in_vain: int = 0
    revision: int = -1


class CarDriver:
    """Turns paths into motions of a car.

    Parameters
    ----------
    me : RobotSelf
        What the car knows of itself.
    car : Car
        How it moves.
    options : FrontierOptions
        Its parameters.
    course : Course
        Where it is.
    map : ScanMap
        What it knows.
    bodies : Bodies
        The bodies in its way.

    Attributes
    ----------
    route : Route
        The motion in progress, and how it can continue from there.
    """

    def __init__(
        self,
        me: RobotSelf,
        car: Car,
        options: FrontierOptions,
        course: Course,
        map: ScanMap,
        bodies: Bodies,
    ) -> None:
        self.route = Route(car, course)
        self._planner = CarPlanner(me, car, options, course, map, bodies)
        self._max_vain_motions = options.max_vain_motions
        self._course = course
        self._map = map
        self._bodies = bodies
        self._aim: Place | None = None
        self._attempts: dict[Place, Attempt] = {}

    def motion_along(self, path: FloatArray) -> Generator[Action, Outcome, Trajectory | None]:
        """Return the next motion along a path.

        It is the rest of the last one as long as the path leads to the same place.

        Parameters
        ----------
        path : (n, 2) array
            The path in metres, from where the car is.

        Yields
        ------
        Look
            If a motion is to be planned.

        Returns
        -------
        Trajectory or None
            None if no motion leads on, or too many have not led nearer to the goal.
        """
        aim = float(path[-1, 0]), float(path[-1, 1])
        if aim == self._aim and self.route.rest is not None:
            return self.route.rest
        if not self._may_try(aim, path):
            return None
        seen = yield from self._bodies.look()
        plan = self._planner.plan(path, self.route.exit_starts(), seen)
        if plan is None:
            return None
        self.route.take(plan)
        self._aim = aim
        return self.route.rest

    def note_driven(self, moved: Moved, set_out_s: float) -> None:
        """Record how far the car came on its motion, which began at `set_out_s`."""
        self.route.note_driven(moved.time_s - set_out_s)
        if moved.blocked_by is not None:
            # The next motion counts as another attempt, so that the same is not tried forever.
            self._aim = None

    def leave_by_exit(self, path: FloatArray, apart_m: float) -> Trajectory | None:
        """Set out along the exit, up to where the car is off another robot's path.

        Parameters
        ----------
        path : (n, 2) array
            The path of the other robot in metres.
        apart_m : float
            Minimum distance from it in metres.

        Returns
        -------
        Trajectory or None
            None if the exit does not lead so far away.
        """
        starts = self.route.exit_starts()
        places = np.array([motion.end[:2] for motion in starts])
        place = place_aside(
            places, np.array([motion.duration_s for motion in starts]), path, apart_m
        )
        if place is None:
            return None
        first = next(motion for motion in starts if motion.end[:2] == place)
        self.route.take_exit(first)
        self._aim = place
        return first

    def _may_try(self, aim: Place, path: FloatArray) -> bool:
        """Count an attempt; return whether it is worth making: not too many earlier ones failed."""
        attempt = self._attempts.setdefault(aim, Attempt())
        left_m = length_of(path) + math.dist(path[0], self._course.at[:2])
        revision = self._map.raster.revision
        if left_m < attempt.nearest_m - MIN_LENGTH_M:
            attempt.nearest_m, attempt.in_vain = left_m, 0
        elif revision != attempt.revision:
            attempt.in_vain = 0
        else:
            attempt.in_vain += 1
        attempt.revision = revision
        return attempt.in_vain <= self._max_vain_motions
