"""A checker for new explorers.

`check_explorer` runs an explorer in a few small worlds, alone and in a team, with the real
simulation, and raises one clear `ExplorerDefect` if it does not keep to the contract of
`multisrt.robots.explorer`. It needs no test framework; in a test, a call is enough.

It checks that

- runs repeat: equal specs give equal digests, and an explorer that is sent the same outcomes
  again acts as before; also after other runs, among other explorers, with other states of the
  global random generators, and at another time of day;
- it changes nothing that it is given, and nothing that it has sent;
- it yields only actions that its body can carry out: trajectories begin where the robot is, run
  forwards in time, and keep to its kinematics;
- its body stays in what the robot has sensed, or may have been told of;
- neither what it holds nor what its code names leads to the world or to the simulation;
- it does not collide, and ends with `Done`.

Where its own account of a run and its scans differ, the summary says so: it says that it is
complete where little was covered, or notes nodes that hold less or more than was seen. This is no
defect, since runs are measured by what they did.

An explorer that computes for ever without yielding anything cannot be detected.

>>> from multisrt.robots.explorer import Done, Move, Sense
>>> from multisrt.testing import check_explorer
>>> class Glance:
...     '''Looks round once.'''
...
...     def __init__(self, me):
...         self.me = me
...
...     def run(self):
...         scan = yield Sense()
...         yield Done(complete=False, reason=f"saw {len(scan.boundary)} corners")
>>> print(check_explorer(Glance, worlds=[two_rooms()]))
Glance keeps to the contract of explorers:
  repeats; shares no state; changes nothing that it is given; yields what its body can do;
  stays in what it knows; does not reach the truth; does not collide; ends
  1 robot in 'two rooms': stalled after 0 s, 2 actions
    it notes no node, and is measured by its scans
  3 robots in 'two rooms': stalled after 0 s, 6 actions
    it notes no node, and is measured by its scans

>>> class Blind(Glance):
...     '''Drives without looking.'''
...
...     def run(self):
...         x, y, heading = self.me.start
...         yield Move(trajectory=self.me.kinematics.drive(self.me.start, x + 1.0, y))
...         yield Done(complete=False, reason="enough")
>>> check_explorer(Blind, worlds=[two_rooms()])  # doctest: +ELLIPSIS
Traceback (most recent call last):
multisrt.robots.defects.ExplorerDefect: the robot in 'two rooms', action 1: on its way from ...
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from textwrap import indent

import msgspec
import shapely

from multisrt.environments.catalog import environment
from multisrt.environments.environment import Environment
from multisrt.geometry.errors import InvalidInputError
from multisrt.robots.defects import ExplorerDefect
from multisrt.robots.explorer import Explorer, RobotSelf
from multisrt.robots.strategy import Strategy
from multisrt.simulation.worlds import inline
from multisrt.spec import RadioSpec, RobotSpec, RunSpec, StopRule
from multisrt.testing.cases import Case, CheckedRun, repeat_interleaved

__all__ = ["CheckedExplorer", "CheckedRun", "ExplorerDefect", "check_explorer", "two_rooms"]

Make = Callable[[RobotSelf], Explorer]
"""A function that builds the explorer of one robot from what the robot knows of itself."""

CHECKS = (
    "repeats",
    "shares no state",
    "changes nothing that it is given",
    "yields what its body can do",
    "stays in what it knows",
    "does not reach the truth",
    "does not collide",
    "ends",
)
"""What is checked."""

TEAMS = (1, 3)
"""Sizes of the teams that explore each world by default."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CheckedExplorer:
    """An explorer without a defect, and what it was checked for; `print` shows a summary.

    Attributes
    ----------
    name : str
        Name of the strategy, the class or the function.
    checks : tuple of str
        What was checked.
    runs : tuple of CheckedRun
        Its runs.

    Examples
    --------
    >>> from multisrt.robots.explorer import Done
    >>> class Idle:
    ...     def __init__(self, me):
    ...         self.me = me
    ...
    ...     def run(self):
    ...         yield Done(complete=False, reason="has nothing to do")
    >>> checked = check_explorer(Idle, worlds=[two_rooms()], teams=[1])
    >>> checked.runs[0].outcome, checked.runs[0].actions, "ends" in checked.checks
    ('stalled', 1, True)
    """

    name: str
    checks: tuple[str, ...]
    runs: tuple[CheckedRun, ...]

    def __str__(self) -> str:
        half = (len(self.checks) + 1) // 2
        return "\n".join(
            (
                f"{self.name} keeps to the contract of explorers:",
                f"  {'; '.join(self.checks[:half])};",
                f"  {'; '.join(self.checks[half:])}",
                *(indent(str(run), "  ") for run in self.runs),
            )
        )


