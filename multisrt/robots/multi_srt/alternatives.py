"""Other motions for the robots of a group, from what their master knows of them."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping

import numpy as np

from multisrt.geometry.configuration import Configuration
from multisrt.geometry.numerics.rings import Rings
from multisrt.planners.motion.body import PlanningBody
from multisrt.planners.motion.kinematics import Car
from multisrt.planners.motion.steering import reach_fan, steer, turn_and_drive
from multisrt.planners.motion.sweep import Sweep
from multisrt.planners.motion.trajectory import Trajectory, Waypoint, standing_at
from multisrt.planners.srt import SrtPlanner
from multisrt.robots.knowledge import Node, NodeId
from multisrt.robots.multi_srt.conflicts import Prospect
from multisrt.robots.multi_srt.messages import RobotState
from multisrt.robots.multi_srt.robot import SrtRobot

ASIDE_DIRECTIONS = 24
"""Number of directions in which a place out of another's path is looked for."""

ASIDE_SHARES = (0.25, 0.5, 0.75, 1.0)
"""Distances of such places, as shares of how far the robot gets in a direction."""

MIN_ASIDE_GAPS = 2.0
"""Such places are farther off than this many of the gaps to be kept: less hardly clears a path."""


class KnownAlternatives:
    """Finds other targets, detours and places aside for the robots of a group.

    A car moves aside to nodes only: from elsewhere, only the car itself can compute how it would
    come back. The path to a node is checked as a straight line in constant heading,
    whatever the motion is that the robot then makes; the protective stop guards the difference.

    Parameters
    ----------
    robot : SrtRobot
        The master.
    """

    def __init__(self, robot: SrtRobot) -> None:
        self._robot = robot
        self._map = robot.map
        self._team = robot.team
        self._bodies = {robot.team.number: robot.planner.body}

    def sweep(self, robot: int, motion: Trajectory) -> Sweep:
        """Return what a robot's body sweeps on a motion."""
        return Sweep(self._body(robot).footprint, motion)

    def new_targets(self, robot: int) -> Iterator[Trajectory]:
        """Draw other targets towards a robot's local frontier, at most `max_new_targets`."""
        state, options, body = self._team.state_of(robot), self._robot.options, self._body(robot)
        if state.node is None or isinstance(state.kinematics, Car):
            return
        region = self._map[state.node].region
        frontier = self._map.frontier(state.node)
        if not len(frontier):
            return
        at = Configuration(*state.place)
        d_min_m = options.distance_from_nodes_m(body.footprint.width_m)
        planner = SrtPlanner(body, state.kinematics, options, d_min_m)
        reach_m = max(state.range_m, region.range_m)
        others = self._map.places_near(at.x, at.y, reach_m + d_min_m)
        for _ in range(options.max_new_targets):
            place, _ = planner.draw(at, region, frontier, others, [], self._robot.me.rng)
            if place is None:
                return
            motion = self._straight(robot, *place)
            if motion is not None:
                yield motion

    def detours(
        self, robot: int, gap_m: float, prospects: Mapping[int, Prospect]
    ) -> Iterator[Trajectory]:
        """Find places in a robot's region from which its target is reached straight.

        From there the path passes the bodies where they stand at a distance of `gap_m`.
        """
        state, body = self._team.state_of(robot), self._body(robot)
        if state.node is None or isinstance(state.kinematics, Car):
            return
        boundary, target = self._map[state.node].region.boundary, prospects[robot].target
        bodies = [other.body for number, other in prospects.items() if number != robot]
        options = []
        for _, x, y in self._fan(robot, state, gap_m):
            onwards = math.dist((x, y), target)
            if body.disc_reach(boundary, x, y, *target) >= onwards:
                options.append((math.dist(state.place[:2], (x, y)) + onwards, x, y))
        for _, x, y in sorted(options):
            at = Configuration(x, y, 0.0)
            rest = Sweep(body.footprint, _line(at, Configuration(*target, 0.0)))
            if all(rest.distance_to(other) >= gap_m for other in bodies):
                motion = self._straight(robot, x, y)
                if motion is not None:
                    yield motion

    def motions_aside(
        self, robot: int, swept: Sweep, gap_m: float, prospects: Mapping[int, Prospect]
    ) -> Iterator[tuple[float, Trajectory, NodeId | None]]:
        """Find where a robot could move out of another's path, the nearest place first.

        First straight in its region, then the nearest node of the roadmap that is out of the
        path, towards which it makes one hop.

        Yields
        ------
        length_m : float
            Length of the path to there.
        motion : Trajectory
            The first step.
        node : NodeId or None
            The node at its end.
        """
        state = self._team.state_of(robot)
        if state.node is None:
            return
        yield from self._places_aside(robot, state, swept, gap_m)
        yield from self._nodes_aside(robot, state, swept, gap_m, prospects)

    def _places_aside(
        self, robot: int, state: RobotState, swept: Sweep, gap_m: float
    ) -> Iterator[tuple[float, Trajectory, NodeId | None]]:
        if isinstance(state.kinematics, Car):
            return
        body, heading = self._body(robot), state.place[2]
        for length, x, y in self._fan(robot, state, gap_m):
            place = Sweep(body.footprint, standing_at(Configuration(x, y, heading)))
            if place.distance_to(swept) >= gap_m:
                motion = self._straight(robot, x, y)
                if motion is not None:
                    yield length, motion, None

    def _nodes_aside(
        self,
        robot: int,
        state: RobotState,
        swept: Sweep,
        gap_m: float,
        prospects: Mapping[int, Prospect],
    ) -> Iterator[tuple[float, Trajectory, NodeId | None]]:
        assert state.node is not None
        known, roadmap, footprint = self._map, self._robot.roadmap, self._body(robot).footprint
        roadmap.extend()
        others = [other for number, other in prospects.items() if number != robot]

        def is_aside(node: NodeId) -> bool:
            body = Sweep(footprint, standing_at(known[node].configuration))
            return body.distance_to(swept) >= gap_m

        def is_passable(a: NodeId, b: NodeId) -> bool:
            if not self._fits(robot, known[a], known[b]):
                return False
            sweep = Sweep(footprint, _line(known[a].configuration, known[b].configuration))
            return all(sweep.distance_to(other.body) >= gap_m for other in others)

        route = roadmap.to_nearest(state.node, is_aside, is_passable)
        if route is None or len(route) < 2:
            return
        places = [known[node].configuration for node in route]
        length = math.fsum(a.distance(b) for a, b in itertools.pairwise(places))
        yield length, _line(Configuration(*state.place), places[1]), route[1]

    def _fits(self, robot: int, a: Node, b: Node) -> bool:
        # Whether a robot gets along an edge of the master's roadmap: its body may be larger.
        body, own = self._body(robot), self._robot.planner.body
        is_car = isinstance(self._team.state_of(robot).kinematics, Car)
        child, parent = (a, b) if a.parent == b.id else (b, a)
        has_driven_it = child.parent == parent.id and child.id.robot == robot
        if body.footprint == own.footprint or is_car or has_driven_it:
            return True
        ends = np.array([a.configuration[:2], b.configuration[:2]])
        rings = Rings([a.region.boundary, b.region.boundary])
        return bool(body.bridges(ends, rings, np.array([[0, 1]]))[0])

    def _fan(self, robot: int, state: RobotState, gap_m: float) -> list[tuple[float, float, float]]:
        # Places that a robot reaches straight, the nearest first: their distance, x and y.
        assert state.node is not None
        body, at = self._body(robot), Configuration(*state.place)
        boundary = self._map[state.node].region.boundary
        directions = np.linspace(0.0, 2.0 * math.pi, ASIDE_DIRECTIONS, endpoint=False)
        limits = reach_fan(body, state.kinematics, boundary, at, directions, state.range_m)
        options = sorted(
            (share * limit, k)
            for k, limit in enumerate(limits.tolist())
            for share in ASIDE_SHARES
            if share * limit > MIN_ASIDE_GAPS * gap_m
        )
        return [
            (
                length,
                at.x + length * math.cos(directions[k]),
                at.y + length * math.sin(directions[k]),
            )
            for length, k in options
        ]

    def _straight(self, robot: int, x: float, y: float) -> Trajectory | None:
        state, body = self._team.state_of(robot), self._body(robot)
        assert state.node is not None
        at = Configuration(*state.place)
        assert not isinstance(state.kinematics, Car)
        if body.is_disc:
            return turn_and_drive(state.kinematics, at, x, y)
        boundary = self._map[state.node].region.boundary
        return steer(body, state.kinematics, boundary, at, x, y)

    def _body(self, robot: int) -> PlanningBody:
        if robot not in self._bodies:
            footprint = self._team.footprint(robot)
            self._bodies[robot] = PlanningBody(footprint, self._robot.options.margin_m)
        return self._bodies[robot]


def _line(a: Configuration, b: Configuration) -> Trajectory:
    return Trajectory((Waypoint(0.0, *a), Waypoint(1.0, b.x, b.y, a.heading)))
