"""One robot's side of the conversation: what it says of itself, and what it does when it hears."""

from __future__ import annotations

import math
from collections.abc import Callable, Generator
from dataclasses import dataclass, field

from multisrt.planners.navigation.right_of_way import Claim, leader_of
from multisrt.robots.explorer import (
    Action,
    Outcome,
    Receive,
    RobotSelf,
    Send,
    Steps,
    TimedOut,
)
from multisrt.robots.frontier.assignments import Assignments
from multisrt.robots.frontier.bodies import Bodies
from multisrt.robots.frontier.course import Course
from multisrt.robots.frontier.frontiers import Frontiers
from multisrt.robots.frontier.goal import Place
from multisrt.robots.frontier.messages import (
    AssignmentMessage,
    ChainLink,
    GiveWayMessage,
    InaccessibleMessage,
    Phase,
    ReportMessage,
    RobotReport,
    StopMessage,
    SwapMessage,
)
from multisrt.robots.frontier.options import FrontierOptions
from multisrt.robots.frontier.requests import Requests
from multisrt.robots.frontier.scan_map import ScanMap
from multisrt.robots.frontier.teammates import Teammates
from multisrt.robots.homing.pairs import Pair, ReadyMessage, RendezvousMessage
from multisrt.robots.knowledge import EntriesMessage, Entry, Node, NodeId, WantMessage
from multisrt.robots.listening import Listener, counts_beyond, have_of
from multisrt.robots.messages import Message

LATELY_PERIODS = 2.0
"""Number of question periods for which a robot counts as having asked just now."""

TOUCH_PERIODS = 2.0
"""Number of report periods for which a robot that was heard counts as in touch."""

SAME_GOAL_M = 1e-9
"""Goals closer than this are the same."""


@dataclass(slots=True)
class SharedCells:
    """The state that robots with the rules of Álvarez agree on.

    Attributes
    ----------
    aim : (x, y) or None
        The unexplored cell for whose sake this robot goes where it goes.
    leader : bool
        Whether it leads where robots meet.
    inaccessible : dict of (x, y) to dict of int
        For every cell, the robots that found no path to it.
    tried : dict of (x, y)
        Places at the edge of the known area where this robot, or one no larger, learnt nothing.
    """

    aim: Place | None = None
    leader: bool = False
    inaccessible: dict[Place, dict[int, None]] = field(default_factory=dict)
    tried: dict[Place, None] = field(default_factory=dict)


@dataclass(slots=True)
class StopSignals:
    """The stop signals that a robot has sent (SBX-R).

    Attributes
    ----------
    open_goals : dict of int to (x, y)
        Goals of others that were frontiers when this robot last looked.
    settled : dict of int to (x, y)
        Goals of others that were explored, by this robot or another.
    ended_s : float
        When this robot told all others that it knows no frontier any more.
    """

    open_goals: dict[int, Place] = field(default_factory=dict)
    settled: dict[int, Place] = field(default_factory=dict)
    ended_s: float = -math.inf


def link_of(report: RobotReport, robot: int) -> Place | None:
    """Return where a robot is to stand as a relay of another one; None if it is not called."""
    return next((link.place for link in report.links or () if link.robot == robot), None)


