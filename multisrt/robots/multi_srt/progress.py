"""Whether a robot makes progress, and what it does where it does not: one state machine.

A *setback* is a step that did not go as planned: a master ordered something else, or the
protective stop ended the motion. *Progress* is to reach, by a plan of its own, a place where the
robot has not been in its present task, which is to extend one tree or to go to one node. The
number of setbacks since the last progress determines the states of the first row; where there is
no path at all, those of the second row follow:

::

       crowded_after setbacks          jammed_after setbacks
    +-------+              +---------+              +--------+
    | CLEAR | -----------> | CROWDED | -----------> | JAMMED |
    +-------+              +---------+              +--------+
        ^                       |                       |
        +------ progress -------+------- progress ------+
               new task         |       new task
                                |
         any of the three:      | no path                     | gives_up_after
                                v       no path, more than    v setbacks
                           +-------+    boxed_in_after times   +----------+
                           | STUCK | ------------------------> | BOXED_IN |
                           +-------+    in a row               +----------+
                                |                                   |
                                | a path, new task                  | a path
                                v                                   v
         back to the first row, by the number of setbacks: CLEAR, CROWDED or JAMMED

A robot that finds no motion from its start, as its body has no room there, is BOXED_IN at once.

=========  =====================================================================================
state      what the robot does
=========  =====================================================================================
CLEAR      follows its target; after `max_waits` waits in a row, as in any state, a new one
CROWDED    stands aside for a while when it was stopped, and takes a place within sensing range of
           the end of a transfer as near enough
JAMMED     in addition plans around the robots of its group that stand idle
STUCK      waits, and looks for a path again
BOXED_IN   gives up its task: it stands idle, and others plan around it or order it out of the way
=========  =====================================================================================

A robot sent back and forth between the same places makes no progress, however many motions it
completes and nodes it adds. The places of a task are finitely many, as they lie apart; so a robot
that keeps meeting setbacks ends up jammed.
"""

from __future__ import annotations

from enum import Enum

from multisrt.robots.multi_srt.options import MultiSrtOptions


class State(Enum):
    """Whether a robot makes progress; see the module for what it does in each state."""

    CLEAR = "clear"
    CROWDED = "crowded"
    JAMMED = "jammed"
    STUCK = "stuck"
    BOXED_IN = "boxed in"


class Event(Enum):
    """Events that change the state."""

    NEW_TASK = "begins to extend a tree, or to go to a node"
    NEW_PLACE = "has reached, by its own plan, a place where it had not been in its task"
    SETBACK = "was ordered otherwise by a master, or stopped"
    NO_PATH = "has found no path to anywhere"
    NO_ROOM = "has found no motion from its start, where its body has no room"
    PATH = "has found a path"


class BoxedIn(Exception):
    """The robot gives up its task: bodies that do not give way, or walls, are all around."""


class Progress:
    """The state machine of one robot.

    Parameters
    ----------
    options : MultiSrtOptions
        The limits.

    Attributes
    ----------
    state : State
        The present state.
    setbacks : int
        Number of setbacks since the last progress or new task.

    Examples
    --------
    >>> progress = Progress(MultiSrtOptions(crowded_after=2))
    >>> progress.note(Event.SETBACK)
    >>> progress.note(Event.SETBACK)
    >>> progress.state
    <State.CROWDED: 'crowded'>
    >>> progress.note(Event.NEW_PLACE)
    >>> progress.state
    <State.CLEAR: 'clear'>
    """

    def __init__(self, options: MultiSrtOptions) -> None:
        self.state = State.CLEAR
        self.setbacks = 0
        self._pathless = 0
        self._rounds = 0
        self._options = options

    @property
    def is_hindered(self) -> bool:
        """Whether setbacks call for other measures: the robot is crowded or jammed."""
        return self.state in (State.CROWDED, State.JAMMED)

    @property
    def is_boxed_in(self) -> bool:
        """Whether the robot has given up."""
        return self.state is State.BOXED_IN

    @property
    def backoff(self) -> int:
        """Factor by which a robot that stands aside pauses longer."""
        return 1 + min(self.setbacks, self._options.jammed_after)

    def note(self, event: Event) -> None:
        """Go to the state to which an event leads."""
        match self.state, event:
            case _, Event.NO_ROOM:
                self.state = State.BOXED_IN
            case _, Event.NO_PATH:
                self._pathless += 1
                gives_up = self.is_boxed_in or self._pathless > self._options.boxed_in_after
                self.state = State.BOXED_IN if gives_up else State.STUCK
            case State.STUCK | State.BOXED_IN, Event.SETBACK:
                pass  # where there is no path, a setback says nothing new
            case State.BOXED_IN, Event.NEW_TASK:
                self.setbacks = 0  # no path was found for the last task, and none for this one yet
            case _:
                self._pathless = 0
                self._count(event)
                gives_up = self.setbacks >= self._options.gives_up_after
                self.state = (
                    State.BOXED_IN if gives_up and event is Event.SETBACK else self._by_setbacks()
                )

    def _count(self, event: Event) -> None:
        if event is Event.SETBACK:
            self.setbacks += 1
        elif event in (Event.NEW_PLACE, Event.NEW_TASK):
            self.setbacks = 0

    def _by_setbacks(self) -> State:
        if self.setbacks >= self._options.jammed_after:
            return State.JAMMED
        return State.CROWDED if self.setbacks >= self._options.crowded_after else State.CLEAR

    def begin_step(self) -> None:
        """Begin a step: no member of its group has been asked without success yet."""
        self._rounds = 0

    def has_asked_enough(self) -> bool:
        """Count a round of questions within a step; return whether it continues without answers."""
        self._rounds += 1
        if self._rounds <= self._options.max_rounds:
            return False
        self._rounds = 0
        return True
