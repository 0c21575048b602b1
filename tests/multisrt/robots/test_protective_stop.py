"""The protective stop's rule, by hand, and what is planned beside it."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from multisrt.robots.protective_stop import LEAST_SHARE, NO_NEARER, least_gap, stop_within

GUARD_M = 0.1

distances = st.floats(1e-9, 5.0)
guards = st.floats(0.01, 1.0)


@pytest.mark.parametrize(
    ("now", "stop"),
    [(0.1, 0.05), (0.06, 0.03), (0.04, 0.025), (0.025, 0.999 * 0.025), (0.01, 0.00999), (0.0, 0.0)],
)
def test_who_is_nearer_than_the_guard_stops_at_half_of_that_but_not_within_a_quarter(now, stop):
    assert stop_within(now, GUARD_M) == pytest.approx(stop, rel=1e-12)


@given(distances, guards)
def test_whoever_leaves_is_not_stopped_and_nobody_gets_much_nearer_than_a_quarter(now, guard):
    stop = stop_within(now, guard)
    assert 0.0 < stop < now
    assert stop >= NO_NEARER * min(now, LEAST_SHARE * guard)


@given(st.just(0.0) | distances, guards)
def test_the_least_gap_is_beyond_the_protective_stop(now, guard):
    gap = least_gap(now, guard)
    assert gap <= now
    stop = guard if now > guard else stop_within(now, guard)
    assert gap > stop or now == 0.0 or gap == stop == guard
    assert least_gap(now + 0.1, guard) >= gap
