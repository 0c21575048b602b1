"""One robot that goes to frontiers, put together from its parts, and how it perceives."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from contextlib import AbstractContextManager
from typing import cast

import numpy as np

from multisrt.events import MapComplete
from multisrt.geometry.bodies.clearance import disc_clearance
from multisrt.geometry.bodies.footprint import Footprint
from multisrt.geometry.configuration import Configuration
from multisrt.geometry.grids.distance_field import DistanceField
from multisrt.geometry.grids.occupancy import Occupancy
from multisrt.geometry.numerics.arrays import BoolArray, FloatArray, IntArray
from multisrt.geometry.numerics.distances import inside
from multisrt.geometry.regions.scan import Scan
from multisrt.planners.motion.body import PlanningBody
from multisrt.planners.motion.kinematics import Car
from multisrt.robots.explorer import Note, RobotSelf, Sense, Sighting, Steps
from multisrt.robots.frontier.bodies import Bodies
from multisrt.robots.frontier.car_driving import CarDriver
from multisrt.robots.frontier.course import Course
from multisrt.robots.frontier.fields import NEAR_BY_CELLS, indices_of
from multisrt.robots.frontier.frontiers import Frontiers
from multisrt.robots.frontier.goal import Goal, Place
from multisrt.robots.frontier.homing import FrontierHoming
from multisrt.robots.frontier.options import FrontierOptions
from multisrt.robots.frontier.path_finder import PathFinder
from multisrt.robots.frontier.pursuit import Pursuit
from multisrt.robots.frontier.scan_map import ScanMap, raster_for
from multisrt.robots.frontier.team import Team

Watch = Callable[["FrontierRobot"], Steps]
"""Called after every scan that showed something new."""

ROUNDING_S = 1e-9
"""Times that differ by less than this are equal."""


class FrontierRobot:
    """The input of the rules of frontier bidding: one robot's knowledge and its place.

    The parts hold no reference to the robot, so that all of it is freed with the last reference
    to it.

    Parameters
    ----------
    me : RobotSelf
        What the robot knows of itself.
    options : FrontierOptions
        The parameters.
    watch : callable, optional
        Called after every scan that showed something new.

    Attributes
    ----------
    me : RobotSelf
        What the robot knows of itself.
    options : FrontierOptions
        The parameters.
    body : PlanningBody
        Its body with half the margin. Paths between cells pass walls more closely than the
        centres of the cells do, so legs are driven with less of a margin than paths are planned.
    course : Course
        Its clock, where it is, and where it is going.
    map : ScanMap
        What it knows of the world.
    bodies : Bodies
        Robots that stand in its way and do not leave.
    frontiers : Frontiers
        The places to go to.
    paths : PathFinder
        The shortest paths from where it stands.
    team : Team
        Its messages, and what it knows of the others.
    homing : FrontierHoming or None
        What delivers its data, if anything does.
    pursuit : Pursuit or None
        When it pursues teammates that are out of touch, if it may.
    car : CarDriver or None
        Plans its motions, if it is a car.
    pulled_out_from : list of (Place, int)
        Where it had no room to turn, and drove straight to where it has; with the revision of the
        raster.

    Raises
    ------
    InvalidInputError
        If the cells of the raster are wider than the body, or the time limit is too short to
        deliver data.
    """

    def __init__(self, me: RobotSelf, options: FrontierOptions, watch: Watch | None = None) -> None:
        width_m = me.footprint.width_m
        raster = raster_for(me.footprint, options.cell_m, options.margin_m, me.robot)
        self.me = me
        self.options = options
        self.body = PlanningBody(me.footprint, 0.5 * options.margin_m)
        self._watch = watch
        self._told_complete = False
        self.pulled_out_from: list[tuple[Place, int]] = []
        # When a scan was last added to the map, and the last scan if it was not.
        self._mapped_s = -math.inf
        self._not_mapped: Scan | None = None
        # Legs are planned for this disc: see `driven_body`.
        self._disc = PlanningBody(Footprint.disc(self.body.outer_radius_m), 0.5 * options.margin_m)
        self.course = Course(me.start, me.time_s)
        self.map = ScanMap(me.robot, raster, options.shape, options.cones)
        self.bodies = Bodies(self.course, self.map)
        self.frontiers = Frontiers(raster, width_m, options.min_frontier_m)
        self.path_finder = PathFinder(self.body, options, self.course, self.map, self.bodies)
        self.team = Team(me, options, self.course, self.map, self.bodies, self.frontiers)
        self.homing = (
            None
            if options.home == "never" or me.base is None
            else FrontierHoming(
                me,
                options,
                self.course,
                self.map,
                self.team,
                self.path_finder,
                self.bodies,
                self.frontiers,
            )
        )
        self.pursuit = (
            Pursuit(
                me,
                options,
                self.course,
                self.map,
                self.team,
                self.path_finder,
                self.frontiers,
                self.homing,
            )
            if options.pursue
            else None
        )
        drive = me.kinematics
        self.car = (
            CarDriver(me, drive, options, self.course, self.map, self.bodies)
            if isinstance(drive, Car)
            else None
        )

    # What rules ask -----------------------------------------------------------------------

    @property
    def at(self) -> Configuration:
        """Position of the robot; during a motion, where that motion began."""
        return self.course.at

    @property
    def time_s(self) -> float:
        """Time of its clock in seconds."""
        return self.course.time_s

    @property
    def goal(self) -> Goal | None:
        """Its goal."""
        return self.course.goal

    @property
    def raster(self) -> Occupancy:
        """Its knowledge of every cell."""
        return self.map.raster

    def targets(self) -> FloatArray:
        """Return the places to go to, ``(m, 2)`` metres; see `Frontiers.targets`."""
        return self.frontiers.targets()

    def look_closer(self, reach: BoolArray) -> bool:
        """Look for other targets where one cannot be reached; see `Frontiers.look_closer`."""
        return self.frontiers.look_closer(reach, blocked=len(self.bodies) > 0)

    def is_frontier(self, x: float, y: float) -> bool:
        """Whether a frontier cell lies within half the body's width of a place."""
        return self.frontiers.is_frontier(x, y)

    def field(self, x: float, y: float) -> DistanceField | None:
        """Return the distances from a place; see `DistanceFields.field`."""
        return self.path_finder.field(x, y)

    def own_field(self) -> DistanceField | None:
        """Return the distances from where the robot stands; see `PathFinder.own_field`."""
        return self.path_finder.own_field()

    def around_bodies(self, sightings: Iterable[Sighting] = ()) -> AbstractContextManager[None]:
        """Block the cells that bodies keep the robot from; see `PathFinder.around_bodies`."""
        return self.path_finder.around_bodies(sightings)

    def indices_of(self, places: FloatArray) -> IntArray:
        """Return the indices of the cells of places, ``(k, 2)``; see `fields.indices_of`."""
        return indices_of(self.raster, places)

    def fitting_costs(self, field: DistanceField, places: FloatArray) -> FloatArray:
        """Return the lengths of the robot's paths to places that it may choose.

        Parameters
        ----------
        field : DistanceField
            Distances from where it stands.
        places : (m, 2) array
            Places in passable cells, in metres.

        Returns
        -------
        (m,) array
            Metres; ``inf`` where there is no path, no time to go there and home again, or no chain
            of relays (see `FrontierHoming.only_fitting`).
        """
        costs_m = field.distance(self.indices_of(places))
        if self.homing is None:
            return costs_m
        return self.homing.only_fitting(places, costs_m)

    def goal_at(self, field: DistanceField, x: float, y: float) -> Goal:
        """Return a place as a goal, with the path to it; see `PathFinder.goal_at`."""
        return self.path_finder.goal_at(field, x, y)

    def blocked_frontiers(self) -> bool:
        """Whether there are frontiers to which only bodies in the way bar all paths."""
        if not len(self.bodies):
            return False
        if self.frontiers.has_no_path_past_bodies():
            return True
        field = self.own_field()
        if field is None:
            return False
        self.look_closer(field.reachable())
        targets = self.targets()
        if self.homing is not None:
            return bool(np.isfinite(self.fitting_costs(field, targets)).any())
        return len(targets) > 0 and field.first(self.indices_of(targets)) is not None

    # The goal -----------------------------------------------------------------------------

    def set_goal(self, goal: Goal | None) -> None:
        """Take a goal, chosen by what is known now."""
        self.course.set_goal(goal, self.raster.revision)

    def may_choose_anew(self) -> bool:
        """Whether the map has changed since the goal was chosen, and that is long enough ago."""
        course, options = self.course, self.options
        return (
            options.replan == "news"
            and self.raster.revision != course.goal_revision
            and course.time_s >= course.goal_chosen_s + options.replan_period_s
        )

    def sees_at_half_range(self, goal: Goal) -> bool:
        """Whether a goal counts as reached from where the robot stands.

        That is so, by the option `reached`, if it is in sight within half the range, and was not
        already seen from afar without result.
        """
        if self.options.reached == "cell" or self.frontiers.was_seen_in_vain(goal.place):
            return False
        near = math.dist(self.at[:2], goal.place) <= 0.5 * self.me.range_m
        return near and inside(self.map.boundary, goal.x, goal.y)

    def is_called_home(self) -> bool:
        """Return whether the robot must end its drive to deliver data or to meet its partner."""
        return self.homing is not None and self.homing.must_interrupt()

    def driven_body(self) -> PlanningBody:
        """Return the body for which legs are planned.

        It is a disc, which can turn anywhere: in a gap that only the narrow side of the body fits
        through, the robot could not turn if something new were seen or heard. Where the disc has
        no room, perhaps at the start, it is the body itself.
        """
        if self.body.is_disc:
            return self.body
        x, y, _ = self.at
        has_room = disc_clearance(self.map.boundary, x, y) >= self.body.outer_radius_m
        return self._disc if has_room else self.body

    # Perceiving ---------------------------------------------------------------------------

    def begin(self) -> Steps:
        """Take the first scan, and ask what the others know."""
        yield from self.perceive()
        if not self.team.is_alone:
            yield from self.team.report(asks=True)
            yield from self.team.pause(self.team.round_trip_s)
        elif self.homing is not None:
            # Whether the base station is in touch.
            yield from self.team.pause(self.team.round_trip_s)

    def perceive(self, maps: bool = True) -> Steps:
        """Take a scan, add it to the map, and report what is new.

        Parameters
        ----------
        maps : bool
            Whether to add it to the map; if not, it only shows where the robot can drive.
        """
        scan = cast(Scan, (yield Sense()))
        self.course.time_s = scan.time_s
        if maps:
            yield from self._add(scan)
        else:
            self.map.view(scan)
            self._not_mapped = scan

    def perceive_on_the_way(self) -> Steps:
        """Take a scan; add it to the map if the last one that was added is old enough."""
        next_s = self._mapped_s + self.options.sense_period_s
        yield from self.perceive(maps=self.time_s >= next_s - ROUNDING_S)

    @property
    def is_walled_in(self) -> bool:
        """Whether frontiers are left that the robot gave up before it had ever left its start.

        Either it has given up their places, or no cell around it is passable.
        """
        if self.course.has_left:
            return False
        x, y, _ = self.at
        if self.raster.passable_near(x, y, NEAR_BY_CELLS) is None:
            return bool(self.frontiers.groups())
        return self.frontiers.has_given_up

    @property
    def has_scan_to_map(self) -> bool:
        """Whether the last scan is not on the map."""
        return self._not_mapped is not None

    def map_last_scan(self) -> Steps:
        """Add the last scan to the map, if that has not been done."""
        if self._not_mapped is not None:
            yield from self._add(self._not_mapped)

    def _add(self, scan: Scan) -> Steps:
        self._mapped_s, self._not_mapped = scan.time_s, None
        node = self.map.add(scan)
        if node is None:
            return
        yield Note(node.added("root" if node.parent is None else "scan"))
        if self.team.has_receivers:
            yield from self.team.report()
        if self._watch is not None:
            yield from self._watch(self)

    def tell_when_complete(self) -> Steps:
        """Record, once, that no frontier is left that the robot could reach.

        Frontier behind bodies counts as left: they may go.
        """
        if not self._told_complete:
            self._told_complete = True
            yield Note(MapComplete(time_s=self.time_s, robot=self.me.robot))
