"""The state machine of a robot that goes to frontiers.

::

                       goal               met
    START --> CHOOSING ------> DRIVING ----------> MEETING
              ^  |  ^ ^         | |  ^               | | |
              |  |  | +---(a)---+ |  +----detour-----+ | |
              |  |  +-------------|-------(b)----------+ |
              |  |                | asked                | asked
              |  |                v                      |
              |  |             YIELDING <----------------+
              |  |              |  ^
              |  |   gave way   |  | asked
              |<-|--------------+  +------------------+
              |  |                                    |
              |  +-- barred ------------> WAITING ----+
              |  +-- jammed, boxed in --> BOXED_IN ---+
              |  +-- explored ----------> COMPLETE ---+
              |                                       |
              +-- blocked (from WAITING), ------------+
                  called on (from the other two)

    (a) reached, news, nothing left, no way, stop signal, assigned
    (b) blocked, stop signal, assigned

Robots that deliver data (`multisrt.robots.homing`) have errands besides::

    CHOOSING ---- goal ----> DRIVING ---- arrived ----> ATTENDING --- asked ---> YIELDING
      ^   |                     |                           |
      +---|-- errand, errand ---+------- errand over -------+
      |   |   over
      |   +-- out of time, out of reach --> OUT_OF_TIME, OUT_OF_REACH --- asked ---> YIELDING
      |                           |
      +-------- called on --------+

============  ======================================================================================
CHOOSING      The rule chooses a goal. If there is none, a car tries goals given up for want of a
              path again once more is known, or a body is gone (``no way``, to CHOOSING). A robot
              whose map changes while it waits for an answer before its end chooses again
              (``news``, to CHOOSING).
DRIVING       The robot drives to its goal.
MEETING       The protective stop has ended a motion before another body. The robot looks for a
              detour, or asks the other to give way.
YIELDING      The robot makes room, as it was asked to.
WAITING       Only bodies that may still leave bar the paths to the last frontiers.
ATTENDING     The robot is where its errand leads, and waits for the base station's acknowledgement,
              or for its partner.
BOXED_IN      Bodies that do not leave bar them, or walls beside the start; the robot is done until
              it hears something new.
OUT_OF_TIME   No time is left to go on and come home; it is done until it hears something new.
OUT_OF_REACH  No goal is left from which the chain reaches the base station; it is done until it
              hears something new.
COMPLETE      No frontier is left that it can reach; the robot is done until it hears something new.
============  ======================================================================================

What ends a state is an `Event`; `TRANSITIONS` says where it leads. Attempts that fail are counted,
and the limits are options. Jams are counted while the robot stands at one place and its map stays
the same (`Standstill`). While its map stays the same, wherever it moves, waits are counted, and
meetings in which both robots ask the other to give way, and how often it gives way to another,
which makes its pauses longer; and where a detour began no other one begins. Goals to which no path
was free are given up, see `Progress.note_no_path`.

====================  ============================================================================
`patience`            times a robot asks another to give way, in MEETING, before it takes the body
                      as an obstacle
`max_waits`           times a robot enters WAITING before it is boxed in
`max_jams`            times a robot could not pass another, or make room for it, before it is
                      boxed in; also meetings in which it was asked to give way instead
`max_instant_goals`   goals in a row that end at the moment they were chosen, before it pauses
====================  ============================================================================
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum, StrEnum, auto
from types import MappingProxyType
from typing import Final, Generic, TypeVar

from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.grids.occupancy import Occupancy
from multisrt.robots.frontier.bodies import MOVED_M
from multisrt.robots.frontier.course import Course
from multisrt.robots.frontier.goal import Place
from multisrt.robots.frontier.options import FrontierOptions

K = TypeVar("K")


class State(Enum):
    """State of a robot; see the drawing above."""

    CHOOSING = auto()
    DRIVING = auto()
    MEETING = auto()
    YIELDING = auto()
    WAITING = auto()
    ATTENDING = auto()
    BOXED_IN = auto()
    OUT_OF_TIME = auto()
    OUT_OF_REACH = auto()
    COMPLETE = auto()


class Event(StrEnum):
    """What ends a state. The value is the recorded reason of a choice that follows."""

    START = "start"
    """The robot has looked round for the first time."""
    REACHED = "reached"
    """The goal is reached."""
    NEWS = "news"
    """The map has changed, so that a goal may be chosen again."""
    NOTHING_LEFT = "nothing left"
    """Nothing is left to be seen at the goal."""
    NO_WAY = "no way"
    """The path turned out not to be free; or a car may try goals given up for that again."""
    BLOCKED = "blocked"
    """Another robot stands in the way."""
    GAVE_WAY = "gave way"
    """The robot has made room for another, or tried to."""
    STOP_SIGNAL = "stop signal"
    """Another robot said that the goal is no longer a frontier."""
    ASSIGNED = "assigned"
    """Another robot took over the goal of this one, and gave it its own."""
    CALLED_ON = "called on"
    """The robot was done, and heard something new."""
    ERRAND = "errand"
    """The robot has an errand (`multisrt.robots.frontier.errands`): to deliver data, to meet
    its partner, to pursue a teammate, or to stand in a chain; or it has met the robot that takes
    its data."""
    ERRAND_OVER = "errand over"
    """An errand is over: it is done, it is not needed any more, or the robot has waited in
    vain."""

    GOAL = "goal"
    """A goal was chosen."""
    MET = "met"
    """The protective stop ended a motion."""
    DETOUR = "detour"
    """There is a path round the other robot."""
    ASKED = "asked"
    """Another robot wants this one to give way."""
    BARRED = "barred"
    """Frontiers are left, and only bodies that may leave bar the paths to them."""
    BOXED_IN = "boxed in"
    """Frontiers are left, and bodies that do not leave bar the paths to them, or walls beside the
    start of a robot that has not left it."""
    JAMMED = "jammed"
    """The robot and others have too often failed to let each other pass."""
    ARRIVED = "arrived"
    """The robot is where its errand leads."""
    OUT_OF_TIME = "out of time"
    """No time is left to go on and come home."""
    OUT_OF_REACH = "out of reach"
    """No goal is left from which a chain of relays reaches the base station."""
    EXPLORED = "explored"
    """No frontier is left that the robot can reach."""
    INTERRUPTED = "interrupted"
    """Something was heard for which a robot stops driving."""


TRANSITIONS: Final[Mapping[State, Mapping[Event, State]]] = MappingProxyType(
    {
        State.CHOOSING: {
            Event.GOAL: State.DRIVING,
            Event.NO_WAY: State.CHOOSING,
            Event.NEWS: State.CHOOSING,
            Event.BARRED: State.WAITING,
            Event.BOXED_IN: State.BOXED_IN,
            Event.JAMMED: State.BOXED_IN,
            Event.OUT_OF_TIME: State.OUT_OF_TIME,
            Event.OUT_OF_REACH: State.OUT_OF_REACH,
            Event.EXPLORED: State.COMPLETE,
        },
        State.DRIVING: {
            Event.REACHED: State.CHOOSING,
            Event.NEWS: State.CHOOSING,
            Event.NOTHING_LEFT: State.CHOOSING,
            Event.NO_WAY: State.CHOOSING,
            Event.STOP_SIGNAL: State.CHOOSING,
            Event.ASSIGNED: State.CHOOSING,
            Event.ERRAND: State.CHOOSING,
            Event.ERRAND_OVER: State.CHOOSING,
            Event.ARRIVED: State.ATTENDING,
            Event.MET: State.MEETING,
            Event.ASKED: State.YIELDING,
        },
        State.MEETING: {
            Event.DETOUR: State.DRIVING,
            Event.BLOCKED: State.CHOOSING,
            Event.STOP_SIGNAL: State.CHOOSING,
            Event.ASSIGNED: State.CHOOSING,
            Event.ERRAND: State.CHOOSING,
            Event.ASKED: State.YIELDING,
        },
        State.YIELDING: {Event.GAVE_WAY: State.CHOOSING},
        State.WAITING: {Event.BLOCKED: State.CHOOSING, Event.ASKED: State.YIELDING},
        State.ATTENDING: {Event.ERRAND_OVER: State.CHOOSING, Event.ASKED: State.YIELDING},
        State.BOXED_IN: {Event.CALLED_ON: State.CHOOSING, Event.ASKED: State.YIELDING},
        State.OUT_OF_TIME: {Event.CALLED_ON: State.CHOOSING, Event.ASKED: State.YIELDING},
        State.OUT_OF_REACH: {Event.CALLED_ON: State.CHOOSING, Event.ASKED: State.YIELDING},
        State.COMPLETE: {Event.CALLED_ON: State.CHOOSING, Event.ASKED: State.YIELDING},
    }
)
"""Transitions: the next state by state and event."""


MAX_PATHS = 4
"""A goal is given up once this many paths to it turned out not to be free."""


@dataclass(slots=True)
class Standstill:
    """The unsuccessful attempts of a robot since it last moved.

    Attributes
    ----------
    place : (x, y)
        Where it stands.
    revision : int
        Revision of its raster.
    jams : dict of int to int
        How often each other robot and this one could not let each other pass, since the map last
        changed.
    found_no_path : bool
        Whether the path to a goal turned out not to be free.
    """

    place: Place
    revision: int
    jams: dict[int, int] = field(default_factory=dict)
    found_no_path: bool = False


class _Counts(Generic[K]):
    """Counts that begin anew when the map changes."""

    def __init__(self, raster: Occupancy) -> None:
        self._raster = raster
        self._revision = raster.revision
        self._counted: Counter[K] = Counter()

    @property
    def now(self) -> Counter[K]:
        if self._revision != self._raster.revision:
            self._revision, self._counted = self._raster.revision, Counter()
        return self._counted


class Progress:
    """The state of one robot, and its failed attempts.

    Parameters
    ----------
    options : FrontierOptions
        The limits.
    course : Course
        Where the robot is.
    raster : Occupancy
        What it knows.

    Attributes
    ----------
    state : State
        What it is doing.
    because : Event
        What ended the state before.
    is_hasty : bool
        Whether too many goals in a row have ended at the moment they were chosen. The robot then
        pauses: others continue meanwhile, and what kept it from its goals may be over.
    """

    def __init__(self, options: FrontierOptions, course: Course, raster: Occupancy) -> None:
        self.state = State.CHOOSING
        self.because = Event.START
        self.is_hasty = False
        self._options = options
        self._course = course
        self._raster = raster
        self._standstill = Standstill(course.at[:2], raster.revision)
        # Where detours began since the map last changed.
        self._detoured_at: list[Place] = []
        self._detoured_revision = raster.revision
        # How often it waited; was met by each robot and asked to give way; and did so.
        self._waits = _Counts[State](raster)
        self._in_vain = _Counts[int](raster)
        self._gave_way = _Counts[int](raster)
        # When the last drive began, until what came of it is dealt with.
        self._set_out_s: float | None = None
        self._instant_goals = 0
        self._without_path: Counter[Place] = Counter()

    def advance(self, event: Event) -> None:
        """Continue to the next state.

        Raises
        ------
        InvalidInputError
            If the event cannot end the present state.
        """
        following = TRANSITIONS[self.state].get(event)
        if following is None:
            raise InvalidInputError(f"{event.value!r} cannot end {self.state.name}")
        self.state, self.because = following, event
        self.is_hasty = False
        if following in (State.CHOOSING, State.DRIVING) and self._set_out_s is not None:
            took_no_time = self._course.time_s == self._set_out_s
            self._instant_goals = self._instant_goals + 1 if took_no_time else 0
            self.is_hasty = self._instant_goals > self._options.max_instant_goals
            self._set_out_s = None
        if following is State.DRIVING:
            self._set_out_s = self._course.time_s

    @property
    def standstill(self) -> Standstill:
        """The unsuccessful attempts here; a new one once the robot has moved."""
        here, revision = self._course.at[:2], self._raster.revision
        if math.dist(here, self._standstill.place) > MOVED_M:
            self._standstill = Standstill(here, revision)
        elif revision != self._standstill.revision:
            self._standstill.revision, self._standstill.jams = revision, {}
        return self._standstill

    def note_no_path(self, place: Place) -> bool:
        """Count that the path to a goal was not free; return whether to give that goal up.

        That is so for the second such goal while the robot stands here, and for a goal to which
        `MAX_PATHS` paths were not free, from wherever they began.
        """
        here = self.standstill
        self._without_path[place] += 1
        found_none, here.found_no_path = here.found_no_path, True
        return found_none or self._without_path[place] >= MAX_PATHS

    def note_detour(self) -> None:
        """Record that a detour begins here."""
        if self._detoured_revision != self._raster.revision:
            self._detoured_at, self._detoured_revision = [], self._raster.revision
        self._detoured_at.append(self._course.at[:2])

    @property
    def has_detoured(self) -> bool:
        """Whether a detour began here since the map last changed, or the last one did.

        So it does also for a robot that has come back since: the detour led it nowhere. Robots
        that stand in two doors would otherwise send it from one to the other forever.
        """
        since = self._detoured_at
        if self._detoured_revision != self._raster.revision:
            since = since[-1:]
        here = self._course.at[:2]
        return any(math.dist(at, here) <= MOVED_M for at in since)

    def note_jam(self, other: int) -> None:
        """Count that another robot did not let this one pass, or could not be let pass."""
        jams = self.standstill.jams
        jams[other] = jams.get(other, 0) + 1

    def note_asked_instead(self, other: int) -> None:
        """Count that a robot that was to give way asked this one to do so.

        Moving does not make the count smaller: the two may step back and forth forever.
        """
        self._in_vain.now[other] += 1

    def note_giving_way(self, other: int) -> int:
        """Count that this robot gives way to another; return how often it did so before.

        Moving does not make the count smaller, but a new map does.
        """
        self._gave_way.now[other] += 1
        return self._gave_way.now[other] - 1

    @property
    def jams(self) -> Counter[int]:
        """By robot, how often it and this one failed to let each other pass."""
        return Counter(self.standstill.jams) | self._in_vain.now

    @property
    def is_jammed(self) -> bool:
        """Whether neither asking nor giving way leads any further here."""
        return self.jams.total() >= self._options.max_jams

    def note_wait(self) -> None:
        """Count a wait."""
        self._waits.now[State.WAITING] += 1

    @property
    def may_wait(self) -> bool:
        """Whether the robot has waited fewer times than allowed since its map last changed.

        Moving does not give it new patience: robots that make room for each other by turns would
        wait forever.
        """
        return self._waits.now[State.WAITING] < self._options.max_waits
