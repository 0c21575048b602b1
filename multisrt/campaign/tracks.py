"""Where bodies were at any time of a run: recorded motions, evaluated without the simulation."""

from __future__ import annotations

import itertools
import math
from collections import defaultdict
from typing import Final

import numpy as np
from numpy.typing import NDArray

from multisrt.campaign.bodies import FloatArray
from multisrt.events import Motion
from multisrt.recording import Recording

IntArray = NDArray[np.int64]

STEP_RAD: Final = 1e-3
"""Maximum turn between two of the points that stand for an arc, by default."""

MIN_TURN_RAD: Final = 1e-8
"""Legs that turn less are straight: rounding would move their far centres by more than they bend.
"""


class Track:
    """The motion of a robot, from 0 to the end of a run.

    Between two waypoints of a motion the body turns about a fixed centre, or moves straight. A
    motion that does not begin where the last one ended is a jump here; none is refused.

    Parameters
    ----------
    start : (x, y, heading)
        Where it starts.
    motions : list of Motion
        Its motions.
    end_s : float
        The end of the run.

    Attributes
    ----------
    legs : (n, 8) array
        Time, x, y and heading where each leg begins, and where it ends; the robot stands on those
        between motions.
    turns, lengths : (n,) array
        The signed turn of each leg (rad), and the length of its path (m).

    Examples
    --------
    A quarter of a circle of 1 m to the left, in two seconds:

    >>> quarter = ((1.0, 0.0, 0.0, 0.0), (3.0, 1.0, 1.0, math.pi / 2))
    >>> track = Track((0.0, 0.0, 0.0), [Motion(time_s=1.0, robot=0, waypoints=quarter)], 9.0)
    >>> track.at(np.array([0.5, 2.0, 8.0])).round(3).tolist()
    [[0.0, 0.0, 0.0], [0.707, 0.293, 0.785], [1.0, 1.0, 1.571]]
    >>> track.lengths.round(3).tolist()
    [0.0, 1.571, 0.0]
    """

    def __init__(
        self, start: tuple[float, float, float], motions: list[Motion], end_s: float
    ) -> None:
        legs: list[tuple[float, ...]] = []
        time_s, pose = 0.0, start
        for motion in sorted(motions, key=lambda motion: motion.time_s):
            legs.append((time_s, *pose, motion.waypoints[0][0], *pose))
            legs += [(*a, *b) for a, b in itertools.pairwise(motion.waypoints)]
            time_s, *place = motion.waypoints[-1]
            pose = (place[0], place[1], place[2])
        legs.append((time_s, *pose, max(end_s, time_s), *pose))
        self.legs: FloatArray = np.array(legs)
        chord = self.legs[:, 5:7] - self.legs[:, 1:3]
        self.turns: FloatArray = self.legs[:, 7] - self.legs[:, 3]
        self._curved = np.abs(self.turns) > MIN_TURN_RAD
        half = np.where(self._curved, self.turns, math.pi) / 2.0
        to_left = np.column_stack([-chord[:, 1], chord[:, 0]])
        middle = (self.legs[:, 1:3] + self.legs[:, 5:7]) / 2.0
        self._centres = middle + to_left / (2.0 * np.tan(half))[:, None]
        still = (chord == 0.0).all(axis=1)
        self._centres[still] = self.legs[still, 1:3]
        straight = np.hypot(chord[:, 0], chord[:, 1])
        arms = self.legs[:, 1:3] - self._centres
        around = np.abs(self.turns) * np.hypot(arms[:, 0], arms[:, 1])
        self.lengths: FloatArray = np.where(self._curved, around, straight)

    def on(self, which: IntArray, shares: FloatArray) -> FloatArray:
        """Return the poses ``(n, 3)`` at shares, from 0 to 1, of some legs."""
        legs, turn = self.legs[which], self.turns[which]
        poses = legs[:, 1:4] + shares[:, None] * (legs[:, 5:8] - legs[:, 1:4])
        arm = legs[:, 1:3] - self._centres[which]
        cos, sin = np.cos(shares * turn), np.sin(shares * turn)
        turned = self._centres[which] + np.column_stack(
            [cos * arm[:, 0] - sin * arm[:, 1], sin * arm[:, 0] + cos * arm[:, 1]]
        )
        poses[:, :2] = np.where(self._curved[which][:, None], turned, poses[:, :2])
        return poses

    def at(self, times: FloatArray) -> FloatArray:
        """Return the poses ``(n, 3)`` at some times; headings are not wrapped."""
        which = self.leg_at(times)
        begin, end = self.legs[which, 0], self.legs[which, 4]
        lasting = np.where(end > begin, end - begin, 1.0)
        return self.on(which, np.clip((times - begin) / lasting, 0.0, 1.0))

    def pose(self, time_s: float) -> tuple[float, float, float]:
        """Return the pose at a time; the heading is not wrapped."""
        x, y, heading = self.at(np.array([time_s]))[0].tolist()
        return x, y, heading

    def leg_at(self, times: FloatArray) -> IntArray:
        """Return the last legs that have begun by some times."""
        which = np.searchsorted(self.legs[:, 0], times, side="right") - 1
        legs: IntArray = np.maximum(which, 0)
        return legs

    def rates(self, times: FloatArray, radius_m: float) -> FloatArray:
        """Return how fast the points within a radius move at some times at most (m/s)."""
        which = self.leg_at(times)
        lasting = self.legs[which, 4] - self.legs[which, 0]
        reach = self.lengths[which] + np.abs(self.turns[which]) * radius_m
        rates: FloatArray = np.zeros_like(reach)
        rates[lasting > 0.0] = reach[lasting > 0.0] / lasting[lasting > 0.0]
        return rates

    def along(self, leg: int, step_rad: float = STEP_RAD) -> FloatArray:
        """Return poses ``(n, 3)`` along a leg; a step turns by at most an angle."""
        steps = max(1, math.ceil(abs(self.turns[leg]) / step_rad))
        return self.on(np.full(steps + 1, leg), np.linspace(0.0, 1.0, steps + 1))


def tracks(recording: Recording) -> list[Track]:
    """Return the track of each robot."""
    motions: dict[int, list[Motion]] = defaultdict(list)
    for motion in recording.of(Motion):
        motions[motion.robot].append(motion)
    return [
        Track(start, motions[robot], recording.footer.time_s)
        for robot, start in enumerate(recording.header.starts)
    ]
