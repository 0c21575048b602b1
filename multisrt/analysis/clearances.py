"""How near bodies came to obstacles and to one another in a run.

Distances are computed with shapely and in closed form, independently of the collision queries of
the simulation.
"""

from __future__ import annotations

import itertools
import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np
import shapely

from multisrt.analysis.arc_distances import arcs_to_segments, centres_of_rotation
from multisrt.analysis.poses import durations, leg_lengths, legs_at, poses_on, tracks
from multisrt.environments.environment import Environment
from multisrt.geometry.bodies.footprint import Footprint
from multisrt.geometry.numerics import libm
from multisrt.geometry.numerics.kernel import BoolArray, FloatArray
from multisrt.recording import Recording

MIN_TURN_RAD = 1e-7
"""Turn in radians below which a leg that translates is taken as straight, which is more exact."""

TOLERANCE_M = 1e-6
"""Tolerance of the smallest distance between robots, in metres."""

MAX_PAIRS = 20_000
"""Pairs of a leg and a wall that are computed at once, which bounds the memory."""

ROUNDING_M = 1e-9
"""Bound of the difference of distances that are computed in two ways, in metres."""


def smallest_clearance(recording: Recording, environment: Environment) -> float:
    """Return the smallest distance between a body and an obstacle during a run, in metres.

    It is negative where the centre of a disc came nearer than its radius. It is exact but for
    rounding: a leg sweeps a polygon where it is straight, and where it turns each corner of the
    body moves on an arc about one centre of rotation, as each end of a wall does seen from the
    body. Two polygons are nearest to each other at a corner of one of them.
    """
    walls = _walls(environment)
    smallest = math.inf
    for robot, track in zip(recording.spec.robots, tracks(recording), strict=True):
        footprint = Footprint.parse(robot.footprint)
        turns = _turns(footprint, track.driven)
        shapes = _outlines(footprint, track.legs[:1, 1:4])
        shapes += _outlines(footprint, track.driven[turns, 1:4])
        shapes += _swept(footprint, track.driven[~turns])
        radius = footprint.radius_m if footprint.is_disc else 0.0
        # Walls farther away than the smallest distance so far need not be measured.
        at_start = float(shapely.distance(shapes[0], walls.geometries).min())
        least = max(0.0, min(smallest + radius, at_start)) + ROUNDING_M
        which, wall = walls.query(shapes, predicate="dwithin", distance=least)
        distances = shapely.distance(np.array(shapes)[which], walls.geometries[wall])
        smallest = min(smallest, float(np.min(distances, initial=math.inf)) - radius)
        smallest = min(smallest, _on_turns(footprint, track.driven[turns], walls, smallest))
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


def _turns(footprint: Footprint, legs: FloatArray) -> BoolArray:
    # Whether a body turns on each leg: the centre of a disc only where it moves as well.
    stays = (legs[:, 1:3] == legs[:, 5:7]).all(axis=1)
    turn = np.abs(legs[:, 7] - legs[:, 3])
    turns: BoolArray = np.where(stays, (turn > 0.0) & (not footprint.is_disc), turn >= MIN_TURN_RAD)
    return turns


def _swept(footprint: Footprint, legs: FloatArray) -> list[shapely.Geometry]:
    # The areas that a body covers on straight legs; for a disc the path of its centre.
    still = (legs[:, 1:3] == legs[:, 5:7]).all(axis=1)
    shapes = _outlines(footprint, legs[still, 1:4])
    if footprint.is_disc:
        ends = legs[~still][:, [1, 2, 5, 6]].reshape(-1, 2, 2)
        shapes += np.asarray(shapely.linestrings(ends)).tolist()
        return shapes
    return shapes + [
        footprint.swept((*leg[1:3], leg[3]), (*leg[5:7], leg[3])) for leg in legs[~still]
    ]


