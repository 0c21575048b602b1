"""Robots of the frontier family choose goals by their rule, from the table that they record."""

from __future__ import annotations

import itertools
import math
from typing import Final

from multisrt.campaign.judged_run import ROUNDING_M, JudgedRun
from multisrt.campaign.violations import Violation
from multisrt.events import GoalChosen

NAME: Final = "goals-by-rule"


def goals_by_rule(run: JudgedRun) -> Violation | None:
    """Check that goals are those that the rule names, by the table that was recorded.

    `closest`: no recorded cost of the robot is lower; not judged for robots that return data, whose
    tables may contain goals for which no time is left. `minpos`: no recorded rank is lower, and of
    equal ones no cost. `greedy` and `utility`: the goal is that of the robot's round. `utility`:
    values, utility minus `beta` times the share of the cost, never rise from round to round.

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


def _wrong(run: JudgedRun, chosen: GoalChosen) -> str | None:
    place = chosen.goal
    if place is None or not chosen.frontiers or chosen.robot not in chosen.robots:
        return None
    own = chosen.robots.index(chosen.robot)
    targets = range(len(chosen.frontiers))
    goal = min(targets, key=lambda k: math.dist(chosen.frontiers[k], place))
    if math.dist(chosen.frontiers[goal], place) > ROUNDING_M:
        return None  # one that was assigned, or asked for
    if not chosen.costs:
        return None
    costs = [math.inf if cost is None else cost for cost in chosen.costs[own]]
    rounds = [one for one in chosen.rounds if one[0] == chosen.robot]
    match chosen.rule:
        case "closest" if not run.returns_data:
            if costs[goal] > min(costs) + ROUNDING_M:
                return f"its goal costs {costs[goal]:.3f} m, another one {min(costs):.3f} m"
        case "minpos" if chosen.ranks:
            ranks = chosen.ranks[own]
            counted = [(rank, costs[k]) for k, rank in enumerate(ranks) if rank is not None]
            best, mine = min(counted), (ranks[goal], costs[goal])
            if mine[0] is None or (mine[0], mine[1] - ROUNDING_M) > best:
                return f"its goal has rank and cost {mine}, another one {best}"
        case "greedy" | "utility" if chosen.rounds:
            if [one[1] for one in rounds] != [goal]:
                return f"its goal is target {goal}, and not that of its round"
            if chosen.rule == "utility":
                beta = run.options["beta"]
                values = [one[2] - beta * one[3] for one in chosen.rounds]
                if any(b > a + ROUNDING_M for a, b in itertools.pairwise(values)):
                    return f"values rise between rounds, from {values[0]:.3f} to {max(values):.3f}"
    return None
