"""The explorer of frontier bidding, from beginning to end.

Where the procedures of the papers are:

=================================  =============================================================
SBX-R                              module
=================================  =============================================================
Algorithm 1, main exploration      `explore`, here, with the states in `progress`
- map generator                    `scan_map`
- EEDT planner                     `path_finder`, with `geometry.grids.euclidean_field`
- navigator                        `nearness`, with `planners.navigation.nearness_diagram`
- stop signal                      `self_bidding`; heard in `team`
Algorithm 2, table of bids         `self_bidding`, with `planners.assignment.self_bidding`
Algorithm 3, communication         `team`, with `messages` and `multisrt.robots.listening`
=================================  =============================================================

=================================  =============================================================
Álvarez, section                   module
=================================  =============================================================
3.2.1 data acquisition             `scan_map`; inaccessible cells in `alvarez`
3.2.2 general control              `explore`, here, with `Rules` in `alvarez`
3.2.3 goal search (Algorithm 2)    `alvarez_goals`, with `planners.grid_search` and
                                   `planners.assignment.cell_choice`
3.2.4 look ahead                   `alvarez_goals`, with `planners.navigation.sector`
3.2.5 path planning (Algorithm 3)  `alvarez_goals`, with `planners.grid_search`
3.2.6 motion (Algorithm 4)         `alvarez` and `driving`
3.2.7 conflicts (Algorithm 5)      `alvarez`, with `planners.navigation.right_of_way`
3.2.8 exchange (Algorithm 6)       `alvarez`, with `planners.assignment.exchange`
=================================  =============================================================
"""

from __future__ import annotations

import math
from collections.abc import Callable, Generator
from typing import Final

import numpy as np

from multisrt.events import Decided
from multisrt.planners.home_options import NO_TIME_LEFT
from multisrt.robots.explorer import Action, Done, Note, Outcome, RobotSelf, Sighting, Steps
from multisrt.robots.frontier.bodies import MOVED_M
from multisrt.robots.frontier.chain import Chain
from multisrt.robots.frontier.driving import Drive, drive
from multisrt.robots.frontier.errand_steps import agree, end_errand, errand_now
from multisrt.robots.frontier.errands import Errand
from multisrt.robots.frontier.giving_way import ask_to_leave, find_detour, give_way
from multisrt.robots.frontier.goal import Goal
from multisrt.robots.frontier.homing import FrontierHoming
from multisrt.robots.frontier.options import FrontierOptions
from multisrt.robots.frontier.progress import Event, Progress, State
from multisrt.robots.frontier.robot import FrontierRobot, Watch
from multisrt.robots.naming import NO_CHAIN, WALLED_IN, boxed_in_by

Rule = Callable[[FrontierRobot, Event], Generator[Action, Outcome, Goal | None]]
"""Chooses a goal, given why one is chosen; returns None if there is nothing to go to."""

Act = Generator[Action, Outcome, Event]

NO_TIME = "there is no time for another goal and the way home"
"""Why a robot goes home, in words, that would have gone on."""

DONE: Final = (
    Event.OUT_OF_TIME,
    Event.OUT_OF_REACH,
    Event.EXPLORED,
    Event.JAMMED,
    Event.BOXED_IN,
)
"""Events after which a robot without a goal is done."""


def left_out(homing: FrontierHoming) -> tuple[str, Event]:
    """Return why a robot has no goal, in words and as an event, that has left some out."""
    if homing.chain is not None:
        return "there is no goal from which the chain reaches home", Event.OUT_OF_REACH
    return NO_TIME, Event.OUT_OF_TIME


