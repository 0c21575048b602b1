"""Pairs of an explorer and a relay that meet at agreed places: what one robot keeps of its pair.

Robots 0 and 1 are a pair, 2 and 3 the next, and so on: the first of them explores, the second
carries its news to the base station. The last robot of an odd team explores alone. A pair agrees,
whenever it meets, on its next *appointment*: a place, which is where the explorer goes next, a time
by which the relay can have been home and there, and a backup place, which is where they had agreed
to meet this time. At first it is the place of the base station, which all robots know.

The explorer drives to the place in time, and both wait there until a while after that time, then at
the backup place. A robot whose mate comes to neither takes it as lost and goes on alone, which
makes an explorer of a relay; so nobody waits for ever. ::

                   appointment, then lateness            in vain              in vain
    explorer:  EXPLORING ------------------> TO PLACE ----------> TO BACKUP ----------> ALONE
                   ^                            |                     |
                   +---------- met -------------+---------------------+

                   home, delivered                       in vain              in vain
    relay:     DELIVERING -----------------> TO PLACE ----------> TO BACKUP ----------> ALONE
                   ^                            |                     |
                   +---------- met -------------+---------------------+

They meet by radio: a relay on its way to its explorer that hears of news tells it that it is ready.
Until it knows a way home it explores like any robot, and takes no news.
The explorer chooses its next goal and proposes an appointment, again and again until the relay has
all that the explorer knows, and accepts. Both then keep the new appointment; where the acceptance
is lost, the explorer keeps the last one, at whose place the relay looks for it in the end, as that
is the backup of its own.

Source: J. de Hoog, S. Cameron and A. Visser, Role-based autonomous multi-robot exploration,
COGNITIVE 2009, and Selection of rendezvous points for multi-robot exploration in dynamic
environments, AAMAS workshop ARMS 2010; V. Spirin, S. Cameron and J. de Hoog, Time preference for
information in multi-agent exploration with limited communication, TAROS 2013, for the backup and
the limits. Differs in: the meeting place is the explorer's next goal, and not the one of a skeleton
that is best for the team; the hierarchy has two levels; roles are not swapped.
"""

from __future__ import annotations

import math
from enum import Enum, auto
from typing import ClassVar

import msgspec

from multisrt.robots.homing.contact import Place
from multisrt.robots.knowledge import Counts
from multisrt.robots.messages import Message


class Appointment(msgspec.Struct, frozen=True, kw_only=True):
    """Where and when a pair meets next.

    Attributes
    ----------
    number : int
        Serial number among those of the pair.
    place : (x, y)
        Where, in metres.
    backup : (x, y)
        Where else, if one of them did not come.
    due_s : float
        When, in seconds.
    """

    number: int
    place: Place
    backup: Place
    due_s: float


class ReadyMessage(Message, frozen=True, kw_only=True):
    """A relay tells its explorer that it can take its news.

    Attributes
    ----------
    number : int
        Number of the appointment that it keeps.
    """

    kind: ClassVar[str] = "ready"

    number: int

    @property
    def wakes(self) -> bool:
        """True: it also reaches a robot that moves."""
        return True


