"""The simulation: an interpreter of explorers' actions over a discrete-event clock.

It holds the true state. It moves bodies along their trajectories, takes their scans, delivers
their messages, injects the faults of the spec, and checks every motion against the world and all
other bodies. It advances from event to event: the cost of a run depends on the number of events,
not on the simulated time.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import closing, nullcontext
from pathlib import Path

from multisrt.environments.environment import Environment
from multisrt.recording import Recording, atomic_write
from multisrt.simulation.journal import Watcher
from multisrt.simulation.setting_up import set_up
from multisrt.simulation.simulation import Simulation
from multisrt.spec import RunSpec


def simulate(
    spec: RunSpec,
    environment: Environment | None = None,
    *,
    path: str | Path | None = None,
    watch: Watcher | None = None,
    planning: Callable[[float], None] | None = None,
    look: Callable[[Callable[[], Recording]], None] | None = None,
) -> Recording:
    """Simulate an exploration.

    Parameters
    ----------
    spec : RunSpec
        Everything that the run depends on.
    environment : Environment, optional
        The world described by `spec.environment`, if it has been built already.
    path : path, optional
        File to which the recording is written during the run.
    watch : callable, optional
        Called with every event as it is recorded.
    planning : callable, optional
        Called with the completed share while a strategy that knows the true map plans the run.
    look : callable, optional
        Called before the first event and after every event of the clock, between decisions, with a
        function that returns the recording of the run up to the present time.

    Returns
    -------
    Recording
        The recording. An exploration that stalls or runs out of time is a result, not an error.

    Raises
    ------
    InvalidInputError
        If the spec cannot be run (the world, a start, the strategy or its options), or if `path`
        cannot be written.
    ExplorerDefect
        If an explorer yields an impossible action; a subclass of `InvalidInputError`.

    Examples
    --------
    >>> from multisrt import CatalogEnvironment, RunSpec, simulate
    >>> spec = RunSpec(environment=CatalogEnvironment(name="apartment"), seed=1)
    >>> recording = simulate(spec)
    >>> recording.footer.outcome
    'complete'
    >>> simulate(spec).footer.digest == recording.footer.digest
    True
    """
    setup = set_up(spec, environment, planning=planning)
    opened = nullcontext() if path is None else atomic_write(Path(path))
    with opened as file, closing(Simulation(setup, watch=watch, file=file)) as simulation:
        if look is not None:
            look(simulation.recording_so_far)
        while simulation.has_events():
            simulation.clock.step()
            if look is not None:
                look(simulation.recording_so_far)
        return simulation.finish()
