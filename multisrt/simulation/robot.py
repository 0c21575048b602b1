"""One robot of a run as the simulation sees it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from multisrt.events import Ended
from multisrt.geometry.bodies.collision import Body
from multisrt.planners.motion.trajectory import Trajectory
from multisrt.robots.explorer import Move
from multisrt.robots.messages import Message
from multisrt.simulation.clock import ROUNDING_S, Clock
from multisrt.simulation.encounters import Encounter
from multisrt.spec import RobotSpec


@dataclass(slots=True, kw_only=True)
class CurrentMotion:
    """A motion that has begun and not ended.

    Attributes
    ----------
    move : Move
        The action that began it.
    set_out_s, arrival_s : float
        When it began, and when it ends if nothing intervenes, in seconds.
    encounter : Encounter or None
        The first thing that another body will do to it, if all continue as they do.
    """

    move: Move
    set_out_s: float
    arrival_s: float
    encounter: Encounter | None = None

    def driven(self, time_s: float) -> Trajectory:
        """Return what has been driven by a time: all of it from its arrival on."""
        if time_s >= self.arrival_s - ROUNDING_S:
            return self.move.trajectory
        return self.move.trajectory.until(time_s - self.set_out_s)


class Robot:
    """One robot: its body, its mailbox and its state.

    Parameters
    ----------
    number : int
        Its number in the team, from 0.
    spec : RobotSpec
        What it is.
    body : Body
        Its body, for collision queries.
    clock : Clock
        The clock of the run.

    Attributes
    ----------
    mailbox : list of Message
        Messages that have arrived and that the explorer has not been sent yet.
    wake : simpy.Event
        What its process waits for.
    state : {"off", "on", "done", "dead"}
        Switched off before a late start, exploring, finished (perhaps on call), or dead.
    hears : bool
        Whether its radio works.
    waits : bool
        Whether it stands and waits.
    motion : CurrentMotion or None
        Its motion; None while it stands.
    end : Ended or None
        The last end that was recorded of it.
    """

    def __init__(self, number: int, spec: RobotSpec, body: Body, clock: Clock) -> None:
        self.number = number
        self.spec = spec
        self.body = body
        self.mailbox: list[Message] = []
        self.wake = clock.event()
        self.state: Literal["off", "on", "done", "dead"] = "off"
        self.hears = False
        self.waits = False
        self.motion: CurrentMotion | None = None
        self.end: Ended | None = None

    def deliver(self, message: Message) -> None:
        """Put a message that arrives into the mailbox, if the radio works."""
        if self.hears:
            self.mailbox.append(message)
            if self.motion is None or message.wakes:
                self.poke()

    def poke(self) -> None:
        """Wake its process, so that it looks at what happened."""
        if not self.wake.triggered:
            self.wake.succeed()
