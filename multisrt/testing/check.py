"""A checker for explorers of one's own.

`check_explorer` runs an explorer in a few small worlds, alone and in a team, with the real
simulation, and raises one clear `ExplorerDefect` if it does not keep to the contract of
`multisrt.robots.explorer`. It needs no test framework; in a test, a call is enough.

It checks that

- runs repeat: equal specs give equal digests, and an explorer that is driven by hand with what it
  was sent before acts as before; also after other runs, among other explorers, with other states
  of the global random generators, and at another time of day;
- nothing that it is given, and nothing that it has sent, is changed;
- all that it yields is an action that its body can carry out: trajectories begin where the robot
  is, run forwards in time, and keep to its kinematics;
- its body stays in what the robot has sensed, or may have been told of;
- neither what it holds nor what its code names leads to the world or to the simulation;
- it does not collide, and ends with `Done`.

It cannot notice an explorer that calculates for ever without yielding anything.

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
  3 robots in 'two rooms': stalled after 0 s, 6 actions

>>> class Blind(Glance):
...     '''Drives without looking.'''
...
...     def run(self):
...         x, y, heading = self.me.start
...         yield Move(trajectory=self.me.kinematics.drive(self.me.start, x + 1.0, y))
...         yield Done(complete=False, reason="enough")
>>> check_explorer(Blind, worlds=[two_rooms()])  # doctest: +ELLIPSIS
Traceback (most recent call last):
multisrt.testing.supervision.ExplorerDefect: the robot in 'two rooms', action 1: on its way from ...
"""

from __future__ import annotations

import datetime
import random
import sys
import time
from collections import deque
from collections.abc import Callable, Generator, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass, replace
from itertools import count
from types import ModuleType
from typing import Any

import msgspec
import numpy as np
import shapely

from multisrt.environments.catalog import environment
from multisrt.environments.environment import Environment
from multisrt.events import Collision
from multisrt.geometry.errors import InvalidInputError
from multisrt.recording import Recording, RunOutcome
from multisrt.robots import registry
from multisrt.robots.explorer import Action, Explorer, Move, Outcome, RobotSelf
from multisrt.robots.registry import Strategy
from multisrt.simulation.simulate import simulate
from multisrt.simulation.worlds import inline
from multisrt.spec import RadioSpec, RobotSpec, RunSpec, StopRule, random_stream
from multisrt.testing.hidden_truth import named_by_code
from multisrt.testing.supervision import (
    ExplorerDefect,
    SupervisedExplorer,
    Supervision,
    fingerprint,
)

__all__ = ["CheckedExplorer", "CheckedRun", "ExplorerDefect", "check_explorer", "two_rooms"]

Make = Callable[[RobotSelf], Explorer]
"""Builds one robot's explorer from what the robot knows of itself."""

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

DATA = (int, float, complex, str, bytes, tuple, list, dict, set, frozenset, deque, np.ndarray)
"""State that explorers share is looked for in class attributes, globals and defaults of these."""

