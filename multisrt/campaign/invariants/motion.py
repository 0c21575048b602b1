"""Motions respect the drive, begin where the body is, and occur only while a robot is active."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from typing import Any, Final

import numpy as np

from multisrt.campaign.bodies import FloatArray
from multisrt.campaign.judged_run import JudgedRun
from multisrt.campaign.violations import Violation
from multisrt.events import (
    BaseLearned,
    Blocked,
    Died,
    Event,
    Joined,
    Motion,
    Sensed,
    Sent,
)
from multisrt.spec import DriveSpec

WITHIN_DRIVE: Final = "motion-within-drive"
CONTINUOUS: Final = "motion-continuous"
FULL_SPEED: Final = "motion-at-full-speed"

ROUNDING_M: Final = 1e-6
"""Maximum excess length of a leg, and distance between two motions, in metres."""

SIDEWAYS_M: Final = 1e-5
"""By how much a leg may lead to the side, in metres: curves of cars are found to within this."""

ROUNDING_RAD: Final = 1e-6
"""Maximum excess turn of a leg, in radians."""

ROUNDING_S: Final = 1e-6
"""Maximum overlap of times, in seconds."""

PLACE_M: Final = 1e-5
"""Maximum distance of a recorded scan or stop from the position of the robot, in metres."""


def motion_within_drive(run: JudgedRun) -> Violation | None:
    """Check that every leg of a motion is within the limits of the robot's drive.

    No body is faster than its speed, and no differential drive turns faster than its turn rate.
    Differential drives and cars move along their heading, not sideways; holonomic bodies keep their
    heading; cars turn with at least their turning radius, and Dubins cars never drive backwards.
    For rounding, a leg may be 1e-6 m longer, turn by 1e-6 rad more and end 1e-5 m to the side.

    Cost: negligible.
    """
    found = [
        violation
        for motion in run.recording.of(Motion)
        for violation in _beyond_drive(motion, run.recording.spec.robots[motion.robot].drive)
    ]
    return min(found, key=lambda violation: violation.time_s or 0.0, default=None)


def _beyond_drive(motion: Motion, drive: DriveSpec) -> Iterator[Violation]:
    a, along, lengths = _legs(motion)
    for k, what in _limits(drive, lengths, along, a[:, 3]):
        yield Violation(
            invariant=WITHIN_DRIVE,
            says=f"robot {motion.robot} ({drive.kind}) {what} at {a[k, 0]:.2f} s, "
            f"at ({a[k, 1]:.3f}, {a[k, 2]:.3f})",
            robot=motion.robot,
            time_s=float(a[k, 0]),
        )


def _legs(motion: Motion) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the beginnings of the legs, the steps to their ends, and their lengths in metres."""
    points = np.array(motion.waypoints)
    steps = np.diff(points, axis=0)
    chords, half = np.hypot(*steps[:, 1:3].T), 0.5 * np.abs(steps[:, 3])
    curved = half > 1e-9
    lengths = np.where(curved, chords * half / np.sin(np.where(curved, half, 1.0)), chords)
    return points[:-1], steps, lengths


def _limits(
    drive: DriveSpec, lengths: FloatArray, along: FloatArray, headings: FloatArray
) -> Iterator[tuple[int, str]]:
    """Yield the first leg that exceeds each limit, with a description."""
    lasting, turns = along[:, 0], along[:, 3]
    for k in np.flatnonzero(lengths > drive.speed_m_s * lasting + ROUNDING_M)[:1].tolist():
        yield k, f"drives {lengths[k]:.4f} m in {lasting[k]:.4f} s, beyond {drive.speed_m_s:g} m/s"
    if drive.kind == "holonomic":
        for k in np.flatnonzero(np.abs(turns) > ROUNDING_RAD)[:1].tolist():
            yield k, f"turns by {turns[k]:.4f} rad"
        return
    # A body that follows its heading on an arc moves, on the chord, along the mean heading.
    mean = headings + 0.5 * turns
    forwards = along[:, 1] * np.cos(mean) + along[:, 2] * np.sin(mean)
    sideways = np.abs(along[:, 2] * np.cos(mean) - along[:, 1] * np.sin(mean))
    for k in np.flatnonzero(sideways > SIDEWAYS_M)[:1].tolist():
        yield k, f"moves {sideways[k]:.6f} m to the side"
    if drive.kind == "differential":
        rate = drive.turn_rate_rad_s
        for k in np.flatnonzero(np.abs(turns) > rate * lasting + ROUNDING_RAD)[:1].tolist():
            yield k, f"turns by {turns[k]:.4f} rad in {lasting[k]:.4f} s, beyond {rate:.4g} rad/s"
        return
    radius_m = drive.turning_radius_m
    tight = np.abs(turns) * radius_m > lengths * (1.0 + ROUNDING_RAD) + ROUNDING_M
    for k in np.flatnonzero(tight)[:1].tolist():
        yield k, f"turns by {turns[k]:.4f} rad on {lengths[k]:.4f} m, tighter than {radius_m:g} m"
    if drive.kind == "dubins":
        for k in np.flatnonzero(forwards < -ROUNDING_M)[:1].tolist():
            yield k, f"drives {-forwards[k]:.4f} m backwards"


