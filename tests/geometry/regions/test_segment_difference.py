"""Differences of segments, against shapely and by hand."""

import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st
from shapely.geometry.base import BaseGeometry

from multisrt.geometry.numerics.rings import Rings
from multisrt.geometry.regions.frontier_arcs import total_length
from multisrt.geometry.regions.segment_difference import beside, intersect_pieces, uncovered


def lines(segments):
    return shapely.multilinestrings(shapely.linestrings(segments.reshape(-1, 2, 2)))


SQUARE = np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]])


@pytest.mark.parametrize(
    ("segment", "left"),
    [
        ([-1, 1, 3, 1], [[-1, 1, 0, 1], [2, 1, 3, 1]]),  # through
        ([0.5, 1, 1.5, 1], []),  # inside
        ([0.5, 1, 3, 1], [[2, 1, 3, 1]]),  # out of it
        ([3, 0, 5, 0], [[3, 0, 5, 0]]),  # beside
        ([0, 0, 0, 2], []),  # on the left side: its right is inside
        ([0, 2, 0, 0], [[0, 2, 0, 0]]),  # the same backwards: its right is outside
        ([0, 0, 2, 0], [[0, 0, 2, 0]]),
        ([2, 0, 0, 0], []),
        ([-1, 0, 3, 0], [[-1, 0, 3, 0]]),  # along the lower side, nothing seen below
        ([3, 0, -1, 0], [[3, 0, 2, 0], [0, 0, -1, 0]]),  # along it, the square beyond
        ([1, 1, 1, 1], []),  # no length
    ],
)
def test_a_square_is_subtracted_from_segments_by_hand(subtracting, segment, left):
    rest = subtracting.take(np.array([segment], float), [SQUARE])
    assert rest.shape == (len(left), 4)
    assert rest == pytest.approx(np.array(left, float).reshape(-1, 4), abs=1e-5)


def test_what_is_left_keeps_its_order_and_its_source():
    segments = np.array([[-1.0, 1, 3, 1], [0.5, 1, 1.5, 1], [-1, 1.5, 3, 1.5]])
    rest, source = uncovered(segments, Rings([SQUARE]).arrays(np.array([0])), np.array([0]))
    assert source.tolist() == [0, 0, 2, 2]
    assert rest[:, 0] == pytest.approx([-1, 2, -1, 2])


def test_many_holes_in_one_segment(subtracting):
    # A comb with 40 teeth: more pieces than segments came in.
    teeth = [SQUARE * 0.25 + (k, 0.0) for k in range(40)]
    rest = subtracting.take(np.array([[-1.0, 0.3, 41.0, 0.3]]), teeth)
    assert len(rest) == 41
    assert total_length(rest) == pytest.approx(42 - 40 * 0.5)


def test_a_polygon_that_is_not_convex_cuts_several_times(subtracting):
    comb = np.array([[0, 0], [5, 0], [5, 2], [4, 2], [4, 1], [1, 1], [1, 2], [0, 2.0]])
    rest = subtracting.take(np.array([[-1.0, 1.5, 6.0, 1.5]]), [comb])
    assert rest == pytest.approx(np.array([[-1, 1.5, 0, 1.5], [1, 1.5, 4, 1.5], [5, 1.5, 6, 1.5]]))


@pytest.mark.slow
@given(
    st.lists(
        st.tuples(st.floats(0, 8), st.floats(0, 8), st.floats(0.5, 3), st.integers(3, 9)),
        min_size=1,
        max_size=6,
    ),
    st.randoms(use_true_random=False),
)
def test_subtracting_in_any_order_leaves_the_same_points(subtracting, shapes, random):
    polygons = [
        np.array([x, y]) + r * np.column_stack([np.cos(a), np.sin(a)])
        for x, y, r, n in shapes
        for a in [np.arange(n) * 2 * np.pi / n]
    ]
    segments = np.array([[-1.0, 3.3, 11.0, 3.3], [2.2, 11.0, 2.2, -1.0], [0.0, 0.0, 9.0, 8.0]])
    at_once = subtracting.take(segments, polygons)
    order = list(range(len(polygons)))
    random.shuffle(order)
    one_by_one = segments
    for k in order:
        one_by_one = subtracting.take(one_by_one, polygons, [k])
    assert total_length(one_by_one) == pytest.approx(total_length(at_once), abs=1e-5)
    a, b = lines(at_once), lines(one_by_one)
    assert a.difference(b.buffer(2e-6)).length < 1e-5
    assert b.difference(a.buffer(2e-6)).length < 1e-5


def test_only_what_lies_along_a_segment_is_subtracted():
    segments = np.array([[0.0, 0, 4, 0], [0, 1, 4, 1]])
    lines = np.array([[3.0, 0, 1, 0], [2, -1, 2, 2], [0, 0.5, 4, 0.5], [1, 1, 9, 1]])
    rest, source = beside(segments, np.array([True, False]), lines, 1e-6)
    assert rest.tolist() == [[0, 0, 1, 0], [3, 0, 4, 0], [0, 1, 4, 1]]
    assert source.tolist() == [0, 0, 1]


@given(st.lists(st.tuples(st.floats(0, 10), st.floats(0, 10)), max_size=6), st.randoms())
def test_subtractions_in_any_order_leave_the_difference(subtracting, stretches, random):
    whole = np.array([[1.0, 2.0, 7.0, 10.0]])
    at = whole[0, :2] + np.array([0.6, 0.8]) * np.array(stretches).reshape(-1, 2, 1)
    left = whole, whole
    order = list(range(len(stretches)))
    random.shuffle(order)
    for k in order:
        left = subtracting.remainder(subtracting.along(at[k].reshape(1, 4)), *left)
    expected: BaseGeometry = shapely.LineString([(0, 0), (10, 0)])
    for a, b in stretches:
        if abs(a - b) > 1e-5:
            expected = expected.difference(shapely.LineString([(a, 0), (b, 0)]))
    lengths = np.hypot(*(left[0][:, 2:] - left[0][:, :2]).T)
    assert lengths.sum() == pytest.approx(expected.length, abs=1e-4 * (len(stretches) + 1))


@pytest.mark.parametrize("end", [(1.0, 1.0), (-1.0, 1.0), (1.0, -1.0), (-1.0, -1.0)])
def test_of_two_points_that_are_equally_far_any_order_keeps_the_same(end):
    """Computed in two ways, each is farther on in one coordinate, by its last digit."""
    more = np.nextafter(0.5, 1.0)
    whole = np.array([[0.0, 0.0, *end]])
    points = (np.array([[0.5, more], [more, 0.5]]) * end).tolist()
    for pieces in ([[*p, *end] for p in points], [[0.0, 0.0, *p] for p in points]):
        one, other = np.array(pieces[:1]), np.array(pieces[1:])
        found, _ = intersect_pieces(one, whole, other, np.array([0]))
        assert found.tolist() == intersect_pieces(other, whole, one, np.array([0]))[0].tolist()
