"""Pairs of an explorer and a relay that meet at agreed places: the state that a robot keeps of it.

Robots 0 and 1 are a pair, 2 and 3 the next, and so on: the first of them explores, the second
carries its data to the base station. The last robot of an odd team explores alone. Whenever a pair
meets, it agrees on its next *rendezvous*: a place, which is where the explorer goes next; a time by
which the relay can have been home and there; and a backup place, which is the place of the present
rendezvous. The first place is that of the base station, which all robots know; a pair in contact
agrees on the next as soon as its relay knows a path home.

Both robots drive to the place, the explorer in time and the relay once it has delivered. They wait
there until a while after the agreed time, and then at the backup place. A robot whose partner comes
to neither presumes it lost and continues alone, which makes an explorer of a relay; so no robot
waits forever. When such a relay hears its explorer again, the two are a pair again as soon as they
agree on a rendezvous. The states below are those of `Stage`, but for `ALONE`, which is a `Role`::

               set out            partner missed           partner missed
    UNTIL_DUE ---------> PLACE -------------------> BACKUP ---------------> ALONE
        ^                  |                           |
        +------------------+-- met: next rendezvous ---+

A robot is in `UNTIL_DUE` while it explores, or as a relay while it delivers. A relay begins in
`PLACE`. Where the backup place is the place itself, `BACKUP` is left out. An explorer that is done,
or for which the time limit leaves no other rendezvous, tells its relay so when they meet, and both
continue alone for good.

A pair meets by radio. A relay on its way to the rendezvous that hears its explorer tells it that it
is ready. A relay that knows no path home explores like any robot, and accepts no data. The explorer
chooses its next goal and proposes a rendezvous there, again and again until the relay has all that
the explorer knows, and accepts. Both then keep the new rendezvous. If the acceptance is lost, the
explorer keeps the previous one; the relay looks for it at that place in the end, as it is the
backup place of the new one.

Source: J. de Hoog, S. Cameron and A. Visser, Role-based autonomous multi-robot exploration,
COGNITIVE 2009, and Selection of rendezvous points for multi-robot exploration in dynamic
environments, AAMAS workshop ARMS 2010; V. Spirin, S. Cameron and J. de Hoog, Time preference for
information in multi-agent exploration with limited communication, TAROS 2013, for the backup and
the limits. Differs in: the rendezvous is at the explorer's next goal, and not at the place of a
skeleton that is best for the team; the hierarchy has two levels; roles are not swapped.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from enum import Enum, auto
from typing import ClassVar

import msgspec

from multisrt.robots.homing.contact import Place
from multisrt.robots.knowledge import Counts
from multisrt.robots.messages import Message


class Rendezvous(msgspec.Struct, frozen=True, kw_only=True):
    """Place and time at which a pair meets next.

    Attributes
    ----------
    number : int
        Serial number among the proposals of the explorer.
    place : (x, y)
        Place in metres.
    backup : (x, y)
        Place in metres where they meet if one of them did not come to the first.
    due_s : float
        Time in seconds.
    """

    number: int
    place: Place
    backup: Place
    due_s: float


class ReadyMessage(Message, frozen=True, kw_only=True):
    """A relay tells its explorer that it can take its data.

    Attributes
    ----------
    number : int
        Number of the rendezvous that it keeps.
    """

    kind: ClassVar[str] = "ready"

    number: int

    @property
    def wakes(self) -> bool:
        """True: it also reaches a robot that moves."""
        return True


class RendezvousMessage(Message, frozen=True, kw_only=True):
    """An explorer proposes the next rendezvous, or its relay accepts it.

    Attributes
    ----------
    rendezvous : Rendezvous or None
        The rendezvous; None: there is no other one, and both continue alone.
    have : tuple of (robot, nodes, closings)
        What the sender knows: a relay accepts when it knows as much. See `Counts`.
    accepts : bool
        Whether it is the answer of the relay.
    """

    # Recordings hold the kind, and the size, to which the names of the fields belong.
    kind: ClassVar[str] = "rendezvous"

    rendezvous: Rendezvous | None
    have: Counts
    accepts: bool = False

    @property
    def wakes(self) -> bool:
        """True: it also reaches a robot that moves."""
        return True


class Role(Enum):
    """What a robot does in its pair."""

    EXPLORER = auto()
    RELAY = auto()
    ALONE = auto()


class Stage(Enum):
    """What a robot of a pair does about its rendezvous; see the diagram of the module."""

    UNTIL_DUE = auto()
    """It explores, or as a relay delivers, until it has to set out."""
    PLACE = auto()
    """It drives to the place, or waits there."""
    BACKUP = auto()
    """It drives to the backup place, or waits there."""


class Pair:
    """One robot's side of a pair.

    Parameters
    ----------
    number : int
        Number of the robot.
    team : int
        Number of robots in the team.
    base : (x, y)
        Where the base station is, in metres.
    period_s : float
        Minimum time between two meetings in seconds.
    now_s : float
        Present time in seconds.

    Attributes
    ----------
    role : Role
        What this robot does.
    partner : int or None
        Number of the other robot; None if there is none.
    rendezvous : Rendezvous
        Where and when they meet next.
    stage : Stage
        What this robot does about that.
    proposed : Rendezvous or None
        Explorer: what it has proposed and the relay has not yet accepted.
    accepted : bool
        Explorer: whether the last proposal was accepted.
    knows_home : callable
        Relay: returns whether it knows a path to where the base station hears it.
    may_meet : bool
        Whether the robot has a partner, and the two have not parted for good.

    Examples
    --------
    >>> pairs = [Pair(n, 5, base=(1.0, 2.0), period_s=60.0, now_s=0.0) for n in range(5)]
    >>> [pair.role.name for pair in pairs]
    ['EXPLORER', 'RELAY', 'EXPLORER', 'RELAY', 'ALONE']
    >>> [pair.partner for pair in pairs]
    [1, 0, 3, 2, None]
    >>> pairs[0].target(), pairs[0].rendezvous.due_s
    ((1.0, 2.0), 60.0)
    """

    def __init__(
        self, number: int, team: int, *, base: Place, period_s: float, now_s: float
    ) -> None:
        partner = number ^ 1
        self.partner: int | None = partner if partner < team else None
        self.role = Role.RELAY if number % 2 else Role.EXPLORER
        if self.partner is None:
            self.role = Role.ALONE
        self.rendezvous = Rendezvous(number=0, place=base, backup=base, due_s=now_s + period_s)
        # A relay begins as if it had delivered: it goes to the first place at once.
        self.stage = Stage.PLACE if self.role is Role.RELAY else Stage.UNTIL_DUE
        self.proposed: Rendezvous | None = None
        self.accepted = False
        self.knows_home: Callable[[], bool] = lambda: False
        self.may_meet = self.partner is not None
        # What it does while it has a partner.
        self._paired_role = self.role
        self._proposals = 0
        self._period_s = period_s
        self._ready_s = -math.inf

    @property
    def is_paired(self) -> bool:
        """Whether the robot has a partner that it does not presume lost."""
        return self.role is not Role.ALONE

    @property
    def lacks_partner(self) -> bool:
        """Whether it has no partner, or presumes it lost; not after they parted for good."""
        return not self.is_paired and (self.partner is None or self.may_meet)

    @property
    def is_relay(self) -> bool:
        """Whether it is the relay of its pair, even while it explores alone."""
        return self.may_meet and self._paired_role is Role.RELAY

    def is_due(self, now_s: float) -> bool:
        """Return whether it is time for the rendezvous, in seconds; for the first it always is."""
        rendezvous = self.rendezvous
        return self.is_paired and (rendezvous.number == 0 or now_s >= rendezvous.due_s)

    def target(self) -> Place:
        """Return where the robot goes to meet its partner, in metres."""
        rendezvous = self.rendezvous
        return rendezvous.backup if self.stage is Stage.BACKUP else rendezvous.place

    def set_out(self) -> None:
        """Begin to go to the rendezvous: the time has come, or what was carried is delivered."""
        if self.stage is Stage.UNTIL_DUE:
            self.stage = Stage.PLACE

    def note_missed(self) -> None:
        """Go on to the backup place, or continue alone: the partner has not come."""
        if self.stage is Stage.PLACE and self.rendezvous.backup != self.rendezvous.place:
            self.stage = Stage.BACKUP
        else:
            self.continue_alone()

    def continue_alone(self) -> None:
        """Explore alone, until the partner is heard from and they agree on a rendezvous."""
        self.role = Role.ALONE

    def part(self) -> None:
        """Explore alone from now on."""
        self.may_meet = False
        self.continue_alone()

    # The explorer ---------------------------------------------------------------------------

    def propose(
        self, place: Place | None, now_s: float, round_s: float, have: Counts, sender: int
    ) -> RendezvousMessage:
        """Return the proposal of the next rendezvous.

        Parameters
        ----------
        place : (x, y) or None
            Where the explorer goes next, in metres; None if there is no other rendezvous.
        now_s : float
            Present time in seconds.
        round_s : float
            Time that the relay takes from here home, and from there to the place, in seconds.
        have : tuple of (robot, nodes, closings)
            What the explorer knows.
        sender : int
            Number of the explorer.

        Returns
        -------
        RendezvousMessage
            The message for the relay.
        """
        self.accepted = False
        self.proposed = None
        if place is not None:
            self._proposals += 1
            self.proposed = Rendezvous(
                number=self._proposals,
                place=place,
                backup=self.rendezvous.place,
                due_s=self.next_due_s(now_s, round_s),
            )
        return RendezvousMessage(sender=sender, rendezvous=self.proposed, have=have)

    def next_due_s(self, now_s: float, round_s: float) -> float:
        """Return the time of a rendezvous that is agreed on now, in seconds; see `propose`."""
        return now_s + max(self._period_s, round_s)

    def take_acceptance(self, message: RendezvousMessage) -> None:
        """Take the relay's answer; ignore an answer to another proposal."""
        if message.rendezvous != self.proposed:
            return
        self.accepted = True
        if message.rendezvous is None:
            self.part()
        else:
            self._keep(message.rendezvous)

    # The relay ------------------------------------------------------------------------------

    def take_ready_turn(self, now_s: float, period_s: float) -> bool:
        """Return whether to announce readiness now, and if so record the time.

        Parameters
        ----------
        now_s : float
            Present time in seconds.
        period_s : float
            Minimum time between two announcements in seconds.
        """
        waits = self.role is Role.ALONE or self.stage is not Stage.UNTIL_DUE
        if not (self.is_relay and waits) or now_s < self._ready_s + period_s:
            return False
        if not self.knows_home():
            return False
        self._ready_s = now_s
        return True

    def accept(self, message: RendezvousMessage) -> bool:
        """Keep a proposed rendezvous, or continue alone if there is none.

        Returns
        -------
        bool
            Whether the relay accepts: the message is not older than the rendezvous that it keeps.
        """
        if message.rendezvous is None:
            self.part()
            return True
        if message.rendezvous.number > self.rendezvous.number:
            self._keep(message.rendezvous)
        return message.rendezvous == self.rendezvous

    def _keep(self, rendezvous: Rendezvous) -> None:
        self.rendezvous = rendezvous
        self.stage = Stage.UNTIL_DUE
        self.role = self._paired_role