def motion_at_full_speed(run: JudgedRun) -> Violation | None:
    """Check that robots drive and turn as fast as their drive allows.

    No leg of a motion takes longer, by more than 1e-6 s, the time for 1e-6 m, and 1e-6 of its
    duration, than its length takes at full speed or, for a differential drive, its turn at the full
    rate. Robots that steer by the nearness diagram slow down near obstacles, and are not checked.

    Cost: negligible.
    """
    if run.family == "other" or run.options.get("drive") == "nearness-diagram":
        return None
    for motion in sorted(run.recording.of(Motion), key=lambda motion: motion.time_s):
        drive = run.recording.spec.robots[motion.robot].drive
        begins, steps, lengths = _legs(motion)
        needed = lengths / drive.speed_m_s
        if drive.kind == "differential":
            needed = np.maximum(needed, np.abs(steps[:, 3]) / drive.turn_rate_rad_s)
        rounding_s = ROUNDING_S + ROUNDING_M / drive.speed_m_s
        slow = steps[:, 0] > needed * (1.0 + ROUNDING_S) + rounding_s
        for k in np.flatnonzero(slow)[:1].tolist():
            return Violation(
                invariant=FULL_SPEED,
                says=f"robot {motion.robot} ({drive.kind}) takes {steps[k, 0]:.4f} s for a leg, at "
                f"{begins[k, 0]:.2f} s, for which {needed[k]:.4f} s are enough",
                robot=motion.robot,
                time_s=float(begins[k, 0]),
            )
    return None


def motion_continuous(run: JudgedRun) -> Violation | None:
    """Check that poses never jump, and robots act only between their start and their death.

    A motion begins at the place where the previous one ended, and not before its end; the times of
    its waypoints lie between its beginning and the end of the run. Robots scan, stop and die at the
    place given by their motions, to 1e-5 m. Before a late start and after its death a robot does
    nothing.

    Cost: negligible.
    """
    found = [*_jumps(run), *_out_of_place(run), *_out_of_time(run)]
    return min(found, key=lambda violation: violation.time_s or 0.0, default=None)


def _jumps(run: JudgedRun) -> Iterator[Violation]:
    motions = run.by_robot(Motion)
    for robot, start in enumerate(run.recording.header.starts):
        time_s, pose = 0.0, start
        for motion in sorted(motions[robot], key=lambda motion: motion.time_s):
            begin_s, *place = motion.waypoints[0]
            jump_m, turn = math.dist(pose[:2], place[:2]), _turn(pose[2], place[2])
            if jump_m > ROUNDING_M or turn > ROUNDING_RAD:
                yield _violation(
                    robot, begin_s, f"jumps by {jump_m:.6f} m and {turn:.6f} rad before it moves"
                )
            if begin_s < time_s - ROUNDING_S or abs(begin_s - motion.time_s) > ROUNDING_S:
                yield _violation(
                    robot, begin_s, f"begins a motion before the last one ends, at {time_s:.2f} s"
                )
            times = [waypoint[0] for waypoint in motion.waypoints]
            if any(later < earlier for earlier, later in itertools.pairwise(times)):
                yield _violation(robot, begin_s, "moves back in time")
            time_s, x, y, heading = motion.waypoints[-1]
            pose = (x, y, heading)
        if time_s > run.end_s + ROUNDING_S:
            yield _violation(robot, time_s, f"moves after the run has ended, at {run.end_s:.2f} s")


def _out_of_place(run: JudgedRun) -> Iterator[Violation]:
    placed: dict[int, list[Any]] = run.by_robot(Sensed, Died, Blocked)
    for robot, events in placed.items():
        poses = run.tracks[robot].at(np.array([event.time_s for event in events]))
        for event, pose in zip(events, poses.tolist(), strict=True):
            away_m = math.dist(pose[:2], event.configuration[:2])
            turn = _turn(pose[2], event.configuration[2])
            if away_m > PLACE_M or turn > PLACE_M:
                yield _violation(
                    robot,
                    event.time_s,
                    f"is {away_m:.6f} m and {turn:.6f} rad from where its {_name(event)} event is",
                )


def _out_of_time(run: JudgedRun) -> Iterator[Violation]:
    bounds = [run.present_s(robot) for robot in run.robots]
    for event in run.recording.events:
        if event.robot >= len(bounds) or isinstance(event, BaseLearned):
            continue  # what the base station does, perhaps with a message of one that has died
        begin_s, end_s = bounds[event.robot]
        last_s = event.waypoints[-1][0] if isinstance(event, Motion) else event.time_s
        is_on = event.time_s >= begin_s - ROUNDING_S
        if not is_on and not isinstance(event, Joined | Died):
            what = f"has a {_name(event)} event before it is switched on, at {begin_s:.2f} s"
            yield _violation(event.robot, event.time_s, what)
        if last_s > end_s + ROUNDING_S or (isinstance(event, Sent) and event.time_s > end_s):
            what = f"has a {_name(event)} event after its death at {end_s:.2f} s"
            yield _violation(event.robot, last_s, what)


def _violation(robot: int, time_s: float, what: str) -> Violation:
    return Violation(
        invariant=CONTINUOUS,
        says=f"robot {robot} {what}, {time_s:.2f} s",
        robot=robot,
        time_s=time_s,
    )


def _name(event: Event) -> str:
    return str(event.__struct_config__.tag)


def _turn(one: float, other: float) -> float:
    return abs(math.remainder(one - other, 2.0 * math.pi))
