"""Nobody waits for longer than its limits say."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Final

from multisrt.campaign.judged_run import JudgedRun
from multisrt.campaign.violations import Violation
from multisrt.events import (
    CameBack,
    Died,
    Ended,
    FellSilent,
    Joined,
    Learned,
    Motion,
    NodeAdded,
    Organized,
    PresumedLost,
)
from multisrt.simulation.standstill import NOTHING_NEW
from multisrt.spec import Silence

NAME: Final = "waits-within-limits"

SLACK: Final = 1.5
"""Factor on the sum of all limits: they are counted in rounds, and a round may be longer."""

SLACK_S: Final = 30.0
"""Time besides, for the messages and short pauses between waits, in seconds."""

MOVED_M: Final = 1e-3
"""A motion that leads no farther is none, in metres and in radians."""


def waits_within_limits(run: JudgedRun) -> Violation | None:
    """Check that no team stands for longer than the limits of its waits together, or for ever.

    A spell is a time in which, of all robots that take part and have not ended, none moves by more
    than 1e-3 m or rad, notes or learns a node or ends, and no fault strikes, although at least one
    of them has neither ended nor died. It may be as long as all waits that the strategy's options
    allow one after the other, half as long again, and 30 s more. This holds for robots that wait
    for a dead one, as these wait for nothing else. Waits of one robot while others go on are not
    bounded: robots of the SRT family wait for the others' end, and relays for their front. A run
    that its stop rule ended as nothing new came is a violation if the limits are shorter than it.

    Cost: negligible.
    """
    limit_s = limit(run)
    for begin_s, end_s in _spells(run):
        if end_s - begin_s > limit_s:
            waiting = _not_ended(run, begin_s)
            named = ", ".join(map(str, waiting))
            return Violation(
                invariant=NAME,
                says=f"nobody does anything from {begin_s:.2f} s to {end_s:.2f} s, and robot"
                f"{'s' * (len(waiting) > 1)} {named} {'have' if len(waiting) > 1 else 'has'} not "
                f"ended; the limits allow {limit_s:.0f} s",
                robot=waiting[0],
                time_s=begin_s,
            )
    reason = run.recording.footer.reason
    if NOTHING_NEW in reason and run.recording.spec.stop.max_idle_s >= limit_s:
        return Violation(invariant=NAME, says=reason)
    return None


def limit(run: JudgedRun) -> float:
    """Return for how long a team may stand, in seconds."""
    options, radio = run.options, run.recording.spec.radio
    round_s = 2.0 * (radio.latency_s + radio.jitter_s)
    waits_s = 0.0
    if run.family == "srt":
        period_s = options["ask_period_s"] + round_s
        unheard = 1.0 - (1.0 - radio.loss) ** 2
        patience = 1.0 if unheard == 0.0 else math.ceil(math.log(1e-6) / math.log(unheard))
        silence_s = options["silence_timeout_s"] or patience * period_s
        waits_s = (
            options["max_rounds"] * period_s
            + (len(run.robots) * (silence_s + period_s))
            + options["left_out_s"]
            + options["check_period_s"]
            + options["take_over_after_s"]
            + options["home_after_s"]
            + options["settle_s"]
            # Pauses without a path, and those of a robot that stands aside.
            + options["boxed_in_after"] * options["pause_s"]
            + (1 + options["jammed_after"]) * 1.5 * options["pause_s"]
            + options["home_wait_s"]
        )
    elif run.family == "frontier":
        waits_s = (
            (options["max_waits"] + options["max_jams"]) * 1.5 * options["pause_s"]
            + options["max_jams"] * options["patience"] * (options["ask_period_s"] + round_s)
            + options["body_stays_s"] * 1.5
            + options["pursue_wait_s"]
        )
        if run.recording.spec.base is not None:
            # Home with news; pairs: at the place, the backup, and for the time agreed on; chains:
            # for a front that is not heard.
            homes = {"never": 0.0, "relays": 6.0, "chain": 12.0}
            waits_s += homes.get(options["home"], 2.0) * options["home_wait_s"]
            waits_s += options["home_period_s"] if options["home"] == "relays" else 0.0
        elif options["pursue"]:
            waits_s += options["pursue_steps"] * options["pursue_step_s"]
    else:
        return math.inf
    return SLACK * waits_s + SLACK_S


def _spells(run: JudgedRun) -> Iterator[tuple[float, float]]:
    """Yield the times from one thing that happens to the next, in which a robot waits."""
    steps = sorted({0.0, *_happenings(run)})
    last_s = steps[0]
    for time_s in (*steps[1:], run.end_s):
        if time_s > last_s and _not_ended(run, last_s):
            yield last_s, time_s
        last_s = max(last_s, time_s)


def _happenings(run: JudgedRun) -> Iterator[float]:
    moving: list[tuple[float, float]] = []
    for event in run.recording.events:
        match event:
            case Motion():
                if _leads_on(event):
                    moving.append((event.waypoints[0][0], event.waypoints[-1][0]))
            case NodeAdded() | Learned() | Ended() | Died() | Joined() | FellSilent() | CameBack():
                yield event.time_s
            case PresumedLost() | Organized():
                yield event.time_s
    for fault in run.recording.spec.faults:
        yield min(fault.time_s, run.end_s)
        if isinstance(fault, Silence):
            yield min(fault.time_s + fault.duration_s, run.end_s)
    for begin_s, end_s in moving:
        # While a robot moves, nobody waits in vain.
        steps = max(1, math.ceil((end_s - begin_s) / 10.0))
        yield from (begin_s + k / steps * (end_s - begin_s) for k in range(steps + 1))


def _leads_on(motion: Motion) -> bool:
    _, *first = motion.waypoints[0]
    return any(
        math.dist(first[:2], (x, y)) > MOVED_M or abs(heading - first[2]) > MOVED_M
        for _, x, y, heading in motion.waypoints[1:]
    )


def _not_ended(run: JudgedRun, time_s: float) -> list[int]:
    """Return the robots that take part after a time, and have not ended by then."""
    ended = {end.robot for end in run.recording.of(Ended) if end.time_s <= time_s}
    found = []
    for robot in run.robots:
        on_s, dead_s = run.present_s(robot)
        if on_s <= time_s < dead_s and robot not in ended:
            found.append(robot)
    return found
