"""A run in steps: it pauses after an explorer has decided, and before that is carried out.

A run that is stepped through is the same run to the byte: a pause is an event of the clock that
comes before all others, so that it changes the order of none.
"""

from __future__ import annotations

from collections.abc import Generator, Iterator
from contextlib import closing
from types import FrameType, TracebackType
from typing import Literal

import msgspec

from multisrt.environments.environment import Environment
from multisrt.geometry.configuration import Configuration
from multisrt.planners.motion.trajectory import Trajectory
from multisrt.recording import Recording
from multisrt.robots.explorer import Explorer
from multisrt.simulation.journal import Watcher
from multisrt.simulation.setting_up import set_up
from multisrt.simulation.simulation import Simulation, Step
from multisrt.spec import RunSpec

__all__ = ["RobotState", "Step", "Stepping"]


class RobotState(msgspec.Struct, frozen=True, kw_only=True):
    """The true state of one robot.

    Attributes
    ----------
    robot : int
        Its number.
    configuration : Configuration
        Where it is.
    state : {"off", "on", "done", "dead"}
        Switched off before a late start, exploring, finished (perhaps on call), or dead.
    motion : Trajectory or None
        The motion that it has begun, from its beginning; None while it stands.
    driven_s : float
        How long it has been on that motion, in seconds.
    mailbox : int
        Number of messages that have arrived and that its explorer has not received.
    hears : bool
        Whether its radio works.
    """

    robot: int
    configuration: Configuration
    state: Literal["off", "on", "done", "dead"]
    motion: Trajectory | None
    driven_s: float
    mailbox: int
    hears: bool

    @property
    def ahead(self) -> Trajectory | None:
        """What is left of its motion; None while it stands."""
        return None if self.motion is None else self.motion.after(self.driven_s)


class Stepping(Iterator[Step]):
    """A run in steps: an iterator over the actions of all robots, each before it is carried out.

    While the run is paused, all that has happened can be read, and what explorers hold may be
    set: an explorer that yields a `Note` and then reads one of its own attributes is handed a
    decision from outside in this way.

    Parameters
    ----------
    spec : RunSpec
        Everything that the run depends on.
    environment : Environment, optional
        The world that `spec.environment` describes, if it has been built already.
    watch : callable, optional
        Called with every event as it is recorded.

    Attributes
    ----------
    spec : RunSpec
        The spec in its canonical form.
    environment : Environment
        The world.
    explorers : tuple of Explorer
        What decides for each robot, by its number.

    Raises
    ------
    InvalidInputError
        If the spec cannot be run.
    ExplorerDefect
        From an iteration: if an explorer yields something that it cannot do.

    Examples
    --------
    >>> from multisrt import CatalogEnvironment, RunSpec, simulate
    >>> from multisrt.robots.explorer import Move
    >>> spec = RunSpec(environment=CatalogEnvironment(name="apartment"), seed=1)
    >>> with Stepping(spec) as run:
    ...     moves = [step for step in run if isinstance(step.action, Move)]
    >>> moves[0].robot, moves[0].time_s
    (0, 0.0)
    >>> run.recording.footer.digest == simulate(spec).footer.digest
    True
    """

    def __init__(
        self,
        spec: RunSpec,
        environment: Environment | None = None,
        *,
        watch: Watcher | None = None,
    ) -> None:
        setup = set_up(spec, environment)
        self.spec = setup.spec
        self.environment = setup.environment
        self.explorers: tuple[Explorer, ...] = setup.explorers
        self._simulation = Simulation(setup, watch=watch, pausing=True)
        self._steps = _steps(self._simulation)
        self._recording: Recording | None = None

    def __next__(self) -> Step:
        try:
            return next(self._steps)
        except StopIteration as end:
            if end.value is not None:
                self._recording = end.value
            raise StopIteration from None

    def __enter__(self) -> Stepping:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self.close()

    def close(self) -> None:
        """End the stepping where it is: no step follows. What has happened can still be read."""
        self._steps.close()
        self._simulation.close()

    @property
    def is_over(self) -> bool:
        """Whether the run has ended; False if the stepping was closed before."""
        return self._recording is not None

    @property
    def time_s(self) -> float:
        """The time in seconds: now, or when the run ended."""
        if self._recording is not None:
            return self._recording.footer.time_s
        return self._simulation.clock.now_s

    @property
    def recording(self) -> Recording:
        """All that has happened: of the whole run, or up to now.

        Before the end of the run it is that of a run which is cut off now, with the motions that
        are under way as far as they have gone; its outcome is `out_of_time`.
        """
        if self._recording is not None:
            return self._recording
        return self._simulation.recording_so_far()

    @property
    def robots(self) -> tuple[RobotState, ...]:
        """The true state of each robot now."""
        simulation, now_s = self._simulation, self._simulation.clock.now_s
        return tuple(
            RobotState(
                robot=robot.number,
                configuration=simulation.motions.where(robot),
                state=robot.state,
                motion=None if robot.motion is None else robot.motion.move.trajectory,
                driven_s=0.0 if robot.motion is None else now_s - robot.motion.set_out_s,
                mailbox=len(robot.mailbox),
                hears=robot.hears,
            )
            for robot in simulation.robots
        )

    @property
    def messages_in_flight(self) -> int:
        """How many messages are on their way."""
        return self._simulation.mail.messages_in_flight

    def frames(self, robot: int) -> tuple[FrameType, ...]:
        """Return where the explorer of a robot stands in its code, for a debugger.

        Parameters
        ----------
        robot : int
            The robot.

        Returns
        -------
        tuple of frame
            The frame of `run`, and those of the generators to which it delegates, the innermost
            last; empty before it has begun and after the run.
        """
        found: list[FrameType] = []
        interpreters = self._simulation.interpreters
        inner: object = interpreters[robot].actions if interpreters else None
        while (frame := getattr(inner, "gi_frame", None)) is not None:
            found.append(frame)
            inner = getattr(inner, "gi_yieldfrom", None)
        return tuple(found)


def _steps(simulation: Simulation) -> Generator[Step, None, Recording]:
    # A function, not a method: an object that is dropped takes its suspended steps along.
    with closing(simulation):
        while simulation.has_events():
            simulation.clock.step()
            while (step := simulation.paused_at) is not None:
                simulation.paused_at = None
                yield step
                simulation.clock.step()
        return simulation.finish()
