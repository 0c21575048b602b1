"""How near bodies came to obstacles and to one another during a run."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from typing import Final

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from benchmarks.judge.views import FloatArray
from multisrt.campaign.bodies import Body, bodies_of, placed
from multisrt.campaign.tracks import MIN_TURN_RAD, IntArray, Track
from multisrt.recording import Recording

FOUND_M: Final = 2e-5
"""Minimum distances are found to within this, in metres."""


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
