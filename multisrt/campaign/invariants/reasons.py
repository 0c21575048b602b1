"""A robot that ends incomplete says why, and a robot that has run out of time had none left."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Final

import shapely

from multisrt.campaign.invariants.completeness import IN_THE_WAY
from multisrt.campaign.judged_run import JudgedRun
from multisrt.campaign.violations import Violation, quoted
from multisrt.events import Blocked, Coordinated, Decision, Ended
from multisrt.planners.home_options import NO_TIME_LEFT
from multisrt.robots.naming import BOXED_IN, NO_CHAIN, WALLED_IN

NAME: Final = "incomplete-for-a-reason"
ATTEMPTS: Final = "boxed-in-after-attempts"

NO_TARGET: Final = "the planner has no target"
"""How that of a robot of the SRT family begins that leaves frontier, with `complete=false`."""

SLACK: Final = 2.0
"""Factor on the time that a robot may take at most to any place and home."""

SLACK_S: Final = 30.0
"""Time besides, for messages and pauses, in seconds."""


def incomplete_for_a_reason(run: JudgedRun) -> Violation | None:
    """Check that robots end incomplete only for known reasons, and out of time only with none left.

    The reasons are that it is boxed in, that bodies stand in the way, that no time is left for
    another target and the way home, that no goal is left from which a chain of relays reaches the
    base station, and, with `complete=false` alone, that the planner has no target. A robot that has
    no time left ends at most so long before the time limit as it may need from any place to any
    other and home: twice the time for driving twice the length of all walls of the world, turning
    by half a turn at every corner, and `home_margin` and `home_reserve_s`; plus 30 s. That is not
    checked for cars, nor for relays and chains, which may have agreed to meet before.

    Cost: negligible.
    """
    if run.family == "other":
        return None
    for end in sorted(run.ends.values(), key=lambda end: end.time_s):
        wrong = None if end.complete else _wrong(run, end)
        if wrong is not None:
            says = f"robot {end.robot} ended at {end.time_s:.2f} s ({quoted(end.reason)}), {wrong}"
            return Violation(invariant=NAME, says=says, robot=end.robot, time_s=end.time_s)
    return None


def boxed_in_after_attempts(run: JudgedRun) -> Violation | None:
    """Check that a robot of the SRT family is boxed in only after the attempts that it is to make.

    By then at least `gives_up_after` of its motions were stopped, or ordered otherwise by a master;
    or it stayed where it was, or was stopped, at least `boxed_in_after` times, as there was no
    path. Not judged are robots that find no motion from their start.

    Cost: negligible.
    """
    if run.family != "srt":
        return None
    for robot, end in sorted(run.ends.items(), key=lambda item: item[1].time_s):
        if not end.reason.startswith(BOXED_IN) or end.reason.startswith(WALLED_IN):
            continue
        stops = _count(run.recording.of(Blocked), end)
        orders = _count((o for o in run.recording.of(Coordinated) if o.order != "keep"), end)
        stays = _count((d for d in run.recording.of(Decision) if d.choice == "stay"), end)
        if stops + orders >= run.options["gives_up_after"]:
            continue
        if stays + stops >= run.options["boxed_in_after"]:
            continue
        return Violation(
            invariant=ATTEMPTS,
            says=f"robot {robot} ended at {end.time_s:.2f} s ({quoted(end.reason)}), after {stops} "
            f"stops, {orders} orders and {stays} choices to stay",
            robot=robot,
            time_s=end.time_s,
        )
    return None


def _count(events: Iterable[Blocked | Coordinated | Decision], end: Ended) -> int:
    return sum(event.robot == end.robot and event.time_s <= end.time_s for event in events)


def _wrong(run: JudgedRun, end: Ended) -> str | None:
    if end.reason.startswith(NO_TIME_LEFT):
        left_s = run.recording.spec.stop.max_time_s - end.time_s
        trip_s = _max_trip_s(run, end.robot)
        if left_s > trip_s:
            return f"{left_s:.0f} s before the limit; {trip_s:.0f} s are enough for any place"
        return None
    if end.reason.startswith(NO_TARGET):
        return "which must not happen with complete=true" if run.options["complete"] else None
    is_known = end.reason.startswith((BOXED_IN, NO_CHAIN)) or IN_THE_WAY in end.reason
    return None if is_known else "which is no reason to end incomplete"


def _max_trip_s(run: JudgedRun, robot: int) -> float:
    """Return how long a robot may need at most to any place and home, in seconds."""
    drive, options = run.recording.spec.robots[robot].drive, run.options
    if drive.is_car or options["home"] in ("relays", "chain"):
        return math.inf
    free = run.environment.free
    corners = shapely.get_num_coordinates(free)
    way_s = 2.0 * float(shapely.length(free)) / drive.speed_m_s
    turns_s = 2.0 * corners * math.pi / drive.turn_rate_rad_s
    once_s = (1.0 + options["home_margin"]) * (way_s + turns_s) + options["home_reserve_s"]
    return SLACK * float(once_s) + SLACK_S