class AppointmentMessage(Message, frozen=True, kw_only=True):
    """An explorer proposes the next appointment, or its relay accepts it.

    Attributes
    ----------
    appointment : Appointment or None
        The appointment; None: the explorer is done, and goes home itself.
    have : tuple of (robot, nodes, closings)
        What the sender knows: a relay accepts when it knows as much. See `Counts`.
    accepts : bool
        Whether it is the answer of the relay.
    """

    kind: ClassVar[str] = "appointment"

    appointment: Appointment | None
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
    """What a robot does about its appointment; see the drawing above."""

    UNTIL_DUE = auto()
    """Exploring, or delivering."""
    PLACE = auto()
    BACKUP = auto()


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
        The time now.

    Attributes
    ----------
    role : Role
        What this robot does.
    mate : int or None
        Number of the other robot; None if there is none.
    appointment : Appointment
        When and where they meet next.
    stage : Stage
        What it does about that.
    proposed : Appointment or None
        Explorer: what it has proposed and the relay has not yet accepted.
    accepted : bool
        Explorer: whether the last proposal was accepted.
    knows_home : bool
        Relay: whether it knows a way to where the base station hears it.

    Examples
    --------
    >>> pairs = [Pair(n, 5, base=(1.0, 2.0), period_s=60.0, now_s=0.0) for n in range(5)]
    >>> [pair.role.name for pair in pairs]
    ['EXPLORER', 'RELAY', 'EXPLORER', 'RELAY', 'ALONE']
    >>> [pair.mate for pair in pairs]
    [1, 0, 3, 2, None]
    >>> pairs[0].target(), pairs[0].appointment.due_s
    ((1.0, 2.0), 60.0)
    """

    def __init__(
        self, number: int, team: int, *, base: Place, period_s: float, now_s: float
    ) -> None:
        mate = number ^ 1
        self.mate: int | None = mate if mate < team else None
        self.role = Role.RELAY if number % 2 else Role.EXPLORER
        if self.mate is None:
            self.role = Role.ALONE
        self.appointment = Appointment(number=0, place=base, backup=base, due_s=now_s + period_s)
        # A relay begins as if it had delivered: it goes to the first place at once.
        self.stage = Stage.PLACE if self.role is Role.RELAY else Stage.UNTIL_DUE
        self.proposed: Appointment | None = None
        self.accepted = False
        self.knows_home = False
        self._period_s = period_s
        self._ready_s = -math.inf

    @property
    def is_paired(self) -> bool:
        """Whether the robot has a mate that it does not take as lost."""
        return self.role is not Role.ALONE

    def target(self) -> Place:
        """Return where the robot goes to meet its mate, in metres."""
        here = self.appointment
        return here.backup if self.stage is Stage.BACKUP else here.place

    def set_out(self) -> None:
        """Go to meet the mate: the time has come, or what was carried is delivered."""
        if self.stage is Stage.UNTIL_DUE:
            self.stage = Stage.PLACE

    def note_in_vain(self) -> None:
        """Go on to the backup place, or alone: the mate has not come."""
        if self.stage is Stage.PLACE and self.appointment.backup != self.appointment.place:
            self.stage = Stage.BACKUP
        else:
            self.part()

    def part(self) -> None:
        """Go on alone."""
        self.role = Role.ALONE

    # The explorer ---------------------------------------------------------------------------

    def propose(
        self, place: Place | None, now_s: float, round_s: float, have: Counts, sender: int
    ) -> AppointmentMessage:
        """Return the proposal of the next appointment.

        Parameters
        ----------
        place : (x, y) or None
            Where the explorer goes next, in metres; None if it is done.
        now_s : float
            The time now.
        round_s : float
            Time that the relay takes from here home, and from there to the place, in seconds.
        have : tuple of (robot, nodes, closings)
            What the explorer knows.
        sender : int
            Its number.
        """
        self.accepted = False
        self.proposed = None
        if place is not None:
            self.proposed = Appointment(
                number=self.appointment.number + 1,
                place=place,
                backup=self.appointment.place,
                due_s=now_s + max(self._period_s, round_s),
            )
        return AppointmentMessage(sender=sender, appointment=self.proposed, have=have)

    def take_acceptance(self, message: AppointmentMessage) -> None:
        """Take the relay's answer; an answer to another proposal is passed over."""
        if message.appointment != self.proposed:
            return
        self.accepted = True
        if message.appointment is None:
            self.part()
        else:
            self._keep(message.appointment)

    # The relay ------------------------------------------------------------------------------

    def is_ready(self, now_s: float, period_s: float) -> bool:
        """Whether to tell the explorer that the relay is here, and record that it is done."""
        waits = self.role is Role.RELAY and self.stage is not Stage.UNTIL_DUE
        if not (waits and self.knows_home) or now_s < self._ready_s + period_s:
            return False
        self._ready_s = now_s
        return True

    def accept(self, message: AppointmentMessage) -> None:
        """Keep a proposed appointment, or go on alone if the explorer is done."""
        if message.appointment is None:
            self.part()
        elif message.appointment.number > self.appointment.number:
            self._keep(message.appointment)

    def _keep(self, appointment: Appointment) -> None:
        self.appointment = appointment
        self.stage = Stage.UNTIL_DUE
