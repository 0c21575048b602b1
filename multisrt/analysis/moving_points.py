"""Reference points of bodies as functions of time, on legs of constant twist.

A track is an ``(n, 8)`` array, one row a leg, with the columns `START` to `SPEED`. Its legs follow
one another without gaps from 0 to the end of the run.
"""

from __future__ import annotations

import numpy as np

from multisrt.geometry.numerics import libm
from multisrt.geometry.numerics.kernel import FloatArray, kernel

START, END, X, Y, VX, VY, TURN, SPEED = range(8)
"""Columns of a track: the times at the start and the end of a leg (s), the position (m) and the
velocity (m/s) at its start, the turn rate (rad/s), and the speed (m/s)."""


def track_of_legs(legs: FloatArray) -> FloatArray:
    """Return the track of a robot.

    Parameters
    ----------
    legs : (n, 8) array
        Time, x, y and heading at the start and at the end of each leg, as in
        `multisrt.analysis.poses.Track`.

    Returns
    -------
    (m, 8) array
        The legs that last, or the last leg if none does.
    """
    a, b = legs[:, :4], legs[:, 4:]
    lasting = b[:, 0] > a[:, 0]
    moves = lasting & (a[:, 1:3] != b[:, 1:3]).any(axis=1)
    chord = np.where(moves[:, None], b[:, 1:3] - a[:, 1:3], 0.0)
    turn = np.where(moves, b[:, 3] - a[:, 3], 0.0)
    duration = np.where(lasting, b[:, 0] - a[:, 0], 1.0)
    # An arc is longer than its chord, and starts at an angle of half its turn to it.
    rate = 1.0 / (libm.sinc(turn / 2.0) * duration)
    cos, sin = rate * libm.cos(turn / 2.0), rate * libm.sin(turn / 2.0)
    vx = cos * chord[:, 0] + sin * chord[:, 1]
    vy = cos * chord[:, 1] - sin * chord[:, 0]
    track = np.column_stack(
        [a[:, 0], b[:, 0], a[:, 1:3], vx, vy, turn / duration, np.hypot(vx, vy)]
    )
    return track[lasting] if lasting.any() else track[-1:]


def standing_track(place: tuple[float, float], end_s: float) -> FloatArray:
    """Return the track of what stands at a place from 0 to the end of the run, in seconds."""
    return np.array([[0.0, end_s, *place, 0.0, 0.0, 0.0, 0.0]])


@kernel
def position(leg: FloatArray, time: float) -> tuple[float, float]:
    """Return x and y at a time on a leg."""
    after = time - leg[START]
    if leg[TURN] == 0.0:
        return leg[X] + leg[VX] * after, leg[Y] + leg[VY] * after
    along = np.sin(leg[TURN] * after) / leg[TURN]
    aside = 2.0 * np.sin(0.5 * leg[TURN] * after) ** 2 / leg[TURN]
    return (
        leg[X] + along * leg[VX] - aside * leg[VY],
        leg[Y] + along * leg[VY] + aside * leg[VX],
    )


@kernel
def velocity(leg: FloatArray, time: float) -> tuple[float, float]:
    """Return the velocity by x and y at a time on a leg."""
    cos, sin = np.cos(leg[TURN] * (time - leg[START])), np.sin(leg[TURN] * (time - leg[START]))
    return cos * leg[VX] - sin * leg[VY], sin * leg[VX] + cos * leg[VY]


@kernel
def leg_at(track: FloatArray, time: float) -> int:
    """Return the index of the last leg that has started by a time."""
    first, last = 0, track.shape[0] - 1
    while first < last:
        middle = (first + last + 1) // 2
        if track[middle, START] <= time:
            first = middle
        else:
            last = middle - 1
    return first


@kernel
def lines_between(one: FloatArray, two: FloatArray, times: FloatArray) -> FloatArray:
    """Return the lines between the points of two tracks at some times, ``(n, 4)``."""
    lines = np.empty((times.shape[0], 4))
    for k in range(times.shape[0]):
        i, j = leg_at(one, times[k]), leg_at(two, times[k])
        lines[k, 0], lines[k, 1] = position(one[i], times[k])
        lines[k, 2], lines[k, 3] = position(two[j], times[k])
    return lines
