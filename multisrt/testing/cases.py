"""Runs of a checked explorer: supervised, driven by hand, repeated."""

from __future__ import annotations

import inspect
from collections import Counter, deque
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import replace
from types import ModuleType
from typing import Any, NoReturn

import numpy as np

from multisrt.environments.environment import Environment
from multisrt.events import Collision, Died, Learned
from multisrt.geometry.errors import InvalidInputError
from multisrt.recording import Recording
from multisrt.robots.code_places import modules_of, place_suffix
from multisrt.robots.defects import ExplorerDefect, Flaw
from multisrt.robots.error_flaw import error_flaw
from multisrt.robots.explorer import Explorer, RobotSelf
from multisrt.robots.naming import named_robots
from multisrt.robots.registry import registered
from multisrt.robots.strategy import Strategy
from multisrt.simulation.protocol import FROM_ITS_OWN, begin, build
from multisrt.simulation.random_streams import random_stream
from multisrt.simulation.simulate import simulate
from multisrt.simulation.standstill import NOTHING_NEW, WAITS_FOR_EVER
from multisrt.spec import RunSpec
from multisrt.testing.checked_run import CheckedRun
from multisrt.testing.code_reading import OwnCode, own_code_of
from multisrt.testing.fingerprint import fingerprint
from multisrt.testing.forgotten import forgotten_yield
from multisrt.testing.hidden_truth import named_by_code
from multisrt.testing.own_code import (
    chance_in,
    clocks_in,
    order_in,
    place_of_frame,
)
from multisrt.testing.repetition import ActionDiffers, Repetition
from multisrt.testing.sent_nodes import is_sent_nodes
from multisrt.testing.supervision import SupervisedExplorer, Supervision
from multisrt.testing.surroundings import surroundings
from multisrt.testing.unfinished import unfinished
from multisrt.testing.watchdog import ComputesTooLong, Limits, Watchdog

DATA = (int, float, complex, str, bytes, tuple, list, dict, set, frozenset, deque, np.ndarray)
"""Types of class attributes, globals and defaults in which explorers might share state."""


OWN_STATE = "keep everything in self: no class attribute, global or default that changes"
OWN_STREAM = "draw random numbers from the rng of its RobotSelf alone"


