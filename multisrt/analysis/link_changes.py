"""When radio links between two robots come and go, from their motions.

A link can change only when the distance of the two robots is one of the radio's reaches, or when
the line between them passes a corner of the world. While both keep to one leg each, these moments
are the roots of functions of time: of polynomials of degree two where both move straight, else of
smooth functions whose second derivative is bounded. Between two such moments the radio is asked
once.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from multisrt.analysis.isolation_spells import NEAR, Change
from multisrt.analysis.moving_points import (
    END,
    SPEED,
    START,
    TURN,
    VX,
    VY,
    lines_between,
    position,
    velocity,
)
from multisrt.environments.environment import Environment
from multisrt.geometry.numerics.kernel import FloatArray, kernel
from multisrt.geometry.regions.edge_index import EdgeIndex
from multisrt.simulation.radio import links_hold, weakened_range
from multisrt.spec import RadioSpec

ROUNDING = 1e-9
"""Tolerance of roots: of values (m, relative to the terms they are made of) and of times (s)."""

MIN_SPAN_S = 1e-8
"""Half-length of a span of time, around a possible root on an arc, that is not halved again."""

MAX_SPANS = 4096
"""Spans of time that are halved at once; there are more only where a function is close to zero
for long, and then their middles are taken as roots."""


def link_changes(
    spec: RadioSpec, tracks: list[FloatArray], environment: Environment | None
) -> Iterator[Change]:
    """Yield the moments at which links between robots come or go, were all radios working.

    Parameters
    ----------
    spec : RadioSpec
        How messages travel.
    tracks : list of (n, 8) array
        The robots' tracks; see `multisrt.analysis.moving_points`.
    environment : Environment or None
        The world; needed only where walls matter to the radio.
    """
    corners = np.empty((0, 2))
    index = None
    reaches = np.array([math.inf if spec.range_m is None else spec.range_m])
    if environment is not None and spec.walls_matter:
        index = EdgeIndex(environment.edges, (spec.range_m or 12.0) / 3.0)
        corners = np.unique(environment.edges[:, :2], axis=0)  # sorted by x
    if environment is not None and spec.walls == "weaken":
        reaches = np.unique(weakened_range(spec, np.arange(len(environment.edges) // 2 + 1)))
    end = tracks[0][-1, END]
    for i, j in itertools.combinations(range(len(tracks)), 2):
        roots = np.unique(_moments(tracks[i], tracks[j], reaches, corners))
        times = np.concatenate([[0.0], roots[(roots > ROUNDING) & (roots < end)]])
        times = np.append(times[np.append(True, np.diff(times) > ROUNDING)], max(end, times[-1]))
        lines = lines_between(tracks[i], tracks[j], (times[:-1] + times[1:]) / 2.0)
        holds = links_hold(spec, index, lines)
        for k in np.flatnonzero(np.diff(holds, prepend=False)):
            yield float(times[k]), NEAR, i, j


class _Pair(NamedTuple):
    """Two legs, and the function of time whose roots are sought.

    With `corner`, it is on which side of the corner (p, q) the line between the two points
    passes; else it is the square of their distance less that of a reach p.
    """

    one: FloatArray
    two: FloatArray
    corner: bool
    p: float
    q: float


@kernel
def _moments(
    one: FloatArray, two: FloatArray, reaches: FloatArray, corners: FloatArray
) -> FloatArray:
    # All moments at which a link can change, and perhaps some others: when the distance is one
    # of the reaches, which are sorted, and when a corner lies on the line between the two.
    times = [0.0]
    i = j = 0
    while i < one.shape[0] and j < two.shape[0]:
        begin = max(one[i, START], two[j, START])
        end = min(one[i, END], two[j, END])
        if begin < end and one[i, SPEED] + two[j, SPEED] > 0.0:
            _moments_in(one[i], two[j], begin, end, reaches, corners, times)
        if one[i, END] <= two[j, END]:
            i += 1
        else:
            j += 1
    return np.array(times)


@kernel
def _moments_in(
    one: FloatArray,
    two: FloatArray,
    begin: float,
    end: float,
    reaches: FloatArray,
    corners: FloatArray,
    times: list[float],
) -> None:
    # The distance in the span differs from that in its middle by no more than the robots move.
    half = (end - begin) / 2.0
    middle = begin + half
    (ax, ay), (bx, by) = position(one, middle), position(two, middle)
    apart = np.hypot(ax - bx, ay - by)
    strays = (one[SPEED] + two[SPEED]) * half + ROUNDING
    if apart - strays > reaches[-1]:
        return
    straight = one[TURN] == 0.0 and two[TURN] == 0.0
    first = np.searchsorted(reaches, apart - strays)
    last = np.searchsorted(reaches, apart + strays)
    for k in range(first, min(last, reaches.shape[0])):
        if straight:
            _straight_moments(_Pair(one, two, False, reaches[k], 0.0), begin, end, times)
        elif reaches[k] < np.inf:
            _curved_moments(_Pair(one, two, False, reaches[k], 0.0), begin, end, times)
    if not corners.shape[0]:
        return
    reach_one, reach_two = one[SPEED] * half, two[SPEED] * half
    low_x, high_x = min(ax - reach_one, bx - reach_two), max(ax + reach_one, bx + reach_two)
    low_y, high_y = min(ay - reach_one, by - reach_two), max(ay + reach_one, by + reach_two)
    for k in range(np.searchsorted(corners[:, 0], low_x), corners.shape[0]):
        x, y = corners[k, 0], corners[k, 1]
        if x > high_x:
            break
        if y < low_y or y > high_y:
            continue
        # The line passes the corner only if they can move far enough.
        side = (ax - x) * (by - y) - (ay - y) * (bx - x)
        far_a, far_b = np.hypot(ax - x, ay - y), np.hypot(bx - x, by - y)
        if abs(side) > far_b * reach_one + far_a * reach_two + reach_one * reach_two + ROUNDING:
            continue
        if straight:
            _straight_moments(_Pair(one, two, True, x, y), begin, end, times)
        else:
            _curved_moments(_Pair(one, two, True, x, y), begin, end, times)


@kernel
def _value(pair: _Pair, time: float) -> tuple[float, float, float]:
    # The function at a time, its derivative, and the scale of its rounding errors.
    one, two, corner, p, q = pair
    (ax, ay), (bx, by) = position(one, time), position(two, time)
    (ux, uy), (vx, vy) = velocity(one, time), velocity(two, time)
    if corner:
        ax, ay, bx, by = ax - p, ay - q, bx - p, by - q
        value = ax * by - ay * bx
        return value, ux * by - uy * bx + ax * vy - ay * vx, abs(ax) + abs(ay) + abs(bx) + abs(by)
    x, y = bx - ax, by - ay
    return x * x + y * y - p * p, 2.0 * (x * (vx - ux) + y * (vy - uy)), abs(x) + abs(y) + p


@kernel
def _straight_moments(pair: _Pair, begin: float, end: float, times: list[float]) -> None:
    # The roots of a polynomial a t^2 + b t + c; also where it is next to zero at the begin, the
    # end or its extremum.
    one, two = pair.one, pair.two
    c, b, scale = _value(pair, begin)
    if pair.corner:
        a = one[VX] * two[VY] - one[VY] * two[VX]
    else:
        a = (two[VX] - one[VX]) ** 2 + (two[VY] - one[VY]) ** 2
    length = end - begin
    near = ROUNDING * scale
    if abs(c) <= near:
        _take(pair, begin, times)
    if abs((a * length + b) * length + c) <= near:
        _take(pair, end, times)
    below = b * b - 4.0 * a * c
    if a == 0.0:
        if b != 0.0:
            _take_within(pair, begin, end, begin - c / b, times)
        return
    if below < 0.0:
        if abs(below) <= 4.0 * abs(a) * near:
            _take_within(pair, begin, end, begin - 0.5 * b / a, times)
        return
    # Both terms of the sum have the same sign, so that no digits cancel.
    larger = -0.5 * (b + (np.sqrt(below) if b >= 0.0 else -np.sqrt(below)))
    _take_within(pair, begin, end, begin + larger / a, times)
    if larger != 0.0:
        _take_within(pair, begin, end, begin + c / larger, times)


@kernel
def _take_within(pair: _Pair, begin: float, end: float, time: float, times: list[float]) -> None:
    if begin - ROUNDING <= time <= end + ROUNDING:
        _take(pair, min(max(time, begin), end), times)


@kernel
def _take(pair: _Pair, time: float, times: list[float]) -> None:
    # A corner in line with two robots matters where it is between them.
    one, two, corner, p, q = pair
    if corner:
        (ax, ay), (bx, by) = position(one, time), position(two, time)
        if (p - ax) * (p - bx) + (q - ay) * (q - by) > ROUNDING:
            return
    times.append(time)


@kernel
def _curved_moments(pair: _Pair, begin: float, end: float, times: list[float]) -> None:
    # The span is halved until each part has no root, or the function is monotonic in it, by its
    # value and derivative in the middle and a bound on its second derivative.
    one, two, corner, p, q = pair
    speed = one[SPEED] + two[SPEED]
    bend_one, bend_two = one[SPEED] * abs(one[TURN]), two[SPEED] * abs(two[TURN])
    starts, ends = np.array([begin]), np.array([end])
    while starts.shape[0]:
        left = np.empty(2 * starts.shape[0])
        right = np.empty(2 * starts.shape[0])
        count = 0
        for k in range(starts.shape[0]):
            middle, half = (starts[k] + ends[k]) / 2.0, (ends[k] - starts[k]) / 2.0
            value, rate, _ = _value(pair, middle)
            (ax, ay), (bx, by) = position(one, middle), position(two, middle)
            if corner:
                far_one = np.hypot(ax - p, ay - q) + one[SPEED] * half
                far_two = np.hypot(bx - p, by - q) + two[SPEED] * half
                bend = bend_one * far_two + 2.0 * one[SPEED] * two[SPEED] + far_one * bend_two
            else:
                far = np.hypot(bx - ax, by - ay) + speed * half
                bend = 2.0 * (speed * speed + far * (bend_one + bend_two))
            if abs(value) > (abs(rate) + 0.5 * bend * half) * half + ROUNDING:
                continue
            if abs(rate) > bend * half:
                _one_root(pair, starts[k], ends[k], times)
            elif half <= MIN_SPAN_S or starts.shape[0] > MAX_SPANS:
                _take(pair, middle, times)
            else:
                left[count], right[count] = starts[k], middle
                left[count + 1], right[count + 1] = middle, ends[k]
                count += 2
        starts, ends = left[:count].copy(), right[:count].copy()


@kernel
def _one_root(pair: _Pair, begin: float, end: float, times: list[float]) -> None:
    # Bisection of a monotonic function.
    at_begin, _, scale = _value(pair, begin)
    at_end, _, _ = _value(pair, end)
    for value, time in ((at_begin, begin), (at_end, end)):
        if abs(value) <= ROUNDING * scale:
            _take(pair, time, times)
    if (at_begin > 0.0) == (at_end > 0.0):
        return
    while end - begin > ROUNDING:
        middle = (begin + end) / 2.0
        value, _, _ = _value(pair, middle)
        if (value > 0.0) == (at_begin > 0.0):
            begin = middle
        else:
            end = middle
    _take(pair, (begin + end) / 2.0, times)
