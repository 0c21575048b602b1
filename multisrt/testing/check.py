"""A checker for new explorers.

`check_explorer`, or ``multisrt check mine.py``, runs an explorer in a few small worlds, alone and
in a team, with the real simulation. It stops at the first defect with one clear `ExplorerDefect`:
what the explorer did, in which run and at which action, and what to change. It needs no test
framework; in a test, a call is enough.

**Defects** are violations of the contract of `multisrt.robots.explorer`, with which results would
be worthless or impossible. It is checked that

- runs repeat: equal specs give equal digests, and an explorer that is sent the same outcomes
  again acts as before; also after other runs, among other explorers, with other states of the
  global random generators, at another time of day, and in another process, where sets have
  another order (if it can be imported there: not from a notebook);
- it shares no state with explorers that run at the same time;
- it changes nothing that it is given, and nothing that it has sent;
- it yields only actions, with values of the types that they declare, which its body can carry
  out: trajectories begin where the robot is, run forwards in time, and keep to its kinematics;
- its body stays in what the robot has sensed, or may have been told of;
- neither what it holds nor what its code names leads to the world or to the simulation, and it
  names no back door to them (``gc.get_objects``, frames, ``importlib``, ``eval``, a module that is
  given to ``getattr`` or ``attrgetter``);
- it opens no file and starts no program while it runs: neither by ``open`` nor by a path that it
  holds (``read_text``); what it needs is read where it is built;
- no line of its code makes a generator or an action and drops it, where `yield from` or `yield`
  was forgotten;
- it does not collide, and ends with `Done`: in time, in a number of actions, without standing
  still in time, and without computing for long before it yields.

**Warnings** are about behaviour that the contract allows but that is probably unintended: an
explorer that ends at once, never senses or never moves, that reports completion where little was
covered, covers little everywhere, stalls in a team where one robot alone completes, never ends
while a robot that has died stands in the only doorway, or sends nodes that nobody records as
`Learned`. They are not defects: such runs are valid, if useless, and a baseline may stand still.

**Notes** say where its own account of a run and its scans differ: it records no nodes, or nodes
that hold less or more than was seen, or no `MapComplete`.

What is cheap comes first: each world is explored by one robot before a team, and every action is
checked as it is yielded. What takes too long before it yields is interrupted by a timer of the
operating system, in the main thread and on Unix only; the message names the line where it was.

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
>>> print(check_explorer(Glance, worlds=[two_rooms()], repeat_in_process=False))
glance keeps to the contract of explorers, with a warning:
  repeats; shares no state; changes nothing that it is given; yields what its body can do;
  stays in what it knows; does not reach the truth; does not collide; ends
  1 robot in 'two rooms': stalled after 0 s, 38.8 % covered, 2 actions
  3 robots in 'two rooms': stalled after 0 s, 92.1 % covered, 6 actions
  note: it notes no node, and is measured by its scans
WARNING: it never moves: it sees what can be seen from its start alone; yield Move(...) to a place
that its scan shows to be free

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
from itertools import zip_longest
from textwrap import fill, indent
from time import monotonic

import shapely

from multisrt.environments.catalog import environment
from multisrt.environments.environment import Environment
from multisrt.geometry.errors import InvalidInputError
from multisrt.robots.defects import ExplorerDefect
from multisrt.robots.explorer import Explorer
from multisrt.robots.loading import is_reference, load_strategy, require_no_folder
from multisrt.robots.registry import strategy as strategy_of_name
from multisrt.robots.strategy import Strategy
from multisrt.simulation.worlds import build_environment, inline
from multisrt.spec import RadioSpec, RobotSpec, RunSpec, StopRule
from multisrt.testing.cases import Case, repeat_interleaved
from multisrt.testing.check_warnings import warnings_about
from multisrt.testing.checked_run import CheckedRun
from multisrt.testing.doorway import waits_for_ever
from multisrt.testing.other_process import digests_elsewhere, require_first
from multisrt.testing.watchdog import Limits, Watchdog

__all__ = ["CheckedExplorer", "CheckedRun", "ExplorerDefect", "check_explorer", "two_rooms"]

Make = Callable[..., Explorer]
"""What builds the explorer of one robot from its `RobotSelf`, and options if there are any."""

Progress = Callable[[str, int, int], None]
"""Called with the current activity, the number of finished steps, and the number of all steps."""

IN_PROCESS = "repeats in another process"

CHECKS = (
    "repeats",
    IN_PROCESS,
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
        Name of the strategy.
    checks : tuple of str
        What was checked.
    runs : tuple of CheckedRun
        Its runs.
    warnings : tuple of str
        Behaviour that is allowed but probably unintended; see `multisrt.testing.check`.
    unchecked : tuple of str
        What could not be checked, and why.

    Examples
    --------
    >>> from multisrt.robots.explorer import Done
    >>> class Idle:
    ...     def __init__(self, me):
    ...         self.me = me
    ...
    ...     def run(self):
    ...         yield Done(complete=False, reason="has nothing to do")
    >>> checked = check_explorer(Idle, worlds=[two_rooms()], teams=[1], repeat_in_process=False)
    >>> checked.runs[0].outcome, checked.runs[0].covered, len(checked.warnings)
    ('stalled', 0.0, 1)
    """

    name: str
    checks: tuple[str, ...]
    runs: tuple[CheckedRun, ...]
    warnings: tuple[str, ...] = ()
    unchecked: tuple[str, ...] = ()

    def __str__(self) -> str:
        half = (len(self.checks) + 1) // 2
        count = len(self.warnings)
        end = "" if count == 0 else ", with a warning" if count == 1 else f", with {count} warnings"
        return "\n".join(
            (
                f"{self.name} keeps to the contract of explorers{end}:",
                f"  {'; '.join(self.checks[:half])};",
                f"  {'; '.join(self.checks[half:])}",
                *(indent(str(run), "  ") for run in self.runs),
                *(f"  note: it {note}" for note in self._notes()),
                *(fill(f"  not checked: {what}", 99) for what in self.unchecked),
                *(fill(f"WARNING: {warning}", 99) for warning in self.warnings),
            )
        )

    def _notes(self) -> list[str]:
        # Every difference once, with the runs if it is not that of all.
        runs_with: dict[str, list[str]] = {}
        for run in self.runs:
            for difference in run.differences:
                runs_with.setdefault(difference, []).append(run.title)
        return [
            note if len(titles) == len(self.runs) else f"{note} ({', '.join(titles)})"
            for note, titles in runs_with.items()
        ]


