"""Robots make progress: none drives in circles."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Final

import numpy as np
import shapely

from multisrt.campaign.bodies import FloatArray
from multisrt.campaign.judged_run import ROUNDING_S, JudgedRun
from multisrt.campaign.violations import Violation
from multisrt.events import (
    ArcClosed,
    CameBack,
    Died,
    Ended,
    FellSilent,
    GoalChosen,
    Joined,
    Learned,
    Motion,
    NodeAdded,
)

NAME: Final = "drives-get-somewhere"

POINTS: Final = 4000
"""Number of points, about, that stand for the free space."""

GOAL_M: Final = 0.5
"""Side of the squares within which goals, or nodes, count as one, in metres."""


MOTION_M: Final = 0.1
"""Distance that a motion counts in addition to its length, in metres."""


def drives_get_somewhere(run: JudgedRun) -> Violation | None:
    """Check that no robot drives farther than the length of all walls without making progress.

    Between two events of progress, a robot drives at most the total length of all walls of the
    world; any place is reached, and left again, on a shorter path. A motion counts 0.1 m more than
    its length, so that tiny ones add up, too, but not if it is a part of the one before: it begins
    when that one ends, and turns the same way. In the SRT family robots return along their trees,
    which may be longer: there the limit is at least the distance that all robots together have
    driven by then. Progress of all robots is a region that shows a place not seen by any of them
    (of about 4000 in the free space), the closing of an arc, the end of a robot, and the beginning
    or end of a fault. Progress of one robot is learning of a node of another robot, and choosing a
    goal, in the SRT family adding a node, in a square of 0.5 m in which it has had none. There are
    finitely many such events, so a robot that drives to and fro for ever is found if its run is
    long enough.

    Cost: each region tests the points that no earlier one has shown.
    """
    if run.family == "other":
        return None
    limit_m = float(shapely.length(run.environment.free))
    shared = _shared_steps(run)
    for robot in run.robots:
        steps = np.unique([0.0, *shared, *_own_steps(run, robot), run.end_s])
        driven_m = np.diff(_driven_m(run, robot, steps))
        limits_m = np.full(len(driven_m), limit_m)
        if run.family == "srt":
            trees_m = sum(_driven_m(run, other, steps[:-1]) for other in run.robots)
            limits_m = np.maximum(limits_m, trees_m)
        beyond_m = driven_m - limits_m
        if not (beyond_m > 0.0).any():
            continue
        longest = int(beyond_m.argmax())
        return Violation(
            invariant=NAME,
            says=f"robot {robot} drives {driven_m[longest]:.1f} m from {steps[longest]:.2f} s "
            f"to {steps[longest + 1]:.2f} s, without progress ({MOTION_M:g} m are added for each "
            f"motion); the limit is {limits_m[longest]:.1f} m",
            robot=robot,
            time_s=float(steps[longest]),
        )
    return None


def _shared_steps(run: JudgedRun) -> list[float]:
    """Return the times of progress that counts for all robots."""
    unseen = _points_in(run.environment.free)
    times = []
    for event in run.recording.events:
        match event:
            case NodeAdded():
                region = run.regions[event.robot, event.serial]
                shown = shapely.contains_xy(region, unseen[:, 0], unseen[:, 1])
                unseen = unseen[~shown]
                if shown.any():
                    times.append(event.time_s)
            case ArcClosed() | Ended() | Died() | Joined() | FellSilent() | CameBack():
                times.append(event.time_s)
    return times


def _own_steps(run: JudgedRun, robot: int) -> Iterator[float]:
    """Yield the times of progress of one robot."""
    squares = set()
    for learned in run.recording.of(Learned):
        if learned.robot == robot:
            yield learned.time_s
    for event in run.recording.events:
        match event:
            case GoalChosen(goal=place) if event.robot == robot and place is not None:
                x, y = place
            case NodeAdded() if event.robot == robot and run.family == "srt":
                x, y, _ = event.configuration
            case _:
                continue
        square = (int(x // GOAL_M), int(y // GOAL_M))
        if square not in squares:
            squares.add(square)
            yield event.time_s


def _points_in(free: shapely.geometry.base.BaseGeometry) -> FloatArray:
    x0, y0, x1, y1 = free.bounds
    step_m = float(np.sqrt(free.area / POINTS))
    xs, ys = np.meshgrid(
        np.arange(x0 + step_m / 2.0, x1, step_m), np.arange(y0 + step_m / 2.0, y1, step_m)
    )
    is_free = shapely.contains_xy(free, xs, ys)
    points: FloatArray = np.column_stack([xs[is_free], ys[is_free]])
    return points


def _driven_m(run: JudgedRun, robot: int, times: FloatArray) -> FloatArray:
    """Return the distance that a robot has driven by each time, with what its motions count."""
    track = run.tracks[robot]
    motions = np.searchsorted(_begins_s(run, robot), times)
    begin_m = np.concatenate([[0.0], np.cumsum(track.lengths)])
    begin_s = np.append(track.legs[:, 0], track.legs[-1, 4])
    driven: FloatArray = np.interp(times, begin_s, begin_m) + MOTION_M * motions
    return driven


def _begins_s(run: JudgedRun, robot: int) -> list[float]:
    """Return when the motions of a robot began, without those that go on with the one before."""
    motions = [e.waypoints for e in run.recording.of(Motion) if e.robot == robot]
    begins_s: list[float] = []
    end_s, turn = -math.inf, 0.0
    for waypoints in sorted(motions):
        (begin_s, *_, before), (over_s, *_, after) = waypoints[0], waypoints[-1]
        way = float(np.sign(after - before))
        if begin_s > end_s + ROUNDING_S or way != turn:
            begins_s.append(begin_s)
        end_s, turn = over_s, way
    return begins_s
