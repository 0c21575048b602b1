"""Step through a run from Python: `Stepper`."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterator
from pathlib import Path
from types import TracebackType
from typing import Any, Final, Unpack, get_args

from multisrt.environments.environment import Environment
from multisrt.events import (
    ArcClosed,
    ArcReopened,
    Event,
    Learned,
    MapComplete,
    NodeAdded,
    NotedEvent,
    PresumedLost,
)
from multisrt.finished_run import Run
from multisrt.geometry.errors import InvalidInputError
from multisrt.recording import Recording, atomic_write
from multisrt.robots.explorer import Action, Explorer, Note
from multisrt.run import INSTEAD, RunKeywords, spec_and_world, with_run_keywords
from multisrt.simulation.journal import Watcher
from multisrt.simulation.stepping import RobotState, Step, Stepping
from multisrt.spec import RunSpec
from multisrt.spec.keywords import refuse_unknown

NEWS: Final = (NodeAdded, Learned, MapComplete, ArcClosed, ArcReopened, PresumedLost)
"""Events that explorers record about their knowledge, not about their decisions."""

DECISIONS: Final = tuple(kind for kind in get_args(NotedEvent) if kind not in NEWS)
"""Events that record a decision of an explorer."""


CONDITIONS: Final = ("time_s", "robot", "action", "decision", "where")
"""The parameters of `Stepper.until`."""


class Stepper(Iterator[Step]):
    """A run that is stepped through, one action of one robot at a time.

    It pauses after an explorer has yielded an action and before the action is executed. The
    recording is the same, byte for byte, as that of a run without pauses.

    Parameters
    ----------
    environment : Environment, str, Path or RunSpec
        As for `multisrt.explore`.
    watch : callable, optional
        Called with every event as it happens.
    **keywords
        The keywords of `multisrt.explore` that describe the run.

    Attributes
    ----------
    steps : list of Step
        All steps so far: what each robot received, and what it did.

    Raises
    ------
    InvalidInputError
        If the arguments contradict each other or describe an impossible run.
    ExplorerDefect
        During a step, if an explorer has yielded an impossible action.

    Examples
    --------
    >>> import multisrt as ms
    >>> stepper = ms.Stepper("apartment", strategy="minpos", robots=2, seed=1)
    >>> step = next(stepper)
    >>> print(step)
    0.00 s  robot 0  Sense
    >>> step = stepper.run_until(robot=1, decision=True)
    >>> step.robot, type(step.action.event).__name__
    (1, 'GoalChosen')
    >>> stepper.robots[1].state
    'on'
    >>> run = stepper.finish()
    >>> run.digest == ms.explore("apartment", strategy="minpos", robots=2, seed=1).digest
    True
    """

    @with_run_keywords
    def __init__(
        self,
        environment: Environment | str | Path | RunSpec,
        *,
        watch: Watcher | None = None,
        **keywords: Unpack[RunKeywords],
    ) -> None:
        refuse_unknown("Stepper", keywords, inspect.signature(Stepper).parameters, INSTEAD)
        spec, self.environment = spec_and_world(environment, keywords)
        self._stepping = Stepping(spec, self.environment, watch=watch)
        self.steps: list[Step] = []

    def __next__(self) -> Step:
        step = next(self._stepping)
        self.steps.append(step)
        return step

    def __enter__(self) -> Stepper:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self.close()

    # Advancing ---------------------------------------------------------------------------

    def until(
        self,
        *,
        time_s: float | None = None,
        robot: int | None = None,
        action: type[Action] | None = None,
        decision: bool | type[Event] = False,
        where: Callable[[Step], bool] | None = None,
    ) -> Iterator[Step]:
        """Iterate over steps up to and including the first one that meets all conditions.

        Parameters
        ----------
        time_s : float, optional
            The step occurs at this time (s) or later.
        robot : int, optional
            The step belongs to this robot.
        action : type, optional
            The action is an instance of this class of `multisrt.robots.explorer`.
        decision : bool or type, optional
            True: the action records a decision. A class of `multisrt.events`: the action records
            such an event.
        where : callable, optional
            Takes the step and returns whether it meets the condition.

        Yields
        ------
        Step

        Raises
        ------
        InvalidInputError
            If there is no such robot, or a condition has the wrong type.

        Examples
        --------
        >>> import multisrt as ms
        >>> stepper = ms.Stepper("apartment", seed=1)
        >>> for step in stepper.until(time_s=5.0):
        ...     assert stepper.time_s == step.time_s
        >>> step.time_s >= 5.0
        True
        """
        if robot is not None:
            self._require(robot)
        for name, value, is_right, what in (
            ("time_s", time_s, isinstance(time_s, float | int), "a number of seconds"),
            ("action", action, action in get_args(Action), "a class of robots.explorer, as Move"),
            ("where", where, callable(where), "a function of a step"),
        ):
            if value is not None and not is_right:
                raise InvalidInputError(f"{name} is {what}, not {value!r}")
        is_event = isinstance(decision, type) and issubclass(decision, Event)
        if not (isinstance(decision, bool) or is_event):
            raise InvalidInputError(
                f"decision is True or a class of multisrt.events, not {decision!r}"
            )
        events: tuple[type, ...] = DECISIONS if decision is True else ()
        if isinstance(decision, type):
            events = (decision,)

        def is_met(step: Step) -> bool:
            noted = step.action.event if isinstance(step.action, Note) else None
            return (
                (time_s is None or step.time_s >= time_s)
                and (robot is None or step.robot == robot)
                and (action is None or isinstance(step.action, action))
                and (not events or isinstance(noted, events))
                and (where is None or where(step))
            )

        return self._until(is_met)

    def _until(self, is_met: Callable[[Step], bool]) -> Iterator[Step]:
        for step in self:
            yield step
            if is_met(step):
                return

    def run_until(self, **conditions: Any) -> Step | None:
        """Advance to the first step that meets all conditions, and return it.

        Parameters
        ----------
        **conditions
            The parameters of `until`. Without conditions, the next step is returned.

        Returns
        -------
        Step or None
            The step; None if the run ends before such a step, or has already ended. `finish` then
            returns the run, and `steps` ends with the last step.

        Raises
        ------
        InvalidInputError
            As for `until`; also if there is no such condition.

        Examples
        --------
        >>> import multisrt as ms
        >>> from multisrt.events import Decision
        >>> stepper = ms.Stepper("open", seed=1)
        >>> stepper.run_until(time_s=20.0, decision=Decision).action.event.choice
        'draw'
        >>> stepper.run_until(time_s=1e6) is None
        True
        """
        refuse_unknown("run_until", conditions.keys() - CONDITIONS, CONDITIONS)
        last = None
        for step in self.until(**conditions):
            last = step
        return None if self.is_over else last

    def finish(self) -> Run:
        """Execute the rest of the run and return the whole run.

        Raises
        ------
        InvalidInputError
            If the stepper was closed before the run had ended.
        """
        for _ in self:
            pass
        if not self.is_over:
            raise InvalidInputError(
                f"the run was given up at {self.time_s:g} s, so it cannot be finished: make a new "
                "Stepper; recording has what had happened"
            )
        return Run(self.recording, self.environment)

    def close(self) -> None:
        """Abandon the run. Its recording so far can still be read."""
        self._stepping.close()

    # Inspecting --------------------------------------------------------------------------

    @property
    def spec(self) -> RunSpec:
        """The spec of the run."""
        return self._stepping.spec

    @property
    def explorers(self) -> tuple[Explorer, ...]:
        """The explorer objects, by robot."""
        return self._stepping.explorers

    @property
    def robots(self) -> tuple[RobotState, ...]:
        """The present true state of each robot."""
        return self._stepping.robots

    @property
    def time_s(self) -> float:
        """The present time, or the end of the run, in seconds."""
        return self._stepping.time_s

    @property
    def messages_in_flight(self) -> int:
        """Number of messages in flight."""
        return self._stepping.messages_in_flight

    @property
    def is_over(self) -> bool:
        """Whether the run has ended."""
        return self._stepping.is_over

    @property
    def recording(self) -> Recording:
        """The recording of the run so far, which can be measured and drawn.

        Until the run has ended, its outcome is `out_of_time`.
        """
        return self._stepping.recording

    def steps_of(self, robot: int) -> list[Step]:
        """Return the steps of a robot so far.

        Examples
        --------
        >>> import multisrt as ms
        >>> stepper = ms.Stepper("apartment", seed=1)
        >>> step = stepper.run_until(time_s=2.0)
        >>> [type(step.action).__name__ for step in stepper.steps_of(0)][:2]
        ['Sense', 'Note']
        """
        self._require(robot)
        return [step for step in self.steps if step.robot == robot]

    def where(self, robot: int) -> str:
        """Return the lines at which the explorer of a robot is paused, for a breakpoint.

        Returns
        -------
        str
            A line ``file:line in function`` for `run` and for each generator to which it
            delegates, the innermost last; empty before the explorer has started and after the run.
            Paths of files in the working directory are relative to it.

        Examples
        --------
        >>> import multisrt as ms
        >>> stepper = ms.Stepper("apartment", seed=1)
        >>> step = next(stepper)
        >>> stepper.where(robot=0).splitlines()[0].rpartition(" ")[2]
        'run'
        """
        self._require(robot)
        return "\n".join(
            f"{_from_here(frame.f_code.co_filename)}:{frame.f_lineno} in {frame.f_code.co_name}"
            for frame in self._stepping.frames(robot)
        )

    def variables(self, robot: int) -> dict[str, Any]:
        """Return the local variables at the line at which the explorer of a robot is paused."""
        self._require(robot)
        frames = self._stepping.frames(robot)
        return dict(frames[-1].f_locals) if frames else {}

    def draw(self) -> str:
        """Return a picture of the present state as SVG.

        Returns
        -------
        str
            The true world, the area seen so far, trees, bodies, current motions and their goals.
        """
        from multisrt.drawing.state_svg import state_svg

        return state_svg(self.recording, self.robots)

    def save_svg(self, path: str | Path) -> None:
        """Write the picture of the present state to a file; written completely or not at all."""
        text = self.draw()
        with atomic_write(Path(path)) as file:
            file.write(text.encode())

    def _repr_svg_(self) -> str:
        return self.draw()

    def __repr__(self) -> str:
        state = "ended" if self.is_over else "at"
        return (
            f"Stepper({self.spec.strategy!r} in {self.environment.name!r}, seed "
            f"{self.spec.seed}: {state} {self.time_s:.2f} s, {len(self.steps)} steps)"
        )

    def _require(self, robot: int) -> None:
        robots = len(self.spec.robots)
        if not isinstance(robot, int) or robot not in range(robots):
            raise InvalidInputError(f"there is no robot {robot}; robots are 0 to {robots - 1}")


def _from_here(file: str) -> str:
    # The path of a file from the working directory, if it is below.
    path, here = Path(file), Path.cwd()
    return str(path.relative_to(here)) if path.is_relative_to(here) else file