def _on_turns(
    footprint: Footprint, legs: FloatArray, walls: shapely.STRtree, least: float
) -> float:
    # The smallest clearance on legs on which a body turns, or `least` if none is smaller.
    turns = legs[:, 7] - legs[:, 3]
    centres = centres_of_rotation(legs[:, 1:3], legs[:, 5:7], turns)
    # An arc is no farther from its chord than its sagitta.
    sagittas = np.hypot(*(legs[:, 1:3] - centres).T) * (1.0 - libm.cos(0.5 * turns))
    stays = (legs[:, 1:3] == legs[:, 5:7]).all(axis=1)
    chords = np.asarray(shapely.linestrings(legs[:, [1, 2, 5, 6]].reshape(-1, 2, 2)))
    chords[stays] = shapely.points(legs[stays, 1:3])
    reach = np.maximum(0.0, least + footprint.circumscribed_radius_m + sagittas) + ROUNDING_M
    which, wall = walls.query(chords, predicate="dwithin", distance=reach)
    segments = shapely.get_coordinates(walls.geometries).reshape(-1, 2, 2)[wall]
    for first in range(0, len(which), MAX_PAIRS):
        part = slice(first, first + MAX_PAIRS)
        leg, wall_ends = which[part], segments[part]
        turn, centre = turns[leg, None], centres[leg, None]
        if footprint.is_disc:
            at = legs[leg, None, 1:3]
            distances = arcs_to_segments(centre, at, turn, wall_ends[:, None])
            least = min(least, float(distances.min()) - footprint.radius_m)
            continue
        corners = _placed(footprint.vertices, legs[leg, 1:4])
        sides = np.stack([corners, np.roll(corners, -1, axis=1)], axis=2)
        of_corners = arcs_to_segments(centre, corners, turn, wall_ends[:, None])
        of_walls = arcs_to_segments(
            centre[:, None], wall_ends[:, :, None], -turn[:, None], sides[:, None]
        )
        least = min(least, float(of_corners.min()), float(of_walls.min()))
    return least


def _placed(points: FloatArray, poses: FloatArray) -> FloatArray:
    # Points in the frame of a body, at many poses; (poses, points, 2).
    cos, sin = libm.cos(poses[:, 2])[:, None], libm.sin(poses[:, 2])[:, None]
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
        return gaps - self._radii()

    def distances_over(self, spans: _Spans) -> FloatArray:
        # Where both move straight: one is swept along its motion as seen from the other.
        at_one, at_two = poses_on(spans.one, spans.start), poses_on(spans.two, spans.start)
        later = poses_on(spans.one, spans.end) - (poses_on(spans.two, spans.end) - at_two)
        later[:, 2] = at_one[:, 2]
        others = np.array(_outlines(self.two, at_two))
        gaps = np.full(len(others), np.inf)
        pieces = [np.zeros((1, 2))] if self.one.is_disc else self.one.convex_pieces
        for piece in pieces:
            both = np.concatenate([_placed(piece, at_one), _placed(piece, later)], axis=1)
            swept = shapely.convex_hull(shapely.multipoints(both))
            gaps = np.minimum(gaps, shapely.distance(swept, others))
        return gaps - self._radii()

    def _radii(self) -> float:
        return sum(body.radius_m for body in self if body.is_disc)


def _lasting(legs: FloatArray) -> FloatArray:
    # Legs that take no time are left out, as they have no speed.
    lasting = legs[legs[:, 4] > legs[:, 0]]
    return lasting if len(lasting) else legs[-1:]


def _together(one: FloatArray, two: FloatArray) -> _Spans:
    times = np.unique(np.concatenate([one[:, 0], two[:, 0], one[-1:, 4], two[-1:, 4]]))
    start, end = (times, times) if len(times) == 1 else (times[:-1], times[1:])
    return _Spans(legs_at(one, start), legs_at(two, start), start, end)


