"""Motions of robots: begun, ended on arrival or by a protective stop, checked for collisions."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

from multisrt.events import Blocked, Collision, Motion
from multisrt.geometry.bodies.collision import Body, CollisionWorld
from multisrt.geometry.configuration import Configuration
from multisrt.planners.motion.trajectory import Trajectory, Waypoint
from multisrt.robots.defects import refuse
from multisrt.robots.explorer import Move, Moved
from multisrt.simulation.clock import ROUNDING_S, Clock
from multisrt.simulation.encounters import Encounter
from multisrt.simulation.journal import Journal
from multisrt.simulation.robot import CurrentMotion, Robot
from multisrt.simulation.sensing import Sensing
from multisrt.simulation.traffic import Traffic

SAME_PLACE = 1e-5
"""Distance in metres, and angle in radians, by which a body may move in no time, for rounding."""

START_TOLERANCE = 1e-9
"""A trajectory starts within this of where the robot is, in metres and in radians."""


class Motions:
    """Begins and ends the motions of all robots.

    Parameters
    ----------
    robots : sequence of Robot
        The team.
    world : CollisionWorld
        The obstacles.
    traffic : Traffic
        Where all bodies are, and how their motions meet.
    sensing : Sensing
        What robots see of one another.
    clock, journal
        Those of the run.
    max_time_s : float
        When the run ends at the latest; no motion is checked or recorded beyond.

    Attributes
    ----------
    collision : Collision or None
        The collision that ends the run.
    """

    def __init__(
        self,
        robots: Sequence[Robot],
        world: CollisionWorld,
        traffic: Traffic,
        sensing: Sensing,
        *,
        clock: Clock,
        journal: Journal,
        max_time_s: float,
    ) -> None:
        self._robots = robots
        self._world = world
        self._traffic = traffic
        self._sensing = sensing
        self._clock = clock
        self._journal = journal
        self._max_time_s = max_time_s
        self.collision: Collision | None = None

    def begin(self, robot: Robot, move: Move) -> bool:
        """Begin a motion of a robot that stands; one that touches an obstacle is a collision.

        Returns
        -------
        bool
            Whether it has begun.

        Raises
        ------
        ExplorerDefect
            If the trajectory does not start where the robot is, or leads on in no time.
        """
        now_s, number, trajectory = self._clock.now_s, robot.number, move.trajectory
        _require_start(trajectory, self._traffic.where(number, now_s), number)
        _require_time(trajectory, number)
        left_s = self._max_time_s - now_s
        driven = trajectory if trajectory.duration_s <= left_s else trajectory.until(left_s)
        touching = self._touching_leg(robot.body, driven)
        if touching is not None:
            self._collide_with_obstacle(robot, *touching)
            return False
        robot.motion = CurrentMotion(
            move=move, set_out_s=now_s, arrival_s=now_s + trajectory.duration_s
        )
        self._traffic.begin(number, now_s, trajectory, move.guard_m)
        self._clock.later(trajectory.duration_s, robot.poke)
        self._foresee_encounter(robot)
        self._foresee_others(robot)
        return True

    def is_stopped(self, robot: Robot) -> bool:
        """Whether a robot that moves is stopped now by its protective stop."""
        met = None if robot.motion is None else robot.motion.encounter
        return met is not None and met.kind == "guard" and self._is_now(met)

    def ended(self, robot: Robot) -> Moved | None:
        """End a robot's motion if it has arrived or is stopped now.

        Returns
        -------
        Moved or None
            How the motion ended; None if the robot stands, moves on, or has touched another
            body, which is a collision.
        """
        if robot.motion is None:
            return None
        now_s, met = self._clock.now_s, robot.motion.encounter
        if met is not None and self._is_now(met):
            if met.kind == "contact":
                self._collide_with_robot(robot, met)
                return None
            moved = self.end(robot, now_s)
            self._journal.record(
                Blocked(
                    time_s=now_s,
                    robot=robot.number,
                    by=met.other,
                    configuration=(*moved.configuration,),
                )
            )
            return Moved(
                configuration=moved.configuration,
                time_s=now_s,
                blocked_by=self._sensing.sighting(met.other, now_s),
            )
        if now_s >= robot.motion.arrival_s - ROUNDING_S:
            return self.end(robot, robot.motion.arrival_s)
        return None

    def end(self, robot: Robot, time_s: float) -> Moved:
        """End a robot's motion where it is at a time, and record what was driven."""
        assert robot.motion is not None
        motion, robot.motion = robot.motion, None
        arrived = time_s >= motion.arrival_s - ROUNDING_S
        self._traffic.end(robot.number, max(time_s, motion.arrival_s) if arrived else time_s)
        driven = motion.driven(time_s)
        self._journal.record(self._event(robot, motion, driven))
        self._foresee_others(robot)
        return Moved(configuration=driven.end, time_s=self._clock.now_s)

    def under_way(self, time_s: float) -> list[Motion]:
        """Return the motions that have begun before a time, as if they ended then."""
        return [
            self._event(robot, robot.motion, robot.motion.driven(time_s))
            for robot in self._robots
            if robot.motion is not None and robot.motion.set_out_s < time_s
        ]

    def _event(self, robot: Robot, motion: CurrentMotion, driven: Trajectory) -> Motion:
        waypoints = tuple(
            (min(motion.set_out_s + w.time_s, self._max_time_s), w.x, w.y, w.heading)
            for w in driven.waypoints
        )
        return Motion(
            time_s=motion.set_out_s,
            robot=robot.number,
            waypoints=waypoints,
            purpose=motion.move.purpose,
        )

    def end_all(self, time_s: float) -> None:
        """End all motions where the robots are at a time."""
        for robot in self._robots:
            if robot.motion is not None:
                self.end(robot, time_s)

    def where(self, robot: Robot) -> Configuration:
        """Return where a robot is now."""
        return self._traffic.where(robot.number, self._clock.now_s)

    # Encounters with other robots --------------------------------------------------------

    def _is_now(self, met: Encounter) -> bool:
        return met.time_s <= self._clock.now_s + ROUNDING_S

    def _foresee_encounter(self, robot: Robot) -> None:
        assert robot.motion is not None
        now_s = self._clock.now_s
        robot.motion.encounter = met = self._traffic.next_event(robot.number, now_s)
        if met is not None:
            self._clock.later(max(0.0, met.time_s - now_s), robot.poke)

    def _foresee_others(self, robot: Robot) -> None:
        for other in self._traffic.affected(robot.number):
            self._foresee_encounter(self._robots[other])

    def _collide_with_robot(self, robot: Robot, met: Encounter) -> None:
        now_s = self._clock.now_s
        here = self._traffic.where(robot.number, now_s)
        there = self._traffic.where(met.other, now_s)
        self.collision = Collision(
            time_s=now_s,
            robot=robot.number,
            configuration=(*here,),
            account=f"touched robot {met.other} at ({there.x:.3f}, {there.y:.3f}) on its way "
            f"from ({here.x:.3f}, {here.y:.3f})",
        )
        self.end_all(now_s)
        self._journal.note_time(now_s)
        self._journal.record(self.collision)

    # Obstacles ---------------------------------------------------------------------------

    def _collide_with_obstacle(self, robot: Robot, a: Waypoint, b: Waypoint) -> None:
        self.collision = Collision(
            time_s=self._clock.now_s + a.time_s,
            robot=robot.number,
            configuration=(a.x, a.y, a.heading),
            account=f"touched an obstacle on its way from ({a.x:.3f}, {a.y:.3f}) "
            f"to ({b.x:.3f}, {b.y:.3f})",
        )
        self._journal.note_time(self.collision.time_s)
        self._journal.record(self.collision)

    def _touching_leg(self, body: Body, trajectory: Trajectory) -> tuple[Waypoint, Waypoint] | None:
        # The first leg on which the body touches an obstacle.
        legs = list(pairwise(trajectory.waypoints))
        # A disc that turns in place is covered by the legs before and after.
        turns = body.footprint.is_disc
        moves = [(a, b) for a, b in legs if not (turns and (a.x, a.y) == (b.x, b.y))] or legs
        if all(self._leg_is_free(body, a, b) for a, b in moves):
            return None
        return next(leg for leg in legs if not self._leg_is_free(body, *leg))

    def _leg_is_free(self, body: Body, a: Waypoint, b: Waypoint) -> bool:
        start, end = Configuration(*a[1:]), Configuration(*b[1:])
        if a.heading == b.heading:
            return self._world.straight_motion_is_free(body, start, end)
        if (a.x, a.y) == (b.x, b.y):
            return self._world.rotation_is_free(body, start, b.heading - a.heading)
        turn = b.heading - a.heading
        return self._world.first_contact(body, start, end, turn, arc=True) is None


def begins_at(trajectory: Trajectory, configuration: Configuration) -> bool:
    """Whether a trajectory begins where a robot is, but for `START_TOLERANCE`."""
    start = trajectory.start
    turn = abs(math.remainder(start.heading - configuration.heading, 2.0 * math.pi))
    return start.distance(configuration) <= START_TOLERANCE and turn <= START_TOLERANCE


def _require_start(trajectory: Trajectory, configuration: Configuration, number: int) -> None:
    if not begins_at(trajectory, configuration):
        refuse(
            number,
            f"it yielded a trajectory from {trajectory.start}, but the robot is at {configuration}",
            "begin every trajectory where the last motion ended",
        )


def _require_time(trajectory: Trajectory, number: int) -> None:
    # A robot is at one place at one moment.
    for a, b in pairwise(trajectory.waypoints):
        moved = max(math.hypot(b.x - a.x, b.y - a.y), abs(b.heading - a.heading))
        if b.time_s - a.time_s <= ROUNDING_S and moved > SAME_PLACE:
            refuse(
                number,
                f"its trajectory leads from ({a.x:g}, {a.y:g}) to ({b.x:g}, {b.y:g}) in no time",
                "give every waypoint the time at which the body can be there",
            )
