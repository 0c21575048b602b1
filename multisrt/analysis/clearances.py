"""How near bodies came to obstacles and to one another in a run.

Distances are computed with shapely, independently of the collision queries of the simulation;
those of two discs follow from their centres and radii.

Between two waypoints a body moves with a constant twist. Over a share `s` of such a leg, with
turn `a` and chord `C`, its reference point has moved by the chord turned by `(s - 1) a / 2` and
shortened by `sin(s a / 2) / sin(a / 2)`.
"""

from __future__ import annotations

import itertools
import math
from collections import defaultdict
from functools import lru_cache
from typing import NamedTuple
from weakref import WeakKeyDictionary

import numpy as np
import shapely
from numpy.typing import ArrayLike

from multisrt.environments.environment import Environment
from multisrt.events import Motion
from multisrt.geometry.bodies.footprint import Footprint
from multisrt.geometry.numerics.kernel import BoolArray, FloatArray, IntArray
from multisrt.recording import Recording

TURN_STEP_RAD = math.radians(2.0)
"""Largest step in which turns are sampled."""

SAGITTA_M = 1e-4
"""Largest distance of an arc from the chords that stand for it, in metres."""

TOLERANCE_M = 1e-4
"""Tolerance of the smallest distance between robots, in metres."""

ROUNDING_M = 1e-9
"""Bound of the difference of distances that are computed in two ways, in metres."""


class Track(NamedTuple):
    """The motion of a robot from 0 to the end of the run.

    Attributes
    ----------
    legs : (n, 8) array
        Time, x, y, heading at the start and at the end of each leg; legs follow one another
        without gaps.
    stands : (k + 1,) array of int
        Indices of the legs on which it stands: one before each of its k motions, and the last.
    """

    legs: FloatArray
    stands: IntArray

    @property
    def driven(self) -> FloatArray:
        """The legs of its motions."""
        return np.delete(self.legs, self.stands, axis=0)

    def moving_spans(self) -> FloatArray:
        """Return begin and end of each leg on which the body moved or turned, ``(m, 2)``."""
        driven = self.driven
        moving = (driven[:, 1:4] != driven[:, 5:]).any(axis=1)
        return np.column_stack([driven[moving, 0], driven[moving, 4]])

    def length_m(self) -> float:
        """Return the path length of the reference point, along arcs, in metres."""
        lengths = _lengths(self.legs)
        return math.fsum(
            lengths[before + 1 : after].sum()
            for before, after in itertools.pairwise(self.stands.tolist())
        )


_TRACKS: WeakKeyDictionary[Recording, tuple[Track, ...]] = WeakKeyDictionary()


def tracks(recording: Recording) -> tuple[Track, ...]:
    """Return the track of each robot, computed once for a recording."""
    if recording not in _TRACKS:
        _TRACKS[recording] = _laid_out(recording)
    return _TRACKS[recording]


def _laid_out(recording: Recording) -> tuple[Track, ...]:
    motions: dict[int, list[Motion]] = defaultdict(list)
    for motion in recording.of(Motion):
        motions[motion.robot].append(motion)
    return tuple(
        _track(start, motions[robot], recording.footer.time_s)
        for robot, start in enumerate(recording.header.starts)
    )


def _track(start: tuple[float, float, float], motions: list[Motion], end: float) -> Track:
    motions.sort(key=lambda motion: motion.time_s)
    ways = [motion.waypoints for motion in motions]
    points = [(0.0, *start), *itertools.chain.from_iterable(ways)]
    last = points[-1]
    way = np.array([*points, (max(end, last[0]), *last[1:])])
    legs: FloatArray = np.hstack([way[:-1], way[1:]])
    stands = np.cumsum([0, *map(len, ways)])
    legs[stands, 5:] = legs[stands, 1:4]
    return Track(legs, stands)


