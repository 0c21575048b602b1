"""Scans hold what the range finder would measure, and nothing else."""

import math
from typing import Any, cast

import numpy as np
import pytest

from multisrt.geometry.configuration import Configuration
from multisrt.geometry.errors import ClearanceError
from multisrt.geometry.regions.laser import laser_ranges
from multisrt.geometry.regions.safe_region import local_safe_region
from multisrt.geometry.regions.scan import ExactScan, LaserScan, beam_spacing_rad, take_scan
from multisrt.geometry.regions.visibility import visibility_polygon


def test_exact_scan_is_the_visibility_polygon(worlds):
    index = worlds.index(worlds.pillar())
    at = Configuration(2.0, 5.0, 1.0)
    scan = take_scan(index, at, 7.5, 4.0)
    assert isinstance(scan, ExactScan)
    boundary, tags = visibility_polygon(index, 2.0, 5.0, 4.0)
    assert np.array_equal(scan.boundary, boundary)
    assert np.array_equal(scan.tags, tags)
    assert (scan.configuration, scan.time_s, scan.range_m) == (at, 7.5, 4.0)


def test_laser_scan_is_in_the_frame_of_the_world(worlds):
    # In the empty hall, wherever the robot looks: beam 0 points to +x, a quarter later to +y.
    index = worlds.index(worlds.hall())
    for heading in (0.0, 1.0, -2.0):
        scan = take_scan(index, Configuration(9.0, 8.0, heading), 0.0, 4.0, beams=4)
        assert isinstance(scan, LaserScan)
        assert scan.ranges.tolist() == pytest.approx([1.0, 2.0, np.inf, np.inf])
        assert np.array_equal(scan.ranges, laser_ranges(index, 9.0, 8.0, 4.0, 4))


def test_beam_spacing(worlds):
    scan = take_scan(worlds.index(worlds.hall()), Configuration(5.0, 5.0), 0.0, 4.0, beams=90)
    assert isinstance(scan, LaserScan)
    assert beam_spacing_rad(scan) == pytest.approx(math.radians(4.0))


def test_scanning_inside_an_obstacle_is_an_error(worlds):
    index = worlds.index(worlds.pillar())
    for beams in (None, 90):
        with pytest.raises(ClearanceError):
            take_scan(index, Configuration(5.0, 5.0), 0.0, 4.0, beams)


@pytest.mark.parametrize("beams", [None, 90])
def test_integers_are_taken_as_floats(worlds, beams):
    index = worlds.index(worlds.pillar())
    scan = take_scan(index, Configuration(2, 5, 1), 0.0, 4, beams)
    same = take_scan(index, Configuration(2.0, 5.0, 1.0), 0.0, 4.0, beams)
    for shape in ("ball", "star", "radial"):
        regions = local_safe_region(scan, shape), local_safe_region(same, shape)
        assert np.array_equal(regions[0].boundary, regions[1].boundary)
        assert np.array_equal(regions[0].tags, regions[1].tags)


def test_scans_do_not_change(worlds):
    scan = take_scan(worlds.index(worlds.hall()), Configuration(5.0, 5.0), 0.0, 4.0)
    with pytest.raises(AttributeError):
        cast(Any, scan).range_m = 5.0
