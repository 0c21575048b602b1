"""How far a robot was from the nearest other one."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from multisrt.analysis.isolation_spells import Spell
from multisrt.analysis.moving_points import SPEED, START, TURN, leg_at, position
from multisrt.geometry.numerics.kernel import FloatArray, IntArray, kernel

TOLERANCE_M = 1e-6
"""The largest separation is found to within this."""

MIN_SPAN_S = 1e-9
"""Spans of time that are no longer than this are not halved again."""

MAX_DEPTH = 64
"""Size of the stack of halved spans."""


def largest_separation(
    robot: int, spells: Sequence[Spell], tracks: list[FloatArray], present: Sequence[Spell]
) -> float:
    """Return the largest distance of a robot to the nearest other one that takes part, in metres.

    Parameters
    ----------
    robot : int
        The robot.
    spells : sequence of Spell
        The times that count.
    tracks : list of (n, 8) array
        All robots' tracks; see `multisrt.analysis.moving_points`.
    present : sequence of Spell
        From when to when each robot takes part.
    """
    legs = np.vstack(tracks)
    first = np.cumsum([0, *map(len, tracks)])
    lives = np.array(present)
    joints = np.unique(np.concatenate([legs[:, START], lives.ravel()]))
    farthest = -math.inf
    for begin, end in spells:
        inside = joints[(joints > begin) & (joints < end)]
        times = np.concatenate([[begin], inside, [end]])
        farthest = _farthest_in(robot, times, legs, first, lives, farthest)
    return farthest


@kernel
def _farthest_in(
    robot: int,
    times: FloatArray,
    legs: FloatArray,
    first: IntArray,
    lives: FloatArray,
    farthest: float,
) -> float:
    # Branch and bound over spans in which every robot keeps to one leg. Two that move straight are
    # never farther apart than at one of the ends; on arcs, by no more than the arcs bend.
    nearest = 0
    stack = np.empty((MAX_DEPTH, 2))
    on = np.zeros(lives.shape[0], np.int64)
    for k in range(times.shape[0] - 1):
        stack[0, 0], stack[0, 1] = times[k], times[k + 1]
        middle = (times[k] + times[k + 1]) / 2.0
        for j in range(lives.shape[0]):
            last = first[j + 1] - 1
            if on[j] == 0:
                on[j] = first[j] + leg_at(legs[first[j] : first[j + 1]], middle)
            while on[j] < last and legs[on[j] + 1, START] <= middle:
                on[j] += 1
        depth = 1
        while depth > 0:
            depth -= 1
            begin, end = stack[depth, 0], stack[depth, 1]
            own = legs[on[robot]]
            (ax, ay), (bx, by) = position(own, begin), position(own, end)
            bound = at_begin = at_end = np.inf
            # The robot that was nearest comes first: its bound most often rules out the others.
            for turn in range(-1, lives.shape[0]):
                j = nearest if turn < 0 else turn
                if j == robot or lives[j, 0] > middle or lives[j, 1] < middle:
                    continue
                other = legs[on[j]]
                (px, py), (qx, qy) = position(other, begin), position(other, end)
                one, two = np.hypot(px - ax, py - ay), np.hypot(qx - bx, qy - by)
                most = max(one, two)
                bend = own[SPEED] * abs(own[TURN]) + other[SPEED] * abs(other[TURN])
                if bend > 0.0:
                    # The second derivative of the squared distance is no less than -2 `far` `bend`.
                    length = end - begin
                    far = most + (own[SPEED] + other[SPEED]) * length
                    most = np.sqrt(most * most + 0.25 * far * bend * length * length)
                if most < bound:
                    bound = most
                    nearest = j
                at_begin, at_end = min(at_begin, one), min(at_end, two)
                if bound <= farthest + TOLERANCE_M:
                    break
            if bound <= farthest + TOLERANCE_M:
                continue
            farthest = max(farthest, at_begin, at_end)
            if (
                bound > farthest + TOLERANCE_M
                and end - begin > MIN_SPAN_S
                and depth + 2 <= MAX_DEPTH
            ):
                half = (begin + end) / 2.0
                stack[depth, 0], stack[depth, 1] = begin, half
                stack[depth + 1, 0], stack[depth + 1, 1] = half, end
                depth += 2
    return farthest
