"""Where bodies were at any time of a run, how far they drove, and how near they came."""

from __future__ import annotations

import itertools
import math
from collections import defaultdict
from collections.abc import Callable
from typing import Final

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely.geometry.base import BaseGeometry

from benchmarks.judge.bodies import Body, bodies_of, placed
from benchmarks.judge.views import FloatArray
from multisrt.events import Motion
from multisrt.recording import Recording

IntArray = NDArray[np.int64]

STEP_RAD: Final = 1e-3
"""Maximum turn between two of the points by which an arc is measured."""

FOUND_M: Final = 2e-5
"""Minimum distances are found to within this, in metres."""

MIN_TURN_RAD: Final = 1e-12
"""Legs that turn less are straight."""


class Track:
    """The motion of a robot, from 0 to the end of a run.

    Between two waypoints of a motion the body turns about a fixed centre, or moves straight.

    Parameters
    ----------
    start : (x, y, heading)
        Where it starts.
    motions : list of Motion
        Its motions.
    end_s : float
        The end of the run.
    """

    def __init__(
        self, start: tuple[float, float, float], motions: list[Motion], end_s: float
    ) -> None:
        legs: list[tuple[float, ...]] = []
        time_s, pose = 0.0, start
        for motion in sorted(motions, key=lambda motion: motion.time_s):
            for at_s, *place in motion.waypoints[:1]:
                legs.append((time_s, *pose, at_s, *pose))
                self._require_same(pose, place)
            for a, b in itertools.pairwise(motion.waypoints):
                legs.append((*a, *b))
            time_s, *place = motion.waypoints[-1]
            pose = (place[0], place[1], place[2])
        legs.append((time_s, *pose, max(end_s, time_s), *pose))
        self.legs: FloatArray = np.array(legs)
        chord = self.legs[:, 5:7] - self.legs[:, 1:3]
        self.turns: FloatArray = self.legs[:, 7] - self.legs[:, 3]
        self._curved = np.abs(self.turns) > MIN_TURN_RAD
        half = np.where(self._curved, self.turns, math.pi) / 2.0
        to_left = np.column_stack([-chord[:, 1], chord[:, 0]])
        middle = (self.legs[:, 1:3] + self.legs[:, 5:7]) / 2.0
        self._centres = middle + to_left / (2.0 * np.tan(half))[:, None]
        still = (chord == 0.0).all(axis=1)
        self._centres[still] = self.legs[still, 1:3]
        self.lengths: FloatArray = np.array([self._length(k) for k in range(len(self.legs))])

    @staticmethod
    def _require_same(pose: tuple[float, float, float], place: list[float]) -> None:
        if math.dist(pose[:2], place[:2]) > 1e-6:
            raise ValueError(f"a motion begins at {place}, but the robot was at {pose}")

    def on(self, which: IntArray, shares: FloatArray) -> FloatArray:
        """Return the poses ``(n, 3)`` at shares, from 0 to 1, of some legs."""
        legs, turn = self.legs[which], self.turns[which]
        poses = legs[:, 1:4] + shares[:, None] * (legs[:, 5:8] - legs[:, 1:4])
        arm = legs[:, 1:3] - self._centres[which]
        cos, sin = np.cos(shares * turn), np.sin(shares * turn)
        turned = self._centres[which] + np.column_stack(
            [cos * arm[:, 0] - sin * arm[:, 1], sin * arm[:, 0] + cos * arm[:, 1]]
        )
        poses[:, :2] = np.where(self._curved[which][:, None], turned, poses[:, :2])
        return poses

    def at(self, times: FloatArray) -> FloatArray:
        """Return the poses ``(n, 3)`` at some times."""
        which = self.leg_at(times)
        begin, end = self.legs[which, 0], self.legs[which, 4]
        lasting = np.where(end > begin, end - begin, 1.0)
        return self.on(which, np.clip((times - begin) / lasting, 0.0, 1.0))

    def leg_at(self, times: FloatArray) -> IntArray:
        """Return the last legs that have begun by some times."""
        which = np.searchsorted(self.legs[:, 0], times, side="right") - 1
        legs: IntArray = np.maximum(which, 0)
        return legs

    def rates(self, times: FloatArray, radius_m: float) -> FloatArray:
        """Return how fast the points within a radius move at some times at most (m/s)."""
        which = self.leg_at(times)
        lasting = self.legs[which, 4] - self.legs[which, 0]
        reach = self.lengths[which] + np.abs(self.turns[which]) * radius_m
        rates: FloatArray = np.zeros_like(reach)
        rates[lasting > 0.0] = reach[lasting > 0.0] / lasting[lasting > 0.0]
        return rates

    def along(self, leg: int, step_rad: float = STEP_RAD) -> FloatArray:
        """Return poses ``(n, 3)`` along a leg; a step turns by at most an angle."""
        steps = max(1, math.ceil(abs(self.turns[leg]) / step_rad))
        return self.on(np.full(steps + 1, leg), np.linspace(0.0, 1.0, steps + 1))

    def _length(self, leg: int) -> float:
        steps = np.diff(self.along(leg)[:, :2], axis=0)
        return float(np.hypot(*steps.T).sum())


