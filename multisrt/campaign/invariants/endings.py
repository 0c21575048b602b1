"""Every run ends, with an outcome and a reason that agree with those of its robots."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from multisrt.campaign.invariants.waiting import leads_on, limit
from multisrt.campaign.judged_run import ROUNDING_S, JudgedRun
from multisrt.campaign.violations import MAX_LENGTH, Violation, quoted
from multisrt.events import AnyEvent, BaseLearned, Collision, Died, Ended, Motion, NodeAdded, Sent
from multisrt.simulation.standstill import NOTHING_NEW, WAITS_FOR_EVER

NAME: Final = "ends"

EVENTS_PER_ROBOT: Final = 2_000
"""Number of events of a robot that a run may have, whatever its duration."""

EVENTS_PER_ROBOT_S: Final = 100.0
"""Maximum mean rate of events per robot, in events per second."""


def ends(run: JudgedRun) -> Violation | None:
    """Check that a run ends within a bounded number of events, with a consistent outcome.

    It has at most 2,000 events per robot, plus 100 per second and robot. The outcome is `complete`
    only if all robots that are alive ended as complete, and `out_of_time` only at the time limit.
    It is not `stalled` because of robots that wait for a message that never comes, since no robot
    may do that. Reasons are not empty, nothing happens after the end. A run that no limit ended
    ends at its last event, at the arrival of a message, or at the end of a wait after it. A run
    that its stop rule ended because nothing new came lasts as long as that rule allows after the
    last motion that led on, and the last node that a robot added or the base station learned.

    Cost: negligible.
    """
    return next((Violation(invariant=NAME, says=what) for what in _wrong(run)), None)


def _wrong(run: JudgedRun) -> Iterator[str]:
    recording, footer = run.recording, run.recording.footer
    team, stop = len(run.robots), recording.spec.stop
    most = team * (EVENTS_PER_ROBOT + EVENTS_PER_ROBOT_S * footer.time_s)
    if len(recording.events) > most:
        yield f"{len(recording.events)} events in {footer.time_s:.1f} s, more than {most:.0f}"
    if footer.outcome not in ("complete", "stalled", "out_of_time"):
        yield f"the outcome is {footer.outcome!r}"
    if not footer.reason.strip():
        yield f"the outcome is {footer.outcome}, without a reason"
    if footer.time_s > stop.max_time_s + ROUNDING_S:
        yield f"it ends at {footer.time_s:.2f} s, beyond its limit of {stop.max_time_s:g} s"
    for end in recording.of(Ended):
        if not end.reason.strip():
            yield f"robot {end.robot} ends at {end.time_s:.2f} s without a reason"
    last_s = max((event.time_s for event in recording.events), default=0.0)
    if last_s > footer.time_s + ROUNDING_S:
        yield f"something happens at {last_s:.2f} s, after the end at {footer.time_s:.2f} s"
    is_cut_off = footer.outcome == "out_of_time" or NOTHING_NEW in footer.reason
    if not is_cut_off and last_s + _longest_s(run) < footer.time_s - ROUNDING_S:
        yield f"it ends at {footer.time_s:.2f} s, but the last event is at {last_s:.2f} s"
    news_s = max((_news_s(event) for event in recording.events), default=0.0)
    if NOTHING_NEW in footer.reason and footer.time_s < news_s + stop.max_idle_s - ROUNDING_S:
        yield (
            f"it ends at {footer.time_s:.2f} s as nothing new came for {stop.max_idle_s:g} s, but "
            f"something did at {news_s:.2f} s"
        )
    yield from _misnamed(run)


def _news_s(event: AnyEvent) -> float:
    if isinstance(event, Motion):
        return event.waypoints[-1][0] if leads_on(event) else 0.0
    return event.time_s if isinstance(event, NodeAdded | BaseLearned) else 0.0


def _longest_s(run: JudgedRun) -> float:
    # How long a message may be on its way, or a robot wait that has ended again then: neither is
    # an event.
    radio = run.recording.spec.radio
    travel_s = (len(run.robots) + 1) * (radio.latency_s + radio.jitter_s)
    return travel_s if run.family == "other" else travel_s + limit(run)


def _misnamed(run: JudgedRun) -> Iterator[str]:
    recording, footer = run.recording, run.recording.footer
    dead = {event.robot for event in recording.of(Died)}
    living = [robot for robot in run.robots if robot not in dead]
    is_at_limit = footer.time_s >= recording.spec.stop.max_time_s - ROUNDING_S
    match footer.outcome:
        case "complete":
            if recording.of(Collision):
                yield "the outcome is complete, with a collision"
            for robot in living:
                end = run.ends.get(robot)
                if end is None or not end.complete:
                    why = None if end is None else quoted(end.reason)
                    what = "has not ended" if why is None else f"ended incomplete ({why})"
                    yield f"the outcome is complete, but robot {robot} {what}"
            if not living:
                yield "the outcome is complete, but no robot lives"
        case "out_of_time":
            if not is_at_limit:
                yield (
                    f"the outcome is out_of_time at {footer.time_s:.2f} s, before the limit of "
                    f"{recording.spec.stop.max_time_s:g} s"
                )
        case "stalled":
            ended = [run.ends.get(robot) for robot in living]
            is_complete = bool(living) and all(end is not None and end.complete for end in ended)
            if is_complete and not recording.of(Collision) and not _waits_again(run):
                yield "the outcome is stalled, but all robots that live ended completely"
            if WAITS_FOR_EVER in footer.reason:
                yield quoted(f"the outcome is stalled: {footer.reason}", MAX_LENGTH)


def _waits_again(run: JudgedRun) -> bool:
    # Whether something was on its way still: a robot that was called on, and did not end.
    last_end_s = max(end.time_s for end in run.ends.values())
    return any(event.time_s > last_end_s for event in run.recording.of(Sent))
