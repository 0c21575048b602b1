"""Robots whose paths conflict: CHECK_FEASIBILITY and COORDINATE.

Source: Multi-SRT, paper section 2, "GER path feasibility check" and "Coordination". The master
is the robot of the highest number among those that make a step. A master that does not answer
is taken as lost; the group is built anew without it, and the next highest number is master.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Generator, Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from multisrt.events import Coordinated, Organized
from multisrt.geometry.configuration import Configuration
from multisrt.planners.motion.body import PlanningBody
from multisrt.planners.motion.kinematics import Car
from multisrt.planners.motion.steering import reach_fan, steer, turn_and_drive
from multisrt.planners.motion.sweep import Sweep
from multisrt.planners.motion.trajectory import Trajectory, Waypoint, standing_at
from multisrt.planners.srt import SrtPlanner
from multisrt.robots.exploration_map import NodeId
from multisrt.robots.explorer import Action, Note, Outcome, Send
from multisrt.robots.multi_srt.engagement import Regroup, is_elsewhere
from multisrt.robots.multi_srt.messages import OrdersMessage, RobotState
from multisrt.robots.multi_srt.organize import (
    Arrangement,
    Conflicts,
    Prospect,
    motion_of,
    organize,
)

if TYPE_CHECKING:
    from multisrt.robots.multi_srt.robot import SrtRobot, Step

ASIDE_DIRECTIONS = 24
"""Directions in which a robot looks for a place out of another's way."""

ASIDE_SHARES = (0.25, 0.5, 0.75, 1.0)
"""How far it looks in each, as shares of how far it gets."""


@dataclass(frozen=True, slots=True)
class Feasibility:
    """Which robots of a group can move at once (paper: G_f and G_u).

    Attributes
    ----------
    group : tuple of int
        All that were looked at.
    feasible, unfeasible : tuple of int
        Those whose ways conflict with nobody's, and the rest.
    conflicts : Conflicts
        Which conflict with which.
    """

    group: tuple[int, ...]
    feasible: tuple[int, ...]
    unfeasible: tuple[int, ...]
    conflicts: Conflicts


def check_feasibility(robot: SrtRobot, group: tuple[int, ...]) -> Feasibility:
    """CHECK_FEASIBILITY: find whose prospective ways conflict, the bodies that stay included."""
    team = robot.team
    prospects = {}
    for number in group:
        state = team.state_of(number)
        prospects[number] = Prospect(
            robot=number,
            footprint=team.footprint(number),
            motion=motion_of(state.path),
            frontier_m=state.frontier_m,
            waited=state.waited,
        )
    conflicts = Conflicts(prospects, robot.options.guard_m)
    unfeasible = tuple(sorted({number for pair in conflicts.pairs for number in pair}))
    feasible = tuple(number for number in group if number not in unfeasible)
    return Feasibility(group, feasible, unfeasible, conflicts)


def coordinate(
    robot: SrtRobot, checked: Feasibility, step: Step | None
) -> Generator[Action, Outcome, Step | None]:
    """COORDINATE: as the master, organise the group; else wait for the master's word.

    Returns
    -------
    Step or None
        What this robot does now; None: it waits.

    Raises
    ------
    Regroup
        If the master does not answer, or the group has changed meanwhile.
    """
    team = robot.team
    master = max(n for n in checked.group if n == team.number or team.states[n].phase != "idle")
    if team.key in team.orders:
        message = team.orders[team.key]
    elif master == team.number:
        message = yield from _organize(robot, checked)
    else:
        message = yield from _orders_of(robot, master)
    order = message.order_for(team.number)
    if order is None:
        raise AssertionError(f"robot {message.sender} left robot {team.number} out of its orders")
    after = robot.step_by(order, step)
    team.troubles += order.order != "keep"
    x, y, _ = robot.q_act
    yield Note(
        Coordinated(
            time_s=robot.time_s,
            robot=team.number,
            ger=checked.group,
            master=message.sender,
            feasible=message.feasible,
            unfeasible=message.unfeasible,
            target=(x, y) if step is None else _place(step.motion.end),
            order=order.order,
            new_target=(x, y) if after is None else _place(after.motion.end),
        )
    )
    return after