def smallest_clearance(recording: Recording, environment: Environment) -> float:
    """Return the smallest distance between a body and an obstacle during a run, in metres.

    It is negative where the centre of a disc came nearer than its radius. Turns of other bodies
    are sampled in steps of `TURN_STEP_RAD`.
    """
    walls = _walls(environment)
    smallest = math.inf
    for robot, track in zip(recording.spec.robots, tracks(recording), strict=True):
        footprint = Footprint.parse(robot.footprint)
        shapes = _outlines(footprint, track.legs[:1, 1:4]) + _swept(footprint, track.driven)
        radius = footprint.radius_m if footprint.is_disc else 0.0
        # Walls farther away than the smallest distance so far need not be measured.
        at_start = float(shapely.distance(shapes[0], walls.geometries).min())
        least = max(0.0, min(smallest + radius, at_start)) + ROUNDING_M
        which, wall = walls.query(shapes, predicate="dwithin", distance=least)
        distances = shapely.distance(np.array(shapes)[which], walls.geometries[wall])
        smallest = min(smallest, float(np.min(distances, initial=math.inf)) - radius)
    return smallest


@lru_cache(maxsize=8)
def _walls(environment: Environment) -> shapely.STRtree:
    # The tree is built once for many runs in one world.
    walls = np.asarray(shapely.linestrings(environment.edges.reshape(-1, 2, 2)))
    return shapely.STRtree(walls.tolist())


def smallest_distance_between_robots(recording: Recording) -> float | None:
    """Return the smallest distance between two bodies at one moment of a run, in metres.

    Bodies count all the time, also those of robots that are switched off, done or dead. The
    result is exact for discs that move straight, else at most `TOLERANCE_M` too large; it is 0
    where two bodies touch, and None for a single robot.
    """
    if len(recording.spec.robots) < 2:
        return None
    legs = [_lasting(track.legs) for track in tracks(recording)]
    bodies = [Footprint.parse(robot.footprint) for robot in recording.spec.robots]
    best = math.inf
    for i, j in itertools.combinations(range(len(legs)), 2):
        best = _closest_approach(_Pair(bodies[i], bodies[j]), _together(legs[i], legs[j]), best)
    return max(0.0, best)


def _lengths(legs: FloatArray) -> FloatArray:
    chords = np.hypot(legs[:, 5] - legs[:, 1], legs[:, 6] - legs[:, 2])
    return np.where(chords > 0.0, chords / _chord_share(legs[:, 7] - legs[:, 3]), 0.0)


def _chord_share(turn: FloatArray) -> FloatArray:
    # The ratio of the length of a chord to that of its arc.
    share: FloatArray = np.sinc(turn / (2.0 * math.pi))
    return np.where(share == 0.0, 1.0, share)  # a full turn in place, which has no chord


def _poses(legs: FloatArray, share: FloatArray) -> FloatArray:
    # The poses at a share, from 0 to 1, of each leg; (n, 3).
    chord_x, chord_y = legs[:, 5] - legs[:, 1], legs[:, 6] - legs[:, 2]
    turn = legs[:, 7] - legs[:, 3]
    length = share * np.sinc(share * turn / (2.0 * math.pi)) / _chord_share(turn)
    angle = (share - 1.0) * turn / 2.0
    cos, sin = length * np.cos(angle), length * np.sin(angle)
    return np.column_stack(
        [
            legs[:, 1] + cos * chord_x - sin * chord_y,
            legs[:, 2] + sin * chord_x + cos * chord_y,
            legs[:, 3] + share * turn,
        ]
    )


def _swept(footprint: Footprint, legs: FloatArray) -> list[shapely.Geometry]:
    # The areas that a body covers on legs; for a disc the path of its centre.
    lengths, turns = _lengths(legs), np.abs(legs[:, 7] - legs[:, 3])
    still = (lengths == 0.0) & (footprint.is_disc | (turns == 0.0))
    shapes = _outlines(footprint, legs[still, 1:4])
    if footprint.is_disc:
        straight = (turns == 0.0) & ~still
        arcs = ~still & ~straight
        ends = legs[straight][:, [1, 2, 5, 6]].reshape(-1, 2, 2)
        shapes += shapely.linestrings(ends).tolist()
        return shapes + _arcs(legs[arcs], lengths[arcs], turns[arcs])
    for leg, length, turn in zip(legs[~still], lengths[~still], turns[~still], strict=True):
        shapes += _swept_on(footprint, leg, length, turn)
    return shapes


