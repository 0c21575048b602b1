"""Timing of routes: bodies keep their distance, and nobody waits without need."""

import math

import numpy as np
import pytest

from multisrt.geometry.configuration import Configuration
from multisrt.informed.driving import drive_along, stages_of
from multisrt.informed.timetable import GAP_M, Course, NoTiming, timed
from multisrt.planners.motion.kinematics import Holonomic


def drive(*corners):
    path = np.array(corners, np.float64)
    x, y = corners[0]
    return drive_along(Configuration(x, y, 0.0), Holonomic(speed_m_s=0.5), [path])


def course(drive, radius_m=0.25):
    return Course(motion=drive.motion, radius_m=radius_m, speed_m_s=0.5)


def tracks(drives, timings, step_s=0.01):
    """Where each robot is at equal steps of time, from its stages."""
    stages = [stages_of(d, t) for d, t in zip(drives, timings, strict=True)]
    end_s = max(s.begin_s + s.motion.duration_s for own in stages for s in own)
    found = []
    for one, own in zip(drives, stages, strict=True):
        at, track = one.motion.start, []
        for time_s in np.arange(0.0, end_s + step_s, step_s).tolist():
            for stage in own:
                if stage.begin_s <= time_s:
                    at = stage.motion.at(time_s - stage.begin_s)
            track.append((at.x, at.y))
        found.append(np.array(track))
    return found, stages


def least_distance(tracks):
    return min(
        float(np.hypot(*(a - b).T).min()) for k, a in enumerate(tracks) for b in tracks[k + 1 :]
    )


def test_who_meets_nobody_does_not_wait():
    drives = [drive((0, 0), (10, 0)), drive((0, 5), (6, 5))]
    _, stages = tracks(drives, timed([course(d) for d in drives]))
    for own, one in zip(stages, drives, strict=True):
        assert own[-1].begin_s + own[-1].motion.duration_s == pytest.approx(one.motion.duration_s)


def test_paths_that_cross_are_driven_one_after_the_other():
    drives = [drive((0, 0), (10, 0)), drive((5, -5), (5, 4))]
    found, stages = tracks(drives, timed([course(d) for d in drives]))
    assert least_distance(found) >= 0.5 + GAP_M
    # The longer way is driven without a wait.
    assert stages[0][-1].begin_s + stages[0][-1].motion.duration_s == pytest.approx(20.0)


def test_a_robot_backs_to_let_another_pass():
    # A robot that has driven into a bay of the other's way backs out of it, or waits before.
    drives = [drive((0, 0), (10, 0)), drive((4, 0), (4, 3), (4, 0), (8, 0))]
    found, _ = tracks(drives, timed([course(d) for d in drives]))
    assert least_distance(found) >= 0.5 + GAP_M


def test_who_is_done_goes_back_to_make_room():
    # The shorter route ends on the longer one, behind its own start.
    drives = [drive((0, 0), (12, 0)), drive((6, 3), (6, 0))]
    timings = timed([course(d) for d in drives])
    found, stages = tracks(drives, timings)
    assert least_distance(found) >= 0.5 + GAP_M
    last = stages[1][-1].motion.end
    assert math.hypot(last.x - 6, last.y) < 1e-6 or last.y > 0.5


def test_head_on_there_is_no_timing():
    drives = [drive((0, 0), (10, 0)), drive((10, 0), (0, 0))]
    with pytest.raises(NoTiming):
        timed([course(d) for d in drives])


def test_every_scan_of_a_route_is_taken_once():
    drives = [drive((0, 0), (10, 0)), drive((5, -5), (5, 4)), drive((2, 3), (2, -3))]
    _, stages = tracks(drives, timed([course(d) for d in drives]))
    for own, one in zip(stages, drives, strict=True):
        assert sum(stage.scans for stage in own) == len(one.scans_s)
