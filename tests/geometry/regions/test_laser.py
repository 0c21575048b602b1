"""Laser ranges against shapely and answers by hand."""

import math

import numpy as np
import pytest
from shapely import LineString, Point, Polygon, box

from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.regions.laser import laser_ranges


@pytest.mark.parametrize("name", ["rooms", "office", "clutter"])
def test_laser_measures_what_shapely_cuts(worlds, name):
    free = worlds.WORLDS[name]()
    index = worlds.index(free)
    beams, first = 72, 0.3
    for x, y in worlds.viewpoints(free, 6, seed=26):
        ranges = laser_ranges(index, x, y, 4.0, beams, first_rad=first)
        for i, measured in enumerate(ranges):
            theta = first + 2 * np.pi * i / beams
            ray = LineString([(x, y), (x + 4 * np.cos(theta), y + 4 * np.sin(theta))])
            hits = free.boundary.intersection(ray)
            if hits.is_empty:
                assert measured == np.inf
            else:
                assert measured == pytest.approx(Point(x, y).distance(hits), abs=1e-9)


def test_laser_in_a_hall_by_hand(worlds):
    index = worlds.index(worlds.hall())
    ranges = laser_ranges(index, 2.0, 5.0, 4.0, 8)
    # East, north-east, north, ... ; the corners of the hall are beyond 4 m.
    assert ranges == pytest.approx(
        [np.inf, np.inf, np.inf, 2 * math.sqrt(2), 2.0, 2 * math.sqrt(2), np.inf, np.inf]
    )
    assert laser_ranges(index, 5.0, 5.0, 8.0, 8) == pytest.approx(
        [5.0, math.sqrt(50), 5.0, math.sqrt(50), 5.0, math.sqrt(50), 5.0, math.sqrt(50)]
    )


@pytest.mark.parametrize("turns", [-100.25, -0.5, 0.75, 7.0])
def test_laser_directions_may_be_any_angle(worlds, turns):
    index = worlds.index(worlds.office())
    plain = laser_ranges(index, 7.0, 8.0, 4.0, 60, first_rad=2 * math.pi * (turns % 1.0))
    turned = laser_ranges(index, 7.0, 8.0, 4.0, 60, first_rad=2 * math.pi * turns)
    assert turned == pytest.approx(plain, abs=1e-9)


@pytest.mark.parametrize(
    ("x", "y", "corners"),
    [
        (-2.6, -2.4000000000000004, [(-2.2, -2.8000000000000003), (-1.8, -3.2), (-2.2, -3.6)]),
        (
            1.0,
            2.8000000000000003,
            [(0.6000000000000001, 2.4000000000000004), (0.4, 2.2), (0.2, 2.4)],
        ),
        (11.200000000000001, -10.4, [(8.8, -8.0), (8.0, -7.2), (8.8, -6.4)]),
    ],
)
def test_beams_along_an_edge_end_where_it_begins(worlds, x, y, corners):
    # The first edge points at the viewpoint but for rounding, along one of eight beams.
    obstacle = Polygon(corners)
    index = worlds.index(box(-20, -20, 20, 20).difference(obstacle))
    found = laser_ranges(index, x, y, 4.0, 8).min()
    assert found == pytest.approx(math.dist((x, y), corners[0]), abs=1e-9)
    assert found == pytest.approx(obstacle.distance(Point(x, y)), abs=1e-9)


def test_an_edge_hardly_longer_than_a_point_stops_no_beam_too_early(worlds):
    twice = [(1.6, 0.8), (1.4, 0.6), (1.2, 1.2), (2.0, 1.2), (1.6, 0.8000000000000002)]
    index = worlds.index(box(-20, -20, 20, 20).difference(Polygon(twice)))
    ranges = laser_ranges(index, 1.8, 0.6, 4.0, 8)
    assert ranges.min() == ranges[3] == pytest.approx(math.dist((1.8, 0.6), twice[0]), abs=1e-9)


def test_refuses_two_beams(worlds):
    with pytest.raises(InvalidInputError, match="at least 3 beams, not 2"):
        laser_ranges(worlds.index(worlds.hall()), 5.0, 5.0, 4.0, 2)
