"""The motion of a robot along its route, with the scans that it takes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import groupby

import numpy as np

from multisrt.geometry.configuration import Configuration, wrap_angle
from multisrt.geometry.numerics.kernel import FloatArray
from multisrt.informed.explorer import Stage
from multisrt.informed.team import samples
from multisrt.informed.timetable import Timing
from multisrt.planners.motion.kinematics import Differential, Holonomic
from multisrt.planners.motion.trajectory import Trajectory, standing_at

MIN_LEG_M = 1e-9
"""Shorter legs are rounding."""

MIN_PIECE_S = 1e-9
"""Shorter pieces of time are rounding."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Drive:
    """A motion along a route.

    Attributes
    ----------
    motion : Trajectory
        The motion without any wait.
    scans_s : tuple of float
        When scans are taken in it, ascending.
    """

    motion: Trajectory
    scans_s: tuple[float, ...]


def drive_along(
    start: Configuration,
    kinematics: Holonomic | Differential | None,
    legs: Sequence[FloatArray],
) -> Drive:
    """Return the motion along some paths that follow one another.

    Parameters
    ----------
    start : Configuration
        Where it begins.
    kinematics : Holonomic or Differential or None
        How the body moves. A differential drive goes backwards rather than turn by more than a
        right angle. None: it does not move.
    legs : sequence of (k, 2) array
        Corners of each path in metres.

    Examples
    --------
    >>> path = np.array([[0.0, 0.0], [0.0, 1.0]])
    >>> drive = drive_along(Configuration(0.0, 0.0, 0.0), Differential(speed_m_s=1.0), [path])
    >>> [round(time, 3) for time in drive.scans_s]
    [1.333, 1.667, 2.0]
    """
    motion, scans = standing_at(start), []
    pieces = [tuple(motion.waypoints[0])]
    at = start
    for leg in legs:
        for x, y in samples(leg).tolist():
            if kinematics is None or math.hypot(x - at.x, y - at.y) < MIN_LEG_M:
                continue
            step = _straight(kinematics, at, x, y)
            clock, turned = pieces[-1][0], pieces[-1][3] - step.waypoints[0].heading
            pieces += [(clock + w.time_s, w.x, w.y, turned + w.heading) for w in step.waypoints[1:]]
            at = step.end
            scans.append(pieces[-1][0])
    return Drive(
        motion=Trajectory(tuple(type(motion.waypoints[0])(*piece) for piece in pieces)),
        scans_s=tuple(scans),
    )


def stages_of(drive: Drive, timing: Timing) -> list[Stage]:
    """Return a motion as stages that begin on time, cut where scans are taken."""
    progress, step_s = timing.progress, timing.step_s
    ahead = drive.motion
    whole = ahead.then(ahead.reversed())
    end_s, steps_to_end = ahead.duration_s, math.ceil(ahead.duration_s / step_s - 1e-9)

    def time_at(k: int) -> float:
        # The last step of the path there is shorter, and so is the first of the path back.
        if k <= steps_to_end:
            return min(k * step_s, end_s)
        return 2.0 * end_s - max(0.0, (2 * steps_to_end - k) * step_s)

    found: list[Stage] = []
    seen_s = 0.0
    step = 0
    for move, group in groupby(np.diff(progress).tolist()):
        first, step = step, step + len(list(group))
        if move == 0:
            continue
        a, b = time_at(int(progress[first])), time_at(int(progress[step]))
        begin_s = first * step_s
        if move < 0:
            piece = whole.until(a).after(b).reversed()
            found.append(Stage(begin_s=begin_s, motion=piece, scans=False))
            continue
        cuts = [s for s in drive.scans_s if max(a, seen_s) < s <= b + MIN_PIECE_S]
        for cut in (*cuts, b):
            if cut - a > MIN_PIECE_S:
                piece = whole.until(cut).after(a)
                found.append(Stage(begin_s=begin_s, motion=piece, scans=cut in cuts))
                begin_s += cut - a
                a = cut
        seen_s = max(seen_s, min(b, end_s))
    return found


def _straight(
    kinematics: Holonomic | Differential, at: Configuration, x: float, y: float
) -> Trajectory:
    if isinstance(kinematics, Holonomic):
        return kinematics.drive(at, x, y)
    turn = wrap_angle(math.atan2(y - at.y, x - at.x) - at.heading)
    if abs(turn) > 0.5 * math.pi:
        turn -= math.copysign(math.pi, turn)
    # Along a straight path the heading stays.
    turned = kinematics.turn(at, turn if abs(turn) > 1e-9 else 0.0)
    return turned.then(kinematics.drive(turned.end, x, y))