def _organize(robot: SrtRobot, checked: Feasibility) -> Generator[Action, Outcome, OrdersMessage]:
    team, conflicts = robot.team, checked.conflicts
    arrangement = organize(conflicts, MasterWits(robot))
    yield Note(_organized(robot, checked, arrangement))
    message = OrdersMessage(
        sender=team.number,
        key=team.key,
        orders=tuple(arrangement.orders.items()),
        feasible=checked.feasible,
        unfeasible=checked.unfeasible,
    )
    team.orders = {team.key: message}
    yield Send(message)
    return message


def _orders_of(robot: SrtRobot, master: int) -> Generator[Action, Outcome, OrdersMessage]:
    team = robot.team
    deadline = robot.time_s + team.period_s
    while team.key not in team.orders:
        if is_elsewhere(robot, master, "planned") and team.key_of(team.gpr()) != team.key:
            raise Regroup
        yield from team.hear(max(0.0, deadline - robot.time_s))
        if robot.time_s >= deadline and team.key not in team.orders:
            yield from team.ask([master])
            deadline = robot.time_s + team.period_s
    return team.orders[team.key]


def _organized(robot: SrtRobot, checked: Feasibility, arrangement: Arrangement) -> Organized:
    prospects = checked.conflicts.prospects
    return Organized(
        time_s=robot.time_s,
        robot=robot.team.number,
        feasible=checked.feasible,
        unfeasible=checked.unfeasible,
        before={number: prospect.target for number, prospect in prospects.items()},
        after=arrangement.targets,
        orders={number: order.order for number, order in arrangement.orders.items()},
        conflicts=checked.conflicts.pairs,
        deadlock=arrangement.is_deadlock,
    )


