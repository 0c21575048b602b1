"""What one robot that bids for frontiers does from beginning to end."""

from __future__ import annotations

from collections.abc import Callable, Generator

from multisrt.explorer import Action, Done, Outcome, RobotSelf, Sighting
from multisrt.frontier_team.driving import drive
from multisrt.frontier_team.giving_way import give_way, settle
from multisrt.frontier_team.options import FrontierOptions
from multisrt.frontier_team.robot import FrontierRobot, Goal

Steps = Generator[Action, Outcome, None]
Rule = Callable[[FrontierRobot, str], Generator[Action, Outcome, Goal | None]]
"""Chooses a goal, given why one is chosen; None: there is nothing to go to."""

Drive = Callable[[FrontierRobot, Goal], Generator[Action, Outcome, "str | Sighting"]]


class FrontierExplorer:
    """Explores by going to frontiers that a rule chooses, alone or in a team.

    Parameters
    ----------
    me : RobotSelf
        What the robot knows of itself.
    options : FrontierOptions
        The parameters.
    rule : callable
        Chooses the goals.
    drive : callable
        Drives to them.
    """

    def __init__(
        self, me: RobotSelf, options: FrontierOptions, rule: Rule, drive: Drive = drive
    ) -> None:
        self.robot = FrontierRobot(me, options)
        self.rule = rule
        self.drive = drive

    def run(self) -> Steps:
        """Choose a goal and drive to it, until there is none; then stand by."""
        robot = self.robot
        yield from robot.begin()
        because = "start"
        while True:
            goal = yield from self.rule(robot, because)
            robot.set_goal(goal)
            if goal is None:
                because = yield from self.stand_by()
                continue
            if not robot.team.is_alone:
                yield from robot.team.report()
            reason = yield from self.drive(robot, goal)
            because = yield from self.follow_up(goal, reason)

    def follow_up(self, goal: Goal, reason: str | Sighting) -> Generator[Action, Outcome, str]:
        """Do what the end of a drive asks for; say why the next goal is chosen."""
        robot, team = self.robot, self.robot.team
        if isinstance(reason, Sighting):
            yield from settle(robot, goal, reason)
            return "blocked"
        if reason == "interrupted":
            if team.asked_way is not None:
                yield from give_way(robot)
                return "gave way"
            if team.stopped:
                team.stopped = False
                return "stop signal"
            return "assigned"
        if reason == "reached" and robot.options.sense == "targets":
            yield from robot.perceive()
        if reason == "no way" or (reason == "reached" and robot.stands_on(goal)):
            # Nothing more is to be seen from there, or no way leads there.
            robot.give_up(goal, reason)
        return reason

    def stand_by(self) -> Generator[Action, Outcome, str]:
        """Be done, until something new is heard."""
        robot, team = self.robot, self.robot.team
        blocked = robot.blocked_frontiers()
        if blocked and robot.waits_for_room():
            yield from team.pause(robot.options.pause_s * (0.5 + robot.me.rng.random()))
            return "blocked"
        team.phase = "idle"
        if not blocked:
            yield from robot.tell_when_complete()
        if not team.is_alone:
            yield from team.report()
        outcome = yield Done(
            complete=not blocked,
            reason=robot.account(blocked),
            frontier=(),
            on_call=not team.is_alone,
        )
        yield from team.take(outcome)
        if team.asked_way is not None:
            yield from give_way(robot)
        return "called on"