class FrontierExplorer:
    """Explores by driving to frontiers that a rule chooses, alone or in a team.

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
        Called after every scan that showed something new.
    at_end : callable, optional
        Called when no frontier is left that the robot could reach, before it is done.
    barred : callable
        Whether, when the rule has chosen nothing, there are goals to which only bodies in the way
        bar all paths. By default the frontiers of the raster are the goals; a rule that goes to
        other places has to say it itself.

    Attributes
    ----------
    robot : FrontierRobot
        The robot and what it knows.
    progress : Progress
        Its state.
    asks : callable or None
        The function, perhaps one of a user's own, that it asks where to go: checks read its code.
    """

    def __init__(
        self,
        me: RobotSelf,
        options: FrontierOptions,
        rule: Rule,
        drive: Drive = drive,
        watch: Watch | None = None,
        at_end: Watch | None = None,
        barred: Callable[[FrontierRobot], bool] = FrontierRobot.blocked_frontiers,
    ) -> None:
        self.robot = FrontierRobot(me, options, watch)
        self.progress = Progress(options, self.robot.course, self.robot.raster)
        self.asks: Callable[..., object] | None = rule
        self._rule = rule
        self._drive = drive
        self._at_end = at_end
        self._barred = barred
        self._goes_to_frontiers = barred is FrontierRobot.blocked_frontiers
        self._met: Sighting | None = None
        self._errand: Errand | None = None
        # The last errand that is on record, of those that are not over.
        self._told: tuple[str, str] | None = None

    def run(self) -> Steps:
        """Perceive; choose a goal and drive to it until no frontier is left; then stand by."""
        yield from self.robot.begin()
        while True:
            event = yield from self.act()
            self.progress.advance(event)
            if self.progress.is_hasty:
                robot = self.robot
                yield from robot.team.pause(robot.options.pause_s * robot.me.rng.random())

    def act(self) -> Act:
        """Do what the present state is for; return what ends it."""
        match self.progress.state:
            case State.CHOOSING:
                return (yield from self.choose())
            case State.DRIVING:
                return (yield from self.drive())
            case State.MEETING:
                return (yield from self.meet())
            case State.YIELDING:
                return (yield from self.give_way())
            case State.WAITING:
                return (yield from self.wait())
            case State.ATTENDING:
                return (yield from self.attend())
            case State.BOXED_IN | State.OUT_OF_TIME | State.OUT_OF_REACH | State.COMPLETE:
                return (yield from self.stand_by())

    def choose(self) -> Act:
        """Choose a goal by the rule, unless it is clear that none can be reached; or an errand."""
        robot, team, goal = self.robot, self.robot.team, None
        self._errand = None
        # What the front of a chain wants now is looked up below.
        team.requests.link = False
        if not self.progress.is_jammed:
            team.phase = "choosing"
            if (errand := errand_now(robot)) is not None:
                return (yield from self.set_out(errand))
            if robot.homing is not None:
                robot.homing.has_left_out = False
            goal = yield from self.called_for()
            if goal is None:
                goal = yield from self._rule(robot, self.progress.because)
        if robot.homing is not None:
            return (yield from self.weigh(robot.homing, goal))
        robot.set_goal(goal)
        return Event.GOAL if goal is not None else self.why_no_goal()

    def called_for(self) -> Generator[Action, Outcome, Goal | None]:
        """Return the goal for which the front of a chain called its relays, once they are in place.

        It is kept: the rule may prefer another goal as soon as the relays have moved, and send them
        to and fro forever. Only where goals are frontiers of the raster: other rules keep account
        of what they chose.
        """
        robot = self.robot
        chain = None if robot.homing is None else robot.homing.chain
        place = None if chain is None else chain.take_called_for()
        if place is None or not self._goes_to_frontiers:
            return None
        if not robot.is_frontier(*place) or robot.frontiers.is_given_up(place):
            return None
        with robot.around_bodies():
            field = robot.own_field()
            if field is None or math.isinf(field.distance(robot.indices_of(np.array([place])))[0]):
                return None
            goal = robot.goal_at(field, *place)
        text = "goes where it called its relays for: they are in place"
        yield Note(Decided(time_s=robot.time_s, robot=robot.me.robot, text=text, goal=place))
        return goal

    def weigh(self, homing: FrontierHoming, goal: Goal | None) -> Act:
        """Take a goal if there is time for it and the way home; else go home, if that is of use.

        Rules leave out what there is no time for; one of a user's own may not.
        """
        robot, why = self.robot, "it knows of nothing that is left to explore"
        robot.set_goal(goal)
        if goal is None:
            event = self.why_no_goal()
            if event in (Event.EXPLORED, Event.BOXED_IN) and homing.has_left_out:
                why, event = left_out(homing)
        elif homing.fits(goal):
            event = Event.GOAL
        else:
            robot.set_goal(None)
            why, event = left_out(homing)
        if homing.chain is not None:
            errand = self.weigh_chain(homing.chain, goal, event)
            if errand is not None:
                return (yield from self.set_out(errand))
        is_done = event in DONE
        if is_done and robot.team.carries:
            # The answer to the last report may be on its way.
            yield from robot.team.pause(robot.team.round_trip_s)
        if robot.team.requests.meet or (is_done and homing.may_dismiss_partner()):
            following = robot.at[:2] if goal is None else goal.place
            yield from agree(robot, homing, None if is_done else following)
        if is_done and robot.raster.revision != robot.course.goal_revision:
            return Event.NEWS
        if event is Event.EXPLORED:
            yield from robot.tell_when_complete()
        if not is_done or self.progress.is_jammed or not homing.may_deliver():
            return event
        return (yield from self.set_out(homing.errand(why)))

    def weigh_chain(self, chain: Chain, goal: Goal | None, event: Event) -> Errand | None:
        """Return what a robot of a chain has to wait for, before its goal or without one."""
        if not chain.is_front:
            chain.let_go()
            return chain.stand_by() if event in DONE else None
        if goal is None or event is not Event.GOAL:
            chain.let_go()
            if event in DONE:
                chain.pass_front()
            return None
        return chain.call(goal)

    def set_out(self, errand: Errand) -> Act:
        """Begin an errand; wait if bodies bar all paths."""
        robot = self.robot
        robot.team.cells.aim = None
        self._errand = errand
        robot.set_goal(errand.goal)
        if (errand.kind, errand.why) != self._told:
            self._told = errand.kind, errand.why
            place = None if errand.goal is None else errand.goal.place
            text = f"{errand.what}: {errand.why}"
            now_s, number = robot.time_s, robot.me.robot
            yield Note(Decided(time_s=now_s, robot=number, text=text, goal=place))
        if errand.goal is not None:
            return Event.GOAL
        if (event := self.past_bodies()) is not None:
            return event
        yield from self.end_errand(errand, barred=True)
        return Event.NO_WAY

    def why_no_goal(self) -> Event:
        """Return what a robot without a goal is to do."""
        robot, progress = self.robot, self.progress
        if robot.frontiers.reopen(robot.bodies.numbers()):
            return Event.NO_WAY
        if progress.is_jammed:
            return Event.JAMMED
        if not self._barred(robot):
            return Event.BOXED_IN if robot.is_walled_in else Event.EXPLORED
        return self.past_bodies() or Event.BOXED_IN

    def past_bodies(self) -> Event | None:
        """Return what to do where bodies bar all paths: wait, or look again; None if neither."""
        bodies = self.robot.bodies
        if self.progress.may_wait and not bodies.all_are_lost():
            return Event.BARRED
        return Event.NO_WAY if bodies.seek_lost(self.robot.options.body_stays_s) else None

    def drive(self) -> Act:
        """Drive to the goal, and judge what came of it."""
        robot, goal = self.robot, self.robot.goal
        assert goal is not None
        if robot.team.has_receivers:
            yield from robot.team.report()
        errand = self._errand
        if errand is None:
            ended = yield from self._drive(robot, goal)
        else:
            ended = yield from drive(
                robot,
                goal,
                errand.purpose,
                to_see=False,
                until=lambda: errand.is_over() or errand.is_late(robot.time_s),
            )
        if isinstance(ended, Sighting):
            self._met = ended
            return Event.MET
        if ended is Event.INTERRUPTED:
            return self.request()
        if errand is not None:
            return (yield from self.judge_errand(errand, ended))
        if ended is Event.REACHED and robot.options.sense == "targets":
            yield from robot.perceive()
        if ended is Event.REACHED:
            robot.frontiers.note_reached(goal.place, robot.at[:2])
        elif ended is Event.NO_WAY:
            if robot.options.replan == "arrival" and not robot.is_frontier(*goal.place):
                # It cannot go on to a goal at which nothing is left: there is nothing to give up.
                return Event.NOTHING_LEFT
            yield from self.judge_no_path(goal)
        return ended

    def judge_errand(self, errand: Errand, ended: Event) -> Act:
        """Return what a drive on an errand has led to."""
        robot = self.robot
        if ended is Event.REACHED:
            return Event.ARRIVED
        if ended is Event.NO_WAY:
            robot.course.note_no_path()
            assert robot.goal is not None
            if self.progress.note_no_path(robot.goal.place):
                yield from self.end_errand(errand, barred=True)
        elif ended is Event.ERRAND_OVER:
            yield from self.end_errand(errand)
        return ended

    def end_errand(self, errand: Errand, *, barred: bool = False) -> Steps:
        """Record that an errand is over, perhaps in vain, or as bodies bar all paths."""
        self._told = None
        yield from end_errand(self.robot, errand, barred=barred)

    def attend(self) -> Act:
        """Wait where an errand leads until it is over, or as long as it allows."""
        robot, errand = self.robot, self._errand
        assert errand is not None
        robot.team.phase = "idle"
        arrived_s = robot.time_s
        while not errand.is_over():
            if robot.team.requests.give_way is not None:
                return Event.ASKED
            if robot.team.requests.meet:
                return Event.ERRAND_OVER
            robot.team.requests.link = False
            if robot.time_s >= errand.waits_until_s(arrived_s):
                break
            robot.team.requests.stop = False
            yield from robot.team.deliver()
            if errand.is_barred:
                yield from robot.bodies.look()
            # A relay is in touch anyway.
            is_linked = errand.kind in ("link", "wait")
            period_s = robot.options.report_period_s if is_linked else robot.team.period_s
            yield from robot.team.pause(period_s)
        yield from self.end_errand(errand)
        return Event.ERRAND_OVER

    def judge_no_path(self, goal: Goal) -> Steps:
        """Give a goal up if the path to it was not free too often; see `Progress.note_no_path`.

        If the last scan is not on the map, the obstacle may be in it: the robot first takes a scan
        and adds it to the map.
        """
        robot = self.robot
        robot.course.note_no_path()
        if robot.car is not None:
            robot.frontiers.note_no_path(goal.place, robot.bodies.numbers())
        if not self.progress.note_no_path(goal.place):
            return
        if robot.has_scan_to_map:
            yield from robot.perceive()
        else:
            robot.frontiers.give_up(goal.place)

    def request(self) -> Event:
        """Return what the others want from this robot, the most urgent first."""
        requests = self.robot.team.requests
        if requests.give_way is not None:
            return Event.ASKED
        if requests.stop:
            requests.stop = False
            return Event.STOP_SIGNAL
        return Event.ERRAND if requests.meet or requests.link else Event.ASSIGNED

    def meet(self) -> Act:
        """Go round a robot before which the protective stop ended a motion, or ask it to leave."""
        robot, goal, met = self.robot, self.robot.goal, self._met
        assert goal is not None
        assert met is not None
        detour = yield from find_detour(robot, goal, self.progress)
        if detour is None:
            yield from ask_to_leave(robot, goal, met)
        if met.robot in robot.bodies:
            self.progress.note_jam(met.robot)
        if robot.team.requests.any_pending:
            asked = robot.team.requests.give_way
            if asked is not None and asked.sender == met.robot:
                self.progress.note_asked_instead(met.robot)
            return self.request()
        if detour is None:
            return Event.BLOCKED
        robot.set_goal(detour)
        return Event.DETOUR

    def give_way(self) -> Act:
        """Make room for a robot that asked for it."""
        robot, asked = self.robot, self.robot.team.requests.give_way
        assert asked is not None
        place = robot.at[:2]
        yield from give_way(robot, self.progress.note_giving_way(asked.sender))
        if math.dist(robot.at[:2], place) <= MOVED_M:
            self.progress.note_jam(asked.sender)
        return Event.GAVE_WAY

    def wait(self) -> Act:
        """Wait a little for the robots in the way to leave."""
        robot = self.robot
        self.progress.note_wait()
        yield from robot.team.pause(robot.options.pause_s * (0.5 + robot.me.rng.random()))
        yield from robot.bodies.look()
        return Event.BLOCKED if robot.team.requests.give_way is None else Event.ASKED

    def stand_by(self) -> Act:
        """Be done until something new is heard."""
        robot, team, progress = self.robot, self.robot.team, self.progress
        is_complete = progress.state is State.COMPLETE
        if is_complete:
            yield from robot.tell_when_complete()
            if self._at_end is not None:
                yield from self._at_end(robot)
        done = Done(complete=is_complete, reason=self.why_done(), on_call=team.has_receivers)
        team.phase = "idle"
        if team.has_receivers:
            yield from team.report()
        known = robot.raster.revision
        while robot.raster.revision == known and not team.requests.any_pending:
            if not (yield from team.ask_again()):
                yield from team.take((yield done))
        if team.requests.give_way is not None:
            return Event.ASKED
        team.requests.stop = team.requests.link = False
        return Event.CALLED_ON

    def why_done(self) -> str:
        """Return the reason for which the robot is done, in words."""
        robot, progress = self.robot, self.progress
        match progress.state:
            case State.COMPLETE:
                return "no frontier is left that it can reach"
            case State.OUT_OF_TIME:
                return f"{NO_TIME_LEFT} goal and the way home"
            case State.OUT_OF_REACH:
                return NO_CHAIN
        if progress.because is Event.JAMMED:
            return boxed_in_by(progress.jams)
        if robot.is_walled_in and not self._barred(robot):
            return WALLED_IN
        return boxed_in_by(robot.bodies.numbers())