class NeverEnds(ExplorerDefect):
    """Explorers are not done when nothing more happens, or when the time is over."""


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
    limits : Limits
        By when its explorers must be done.
    watchdog : Watchdog
        Calls explorers.
    only_known : bool
        Whether a body must stay in what its robot has sensed or may have been told of.
    """

    def __init__(
        self,
        strategy: Strategy,
        spec: RunSpec,
        world: Environment,
        *,
        limits: Limits,
        watchdog: Watchdog,
        only_known: bool,
    ) -> None:
        self.strategy = strategy
        self.spec = spec
        self.world = world
        self.options = strategy.parse_options(spec.options)
        self.title = repr(world.name)
        self.robots: list[SupervisedExplorer] = []
        self.recording: Recording | None = None
        self.changed: list[str] = []
        self.modules: list[ModuleType] = []
        self.cls: type = object
        self.own_code: OwnCode = object
        self._limits = limits
        self._watchdog = watchdog
        self._only_known = only_known

    def again(self, spec: RunSpec, world: Environment) -> Case:
        """Return a case of the same explorer in another run."""
        return Case(
            self.strategy,
            spec,
            world,
            limits=self._limits,
            watchdog=self._watchdog,
            only_known=self._only_known,
        )

    def make(self, me: RobotSelf) -> Explorer:
        """Return a new explorer.

        Raises
        ------
        ExplorerDefect
            If it cannot be built.
        """
        built_by = inspect.unwrap(self.strategy.explorer)
        try:
            return self._watchdog.call(build, self.strategy.explorer, me, self.options)
        except ComputesTooLong as late:
            place = place_suffix(place_of_frame(built_by, late.frame))
            raise self._defect(
                f"building the explorer of robot {me.robot} has taken "
                f"{self._limits.max_decision_s:g} s{place}",
                "keep the constructor fast: long computations belong in run()",
            ) from None
        except ExplorerDefect as defect:
            raise self._defect(f"{defect.where}: {defect.what}", defect.remedy) from defect
        except InvalidInputError as error:
            flaw = error_flaw(built_by, error, FROM_ITS_OWN)
            raise self._defect(
                f"building the explorer of robot {me.robot}: {flaw.what}", flaw.remedy
            ) from error

    def run_supervised(self) -> None:
        """Run the explorers in the simulation, and check everything that they do."""
        supervision = Supervision(
            self.world,
            self.title,
            limits=self._limits,
            watchdog=self._watchdog,
            only_known=self._only_known,
        )
        kept: dict[str, bytes] = {}

        def explorer(me: RobotSelf, _: Any) -> Explorer:
            made = self.make(me)
            if not kept:
                kept.update(_kept_by(own_code_of(made)))
            return supervision.supervise(me, made)

        # One explorer is built beforehand, as its modules may have names for clocks.
        sample = self._sample()
        made = self.make(sample)
        self.cls, self.own_code = type(made), own_code_of(made)
        self.modules = modules_of(self.own_code)
        if (flaw := forgotten_yield(self.cls)) is not None:
            raise self._defect(*flaw)
        with surroundings(self.modules, seed=1, clock_s=1e9):
            recording = self._simulate(explorer, supervision)
        supervision.finish()
        self._check_end(recording, supervision)
        self.recording, self.robots = recording, supervision.robots
        now = _kept_by(self.own_code)
        self.changed = [name for name, mark in kept.items() if now.get(name, mark) != mark]

    def repeat_by_hand(self) -> None:
        """Send each explorer the same outcomes in other surroundings, and compare its actions."""
        try:
            self._drive(seed=2, clock_s=2e9)
        except ActionDiffers as other:
            self._explain(other)

    def _drive(self, *, seed: int, clock_s: float) -> None:
        with surroundings(self.modules, seed=seed, clock_s=clock_s) as were_drawn:
            try:
                for repeated in self.repetitions():
                    while repeated.advance():
                        pass
            except ActionDiffers as other:
                other.has_drawn = were_drawn()
                raise

    def _explain(self, other: ActionDiffers) -> NoReturn:
        # By what is left of the difference if one thing is as it was before.
        try:
            self._drive(seed=1, clock_s=1e9)
        except ActionDiffers as again:
            raise again.defect(*self._unknown_cause()) from None
        try:
            self._drive(seed=2, clock_s=1e9)
        except ActionDiffers as again:
            if not again.has_drawn:
                raise again.defect(*self._unknown_cause()) from None
            why = f"it draws on global random numbers{_after(chance_in(self.own_code))}"
            raise again.defect(why, OWN_STREAM) from None
        raise other.defect(
            f"it reads a clock{_after(clocks_in(self.own_code))}",
            "use the times of scans, motions and messages instead",
        )

    def _unknown_cause(self) -> Flaw:
        # Why it may act otherwise in the same surroundings.
        if self.changed:
            return Flaw(f"{self.changed[0]} changes, which explorers share", OWN_STATE)
        if chance := chance_in(self.own_code):
            return Flaw(f"it draws on other random numbers: {chance}", OWN_STREAM)
        order = order_in(self.own_code)
        return Flaw(
            "it depends on something besides what it was sent"
            + (f": perhaps on memory addresses, {order}" if order else ""),
            f"{OWN_STREAM}; do not depend on the order of a set; {OWN_STATE}",
        )

    def repetitions(self) -> Iterator[Repetition]:
        """Yield new explorers of the whole team, to be driven by hand."""
        for robot in self.robots:
            rng = random_stream(self.spec.seed, "robots", robot.me.robot)
            explorer = self.make(replace(robot.me, rng=rng))
            yield Repetition(robot, begin(explorer, robot.me.robot), self.title, self._watchdog)

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

    def compare_elsewhere(self, digest: str | None, reason: str) -> None:
        """Compare its digest with that of the same run in another process.

        Parameters
        ----------
        digest : str or None
            The digest there; None if there is none.
        reason : str
            Why there is none.
        """
        assert self.recording is not None
        if digest is None:
            raise self._defect(
                f"in another process the same run does not end well: {reason}",
                "see that it depends on nothing that this process has done before",
            )
        if digest != self.recording.footer.digest:
            order = order_in(self.own_code)
            raise self._defect(
                "in another process, where sets iterate in another order, the same run has another "
                f"digest{_after(order)}",
                "do not depend on the order of a set: sort its elements, as in sorted(names)",
            )

    def summary(self) -> CheckedRun:
        """Return how the run went."""
        # Loaded late: an explorer that fails at once need not wait for what measures runs.
        from multisrt.testing.account import account

        assert self.recording is not None
        footer = self.recording.footer
        covered, differences = account(self.recording, self.world)
        kinds = Counter(type(turn.action).__name__ for robot in self.robots for turn in robot.turns)
        return CheckedRun(
            world=self.world.name,
            robots=len(self.robots),
            outcome=footer.outcome,
            time_s=footer.time_s,
            covered=covered,
            actions=dict(kinds),
            digest=footer.digest,
            differences=differences,
            unfinished=unfinished(self.recording),
            unlearned=not self.recording.of(Learned) and any(map(is_sent_nodes, self.robots)),
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

        class Idle(InvalidInputError):
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
        dead = {event.robot for event in recording.of(Died)}
        waiting = [
            robot for robot in supervision.robots if not (robot.is_done or robot.me.robot in dead)
        ]
        if not waiting:
            return
        names = _names([robot.me.robot for robot in waiting])
        last = waiting[0].last_actions()
        if recording.footer.outcome == "out_of_time":
            raise self._never_ends(
                f"{names} not done after {self.spec.stop.max_time_s:g} s; {last}",
                "see that every exploration ends with Done, or give a larger max_time_s "
                "(--max-time)",
            )
        if recording.footer.reason.startswith(NOTHING_NEW):
            raise self._never_ends(
                f"{names} not done: {recording.footer.reason}; {last}",
                "count how often it waits or is stopped at one place; after some attempts plan "
                "another way, and end with Done where there is none",
            )
        raise self._never_ends(
            f"{names} waiting {WAITS_FOR_EVER}",
            "give Receive a timeout_s, and end with Done",
        )

    def _defect(self, what: str, remedy: str) -> ExplorerDefect:
        return ExplorerDefect(what, self._who, remedy)

    def _never_ends(self, what: str, remedy: str) -> NeverEnds:
        return NeverEnds(what, self._who, remedy)

    @property
    def _who(self) -> str:
        team = len(self.spec.robots)
        who = "a robot alone" if team == 1 else f"a team of {team}"
        return f"{who} in {self.title}"


def repeat_interleaved(cases: Sequence[Case]) -> None:
    """Drive all explorers of all cases by hand, in turns, and compare their actions."""
    modules = list({id(m): m for case in cases for m in case.modules}.values())
    try:
        with surroundings(modules, seed=1, clock_s=1e9):
            going = [repetition for case in cases for repetition in case.repetitions()]
            while going:
                going = [repetition for repetition in going if repetition.advance()]
    except ActionDiffers as other:
        raise other.defect(
            "it shares state with explorers that run at the same time",
            OWN_STATE,
        ) from None


def _names(robots: list[int]) -> str:
    return f"{named_robots(robots)} {'is' if len(robots) == 1 else 'are'}"


def _after(places: str) -> str:
    return f": {places}" if places else ""


def _kept_by(cls: OwnCode) -> dict[str, bytes]:
    # Fingerprints of the data that all explorers of a class share, by name.
    return {
        name: fingerprint(value)
        for name, value in named_by_code(cls).items()
        if isinstance(value, DATA)
    }
