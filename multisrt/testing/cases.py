"""Runs of a checked explorer: supervised, driven by hand, repeated."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from types import ModuleType
from typing import Any

import numpy as np

from multisrt.environments.environment import Environment
from multisrt.events import Collision
from multisrt.recording import Recording, RunOutcome
from multisrt.robots.defects import ExplorerDefect, brief
from multisrt.robots.explorer import Action, Explorer, Move, Outcome, RobotSelf
from multisrt.robots.registry import registered
from multisrt.robots.strategy import Strategy
from multisrt.simulation.random_streams import random_stream
from multisrt.simulation.simulate import simulate
from multisrt.spec import RunSpec
from multisrt.testing.account import differences
from multisrt.testing.fingerprint import fingerprint
from multisrt.testing.hidden_truth import named_by_code
from multisrt.testing.supervision import SupervisedExplorer, Supervision
from multisrt.testing.surroundings import modules_of, surroundings

DATA = (int, float, complex, str, bytes, tuple, list, dict, set, frozenset, deque, np.ndarray)
"""Types of class attributes, globals and defaults in which explorers might share state."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CheckedRun:
    """One of the runs of a checked explorer.

    Attributes
    ----------
    world : str
        Name of the world.
    robots : int
        Number of robots.
    outcome : {"complete", "stalled", "out_of_time"}
        How it ended.
    time_s : float
        When it ended, in the time of the run.
    actions : int
        Number of actions that the explorers yielded.
    digest : str
        Digest of the recording.
    differences : tuple of str
        Where the explorers' own account and their scans differ; see
        `multisrt.testing.account.differences`.

    Examples
    --------
    >>> run = CheckedRun(
    ...     world="hall", robots=2, outcome="complete", time_s=81.4, actions=60, digest="0" * 64
    ... )
    >>> print(run)
    2 robots in 'hall': complete after 81 s, 60 actions
    """

    world: str
    robots: int
    outcome: RunOutcome
    time_s: float
    actions: int
    digest: str
    differences: tuple[str, ...] = ()

    def __str__(self) -> str:
        team = "1 robot" if self.robots == 1 else f"{self.robots} robots"
        return "\n".join(
            (
                f"{team} in {self.world!r}: {self.outcome} after {self.time_s:.0f} s, "
                f"{self.actions} actions",
                *(f"  it {difference}" for difference in self.differences),
            )
        )


class Case:
    """One team in one world, run in several ways.

    Parameters
    ----------
    strategy : Strategy
        What builds the explorers.
    spec : RunSpec
        The run.
    world : Environment
        The world.
    """

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
        """Return a new explorer.

        Raises
        ------
        ExplorerDefect
            If it cannot be built.
        """
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
        """Run the explorers in the simulation, and check everything that they do."""
        supervision = Supervision(
            self.world, self.title, max_actions=max_actions, only_known=only_known
        )
        kept: dict[str, bytes] = {}

        def explorer(me: RobotSelf, _: Any) -> Explorer:
            made = self.make(me)
            if not kept:
                self.modules = modules_of(type(made))
                kept.update(_kept_by(type(made)))
            return supervision.supervise(me, made)

        # One explorer is built beforehand, as its modules may have names for clocks.
        self.modules = modules_of(type(self.make(self._sample())))
        with surroundings(self.modules, seed=1, clock_s=1e9):
            recording = self._simulate(explorer, supervision)
        supervision.finish()
        self._check_end(recording, supervision)
        self.recording, self.robots = recording, supervision.robots
        now = _kept_by(type(self.make(self._sample())))
        self.changed = [name for name, mark in kept.items() if now.get(name, mark) != mark]

    def repeat_by_hand(self) -> None:
        """Send each explorer the same outcomes in other surroundings, and compare its actions."""
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
            with surroundings(self.modules, seed=seed, clock_s=clock_s):
                for repeated in self.repetitions(why, remedy):
                    while repeated.advance():
                        pass

    def repetitions(self, why: str, remedy: str) -> Iterator[Repetition]:
        """Yield new explorers of the whole team, to be driven by hand."""
        for robot in self.robots:
            rng = random_stream(self.spec.seed, "robots", robot.me.robot)
            explorer = self.make(replace(robot.me, rng=rng))
            yield Repetition(self, robot, explorer.run(), why, remedy)

    def repeat(self) -> None:
        """Run the same spec again without supervision, and compare the digests."""
        assert self.recording is not None
        with surroundings(self.modules, seed=3, clock_s=3e9):
            again = self._simulate(lambda me, _: self.make(me), None)
        if again.footer.digest != self.recording.footer.digest:
            raise self._defect(
                "a second run of the same spec has another digest",
                "decide by what the explorer was sent alone, and draw from the RobotSelf's rng",
            )

    def summary(self) -> CheckedRun:
        """Return how the run went."""
        assert self.recording is not None
        footer = self.recording.footer
        return CheckedRun(
            world=self.world.name,
            robots=len(self.robots),
            outcome=footer.outcome,
            time_s=footer.time_s,
            actions=sum(len(robot.turns) for robot in self.robots),
            digest=footer.digest,
            differences=differences(self.recording, self.world),
        )

    def _simulate(
        self, explorer: Callable[[RobotSelf, Any], Explorer], supervision: Supervision | None
    ) -> Recording:
        with registered(replace(self.strategy, explorer=explorer)):
            try:
                return simulate(self.spec, self.world)
            except Exception:
                # The clock wraps exceptions of its processes: the defect itself is raised.
                if supervision is not None and supervision.defect is not None:
                    raise supervision.defect from supervision.defect.__cause__
                raise

    def _sample(self) -> RobotSelf:
        # A RobotSelf of this spec.
        told: list[RobotSelf] = []

        class Idle(Exception):
            pass

        def explorer(me: RobotSelf, _: Any) -> Explorer:
            told.append(me)
            raise Idle

        with registered(replace(self.strategy, explorer=explorer)), suppress(Idle):
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


class Repetition:
    """An explorer that is driven by hand, and must act as it did before."""

    def __init__(
        self,
        case: Case,
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
        """Send it the next outcome; return whether there are more."""
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


def repeat_interleaved(cases: Sequence[Case]) -> None:
    """Drive all explorers of all cases by hand, in turns, and compare their actions."""
    modules = list({id(m): m for case in cases for m in case.modules}.values())
    with surroundings(modules, seed=1, clock_s=1e9):
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
    return brief(action, 120)


def _kept_by(cls: type) -> dict[str, bytes]:
    # Fingerprints of the data that all explorers of a class share, by name.
    return {
        name: fingerprint(value)
        for name, value in named_by_code(cls).items()
        if isinstance(value, DATA)
    }
