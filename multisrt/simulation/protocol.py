"""The protocol between an explorer and what carries out its actions.

The simulation, a driver of other bodies and the checker begin an explorer, send it outcomes and
take its actions here, and refuse here what is no action or comes at the wrong moment.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable
from types import CoroutineType, GeneratorType
from typing import Any, NoReturn, cast, get_args

from multisrt.events import Event
from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.regions.scan import ExactScan, LaserScan
from multisrt.planners.motion.trajectory import Trajectory
from multisrt.robots.defects import ExplorerDefect, article, brief, described, refuse
from multisrt.robots.error_flaw import error_flaw
from multisrt.robots.explorer import (
    Action,
    Done,
    Explorer,
    Move,
    Moved,
    Outcome,
    Received,
    RobotSelf,
    Steps,
    Stop,
    TimedOut,
)
from multisrt.robots.messages import Message

MAX_ACTIONS = 100_000
"""Actions of one explorer at one moment; one that yields more never lets time pass."""

MAX_RATE_HZ = 1_000
"""Actions of one explorer in each second of the run, on average, besides `MAX_ACTIONS`; one that
yields more lets too little time pass."""

FROM_ITS_OWN = "build it from its RobotSelf and its options alone"
"""What to do about an exception in building an explorer, if it does not tell more."""

TRY_IT = "see what 'multisrt check FILE' says of it"
"""What to do about an exception in a run, if it does not tell more."""


class Pace:
    """Counts the actions of one explorer, of which there may be many, but not without end.

    Parameters
    ----------
    robot : int
        Its robot.
    """

    def __init__(self, robot: int) -> None:
        self._robot = robot
        self._moment_s = 0.0
        self._at_once = 0
        self._all = 0

    def count(self, now_s: float) -> None:
        """Count an action.

        Parameters
        ----------
        now_s : float
            The present moment in seconds.

        Raises
        ------
        ExplorerDefect
            If these are more than `MAX_ACTIONS` at this moment, or more than that and
            `MAX_RATE_HZ` up to it.
        """
        if self._moment_s < now_s:
            self._moment_s, self._at_once = now_s, 0
        self._at_once += 1
        self._all += 1
        if self._at_once > MAX_ACTIONS:
            refuse(
                self._robot,
                f"it yielded {MAX_ACTIONS:,} actions at {now_s:g} s and lets no time pass",
                "have it move, or wait with a Receive that does not end at once",
            )
        if self._all > MAX_ACTIONS + MAX_RATE_HZ * now_s:
            refuse(
                self._robot,
                f"it yielded {self._all:,} actions by {now_s:g} s, of which {MAX_RATE_HZ:,} in a "
                "second are allowed",
                "have it wait longer, as with a larger timeout_s of its Receive",
            )


def build(make: Callable[[RobotSelf, Any], Explorer], me: RobotSelf, options: object) -> Explorer:
    """Return the explorer of a robot.

    Parameters
    ----------
    make : callable
        That of its strategy.
    me : RobotSelf
        What the robot knows of itself.
    options : object
        The options of the strategy.

    Returns
    -------
    Explorer
        The explorer.

    Raises
    ------
    ExplorerDefect
        If it cannot be built, by an exception which is its cause then, or has no `run()`. Errors
        of this package pass as they are.
    """
    where = f"building the explorer of robot {me.robot}"
    try:
        explorer = make(me, options)
    except InvalidInputError:
        raise
    except (Exception, SystemExit) as error:
        _pass_interrupt(error)
        what, remedy = error_flaw(inspect.unwrap(make), error, FROM_ITS_OWN)
        raise ExplorerDefect(what, where, remedy) from error
    if not callable(getattr(explorer, "run", None)):
        raise ExplorerDefect(
            f"what was built is {article(type(explorer).__name__)}, which has no run()",
            where,
            "give it a method run(self), a generator of actions",
        )
    return explorer


def begin(explorer: Explorer, robot: int, usual: str = TRY_IT) -> Steps:
    """Return the generator of an explorer's actions.

    Parameters
    ----------
    explorer : Explorer
        The explorer.
    robot : int
        Its robot.
    usual : str
        What to do about an exception that does not tell more.

    Returns
    -------
    generator
        What its `run()` returns.

    Raises
    ------
    ExplorerDefect
        If that is no generator, or `run()` raises an exception, which is its cause then.
    """
    returned: Any
    try:
        returned = explorer.run()
    except ExplorerDefect:
        raise
    except (Exception, SystemExit) as error:
        _refuse_error(explorer, error, robot, usual)
    if isinstance(returned, CoroutineType) or hasattr(returned, "asend"):
        refuse(robot, "its run() is asynchronous", "write def run(self), not async def")
    if not hasattr(returned, "send"):
        what = "None" if returned is None else article(type(returned).__name__)
        refuse(
            robot,
            f"its run() returned {what}, not a generator",
            "have it yield every action, as in scan = yield Sense(), and at last yield Done(...)",
        )
    return cast(Steps, returned)


def next_action(
    explorer: Explorer, actions: Steps, outcome: Outcome, robot: int, usual: str = TRY_IT
) -> Action:
    """Return what an explorer yields when it is sent the outcome of its last action.

    Parameters
    ----------
    explorer : Explorer
        The explorer.
    actions : generator
        What `begin` returned.
    outcome : Outcome
        The outcome.
    robot : int
        Its robot.
    usual : str
        What to do about an exception that does not tell more.

    Returns
    -------
    Action
        What it yields, which may be no action: see `refuse_action`.

    Raises
    ------
    ExplorerDefect
        If `run()` returns, or raises an exception, which is its cause then.
    """
    try:
        return actions.send(outcome)
    except StopIteration:
        refuse(
            robot,
            "its run() ended without a last action Done",
            "yield Done(complete=..., reason=...) before it returns",
        )
    except ExplorerDefect:
        raise
    except (Exception, SystemExit) as error:
        _refuse_error(explorer, error, robot, usual)


def require_in_order(action: object, robot: int, *, moves: bool) -> None:
    """Check that an action comes while the robot can carry it out.

    Parameters
    ----------
    action : object
        What its explorer yielded.
    robot : int
        The robot.
    moves : bool
        Whether a motion of it goes on.

    Raises
    ------
    ExplorerDefect
        If it sets out or is done on its way, or stops while it stands.
    """
    if moves and isinstance(action, Move | Done):
        refuse(
            robot,
            f"it yielded {type(action).__name__} while a motion goes on",
            "yield Receive to wait for its end, or Stop",
        )
    if not moves and isinstance(action, Stop):
        refuse(robot, "it yielded Stop, but it stands", "Stop ends a motion: Move first")


def refuse_action(action: object, robot: int) -> NoReturn:
    """Raise the error of an explorer that yields what is no action.

    Parameters
    ----------
    action : object
        What it yielded.
    robot : int
        Its robot.

    Raises
    ------
    ExplorerDefect
        Always; its remedy is what is yielded instead of such a thing.
    """
    what = f"it yielded {brief(action)}, which is no action"
    remedy = "yield instances of Sense, Look, Move, Stop, Send, Receive, Note and Done"
    match action:
        case None:
            what, remedy = "it yielded None, which is no action", "yield Sense(), not yield alone"
        case type() if action in get_args(Action):
            name = action.__name__
            what, remedy = f"it yielded the class {name}", f"yield an instance: {name}(...)"
        case GeneratorType():
            what = f"it yielded what {action.__name__}() returned, a generator"
            remedy = f"delegate to a procedure that yields actions: yield from {action.__name__}()"
        case Trajectory():
            remedy = "yield Move(trajectory=...) to follow it"
        case Message():
            remedy = "yield Send(...) to send it"
        case Event():
            remedy = "yield Note(...) to put it on record"
        case ExactScan() | LaserScan() | Moved() | Received() | TimedOut():
            what = f"it yielded {described(action)}, which is an outcome"
            remedy = "outcomes are what it is sent: scan = yield Sense()"
        case list() | tuple() if action and isinstance(action[0], Action):
            what = f"it yielded {len(action)} actions at once, in a {type(action).__name__}"
            remedy = "yield them one by one: each has an outcome"
    refuse(robot, what, remedy)


def _refuse_error(explorer: Explorer, error: BaseException, robot: int, usual: str) -> NoReturn:
    _pass_interrupt(error)
    what, remedy = error_flaw(type(explorer), error, usual)
    raise ExplorerDefect(what, f"the explorer of robot {robot}", remedy) from error


def _pass_interrupt(error: BaseException) -> None:
    # Compiled code that is interrupted raises a SystemError from the interrupt.
    if isinstance(error.__cause__, KeyboardInterrupt):
        raise error.__cause__ from None
