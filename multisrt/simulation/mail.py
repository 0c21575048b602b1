"""Messages on their way: sent, carried by the radio, and delivered."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Protocol

from multisrt.events import Sent
from multisrt.robots.messages import Message
from multisrt.robots.robot_self import BaseSelf
from multisrt.simulation import plain
from multisrt.simulation.base_station import Base
from multisrt.simulation.clock import Clock
from multisrt.simulation.journal import Journal
from multisrt.simulation.radio import Radio
from multisrt.simulation.robot import Robot
from multisrt.simulation.traffic import Traffic
from multisrt.spec import RadioSpec


class Member(Protocol):
    """What takes part in the radio traffic: a robot, or the base station."""

    @property
    def number(self) -> int:
        """Its number."""

    @property
    def hears(self) -> bool:
        """Whether its radio works."""

    def deliver(self, message: Message) -> None:
        """Take a message that arrives."""


class Mail:
    """Carries messages from robot to robot, and to the base station and from it.

    Parameters
    ----------
    robots : sequence of Robot
        The team.
    radio : Radio
        Which robots a message reaches, and after what time.
    spec : RadioSpec
        How messages travel.
    traffic : Traffic
        Where the robots are.
    base : BaseSelf or None
        The base station, if there is one.
    clock, journal
        Those of the run.

    Attributes
    ----------
    messages_in_flight : int
        How many messages are on their way.
    """

    def __init__(
        self,
        robots: Sequence[Robot],
        radio: Radio,
        spec: RadioSpec,
        traffic: Traffic,
        base: BaseSelf | None,
        *,
        clock: Clock,
        journal: Journal,
    ) -> None:
        self._members: list[Member] = [*robots]
        self._base: Base | None = None
        if base is not None:
            self._base = Base(base, self._send_from_base, clock=clock, journal=journal)
            self._members.append(self._base)
        self._radio = radio
        self._range_m = spec.reach_m
        self._relayed = spec.multi_hop
        self._traffic = traffic
        self._clock = clock
        self._journal = journal
        self.messages_in_flight = 0
        # Positions at one moment, at which many messages are sent.
        self._positions: dict[int, tuple[float, float]] = {}
        self._positions_at_s = -1.0

    def close(self) -> None:
        """Let go of what the base station knows."""
        if self._base is not None:
            self._base.close()

    def _send_from_base(self, message: Message, to: int | None) -> None:
        assert self._base is not None
        self.send(self._base, message, to)

    def send(self, robot: Member, message: Message, to: int | None) -> None:
        """Send a message to one robot, or to all that the radio reaches (None)."""
        to, size_bytes = plain.addressee(to, robot.number), plain.size_bytes(message, robot.number)
        deliveries: list[tuple[int, float]] = []
        lost: list[int] = []
        if robot.hears:
            deliveries, lost = self._deliveries(robot.number, to)
        self._journal.record(
            Sent(
                time_s=self._clock.now_s,
                robot=robot.number,
                kind=message.kind,
                size_bytes=size_bytes,
                reached=tuple(receiver for receiver, _ in deliveries),
                lost=tuple(lost),
            )
        )
        for receiver, delay_s in deliveries:
            if delay_s > 0.0:
                self.messages_in_flight += 1
                self._clock.later(delay_s, partial(self._arrive, self._members[receiver], message))
            else:
                self._members[receiver].deliver(message)

    def _deliveries(self, sender: int, to: int | None) -> tuple[list[tuple[int, float]], list[int]]:
        # Only robots that may be in reach are put to the radio, numbered among themselves.
        if self._radio.reaches_everywhere:
            working = [member.hears for member in self._members]
            return self._radio.deliveries(sender, to, [], working)
        near = self._traffic.may_reach(
            sender,
            self._range_m,
            relayed=self._relayed,
            base=None if self._base is None else self._base.place,
        )
        if to is not None and to not in near:
            return [], []
        delivered, lost = self._radio.deliveries(
            near.index(sender),
            None if to is None else near.index(to),
            [self._position(number) for number in near],
            [self._members[number].hears for number in near],
        )
        return [(near[k], delay) for k, delay in delivered], [near[k] for k in lost]

    def _position(self, robot: int) -> tuple[float, float]:
        if self._base is not None and robot == self._base.number:
            return self._base.place
        if self._positions_at_s != self._clock.now_s:
            self._positions_at_s = self._clock.now_s
            self._positions = {}
        if robot not in self._positions:
            self._positions[robot] = self._traffic.where(robot, self._clock.now_s)[:2]
        return self._positions[robot]

    def _arrive(self, member: Member, message: Message) -> None:
        self.messages_in_flight -= 1
        member.deliver(message)
