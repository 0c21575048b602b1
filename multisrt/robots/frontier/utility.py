"""UTILITY: a leader assigns frontiers to the robots in contact that need one.

Source: Burgard, Moors, Stachniss and Schneider, Coordinated Multi-robot Exploration (2005), as
the SBX-R paper compares with it. The leader is the robot of the lowest number among those in
contact; a robot that hears nothing from its leader turns to the next. Differs in, where a robot
asks for a goal: the leader answers at once and goes on, others keep the goals that they have, and
these lower the utility of targets near them. Robots that need a goal at the same moment, as at the
start, get theirs together, by the rule.
"""

from __future__ import annotations

import math
import weakref
from collections.abc import Collection, Generator
from typing import Final, cast

import numpy as np

from multisrt.geometry.grids.occupancy import OCCUPIED
from multisrt.geometry.grids.sight import in_sight
from multisrt.geometry.numerics.arrays import BoolArray, FloatArray
from multisrt.planners.assignment.closest import closest
from multisrt.planners.assignment.utility import UtilityAssignment, overlap, utility
from multisrt.robots.explorer import Action, Outcome, Send, Steps
from multisrt.robots.frontier.messages import AssignmentMessage
from multisrt.robots.frontier.options import UtilityOptions
from multisrt.robots.frontier.robot import FrontierRobot
from multisrt.robots.frontier.wavefront_costs import Table, WavefrontCosts, own_costs
from multisrt.robots.frontier.wavefront_rules import Choice, settle_on

MAX_REQUESTS: Final = 3
"""Bounds the requests of a robot to a leader that does not answer."""


def choose_utility(robot: FrontierRobot, because: str) -> Choice:
    """Go where the leader says, or choose as the leader."""
    team = robot.team
    robot.set_goal(None)
    while True:
        leader = min(
            [
                robot.me.robot,
                *(r.robot for r in team.present() if not team.teammates.is_deaf(r.robot)),
            ]
        )
        if leader == robot.me.robot:
            return (yield from lead(robot, because))
        assignment = yield from ask(robot, leader)
        if assignment is not None:
            return (yield from follow_assignment(robot, assignment, because))
        team.teammates.note_deaf(leader, robot.time_s)


def ask(robot: FrontierRobot, leader: int) -> Generator[Action, Outcome, AssignmentMessage | None]:
    """Ask the leader for a goal; return None if it does not answer."""
    for _ in range(MAX_REQUESTS):
        robot.team.requests.assignment = None
        yield from robot.team.report(wants_goal=True, to=leader)
        assignment = yield from robot.team.await_assignment()
        if assignment is not None:
            return assignment
    return None


def lead(robot: FrontierRobot, because: str) -> Choice:
    """As the leader, choose this robot's goal, with those of all that need one now."""
    own, me = own_costs(robot), robot.me.robot
    costs = {me: own.costs[0], **_costs_of(robot, _robots_without_goal(robot), own.targets)}
    given = assign(robot, own.targets, costs)
    robots = tuple(sorted(costs))
    table = Table(
        targets=own.targets,
        robots=robots,
        costs=given.costs,
        field=own.field,
        row=robots.index(me),
    )
    target = int(given.assignment[table.row])
    rounds = tuple((robots[i], *rest) for i, *rest in given.rounds)
    choice = target if target >= 0 else None
    return (yield from settle_on(robot, table, choice, "utility", because, rounds=rounds))


def answer_requests(robot: FrontierRobot) -> None:
    """Let a robot answer, whatever it does meanwhile, those that take it for their leader."""
    known = weakref.ref(robot)  # The parts of a robot hold no reference to it.

    def answer(asker: int) -> Steps:
        leader = known()
        assert leader is not None
        made, now_s = leader.team.assignments, leader.time_s
        if not made.waits_for(asker, now_s):
            targets = leader.targets()
            needy = {asker, *_robots_without_goal(leader)}
            assign(leader, targets, _costs_of(leader, sorted(needy), targets))
        yield Send(made.send(asker, now_s), asker)

    robot.team.answer = answer


def _robots_without_goal(robot: FrontierRobot) -> list[int]:
    """Return the other robots that said at this very moment that they have no goal."""
    now_s = robot.time_s
    return [
        report.robot
        for report in robot.team.present()
        if report.time_s == now_s
        and robot.team.assignments.goal_of(report.robot, now_s, report) is None
    ]


def _costs_of(
    robot: FrontierRobot, others: list[int], targets: FloatArray
) -> dict[int, FloatArray]:
    """Return the costs of other robots to targets on this robot's map, ``(m,)`` metres each."""
    reports, indices = robot.team.teammates.reports, robot.indices_of(targets)
    costs = {}
    for number in others:
        field = robot.field(*reports[number].place[:2])
        costs[number] = np.full(len(targets), np.inf) if field is None else field.distance(indices)
    return costs


