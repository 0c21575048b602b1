"""Robots of the frontier family choose goals by their rule, from the table that they record."""

from __future__ import annotations

import itertools
import math
from typing import Any, Final, NamedTuple

import numpy as np
from scipy.optimize import linear_sum_assignment

from multisrt.campaign.bodies import FloatArray
from multisrt.campaign.judged_run import ROUNDING_M, JudgedRun
from multisrt.campaign.violations import Violation
from multisrt.events import GoalChosen

NAME: Final = "goals-by-rule"

OFFSET_M: Final = 0.5
"""Length in metres that `gain` adds to every path length."""

NO_BID: Final = 1e7
"""Stands for an infinite bid, so that a matching has as few of these as possible."""


def goals_by_rule(run: JudgedRun) -> Violation | None:
    """Check that goals are those that the rule names, by the table that was recorded.

    `closest`: no recorded cost of the robot is lower; not judged for robots that return data, whose
    tables may contain goals for which no time is left. `minpos`: no recorded rank is lower, and of
    equal ones no cost. `greedy` and `utility`: the goal is that of the robot's round. `utility`:
    values, utility minus `beta` times the share of the cost, never rise from round to round.

    `self-bidding`: the goal is the robot's in a matching of the recorded bids that has as few
    infinite ones as possible and then the lowest sum, computed by another library; or such a
    matching leaves the robot without one, and its cost is the lowest. `gain`: the last round is
    that of the goal; the value of the first one that the robot took is the recorded area over the
    power of the path length, but for `keep_m` and a turn by half a circle. `routes`: no stop is on
    two routes, lengths never fall along a route, and the goal is the first stop of the robot's own
    route, or its nearest frontier if that is empty.

    Cost: negligible.
    """
    for chosen in run.recording.of(GoalChosen):
        what = _wrong(run, chosen)
        if what is not None:
            return Violation(
                invariant=NAME,
                says=f"robot {chosen.robot} at {chosen.time_s:.2f} s ({chosen.rule}): {what}",
                robot=chosen.robot,
                time_s=chosen.time_s,
            )
    return None


class _Choice(NamedTuple):
    """A choice of one of the targets.

    Attributes
    ----------
    noted : GoalChosen
        As it was recorded.
    goal : int
        The number of the target.
    row : int
        The row of the robot in the tables.
    costs : list of float
        The robot's path lengths to the targets, in metres.
    options : dict
        The options of the strategy.
    """

    noted: GoalChosen
    goal: int
    row: int
    costs: list[float]
    options: dict[str, Any]

    @property
    def rounds(self) -> list[tuple[int, int, float, float]]:
        """The robot's own rounds."""
        return [one for one in self.noted.rounds if one[0] == self.noted.robot]


def _wrong(run: JudgedRun, noted: GoalChosen) -> str | None:
    place = noted.goal
    if place is None or not noted.frontiers or not noted.costs or noted.robot not in noted.robots:
        return None
    row = noted.robots.index(noted.robot)
    goal = min(
        range(len(noted.frontiers)), key=lambda target: math.dist(noted.frontiers[target], place)
    )
    if math.dist(noted.frontiers[goal], place) > ROUNDING_M:
        return None  # one that was assigned, or asked for
    costs = [math.inf if cost is None else cost for cost in noted.costs[row]]
    choice = _Choice(noted, goal, row, costs, dict(run.options))
    match noted.rule:
        case "closest" if not run.returns_data:
            return _wrong_closest(choice)
        case "minpos" if noted.ranks:
            return _wrong_minpos(choice)
        case "greedy" | "utility" if noted.rounds:
            return _wrong_in_rounds(choice)
        case "self-bidding" if noted.bids:
            return _wrong_by_bids(choice)
        case "gain" | "room" if noted.rounds:
            return _wrong_gain(choice)
        case "routes" if noted.rounds:
            return _wrong_routes(choice)
    return None


