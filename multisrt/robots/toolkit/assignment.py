"""Strategies made of an assignment rule, with robots of the frontier family."""

from __future__ import annotations

import operator
from collections.abc import Callable
from typing import Any, NoReturn, SupportsIndex, overload

import numpy as np

from multisrt.geometry.numerics.arrays import FloatArray
from multisrt.robots.defects import ExplorerDefect, brief
from multisrt.robots.explorer import Explorer, RobotSelf
from multisrt.robots.frontier.explore import FrontierExplorer
from multisrt.robots.frontier.options import FrontierOptions
from multisrt.robots.frontier.progress import Event
from multisrt.robots.frontier.robot import FrontierRobot
from multisrt.robots.frontier.wavefront_costs import Table, full_table
from multisrt.robots.frontier.wavefront_rules import Choice, settle_on
from multisrt.robots.strategy import Strategy, kebab_case

AssignmentRule = Callable[[FloatArray, int], SupportsIndex | None]
"""Takes costs and the robot's row; returns the number of a frontier, or None."""


@overload
def assignment(
    rule: AssignmentRule,
    *,
    name: str | None = None,
    summary: str | None = None,
    options: type[FrontierOptions] = FrontierOptions,
) -> Strategy: ...
@overload
def assignment(
    rule: None = None,
    *,
    name: str | None = None,
    summary: str | None = None,
    options: type[FrontierOptions] = FrontierOptions,
) -> Callable[[AssignmentRule], Strategy]: ...
def assignment(
    rule: AssignmentRule | None = None,
    *,
    name: str | None = None,
    summary: str | None = None,
    options: type[FrontierOptions] = FrontierOptions,
) -> Strategy | Callable[[AssignmentRule], Strategy]:
    """Return a strategy whose robots go to the frontiers that a rule assigns to them.

    Only the rule has to be written: mapping, driving, communicating and giving way are those of
    `closest`, `greedy` and `minpos`. Can also be used as a decorator of the rule.

    Parameters
    ----------
    rule : callable
        Takes the costs, an ``(n, m)`` array of path lengths in metres from each of the n robots
        considered to each of m frontiers, ``inf`` if there is no path; and the row of the robot
        that decides. Returns the index of the frontier that this robot goes to, or None to leave
        all frontiers to the others: the robot then waits, and the rule is called again. It is
        called only while the robot can reach a frontier. Costs are computed on the robot's own map;
        rows are in the order of robot numbers. Robots that are idle, or have not been heard from
        for some time, have no row.
    name : str, optional
        Name of the strategy; by default the name of the rule, with hyphens.
    summary : str, optional
        One line for lists; by default the first line of the rule's docstring.
    options : type
        The options: `FrontierOptions`, or a class derived from it with other defaults.

    Returns
    -------
    Strategy
        The strategy, for `multisrt.explore`, `multisrt.compare`, `multisrt.register` or
        `multisrt.testing.check_explorer`.

    Examples
    --------
    >>> @assignment
    ... def nearest(costs, robot):
    ...     '''Every robot to its nearest frontier.'''
    ...     return costs[robot].argmin()
    >>> nearest.name, nearest.summary
    ('nearest', 'Every robot to its nearest frontier')
    """
    if rule is None:
        return lambda given: assignment(given, name=name, summary=summary, options=options)
    title = kebab_case(rule.__name__) if name is None else name
    known = rule

    def explorer(me: RobotSelf, chosen: FrontierOptions) -> Explorer:
        return AssignmentExplorer(me, chosen, known, title)

    # The strategy is one of the rule's module: loading by reference goes by that.
    explorer.__module__, explorer.__name__ = rule.__module__, rule.__name__
    first_line = (rule.__doc__ or "").strip().partition("\n")[0].rstrip(". ")
    return Strategy(
        name=title,
        summary=summary or first_line or f"The rule {rule.__name__} of {rule.__module__}",
        options=options,
        explorer=explorer,
    )


class AssignmentExplorer(FrontierExplorer):
    """Explores by driving to the frontiers that an assignment rule chooses.

    Parameters
    ----------
    me : RobotSelf
        What the robot knows about itself.
    options : FrontierOptions
        The parameters.
    rule : callable
        See `assignment`.
    name : str
        Name of the rule in recordings.
    """

    def __init__(
        self, me: RobotSelf, options: FrontierOptions, rule: AssignmentRule, name: str
    ) -> None:
        self._adapter = RuleAdapter(rule, name)
        super().__init__(me, options, self._adapter)
        self.asks = rule

    def why_no_goal(self) -> Event:
        """Return the event of a robot without a goal: it waits if the rule says so."""
        return Event.BARRED if self._adapter.is_waiting else super().why_no_goal()


class RuleAdapter:
    """Adapter of an assignment rule to the frontier family.

    Parameters
    ----------
    rule : callable
        See `assignment`.
    name : str
        Its name in recordings.

    Attributes
    ----------
    is_waiting : bool
        Whether the rule has assigned the robot no frontier although it could reach one.
    """

    def __init__(self, rule: AssignmentRule, name: str) -> None:
        self.is_waiting = False
        self._rule = rule
        self._name = name
        self._known: tuple[object, ...] = ()
        self._waits = 0

    def __call__(self, robot: FrontierRobot, because: str) -> Choice:
        """Choose a goal by the rule, and record the choice."""
        table = full_table(robot)
        can_go = bool(np.isfinite(table.costs[table.row]).any())
        choice = self._ask(table) if can_go else None
        self.is_waiting = can_go and choice is None
        if self.is_waiting:
            self._count(robot, table)
        return (yield from settle_on(robot, table, choice, self._name, because))

    def _ask(self, table: Table) -> int | None:
        costs = table.costs.copy()
        costs.setflags(write=False)
        given: Any = self._rule(costs, table.row)
        if given is None:
            return None
        try:
            choice = operator.index(given)
        except TypeError:
            self._refuse(
                table, f"it returned {brief(given)}", "return a number, as int(x), or None"
            )
        if not 0 <= choice < costs.shape[1]:
            self._refuse(
                table,
                f"it returned {choice}, of {costs.shape[1]} frontiers",
                "return the number of a column of the costs, from 0, or None",
            )
        if not np.isfinite(costs[table.row, choice]):
            self._refuse(
                table,
                f"it returned {choice}, to which no path of the robot leads",
                "return a frontier with a finite cost in the row of the robot",
            )
        return choice

    def _count(self, robot: FrontierRobot, table: Table) -> None:
        # Waits in which nothing has changed: neither the map nor any robot's costs.
        known = robot.raster.revision, table.robots, table.costs.tobytes()
        self._waits = self._waits + 1 if known == self._known else 1
        self._known = known
        if self._waits > robot.options.max_waits:
            self._refuse(
                table,
                f"it returned None {self._waits} times in a row while nothing changed, though "
                "the robot can reach a frontier",
                "give at least one robot of those in the costs a frontier",
            )

    def _refuse(self, table: Table, what: str, remedy: str) -> NoReturn:
        raise ExplorerDefect(
            what, f"the rule {self._name!r}, asked by robot {table.robots[table.row]}", remedy
        )