TEAMS = (1, 3)
"""So many robots explore each world, one team after the other."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CheckedRun:
    """One of the runs that a checked explorer made.

    Attributes
    ----------
    world : str
        Name of the world.
    robots : int
        How many explored it.
    outcome : {"complete", "stalled", "out_of_time"}
        How it ended.
    time_s : float
        When, by the run's own clock.
    actions : int
        How many actions the explorers yielded.
    digest : str
        The recording's.
    """

    world: str
    robots: int
    outcome: RunOutcome
    time_s: float
    actions: int
    digest: str

    def __str__(self) -> str:
        team = "1 robot" if self.robots == 1 else f"{self.robots} robots"
        return (
            f"{team} in {self.world!r}: {self.outcome} after {self.time_s:.0f} s, "
            f"{self.actions} actions"
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class CheckedExplorer:
    """An explorer without a defect, and what it was checked for; printing it tells all.

    Attributes
    ----------
    name : str
        What it is called.
    checks : tuple of str
        What was checked.
    runs : tuple of CheckedRun
        The runs that it made.
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
                *(f"  {run}" for run in self.runs),
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
        What builds one robot's explorer from its `RobotSelf`: a function, a class, or a strategy.
    options : mapping, optional
        A strategy's parameters, where they are not its defaults.
    worlds : sequence of Environment, optional
        Where to explore; two rooms, a hall with columns and a maze by default, all small.
    teams : sequence of int
        How many robots explore each world.
    robot : RobotSpec, optional
        Body, drive and range finder of every robot.
    radio : RadioSpec, optional
        How messages travel; everywhere and at once by default.
    seed : int
        Seed of all runs.
    max_time_s : float
        By this time of its own clock every run ought to be over.
    max_actions : int
        After so many actions every explorer ought to be done.
    only_known : bool
        Whether a body has to stay in what its robot has sensed, or may have been told of: what
        the sender of a message knew when it sent it.

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
        _Case(strategy, spec, world)
        for spec, world in zip(specs, (w for w in worlds for _ in teams), strict=True)
    ]
    for case in cases:
        case.run_supervised(max_actions, only_known)
        case.repeat_by_hand()
    _repeat_interleaved(cases)
    # In reverse order, so that every run comes after other ones than before.
    for case in reversed(cases):
        case.repeat()
    return CheckedExplorer(
        name=strategy.name,
        checks=tuple(c for c in CHECKS if only_known or c != "stays in what it knows"),
        runs=tuple(case.summary() for case in cases),
    )


def two_rooms() -> Environment:
    """Give a small world: two rooms of 6 m x 5 m with an open door between them."""
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


