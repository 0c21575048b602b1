"""An explorer of the frontier family whose goals are chosen by a policy or from outside."""

from __future__ import annotations

from collections.abc import Callable
from typing import Literal

import numpy as np

from multisrt.geometry.numerics.arrays import FloatArray
from multisrt.robots.explorer import Look, RobotSelf
from multisrt.robots.frontier.driving import Driven, drive
from multisrt.robots.frontier.explore import FrontierExplorer
from multisrt.robots.frontier.fields import NEAR_BY_CELLS
from multisrt.robots.frontier.goal import Goal
from multisrt.robots.frontier.nearness import drive_by_option
from multisrt.robots.frontier.options import BiddingOptions
from multisrt.robots.frontier.robot import FrontierRobot
from multisrt.robots.frontier.wavefront_rules import Choice, note_goal, settle_on
from multisrt.robots.policy.decision_spec import Answer, DecisionSpec
from multisrt.robots.policy.observing import Observation, observe
from multisrt.robots.policy.questions import Question, question_of

Policy = Callable[[Observation], Answer]
"""Takes what a robot observes, and returns where it is to go."""


class PolicyOptions(BiddingOptions, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Parameters of robots that are told where to go: those of `BiddingOptions`.

    Attributes
    ----------
    replan : {"target", "news"}
        Whether a robot asks when the last goal is reached or nothing is left to be seen there,
        or whenever its map has changed.
    """

    replan: Literal["news", "target"] = "target"


class PolicyExplorer(FrontierExplorer):
    """Explores by driving where a policy says.

    Parameters
    ----------
    me : RobotSelf
        What the robot knows of itself.
    options : PolicyOptions
        Its parameters.
    spec : DecisionSpec
        What it observes and may be answered.
    policy : callable, optional
        Chooses where it goes. Default: the answer comes from outside. Then the run pauses at an
        action `Look` while `pending.question` is set, and `pending.answer` has to be set before it
        goes on.
    rule : str, default "policy"
        The name under which its choices are recorded.

    Attributes
    ----------
    pending : PendingDecision
        Its question that waits for an answer.
    """

    def __init__(
        self,
        me: RobotSelf,
        options: PolicyOptions,
        spec: DecisionSpec,
        policy: Policy | None = None,
        *,
        rule: str = "policy",
    ) -> None:
        pending = PendingDecision(spec, policy, rule)
        super().__init__(me, options, pending.choose, pending.drive)
        self.pending = pending
        self.asks = policy

    def observe(self) -> Observation:
        """Return what the robot observes as it asks; to be called while it does."""
        assert self.pending.question is not None
        return observe(self.robot, self.pending.question, self.pending.spec)


class PendingDecision:
    """The question of one robot, the answer to it, and the goal that follows.

    Parameters
    ----------
    spec : DecisionSpec
        What it observes and may be answered.
    policy : callable or None
        What answers; None: the answer is set from outside.
    rule : str
        The name under which choices are recorded.

    Attributes
    ----------
    question : Question or None
        What the robot asks now; None while it is on its way.
    answer : Answer or None
        What it is answered; to be set while it asks.
    was_valid : bool
        Whether the last answer could be followed. Otherwise the robot has gone to the nearest
        frontier.
    """

    def __init__(self, spec: DecisionSpec, policy: Policy | None, rule: str) -> None:
        self.spec = spec
        self.question: Question | None = None
        self.answer: Answer | None = None
        self.was_valid = True
        self._policy = policy
        self._rule = rule

    def choose(self, robot: FrontierRobot, because: str) -> Choice:
        """Ask where to go, unless no frontier can be reached, and settle on a goal."""
        question = question_of(robot, self.spec.frontiers)
        if not len(question.nearest):
            return (yield from settle_on(robot, question.table, None, self._rule, because))
        if self._policy is not None:
            answer = self._policy(observe(robot, question, self.spec))
        else:
            self.question = question
            yield Look()
            answer, self.question, self.answer = self.answer, None, None
        checked = self.spec.checked(answer)
        if isinstance(checked, int):
            row = self._row(question, checked)
            return (yield from settle_on(robot, question.table, row, self._rule, because))
        goal = self._goal(robot, question, checked)
        yield note_goal(robot, question.table, goal, self._rule, because)
        return goal

    def drive(self, robot: FrontierRobot, goal: Goal) -> Driven:
        """Drive to a goal, also where nothing is left to be seen there."""
        if robot.is_frontier(*goal.place):
            return (yield from drive_by_option(robot, goal))
        return (yield from drive(robot, goal, to_see=False))

    def _row(self, question: Question, number: int) -> int:
        # The row of the frontier with the number that was answered, else of the nearest.
        self.was_valid = 0 <= number < len(question.nearest)
        return int(question.nearest[number if self.was_valid else 0])

    def _goal(self, robot: FrontierRobot, question: Question, offset: FloatArray) -> Goal:
        # The passable place nearest to the one that was answered, else the nearest frontier.
        field = question.table.field
        assert field is not None, "a robot that can reach a frontier has a field"
        with robot.around_bodies():
            if np.isfinite(offset).all():
                x, y = (robot.at[:2] + self.spec.place_m * np.clip(offset, -1.0, 1.0)).tolist()
                cell = robot.raster.passable_near(x, y, NEAR_BY_CELLS)
                if cell is not None:
                    place = robot.raster.centre_of(*cell)
                    if np.isfinite(robot.fitting_costs(field, np.array([place]))[0]):
                        self.was_valid = True
                        return robot.goal_at(field, *place)
            self.was_valid = False
            return robot.goal_at(field, *question.table.targets[question.nearest[0]].tolist())
