"""Poses of robots along their motions, at waypoints and between them."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np

from multisrt.analysis.poses import poses_on
from multisrt.events import Motion
from multisrt.geometry.numerics.arrays import FloatArray
from multisrt.planners.motion.trajectory import CHORD_RAD


def nanoseconds(time_s: float) -> int:
    """Return a time in whole nanoseconds, at least 0."""
    return max(0, round(time_s * 1e9))


def inner_times(begin_s: float, end_s: float, step_s: float) -> FloatArray:
    """Return the multiples of a step that lie between two times.

    Examples
    --------
    >>> inner_times(1.0, 3.0, 0.5).tolist()
    [1.5, 2.0, 2.5]
    """
    first = math.floor(begin_s / step_s) + 1
    times = np.arange(first, max(first, math.ceil(end_s / step_s)), dtype=np.float64) * step_s
    return times[(times > begin_s) & (times < end_s)]


def course_of(motion: Motion) -> FloatArray:
    """Return the waypoints of a motion, and points on arcs between them.

    Parameters
    ----------
    motion : Motion
        The motion.

    Returns
    -------
    (n, 4) array
        Time in seconds, x, y in metres, heading in radians.
    """
    rows = [np.array(motion.waypoints[:1])]
    for a, b in pairwise(motion.waypoints):
        chords = 1
        if (a[1], a[2]) != (b[1], b[2]):
            chords = max(1, math.ceil(abs(b[3] - a[3]) / CHORD_RAD))
        times = a[0] + (b[0] - a[0]) * np.arange(1, chords + 1) / chords
        leg = np.broadcast_to(np.array([*a, *b]), (chords, 8))
        rows.append(np.column_stack([times, poses_on(leg, times)]))
        rows[-1][-1] = b
    return np.concatenate(rows)
