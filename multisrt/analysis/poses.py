"""Where robots were at any time, exactly.

Between two waypoints a body moves with a constant twist. Over a share `s` of such a leg, with
turn `a` and chord `C`, its reference point has moved by the chord turned by `(s - 1) a / 2` and
shortened by `sin(s a / 2) / sin(a / 2)`.
"""

from __future__ import annotations

import itertools
import math
from collections import defaultdict
from typing import NamedTuple
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import ArrayLike

from multisrt.events import Motion, Purpose
from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.numerics import libm
from multisrt.geometry.numerics.kernel import FloatArray, IntArray
from multisrt.recording import Recording


def poses(recording: Recording, times_s: ArrayLike) -> FloatArray:
    """Return where the robots of a run were at some times.

    Parameters
    ----------
    recording : Recording
        The run.
    times_s : (n,) array_like
        Seconds since the start of the run, in any order. Before 0 robots are at their starts,
        after the end of the run where they were last.

    Returns
    -------
    (robots, n, 3) array of float64
        x and y in metres and the heading in radians, in the frame of the environment. Headings
        are not wrapped; they continue those of the waypoints, so that the difference of two
        headings within a motion is the turn. A robot that starts late, or never, has its body at
        its start until it moves, and one that died has it where it died: bodies are always
        somewhere.

    Raises
    ------
    InvalidInputError
        If times are not a row of finite numbers.

    Examples
    --------
    >>> import multisrt as ms
    >>> run = ms.explore("open", start=(2.0, 4.0), seed=1, max_time_s=10.0)
    >>> at = poses(run.recording, [0.0, 5.0])
    >>> at.shape, at[0, 0, :2].tolist()
    ((1, 2, 3), [2.0, 4.0])
    """
    times = np.asarray(times_s, np.float64)
    if times.ndim != 1 or not np.isfinite(times).all():
        raise InvalidInputError("times are a row of finite numbers of seconds")
    return np.array([poses_on(legs_at(track.legs, times), times) for track in tracks(recording)])


class Track(NamedTuple):
    """The motion of a robot from 0 to the end of the run.

    Attributes
    ----------
    legs : (n, 8) array
        Time, x, y, heading at the start and at the end of each leg; legs follow one another
        without gaps.
    stands : (k + 1,) array of int
        Indices of the legs on which it stands: one before each of its k motions, and the last.
    purposes : tuple of str
        The purposes of its k motions.
    """

    legs: FloatArray
    stands: IntArray
    purposes: tuple[Purpose, ...]

    @property
    def driven(self) -> FloatArray:
        """The legs of its motions."""
        return np.delete(self.legs, self.stands, axis=0)

    def moving_spans(self, purpose: Purpose | None = None) -> FloatArray:
        """Return begin and end of each leg on which the body moved or turned, ``(m, 2)``.

        Parameters
        ----------
        purpose : str, optional
            Leave out legs of motions for any other purpose.

        Returns
        -------
        (m, 2) array of float64
            Times in seconds, in order.
        """
        legs = self.legs
        moving = (legs[:, 1:4] != legs[:, 5:]).any(axis=1)
        if purpose is not None:
            for (before, after), own in zip(
                itertools.pairwise(self.stands.tolist()), self.purposes, strict=True
            ):
                moving[before + 1 : after] &= own == purpose
        spans: FloatArray = legs[moving][:, [0, 4]]
        return spans

    def length_m(self) -> float:
        """Return the path length of the reference point, along arcs, in metres."""
        lengths = leg_lengths(self.legs)
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
    return Track(legs, stands, tuple(motion.purpose for motion in motions))


# Legs: rows of time, x, y, heading at the start and at the end.


def legs_at(track: FloatArray, times: FloatArray) -> FloatArray:
    """Return the last leg of a track that has started by each of some times."""
    which = np.searchsorted(track[:, 0], times, side="right") - 1
    legs: FloatArray = track[np.clip(which, 0, len(track) - 1)]
    return legs


def poses_on(legs: FloatArray, times: FloatArray) -> FloatArray:
    """Return the pose on each leg at a time of its own, ``(n, 3)``; at the nearer end outside."""
    return _poses(legs, np.clip((times - legs[:, 0]) / durations(legs), 0.0, 1.0))


def durations(legs: FloatArray) -> FloatArray:
    """Return the durations of legs, 1 s for those that take no time."""
    duration = legs[:, 4] - legs[:, 0]
    return np.where(duration > 0.0, duration, 1.0)


def leg_lengths(legs: FloatArray) -> FloatArray:
    """Return the path lengths of legs, along arcs, in metres."""
    chords = np.hypot(legs[:, 5] - legs[:, 1], legs[:, 6] - legs[:, 2])
    return np.where(chords > 0.0, chords / _chord_share(legs[:, 7] - legs[:, 3]), 0.0)


def _poses(legs: FloatArray, share: FloatArray) -> FloatArray:
    # The poses at a share, from 0 to 1, of each leg; (n, 3).
    chord_x, chord_y = legs[:, 5] - legs[:, 1], legs[:, 6] - legs[:, 2]
    turn = legs[:, 7] - legs[:, 3]
    length = share * libm.sinc(share * turn / 2.0) / _chord_share(turn)
    angle = (share - 1.0) * turn / 2.0
    cos, sin = length * libm.cos(angle), length * libm.sin(angle)
    return np.column_stack(
        [
            legs[:, 1] + cos * chord_x - sin * chord_y,
            legs[:, 2] + sin * chord_x + cos * chord_y,
            legs[:, 3] + share * turn,
        ]
    )


def _chord_share(turn: FloatArray) -> FloatArray:
    # The ratio of the length of a chord to that of its arc.
    share: FloatArray = libm.sinc(turn / 2.0)
    return np.where(share == 0.0, 1.0, share)  # a full turn in place, which has no chord
