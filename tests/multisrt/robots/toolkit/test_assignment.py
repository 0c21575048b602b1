import numpy as np
import pytest

import multisrt as ms
from multisrt.environments.catalog import environment
from multisrt.events import GoalChosen
from multisrt.robots.defects import ExplorerDefect
from multisrt.robots.toolkit import assignment

WORLD = environment("open", size_m=8.0, columns=2)


def explore(rule, robots=1, **options):
    return ms.explore(WORLD, strategy=assignment(rule), robots=robots, seed=1, options=options)


def test_a_rule_is_a_strategy_by_itself():
    @assignment
    def nearest_door(costs, robot):
        """The nearest.

        More.
        """

    assert (nearest_door.name, nearest_door.summary) == ("nearest-door", "The nearest")
    assert nearest_door.explorer.__module__ == __name__

    named = assignment(name="other", summary="Another")(lambda costs, robot: 0)
    assert (named.name, named.summary) == ("other", "Another")


def test_a_rule_is_asked_with_costs_and_its_row():
    asked = []

    def nearest(costs, robot):
        asked.append((costs.shape, robot, bool(np.isfinite(costs[robot]).any())))
        with pytest.raises(ValueError, match="read-only"):
            costs[0, 0] = 1.0
        return costs[robot].argmin()

    run = explore(nearest, robots=3)
    assert run.outcome == "complete"
    assert run.metrics.coverage > 0.99
    assert {robot for (_, _), robot, _ in asked} >= {0, 1}
    assert all(0 <= robot < rows <= 3 and has_way for (rows, _), robot, has_way in asked)
    chosen = run.recording.of(GoalChosen)
    assert {event.rule for event in chosen} == {"nearest"}
    assert len(asked) == sum(bool(event.costs and event.goal) for event in chosen)


def test_the_nearest_frontier_alone_is_what_closest_does():
    def nearest(costs, robot):
        return costs[robot].argmin()

    mine, theirs = explore(nearest), ms.explore(WORLD, strategy="closest", seed=1)
    assert mine.metrics.makespan_s == theirs.metrics.makespan_s
    assert mine.metrics.total_distance_m == theirs.metrics.total_distance_m


def test_a_robot_that_gets_nothing_waits_and_is_asked_again():
    def first_alone(costs, robot):
        return int(costs[0].argmin()) if robot == 0 else None

    run = explore(first_alone, robots=2)
    assert run.outcome == "complete"
    assert run.metrics.coverage > 0.99
    assert run.metrics.distance_by_robot_m[0] > 10.0 * run.metrics.distance_by_robot_m[1]


@pytest.mark.parametrize(
    ("rule", "told"),
    [
        (lambda costs, robot: "first", "it returned 'first'; return a number, as int(x), or None"),
        (lambda costs, robot: 1.0, "it returned 1.0; return a number"),
        (lambda costs, robot: 99, "it returned 99, of "),
        (lambda costs, robot: -1, "it returned -1, of "),
        (lambda costs, robot: None, "it returned None 3 times in a row while nothing changed"),
    ],
)
def test_what_is_no_frontier_is_refused(rule, told):
    with pytest.raises(ExplorerDefect) as defect:
        ms.explore(WORLD, strategy=assignment(rule, name="wrong"), seed=1, options={"max_waits": 2})
    assert told in str(defect.value)
    assert "the rule 'wrong', asked by robot 0" in str(defect.value)


def test_a_frontier_that_cannot_be_reached_is_refused():
    from multisrt.robots.frontier.wavefront_costs import Table
    from multisrt.robots.toolkit.assignment import RuleAdapter

    costs = np.array([[np.inf, 2.0]])
    table = Table(targets=np.zeros((2, 2)), robots=(4,), costs=costs, field=None, row=0)
    with pytest.raises(ExplorerDefect, match="it returned 0, to which no path"):
        RuleAdapter(lambda costs, robot: 0, "wrong")._ask(table)
    assert RuleAdapter(lambda costs, robot: np.int64(1), "right")._ask(table) == 1