def _arcs(legs: FloatArray, lengths: FloatArray, turns: FloatArray) -> list[shapely.Geometry]:
    # The paths of the centre of a disc on legs that are arcs.
    steps = np.ceil(turns / _steps(lengths / turns)).astype(np.int64) + 1
    which = np.repeat(np.arange(len(legs)), steps + 1)
    step = np.arange(len(which)) - np.repeat(np.cumsum(steps + 1) - (steps + 1), steps + 1)
    poses = _poses(legs[which], step / steps[which])
    arcs: list[shapely.Geometry] = np.asarray(
        shapely.linestrings(poses[:, :2], indices=which)
    ).tolist()
    return arcs


def _swept_on(
    footprint: Footprint, leg: FloatArray, length: float, turn: float
) -> list[shapely.Geometry]:
    # The areas that a polygon covers on one leg on which it moves or turns.
    if turn == 0.0:
        return [footprint.swept((*leg[1:3], leg[3]), (*leg[5:7], leg[3]))]
    radius = length / turn + footprint.circumscribed_radius_m
    poses = _along(leg, max(2, math.ceil(turn / float(_steps(radius)))))
    if length == 0.0:
        return _outlines(footprint, poses)
    pieces = []
    for piece in footprint.convex_pieces:
        placed = _placed(piece, poses)
        both = np.concatenate([placed[:-1], placed[1:]], axis=1)
        pieces += np.asarray(shapely.convex_hull(shapely.multipoints(both))).tolist()
    return pieces


def _steps(radius_m: ArrayLike) -> FloatArray:
    # The largest step of a turn on arcs of given radii, in radians.
    steps: FloatArray = np.minimum(TURN_STEP_RAD, np.sqrt(8.0 * SAGITTA_M / np.asarray(radius_m)))
    return steps


def _along(leg: FloatArray, steps: int) -> FloatArray:
    shares = np.linspace(0.0, 1.0, steps + 1)
    return _poses(np.broadcast_to(leg, (steps + 1, 8)), shares)


def _placed(points: FloatArray, poses: FloatArray) -> FloatArray:
    # Points in the frame of a body, at many poses; (poses, points, 2).
    cos, sin = np.cos(poses[:, 2])[:, None], np.sin(poses[:, 2])[:, None]
    x, y = points[:, 0], points[:, 1]
    return np.stack([poses[:, :1] + cos * x - sin * y, poses[:, 1:2] + sin * x + cos * y], axis=-1)


def _outlines(footprint: Footprint, poses: FloatArray) -> list[shapely.Geometry]:
    # The body at many poses; for a disc its centre.
    shapes = (
        shapely.points(poses[:, :2])
        if footprint.is_disc
        else shapely.polygons(_placed(footprint.vertices, poses))
    )
    outlines: list[shapely.Geometry] = np.asarray(shapes).tolist()
    return outlines


# Two robots at a time.


class _Pair(NamedTuple):
    """Two bodies."""

    one: Footprint
    two: Footprint

    def distances(self, at_one: FloatArray, at_two: FloatArray) -> FloatArray:
        gaps: FloatArray
        if self.one.is_disc and self.two.is_disc:
            gaps = np.linalg.norm((at_one - at_two)[:, :2], axis=1)
        else:
            gaps = shapely.distance(
                np.array(_outlines(self.one, at_one)), np.array(_outlines(self.two, at_two))
            )
        return gaps - sum(body.radius_m for body in self if body.is_disc)


class _Spans(NamedTuple):
    """Spans of time in which each of two robots is on one leg."""

    one: FloatArray
    two: FloatArray
    start: FloatArray
    end: FloatArray

    def where(self, which: BoolArray) -> _Spans:
        return _Spans(*(part[which] for part in self))

    def halves(self) -> _Spans:
        middle = (self.start + self.end) / 2.0
        return _Spans(
            np.concatenate([self.one, self.one]),
            np.concatenate([self.two, self.two]),
            np.concatenate([self.start, middle]),
            np.concatenate([middle, self.end]),
        )


def _lasting(legs: FloatArray) -> FloatArray:
    # Legs that take no time are left out, as they have no speed.
    lasting = legs[legs[:, 4] > legs[:, 0]]
    return lasting if len(lasting) else legs[-1:]


