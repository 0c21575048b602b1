"""Recordings that were changed, or written by hand, for invariants to find."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from typing import Any

import msgspec
import shapely

from multisrt.campaign.judged_run import JudgedRun
from multisrt.environments.environment import Environment
from multisrt.events import AnyEvent, Motion
from multisrt.geometry.configuration import Configuration
from multisrt.recording import Recording
from multisrt.recording.lines import Footer, digest_of, header_of
from multisrt.spec import CatalogEnvironment, RobotSpec, RunSpec

ROOM = Environment("room", shapely.box(0.0, 0.0, 4.0, 3.0))
"""A room of 4 m by 3 m."""


def written(
    events: Iterable[AnyEvent] = (),
    *,
    starts: Sequence[tuple[float, float, float]] = ((2.0, 1.5, 0.0),),
    environment: Environment = ROOM,
    end_s: float = 20.0,
    outcome: Any = "stalled",
    **spec: Any,
) -> JudgedRun:
    """Return a run written by hand; by default of discs of 0.25 m in a room."""
    spec.setdefault("robots", (RobotSpec(),) * len(starts))
    run = RunSpec(environment=CatalogEnvironment(name="open"), **spec)
    header = header_of(run, environment, tuple(Configuration(*start) for start in starts))
    footer = Footer(
        time_s=end_s,
        outcome=outcome,
        reason="it was written so",
        digest=digest_of(header, tuple(events)),
    )
    recording = Recording(header=header, events=tuple(events), footer=footer)
    return JudgedRun(recording=recording, environment=environment)


def changed(
    run: JudgedRun,
    change: Callable[[AnyEvent], AnyEvent | None] = lambda event: event,
    *,
    extra: Iterable[AnyEvent] = (),
    until_s: float = math.inf,
    **footer: Any,
) -> JudgedRun:
    """Return a run whose events are changed, left out, cut off at a time, or followed by others.

    Parameters
    ----------
    run : JudgedRun
        The run.
    change : callable
        Returns an event in place of another one; None leaves it out.
    extra : iterable of Event
        What comes at the end.
    until_s : float
        Later events are left out, and motions that end later.
    **footer
        Fields of the last line.
    """
    events: list[AnyEvent] = []
    for event in run.recording.events:
        last_s = event.waypoints[-1][0] if isinstance(event, Motion) else event.time_s
        found = change(event) if last_s <= until_s else None
        if found is not None:
            events.append(found)
    events += extra
    last = msgspec.structs.replace(run.recording.footer, **footer)
    recording = Recording(header=run.recording.header, events=tuple(events), footer=last)
    return JudgedRun(recording=recording, environment=run.environment)


def once(
    kind: type, change: Callable[[Any], AnyEvent | None], which: int = 0
) -> Callable[[AnyEvent], AnyEvent | None]:
    """Return a change of one event of a kind: the first, or the one with a number."""
    count = -1

    def of(event: AnyEvent) -> AnyEvent | None:
        nonlocal count
        if not isinstance(event, kind):
            return event
        count += 1
        return change(event) if count == which else event

    return of


def drive(robot: int, *waypoints: tuple[float, float, float, float]) -> Motion:
    """Return a motion along waypoints (time, x, y, heading)."""
    return Motion(time_s=waypoints[0][0], robot=robot, waypoints=waypoints)
