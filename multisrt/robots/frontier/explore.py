"""What one robot that bids for frontiers does from beginning to end."""

from __future__ import annotations

import math
from collections.abc import Callable, Generator, Iterable

from multisrt.robots.explorer import Action, Done, Outcome, RobotSelf, Sighting
from multisrt.robots.frontier.driving import Reason, drive
from multisrt.robots.frontier.giving_way import give_way, settle
from multisrt.robots.frontier.options import FrontierOptions
from multisrt.robots.frontier.robot import MOVED_M, FrontierRobot, Goal, Watch

MOST_WAITS = 30
"""So often a robot waits for others to leave its way; then it is done."""

MOST_AT_ONCE = 5
"""So many goals a robot takes and drops at one moment; then it waits a little."""

Steps = Generator[Action, Outcome, None]
Rule = Callable[[FrontierRobot, str], Generator[Action, Outcome, Goal | None]]
"""Chooses a goal, given why one is chosen; None: there is nothing to go to."""

Drive = Callable[[FrontierRobot, Goal], Generator[Action, Outcome, Reason | Sighting]]


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
    watch : callable, optional
        Done whenever the robot has seen something new.
    """

    def __init__(
        self,
        me: RobotSelf,
        options: FrontierOptions,
        rule: Rule,
        drive: Drive = drive,
        watch: Watch | None = None,
    ) -> None:
        self.robot = FrontierRobot(me, options, watch)
        self.rule = rule
        self.drive = drive

    def run(self) -> Steps:
        """Choose a goal and drive to it, until there is none; then stand by."""
        robot = self.robot
        yield from robot.begin()
        because, hasty = "start", 0
        while True:
            goal, robot.detour = robot.detour, None
            if goal is None and (robot.team.has_to_choose or not robot.is_jammed):
                robot.team.phase = "choosing"
                goal = yield from self.rule(robot, because)
            robot.set_goal(goal)
            if goal is None:
                because = yield from self.stand_by()
                continue
            if not robot.team.is_alone:
                yield from robot.team.report()
            began_s = robot.time_s
            reason = yield from self.drive(robot, goal)
            because = yield from self.follow_up(goal, reason)
            hasty = hasty + 1 if robot.time_s == began_s else 0
            if hasty > MOST_AT_ONCE:
                # Others go on meanwhile, and what kept this one from its goals may be over.
                yield from robot.team.pause(robot.options.pause_s * robot.me.rng.random())

    def follow_up(self, goal: Goal, reason: str | Sighting) -> Generator[Action, Outcome, str]:
        """Do what the end of a drive asks for; say why the next goal is chosen."""
        robot, team = self.robot, self.robot.team
        if isinstance(reason, Sighting):
            yield from settle(robot, goal, reason)
            if reason.robot in robot.bodies:
                robot.note_jam(reason.robot)
            reason = "interrupted" if team.is_interrupted else "blocked"
        if reason == "interrupted":
            if team.asked_way is not None:
                asked_by, place = team.asked_way.sender, robot.at[:2]
                yield from give_way(robot)
                if math.dist(robot.at[:2], place) <= MOVED_M:
                    robot.note_jam(asked_by)
                return "gave way"
            if team.stopped:
                team.stopped = False
                return "stop signal"
            return "assigned"
        if reason == "reached" and robot.options.sense == "targets":
            yield from robot.perceive()
        robot.judge(goal, reason)
        return reason

    def stand_by(self) -> Generator[Action, Outcome, str]:
        """Be done until something new is heard; or wait until a robot that is in the way leaves."""
        robot, team = self.robot, self.robot.team
        robot.note_progress()
        if robot.try_again():
            return "no way"
        if robot.is_jammed:
            done = self.boxed_in(robot.jammed_by)
        elif robot.blocked_frontiers():
            if robot.waits < MOST_WAITS and not robot.only_lost_bodies():
                robot.waits += 1
                yield from team.pause(robot.options.pause_s * (0.5 + robot.me.rng.random()))
                yield from robot.look()
                if team.asked_way is not None:
                    yield from give_way(robot)
                return "blocked"
            done = self.boxed_in(robot.bodies)
        else:
            yield from robot.tell_when_complete()
            done = Done(
                complete=True,
                reason="no frontier is left that it can reach",
                on_call=not team.is_alone,
            )
        team.phase = "idle"
        if not team.is_alone:
            yield from team.report()
        known = robot.raster.revision
        while robot.raster.revision == known and not team.is_interrupted:
            outcome = yield done
            yield from team.take(outcome)
        if team.asked_way is not None:
            yield from give_way(robot)
        team.stopped = False
        return "called on"

    def boxed_in(self, by: Iterable[int]) -> Done:
        """Be done because other robots stand in all ways."""
        return Done(
            complete=False,
            reason=f"boxed in by robots {', '.join(map(str, sorted(by)))}, which do not give way",
            on_call=not self.robot.team.is_alone,
        )
