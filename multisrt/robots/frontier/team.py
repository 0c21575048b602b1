"""What a robot that bids for frontiers knows of its team, and how it listens and answers."""

from __future__ import annotations

import math
import weakref
from typing import TYPE_CHECKING

from multisrt.robots.explorer import Send
from multisrt.robots.frontier.messages import (
    AssignmentMessage,
    GiveWayMessage,
    InaccessibleMessage,
    Phase,
    Place,
    ReportMessage,
    RobotReport,
    StopMessage,
    SwapMessage,
)
from multisrt.robots.knowledge import EntriesMessage, Entry, Node, NodeId, WantMessage
from multisrt.robots.listening import Listener, Talk, have_of
from multisrt.robots.messages import Message

if TYPE_CHECKING:
    from multisrt.robots.frontier.robot import FrontierRobot


class Team(Listener):
    """One robot's side of all talk.

    Parameters
    ----------
    robot : FrontierRobot
        Whose.

    Attributes
    ----------
    reports : dict of int to RobotReport
        What every other robot said of itself last.
    asked_way : GiveWayMessage or None
        Who wants this robot to give way, if it has not yet.
    stopped : bool
        Whether a stop signal came for the goal that it has.
    wanted : bool
        Whether somebody wants a goal from this robot.
    deaf_since_s : dict of int to float
        Since when robots have not answered.
    assignment : AssignmentMessage or None
        The leader's last word, until it is followed.
    aim : (x, y) or None
        The unexplored cell for whose sake the robot goes where it goes.
    leader : bool
        Whether it goes first where robots meet.
    inaccessible : dict of (x, y) to dict of int
        Who said that there is no way to a cell.
    tried : dict of (x, y)
        Where this robot, or one no larger, learnt nothing at the edge of what is known.
    """

    ends_pauses_on_time = True

    def __init__(self, robot: FrontierRobot) -> None:
        # The robot holds its team: were it held in turn, both would outlive their run.
        self.robot: FrontierRobot = weakref.proxy(robot)
        super().__init__(self.robot, robot.me, robot.entries, robot.options.ask_period_s)
        self.reports: dict[int, RobotReport] = {}
        self.heard_s: dict[int, float] = {}
        self.asked_way: GiveWayMessage | None = None
        self.asks_s: dict[int, float] = {}
        self.stopped = False
        self.wanted = False
        self.deaf_since_s: dict[int, float] = {}
        self.assignment: AssignmentMessage | None = None
        self.aim: Place | None = None
        self.leader = False
        self.inaccessible: dict[Place, dict[int, None]] = {}
        self.tried: dict[Place, None] = {}
        self.phase: Phase = "choosing"
        self.told_s = -math.inf
        self.told_to_stop: dict[int, tuple[float, float]] = {}
        self._said = 0
        self._told = 0
        self._offered: dict[int, float] = {}

    def present(self) -> list[RobotReport]:
        """Give the reports of the others that are reckoned with, by number.

        Those are left out that have nothing to do, and those that ought to have been heard of.
        """
        since = self.robot.time_s - self.robot.options.forget_after_s
        return [
            report
            for number, report in sorted(self.reports.items())
            if report.phase != "idle" and self.heard_s[number] >= since
        ]

    def own_report(self) -> RobotReport:
        """Give what this robot says of itself."""
        robot = self.robot
        at = robot.now_at()
        goal = robot.goal
        path = () if goal is None else tuple(map(tuple, goal.path.tolist()))
        done = (
            0.0
            if robot.motion is None
            else robot.motion.until(robot.time_s - robot.set_out_s).length_m
        )
        return RobotReport(
            robot=self.number,
            said=self._said,
            time_s=robot.time_s,
            phase=self.phase,
            place=(*at,),
            goal=None if goal is None else goal.place,
            remaining_m=0.0 if goal is None else max(0.0, goal.cost_m - done),
            path=path,
            footprint=str(robot.me.footprint),
            have=self._entries.counts(),
            aim=self.aim,
            leader=self.leader,
        )

    @property
    def is_interrupted(self) -> bool:
        """Whether something was heard for which a robot that drives stops."""
        return self.asked_way is not None or self.stopped or self.has_to_choose

    @property
    def has_to_choose(self) -> bool:
        """Whether a goal is wanted from this robot, or its leader gave it one."""
        return self.wanted or self.assignment is not None

    def is_deaf(self, report: RobotReport) -> bool:
        """Whether a robot has not been heard of since it did not answer."""
        since = self.deaf_since_s.get(report.robot)
        return since is not None and self.heard_s[report.robot] <= since

    def report(
        self, *, asks: bool = False, wants_goal: bool = False, to: int | None = None
    ) -> Talk:
        """Tell how it stands; all, with what is new in the map."""
        self._said += 1
        entries: tuple[Node, ...] = ()
        if to is None:
            own = self._entries
            have = {**own.have(), self.number: (self._told, 0)}
            entries = tuple(e for e in own.lacks(have) if isinstance(e, Node))
            self._told = own.have().get(self.number, (0, 0))[0]
            self.told_s = self.robot.time_s
        yield Send(
            ReportMessage(
                sender=self.number,
                reports=(self.own_report(), *self._passed_on()),
                asks=asks,
                wants_goal=wants_goal,
                entries=entries,
            ),
            to,
        )

    def _merge(self, entries: tuple[Entry, ...]) -> tuple[NodeId, ...]:
        return self.robot.merge(entries)

    def _passed_on(self) -> tuple[RobotReport, ...]:
        # Where nobody relays messages, robots tell of one another.
        radio = self.robot.me.radio
        if radio.multi_hop or math.isinf(radio.range_m):
            return ()
        return tuple(self.present())

    def _take_message(self, message: Message) -> Talk:
        self.heard_s[message.sender] = self.robot.time_s
        body = self.robot.bodies.get(message.sender)
        if body is not None and body.is_lost:
            # It is not.
            del self.robot.bodies[message.sender]
        match message:
            case ReportMessage():
                for report in message.reports:
                    self._take_report(report)
                if message.entries:
                    yield from self.learn(message.entries)
                self.wanted |= message.wants_goal
                if message.asks or self._has_to_offer(message.reports[0]):
                    yield from self.report(to=message.sender)
                own = message.reports[0]
                if own.have != self._entries.counts():
                    yield from self._ask_for_what_lacks(own.robot, own.have)
            case WantMessage():
                yield from self._answer_want(message)
            case EntriesMessage():
                yield from self.learn(message.entries)
            case GiveWayMessage():
                self._take_asked_way(message)
                yield from self.report(to=message.sender)
            case StopMessage():
                goal = self.robot.goal
                if goal is not None and math.dist(goal.place, message.goal) < 1e-9:
                    self.stopped = True
            case AssignmentMessage():
                if self.number in dict(message.goals):
                    self.assignment = message
            case InaccessibleMessage():
                for cell in message.cells:
                    self.inaccessible.setdefault(cell, {})[message.sender] = None
                if message.radius_m <= self.robot.body.outer_radius_m:
                    for place in message.tried:
                        self.tried[place] = None
                        self.robot.give_up(place)
            case SwapMessage():
                if self.aim == message.taken:
                    self.aim = message.given

    def _take_report(self, report: RobotReport) -> None:
        known = self.reports.get(report.robot)
        if report.robot != self.number and (known is None or report.said >= known.said):
            self.reports[report.robot] = report
            self.heard_s[report.robot] = max(
                self.heard_s.get(report.robot, -math.inf), report.time_s
            )

    def _take_asked_way(self, message: GiveWayMessage) -> None:
        # Of two that ask one another the first goes first; at one moment, the lower number.
        lately = self.robot.time_s - 2.0 * self.period_s
        asked_s = self.asks_s.get(message.sender, -math.inf)
        if asked_s >= lately and self.number < message.sender and not message.firm:
            return
        self.asked_way = message

    def _has_to_offer(self, report: RobotReport) -> bool:
        # Who has nothing to do does not report by itself: others would not learn what they lack.
        if self.phase != "idle":
            return False
        lately = self.robot.time_s < self._offered.get(report.robot, -math.inf) + self.period_s
        if lately or not self._entries.more_than(have_of(report.have)):
            return False
        self._offered[report.robot] = self.robot.time_s
        return True