def assign(
    robot: FrontierRobot, targets: FloatArray, costs: dict[int, FloatArray]
) -> UtilityAssignment:
    """Assign targets to robots, and keep the goals of the others for when they ask.

    Parameters
    ----------
    robot : FrontierRobot
        The leader.
    targets : (m, 2) array
        The targets in metres.
    costs : dict of int to (m,) array
        For each robot that needs a goal, its costs in metres.

    Returns
    -------
    UtilityAssignment
        With a row for each of them, by number.
    """
    options, robots = cast(UtilityOptions, robot.options), sorted(costs)
    goals = _kept_goals(robot, set(robots))
    overlap_m = options.overlap_ranges * robot.me.range_m
    distances = euclidean_distances(goals, targets)
    lost = overlap(distances, in_view(robot, goals, targets), overlap_m)
    alone = len(robots) == 1
    given = utility(
        np.array([costs[number] for number in robots]),
        euclidean_distances(targets, targets),
        np.eye(len(targets), dtype=np.bool_) if alone else in_view(robot, targets, targets),
        overlap_m,
        options.beta,
        worth=1.0 - lost.sum(axis=0),
    )
    rounds = {robots[i]: rest for i, *rest in given.rounds}
    for number in robots:
        goal, worth, share = None, 0.0, 0.0
        if number in rounds:
            target, worth, share = rounds[number]
            x, y = targets[int(target)].tolist()
            goal = x, y
        robot.team.assignments.add(
            number,
            AssignmentMessage(sender=robot.me.robot, goal=goal, utility=worth, share=share),
            robot.time_s,
        )
    return given


def _kept_goals(robot: FrontierRobot, needy: Collection[int]) -> FloatArray:
    """Return the goals of the robots in contact but for those that need one, ``(k, 2)`` metres."""
    team, now_s = robot.team, robot.time_s
    goals = [] if robot.goal is None else [robot.goal.place]
    for report in team.present():
        goal = team.assignments.goal_of(report.robot, now_s, report)
        if report.robot not in needy and goal is not None:
            goals.append(goal)
    return np.array(goals).reshape(-1, 2)


def follow_assignment(robot: FrontierRobot, assignment: AssignmentMessage, because: str) -> Choice:
    """Go where the leader says, or to the nearest frontier if the own map has none there."""
    costs = WavefrontCosts(robot, alone=True)
    choice = _assigned_target(costs, assignment)
    if choice is None:
        # Where a frontier's target cannot be reached another cell of it may be.
        costs = WavefrontCosts(robot, alone=True, every=True)
        choice = _assigned_target(costs, assignment)
    rounds: tuple[tuple[int, int, float, float], ...] = ()
    if choice is None:
        choice = closest(costs, costs.row)
    else:
        rounds = ((robot.me.robot, choice, assignment.utility, assignment.share),)
    return (yield from settle_on(robot, costs.table(), choice, "utility", because, rounds=rounds))


def _assigned_target(costs: WavefrontCosts, assignment: AssignmentMessage) -> int | None:
    """Return the number of the target nearest to the assigned goal, None without one in reach."""
    if assignment.goal is None or not len(costs.targets):
        return None
    gaps = np.hypot(*(costs.targets - assignment.goal).T)
    nearest = int(np.argmin(gaps))
    is_near = gaps[nearest] <= costs.robot.me.range_m
    return nearest if is_near and math.isfinite(costs.own_cost(nearest)) else None


def euclidean_distances(places: FloatArray, targets: FloatArray) -> FloatArray:
    """Return the Euclidean distances from places to targets, ``(k, m)`` metres."""
    distances: FloatArray = np.hypot(*(places[:, None] - targets[None]).transpose(2, 0, 1))
    return distances


def in_view(robot: FrontierRobot, places: FloatArray, targets: FloatArray) -> BoolArray:
    """Return which places and targets see each other, ``(k, m)``; unknown cells hide nothing."""
    seen = np.ones((len(places), len(targets)), np.bool_)
    mapped = [i for i, place in enumerate(places.tolist()) if robot.raster.is_known(*place)]
    if not mapped or not len(targets):
        return seen
    sources, indices = robot.indices_of(places[mapped]), robot.indices_of(targets)
    cells = np.vstack([sources, indices])
    low, high = cells.min(axis=0), cells.max(axis=0) + 1
    open_cells = robot.raster.cells[low[0] : high[0], low[1] : high[1]] != OCCUPIED
    for i, (row, column) in zip(mapped, (sources - low).tolist(), strict=True):
        for j, (to_row, to_column) in enumerate((indices - low).tolist()):
            seen[i, j] = in_sight(open_cells, column + 0.5, row + 0.5, to_column, to_row)
    return seen
