"""No robot waits longer than its limits allow."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Iterator
from typing import Final

from multisrt.campaign.judged_run import JudgedRun
from multisrt.campaign.violations import MAX_LENGTH, Violation, quoted
from multisrt.events import (
    CameBack,
    Died,
    Ended,
    FellSilent,
    GoalChosen,
    Joined,
    Learned,
    Motion,
    NodeAdded,
    Organized,
    PresumedLost,
    Sensed,
    Sent,
)
from multisrt.robots.frontier.progress import Event
from multisrt.simulation.standstill import NOTHING_NEW
from multisrt.spec import Silence

NAME: Final = "waits-within-limits"
OFTEN: Final = "waits-as-often-as-allowed"

SLACK: Final = 1.5
"""Factor on the sum of all limits: they are counted in rounds, and a round may be longer."""

SLACK_S: Final = 30.0
"""Time besides, for the messages and short pauses between waits, in seconds."""

STUCK_S: Final = 5.0
"""Time without progress by the nearness diagram after which a robot follows its path (s)."""

MOVED_M: Final = 1e-3
"""Motions shorter than this count as standing still, in metres and in radians."""


def waits_within_limits(run: JudgedRun) -> Violation | None:
    """Check that no team stands still for longer than all its waiting times added up.

    An idle period is a time in which at least one robot has neither ended nor died, and no active
    robot moves by more than 1e-3 m or rad, adds or learns a node, or ends, and no fault occurs. It
    may be 1.5 times as long as all waiting times of the strategy's options added up, plus 30 s,
    plus a pause and a query for each request to give way in it, and for each goal that is chosen in
    it a pause and the time after which a robot that makes no progress by the nearness diagram
    follows its path. This also holds for robots that wait for a dead one. For robots that go to
    frontiers, and do not form pairs or chains and do not pursue each other, it holds for each robot
    separately, whatever the others do; robots of the SRT family may wait for the end of others. A
    run that its stop rule ended because nothing new came is a violation if the allowed time is
    shorter than the time of the stop rule.

    Cost: negligible.
    """
    if run.family == "other":
        return None
    teams = [list(run.robots)]
    if run.family == "frontier" and _is_for_itself(run):
        teams = [[robot] for robot in run.robots]
    limit_s = limit(run)
    for team in teams:
        for begin_s, end_s in _spells(run, team):
            allowed_s = limit_s + _tried(run, team, begin_s, end_s)
            if end_s - begin_s > allowed_s:
                return _violation(run, team, begin_s, end_s, allowed_s)
    reason, idle_s = run.recording.footer.reason, run.recording.spec.stop.max_idle_s
    if NOTHING_NEW in reason:
        tried_s = _tried(run, list(run.robots), run.end_s - idle_s, run.end_s)
        if idle_s >= limit_s + tried_s:
            return Violation(invariant=NAME, says=quoted(reason, MAX_LENGTH))
    return None


def _is_for_itself(run: JudgedRun) -> bool:
    # Whether robots wait for one another only as their ways cross.
    goes_alone = run.recording.spec.base is None or run.options["home"] not in ("relays", "chain")
    return goes_alone and not run.options["pursue"]


def _violation(
    run: JudgedRun, team: list[int], begin_s: float, end_s: float, allowed_s: float
) -> Violation:
    waiting = _not_ended(run, team, begin_s)
    many = len(waiting) > 1
    named = f"robot{'s' * many} {', '.join(map(str, waiting))} {'have' if many else 'has'}"
    who = "nobody does" if len(team) > 1 else f"robot {team[0]} does not do"
    return Violation(
        invariant=NAME,
        says=f"{who} anything from {begin_s:.2f} s to {end_s:.2f} s ({allowed_s:.0f} s are "
        f"allowed), and {named} not ended",
        robot=waiting[0],
        time_s=begin_s,
    )


def limit(run: JudgedRun) -> float:
    """Return how long a team may stand still without requests to give way, in seconds."""
    options, radio = run.options, run.recording.spec.radio
    period_s = options["ask_period_s"] + _round_s(run)
    if run.family == "srt":
        unheard = 1.0 - (1.0 - radio.loss) ** 2
        patience = 1.0 if unheard == 0.0 else math.ceil(math.log(1e-6) / math.log(unheard))
        silence_s = options["silence_timeout_s"] or patience * period_s
        waits_s = (
            options["max_rounds"] * period_s
            + len(run.robots) * (silence_s + period_s)
            + options["left_out_s"]
            + options["check_period_s"]
            + options["home_after_s"]
            + options["settle_s"]
            # Pauses without a path, and those of a robot that stands aside.
            + options["boxed_in_after"] * options["pause_s"]
            + (1 + options["jammed_after"]) * 1.5 * options["pause_s"]
        )
        if not radio.reaches_everywhere:
            waits_s += options["take_over_after_s"]
    else:
        waits_s = options["max_waits"] * 1.5 * options["pause_s"] + options["body_stays_s"] * 1.5
        if options["pursue"]:
            waits_s += options["pursue_wait_s"] + options["pursue_steps"] * options["pursue_step_s"]
    if run.recording.spec.base is not None:
        # Home with data; pairs: at the place, at its backup, and for the time agreed on; chains:
        # for a front that is not heard.
        homes = {"never": 0.0, "relays": 6.0, "chain": 12.0}
        waits_s += homes.get(options["home"], 3.0) * options["home_wait_s"]
        waits_s += options["home_period_s"] if options["home"] == "relays" else 0.0
    return SLACK * float(waits_s) + SLACK_S


def _round_s(run: JudgedRun) -> float:
    radio = run.recording.spec.radio
    return 2.0 * (radio.latency_s + radio.jitter_s)


def _tried(run: JudgedRun, team: list[int], begin_s: float, end_s: float) -> float:
    """Return the additional time that a team may stand still because of its attempts."""
    if run.family == "srt":
        return 0.0
    options = run.options
    requests = sum(
        begin_s <= sent.time_s <= end_s
        for sent in run.recording.of(Sent)
        if sent.kind == "give way"
    )
    each_s = 1.5 * options["pause_s"] + options["ask_period_s"] + _round_s(run)
    # A robot pauses between goals to which it finds no way, each of which it gives up.
    goals = {
        chosen.goal
        for chosen in run.recording.of(GoalChosen)
        if chosen.robot in team and begin_s <= chosen.time_s <= end_s
    }
    each_goal_s = 1.5 * options["pause_s"]
    if options.get("drive") == "nearness-diagram":
        each_goal_s += STUCK_S
    return SLACK * float(requests * each_s + len(goals) * each_goal_s)


def _spells(run: JudgedRun, team: list[int]) -> Iterator[tuple[float, float]]:
    """Yield the intervals between events in which a robot waits."""
    steps = sorted({0.0, *_happenings(run, team), *_ends(run, team)})
    last_s = steps[0]
    for time_s in (*steps[1:], run.end_s):
        if time_s > last_s and _not_ended(run, team, last_s):
            yield last_s, time_s
        last_s = max(last_s, time_s)


def _happenings(run: JudgedRun, team: list[int]) -> Iterator[float]:
    for event in run.recording.events:
        match event:
            case Died() | Joined() | FellSilent() | CameBack():
                yield event.time_s
            case Motion() if event.robot in team and leads_on(event):
                # While a robot moves, nobody waits in vain.
                begin_s, end_s = event.waypoints[0][0], event.waypoints[-1][0]
                steps = max(1, math.ceil((end_s - begin_s) / 10.0))
                yield from (begin_s + k / steps * (end_s - begin_s) for k in range(steps + 1))
            case NodeAdded() | Learned() | PresumedLost() | Organized():
                if event.robot in team:
                    yield event.time_s
    for fault in run.recording.spec.faults:
        yield min(fault.time_s, run.end_s)
        if isinstance(fault, Silence):
            yield min(fault.time_s + fault.duration_s, run.end_s)


def leads_on(motion: Motion) -> bool:
    """Return whether a motion leads anywhere: by more than `MOVED_M`."""
    _, *first = motion.waypoints[0]
    return any(
        math.dist(first[:2], (x, y)) > MOVED_M or abs(heading - first[2]) > MOVED_M
        for _, x, y, heading in motion.waypoints[1:]
    )


def waits_as_often_as_allowed(run: JudgedRun) -> Violation | None:
    """Check that a robot that bids waits for others to leave at most `max_waits` times in a row.

    Each wait is between two choices that find no goal, the second one because the robot was blocked
    and perhaps the first, too. In a row the robot neither moves, nor scans, nor learns anything.

    Cost: negligible.
    """
    if run.family != "frontier":
        return None
    most: int = run.options["max_waits"]
    kinds = (GoalChosen, Motion, Sensed, NodeAdded, Learned)
    for robot, events in sorted(run.by_robot(*kinds).items()):
        choices = 0
        for event in sorted(events, key=lambda event: event.time_s):
            is_vain = isinstance(event, GoalChosen) and event.goal is None
            choices = choices + 1 if is_vain and event.because == "blocked" else 0
            if choices > most + 1:
                return Violation(
                    invariant=OFTEN,
                    says=f"robot {robot} waits for others to leave {choices - 1} times in a row, "
                    f"until {event.time_s:.2f} s; {most} are allowed",
                    robot=robot,
                    time_s=event.time_s,
                )
    return None


def _not_ended(run: JudgedRun, team: list[int], time_s: float) -> list[int]:
    """Return the robots that are active after a time and have not ended by then."""
    changes = _changes(run)
    found = []
    for robot in team:
        on_s, dead_s = run.present_s(robot)
        times_s, have_ended = changes[robot]
        last = bisect_right(times_s, time_s) - 1
        if on_s <= time_s < dead_s and not (last >= 0 and have_ended[last]):
            found.append(robot)
    return found


def _ends(run: JudgedRun, team: list[int]) -> Iterator[float]:
    """Yield when robots ended, for the first time or again."""
    changes = _changes(run)
    for robot in team:
        yield from (time_s for time_s, has_ended in zip(*changes[robot], strict=True) if has_ended)


def _changes(run: JudgedRun) -> list[tuple[list[float], list[bool]]]:
    """Return for each robot when it ended or began to move, and whether it ended then.

    A robot that moves after it ended was called on, unless it only gave way. If it ends as before,
    that is not recorded again, but that it chooses nothing is. One that is called on without that
    was boxed in before it could choose; it is taken to have ended after its last motion.
    """
    return run.once("ends and motions", lambda: [_changes_of(run, robot) for robot in run.robots])


def _changes_of(run: JudgedRun, robot: int) -> tuple[list[float], list[bool]]:
    told = sorted(
        (
            event
            for event in run.recording.events  # motions are recorded when they are over
            if isinstance(event, Ended | Motion | GoalChosen) and event.robot == robot
        ),
        key=lambda event: event.time_s,
    )
    times_s: list[float] = []
    have_ended: list[bool] = []
    last_s = 0.0
    for event in told:
        if isinstance(event, Motion) and event.purpose == "give way" and True in have_ended[-1:]:
            continue
        if isinstance(event, GoalChosen):
            if event.because == Event.CALLED_ON and have_ended and not have_ended[-1]:
                times_s.append(last_s)
                have_ended.append(True)
            ends_again = event.goal is None and True in have_ended and not have_ended[-1]
            if not ends_again:
                continue
        last_s = event.waypoints[-1][0] if isinstance(event, Motion) else event.time_s
        times_s.append(event.time_s)
        have_ended.append(not isinstance(event, Motion))
    return times_s, have_ended
