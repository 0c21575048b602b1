"""A schedule of robots along their routes, in which no two come close to one another.

Robots are timed one after another. Each keeps off those before it by waiting on its route, or by
backing on it; one that is done may go back along its route to make room. Its motion is a shortest
path in the plane of time and progress (Kant and Zucker, 1986: path-velocity decomposition), found
by A*.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from multisrt.geometry.numerics.kernel import FloatArray, IntArray, kernel
from multisrt.planners.motion.trajectory import Trajectory

STEP_S, MAX_STEPS = 0.05, 3_000
"""Minimum step of time in seconds, and maximum number of steps of the longest route."""

GAP_M = 0.06
"""Minimum distance between bodies that are timed, in metres."""

SLACK_STEPS: Final = 2_000
"""Steps that robots may take longer than the longest routes one after another, at most."""

BACK: Final = -1


@dataclass(frozen=True, slots=True, kw_only=True)
class Course:
    """The motion of a robot along its route, in its own time.

    Attributes
    ----------
    motion : Trajectory
        The motion without any wait.
    radius_m : float
        Radius of the disc that holds the body, in metres.
    speed_m_s : float
        Its largest speed.
    """

    motion: Trajectory
    radius_m: float
    speed_m_s: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Timing:
    """How far a robot is at each step of time.

    Attributes
    ----------
    step_s : float
        The step, in seconds.
    progress : (k,) array of int
        At each step of time, the steps of progress on the route and back: beyond the end of the
        route, the robot is on its way back. After the last step it stands.
    """

    step_s: float
    progress: IntArray


STANDS: Final = Timing(step_s=STEP_S, progress=np.zeros(1, np.int64))
"""The timing of a robot that never moves."""


class NoTiming(Exception):
    """No timetable was found for a robot.

    Attributes
    ----------
    robot : int
        The robot.
    """

    def __init__(self, robot: int) -> None:
        super().__init__(robot)
        self.robot = robot


def timed(courses: Sequence[Course]) -> list[Timing]:
    """Return when each robot drives so that bodies keep `GAP_M` from one another.

    Robots whose routes take longer come first. One that finds no timetable is put before all
    others, and all are timed again.

    Raises
    ------
    NoTiming
        If there is no such timing; it names the robot that cannot move.
    """
    longest_s = max((course.motion.duration_s for course in courses), default=0.0)
    step_s = max(STEP_S, longest_s / MAX_STEPS)
    places = [_places(course.motion, step_s) for course in courses]
    order = sorted(range(len(courses)), key=lambda r: (-len(places[r]), r))
    tried: set[int] = set()
    while True:
        try:
            found = _in_order(order, courses, places, step_s)
        except NoTiming as failed:
            if failed.robot in tried or len(places[failed.robot]) == 1:
                raise
            tried.add(failed.robot)
            order.remove(failed.robot)
            order.insert(0, failed.robot)
            continue
        return [found[robot] for robot in range(len(courses))]


def _in_order(
    order: Sequence[int], courses: Sequence[Course], places: list[FloatArray], step_s: float
) -> dict[int, Timing]:
    found: dict[int, Timing] = {}
    tracks: list[FloatArray] = []
    for robot in order:
        course, own = courses[robot], places[robot]
        apart = np.empty(len(tracks))
        for k, other in enumerate(order[: len(tracks)]):
            them = courses[other]
            slack = 0.5 * step_s * (course.speed_m_s + them.speed_m_s)
            wanted = course.radius_m + them.radius_m + GAP_M + slack
            # Those that start nearer to one another may stay that near.
            first = float(np.hypot(*(own[0] - places[other][0])))
            apart[k] = min(wanted, first - 1e-9)
        horizon = max((len(track) for track in tracks), default=1)
        others = np.stack([_padded(track, horizon) for track in tracks]) if tracks else _NOBODY
        there = np.vstack((own, own[-2::-1]))
        steps = horizon + 2 * len(own) + SLACK_STEPS if tracks else len(own)
        progress = (
            _progress(there, len(own) - 1, others, apart, steps)
            if tracks
            else np.arange(len(own), dtype=np.int64)
        )
        if len(progress) == 0:
            raise NoTiming(robot)
        found[robot] = Timing(step_s=step_s, progress=progress)
        tracks.append(there[progress])
    return found


_NOBODY = np.empty((0, 1, 2))


def _places(motion: Trajectory, step_s: float) -> FloatArray:
    # Where the reference point is at each step of a motion, its end included.
    steps = math.ceil(motion.duration_s / step_s - 1e-9)
    times = np.array([w.time_s for w in motion.waypoints])
    at = np.minimum(np.arange(steps + 1) * step_s, motion.duration_s)
    x = np.interp(at, times, [w.x for w in motion.waypoints])
    y = np.interp(at, times, [w.y for w in motion.waypoints])
    return np.column_stack((x, y))


def _padded(track: FloatArray, size: int) -> FloatArray:
    return np.vstack((track, np.repeat(track[-1:], size - len(track), axis=0)))


@kernel
def _near(places: FloatArray, k: int, others: FloatArray, apart: FloatArray, step: int) -> bool:
    when = min(step, others.shape[1] - 1)
    x, y = places[k]
    for j in range(len(others)):
        dx, dy = others[j, when, 0] - x, others[j, when, 1] - y
        if dx * dx + dy * dy < apart[j] * apart[j]:
            return True
    return False


@kernel
def _progress(
    places: FloatArray, end: int, others: FloatArray, apart: FloatArray, steps: int
) -> IntArray:
    # A* over (time, progress): a step ahead costs nothing beyond what must be, a wait one step, a
    # step back two. Done: at the end of the route or on the way back from it, where no robot comes
    # any more. An empty array: there is none.
    size = len(places)
    horizon = others.shape[1]
    free_since = np.full(size, -1, np.int64)
    came = np.zeros((steps + 1, size), np.int8)  # 0 not reached, 1 from behind, 2 waited, 3 back
    waves = [[(0, 0)]]
    came[0, 0] = 2
    level = 0
    while level < len(waves):
        wave = waves[level]
        while len(wave) > 0:
            time, k = wave.pop()
            if k >= end:
                if free_since[k] < 0:
                    last = horizon
                    while last > 0 and not _near(places, k, others, apart, last - 1):
                        last -= 1
                    free_since[k] = last
                if time >= free_since[k]:
                    return _traced(came, time, k)
            if time == steps:
                continue
            for move in range(1, 4):
                to = k + (1 if move == 1 else 0 if move == 2 else -1)
                if to < 0 or to >= size or came[time + 1, to] != 0:
                    continue
                if _near(places, to, others, apart, time + 1):
                    continue
                came[time + 1, to] = move
                more = 0 if move == 1 and k < end else 1 if move != 3 else 2
                while len(waves) <= level + more:
                    waves.append([(0, 0)][:0])
                waves[level + more].append((time + 1, to))
        level += 1
    return np.empty(0, np.int64)


@kernel
def _traced(came: np.ndarray, time: int, k: int) -> IntArray:
    found = np.empty(time + 1, np.int64)
    while time > 0:
        found[time] = k
        move = came[time, k]
        k -= 1 if move == 1 else 0 if move == 2 else -1
        time -= 1
    found[0] = k
    return found