def _together(one: FloatArray, two: FloatArray) -> _Spans:
    times = np.unique(np.concatenate([one[:, 0], two[:, 0], one[-1:, 4], two[-1:, 4]]))
    start, end = (times, times) if len(times) == 1 else (times[:-1], times[1:])
    return _Spans(_legs_at(one, start), _legs_at(two, start), start, end)


def _legs_at(track: FloatArray, times: FloatArray) -> FloatArray:
    which = np.searchsorted(track[:, 0], times, side="right") - 1
    legs: FloatArray = track[np.clip(which, 0, len(track) - 1)]
    return legs


def _closest_approach(pair: _Pair, spans: _Spans, best: float) -> float:
    """Return the smallest distance of two bodies, or `best` unless it is clearly smaller.

    Branch and bound: in a span of time, the distance is at least that in its middle less what
    the bodies can approach in half of the span.
    """
    reach = sum(body.circumscribed_radius_m for body in pair)
    exact_bodies = all(body.is_disc for body in pair)
    spans = spans.where(_apart(spans) - reach < best)
    while len(spans.start):
        velocity, rate = _speeds(pair, spans)
        straight = rate == 0.0
        moment = (spans.start + spans.end) / 2.0
        if exact_bodies:
            moment = np.where(straight, _nearest_moment(spans, velocity), moment)
        at_one, at_two = _poses_at(spans.one, moment), _poses_at(spans.two, moment)
        half = (spans.end - spans.start) / 2.0
        nearer = (np.hypot(*velocity.T) + rate) * half
        if exact_bodies:
            nearer[straight] = 0.0
        near = np.hypot(*(at_one - at_two)[:, :2].T) - reach - nearer < best - TOLERANCE_M
        if not near.any():
            return best
        distances = pair.distances(at_one[near], at_two[near])
        best = min(best, float(distances.min()))
        spans = spans.where(near).where(
            (distances - nearer[near] < best - TOLERANCE_M) & (nearer[near] > 0.0)
        )
        spans = spans.halves()
    return best


def _apart(spans: _Spans) -> FloatArray:
    # A lower bound of the distance between the paths of two reference points.
    one, two = spans.one, spans.two
    between = np.hypot(two[:, 1] - one[:, 1], two[:, 2] - one[:, 2])
    return between - _lengths(one) - _lengths(two) - ROUNDING_M


def _poses_at(legs: FloatArray, times: FloatArray) -> FloatArray:
    return _poses(legs, np.clip((times - legs[:, 0]) / _duration(legs), 0.0, 1.0))


def _duration(legs: FloatArray) -> FloatArray:
    duration = legs[:, 4] - legs[:, 0]
    return np.where(duration > 0.0, duration, 1.0)


def _speeds(pair: _Pair, spans: _Spans) -> tuple[FloatArray, FloatArray]:
    # The relative velocity where both bodies move straight, else 0; and a bound on how fast their
    # points move besides: 0 where both move straight, else the full speed.
    velocities, rates, turning = [], [], np.zeros(len(spans.start), np.bool_)
    for body, legs in zip(pair, (spans.one, spans.two), strict=True):
        duration = _duration(legs)
        turn = np.abs(legs[:, 7] - legs[:, 3]) / duration
        length = _lengths(legs)
        if body.is_disc:
            turning |= (turn > 0.0) & (length > 0.0)
            rates.append(length / duration)
        else:
            turning |= turn > 0.0
            rates.append(length / duration + turn * body.circumscribed_radius_m)
        velocities.append((legs[:, 5:7] - legs[:, 1:3]) / duration[:, None])
    velocity = np.where(turning[:, None], 0.0, velocities[0] - velocities[1])
    return velocity, np.where(turning, rates[0] + rates[1], 0.0)


def _nearest_moment(spans: _Spans, velocity: FloatArray) -> FloatArray:
    # The moment at which two points that move straight are nearest to each other.
    apart = (_poses_at(spans.one, spans.start) - _poses_at(spans.two, spans.start))[:, :2]
    speed2 = np.maximum((velocity**2).sum(axis=1), 1e-300)
    after = -(apart * velocity).sum(axis=1) / speed2
    moment: FloatArray = spans.start + np.clip(after, 0.0, spans.end - spans.start)
    return moment
