"""How a robot communicates with its team: what it reports of itself, and what it answers."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass

from multisrt.events import PresumedLost
from multisrt.geometry.bodies.footprint import Footprint
from multisrt.robots.exploration_map import ExplorationMap
from multisrt.robots.explorer import Note, RobotSelf, Send, Steps
from multisrt.robots.knowledge import Entry, NodeId
from multisrt.robots.listening import Listener
from multisrt.robots.messages import Message
from multisrt.robots.multi_srt.groups import are_coupled, group_of
from multisrt.robots.multi_srt.messages import (
    EntriesMessage,
    Key,
    NoPlaceMessage,
    Order,
    OrdersMessage,
    Path,
    Phase,
    RobotState,
    StateMessage,
    WantMessage,
)
from multisrt.robots.multi_srt.options import MultiSrtOptions
from multisrt.robots.multi_srt.roster import Roster
from multisrt.robots.multi_srt.whereabouts import Whereabouts


@dataclass(slots=True)
class Status:
    """What a robot reports to its team of its present step; see `RobotState` for the fields."""

    step: int = 0
    phase: Phase = "waiting"
    key: Key = ()
    path: Path = ()
    arrival_s: float = 0.0
    frontier_m: float = 0.0
    waited: int = 0


class Team(Listener):
    """One robot's side of all talk.

    Parameters
    ----------
    me : RobotSelf
        What the robot knows of itself.
    options : MultiSrtOptions
        Its parameters.
    at : Whereabouts
        Where it is; its clock is set by what is heard.
    known : ExplorationMap
        Its map.
    roster : Roster
        What it knows of the others.

    Attributes
    ----------
    status : Status
        What it reports of its present step.
    orders : OrdersMessage or None
        The newest orders of a master.
    without_place : Counter of NodeId
        How often robots of the same body and drive have found no place for a target at a node.
    """

    ends_pauses_on_time = False

    def __init__(
        self,
        me: RobotSelf,
        options: MultiSrtOptions,
        at: Whereabouts,
        known: ExplorationMap,
        roster: Roster,
    ) -> None:
        super().__init__(at, me, known.entries, options.ask_period_s)
        self.me = me
        self.at = at
        self.roster = roster
        self.status = Status()
        self.orders: OrdersMessage | None = None
        self.without_place: Counter[NodeId] = Counter()
        self._map = known
        self._said = 0
        self._told: tuple[int, int] = (0, 0)

    @property
    def hears_all(self) -> bool:
        """Whether every robot hears all that any other says."""
        return self.me.radio.reaches_all

    @property
    def others(self) -> list[int]:
        """The numbers of all other robots."""
        return [number for number in range(self.size) if number != self.number]

    @property
    def companions(self) -> list[int]:
        """The numbers of the other robots of the group of this step."""
        return [number for number, _ in self.status.key if number != self.number]

    # The group ---------------------------------------------------------------------------

    def state_of(self, number: int) -> RobotState:
        """Return the last known state of a robot; of this one, the present state."""
        return self.state() if number == self.number else self.roster.states[number]

    def footprint(self, number: int) -> Footprint:
        """Return the footprint of a robot."""
        return self.me.footprint if number == self.number else self.roster.footprint(number)

    def gpr(self) -> tuple[int, ...]:
        """Return the group of pre-engaged robots, this one among them."""
        return group_of(
            self.number, {**self.roster.present(), self.number: self.state()}, are_coupled
        )

    def key_of(self, group: Iterable[int]) -> Key:
        """Return the name of a group for the step that it is about to make."""
        states = self.roster.states
        return tuple(
            (number, self.status.step if number == self.number else states[number].step)
            for number in sorted(group)
        )

    def has_regrouped(self) -> bool:
        """Whether the GPR, or the step of a member, has changed since the key was set."""
        return self.key_of(self.gpr()) != self.status.key

    @property
    def order_message(self) -> OrdersMessage | None:
        """The orders for the step that the group is about to make, if they have come."""
        orders = self.orders
        return orders if orders is not None and orders.key == self.status.key else None

    def order_for_me(self) -> Order | None:
        """Return what a master has ordered this robot for its present step, or None."""
        orders = self.orders
        if orders is None or (self.number, self.status.step) not in orders.key:
            return None
        return orders.order_for(self.number)

    # What is sent ------------------------------------------------------------------------

    def state(self) -> RobotState:
        """Return this robot's own state."""
        status, at = self.status, self.at
        return RobotState(
            robot=self.number,
            said=self._said,
            step=status.step,
            phase=status.phase,
            key=status.key,
            path=status.path or ((0.0, *at.q_act),),
            arrival_s=status.arrival_s,
            node=at.here,
            frontier_m=status.frontier_m,
            waited=status.waited,
            tree=at.tree,
            footprint=str(self.me.footprint),
            kinematics=self.me.kinematics,
            range_m=self.me.range_m,
            have=self._entries.counts(),
        )

    def announce(self, phase: Phase) -> Steps:
        """Tell the team which phase of its step this robot has reached, and what its map gained."""
        self.status.phase = phase
        if self.has_receivers:
            yield from self.say()

    def rest(self) -> Steps:
        """Announce that this robot stands and has nothing to do."""
        self.status.path, self.status.frontier_m = (), 0.0
        yield from self.announce("idle")

    def say(
        self, *, to: int | None = None, ask: bool = False, asked: tuple[int, ...] = ()
    ) -> Steps:
        """Send this robot's state, to all with the map entries that were not sent yet.

        Parameters
        ----------
        to : int or None
            The recipient; None: all.
        ask : bool
            Whether robots that this one may meet in its next step are to answer.
        asked : tuple of int
            Robots that are to answer in any case.
        """
        self._said += 1
        entries: tuple[Entry, ...] = ()
        if to is None:
            known = self._entries.have()
            entries = self._entries.missing_from({**known, self.number: self._told})
            self._told = known.get(self.number, (0, 0))
        # A robot that asks may have been out of reach: it receives the states of the whole group.
        # Without relays, robots always report one another.
        relayed = self.hears_all or (to is None and self.me.radio.multi_hop)
        others = () if relayed else self.roster.vouched(self.companions)
        yield Send(
            StateMessage(
                sender=self.number,
                states=(self.state(), *others),
                ask=ask,
                asked=asked,
                entries=entries,
            ),
            to,
        )

    def tell_no_place(self, node: NodeId) -> Steps:
        """Tell the team that there was no place for a target at a node."""
        self.without_place[node] += 1
        if not self.is_alone:
            yield Send(NoPlaceMessage(sender=self.number, node=node))

    def begin_step(self) -> Steps:
        """Tell that this robot is about to make a step; a robot that comes late asks everybody."""
        is_late = not self.roster.states and self.at.time_s > 0.0
        self.status.path = ()
        self.status.phase = "waiting"
        if self.has_receivers:
            asked = tuple(self.others) if is_late else ()
            asks = not (self.is_alone or self.hears_all)
            yield from self.say(ask=asks, asked=asked)
            # Messages that have come are read first, and robots that are asked have time to answer.
            yield from self.pause(self.round_trip_s if asks or asked else 0.0)

    def ask(self, pending: Iterable[int]) -> Steps:
        """Ask robots for their states; those that never answer are presumed lost."""
        asked = tuple(pending)
        for number in asked:
            if self.roster.is_lost_when_asked(number):
                yield Note(PresumedLost(time_s=self.at.time_s, robot=self.number, other=number))
        yield from self.say(asked=asked)

    def news(self) -> tuple[object, ...]:
        """Return a value that changes with the trees of other robots and with the map."""
        states, lost = self.roster.states, self.roster.lost
        return (
            tuple((n, states[n].tree, n in lost) for n in sorted(states)),
            self._entries.counts(),
        )

    # What is heard -----------------------------------------------------------------------

    def _merge(self, entries: tuple[Entry, ...]) -> tuple[NodeId, ...]:
        return self._map.merge(entries)

    def _take_message(self, message: Message) -> Steps:
        match message:
            case StateMessage():
                for state in message.states:
                    self.roster.take(state, message.sender)
                if message.entries:
                    yield from self.learn(message.entries)
                own = message.states[0]
                if self.number in message.asked or (message.ask and self._concerns_me(own)):
                    yield from self._answer(own)
                if own.have != self._entries.counts():
                    yield from self._ask_for_missing(own.robot, own.have)
            case WantMessage():
                yield from self._answer_want(message)
            case EntriesMessage():
                self.roster.hear_from(message.sender)
                yield from self.learn(message.entries)
            case NoPlaceMessage():
                self.roster.hear_from(message.sender)
                if self._moves_like_me(message.sender):
                    self.without_place[message.node] += 1
            case OrdersMessage():
                self.roster.hear_from(message.sender)
                concerns_me = message.order_for(self.number) is not None
                if (self.number, self.status.step) in message.key and concerns_me:
                    self.orders = message

    def _moves_like_me(self, number: int) -> bool:
        state = self.roster.states.get(number)
        return state is not None and (state.footprint, state.kinematics) == (
            str(self.me.footprint),
            self.me.kinematics,
        )

    def _concerns_me(self, asker: RobotState) -> bool:
        return any(number == self.number for number, _ in asker.key) or are_coupled(
            asker, self.state()
        )

    def _answer(self, asker: RobotState) -> Steps:
        yield from self.say(to=asker.robot)
        orders = self.orders
        if orders is not None and orders.key == asker.key and orders.sender == self.number:
            yield Send(orders, asker.robot)
