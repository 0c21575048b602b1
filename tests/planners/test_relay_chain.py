"""Where relays stand along a path: on a line, with answers worked out by hand."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from multisrt.planners.relay_chain import relay_places


def line(length_m):
    xs = np.arange(0.0, length_m + 0.5)
    return np.column_stack([xs, np.zeros(len(xs))])


def within(range_m):
    return lambda places, at: np.hypot(*(places - np.array(at)).T) <= range_m


@given(st.integers(1, 60), st.integers(2, 15), st.integers(0, 6))
def test_on_a_line_there_are_as_few_as_can_be(length_m, range_m, relays):
    found = relay_places(line(length_m), (0.0, 0.0), within(range_m), max_relays=relays)
    needed = math.ceil(length_m / range_m) - 1
    if needed > relays:
        assert found is None
        return
    assert found == tuple((k * range_m, 0.0) for k in range(1, needed + 1))


@given(st.lists(st.floats(-1.2, 1.2), min_size=1, max_size=25), st.floats(2.0, 6.0))
def test_what_is_found_is_a_chain(turns, range_m):
    # A path of steps of 1 m that winds.
    steps = np.cumsum(turns)
    path = np.vstack([[(0.0, 0.0)], np.cumsum(np.column_stack([np.cos(steps), np.sin(steps)]), 0)])
    found = relay_places(path, (0.0, 0.0), within(range_m), max_relays=50)
    assert found is not None
    end = (float(path[-1, 0]), float(path[-1, 1]))
    stops = [(0.0, 0.0), *found, end]
    assert all(math.dist(a, b) <= range_m + 1e-9 for a, b in itertools.pairwise(stops))


def test_a_longer_path_begins_with_the_same_places():
    short = relay_places(line(30), (0.0, 0.0), within(9.0), max_relays=9)
    long = relay_places(line(50), (0.0, 0.0), within(9.0), max_relays=9)
    assert short is not None
    assert long is not None
    assert long[: len(short)] == short


def test_relays_that_stand_well_are_kept():
    kept = [(7.0, 0.5), (14.0, -0.5)]
    found = relay_places(line(30), (0.0, 0.0), within(9.0), max_relays=4, kept=kept)
    # The third is 9 m from (14, -0.5).
    assert found == (*kept, (22.0, 0.0))


def test_relays_are_not_kept_where_there_are_too_few_of_them():
    # With 7 and 14, three relays end at 22 and reach 31; without, they reach 36.
    kept = [(7.0, 0.0), (14.0, 0.0)]
    found = relay_places(line(36), (0.0, 0.0), within(9.0), max_relays=3, kept=kept)
    assert found == ((9.0, 0.0), (18.0, 0.0), (27.0, 0.0))


@pytest.mark.parametrize("place", [(7.0, 3.0), (11.0, 0.0)])
def test_relays_off_the_path_or_out_of_reach_are_not_kept(place):
    found = relay_places(line(15), (0.0, 0.0), within(9.0), max_relays=2, kept=[place])
    assert found == ((9.0, 0.0),)


def test_new_relays_stand_before_the_front():
    found = relay_places(
        line(15), (0.0, 0.0), within(9.0), max_relays=2, clear_of=(9.0, 0.0), clear_m=1.5
    )
    assert found == ((7.0, 0.0),)


def test_a_path_that_the_base_station_does_not_hear_has_no_chain():
    assert relay_places(line(20)[12:], (0.0, 0.0), within(9.0), max_relays=9) is None


def test_relays_stand_where_others_can_pass_if_there_is_such_a_place_near():
    path = np.column_stack([np.arange(0.0, 30.5, 0.5), np.zeros(61)])

    def linked(places, at):
        return np.hypot(*(places - at).T) <= 9.0

    def roomy(places):
        # Doors at 8 to 10 m and at 15 to 20 m, the latter too long to stand before it.
        x = places[:, 0]
        return ~(((x > 7.5) & (x < 10.5)) | ((x > 12.5) & (x < 20.5)))

    places = relay_places(path, (0.0, 0.0), linked, max_relays=9, roomy=roomy)
    assert places == ((7.5, 0.0), (16.5, 0.0), (25.5, 0.0))
    # With three relays they have to stand at the last places.
    path = path[:57]
    assert relay_places(path, (0.0, 0.0), linked, max_relays=3, roomy=roomy) is not None
    path = np.column_stack([np.arange(0.0, 36.5, 0.5), np.zeros(73)])
    places = relay_places(path, (0.0, 0.0), linked, max_relays=3, roomy=roomy)
    assert places == ((9.0, 0.0), (18.0, 0.0), (27.0, 0.0))
