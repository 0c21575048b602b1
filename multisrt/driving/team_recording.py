"""A recording of a team outside the simulation."""

from __future__ import annotations

from collections.abc import Sequence

from multisrt.driving.driver import Driver
from multisrt.environments.environment import Environment
from multisrt.events import AnyEvent, Motion, NodeAdded
from multisrt.geometry.errors import InvalidInputError
from multisrt.recording import Recorder, Recording, RunOutcome, header_of
from multisrt.recording.flaws import flaw_of
from multisrt.simulation.worlds import inline
from multisrt.spec import RangeFinderSpec, RobotSpec, RunSpec


def recording_of(
    drivers: Sequence[Driver],
    environment: Environment,
    *,
    robots: Sequence[RobotSpec] | None = None,
) -> Recording:
    """Return what a team did as a recording, which can be measured and drawn.

    Paths are those that were commanded, from where each motion began to where it ended. Which
    robots a message has reached is not known.

    Parameters
    ----------
    drivers : sequence of Driver
        The drivers of the robots 0, 1, ...
    environment : Environment
        The world in which they were, as far as it is known.
    robots : sequence of RobotSpec, optional
        What the robots are; by default as their `RobotSelf` says.

    Returns
    -------
    Recording
        The recording; its spec describes the run, which cannot be repeated from it.

    Raises
    ------
    InvalidInputError
        If the drivers are not those of a whole team, or an event cannot be recorded.
    """
    numbers = [driver.me.robot for driver in drivers]
    if numbers != list(range(len(numbers))) or not numbers:
        raise InvalidInputError(f"drivers of the robots {numbers}: give those of 0, 1, ... in turn")
    if robots is None:
        robots = [
            RobotSpec(
                start=(*driver.me.start,),
                footprint=str(driver.me.footprint),
                range_finder=RangeFinderSpec(range_m=driver.me.range_m),
            )
            for driver in drivers
        ]
    spec = RunSpec(
        environment=inline(environment),
        strategy=drivers[0].name,
        options=drivers[0].options,
        robots=tuple(robots),
    )
    starts = tuple(driver.me.start for driver in drivers)
    recorder = Recorder(header_of(spec, environment, starts))
    events = sorted(
        (event for driver in drivers for event in driver.events),
        key=_recorded_s,
    )
    nodes = {(event.robot, event.serial) for event in events if isinstance(event, NodeAdded)}
    for event in events:
        if flaw := flaw_of(event, spec, nodes):
            raise InvalidInputError(f"a {type(event).__name__} at {event.time_s:g} s: {flaw}")
        recorder.record(event)
    ends = [driver.end for driver in drivers]
    outcome: RunOutcome = "out_of_time" if None in ends else "stalled"
    if all(end is not None and end.complete for end in ends):
        outcome = "complete"
    reason = "; ".join(
        f"robot {number}: {'explores' if end is None else end.reason}"
        for number, end in enumerate(ends)
    )
    return recorder.finish(max(driver.time_s for driver in drivers), outcome, reason)


def _recorded_s(event: AnyEvent) -> float:
    # A motion is recorded when it has ended.
    return event.waypoints[-1][0] if isinstance(event, Motion) else event.time_s
