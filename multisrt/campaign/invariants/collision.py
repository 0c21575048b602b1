"""Bodies never touch walls or each other."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator
from typing import Final

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import Polygon
from shapely.geometry.base import BaseGeometry

from multisrt.campaign.bodies import Body, FloatArray, placed
from multisrt.campaign.judged_run import JudgedRun, Walls
from multisrt.campaign.tracks import MIN_TURN_RAD, IntArray, Track
from multisrt.campaign.violations import Violation
from multisrt.events import Collision

NAME: Final = "no-collision"

TOUCH_M: Final = 1e-6
"""Bodies that overlap an obstacle, or each other, by no more are beside it, but for rounding."""

FOUND_M: Final = 2e-5
"""Where a body that is no disc turns, overlaps are found that are deeper than this, in metres."""

BESIDE_M: Final = 0.1
"""Maximum distance from a body's path to an obstacle that it touches, in metres."""

LEG_M: Final = 2.0
"""How far from where it sets out a body touches an obstacle by which a run ended, in metres."""

COARSE_M: Final = 1e-3
"""Arcs are first taken as chords that lie at most this far from them, in metres."""

BoolArray = NDArray[np.bool_]


def no_collision(run: JudgedRun) -> Violation | None:
    """Check that no body touches an obstacle or another body, at any time of the run.

    No event reports a collision, no leg of a motion crosses a wall, and no two bodies overlap at
    the same time. The bodies of dead robots, and of robots that have not started, stay where they
    are. Paths of discs and areas swept by polygons on straight legs are exact to `TOUCH_M` (1e-6
    m). For turns of polygons and for pairs of bodies, time intervals are halved until the bodies
    cannot meet between two samples, given the speeds of their motions, or until they are within
    `FOUND_M` (2e-5 m). Robots plan with a margin more than ten times as large.

    Robots cannot know of walls that the beams of a laser missed. In worlds with obstacles thinner
    than the distance between beams, or with sharp corners, contact with an obstacle is not a
    violation if a region on the robot's map contains a part of that obstacle next to it.
    `known-free-is-free` limits what beams may miss.

    Cost: a few milliseconds for each robot and each pair.
    """
    for event in run.recording.of(Collision):
        here = shapely.Point(event.configuration[:2])
        if _is_unseen(run, event.robot, here.buffer(LEG_M)):
            continue
        return Violation(
            invariant=NAME,
            says=f"robot {event.robot} {event.account} at {event.time_s:.2f} s",
            robot=event.robot,
            time_s=event.time_s,
        )
    found = [*_with_walls(run), *_with_each_other(run)]
    return min(found, key=lambda violation: violation.time_s or 0.0, default=None)


# Walls ---------------------------------------------------------------------------------------


def _with_walls(run: JudgedRun) -> Iterator[Violation]:
    for robot, (body, track) in enumerate(zip(run.bodies, run.tracks, strict=True)):
        for leg in _touching_legs(body, track, run.walls).tolist():
            begin, end = track.legs[leg, [0, 4]].tolist()
            x, y = track.legs[leg, 1:3].tolist()
            path = _line(_chords(track, leg, COARSE_M))
            if _is_unseen(run, robot, path.buffer(body.circumscribed_m + BESIDE_M)):
                continue
            yield Violation(
                invariant=NAME,
                says=f"robot {robot} touches an obstacle between {begin:.2f} s and {end:.2f} s, "
                f"from ({x:.3f}, {y:.3f}) on",
                robot=robot,
                time_s=begin,
            )
            break


def _is_unseen(run: JudgedRun, robot: int, beside: BaseGeometry) -> bool:
    """Whether a robot's map contains obstacles in an area, which its beams missed."""
    if run.beams_find_all:
        return False
    obstacles = beside.difference(run.walls.grown)
    return any(
        run.regions[name].intersection(obstacles).area > TOUCH_M for name in run.known[robot]
    )


def _touching_legs(body: Body, track: Track, walls: Walls) -> IntArray:
    """Return the legs on which a body touches a wall, ascending."""
    begins = track.legs[:, 1:3]
    touches: BoolArray = ~shapely.contains_xy(walls.grown, begins[:, 0], begins[:, 1])
    coarse = np.array([_line(_chords(track, k, COARSE_M)) for k in range(len(track.legs))])
    near = walls.tree.query(coarse, "dwithin", distance=body.circumscribed_m + COARSE_M)
    for leg in np.unique(near[0]).tolist():
        if not touches[leg]:
            touches[leg] = _touches(body, track, leg, walls)
    return np.flatnonzero(touches)


def _line(points: FloatArray) -> BaseGeometry:
    # GEOS measures no distance from a line without a length.
    if (points == points[0]).all():
        return shapely.Point(points[0])
    return shapely.LineString(points)


def _chords(track: Track, leg: int, sagitta_m: float) -> FloatArray:
    """Return the path of a leg as points whose chords lie within a distance of it."""
    turn = abs(float(track.turns[leg]))
    radius_m = float(track.lengths[leg]) / turn if turn > MIN_TURN_RAD else 0.0
    if radius_m <= sagitta_m:
        ends: FloatArray = track.legs[leg][[1, 2, 5, 6]].reshape(2, 2)
        return ends
    return track.along(leg, 2.0 * math.acos(1.0 - sagitta_m / radius_m))[:, :2]


