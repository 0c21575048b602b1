"""The rule of the protective stop, and the distance that planned ways keep."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from multisrt.geometry.bodies.footprint import Footprint
from multisrt.planners.motion.sweep import Sweep
from multisrt.planners.motion.trajectory import Trajectory, Waypoint
from multisrt.robots.protective_stop import (
    LEAVING_SHARE,
    MIN_SHARE,
    conflict,
    max_gap,
    planned_gap,
    stop_within,
)

GUARD_M = 0.1

distances = st.floats(1e-9, 5.0)
guards = st.floats(0.01, 1.0)


@pytest.mark.parametrize(
    ("now", "stop"),
    [(0.1, 0.05), (0.06, 0.03), (0.04, 0.025), (0.025, 0.999 * 0.025), (0.01, 0.00999), (0.0, 0.0)],
)
def test_bodies_within_the_guard_stop_at_half_but_not_a_quarter(now, stop):
    assert stop_within(now, GUARD_M) == pytest.approx(stop, rel=1e-12)


@given(distances, guards)
def test_the_stop_is_below_the_distance_and_above_a_quarter(now, guard):
    stop = stop_within(now, guard)
    assert 0.0 < stop < now
    assert stop >= LEAVING_SHARE * min(now, MIN_SHARE * guard)


@given(st.just(0.0) | distances, guards)
def test_planned_paths_keep_beyond_the_protective_stop(now, guard):
    gap = planned_gap(now, guard)
    assert gap <= now
    stop = guard if now > guard else stop_within(now, guard)
    assert gap > stop or now == 0.0 or gap == stop == guard
    assert planned_gap(now + 0.1, guard) >= gap
    assert gap <= max_gap(guard) == planned_gap(1e9, guard)


def swept(*places) -> Sweep:
    """What a disc of a quarter metre covers along straight lines."""
    waypoints = (Waypoint(float(k), x, y, 0.0) for k, (x, y) in enumerate(places))
    return Sweep(Footprint.disc(0.25), Trajectory(tuple(waypoints)))


@pytest.mark.parametrize(
    ("start", "end", "conflicts"),
    [
        # Bodies far apart keep 120 mm; those 50 mm apart keep 37.5 mm, those 30 mm apart 27.5 mm.
        ((0.0, 0.0), (1.37, 0.0), False),
        ((0.0, 0.0), (1.39, 0.0), True),
        ((1.45, 0.0), (1.46, 0.0), False),
        ((1.45, 0.0), (1.47, 0.0), True),
        ((1.45, 0.0), (0.0, 0.0), False),
        ((1.47, 0.0), (1.4724, 0.0), False),
        ((1.47, 0.0), (1.4726, 0.0), True),
    ],
)
def test_paths_conflict_where_they_come_too_near(start, end, conflicts):
    standing = swept((2.0, 0.0))
    moving, body = swept(start, end), swept(start)
    assert conflict(moving, body, standing, standing, GUARD_M) == conflicts
    assert conflict(standing, standing, moving, body, GUARD_M) == conflicts
