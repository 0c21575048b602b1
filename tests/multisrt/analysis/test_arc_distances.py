"""Distances of arcs from segments, by hand and by dense sampling."""

import math

import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st

from multisrt.analysis.arc_distances import arcs_to_segments, centres_of_rotation

HALF = math.pi / 2.0
PLACES = st.tuples(st.floats(-3, 3), st.floats(-3, 3))


def distance(centre, start, turn, a, b) -> float:
    segment = np.array([a, b], np.float64)
    arc = np.array(centre, np.float64), np.array(start, np.float64), np.array(float(turn))
    return float(arcs_to_segments(*arc, segment))


@pytest.mark.parametrize(
    ("turn", "a", "b", "expected"),
    [
        # The point starts at (1, 0) and turns about the origin.
        (HALF, (-5, 3), (5, 3), 2.0),  # the end is nearest
        (math.pi, (-5, 3), (5, 3), 2.0),  # the middle is nearest
        (-HALF, (-5, 3), (5, 3), 3.0),  # the start is nearest
        (HALF, (0.3, 0.3), (0.2, 0.2), 1.0 - math.hypot(0.3, 0.3)),  # from inside
        (HALF, (2, 2), (3, 3), math.hypot(2, 2) - 1.0),  # an end of the segment
        (HALF, (0, 0), (2, 2), 0.0),  # crossed
        (-HALF, (0, 0), (2, 2), math.hypot(0.5, 0.5)),  # crossed elsewhere
        (2.5 * math.pi, (0, -2), (0, -2), 1.0),  # more than a whole turn, a point
        (-2.5 * math.pi, (0, 0), (0, 0), 1.0),
        (0.0, (1, 1), (3, 1), 1.0),  # no turn
    ],
)
def test_distances_by_hand(turn, a, b, expected):
    assert distance((0, 0), (1, 0), turn, a, b) == pytest.approx(expected, abs=1e-12)


@given(PLACES, PLACES, st.floats(-6.5, 6.5), PLACES, PLACES)
def test_distances_are_those_of_dense_sampling(centre, start, turn, a, b):
    found = distance(centre, start, turn, a, b)
    spoke = complex(*start) - complex(*centre)
    along = complex(*centre) + spoke * np.exp(1j * np.linspace(0.0, turn, 800))
    points = shapely.points(along.real, along.imag)
    sampled = shapely.distance(points, shapely.LineString([a, b])).min()
    step = abs(spoke * turn) / 799 / 2.0
    assert sampled - step - 1e-9 <= found <= sampled + 1e-9


@given(PLACES, PLACES, st.floats(0.01, math.pi), st.sampled_from([-1, 1]))
def test_a_rotation_about_its_centre_leads_to_the_end(start, end, turn, sign):
    turn *= sign
    centre = centres_of_rotation(np.array([start]), np.array([end]), np.array([turn]))[0]
    about = complex(*centre)
    led = about + (complex(*start) - about) * np.exp(1j * turn)
    assert led == pytest.approx(complex(*end), abs=1e-9 * max(1.0, abs(about)))


def test_who_stays_turns_about_itself():
    place = np.array([(2.0, 3.0)])
    assert centres_of_rotation(place, place, np.array([2.0 * math.pi])).tolist() == [[2.0, 3.0]]