def tracks(recording: Recording) -> list[Track]:
    """Return the track of each robot."""
    motions: dict[int, list[Motion]] = defaultdict(list)
    for motion in recording.of(Motion):
        motions[motion.robot].append(motion)
    return [
        Track(start, motions[robot], recording.footer.time_s)
        for robot, start in enumerate(recording.header.starts)
    ]


def clearance_m(recording: Recording, tracks: list[Track], free: BaseGeometry) -> float:
    """Return the smallest distance between a body and an obstacle during a run.

    The path of a disc's centre, and what a polygon sweeps on a straight line, are shapes whose
    distance is exact; where a polygon turns, it is found to within `FOUND_M`.
    """
    walls = free.boundary
    shapely.prepare(walls)
    best = math.inf
    for body, track in zip(bodies_of(recording.spec), tracks, strict=True):
        shapes = body.at(track.legs[:1, 1:4])
        curved = []
        for leg in range(len(track.legs)):
            if body.outline is None:
                if track.lengths[leg] > 0.0:
                    shapes.append(shapely.LineString(track.along(leg)[:, :2]))
            elif abs(track.turns[leg]) > MIN_TURN_RAD:
                curved.append(leg)
            elif track.lengths[leg] > 0.0:
                shapes += _swept(body, track.along(leg))
        best = min(best, float(shapely.distance(walls, shapes).min()) - body.radius_m)
        if curved:
            best = _smallest_turning(body, track, np.array(curved), walls, best)
    return best


def _swept(body: Body, ends: FloatArray) -> list[BaseGeometry]:
    corners = (placed(piece, ends).reshape(-1, 2) for piece in body.pieces())
    return [shapely.MultiPoint(c).convex_hull for c in corners]


def _smallest_turning(
    body: Body, track: Track, legs: IntArray, walls: BaseGeometry, best: float
) -> float:
    reach = track.lengths[legs] + np.abs(track.turns[legs]) * body.circumscribed_m

    def distance(which: IntArray, shares: FloatArray) -> FloatArray:
        return np.asarray(shapely.distance(walls, body.at(track.on(legs[which], shares))))

    return smallest(distance, np.zeros(len(legs)), np.ones(len(legs)), reach, best)


def smallest(
    distance: Callable[[IntArray, FloatArray], FloatArray],
    begin: FloatArray,
    end: FloatArray,
    rates: FloatArray,
    best: float,
) -> float:
    """Return the smallest value of functions, to within `FOUND_M`.

    Parameters
    ----------
    distance : callable
        Returns the values of functions with some numbers at some places.
    begin, end : (n,) array
        From where to where each function is searched.
    rates : (n,) array
        How fast each changes at most.
    best : float
        A value that is known already.
    """
    which = np.arange(len(begin))
    while len(which):
        middle, half = (begin + end) / 2.0, (end - begin) / 2.0
        values = distance(which, middle)
        best = min(best, float(values.min()))
        slack = rates[which] * half
        kept = (values - slack < best - FOUND_M) & (slack > 0.0)
        which, begin, middle, end = which[kept], begin[kept], middle[kept], end[kept]
        which = np.concatenate([which, which])
        begin, end = np.concatenate([begin, middle]), np.concatenate([middle, end])
    return best


def between_robots_m(recording: Recording, tracks: list[Track]) -> float | None:
    """Return the smallest distance between two bodies at one moment; None for a single robot."""
    best = math.inf
    bodies = bodies_of(recording.spec)
    for (one, track), (two, other) in itertools.combinations(zip(bodies, tracks, strict=True), 2):
        joints = np.unique(np.concatenate([track.legs[:, 0], other.legs[:, 0], track.legs[-1:, 4]]))
        middles = (joints[:-1] + joints[1:]) / 2.0
        rates = track.rates(middles, one.circumscribed_m if one.outline else 0.0)
        rates += other.rates(middles, two.circumscribed_m if two.outline else 0.0)
        best = smallest(_Gap(one, track, two, other), joints[:-1], joints[1:], rates, best)
    return max(0.0, best) if math.isfinite(best) else None


class _Gap:
    """The distance of two bodies at some times."""

    def __init__(self, one: Body, track: Track, two: Body, other: Track) -> None:
        self._one, self._track, self._two, self._other = one, track, two, other

    def __call__(self, _: IntArray, times: FloatArray) -> FloatArray:
        gaps = shapely.distance(
            np.array(self._one.at(self._track.at(times))),
            np.array(self._two.at(self._other.at(times))),
        )
        return np.asarray(gaps) - self._one.radius_m - self._two.radius_m