class _Case:
    """One team in one world."""

    def __init__(self, strategy: Strategy, spec: RunSpec, world: Environment) -> None:
        self.strategy = strategy
        self.spec = spec
        self.world = world
        self.options = strategy.parse_options(spec.options)
        self.title = repr(world.name)
        self.robots: list[SupervisedExplorer] = []
        self.recording: Recording | None = None
        self.changed: list[str] = []
        self.modules: list[ModuleType] = []

    def make(self, me: RobotSelf) -> Explorer:
        """Build an explorer; that it can be built is part of the contract."""
        try:
            explorer = self.strategy.explorer(me, self.options)
        except Exception as error:
            raise self._defect(
                f"building the explorer of robot {me.robot} raised {type(error).__name__}: {error}",
                "build it from the RobotSelf alone",
            ) from error
        if not callable(getattr(explorer, "run", None)):
            raise self._defect(
                f"what was built for robot {me.robot} is a {type(explorer).__name__}, which has "
                "no run()",
                "give what builds an explorer: an object whose run() is a generator of actions",
            )
        return explorer

    def run_supervised(self, max_actions: int, only_known: bool) -> None:
        """Run the explorers in the simulation, and check all that they do."""
        supervision = Supervision(
            self.world, self.title, max_actions=max_actions, only_known=only_known
        )
        kept: dict[str, bytes] = {}

        def explorer(me: RobotSelf, _: Any) -> Explorer:
            made = self.make(me)
            if not kept:
                self.modules = _modules_of(type(made))
                kept.update(_kept_by(type(made)))
            return supervision.supervise(me, made)

        # One is built beforehand: which clocks it can read is known by its modules.
        self.modules = _modules_of(type(self.make(self._sample())))
        with _surroundings(self.modules, seed=1, clock_s=1e9):
            recording = self._simulate(explorer, supervision)
        supervision.finish()
        self._check_end(recording, supervision)
        self.recording, self.robots = recording, supervision.robots
        now = _kept_by(type(self.make(self._sample())))
        self.changed = [name for name, mark in kept.items() if now.get(name, mark) != mark]

    def repeat_by_hand(self) -> None:
        """Send each explorer what it was sent, one after the other, in other surroundings."""
        state = "keep everything in self: no class attribute, global or default that changes"
        stream = "draw random numbers from the RobotSelf's rng alone; let no order of a set decide"
        changed = self.changed[0] if self.changed else None
        explained = (
            (1, 1e9, f"{changed} changes, which explorers share", state)
            if changed
            else (1, 1e9, "it draws on something besides what it was sent", f"{stream}; {state}")
        )
        for seed, clock_s, why, remedy in (
            explained,
            (2, 1e9, "it draws on global random numbers", "draw from the RobotSelf's rng"),
            (1, 2e9, "it reads a clock", "the time is told with scans, motions and messages"),
        ):
            with _surroundings(self.modules, seed=seed, clock_s=clock_s):
                for repeated in self.repetitions(why, remedy):
                    while repeated.advance():
                        pass

    def repetitions(self, why: str, remedy: str) -> Iterator[_Repetition]:
        """Give every explorer of the team anew, to be driven by hand."""
        for robot in self.robots:
            rng = random_stream(self.spec.seed, "robots", robot.me.robot)
            explorer = self.make(replace(robot.me, rng=rng))
            yield _Repetition(self, robot, explorer.run(), why, remedy)

    def repeat(self) -> None:
        """Run the same spec again, without supervision, and compare the digests."""
        assert self.recording is not None
        with _surroundings(self.modules, seed=3, clock_s=3e9):
            again = self._simulate(lambda me, _: self.make(me), None)
        if again.footer.digest != self.recording.footer.digest:
            raise self._defect(
                "a second run of the same spec has another digest",
                "decide by what the explorer was sent alone, and draw from the RobotSelf's rng",
            )

    def summary(self) -> CheckedRun:
        """Say how the run went."""
        assert self.recording is not None
        footer = self.recording.footer
        return CheckedRun(
            world=self.world.name,
            robots=len(self.robots),
            outcome=footer.outcome,
            time_s=footer.time_s,
            actions=sum(len(robot.turns) for robot in self.robots),
            digest=footer.digest,
        )

    def _simulate(
        self, explorer: Callable[[RobotSelf, Any], Explorer], supervision: Supervision | None
    ) -> Recording:
        with _registered(replace(self.strategy, explorer=explorer)):
            try:
                return simulate(self.spec, self.world)
            except Exception:
                # The defect itself, not what became of it on its way through the clock.
                if supervision is not None and supervision.defect is not None:
                    raise supervision.defect from supervision.defect.__cause__
                raise

    def _sample(self) -> RobotSelf:
        # A RobotSelf of this spec, for an explorer that is built but never run.
        told: list[RobotSelf] = []

        class Idle(Exception):
            pass

        def explorer(me: RobotSelf, _: Any) -> Explorer:
            told.append(me)
            raise Idle

        with _registered(replace(self.strategy, explorer=explorer)), suppress(Idle):
            simulate(self.spec, self.world)
        return told[0]

    def _check_end(self, recording: Recording, supervision: Supervision) -> None:
        for event in recording.events:
            if isinstance(event, Collision):
                raise self._defect(
                    f"robot {event.robot} {event.account}, at {event.time_s:g} s",
                    "keep the body in what is sensed to be free; give Move a guard_m where other "
                    "robots are about",
                )
        waiting = [robot.me.robot for robot in supervision.robots if not robot.is_done]
        if recording.footer.outcome == "out_of_time":
            raise self._defect(
                f"robots {waiting} were not done after {self.spec.stop.max_time_s:g} s",
                "see that every exploration ends with Done, or give a larger max_time_s",
            )
        if waiting:
            raise self._defect(
                f"robots {waiting} wait for a message that never comes",
                "give Receive a timeout_s, and end with Done",
            )

    def _defect(self, what: str, remedy: str) -> ExplorerDefect:
        team = len(self.spec.robots)
        who = "a robot alone" if team == 1 else f"a team of {team}"
        return ExplorerDefect(what, f"{who} in {self.title}", remedy)


class _Repetition:
    """An explorer that is driven by hand, and ought to act as it did before."""

    def __init__(
        self,
        case: _Case,
        before: SupervisedExplorer,
        actions: Generator[Action, Outcome, None],
        why: str,
        remedy: str,
    ) -> None:
        self._case = case
        self._before = before
        self._actions = actions
        self._why = why
        self._remedy = remedy
        self._turn = 0

    def advance(self) -> bool:
        """Let it act once more; False when it has done all that it did before."""
        turn = self._before.turns[self._turn]
        self._turn += 1
        acted = "nothing"
        try:
            action = self._actions.send(turn.outcome)
        except StopIteration:
            pass
        except Exception as error:
            acted = f"{type(error).__name__}: {error}"
        else:
            if fingerprint(action) == turn.print:
                return self._turn < len(self._before.turns)
            acted = _described(action)
        me = self._before.me
        who = "the robot" if me.team == 1 else f"robot {me.robot} of {me.team}"
        raise ExplorerDefect(
            f"sent the same as before, it yielded {acted}, not {_described(turn.action)}: "
            f"{self._why}",
            f"{who} in {self._case.title}, action {self._turn}",
            self._remedy,
        )


