"""RULES: robots score unexplored cells, give way to each other, and swap goals.

Source: J. A. Álvarez Jáuregui, Algoritmo descentralizado para la exploración multi-robot de
escenarios 2D (Universidad de Guanajuato, 2018), section 3.2. A goal is a cell that no robot has
seen, here called the robot's *aim*; its `Goal` is the place where the path to the aim leaves the
known area, and the path to that place is the shortest one, not one from cell to cell. Differs in:

- Where no unexplored cell can be reached and frontiers are left, which are smaller than a cell of
  the search, the nearest frontier is the goal. So runs are complete as with all strategies.
- A robot waits only for others in sight, and at most as often as it asks others to give way
  (`patience`); then the protective stop and `giving_way` decide.
- Goals are compared whenever one is new, not all the time, and by default swapped only if the sum
  of the two paths does not grow by more than the width of a cell (`exchange_when`). As a swap
  shortens the shorter of the two paths in either case, robots do not swap forever.
- A cell counts as inaccessible once every robot that is present (`Teammates.present`) has found
  it so, not every robot of the team. Robots also report the places at the edge of the known area
  that they reached without result.
- A robot that was stuck goes to a random place (proposed in the thesis as future work).
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Generator

import numpy as np

from multisrt.events import GoalChosen
from multisrt.geometry.configuration import Configuration
from multisrt.geometry.grids.distance_field import DistanceField
from multisrt.geometry.numerics.distances import length_of
from multisrt.geometry.numerics.kernel import FloatArray
from multisrt.planners.assignment.cell_choice import GoalChoice
from multisrt.planners.assignment.exchange import exchange
from multisrt.planners.navigation.path_following import ahead
from multisrt.planners.navigation.right_of_way import Party, right_of_way
from multisrt.robots.explorer import Action, Note, Outcome, RobotSelf, Send, Sighting
from multisrt.robots.frontier.alvarez_goals import (
    PathToCell,
    Survey,
    is_open,
    path_cost,
    path_to,
    robot_options,
    search,
    take_survey,
)
from multisrt.robots.frontier.driving import REACHED_M, Driven, drive, drive_leg
from multisrt.robots.frontier.explore import FrontierExplorer
from multisrt.robots.frontier.goal import Goal, Place
from multisrt.robots.frontier.messages import InaccessibleMessage, SwapMessage
from multisrt.robots.frontier.options import RulesOptions
from multisrt.robots.frontier.progress import Event
from multisrt.robots.frontier.robot import FrontierRobot
from multisrt.robots.frontier.wavefront_rules import Choice, choose_closest

SCORES_KEPT = 10
"""Number of the best cells that are recorded with a choice."""

MAX_LATE = 20
"""Bounds the cells, and the random places, that turn out not to be allowed as there is no time."""

REPLANNING_EVENTS = (Event.START, Event.NEWS, Event.CALLED_ON, Event.BLOCKED)
"""Events after which a robot chooses another cell even if its own is still unexplored."""

Scores = tuple[tuple[float, float, float, float, float, float], ...]
"""x, y, score, and the terms of the score (distance, turn, others) of the best cells."""


def rules_explorer(me: RobotSelf, options: RulesOptions) -> FrontierExplorer:
    """Return the explorer of one robot."""
    rules = Rules()
    return FrontierExplorer(me, options, rules.choose, rules.drive)


class Rules:
    """The decisions of one robot by the rules, and what it remembers for them.

    Attributes
    ----------
    place : (x, y) or None
        Its last goal.
    failures : counter of (x, y)
        How often no path led to each goal.
    stuck_at : (x, y) or None
        Where it stood when no path led to its goal.
    in_vain : int
        Number of goals in a row that it could not drive to.
    wanders : bool
        Whether its goal is a random place.
    waited : int
        How often in a row it has waited for others.
    compared : tuple
        The aims of the team when it last looked for a swap.
    """

    def __init__(self) -> None:
        self.place: Place | None = None
        self.failures: Counter[Place] = Counter()
        self.stuck_at: Place | None = None
        self.in_vain = 0
        self.wanders = False
        self.waited = 0
        self.compared: tuple[object, ...] = ()

    # Choosing -----------------------------------------------------------------------------

    def choose(self, robot: FrontierRobot, because: Event) -> Choice:
        """Keep the aim until it is explored, then choose the best cell; return a goal for it."""
        tried = self.remember(robot, because)
        team = robot.team
        with robot.around_bodies():
            survey = take_survey(robot, team.cells.tried, agreed(robot))
            aim = None if because in REPLANNING_EVENTS else team.cells.aim
            path = None if aim is None else path_in_time(robot, survey, aim)
            unreached: list[Place] = []
            scores: Scores = ()
            if path is None:
                aim, scores, unreached = best_cell(robot, survey)
                path = None if aim is None else path_to(robot, survey, aim)
            goal = None if path is None else goal_of(robot, path)
        team.cells.aim = None if goal is None else aim
        yield from tell_inaccessible(robot, [] if len(robot.bodies) else unreached, tried)
        if self.in_vain >= robot_options(robot).random_goal_after and goal is not None:
            wandered = yield from self.wander(robot, because)
            if wandered is not None:
                return wandered
            team.cells.aim = aim
        if goal is None or path is None:
            goal = yield from choose_closest(robot, because)
            self.place = None if goal is None else goal.place
            return goal
        self.place = goal.place
        yield Note(chosen(robot, "rules", because, aim, path.cost_m, scores))
        return goal

    def remember(self, robot: FrontierRobot, because: Event) -> tuple[Place, ...]:
        """Record what became of the last goal; return its place if others need not try it."""
        place, self.place = self.place, None
        # A random place in vain does not count, so that the next goal is one by the rules.
        in_vain = because in (Event.NO_WAY, Event.BLOCKED) and not self.wanders
        self.in_vain, self.wanders = self.in_vain + 1 if in_vain else 0, False
        if place is None:
            return ()
        is_left = robot.is_frontier(*place) or is_open(robot.raster, place)
        gives_up = because == Event.REACHED and is_left
        if because == Event.NO_WAY:
            self.failures[place] += 1
            gives_up = (
                self.failures[place] >= robot_options(robot).max_failures
                or self.stuck_at == robot.at[:2]
            )
            self.stuck_at = robot.at[:2]
        if not gives_up:
            return ()
        robot.team.cells.tried[place] = None
        robot.frontiers.give_up(place)
        # Other robots may find a path, as they come from elsewhere.
        return () if because == Event.NO_WAY else (place,)

    def wander(self, robot: FrontierRobot, because: Event) -> Choice:
        """RANDOM GOAL: choose a random place that is known, to continue from there.

        None if of `MAX_LATE` places there is none that the robot may choose
        (`FrontierRobot.fitting_costs`).
        """
        robot.team.cells.aim = None
        self.in_vain, goal = 0, None
        with robot.around_bodies():
            field = robot.own_field()
            if field is not None:
                goal = random_goal(robot, field)
        self.wanders = goal is not None
        if goal is not None:
            yield Note(chosen(robot, "random", because, goal.place, goal.cost_m, ()))
        return goal

    # Driving ------------------------------------------------------------------------------

    def drive(self, robot: FrontierRobot, goal: Goal) -> Driven:
        """MOTION: drive, leg by leg, until the aim is explored or the path to it changes."""
        aim = robot.team.cells.aim
        if aim is None and not self.wanders:
            return (yield from drive(robot, goal))
        path = goal.path
        while True:
            reason = self.reason_to_end(robot, goal, aim)
            if reason is not None:
                return reason
            path = ahead(path, robot.at)
            if not robot.team.is_alone:
                if (yield from self.waits_for_others(robot, path)):
                    continue
                if (yield from self.swaps(robot)):
                    return Event.INTERRUPTED
            ended = yield from drive_leg(robot, path, "explore")
            if ended is not None:
                return ended

    def reason_to_end(self, robot: FrontierRobot, goal: Goal, aim: Place | None) -> Event | None:
        """Return the reason not to drive on; None if there is none."""
        team, raster = robot.team, robot.raster
        if team.requests.any_pending or team.cells.aim != aim:
            return Event.INTERRUPTED
        if robot.is_called_home():
            return Event.ERRAND
        if aim is not None and (raster.is_known(*aim) or not is_open(raster, goal.place)):
            return Event.NOTHING_LEFT
        if math.dist(robot.at[:2], goal.place) <= REACHED_M:
            return Event.REACHED
        return Event.NEWS if aim is not None and robot.may_choose_anew() else None

    def waits_for_others(
        self, robot: FrontierRobot, path: FloatArray
    ) -> Generator[Action, Outcome, bool]:
        """CONFLICTS: wait if a robot is ahead, unless this one leads; return whether it waited."""
        team, options = robot.team, robot_options(robot)
        if options.conflict_radius_m == 0.0:
            return False
        seen = yield from robot.bodies.look()
        me = Party(
            robot=robot.me.robot,
            configuration=facing(robot.at, path),
            path=path,
            radius_m=robot.body.outer_radius_m,
            leader=team.cells.leader,
        )
        ruling = right_of_way(
            me,
            [as_party(robot, sighting) for sighting in seen],
            options.conflict_radius_m,
            margin_m=options.guard_m,
        )
        if ruling.leader != team.cells.leader:
            team.cells.leader = ruling.leader
            yield from team.report()
        if not ruling.waits_for:
            self.waited = 0
            return False
        self.waited += 1
        if self.waited > options.patience:
            return False
        yield from team.pause(team.period_s)
        return True

    def swaps(self, robot: FrontierRobot) -> Generator[Action, Outcome, bool]:
        """EXCHANGE: swap aims with another robot if that is shorter; return whether it did."""
        team = robot.team
        teammates = [report for report in team.present() if report.aim is not None]
        now = (team.cells.aim, *((teammate.robot, teammate.aim) for teammate in teammates))
        if team.cells.aim is None or not robot_options(robot).exchange or now == self.compared:
            return False
        self.compared = now
        with robot.around_bodies():
            survey = take_survey(robot, team.cells.tried, agreed(robot))
            here = robot.at[:2]
            own = path_cost(robot, survey, here, team.cells.aim)
            owners, asked = [own], [math.inf]
            for teammate in teammates:
                assert teammate.aim is not None
                to_it = theirs = math.inf
                if math.dist(here, teammate.aim) < own:
                    to_it = path_cost(robot, survey, here, teammate.aim)
                if to_it < own:
                    theirs = path_cost(robot, survey, teammate.place[:2], teammate.aim)
                asked.append(to_it)
                owners.append(theirs)
            partner = exchange(0, asked, owners)
            if partner is None:
                return False
            teammate = teammates[partner - 1]
            most = own + owners[partner] + robot.options.cell_m
            if robot_options(robot).exchange_when == "shorter" and most < asked[
                partner
            ] + path_cost(robot, survey, teammate.place[:2], team.cells.aim):
                return False
        if teammate.aim is None:
            return False
        given, team.cells.aim = team.cells.aim, teammate.aim
        yield Send(
            SwapMessage(sender=robot.me.robot, taken=teammate.aim, given=given), teammate.robot
        )
        return True


def random_goal(robot: FrontierRobot, field: DistanceField) -> Goal | None:
    """Return a random place that is known and that the robot may choose as a goal."""
    places = robot.raster.passable_centres(*robot.at[:2], robot.raster.diagonal_m)
    places = places[np.isfinite(field.distance(robot.indices_of(places)))]
    for _ in range(min(MAX_LATE, len(places))):
        k = int(robot.me.rng.integers(len(places)))
        if np.isfinite(robot.fitting_costs(field, places[k : k + 1])[0]):
            x, y = places[k].tolist()
            return robot.goal_at(field, x, y)
        places = np.delete(places, k, axis=0)
    return None


def best_cell(robot: FrontierRobot, survey: Survey) -> tuple[Place | None, Scores, list[Place]]:
    """Return the best cell that can be reached, the scores, and the better cells that cannot be.

    Cells that the robot has no time for are passed over (see `FrontierHoming.in_time`); after
    `MAX_LATE` of them there is none, and the robot goes to the closest frontier instead.
    """
    goals = [r.goal if r.aim is None else r.aim for r in robot.team.present()]
    places = np.array([goal for goal in goals if goal is not None]).reshape(-1, 2)
    unreached: dict[Place, None] = {}
    late = 0
    for everywhere in (False, True):
        cells, given = search(robot, survey, places, everywhere)
        for i in given.order.tolist():
            x, y = cells[i].tolist()
            if not survey.can_reach(robot.raster, (x, y)):
                unreached[x, y] = None
            elif robot.homing is None or path_in_time(robot, survey, (x, y)) is not None:
                return (x, y), best_scores(cells, given), list(unreached)
            else:
                late += 1
                if late == MAX_LATE:
                    return None, (), list(unreached)
    return None, (), list(unreached)


def best_scores(cells: FloatArray, given: GoalChoice) -> Scores:
    """Return the best cells with their scores and the terms of these."""
    best = given.order[:SCORES_KEPT]
    terms = (given.scores, given.distance, given.turn, given.others)
    return tuple(zip(*cells[best].T.tolist(), *(t[best].tolist() for t in terms), strict=True))


def path_in_time(robot: FrontierRobot, survey: Survey, aim: Place) -> PathToCell | None:
    """Return the path to an unexplored cell; None also if the robot has no time for it."""
    path = path_to(robot, survey, aim)
    if path is None or robot.homing is None:
        return path
    field = robot.own_field()
    if field is None or not np.isfinite(robot.fitting_costs(field, np.array([path.edge]))[0]):
        return None
    return path


def goal_of(robot: FrontierRobot, path: PathToCell) -> Goal | None:
    """Return the place where a path leaves the known area as a goal."""
    field = robot.own_field()
    return None if field is None else robot.goal_at(field, *path.edge)


def chosen(
    robot: FrontierRobot,
    rule: str,
    because: Event,
    goal: Place | None,
    cost_m: float,
    scores: Scores,
) -> GoalChosen:
    """Return the record of a choice."""
    teammates = [report.robot for report in robot.team.present()]
    return GoalChosen(
        time_s=robot.time_s,
        robot=robot.me.robot,
        rule=rule,
        because=because,
        goal=goal,
        cost_m=cost_m,
        frontiers=tuple([(x, y) for x, y in robot.targets().tolist()]),
        robots=tuple(sorted([robot.me.robot, *teammates])),
        scores=scores,
    )


def agreed(robot: FrontierRobot) -> list[Place]:
    """Return the cells that this robot and all that are present found inaccessible.

    Idle robots, and robots not heard from for long, are not asked for; see `Teammates.present`.
    """
    everybody = {robot.me.robot, *(report.robot for report in robot.team.present())}
    said = robot.team.cells.inaccessible.items()
    return [cell for cell, by in said if everybody <= by.keys()]


def tell_inaccessible(
    robot: FrontierRobot, cells: list[Place], tried: tuple[Place, ...]
) -> Generator[Action, Outcome, None]:
    """INACCESSIBLE CELLS: report cells to which no path leads, and places tried without result."""
    team, me = robot.team, robot.me.robot
    new = [cell for cell in cells if me not in team.cells.inaccessible.get(cell, {})]
    for cell in new:
        team.cells.inaccessible.setdefault(cell, {})[me] = None
    if (new or tried) and not team.is_alone:
        yield Send(
            InaccessibleMessage(
                sender=me, cells=tuple(new), tried=tried, radius_m=robot.body.outer_radius_m
            )
        )


def as_party(robot: FrontierRobot, teammate: Sighting) -> Party:
    """Return a teammate in sight as a party to the right of way.

    Its place is as seen, the rest as reported. A teammate that is not present, or has nothing to
    do, is inactive.
    """
    at = teammate.configuration
    told = {report.robot: report for report in robot.team.present()}.get(teammate.robot)
    path = np.array([at[:2]])
    if told is not None and told.phase == "driving" and told.path:
        path = ahead(np.array(told.path), at)
    return Party(
        robot=teammate.robot,
        configuration=facing(at, path),
        path=path,
        radius_m=teammate.footprint.circumscribed_radius_m,
        leader=told is not None and told.leader,
        inactive=told is None,
    )


def facing(at: Configuration, path: FloatArray) -> Configuration:
    """Return a configuration with the heading in which its path leads."""
    if length_of(path) <= REACHED_M:
        return at
    x, y = next(corner for corner in path.tolist() if math.dist(corner, at[:2]) > 0.0)
    return Configuration(at.x, at.y, math.atan2(y - at.y, x - at.x))
