"""Robots that are to return their data have returned it when they end."""

from __future__ import annotations

import math
from typing import Final

import shapely

from multisrt.campaign.invariants.completeness import (
    BELIEF_S,
    bodies_around,
    known_at,
    reach_of,
)
from multisrt.campaign.invariants.open_frontier import path_leads, united, without
from multisrt.campaign.judged_run import ROUNDING_M, ROUNDING_S, JudgedRun
from multisrt.campaign.violations import Violation, quoted
from multisrt.events import BaseLearned, Motion, NodeName
from multisrt.planners.home_options import NO_TIME_LEFT
from multisrt.spec import Silence

NAME: Final = "data-is-returned"
IN_TIME: Final = "turns-back-in-time"
AT_HOME: Final = "ends-at-home"

AT_HOME_M: Final = 1e-3
"""Maximum distance from its root at which a single robot ends, in metres."""

UNHEARD: Final = 1e-6
"""Smallest probability with which a robot may be unheard for `home_wait_s`, by losses alone."""

MARGIN_M: Final = 0.05
"""Robots subtract this from the range of the radio, in metres."""

SRT_CELL_M: Final = 0.1
"""Maximum width of the cells in which robots of the SRT family count areas, in metres."""

SURELY_A_CELL: Final = 1.5
"""A disc with a radius of so many cells holds at least one."""

MIN_LACKED_M2: Final = 0.05
"""Smaller areas that the base station lacks are scraps."""


def data_is_returned(run: JudgedRun) -> Violation | None:
    """Check that the base station finally knows what robots know that were to return it.

    With a base station and a `home` other than `never`, each robot that is alive, and whose last
    end says that its map is complete or that no time is left, has delivered all nodes that it knew
    when it ended, but for parts of them of together less than 0.05 m2, and for parts that are too
    narrow to hold a cell of its grid. This holds if it has been where it is certainly heard: at a
    node of its own that is at most the range of the radio less 0.05 m away from the base station
    and, where walls matter, with the base station in its region. There must be a path to there past
    all bodies, with the room that robots keep: cells do not show every narrow place that was
    passed. Only a single robot of the SRT family needs none, as it has its tree.
    Robots may give up if they are not heard for `home_wait_s`. Runs in which radios fail are
    therefore not judged, nor those in which it may well be that all is lost for so long.

    Cost: an overlay for each such robot that has not delivered all nodes.
    """
    if not _is_surely_heard(run):
        return None
    delivered = {
        (robot, serial) for event in run.recording.of(BaseLearned) for robot, serial in event.nodes
    }
    for robot, end in sorted(run.ends.items(), key=lambda item: item[1].time_s):
        if math.isfinite(run.present_s(robot)[1]):
            continue
        if not (end.complete or end.reason.startswith(NO_TIME_LEFT)):
            continue
        known = known_at(run, robot, end)
        lacking = [name for name in known if name not in delivered]
        if not lacking or not _may_be_heard(run, robot, known, end.time_s):
            continue
        here = [name for name in known if name in delivered]
        lacked = without(united(run, known), united(run, here))
        # Robots count areas in cells: only such whole ones are sure to be noticed.
        wide_m = SURELY_A_CELL * run.options.get("cell_m", SRT_CELL_M)
        area_m2 = lacked.buffer(-wide_m).buffer(wide_m).area
        if area_m2 > MIN_LACKED_M2:
            return Violation(
                invariant=NAME,
                says=f"robot {robot} ended at {end.time_s:.2f} s ({quoted(end.reason)}), but the "
                f"base station lacks {area_m2:.2f} m2 of what it knew",
                robot=robot,
                time_s=end.time_s,
            )
    return None