def _repeat_interleaved(cases: Sequence[_Case]) -> None:
    """Drive all explorers of all teams by hand, in turns."""
    modules = list({id(m): m for case in cases for m in case.modules}.values())
    with _surroundings(modules, seed=1, clock_s=1e9):
        going = [
            repetition
            for case in cases
            for repetition in case.repetitions(
                "it shares state with explorers that run at the same time",
                "keep everything in self: no class attribute, global or default that changes",
            )
        ]
        while going:
            going = [repetition for repetition in going if repetition.advance()]


def _described(action: object) -> str:
    if isinstance(action, Move):
        x, y, heading = action.trajectory.end
        return f"Move to ({x:.6g}, {y:.6g}, {heading:.6g})"
    text = repr(action)
    return text if len(text) <= 120 else f"{text[:117]}..."


@contextmanager
def _registered(strategy: Strategy) -> Iterator[None]:
    # For as long as it runs; what has its name otherwise comes back.
    known = registry._registry()
    before = known.get(strategy.name)
    known[strategy.name] = strategy
    try:
        yield
    finally:
        del known[strategy.name]
        if before is not None:
            known[strategy.name] = before


def _modules_of(cls: type) -> list[ModuleType]:
    # The modules of an explorer's own package: they may have their own name for a clock.
    package = cls.__module__.partition(".")[0]
    if package == "multisrt":
        return []
    return [
        module
        for name, module in list(sys.modules.items())
        if isinstance(module, ModuleType) and name.partition(".")[0] == package
    ]


def _kept_by(cls: type) -> dict[str, bytes]:
    # Fingerprints of the data that all explorers of a class share.
    return {
        name: fingerprint(value)
        for name, value in named_by_code(cls).items()
        if isinstance(value, DATA)
    }


# Surroundings ------------------------------------------------------------------------------

CLOCKS = ("time", "monotonic", "perf_counter", "process_time", "thread_time")
"""Clocks of the module `time`; each has a twin that counts nanoseconds."""


@contextmanager
def _surroundings(modules: Sequence[ModuleType], *, seed: int, clock_s: float) -> Iterator[None]:
    """Give all that runs a state of the global random generators, and clocks of its own.

    Clocks begin at a time and go on by a millisecond whenever they are read, so that they are
    the same in every run and other ones where that is wanted.
    """
    states = random.getstate(), np.random.get_state()  # noqa: NPY002
    random.seed(seed)
    np.random.seed(seed)  # noqa: NPY002
    replaced = _clocks(clock_s)
    with ExitStack() as stack:
        stack.callback(np.random.set_state, states[1])
        stack.callback(random.setstate, states[0])
        for module in (time, datetime, *modules):
            for name, value in list(vars(module).items()):
                if (other := replaced.get(id(value))) is not None:
                    stack.callback(setattr, module, name, value)
                    setattr(module, name, other)
        yield


def _clocks(clock_s: float) -> dict[int, Any]:
    # What stands in for each clock, by the clock's id.
    ticks = count()

    def seconds() -> float:
        return clock_s + 1e-3 * next(ticks)

    class Datetime(datetime.datetime):
        @classmethod
        def now(cls, tz: datetime.tzinfo | None = None) -> Datetime:
            return cls.fromtimestamp(seconds(), tz)

        @classmethod
        def utcnow(cls) -> Datetime:
            return cls.fromtimestamp(seconds(), datetime.UTC).replace(tzinfo=None)

        @classmethod
        def today(cls) -> Datetime:
            return cls.fromtimestamp(seconds())

    replaced: dict[int, Any] = {id(datetime.datetime): Datetime}
    for name in CLOCKS:
        replaced[id(getattr(time, name))] = seconds
        replaced[id(getattr(time, f"{name}_ns"))] = lambda: int(1e9 * seconds())
    return replaced