class Team(Listener):
    """Messages of one robot to its team, and from it.

    Parameters
    ----------
    me : RobotSelf
        What the robot knows of itself.
    options : FrontierOptions
        Its parameters.
    course : Course
        Where it is; its clock is set by what is heard.
    map : ScanMap
        What it knows; extended by what others send.
    bodies : Bodies
        The bodies in its way; those that are heard from are no longer presumed lost.
    frontiers : Frontiers
        Its targets; places that others tried without result are given up.

    Attributes
    ----------
    teammates : Teammates
        The reports of the others.
    requests : Requests
        What the others want from this robot.
    cells : SharedCells
        What is agreed on by the rules of Álvarez.
    phase : {"choosing", "driving", "idle"}
        What this robot says that it is doing.
    asked_s : dict of int to float
        When this robot last asked others to give way.
    reported_s : float
        When it last reported to all.
    assignments : Assignments
        Utility: the goals that it has assigned to others as their leader.
    answer : callable or None
        Utility: answers a robot, given its number, that wants a goal from this one.
    stops : StopSignals
        Self-bidding: which stop signals it has sent.
    pair : Pair or None
        What this robot does in its pair, if the robots go in pairs of explorer and relay.
    links : tuple of ChainLink or None
        The relays that this robot needs as the front of a chain; None if it is not one.
    passes_front : bool
        Whether it found nothing to do as the front of a chain.
    """

    ends_pauses_on_time = True

    def __init__(
        self,
        me: RobotSelf,
        options: FrontierOptions,
        course: Course,
        map: ScanMap,
        bodies: Bodies,
        frontiers: Frontiers,
    ) -> None:
        super().__init__(course, me, map.entries, options.ask_period_s)
        self.teammates = Teammates(me.robot, options.lost_after_s, options.relay_for_s)
        self.requests = Requests()
        self.cells = SharedCells()
        self.phase: Phase = "choosing"
        self.asked_s: dict[int, float] = {}
        self.reported_s = -math.inf
        self.assignments = Assignments(me.robot, self.period_s)
        self.answer: Callable[[int], Steps] | None = None
        self.stops = StopSignals()
        self.pair: Pair | None = None
        self.links: tuple[ChainLink, ...] | None = None
        self.passes_front = False
        self._answers = options.answers
        self._report_period_s = options.report_period_s
        self._tells_speed = options.home in ("relays", "chain")
        self._me = me
        self._course = course
        self._map = map
        self._bodies = bodies
        self._frontiers = frontiers
        self._reports_made = 0
        # Serial number of the first node of its own that is not yet part of a report.
        self._unreported = 0
        self._offered_s: dict[int, float] = {}

    @property
    def is_in_touch(self) -> bool:
        """Whether the base station was heard lately: it acknowledges data at once."""
        return self._is_recent(self.base_heard_s)

    @property
    def has_nothing_overdue(self) -> bool:
        """Whether the robot is in touch, or carries only nodes that may still be acknowledged.

        A base station that has nothing new to acknowledge is not heard for a long time.
        """
        if self.is_in_touch:
            return True
        return all(
            isinstance(entry, Node)
            and entry.id.robot == self.number
            and self._is_recent(entry.time_s)
            for entry in self.carried()
        )

    def hears(self, robot: int) -> bool:
        """Whether another robot was heard lately."""
        return self._is_recent(self.teammates.last_heard_s(robot))

    def _is_recent(self, heard_s: float) -> bool:
        return self._course.time_s <= heard_s + TOUCH_PERIODS * self._report_period_s

    def present(self) -> list[RobotReport]:
        """Return the reports of the robots to take into account; see `Teammates.present`."""
        return self.teammates.present(self._course.time_s)

    def own_report(self) -> RobotReport:
        """Return what this robot says of itself."""
        course = self._course
        goal = course.goal
        return RobotReport(
            robot=self.number,
            said=self._reports_made,
            time_s=course.time_s,
            phase=self.phase,
            place=(*course.now_at(),),
            goal=None if goal is None else goal.place,
            remaining_m=course.remaining_m(),
            path=() if goal is None else tuple(map(tuple, goal.path.tolist())),
            footprint=str(self._me.footprint),
            have=self._entries.counts(),
            aim=self.cells.aim,
            leader=self.cells.leader,
            links=self.links,
            passes_front=self.passes_front,
            speed_m_s=self._me.kinematics.speed_m_s if self._tells_speed else None,
        )

    def report(
        self,
        *,
        asks: bool = False,
        wants_goal: bool = False,
        to: int | None = None,
        answers: bool = False,
    ) -> Steps:
        """Send a report.

        Parameters
        ----------
        asks : bool
            Whether to ask for reports in return.
        wants_goal : bool
            Whether to ask the leader for a goal.
        to : int or None
            The robot that it is for. None: all; the report then carries the new nodes.
        answers : bool
            Whether it answers a question for reports.
        """
        self._reports_made += 1
        entries: tuple[Node, ...] = ()
        if to is None:
            own = self._entries
            have = {**own.have(), self.number: (self._unreported, 0)}
            entries = tuple(e for e in own.missing_from(have) if isinstance(e, Node))
            self._unreported = own.have().get(self.number, (0, 0))[0]
            self.reported_s = self._course.time_s
        yield Send(
            ReportMessage(
                sender=self.number,
                reports=(self.own_report(), *self._passed_on(answers)),
                asks=asks,
                wants_goal=wants_goal,
                entries=entries,
            ),
            to,
        )

    def deliver(self) -> Steps:
        """Report, and ask the base station what it has: an acknowledgement may have been lost."""
        yield from self.report()
        yield from self.ask_base()

    def await_assignment(self) -> Generator[Action, Outcome, AssignmentMessage | None]:
        """Listen until the leader's assignment is heard, for at most the period of questions."""
        until = self._course.time_s + self.period_s
        while self.requests.assignment is None:
            outcome = yield Receive(max(0.0, until - self._course.time_s))
            yield from self.take(outcome)
            if isinstance(outcome, TimedOut):
                break
        return self.requests.assignment

    def _merge(self, entries: tuple[Entry, ...]) -> tuple[NodeId, ...]:
        return self._map.merge(entries)

    def _passed_on(self, answers: bool) -> tuple[RobotReport, ...]:
        """Return the reports of others to pass on with an answer or another report."""
        if answers and self._answers == "known":
            return tuple(self.present())
        # Where a radio relays messages, or reaches all, who is in contact hears the others anyway.
        radio = self._me.radio
        if radio.multi_hop or radio.reaches_all:
            return ()
        return tuple(self.teammates.worth_relaying(self._course.time_s))

    def _take_message(self, message: Message) -> Steps:
        self.teammates.heard_s[message.sender] = self._course.time_s
        self._bodies.note_heard(message.sender)
        match message:
            case ReportMessage():
                yield from self._take_reports(message)
            case WantMessage():
                yield from self._answer_want(message)
            case EntriesMessage():
                yield from self.learn(message.entries)
            case GiveWayMessage():
                if not self._goes_first(message):
                    self.requests.give_way = message
                yield from self.report(to=message.sender)
            case StopMessage():
                self._take_stop(message)
            case AssignmentMessage():
                self.requests.assignment = message
            case ReadyMessage():
                if self.pair is not None:
                    self._take_ready(self.pair)
            case RendezvousMessage():
                if self.pair is not None:
                    yield from self._take_rendezvous(self.pair, message)
            case InaccessibleMessage():
                self._take_inaccessible(message)
            case SwapMessage():
                if self.cells.aim == message.taken:
                    self.cells.aim = message.given

    def _take_reports(self, message: ReportMessage) -> Steps:
        for report in message.reports:
            self._note_chain(report)
            self.teammates.take(report)
        if message.entries:
            yield from self.learn(message.entries)
        if message.wants_goal and self.answer is not None:
            yield from self.answer(message.sender)
        own = message.reports[0]
        if message.asks or self._take_report_turn(own):
            yield from self.report(to=message.sender, answers=message.asks)
        if own.have != self._entries.counts():
            yield from self._ask_for_missing(own.robot, own.have)
        yield from self._tell_ready(own)

    def _note_chain(self, report: RobotReport) -> None:
        """Stop for the front of a chain that calls this robot elsewhere, lets it go, or ends."""
        known = self.teammates.reports.get(report.robot)
        # Others pass on what this robot said itself, too.
        is_old = known is not None and report.said < known.said
        if is_old or report.robot == self.number:
            return
        before = None if known is None else link_of(known, self.number)
        if link_of(report, self.number) != before:
            self.requests.link = True
        has_passed = known is not None and known.passes_front
        if report.passes_front and not has_passed:
            self.requests.link = True
        elif has_passed and not report.passes_front and report.robot < self.number:
            # All had nothing to do, and the first has a goal again: so may this one after it.
            self.passes_front = False

    def _take_rendezvous(self, pair: Pair, message: RendezvousMessage) -> Steps:
        if message.accepts:
            pair.take_acceptance(message)
            return
        lacks = counts_beyond(message.have, self._entries.have())
        if lacks:
            # The explorer proposes it again.
            yield from self._ask_for_missing(message.sender, message.have)
            return
        if not pair.accept(message):
            return
        answer = RendezvousMessage(
            sender=self.number,
            rendezvous=message.rendezvous,
            have=self._entries.counts(),
            accepts=True,
        )
        yield Send(answer, message.sender)

    def _tell_ready(self, report: RobotReport) -> Steps:
        """Tell the explorer of the pair that its relay is here, for its data or as it is time."""
        pair, now_s = self.pair, self._course.time_s
        if pair is None or report.robot != pair.partner:
            return
        # Before that time it interrupts its explorer only for their first agreement, or for data
        # that would not reach the base station otherwise.
        radio = self._me.radio
        is_linked = (radio.multi_hop or radio.reaches_all) and self.is_in_touch
        has_news = not is_linked and counts_beyond(report.have, self.base_has)
        if (has_news or pair.is_due(now_s)) and pair.take_ready_turn(now_s, self.period_s):
            ready = ReadyMessage(sender=self.number, number=pair.rendezvous.number)
            yield Send(ready, report.robot)

    def _take_ready(self, pair: Pair) -> None:
        """Meet the relay, which is here; not before the time if the base station hears all."""
        is_heard = self.is_in_touch and not self.carries
        is_early = pair.is_paired and not pair.is_due(self._course.time_s)
        if pair.may_meet and not (is_heard and is_early):
            self.requests.meet = True

    def _take_stop(self, message: StopMessage) -> None:
        goal = self._course.goal
        if goal is None:
            return
        if message.goal is None or math.dist(goal.place, message.goal) < SAME_GOAL_M:
            self.requests.stop = True

    def _take_inaccessible(self, message: InaccessibleMessage) -> None:
        for cell in message.cells:
            self.cells.inaccessible.setdefault(cell, {})[message.sender] = None
        if message.radius_m <= self._me.footprint.circumscribed_radius_m:
            for place in message.tried:
                self.cells.tried[place] = None
                self._frontiers.give_up(place)

    def _goes_first(self, asked: GiveWayMessage) -> bool:
        """Whether this robot, of two that asked each other to give way, goes first.

        The robot that asked first does; of two that asked at about the same time, the one of the
        lower number, unless the other has no place to give way to.
        """
        lately_s = self._course.time_s - LATELY_PERIODS * self.period_s
        has_asked = self.asked_s.get(asked.sender, -math.inf) >= lately_s
        own = Claim(self.number, leader=has_asked)
        other = Claim(asked.sender, leader=True, cornered=asked.firm)
        return leader_of([own, other]) == self.number

    def _take_report_turn(self, report: RobotReport) -> bool:
        """Return whether to report to a robot that lacks nodes, and if so note the time.

        A robot with nothing to do does not report unasked, so the other would not hear of them.
        """
        if self.phase != "idle":
            return False
        offered_s = self._offered_s.get(report.robot, -math.inf)
        lately = self._course.time_s < offered_s + self.period_s
        if lately or not self._entries.has_more_than(have_of(report.have)):
            return False
        self._offered_s[report.robot] = self._course.time_s
        return True
