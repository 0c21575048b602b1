"""The ways of robots through space and time, with no more points than are visible."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np

from multisrt.analysis.poses import Track, poses, tracks
from multisrt.geometry.numerics.kernel import FloatArray, IntArray
from multisrt.planners.motion.trajectory import CHORD_RAD
from multisrt.recording import Recording

TURN_TOLERANCE_RAD: Final = math.radians(2.0)
"""Bound of the difference between a drawn heading and the true one, in radians."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Way:
    """Where a robot is drawn at what time; linear in between.

    Attributes
    ----------
    times_s : (n,) array
        Times of the run in seconds, from 0 to the end.
    places : (n, 2) array
        Its positions in metres.
    lengths_m : (n,) array
        Lengths of the way up to there.
    turn_times_s, headings : (m,) array
        Times and headings in radians, not wrapped.
    """

    times_s: FloatArray
    places: FloatArray
    lengths_m: FloatArray
    turn_times_s: FloatArray
    headings: FloatArray

    def at(self, time_s: float) -> tuple[float, float, float]:
        """Return x, y and heading at a time."""
        x, y = (np.interp(time_s, self.times_s, own) for own in self.places.T)
        heading = np.interp(time_s, self.turn_times_s, self.headings)
        return float(x), float(y), float(heading)

    def path(self, begin_s: float, end_s: float) -> list[tuple[float, float]]:
        """Return the points of the way between two times."""
        inside = (self.times_s > begin_s) & (self.times_s < end_s)
        return [
            self.at(begin_s)[:2],
            *((float(x), float(y)) for x, y in self.places[inside]),
            self.at(end_s)[:2],
        ]


def ways_of(recording: Recording, tolerance_m: float) -> list[Way]:
    """Return the ways of all robots.

    Parameters
    ----------
    recording : Recording
        The run.
    tolerance_m : float
        Bound in metres of the distance between where a robot is drawn and where it was at the
        same time.

    Returns
    -------
    list of Way
        One for each robot.
    """
    end_s = recording.footer.time_s
    return [
        _way(*_sampled(recording, robot, track, end_s), tolerance_m)
        for robot, track in enumerate(tracks(recording))
    ]


def _sampled(
    recording: Recording, robot: int, track: Track, end_s: float
) -> tuple[FloatArray, FloatArray]:
    # Times and poses at the ends of all legs, and along arcs.
    times = [np.array([0.0, end_s]), track.legs[:, 0], track.legs[:, 4]]
    for leg in track.legs[track.legs[:, 3] != track.legs[:, 7]]:
        chords = math.ceil(abs(leg[7] - leg[3]) / CHORD_RAD)
        times.append(np.linspace(leg[0], leg[4], chords + 1))
    at = np.unique(np.clip(np.concatenate(times), 0.0, end_s))
    found = poses(recording, at)[robot]
    # Motions may begin a full turn off the heading in which the one before ended.
    found[:, 2] = np.unwrap(found[:, 2])
    return at, found


def _way(times: FloatArray, at: FloatArray, tolerance_m: float) -> Way:
    kept = needed(times, at[:, :2], tolerance_m)
    turns = needed(times, at[:, 2:], TURN_TOLERANCE_RAD)
    places = at[kept, :2]
    steps = np.hypot(*np.diff(places, axis=0).T)
    return Way(
        times_s=times[kept],
        places=places,
        lengths_m=np.concatenate([[0.0], np.cumsum(steps)]),
        turn_times_s=times[turns],
        headings=at[turns, 2],
    )


def needed(times: FloatArray, values: FloatArray, tolerance: float) -> IntArray:
    """Return which samples are needed to interpolate all of them.

    Parameters
    ----------
    times : (n,) array
        When they were taken, in order.
    values : (n, k) array
        The samples.
    tolerance : float
        Bound of the distance between a sample and what is interpolated at its time.

    Returns
    -------
    (m,) array of int
        Indices in order, with the first and the last one.

    Notes
    -----
    The method is that of Ramer, Douglas and Peucker with distances at equal times.

    Examples
    --------
    >>> times = np.arange(5.0)
    >>> needed(times, np.array([[0.0], [1.0], [2.0], [2.0], [2.0]]), 0.1).tolist()
    [0, 2, 4]
    """
    kept = np.zeros(len(times), np.bool_)
    kept[[0, -1]] = True
    spans = [(0, len(times) - 1)]
    while spans:
        first, last = spans.pop()
        if last - first < 2:
            continue
        share = (times[first + 1 : last] - times[first]) / (times[last] - times[first])
        between = values[first] + share[:, None] * (values[last] - values[first])
        off = np.linalg.norm(values[first + 1 : last] - between, axis=1)
        worst = int(np.argmax(off))
        if off[worst] > tolerance:
            middle = first + 1 + worst
            kept[middle] = True
            spans += [(first, middle), (middle, last)]
    return np.flatnonzero(kept)