def turns_back_in_time(run: JudgedRun) -> Violation | None:
    """Check that a robot sets out to explore only while there is time to come home.

    With ``home="in-time"`` or ``"worth"``. When a motion to explore begins, while the base station
    lacks a node of the robot, the time left is at least that of the straight way to where the base
    station may hear it, with the share `home_margin`, and `home_reserve_s`. This holds once it has
    been where it is certainly heard and can drive there; see `data_is_returned`, also for the runs
    that are not judged.

    Cost: negligible.
    """
    spec, options = run.recording.spec, run.options
    if not _is_surely_heard(run) or options["home"] not in ("in-time", "worth"):
        return None
    assert spec.base is not None
    learned_s = {
        (robot, serial): event.time_s
        for event in run.recording.of(BaseLearned)
        for robot, serial in event.nodes
    }
    heard_m = spec.radio.reach_m + 2.0 * options.get("cell_m", 0.0)
    for motion in sorted(run.recording.of(Motion), key=lambda motion: motion.time_s):
        robot, now_s = motion.robot, motion.waypoints[0][0]
        speed_m_s = spec.robots[robot].drive.speed_m_s
        away_m = max(0.0, math.dist(motion.waypoints[0][1:3], spec.base.place) - heard_m)
        home_s = away_m * (1.0 + options["home_margin"]) / speed_m_s + options["home_reserve_s"]
        left_s = spec.stop.max_time_s - now_s
        if motion.purpose != "explore" or away_m == 0.0 or left_s >= home_s - ROUNDING_S:
            continue
        known = [name for name, time_s in run.known[robot].items() if time_s <= now_s]
        carries = any(learned_s.get(name, math.inf) > now_s for name in known)
        if carries and _may_be_heard(run, robot, known, now_s):
            return Violation(
                invariant=IN_TIME,
                says=f"robot {robot} sets out to explore at {now_s:.2f} s, {away_m:.2f} m from "
                f"where it may be heard, with {left_s:.2f} s left, and needs {home_s:.2f} s",
                robot=robot,
                time_s=now_s,
            )
    return None


def ends_at_home(run: JudgedRun) -> Violation | None:
    """Check that a single robot of the SRT family whose map is complete ends at its root.

    It ends there to 1e-3 m. Not judged are cars, robots that return data, which may end where they
    deliver it, and teams, in which others may be in the way.

    Cost: negligible.
    """
    end = run.ends.get(0)
    if run.family != "srt" or len(run.robots) > 1 or run.returns_data:
        return None
    if end is None or not end.complete or run.recording.spec.robots[0].drive.is_car:
        return None
    x, y, _ = run.tracks[0].pose(end.time_s)
    away_m = math.dist((x, y), run.recording.header.starts[0][:2])
    if away_m <= AT_HOME_M:
        return None
    return Violation(
        invariant=AT_HOME,
        says=f"robot 0 ended at {end.time_s:.2f} s ({quoted(end.reason)}), {away_m:.3f} m from its "
        "root",
        robot=0,
        time_s=end.time_s,
    )


def _is_surely_heard(run: JudgedRun) -> bool:
    # Whether data is to be returned, and the base station certain to hear a robot in reach.
    spec = run.recording.spec
    if not run.returns_data:
        return False
    return not any(isinstance(fault, Silence) for fault in spec.faults) and not _may_be_unheard(run)


def _may_be_unheard(run: JudgedRun) -> bool:
    radio, options = run.recording.spec.radio, run.options
    period_s = options["ask_period_s"] + 2.0 * (radio.latency_s + radio.jitter_s)
    is_answered = (1.0 - radio.loss) ** 2
    is_unheard: float = (1.0 - is_answered) ** (options["home_wait_s"] / period_s)
    return is_unheard > UNHEARD


def _may_be_heard(run: JudgedRun, robot: int, known: list[NodeName], at_s: float) -> bool:
    # To where only others have been it may know no way.
    heard = [name for name in known if name[0] == robot and _is_heard_at(run, name)]
    if not heard or (run.family == "srt" and len(run.robots) == 1):
        return bool(heard)
    places = [run.nodes[name].configuration for name in heard]
    belief_s = BELIEF_S if run.family == "srt" else 1.5 * run.options["body_stays_s"]
    bodies = bodies_around(run, robot, [at_s], belief_s)
    at = run.tracks[robot].pose(at_s)
    return path_leads(run, robot, known, reach_of(run, robot), at, places, bodies)


def _is_heard_at(run: JudgedRun, name: NodeName) -> bool:
    spec = run.recording.spec
    assert spec.base is not None
    place = run.nodes[name].configuration[:2]
    if math.dist(place, spec.base.place) > spec.radio.reach_m - MARGIN_M - ROUNDING_M:
        return False
    if spec.radio.walls == "pass":
        return True
    return bool(shapely.contains_xy(run.regions[name], *spec.base.place))
