"""Witnesses: regions against what is seen from drawn places, and bounds worked out by hand."""

import numpy as np
import pytest
import shapely

from multisrt.analysis.bounds.team import Member
from multisrt.analysis.bounds.witnesses import witness_s, witnesses
from multisrt.environments.environment import Environment
from multisrt.geometry.configuration import Configuration
from multisrt.geometry.regions.edge_index import EdgeIndex
from multisrt.geometry.regions.safe_region import local_safe_region
from multisrt.geometry.regions.scan import take_scan
from multisrt.spec import RangeFinderSpec, RobotSpec

BODY_M = 0.25


def places(free):
    return free.buffer(-BODY_M)


def member(x, y, *, range_m=4.0, beams=None):
    finder = RangeFinderSpec(range_m=range_m, beams=beams)
    return Member.of(RobotSpec(range_finder=finder), Configuration(x, y))


def star(arms, length=10.0, width=1.0):
    """Return corridors that lead from a middle in equal directions, with a bend at their ends."""
    angles = 2.0 * np.pi * np.arange(arms) / arms
    lines = []
    for angle in angles:
        end = length * np.array([np.cos(angle), np.sin(angle)])
        bend = end + 2.0 * np.array([-np.sin(angle), np.cos(angle)])
        lines.append(shapely.LineString([(0.0, 0.0), end, bend]))
    return shapely.union_all(lines).buffer(0.5 * width, cap_style="flat", join_style="mitre")


@pytest.mark.slow
@pytest.mark.parametrize("beams", [None, 60])
def test_regions_hold_all_places_that_see_a_witness(worlds, beams):
    world = Environment("office", worlds.office(width=8.0, count=2))
    robot = member(0.0, 0.0, range_m=3.0, beams=beams)
    known = witnesses(world, places(world.free), robot.range_m, robot.spread_m, 4)
    index = EdgeIndex(world.edges, 1.0)
    squares = shapely.box(*known.squares.T)
    hits = 0
    for x, y in worlds.viewpoints(world.free.geoms[0], 60, clearance=BODY_M).tolist():
        scan = take_scan(index, Configuration(x, y), 0.0, 3.0, beams)
        seen = local_safe_region(scan, "radial").polygon().buffer(0.0)
        corners = set(known.paths.corners(known.lattice.cells_at(np.array([[x, y]]))).tolist())
        for k in np.flatnonzero(shapely.area(shapely.intersection(squares, seen)) > 1e-9):
            hits += 1
            assert corners <= set(known.regions[k].tolist())
    assert hits > 50


def test_regions_are_far_from_all_that_is_hidden():
    # A corner that is seen from the bend of a corridor on, but not from its beginning.
    world = Environment("bend", shapely.box(0, 0, 10, 1).union(shapely.box(9, 0, 10, 6)))
    known = witnesses(world, places(world.free), 20.0, 0.0, 2)
    last = int(np.argmax(known.squares[:, 1]))
    distance = known.from_starts([(0.5, 0.5)])[last]
    # From the corner at (9, 1) a place in the lower corridor sees (9.7, 5.7) from about x = 8.9.
    assert 7.5 <= distance <= 8.5


def test_a_star_is_driven_out_and_back():
    world = Environment("star", star(4))
    reachable = places(world.free)
    alone = witness_s(world, reachable, [member(0.0, 0.0)], 1e-3)
    # Each arm up to its bend, about 9 m, and back from all but one, at half a metre a second.
    assert 0.85 * 63.0 / 0.5 <= alone <= 70.0 / 0.5
    team = witness_s(world, reachable, [member(0.0, 0.0)] * 4, 1e-3)
    assert 0.85 * 9.0 / 0.5 <= team <= 10.0 / 0.5


def test_bounds_fall_with_what_may_be_left_unseen():
    world = Environment("star", star(4))
    reachable = places(world.free)
    unseen = (1e-3, 0.05, 0.2, 0.7, 3.0, reachable.area)
    times = [witness_s(world, reachable, [member(0.0, 0.0)], area) for area in unseen]
    assert times[0] > times[2] > times[-1] == 0.0
    # More than one of the dead ends may be left out, but not all of them.
    assert times[3] > 0.0


def test_what_is_seen_from_the_start_bounds_nothing():
    hall = shapely.box(0, 0, 3, 3)
    assert witness_s(Environment("hall", hall), places(hall), [member(1.5, 1.5)], 1e-3) == 0.0


def test_witnesses_are_apart_and_can_be_reached(worlds):
    world = Environment("rooms", worlds.rooms(9.0, 2))
    reachable = places(world.free)
    known = witnesses(world, reachable, 4.0, 0.0, 2)
    squares = shapely.box(*known.squares.T)
    assert known.areas_m2 == pytest.approx(shapely.area(shapely.intersection(squares, reachable)))
    middles = 0.5 * (known.squares[:, :2] + known.squares[:, 2:])
    apart = np.hypot(*(middles[:, None] - middles[None, :]).T)
    assert apart[~np.eye(len(middles), dtype=bool)].min() >= 0.79
