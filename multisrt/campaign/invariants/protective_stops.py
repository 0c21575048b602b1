"""Protective stops end motions before bodies that are near and in sight, and only then."""

from __future__ import annotations

import math
from typing import Final

import numpy as np
import shapely
from numpy.typing import NDArray

from multisrt.campaign.bodies import FloatArray
from multisrt.campaign.judged_run import JudgedRun
from multisrt.campaign.violations import Violation
from multisrt.events import Blocked, Motion

NAME: Final = "stops-before-bodies"

GUARD_M: Final = 1e-4
"""Maximum distance beyond that of the protective stop at which it ends a motion, in metres."""

MISSED: Final = 0.5
"""Share of the distance of the protective stop below which no motion goes on: bodies that come no
nearer than 0.6 of it may pass each other between two steps."""

SAMPLES: Final = 16
STEP_S: Final = 0.1
"""Least number of times at which a motion is examined, and greatest time between two of them."""


def stops_before_bodies(run: JudgedRun) -> Violation | None:
    """Check that protective stops end motions before bodies near and in sight, and only then.

    The body before which a motion is stopped is no farther away than `guard_m`, to 1e-4 m, and no
    wall crosses the line between the reference points of the two, or that between their nearest
    points. No motion goes on while a body is nearer than half of `guard_m`, with no wall between
    the reference points, at two times in a row that are 0.1 s apart or less; unless that body was
    nearer than `guard_m` when the motion began.

    Cost: negligible, and two bodies for each time at which they are near.
    """
    if run.family == "other":
        return None
    found = [violation for violation in (_early(run), _late(run)) if violation is not None]
    return min(found, key=lambda violation: violation.time_s or 0.0, default=None)


def _early(run: JudgedRun) -> Violation | None:
    guard_m = run.options["guard_m"]
    for stop in run.recording.of(Blocked):
        at = np.array([stop.time_s])
        pair = stop.robot, stop.by
        places = run.tracks[stop.robot].at(at), run.tracks[stop.by].at(at)
        apart_m = _apart_m(run, pair, places)[0]
        one, other = (run.bodies[n].at(place)[0] for n, place in zip(pair, places, strict=True))
        lines = (
            shapely.LineString([places[0][0, :2], places[1][0, :2]]),
            shapely.shortest_line(one, other),
        )
        if apart_m > guard_m + GUARD_M:
            what = f"{apart_m:.4f} m before robot {stop.by}, guarding {guard_m:g} m"
        elif not any(shapely.covers(run.walls.grown, line) for line in lines):
            what = f"before robot {stop.by}, which is hidden by walls"
        else:
            continue
        return _violation(stop.robot, stop.time_s, f"is stopped {what}")
    return None


def _late(run: JudgedRun) -> Violation | None:
    guard_m = run.options["guard_m"]
    motions = sorted(run.recording.of(Motion), key=lambda motion: motion.time_s)
    for motion in motions if len(run.robots) > 1 else ():
        # Without the last moment, at which it may have been stopped.
        begin_s, end_s = motion.waypoints[0][0], motion.waypoints[-1][0]
        samples = max(SAMPLES, math.ceil((end_s - begin_s) / STEP_S))
        times_s = np.linspace(begin_s, end_s, samples, endpoint=False)
        own = run.tracks[motion.robot].at(times_s)
        for other in run.robots:
            if other == motion.robot:
                continue
            places = own, run.tracks[other].at(times_s)
            pair = motion.robot, other
            reach_m = sum(run.bodies[n].circumscribed_m for n in pair) + MISSED * guard_m
            between_m = np.hypot(*(places[0] - places[1])[:, :2].T)
            if between_m.min() > reach_m:
                continue
            apart_m = _apart_m(run, pair, places)
            near = (apart_m < MISSED * guard_m) & _in_sight(run, places)
            twice = np.flatnonzero(near[:-1] & near[1:])
            if len(twice) and apart_m[0] > guard_m + GUARD_M:
                k = int(twice[0])
                return _violation(
                    motion.robot,
                    float(times_s[k]),
                    f"drives on {apart_m[k]:.4f} m from robot {other}, guarding {guard_m:g} m",
                )
    return None


def _apart_m(
    run: JudgedRun, pair: tuple[int, int], places: tuple[FloatArray, FloatArray]
) -> FloatArray:
    """Return the distances between two bodies at pairs of poses."""
    bodies = [run.bodies[robot] for robot in pair]
    ones, others = (np.array(body.at(at)) for body, at in zip(bodies, places, strict=True))
    apart_m: FloatArray = shapely.distance(ones, others)
    return apart_m - bodies[0].radius_m - bodies[1].radius_m


def _in_sight(run: JudgedRun, places: tuple[FloatArray, FloatArray]) -> NDArray[np.bool_]:
    lines = shapely.linestrings(np.stack([place[:, :2] for place in places], axis=1))
    return np.asarray(shapely.covers(run.once("shrunk", run.walls.shrunk), lines), np.bool_)


def _violation(robot: int, time_s: float, what: str) -> Violation:
    says = f"robot {robot} {what}, at {time_s:.2f} s"
    return Violation(invariant=NAME, says=says, robot=robot, time_s=time_s)
