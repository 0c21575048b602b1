"""What a robot knows of its team, and how it listens and answers."""

from __future__ import annotations

import math
import weakref
from collections.abc import Iterable
from typing import TYPE_CHECKING

from multisrt.events import TakenAsLost
from multisrt.geometry.bodies.footprint import Footprint
from multisrt.robots.explorer import Note, Send, Sighting
from multisrt.robots.knowledge import Entry, NodeId
from multisrt.robots.listening import Listener, Talk
from multisrt.robots.messages import Message
from multisrt.robots.multi_srt.engagement import are_coupled, group_of
from multisrt.robots.multi_srt.messages import (
    EntriesMessage,
    Key,
    Order,
    OrdersMessage,
    Path,
    Phase,
    RobotState,
    StateMessage,
    WantMessage,
)

if TYPE_CHECKING:
    from multisrt.robots.multi_srt.robot import SrtRobot

ALMOST_NEVER = 1e-4
"""A robot is taken as lost when its silence has at most this probability by the radio's loss."""

SAME_PLACE_M = 0.001
"""A robot that is seen so near to where it said that it stands, stands there."""


class Team(Listener):
    """One robot's side of all talk: its own state as others know it, and theirs as it knows it.

    Parameters
    ----------
    robot : SrtRobot
        Whose.
    """

    ends_pauses_on_time = False

    def __init__(self, robot: SrtRobot) -> None:
        # The robot holds its team: were it held in turn, both would outlive their run.
        self.robot: SrtRobot = weakref.proxy(robot)
        super().__init__(self.robot, robot.me, robot.map.entries, robot.options.ask_period_s)
        self.states: dict[int, RobotState] = {}
        self.heard_s: dict[int, float] = {}
        self.lost: dict[int, None] = {}
        self.unanswered: dict[int, int] = {}
        self.orders: dict[Key, OrdersMessage] = {}
        self.footprints: dict[str, Footprint] = {}
        self.step = 0
        self.phase: Phase = "waiting"
        self.key: Key = ()
        self.path: Path = ()
        self.arrival_s = 0.0
        self.frontier_m = 0.0
        self.waited = 0
        self.troubles = 0.0
        self._said = 0
        self._told: tuple[int, int] = (0, 0)
        self._footprint = str(robot.me.footprint)
        self.rounds = 0
        self.ignored_until_s: dict[int, float] = {}
        self._spoke_s: dict[int, float] = {}
        radio, options = robot.me.radio, robot.options
        if options.silence_timeout_s is not None:
            self.patience = math.ceil(options.silence_timeout_s / self.period_s)
        else:
            unheard = 1.0 - (1.0 - radio.loss) ** 2
            self.patience = (
                math.ceil(math.log(ALMOST_NEVER) / math.log(unheard)) if unheard > 0.0 else 1
            )

    @property
    def hears_all(self) -> bool:
        """Whether every robot hears all that any other says."""
        return self.robot.me.radio.reaches_all

    @property
    def others(self) -> list[int]:
        """The numbers of all other robots."""
        return [number for number in range(self.size) if number != self.number]

    def state_of(self, number: int) -> RobotState:
        """Give what is known of a robot's state; of this one, what it is."""
        return self.state() if number == self.number else self.states[number]

    def footprint(self, number: int) -> Footprint:
        """Give a robot's body."""
        if number == self.number:
            return self.robot.me.footprint
        text = self.states[number].footprint
        if text not in self.footprints:
            self.footprints[text] = Footprint.parse(text)
        return self.footprints[text]

    def gpr(self) -> tuple[int, ...]:
        """Give the group of pre-engaged robots, this one among them."""
        present = self.states.copy()
        for number in (*self.lost, *self.ignored_until_s):
            if self.is_out(number):
                present.pop(number, None)
        present[self.number] = self.state()
        return group_of(self.number, present, are_coupled)

    def is_out(self, number: int) -> bool:
        """Whether a robot is not stepped with: it is lost, or the two could not agree."""
        return number in self.lost or self.ignored_until_s.get(number, 0.0) > self.robot.time_s

    def is_news(self, sighting: Sighting) -> bool:
        """Whether a robot that answers is seen elsewhere than where it said that it stands."""
        state = self.states.get(sighting.robot)
        if state is None or sighting.robot in self.lost or state.phase == "moving":
            return False
        return math.dist(state.place[:2], sighting.configuration[:2]) > SAME_PLACE_M

    def key_of(self, group: Iterable[int]) -> Key:
        """Name a group and the step that it is about to make."""
        steps = {number: state.step for number, state in self.states.items()}
        steps[self.number] = self.step
        return tuple((number, steps[number]) for number in sorted(group))

    def state(self) -> RobotState:
        """Give this robot's own state."""
        robot = self.robot
        return RobotState(
            robot=self.number,
            said=self._said,
            step=self.step,
            phase=self.phase,
            key=self.key,
            path=self.path or ((0.0, *robot.q_act),),
            arrival_s=self.arrival_s,
            node=robot.here,
            frontier_m=self.frontier_m,
            waited=self.waited,
            tree=robot.tree,
            footprint=self._footprint,
            kinematics=robot.me.kinematics,
            range_m=robot.me.range_m,
            have=self._entries.counts(),
        )

    def announce(self, phase: Phase) -> Talk:
        """Tell all who hear it what this robot is at, and what is new in its map."""
        self.phase = phase
        if not self.is_alone:
            yield from self.say()

    def rest(self) -> Talk:
        """Tell that this robot has nothing to do and stands."""
        self.path, self.frontier_m = (), 0.0
        yield from self.announce("idle")

    def say(self, *, to: int | None = None, ask: bool = False, asked: tuple[int, ...] = ()) -> Talk:
        """Send the own state; to all, with the entries that were not told yet."""
        self._said += 1
        entries: tuple[Entry, ...] = ()
        if to is None:
            known = self._entries.have()
            entries = self._entries.lacks({**known, self.number: self._told})
            self._told = known.get(self.number, (0, 0))
        states = self._vouched(to)
        yield Send(
            StateMessage(sender=self.number, states=states, ask=ask, asked=asked, entries=entries),
            to,
        )

    def begin_step(self) -> Talk:
        """Tell that this robot is about to make a step; one that comes late asks everybody."""
        late = not self.states and self.robot.time_s > 0.0
        self.path = ()
        self.phase = "waiting"
        if not self.is_alone:
            yield from self.say(ask=not self.hears_all, asked=tuple(self.others) if late else ())
            # What came meanwhile is heard first, and who was asked has time to answer.
            yield from self.pause(0.0 if self.hears_all and not late else self.round_trip_s)

    def ask(self, pending: Iterable[int]) -> Talk:
        """Ask those who have not said what is waited for; who never answers is taken as lost."""
        asked = tuple(pending)
        for number in asked:
            self.unanswered[number] = self.unanswered.get(number, 0) + 1
            if self.unanswered[number] > self.patience:
                self.unanswered[number] = 0
                self.lost[number] = None
                yield Note(TakenAsLost(time_s=self.robot.time_s, robot=self.number, other=number))
        yield from self.say(asked=asked)

    def news(self) -> tuple[object, ...]:
        """Give something that changes when another robot's doing or the map has changed."""
        doing = tuple((n, self.states[n].tree, n in self.lost) for n in sorted(self.states))
        return doing, self._entries.counts()

    def order_for_me(self) -> Order | None:
        """Give what a master told this robot for the step that it is about to make."""
        for key, orders in self.orders.items():
            if (self.number, self.step) in key:
                return orders.order_for(self.number)
        return None

    def _merge(self, entries: tuple[Entry, ...]) -> tuple[NodeId, ...]:
        return self.robot.map.merge(entries)

    def _vouched(self, to: int | None) -> tuple[RobotState, ...]:
        # Who asks may have been out of reach for a while: it is told of all members of the
        # group. Where nobody relays, they always tell of one another.
        own = self.state()
        if self.hears_all or (to is None and self.robot.me.radio.multi_hop):
            return (own,)
        # Nobody vouches for whom it has not itself heard lately: the dead would live on.
        lately = self.robot.time_s - self.patience * self.period_s
        members = (number for number, _ in self.key if number != self.number)
        return (
            own,
            *(
                self.states[n]
                for n in members
                if n not in self.lost and self._spoke_s.get(n, -math.inf) >= lately
            ),
        )

    def _take_message(self, message: Message) -> Talk:
        match message:
            case StateMessage():
                for state in message.states:
                    self._take_state(state, message.sender)
                if message.entries:
                    yield from self.learn(message.entries)
                own = message.states[0]
                if self.number in message.asked or (message.ask and self._concerns_me(own)):
                    yield from self._answer(own)
                if own.have != self._entries.counts():
                    yield from self._ask_for_what_lacks(own.robot, own.have)
            case WantMessage():
                yield from self._answer_want(message)
            case EntriesMessage():
                self._heard(message.sender)
                yield from self.learn(message.entries)
            case OrdersMessage():
                self._heard(message.sender)
                concerns_me = message.order_for(self.number) is not None
                if (self.number, self.step) in message.key and concerns_me:
                    self.orders = {message.key: message}

    def _take_state(self, state: RobotState, sender: int) -> None:
        number = state.robot
        if number == self.number:
            return
        if number == sender:
            self._spoke_s[number] = self.robot.time_s
        known = self.states.get(number)
        if known is None or state.said >= known.said:
            self.states[number] = state
            self._heard(number)
            if state.phase == "moving":
                self.robot.avoided.pop(number, None)

    def _heard(self, number: int) -> None:
        self.heard_s[number] = self.robot.time_s
        self.lost.pop(number, None)
        self.unanswered[number] = 0
        self.robot.bodies.pop(number, None)

    def _concerns_me(self, asker: RobotState) -> bool:
        return any(number == self.number for number, _ in asker.key) or are_coupled(
            asker, self.state()
        )

    def _answer(self, asker: RobotState) -> Talk:
        yield from self.say(to=asker.robot)
        orders = self.orders.get(asker.key)
        if orders is not None and orders.sender == self.number:
            yield Send(orders, asker.robot)
