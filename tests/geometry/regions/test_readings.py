"""Scans from the readings of sensors."""

import math

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from multisrt.geometry.configuration import Configuration
from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.regions.boundary import GAP, OBSTACLE, RANGE
from multisrt.geometry.regions.edge_index import EdgeIndex
from multisrt.geometry.regions.readings import scan_of_polygon, scan_of_ranges
from multisrt.geometry.regions.safe_region import local_safe_region
from multisrt.geometry.regions.scan import ExactScan, LaserScan, take_scan

ROOM = shapely.Polygon([(0, 0), (6, 0), (6, 2), (4, 2), (4, 4), (0, 4)])
EDGES = np.array([[*a, *b] for a, b in zip(ROOM.exterior.coords, ROOM.exterior.coords[1:])])  # noqa: B905
INDEX = EdgeIndex(EDGES, 1.0)


def true_ranges(here: Configuration, beams: int, range_m: float, first_rad: float) -> np.ndarray:
    # By shapely: the distance to the first wall along each beam of a sensor that turns.
    found = []
    for k in range(beams):
        a = here.heading + first_rad + math.tau * k / beams
        end = (here.x + range_m * math.cos(a), here.y + range_m * math.sin(a))
        hit = shapely.LineString([here[:2], end]).intersection(ROOM.exterior)
        found.append(math.inf if hit.is_empty else hit.distance(shapely.Point(here[:2])))
    return np.array(found)


@settings(max_examples=25, deadline=None)
@given(st.floats(-7.0, 7.0), st.floats(-3.0, 3.0), st.sampled_from([8, 45, 90]))
def test_ranges_are_the_shorter_of_the_two_beside_a_beam(heading, first_rad, beams):
    here = Configuration(2.1, 1.7, heading)
    measured = true_ranges(here, beams, 3.5, first_rad)
    scan = scan_of_ranges(measured, here, time_s=1.0, range_m=3.5, first_rad=first_rad)
    assert (scan.configuration, scan.time_s, scan.range_m) == (here, 1.0, 3.5)
    for k, reach in enumerate(scan.ranges):
        # Directions of the sensor's beams from beam k of the scan, in beams.
        turns = (heading + first_rad) * beams / math.tau + np.arange(beams) - k
        apart = np.abs(np.remainder(turns + beams / 2, beams) - beams / 2)
        beside = measured[apart < 1.0 - 1e-6]
        assert reach <= beside.min()
        assert reach in measured[apart < 1.0 + 1e-6]


def test_a_turned_laser_gives_the_scan_of_one_that_is_not():
    straight = true_ranges(Configuration(2.1, 1.7, 0.0), 36, 3.5, 0.0)
    here = Configuration(2.1, 1.7, 5 * math.tau / 36)
    turned = true_ranges(here, 36, 3.5, 0.0)
    scan = scan_of_ranges(turned, here, time_s=0.0, range_m=3.5)
    assert scan.ranges == pytest.approx(straight)
    truth = take_scan(INDEX, here, 0.0, 3.5, 36)
    assert isinstance(truth, LaserScan)
    assert scan.ranges == pytest.approx(truth.ranges)


def test_readings_beyond_the_range_hit_nothing():
    scan = scan_of_ranges([2.0, 3.0, 4.1, 9.0, math.inf], (0, 0, 0), time_s=0.0, range_m=4.0)
    assert scan.ranges.tolist() == [2.0, 3.0, math.inf, math.inf, math.inf]


@pytest.mark.parametrize(
    ("ranges", "place", "range_m", "words"),
    [
        ([1.0, 2.0], (0, 0, 0), 4.0, "at least 5 ranges"),
        ([[1.0] * 5], (0, 0, 0), 4.0, "not the shape"),
        ([1.0, 1.0, 0.0, 1.0, 1.0], (0, 0, 0), 4.0, "beam 2 is 0"),
        ([1.0, 1.0, 1.0, math.nan, 1.0], (0, 0, 0), 4.0, "beam 3 is nan"),
        ([1.0] * 5, (0, math.nan, 0), 4.0, "finite"),
        ([1.0] * 5, (0, 0, 0), math.inf, "a positive range"),
    ],
)
def test_readings_that_are_none_are_refused(ranges, place, range_m, words):
    with pytest.raises(InvalidInputError, match=words):
        scan_of_ranges(ranges, place, time_s=0.0, range_m=range_m)


def test_a_seen_polygon_is_tagged_as_an_exact_scan():
    here = Configuration(5.0, 1.0, 0.0)
    truth = take_scan(INDEX, here, 2.0, 3.5)
    assert isinstance(truth, ExactScan)
    scan = scan_of_polygon(truth.boundary[::-1], here, time_s=2.0, range_m=3.5)
    assert set(scan.tags) == {OBSTACLE, RANGE, GAP}
    mine, theirs = (local_safe_region(s, "radial").polygon() for s in (scan, truth))
    assert mine.symmetric_difference(theirs).area < 1e-9
    lengths = [
        [piece_lengths(s.boundary)[s.tags == tag].sum() for tag in (OBSTACLE, RANGE, GAP)]
        for s in (scan, truth)
    ]
    assert lengths[0] == pytest.approx(lengths[1])


def piece_lengths(corners: np.ndarray) -> np.ndarray:
    return np.hypot(*(np.roll(corners, -1, axis=0) - corners).T)


@pytest.mark.parametrize(
    "corners", [[(0, 0), (1, 1)], [(0, 0), (2, 2), (2, 0), (0, 2)], [(5, 5), (6, 5), (6, 6)], "no"]
)
def test_a_polygon_that_is_no_scan_is_refused(corners):
    with pytest.raises(InvalidInputError, match="scan"):
        scan_of_polygon(corners, (1.0, 0.5, 0.0), time_s=0.0, range_m=4.0)