def _closest_approach(pair: _Pair, spans: _Spans, best: float) -> float:
    """Return the smallest distance of two bodies, or `best` unless it is clearly smaller.

    Branch and bound: in a span of time, the distance is at least that in its middle less what
    the bodies can approach in half of the span.
    """
    reach = sum(body.circumscribed_radius_m for body in pair)
    spans = spans.where(_apart(spans) - reach < best)
    while len(spans.start):
        moment, nearer = (spans.start + spans.end) / 2.0, _approach(pair, spans)
        at_one, at_two = poses_on(spans.one, moment), poses_on(spans.two, moment)
        near = np.hypot(*(at_one - at_two)[:, :2].T) - reach - nearer < best - TOLERANCE_M
        straight = near & _are_straight(pair, spans)
        if straight.any():
            best = min(best, float(pair.distances_over(spans.where(straight)).min()))
        near &= ~straight
        if not near.any():
            return best
        distances = pair.distances(at_one[near], at_two[near])
        best = min(best, float(distances.min()))
        if best <= 0.0:
            return best
        spans = spans.where(near).where(
            (distances - nearer[near] < best - TOLERANCE_M) & (nearer[near] > 0.0)
        )
        spans = spans.halves()
    return best


def _approach(pair: _Pair, spans: _Spans) -> FloatArray:
    """Return how much two bodies can approach from the middle of a span to one of its ends.

    Their nearest points p and q approach at most as fast as ``n . (p' - q')`` for the direction n
    between them, to which ``W x (p - q)`` is perpendicular for every rate W. With the reference
    points r and s, velocities v and u and turn rates f and g, that is bounded by
    ``|v - u - W x (r - s)| + |f - W| R + |g - W| Q``, R and Q being the radii of the bodies, 0 for
    discs. The first term changes by at most ``|f - W| |v| + |g - W| |u|`` per second. The smallest
    bound for the rates W = 0, f and g is returned: it is 0 for bodies at rest to one another, also
    where they turn together.
    """
    half = (spans.end - spans.start) / 2.0
    moment = spans.start + half
    (r, v, f), (s, u, g) = (_motion_at(legs, moment) for legs in (spans.one, spans.two))
    radius_r, radius_s = (0.0 if body.is_disc else body.circumscribed_radius_m for body in pair)
    speed_v, speed_u = np.hypot(*v.T), np.hypot(*u.T)
    smallest = np.full(len(half), np.inf)
    for rate in (np.zeros_like(f), f, g):
        x, y = (r - s).T
        aside = v - u - rate[:, None] * np.column_stack([-y, x])
        off_f, off_g = np.abs(f - rate), np.abs(g - rate)
        change = off_f * speed_v + off_g * speed_u
        speed = np.hypot(*aside.T) + off_f * radius_r + off_g * radius_s
        smallest = np.minimum(smallest, half * (speed + 0.5 * half * change))
    return smallest


def _motion_at(legs: FloatArray, times: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    # Position, velocity and turn rate of reference points.
    poses, duration = poses_on(legs, times), durations(legs)
    turn = legs[:, 7] - legs[:, 3]
    angle = libm.arctan2(legs[:, 6] - legs[:, 2], legs[:, 5] - legs[:, 1])
    angle = angle + poses[:, 2] - legs[:, 3] - turn / 2.0
    speed = leg_lengths(legs) / duration
    velocity = np.column_stack([speed * libm.cos(angle), speed * libm.sin(angle)])
    return poses[:, :2], velocity, turn / duration


def _apart(spans: _Spans) -> FloatArray:
    # A lower bound of the distance between the paths of two reference points.
    one, two = spans.one, spans.two
    between = np.hypot(two[:, 1] - one[:, 1], two[:, 2] - one[:, 2])
    return between - leg_lengths(one) - leg_lengths(two) - ROUNDING_M


def _are_straight(pair: _Pair, spans: _Spans) -> BoolArray:
    # Whether both bodies move straight; the centre of a disc does where it turns in place.
    straight = np.ones(len(spans.start), np.bool_)
    for body, legs in zip(pair, (spans.one, spans.two), strict=True):
        straight &= ~_turns(body, legs)
    return straight
