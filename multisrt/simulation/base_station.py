"""The base station of a run: where it is, and what it does with the messages that reach it."""

from __future__ import annotations

import math
from collections.abc import Callable

from multisrt.environments.environment import Environment
from multisrt.events import BaseLearned
from multisrt.geometry.bodies.footprint import Footprint
from multisrt.geometry.errors import ClearanceError
from multisrt.robots.base_station import BaseStation
from multisrt.robots.defects import refuse
from multisrt.robots.explorer import Done, Note, Outcome, Received, Send, Steps
from multisrt.robots.messages import Message
from multisrt.robots.robot_self import BaseSelf
from multisrt.simulation.clock import Clock
from multisrt.simulation.journal import Journal
from multisrt.simulation.rooms import nearest_room
from multisrt.spec import BaseSpec
from multisrt.spec.numbering import numbers_of

AWAY_FROM_WALLS = Footprint.disc(0.25)
"""The body for which a place is suggested to users. A base station has none, but robots have to get
there; a place beside a wall is hardly ever in a safe region."""

SendMessage = Callable[[Message, int | None], None]
"""Sends a message of the base station to a robot, by its number, or to all."""


class Base:
    """The base station as the simulation sees it: one more that takes part in the radio traffic.

    A message is taken when it arrives, and answered at once.

    Parameters
    ----------
    me : BaseSelf
        What it knows of itself.
    send : callable
        How it sends.
    clock, journal
        Those of the run.

    Attributes
    ----------
    number : int
        Its number: that of robots in the team.
    place : (x, y)
        Where it is, in metres.
    """

    hears = True
    """Whether its radio works: it never fails."""

    def __init__(self, me: BaseSelf, send: SendMessage, *, clock: Clock, journal: Journal) -> None:
        self.number = me.robot
        self.place = me.base
        self._send = send
        self._clock = clock
        self._journal = journal
        self._steps = _begun(BaseStation(me))

    def deliver(self, message: Message) -> None:
        """Take a message, and carry out what follows from it."""
        now_s = self._clock.now_s
        self._journal.note_time(now_s)
        outcome: Outcome = Received((message,), now_s)
        while True:
            action = self._steps.send(outcome)
            outcome = None
            match action:
                case Send():
                    self._send(action.message, action.to)
                case Note(event=BaseLearned() as learned):
                    self._record(learned)
                case Done():
                    return

    def _record(self, learned: BaseLearned) -> None:
        if not 0 <= learned.robot < self.number:
            what = f"a message that reached the base station has sender={learned.robot}"
            refuse(learned.robot, what, f"give the number of the robot; {numbers_of(self.number)}")
        self._journal.record_learned(learned)

    def close(self) -> None:
        """Let go of what it knows."""
        self._steps.close()


def _begun(station: BaseStation) -> Steps:
    steps = station.run()
    assert isinstance(next(steps), Done), "a base station begins by waiting"
    return steps


def require_free(base: BaseSpec, environment: Environment) -> None:
    """Check that a base station is in free space.

    Raises
    ------
    ClearanceError
        If it is not; the message names the nearest place that is.

    Examples
    --------
    >>> import shapely
    >>> hall = Environment("hall", shapely.box(0, 0, 8, 5))
    >>> require_free(BaseSpec(x=4.0, y=6.0), hall)
    Traceback (most recent call last):
    ...
    multisrt.geometry.errors.ClearanceError: the base station (4, 6) is not in the free space of \
'hall': it is in an obstacle or outside the outline, 1 m from free space; the nearest place in \
free space, 0.25 m from walls, is (4, 4.74), 1.26 m from there
    """
    x, y = base.place
    try:
        environment.component(x, y)
    except ClearanceError as error:
        place = nearest_room(environment, AWAY_FROM_WALLS, x, y)
        instead = "choose a place in free space"
        if place is not None:
            instead = (
                f"the nearest place in free space, {AWAY_FROM_WALLS.radius_m:g} m from walls, is "
                f"({place[0]:g}, {place[1]:g}), "
                f"{math.dist(place, (x, y)):.3g} m from there"
            )
        raise ClearanceError(f"the base station {error}; {instead}", error.clearance_m) from None