def _wrong_closest(choice: _Choice) -> str | None:
    cost, lowest = choice.costs[choice.goal], min(choice.costs)
    if cost > lowest + ROUNDING_M:
        return f"its goal costs {cost:.3f} m, another one {lowest:.3f} m"
    return None


def _wrong_minpos(choice: _Choice) -> str | None:
    ranks = choice.noted.ranks[choice.row]
    counted = [(rank, choice.costs[k]) for k, rank in enumerate(ranks) if rank is not None]
    best, rank, cost = min(counted), ranks[choice.goal], choice.costs[choice.goal]
    if rank is None or (rank, cost - ROUNDING_M) > best:
        return f"its goal has rank and cost {(rank, cost)}, another one {best}"
    return None


def _wrong_in_rounds(choice: _Choice) -> str | None:
    if [target for _, target, *_ in choice.rounds] != [choice.goal]:
        return f"its goal is target {choice.goal}, and not that of its round"
    if choice.noted.rule == "utility":
        beta = choice.options["beta"]
        values = [utility - beta * share for *_, utility, share in choice.noted.rounds]
        if any(after > before + ROUNDING_M for before, after in itertools.pairwise(values)):
            return f"values rise between rounds, from {values[0]:.3f} to {max(values):.3f}"
    return None


def _wrong_by_bids(choice: _Choice) -> str | None:
    bids = np.array(
        [[NO_BID if bid is None else bid for bid in bids] for bids in choice.noted.bids]
    )
    robots, targets = bids.shape
    # A robot that gets nothing is matched to one of as many virtual targets as there are robots.
    padded = np.hstack([bids, np.full((robots, robots), NO_BID)])
    lowest = _lowest_sum(padded)
    slack = ROUNDING_M * (1.0 + abs(lowest))
    is_finite = choice.noted.bids[choice.row][choice.goal] is not None
    if is_finite and _lowest_with(padded, choice.row, choice.goal) <= lowest + slack:
        return None
    if _lowest_with(padded, choice.row, targets) <= lowest + slack:
        return _wrong_closest(choice)
    return f"no best matching of the bids gives it target {choice.goal}, or none"


def _lowest_sum(bids: FloatArray) -> float:
    rows, columns = linear_sum_assignment(bids)
    return float(bids[rows, columns].sum())


def _lowest_with(bids: FloatArray, row: int, column: int) -> float:
    """Return the lowest sum of matchings in which a robot has a certain target."""
    others = np.delete(np.delete(bids, row, axis=0), column, axis=1)
    return float(bids[row, column]) + _lowest_sum(others)


def _wrong_gain(choice: _Choice) -> str | None:
    if choice.noted.rounds[-1][:2] != (choice.noted.robot, choice.goal):
        return f"its goal is target {choice.goal}, and not that of the last round"
    _, target, area_m2, value = choice.rounds[0]
    cost_m, options = choice.costs[target] + OFFSET_M, choice.options
    turn_m = options["turn_m_per_rad"] * math.pi
    lowest = area_m2 / (cost_m + turn_m) ** options["power"]
    highest = area_m2 / max(cost_m - options["keep_m"], OFFSET_M) ** options["power"]
    if not lowest * (1.0 - 1e-9) <= value <= highest * (1.0 + 1e-9):
        return f"target {target} is worth {value:.4g}, instead of {lowest:.4g} to {highest:.4g}"
    return None


def _wrong_routes(choice: _Choice) -> str | None:
    stops = [target for _, target, *_ in choice.noted.rounds]
    if len({*stops}) < len(stops):
        return f"a target is on two routes: {stops}"
    for _, route in itertools.groupby(choice.noted.rounds, key=lambda stop: stop[0]):
        lengths_m = [at_m for *_, at_m in route]
        if any(b < a - ROUNDING_M for a, b in itertools.pairwise(lengths_m)):
            return f"lengths fall along a route: {lengths_m}"
    if not choice.rounds:
        return _wrong_closest(choice)
    if choice.rounds[0][1] != choice.goal:
        return f"its goal is target {choice.goal}, the first stop {choice.rounds[0][1]}"
    return None
