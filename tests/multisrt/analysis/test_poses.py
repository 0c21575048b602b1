"""Poses at given times, by hand and against integrating the twists."""

import gc
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from multisrt.analysis import poses as module
from multisrt.analysis.poses import poses
from multisrt.events import Joined
from multisrt.geometry.errors import InvalidInputError
from multisrt.planners.motion.trajectory import leg_pose
from multisrt.spec import LateStart

HALF = math.pi / 2.0


def test_a_straight_leg_a_turn_and_an_arc(recorded, moved):
    # 4 m ahead in 4 s, a turn to the left in 2 s, and a quarter circle of 1 m to the right in 3 s.
    way = moved(
        (2.0, 1.0, 1.0, 0.0),
        (6.0, 5.0, 1.0, 0.0),
        (8.0, 5.0, 1.0, HALF),
        (11.0, 6.0, 2.0, 0.0),
    )
    found = poses(recorded(way), [0.0, 2.0, 3.0, 6.0, 7.0, 8.0, 9.5, 11.0, 40.0])
    r = math.sqrt(0.5)
    assert found.dtype == np.float64
    assert found[0] == pytest.approx(
        np.array(
            [
                (1.0, 1.0, 0.0),
                (1.0, 1.0, 0.0),
                (2.0, 1.0, 0.0),
                (5.0, 1.0, 0.0),
                (5.0, 1.0, HALF / 2.0),
                (5.0, 1.0, HALF),
                (6.0 - r, 1.0 + r, HALF / 2.0),
                (6.0, 2.0, 0.0),
                (6.0, 2.0, 0.0),
            ]
        ),
        abs=1e-12,
    )


def test_driving_backwards_and_more_than_a_turn_in_place(recorded, moved):
    way = moved((0.0, 1.0, 1.0, 0.0), (2.0, 1.0, 1.0, 4.0 * math.pi), (4.0, 0.5, 1.0, 4 * math.pi))
    found = poses(recorded(way), [0.5, 3.0])[0]
    assert found == pytest.approx(np.array([(1.0, 1.0, math.pi), (0.75, 1.0, 4.0 * math.pi)]))


def test_bodies_are_always_somewhere(recorded, moved, died):
    # Robot 0 dies on its way, robot 1 is switched on at 20 s, robot 2 never.
    recording = recorded(
        moved((0.0, 1.0, 1.0, 0.0), (5.0, 6.0, 1.0, 0.0)),
        died(5.0, 0),
        Joined(time_s=20.0, robot=1),
        moved((21.0, 2.0, 3.0, 0.0), (22.0, 3.0, 3.0, 0.0), robot=1),
        starts=[(1.0, 1.0, 0.0), (2.0, 3.0, 0.0), (7.0, 7.0, 1.0)],
        faults=(LateStart(robot=1, time_s=20.0), LateStart(robot=2, time_s=90.0)),
    )
    found = poses(recording, [-1.0, 10.0, 21.5, 60.0])
    assert found[0].tolist() == [[1, 1, 0], [6, 1, 0], [6, 1, 0], [6, 1, 0]]
    assert found[1].tolist() == [[2, 3, 0], [2, 3, 0], [2.5, 3, 0], [3, 3, 0]]
    assert found[2].tolist() == [[7, 7, 1]] * 4


def test_times_are_a_row_of_finite_numbers(recorded):
    recording = recorded()
    assert poses(recording, []).shape == (1, 0, 3)
    for times in (1.0, [[1.0]], [math.nan], [math.inf]):
        with pytest.raises(InvalidInputError, match="a row of finite numbers of seconds"):
            poses(recording, times)


angle = st.floats(-3.1, 3.1)
leg = st.tuples(
    st.floats(0.1, 5.0), st.floats(-3.0, 3.0), st.floats(-3.0, 3.0), angle, st.floats(0.0, 1.0)
)


@settings(max_examples=60, deadline=None)
@given(start=angle, legs=st.lists(leg, min_size=1, max_size=4))
def test_poses_follow_the_integral_of_constant_twists(recorded, moved, start, legs):
    way = [(0.0, 1.0, 1.0, start)]
    for duration, dx, dy, turn, _ in legs:
        t, x, y, heading = way[-1]
        way.append((t + duration, x + dx, y + dy, heading + turn))
    shares = [share for *_, share in legs]
    times = [
        a[0] + share * (b[0] - a[0]) for a, b, share in zip(way, way[1:], shares, strict=False)
    ]
    found = poses(recorded(moved(*way)), times)[0]
    for a, b, share, at in zip(way, way[1:], shares, found, strict=False):
        assert at == pytest.approx(integrated(a, b, share), abs=2e-6)
        # The robots' own rule says the same.
        assert at == pytest.approx(leg_pose(a, b, share), abs=1e-7)


def integrated(a, b, share, steps=2000):
    """Integrate a constant twist in the frame of the body that leads from a to b, by midpoints."""
    duration, turn = b[0] - a[0], b[3] - a[3]
    middles = a[3] + turn * (np.arange(steps) + 0.5) / steps
    # The body's velocity is the one that ends in b.
    rotations = np.exp(1j * middles)
    velocity = complex(b[1] - a[1], b[2] - a[2]) / (rotations.mean() * duration)
    part = a[3] + turn * share * (np.arange(steps) + 0.5) / steps
    moved = velocity * np.exp(1j * part).mean() * share * duration
    return a[1] + moved.real, a[2] + moved.imag, a[3] + share * turn


def test_tracks_are_computed_once_and_live_with_the_recording(recorded):
    gc.collect()
    before = len(module._TRACKS)
    recording = recorded(starts=[(1.0, 1.0, 0.0), (3.0, 1.0, 0.0)])
    assert module.tracks(recording) is module.tracks(recording)
    assert len(module._TRACKS) == before + 1
    del recording
    gc.collect()
    assert len(module._TRACKS) == before