class MasterWits:
    """Finds other targets for the robots of a group from what its master knows of them.

    Parameters
    ----------
    robot : SrtRobot
        The master.
    """

    def __init__(self, robot: SrtRobot) -> None:
        self.robot = robot
        self._bodies: dict[int, PlanningBody] = {}

    def sweep(self, robot: int, motion: Trajectory) -> Sweep:
        """Give what a robot's body sweeps."""
        return Sweep(self._body(robot).footprint, motion)

    def new_targets(self, robot: int) -> Iterator[Trajectory]:
        """Draw other targets towards a robot's local frontier, up to `max_draws` (paper: I_max).

        A car is given none: only itself can tell how it would come back from there.
        """
        state, options, body = (
            self.robot.team.state_of(robot),
            self.robot.options,
            self._body(robot),
        )
        if state.node is None or isinstance(state.kinematics, Car):
            return
        region = self.robot.map[state.node].region
        frontier = self.robot.map.frontier(state.node)
        if not len(frontier):
            return
        at = Configuration(*state.place)
        d_min = options.d_min_m if options.d_min_m is not None else body.footprint.width_m
        planner = SrtPlanner(body, state.kinematics, options, d_min)
        others = self.robot.map.places_near(at.x, at.y, state.range_m + d_min)
        for _ in range(options.max_draws):
            place, _ = planner.draw(at, region, frontier, others, [], self.robot.me.rng)
            if place is None:
                return
            motion = self._straight(robot, *place)
            if motion is not None:
                yield motion

    def detours(
        self, robot: int, gap_m: float, prospects: Mapping[int, Prospect]
    ) -> Iterator[Trajectory]:
        """Find places in what a robot sees from which its target can be gone to straight.

        The ways are straight and pass those who stand there at a distance.
        """
        state, body = self.robot.team.state_of(robot), self._body(robot)
        if state.node is None or isinstance(state.kinematics, Car):
            return
        boundary, target = self.robot.map[state.node].region.boundary, prospects[robot].target
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

    def ways_aside(
        self, robot: int, way: Sweep, gap_m: float, prospects: Mapping[int, Prospect]
    ) -> Iterator[tuple[float, Trajectory, NodeId | None]]:
        """Find where a robot could leave another's way, the nearest place first.

        First straight in what it sees, then the nearest node of the roadmap that is out of the
        way, towards which it makes one hop.

        Yields
        ------
        length_m : float
            How far it is to there.
        motion : Trajectory
            The first step.
        node : NodeId or None
            The node at its end.
        """
        state = self.robot.team.state_of(robot)
        if state.node is None:
            return
        yield from self._places_aside(robot, state, way, gap_m)
        yield from self._nodes_aside(robot, state, way, gap_m, prospects)

    def _places_aside(
        self, robot: int, state: RobotState, way: Sweep, gap_m: float
    ) -> Iterator[tuple[float, Trajectory, NodeId | None]]:
        assert state.node is not None
        if isinstance(state.kinematics, Car):
            return
        body, heading = self._body(robot), state.place[2]
        for length, x, y in self._fan(robot, state, gap_m):
            place = Sweep(body.footprint, standing_at(Configuration(x, y, heading)))
            if place.distance_to(way) >= gap_m:
                motion = self._straight(robot, x, y)
                if motion is not None:
                    yield length, motion, None

    def _nodes_aside(
        self,
        robot: int,
        state: RobotState,
        way: Sweep,
        gap_m: float,
        prospects: Mapping[int, Prospect],
    ) -> Iterator[tuple[float, Trajectory, NodeId | None]]:
        assert state.node is not None
        known, footprint = self.robot.map, self._body(robot).footprint
        self.robot.ways.extend()
        others = [other for number, other in prospects.items() if number != robot]

        def is_aside(node: NodeId) -> bool:
            body = Sweep(footprint, standing_at(known[node].configuration))
            return body.distance_to(way) >= gap_m

        def is_passable(a: NodeId, b: NodeId) -> bool:
            sweep = Sweep(footprint, _line(known[a].configuration, known[b].configuration))
            return all(sweep.distance_to(other.body) >= gap_m for other in others)

        route = self.robot.ways.to_nearest(state.node, is_aside, is_passable)
        if route is None or len(route) < 2:
            return
        places = [known[node].configuration for node in route]
        length = math.fsum(a.distance(b) for a, b in itertools.pairwise(places))
        yield length, _line(Configuration(*state.place), places[1]), route[1]

    def _fan(self, robot: int, state: RobotState, gap_m: float) -> list[tuple[float, float, float]]:
        # Places that a robot gets to straight, the nearest first: how far they are, x and y.
        assert state.node is not None
        body, at = self._body(robot), Configuration(*state.place)
        boundary = self.robot.map[state.node].region.boundary
        directions = np.linspace(0.0, 2.0 * math.pi, ASIDE_DIRECTIONS, endpoint=False)
        limits = reach_fan(body, state.kinematics, boundary, at, directions, state.range_m)
        options = sorted(
            (share * limit, k)
            for k, limit in enumerate(limits.tolist())
            for share in ASIDE_SHARES
            if share * limit > 2.0 * gap_m
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
        state, body = self.robot.team.state_of(robot), self._body(robot)
        assert state.node is not None
        at = Configuration(*state.place)
        assert not isinstance(state.kinematics, Car)
        if body.is_disc:
            return turn_and_drive(state.kinematics, at, x, y)
        boundary = self.robot.map[state.node].region.boundary
        return steer(body, state.kinematics, boundary, at, x, y)

    def _body(self, robot: int) -> PlanningBody:
        if robot == self.robot.team.number:
            return self.robot.body
        if robot not in self._bodies:
            footprint = self.robot.team.footprint(robot)
            self._bodies[robot] = PlanningBody(footprint, self.robot.options.margin_m)
        return self._bodies[robot]


def _line(a: Configuration, b: Configuration) -> Trajectory:
    return Trajectory((Waypoint(0.0, *a), Waypoint(1.0, b.x, b.y, a.heading)))


def _place(configuration: Configuration) -> tuple[float, float]:
    return configuration.x, configuration.y