def _touches(body: Body, track: Track, leg: int, walls: Walls) -> bool:
    if body.outline is None:
        path = _line(_chords(track, leg, 0.5 * TOUCH_M))
        reach_m = body.radius_m - TOUCH_M
        return len(walls.tree.query(path, "dwithin", distance=reach_m)) > 0
    if abs(track.turns[leg]) > MIN_TURN_RAD:
        return _touches_turning(body, track, leg, walls)
    ends = track.along(leg)[[0, -1]]
    swept = [
        shapely.MultiPoint(placed(piece, ends).reshape(-1, 2)).convex_hull
        for piece in _shrunk(body).pieces()
    ]
    return walls.tree.query(swept, "intersects").size > 0


def _shrunk(body: Body) -> Body:
    """Return a body whose outline, if it has one, is smaller by `TOUCH_M` all around."""
    if body.outline is None:
        return body
    smaller = body.outline.buffer(-TOUCH_M, join_style="mitre")
    assert isinstance(smaller, Polygon)
    return Body(radius_m=0.0, outline=smaller)


def _touches_turning(body: Body, track: Track, leg: int, walls: Walls) -> bool:
    reach_m = float(track.lengths[leg] + abs(track.turns[leg]) * body.circumscribed_m)

    smaller = _shrunk(body)

    def apart(shares: FloatArray) -> FloatArray:
        shapes = smaller.at(track.on(np.full(len(shares), leg), shares))
        index, distances = walls.tree.query_nearest(shapes, return_distance=True, all_matches=False)
        found = np.zeros(len(shapes))
        found[index[0]] = distances
        found[found == 0.0] = -math.inf
        return found

    return _first_meeting(apart, np.zeros(1), np.ones(1), np.array([reach_m])) is not None


# Each other ----------------------------------------------------------------------------------


def _with_each_other(run: JudgedRun) -> Iterator[Violation]:
    robots = list(zip(run.robots, run.bodies, run.tracks, strict=True))
    for (i, one, track), (j, two, other) in itertools.combinations(robots, 2):
        joints = np.unique(np.concatenate([track.legs[:, 0], other.legs[:, 0], track.legs[-1:, 4]]))
        joints = joints[joints <= run.end_s]
        if len(joints) < 2:
            joints = np.array([0.0, run.end_s])
        middles = 0.5 * (joints[:-1] + joints[1:])
        rates = track.rates(middles, 0.0 if one.outline is None else one.circumscribed_m)
        rates += other.rates(middles, 0.0 if two.outline is None else two.circumscribed_m)
        gap = _Gap(one, track, two, other)
        met_s = _first_meeting(gap, joints[:-1], joints[1:], rates)
        if met_s is not None:
            x, y, _ = track.pose(met_s)
            yield Violation(
                invariant=NAME,
                says=f"robots {i} and {j} overlap at {met_s:.2f} s, at ({x:.3f}, {y:.3f})",
                robot=i,
                time_s=met_s,
            )


class _Gap:
    """The distance of two bodies in metres at some times; where they are far apart, less."""

    def __init__(self, one: Body, track: Track, two: Body, other: Track) -> None:
        self._one, self._track, self._two, self._other = _shrunk(one), track, _shrunk(two), other
        self._both_m = one.circumscribed_m + two.circumscribed_m
        self._are_discs = one.outline is None and two.outline is None

    def __call__(self, times: FloatArray) -> FloatArray:
        here, there = self._track.at(times), self._other.at(times)
        apart: FloatArray = np.hypot(*(here - there)[:, :2].T) - self._both_m
        near = np.flatnonzero(apart <= 0.1)
        if self._are_discs or not len(near):
            return apart
        gaps = shapely.distance(
            np.array(self._one.at(here[near])), np.array(self._two.at(there[near]))
        )
        # Outlines that overlap have the distance 0 however deep they do.
        gaps = np.where(gaps == 0.0, -math.inf, gaps)
        apart[near] = gaps - self._one.radius_m - self._two.radius_m
        return apart


def _first_meeting(
    apart: Callable[[FloatArray], FloatArray],
    begin: FloatArray,
    end: FloatArray,
    rates: FloatArray,
) -> float | None:
    """Return where a distance is below 0, the first such sample; None if it never is.

    Parameters
    ----------
    apart : callable
        Returns distances (m), negative where bodies overlap.
    begin, end : (n,) array
        From where to where to look.
    rates : (n,) array
        How fast the distance changes at most there.
    """
    met = math.inf
    while len(begin):
        middle, half = 0.5 * (begin + end), 0.5 * (end - begin)
        distances, slack = apart(middle), rates * half
        hits = distances < -TOUCH_M
        if hits.any():
            met = min(met, float(middle[hits].min()))
        unsure = ~hits & (distances <= slack) & (slack >= FOUND_M) & (begin < met)
        begin, middle, end, rates = begin[unsure], middle[unsure], end[unsure], rates[unsure]
        begin, end = np.concatenate([begin, middle]), np.concatenate([middle, end])
        rates = np.concatenate([rates, rates])
    return None if math.isinf(met) else met