def check_explorer(
    make: Make | Strategy,
    *,
    options: Mapping[str, object] | None = None,
    worlds: Sequence[Environment] | None = None,
    teams: Sequence[int] = TEAMS,
    robot: RobotSpec | None = None,
    radio: RadioSpec | None = None,
    seed: int = 1,
    max_time_s: float = 20_000.0,
    max_actions: int = 20_000,
    only_known: bool = True,
) -> CheckedExplorer:
    """Check that an explorer keeps to the contract.

    Parameters
    ----------
    make : callable or Strategy
        What builds the explorer of a robot from its `RobotSelf`: a function, a class or a strategy.
    options : mapping, optional
        Options of a strategy that are not its defaults.
    worlds : sequence of Environment, optional
        Where to explore; by default two rooms, a hall with columns and a maze, all small.
    teams : sequence of int
        Numbers of robots that explore each world, one after the other.
    robot : RobotSpec, optional
        Body, drive and range finder of every robot.
    radio : RadioSpec, optional
        How messages travel; by default they reach all robots at once.
    seed : int
        Seed of all runs.
    max_time_s : float
        Time in seconds by which every run must be over.
    max_actions : int
        Number of actions by which every explorer must be done.
    only_known : bool
        Whether a body must stay in what its robot has sensed, or may have been told of: what the
        sender of a message knew when it sent it.

    Returns
    -------
    CheckedExplorer
        What was checked.

    Raises
    ------
    ExplorerDefect
        If the explorer does not keep to the contract; the message says what it did, where, and
        what to change.
    InvalidInputError
        If the explorer cannot be run at all: no team, options that are not the strategy's.

    Examples
    --------
    >>> from multisrt.robots.registry import strategy
    >>> checked = check_explorer(strategy("srt-radial"), worlds=[two_rooms()], teams=[1])
    >>> checked.runs[0].outcome
    'complete'
    """
    worlds = _small_worlds() if worlds is None else worlds
    if not worlds or not teams:
        raise InvalidInputError("give check_explorer at least one world and one team")
    strategy = _strategy_of(make, options)
    specs = [
        RunSpec(
            environment=inline(world),
            strategy=strategy.name,
            options=dict(options or {}),  # type: ignore[arg-type]
            robots=((RobotSpec() if robot is None else robot),) * size,
            radio=RadioSpec() if radio is None else radio,
            stop=StopRule(max_time_s=max_time_s),
            seed=seed,
        )
        for world in worlds
        for size in teams
    ]
    cases = [
        Case(strategy, spec, world)
        for spec, world in zip(specs, (w for w in worlds for _ in teams), strict=True)
    ]
    for case in cases:
        case.run_supervised(max_actions, only_known)
        case.repeat_by_hand()
    repeat_interleaved(cases)
    # In reverse order, so that other runs come before each of them.
    for case in reversed(cases):
        case.repeat()
    return CheckedExplorer(
        name=strategy.name,
        checks=tuple(c for c in CHECKS if only_known or c != "stays in what it knows"),
        runs=tuple(case.summary() for case in cases),
    )


def two_rooms() -> Environment:
    """Return a small world: two rooms of 6 m x 5 m with an open door between them.

    Returns
    -------
    Environment
        The world; its lower left corner is the origin.

    Examples
    --------
    >>> two_rooms().name
    'two rooms'
    """
    wall = shapely.box(6.0, 0.0, 6.2, 3.5)
    return Environment("two rooms", shapely.box(0.0, 0.0, 12.0, 5.0).difference(wall))


def _small_worlds() -> tuple[Environment, ...]:
    return (
        two_rooms(),
        environment("open", size_m=10.0, columns=3),
        environment("maze", size_m=8.0, cells=4, loops=0.3),
    )


class _NoOptions(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    pass


def _strategy_of(make: Make | Strategy, options: Mapping[str, object] | None) -> Strategy:
    if isinstance(make, Strategy):
        make.parse_options(options or {})
        return make
    if options:
        raise InvalidInputError("options are for a Strategy: a function gets a RobotSelf alone")
    return Strategy(
        name=getattr(make, "__name__", type(make).__name__),
        summary="An explorer that is checked.",
        options=_NoOptions,
        explorer=lambda me, _: make(me),
    )
