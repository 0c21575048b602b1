"""Paths of robots are drawn where the robots were, with few points."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from multisrt.analysis.poses import poses
from multisrt.drawing.animation.keyframes import TURN_TOLERANCE_RAD, needed, ways_of
from multisrt.events import Motion

values = st.lists(st.tuples(st.floats(-9.0, 9.0), st.floats(-9.0, 9.0)), min_size=2, max_size=40)


def test_only_corners_are_needed(told):
    way, turning, standing = ways_of(told, 0.01)
    assert way.times_s.tolist() == [0.0, 10.0, 20.0, 40.0]
    assert way.places.tolist() == [[3, 3], [3, 3], [13, 3], [13, 3]]
    assert way.lengths_m.tolist() == [0.0, 0.0, 10.0, 10.0]
    assert turning.turn_times_s.tolist() == [0.0, 20.0, 30.0, 40.0]
    assert turning.headings.tolist() == [0.0, 0.0, 3.0, 3.0]
    assert standing.times_s.tolist() == [0.0, 40.0]


def test_places_between_are_interpolated(told):
    way = ways_of(told, 0.01)[0]
    assert way.at(15.0) == (8.0, 3.0, 0.0)
    assert way.path(15.0, 30.0) == [(8.0, 3.0), (13.0, 3.0), (13.0, 3.0)]


def test_robots_are_drawn_where_they_were_at_the_time(trees, bidding):
    for recording in (trees, bidding):
        times = np.linspace(0.0, recording.footer.time_s, 1234)
        for way, true in zip(ways_of(recording, 0.05), poses(recording, times), strict=True):
            drawn = np.array([way.at(time) for time in times])
            # Arcs are sampled, which adds a little.
            assert np.hypot(*(drawn - true)[:, :2].T).max() < 0.06
            off = np.exp(1j * (drawn - true)[:, 2])
            assert np.abs(np.angle(off)).max() < 1.1 * TURN_TOLERANCE_RAD


def test_no_robot_spins_between_two_motions(bidding):
    starts = [motion.waypoints[0] for motion in bidding.of(Motion)]
    ends = [motion.waypoints[-1] for motion in bidding.of(Motion)]
    assert max(abs(a[3] - b[3]) for a in starts for b in ends) > 3.2
    for way in ways_of(bidding, 0.05):
        rates = np.diff(way.headings) / np.diff(way.turn_times_s)
        assert np.abs(rates).max() < 4.0  # full turns in no time would be faster


@settings(max_examples=30)
@given(values, st.floats(0.01, 5.0))
def test_no_sample_is_farther_off_than_the_tolerance(points, tolerance):
    times = np.arange(len(points), dtype=float)
    samples = np.array(points)
    kept = needed(times, samples, tolerance)
    assert kept[0] == 0
    assert kept[-1] == len(points) - 1
    drawn = np.column_stack([np.interp(times, times[kept], own) for own in samples[kept].T])
    assert np.hypot(*(drawn - samples).T).max() <= tolerance + 1e-9