def check_explorer(
    make: Make | Strategy | str,
    *,
    options: Mapping[str, object] | None = None,
    worlds: Sequence[Environment] | None = None,
    teams: Sequence[int] = TEAMS,
    robot: RobotSpec | None = None,
    radio: RadioSpec | None = None,
    seed: int = 1,
    max_time_s: float = 10_000.0,
    max_actions: int = 10_000,
    max_decision_s: float = 10.0,
    only_known: bool = True,
    repeat_in_process: bool = True,
    progress: Progress | None = None,
) -> CheckedExplorer:
    """Check that an explorer keeps to the contract.

    Parameters
    ----------
    make : callable, Strategy or str
        The class of the explorer, or a function that builds one, as `Strategy.of` takes them; a
        strategy; the name of one that is registered, or a reference: ``mine.py:Mine``.
    options : mapping, optional
        Options that are not the defaults.
    worlds : sequence of Environment, optional
        Where to explore; by default two rooms, a hall with columns and a maze, all small. A team
        then also meets a robot that has died in the doorway between two rooms.
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
    max_decision_s : float
        Computing time in seconds that an explorer may take before it yields an action.
    only_known : bool
        Whether a body must stay in what its robot has sensed, or may have been told of: what the
        sender of a message knew when it sent it.
    repeat_in_process : bool
        Whether the runs are also repeated in another process, where sets iterate in another order.
    progress : callable, optional
        Called with what is being done, the steps that are done and their number.

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
    require_first()
    are_usual = worlds is None and max(teams, default=0) > 1
    worlds = _small_worlds() if worlds is None else worlds
    if not worlds or not teams:
        raise InvalidInputError("give check_explorer at least one world and one team")
    strategy = _strategy_of(make)
    strategy.parse_options(options or {})
    # As other processes build them.
    described = [inline(world) for world in worlds]
    worlds = [build_environment(world) for world in described]
    limits = Limits(max_time_s=max_time_s, max_actions=max_actions, max_decision_s=max_decision_s)
    robot, radio = robot or RobotSpec(), radio or RadioSpec()
    with Watchdog(max_decision_s) as watchdog:
        cases = [
            Case(
                strategy,
                RunSpec(
                    environment=description,
                    strategy=strategy.name,
                    options=dict(options or {}),  # type: ignore[arg-type]
                    robots=(robot,) * size,
                    radio=radio,
                    stop=StopRule(max_time_s=max_time_s),
                    seed=seed,
                ),
                world,
                limits=limits,
                watchdog=watchdog,
                only_known=only_known,
            )
            for world, description in zip(worlds, described, strict=True)
            for size in teams
        ]
        unchecked, waits = _run_all(
            cases, repeat_in_process, progress or (lambda *_: None), doorway=are_usual
        )
    runs = tuple(case.summary() for case in cases)
    left_out = {
        "stays in what it knows": not only_known,
        IN_PROCESS: not repeat_in_process or bool(unchecked),
    }
    return CheckedExplorer(
        name=strategy.name,
        checks=tuple(check for check in CHECKS if not left_out.get(check, False)),
        runs=runs,
        warnings=(*warnings_about(runs, cases[0].cls), *waits),
        unchecked=unchecked,
    )


def _run_all(
    cases: Sequence[Case], repeat_in_process: bool, progress: Progress, *, doorway: bool
) -> tuple[tuple[str, ...], tuple[str, ...]]:
    # What finds most comes first; later steps repeat what has been done. Returns what cannot be
    # checked, and what an explorer does that waits for ever.
    total, began_s = 2 * len(cases) + 2 + doorway, monotonic()
    for done, case in enumerate(cases):
        progress(f"exploring {case.title}", done, total)
        case.run_supervised()
        case.repeat_by_hand()
    progress("repeating all at once", len(cases), total)
    repeat_interleaved(cases)
    # In reverse order, so that other runs come before each of them.
    for done, case in enumerate(reversed(cases)):
        progress(f"repeating {case.title}", len(cases) + 1 + done, total)
        case.repeat()
    limit_s = 10.0 * (monotonic() - began_s)
    waits: tuple[str, ...] = ()
    if doorway:
        progress("exploring beside a robot in a doorway", 2 * len(cases) + 1, total)
        waits = tuple(filter(None, (waits_for_ever(cases[0]),)))
    if not repeat_in_process:
        return (), waits
    progress("repeating in another process", total - 1, total)
    try:
        specs = [case.spec for case in cases]
        digests, reason = digests_elsewhere(cases[0].strategy, specs, limit_s)
    except InvalidInputError as error:
        why = str(error).partition(": ")[2].partition(";")[0] or str(error)
        return (f"{IN_PROCESS}, since it cannot be imported there: {why}",), waits
    for case, digest in zip_longest(cases, digests):
        case.compare_elsewhere(digest, reason)
    return (), waits


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


def _strategy_of(make: Make | Strategy | str) -> Strategy:
    if isinstance(make, Strategy):
        return make
    if isinstance(make, str):
        require_no_folder(make)
        return load_strategy(make) if is_reference(make) else strategy_of_name(make)
    is_lambda = getattr(make, "__name__", "") == "<lambda>"
    return Strategy.of(make, name="own-explorer" if is_lambda else None)
