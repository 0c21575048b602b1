"""What a robot knows of its team, and how it listens and answers."""

from __future__ import annotations

import math
from collections.abc import Generator, Iterable
from typing import TYPE_CHECKING

from multisrt.events import Learned, TakenAsLost
from multisrt.exploration_map import Closing, Node
from multisrt.explorer import Action, Moved, Note, Outcome, Receive, Received, Send, TimedOut
from multisrt.geometry.footprint import Footprint
from multisrt.multi_srt.engagement import are_coupled, group_of
from multisrt.multi_srt.messages import (
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
    from multisrt.multi_srt.robot import SrtRobot

Talk = Generator[Action, Outcome, None]
Heard = Generator[Action, Outcome, Moved | None]

ALMOST_NEVER = 1e-4
"""A robot is taken as lost when its silence has at most this probability by the radio's loss."""


class Team:
    """One robot's side of all talk: its own state as others know it, and theirs as it knows it.

    Parameters
    ----------
    robot : SrtRobot
        Whose.
    """

    def __init__(self, robot: SrtRobot) -> None:
        self.robot = robot
        self.number = robot.me.robot
        self.size = robot.me.team
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
        self.rounds = 0
        self.ignored_until_s: dict[int, float] = {}
        self._wanted: dict[int, float] = {}
        self._spoke_s: dict[int, float] = {}
        radio, options = robot.me.radio, robot.options
        self.round_trip_s = 2.0 * radio.latency_s
        self.period_s = options.ask_period_s + self.round_trip_s
        if options.silence_timeout_s is not None:
            self.patience = math.ceil(options.silence_timeout_s / self.period_s)
        else:
            unheard = 1.0 - (1.0 - radio.loss) ** 2
            self.patience = (
                math.ceil(math.log(ALMOST_NEVER) / math.log(unheard)) if unheard > 0.0 else 1
            )

    @property
    def is_alone(self) -> bool:
        """Whether the team is this robot."""
        return self.size == 1

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
        present = {n: s for n, s in self.states.items() if not self.is_out(n)}
        present[self.number] = self.state()
        return group_of(self.number, present, are_coupled)

    def is_out(self, number: int) -> bool:
        """Whether a robot is not stepped with: it is lost, or the two could not agree."""
        return number in self.lost or self.ignored_until_s.get(number, 0.0) > self.robot.time_s

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
            footprint=str(robot.me.footprint),
            kinematics=robot.me.kinematics,
            range_m=robot.me.range_m,
            have=self._have(),
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
        entries: tuple[Node | Closing, ...] = ()
        if to is None:
            nodes, closings = self._told
            have = dict(self.robot.map.have())
            have[self.number] = nodes, closings
            if self.robot.map.knows_more_than(have):
                entries = self.robot.map.lacks(have)
                self._told = self.robot.map.have().get(self.number, (0, 0))
        states = self._vouched(to)
        yield Send(
            StateMessage(sender=self.number, states=states, ask=ask, asked=asked, entries=entries),
            to,
        )

    def hear(self, timeout_s: float | None = 0.0) -> Heard:
        """Receive until a motion ends, something was heard, or time is up; answer questions.

        Returns
        -------
        Moved or None
            The end of the motion that went on.
        """
        outcome = yield Receive(timeout_s)
        return (yield from self.take(outcome))

    def take(self, outcome: Outcome) -> Heard:
        """Take in what came, and answer."""
        if isinstance(outcome, Moved):
            return outcome
        assert isinstance(outcome, Received | TimedOut)
        self.robot.time_s = outcome.time_s
        if isinstance(outcome, Received):
            for message in outcome.messages:
                yield from self._take_message(message)
        return None

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
                self.robot.believe_to_stand(number)
                yield Note(TakenAsLost(time_s=self.robot.time_s, robot=self.number, other=number))
        yield from self.say(asked=asked)

    def pause(self, seconds: float) -> Talk:
        """Let time pass, and listen meanwhile; no time: until all has come that comes now."""
        until = self.robot.time_s + seconds
        while True:
            outcome = yield Receive(max(0.0, until - self.robot.time_s))
            yield from self.take(outcome)
            if isinstance(outcome, TimedOut):
                return

    def news(self) -> tuple[object, ...]:
        """Give something that changes when another robot's doing or the map has changed."""
        doing = tuple((n, self.states[n].tree, n in self.lost) for n in sorted(self.states))
        return doing, tuple(self.robot.map.have().items())

    def order_for_me(self) -> Order | None:
        """Give what a master told this robot for the step that it is about to make."""
        for key, orders in self.orders.items():
            if (self.number, self.step) in key:
                return orders.order_for(self.number)
        return None

    def _have(self) -> tuple[tuple[int, int, int], ...]:
        return tuple((robot, *counts) for robot, counts in self.robot.map.have().items())

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

    def _take_message(self, message: object) -> Talk:
        match message:
            case StateMessage():
                for state in message.states:
                    self._take_state(state, message.sender)
                yield from self.learn(message.entries)
                own = message.states[0]
                if self.number in message.asked or (message.ask and self._concerns_me(own)):
                    yield from self._answer(own)
                yield from self._ask_for_what_lacks(own)
            case WantMessage():
                have = {robot: (nodes, closings) for robot, nodes, closings in message.have}
                entries = self.robot.map.lacks(have)
                if entries:
                    yield Send(EntriesMessage(sender=self.number, entries=entries), message.sender)
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

    def _ask_for_what_lacks(self, state: RobotState) -> Talk:
        mine = self.robot.map.have()
        for robot, nodes, closings in state.have:
            known = mine.get(robot, (0, 0))
            if nodes > known[0] or closings > known[1]:
                if self.robot.time_s >= self._wanted.get(robot, -math.inf) + self.period_s:
                    self._wanted[robot] = self.robot.time_s
                    yield Send(WantMessage(sender=self.number, have=self._have()), state.robot)
                return

    def learn(self, entries: tuple[Node | Closing, ...]) -> Talk:
        """Merge entries of other robots' maps."""
        if not entries:
            return
        new = self.robot.map.merge(entries)
        if new:
            yield Note(Learned(time_s=self.robot.time_s, robot=self.number, nodes=new))
