import math

import numpy as np
import pytest
import shapely
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from multisrt.geometry.configuration import Configuration
from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.regions.boundary import OBSTACLE
from multisrt.geometry.regions.laser import laser_ranges
from multisrt.geometry.regions.safe_region import local_safe_region
from multisrt.geometry.regions.scan import take_scan
from multisrt.planners.navigation.beams import in_frame_of, nearer, region_ranges

RANGE_M = 4.0
OPEN = np.full(360, math.inf)


def test_places_in_the_frame_of_a_robot():
    assert in_frame_of(Configuration(1.0, 2.0, math.pi / 2), 1.0, 5.0) == pytest.approx((3.0, 0.0))
    assert in_frame_of(Configuration(1.0, 2.0, math.pi / 2), 0.0, 2.0) == pytest.approx((0.0, 1.0))


@pytest.mark.slow
@given(
    st.lists(
        st.tuples(st.floats(-4, 4), st.floats(-4, 4), st.floats(0.05, 1.0)), min_size=1, max_size=3
    )
)
@settings(max_examples=30)
def test_discs_and_polygons_shorten_beams(discs):
    assume(all(abs(math.hypot(x, y) - r) > 0.01 for x, y, r in discs))
    count = 32
    ranges = np.linspace(1.0, 4.0, count)
    shapes = [shapely.Point(x, y).buffer(r, quad_segs=64) for x, y, r in discs]
    bodies = shapely.union_all(shapes)
    expected = []
    for k in range(count):
        t = k * 2.0 * math.pi / count
        ray = shapely.LineString([(0, 0), (ranges[k] * math.cos(t), ranges[k] * math.sin(t))])
        met = ray.intersection(bodies)
        expected.append(ranges[k] if met.is_empty else met.distance(shapely.Point(0, 0)))
    polygons = [np.asarray(shape.exterior.coords)[:-1] for shape in shapes]
    if bodies.contains(shapely.Point(0, 0)):
        expected = [0.0] * count
    assert nearer(ranges, polygons=polygons) == pytest.approx(expected, abs=1e-9)
    # Chords lie inside the circle by 0.3 mm a metre; a grazing beam meets one and not the other.
    round_ = nearer(ranges, np.array(discs))
    assert (np.abs(round_ - expected) < 0.02).mean() > 0.9
    assert (round_ <= np.array(expected) + 1e-9).all()


def test_a_disc_straight_ahead():
    cut = nearer(OPEN, np.array([[2.0, 0.0, 0.5]]))
    assert cut[0] == pytest.approx(1.5)
    hit = np.flatnonzero(np.isfinite(cut))
    # asin(0.5 / 2) = 14.48 degrees to either side.
    assert sorted(hit) == [*range(15), *range(346, 360)]
    assert cut is not OPEN
    assert np.isinf(OPEN).all()


@pytest.mark.parametrize("world", ["rooms", "office", "clutter"])
@pytest.mark.parametrize("exact", [True, False])
def test_readings_in_a_region_agree_with_a_laser(worlds, world, exact):
    free = worlds.WORLDS[world]()
    index = worlds.index(free, RANGE_M)
    for x, y in worlds.viewpoints(free, 12).tolist():
        at = Configuration(x, y, 0.7)
        scan = take_scan(index, at, 0.0, RANGE_M, None if exact else 720)
        region = local_safe_region(scan, "radial")
        seen = region_ranges(region, at, 360)
        true = laser_ranges(index, x, y, RANGE_M, 360, first_rad=0.7)
        hit, seen_there, there = np.isfinite(seen), seen[np.isfinite(true)], true[np.isfinite(true)]
        if exact:
            # Except beams that meet a corner, and surfaces exactly at the range.
            assert (hit == np.isfinite(true)).mean() > 0.98
            assert np.isclose(seen, true, rtol=0.0, atol=1e-6).mean() > 0.98
        else:
            # The region ends before the surfaces, except at sharp corners of stones.
            found = np.isfinite(seen_there)
            assert found.mean() > 0.7
            assert (seen_there <= there + 1e-9)[found].mean() > 0.98


def test_readings_from_another_place_in_the_region(worlds):
    free = worlds.pillar()
    region = local_safe_region(
        take_scan(worlds.index(free, 20.0), Configuration(2.0, 5.0), 0.0, 20.0), "radial"
    )
    at = Configuration(2.0, 8.0, 0.0)
    seen = region_ranges(region, at, 8)
    # Walls to the left and above; the edge of the pillar's shadow, which is open.
    shadow = math.inf
    expected = [shadow, math.hypot(2, 2), 2.0, math.hypot(2, 2), 2.0, math.hypot(2, 2), 8.0]
    assert seen[:7] == pytest.approx(expected)
    # Down to the right the pillar's left side is met beside its corner.
    assert seen[7] == pytest.approx(math.hypot(2.0, 2.0))
    assert region.tags.min() == OBSTACLE
    # Behind the shadow is another part of the region, and a wall: the opening counts.
    assert region_ranges(region, Configuration(9.0, 9.2, -math.pi / 2), 8)[0] == math.inf
    assert region_ranges(region, Configuration(9.0, 0.8, math.pi / 2), 8)[0] == math.inf


def test_a_robot_outside_its_region_is_rejected(worlds):
    region = local_safe_region(
        take_scan(worlds.index(worlds.hall()), Configuration(2.0, 5.0), 0.0, 4.0), "radial"
    )
    with pytest.raises(InvalidInputError, match="not in the region"):
        region_ranges(region, Configuration(9.0, 9.0))
    with pytest.raises(InvalidInputError, match="at least 8"):
        region_ranges(region, Configuration(2.0, 5.0), 4)
