"""Lower bounds of small worlds worked out by hand, and runs that old bounds were above."""

import math

import pytest
import shapely
from shapely import affinity

from multisrt.analysis.bounds import lower_bounds
from multisrt.analysis.explorable import explorable, viewers
from multisrt.analysis.measuring import measure
from multisrt.environments.environment import Environment
from multisrt.geometry.configuration import Configuration
from multisrt.geometry.errors import InvalidInputError
from multisrt.run import explore
from multisrt.simulation.worlds import inline
from multisrt.spec import DriveSpec, RangeFinderSpec, RobotSpec, RunSpec


def robot(start, *, speed=0.5, range_m=4.0, beams=None, body="disc:0.25"):
    return RobotSpec(
        start=start,
        footprint=body,
        drive=DriveSpec(speed_m_s=speed),
        range_finder=RangeFinderSpec(range_m=range_m, beams=beams),
    )


def bounds(world, *robots, share=1.0, witnesses=False):
    spec = RunSpec(environment=inline(world), robots=robots)
    starts = tuple(Configuration(*each.start) for each in robots)
    what = explorable(world, viewers(spec, starts))
    return lower_bounds(spec, world, what, starts, share, witnesses=witnesses)


CORRIDOR = Environment("corridor", shapely.box(0, 0, 20, 1))
HALL = Environment("hall", shapely.box(0, 0, 20, 20))


def test_a_corridor_is_driven_until_its_end_is_in_range():
    # The last place is 18.75 m away, 14.75 m of which are to be driven at half a metre a second.
    found = bounds(CORRIDOR, robot((1.0, 0.5)))
    assert 0.96 * 29.5 <= found.reach_s <= 29.5
    # 5 m2 are seen at once.
    assert found.area_s == pytest.approx((20.0 - 5.0) / (8.0 * 0.5), rel=0.01)
    assert found.witness_s is None
    assert found.largest_s == found.reach_s


def test_a_hall_is_swept():
    # 400 m2, of which a disc of 4 m is seen at once; the rest in a swath 8 m wide.
    found = bounds(HALL, robot((10.0, 10.0)))
    assert found.area_s == pytest.approx((400.0 - 16.0 * math.pi) / (8.0 * 0.5), rel=1e-3)
    corner = (math.hypot(9.75, 9.75) - 4.0) / 0.5
    assert 0.93 * corner <= found.reach_s <= corner


def test_what_is_in_walls_is_not_seen_at_once():
    # From a corner only a quarter of the disc is in the hall.
    found = bounds(HALL, robot((0.25, 0.25)))
    quarter = shapely.box(0, 0, 20, 20).intersection(shapely.Point(0.25, 0.25).buffer(4.0, 256))
    assert found.area_s == pytest.approx((400.0 - quarter.area) / (8.0 * 0.5), rel=1e-3)


def test_bounds_fall_with_speed_and_range():
    slow, fast = (bounds(HALL, robot((1.0, 1.0), speed=speed)) for speed in (0.5, 1.0))
    assert (slow.reach_s, slow.area_s) == pytest.approx((2.0 * fast.reach_s, 2.0 * fast.area_s))
    assert bounds(HALL, robot((1.0, 1.0), range_m=40.0)).largest_s == 0.0


def test_bounds_fall_with_the_share():
    shares = (1.0, 0.99, 0.9, 0.5, 0.0)
    found = [bounds(CORRIDOR, robot((1.0, 0.5)), share=share).reach_s for share in shares]
    assert found == sorted(found, reverse=True)
    # A tenth of the explorable 20 m2 are 4 m of the 0.5 m that bodies can reach across.
    assert found[2] == pytest.approx((14.75 - 4.0) / 0.5, rel=0.05)
    assert found[-1] == 0.0


@pytest.mark.parametrize("share", [-0.1, 1.1, math.nan])
def test_a_share_is_from_0_to_1(share):
    with pytest.raises(InvalidInputError, match="share of the explorable area"):
        bounds(CORRIDOR, robot((1.0, 0.5)), share=share)


def test_robots_reach_with_their_own_speed_and_range():
    near = robot((0.5, 0.5), range_m=2.0)
    fast = robot((14.0, 0.5), speed=1.0)
    found = bounds(CORRIDOR, near, fast).reach_s
    # A place at x comes into the range of the first at (x - 2.5) / 0.5 and of the other at 10 - x,
    # of both at once at x = 5; the right end at 19.75 - 14 - 4.
    x = 5.0
    assert 0.8 * (10.0 - x) <= found <= 10.0 - x


def test_a_laser_may_be_off_between_its_beams():
    exact, laser = (
        bounds(CORRIDOR, robot((1.0, 0.5), beams=beams), witnesses=True) for beams in (None, 16)
    )
    assert laser.reach_s <= exact.reach_s
    assert laser.witness_s <= exact.witness_s


def test_the_largest_bound_is_the_bound_of_a_run():
    run = explore(Environment("hall", HALL.free, starts=[(10.0, 10.0)]), seed=1)
    metrics = measure(run.recording, witnesses=True)
    assert metrics.lower_bound_witness_s is not None
    found = (metrics.lower_bound_reach_s, metrics.lower_bound_area_s)
    assert metrics.lower_bound_s == max(*found, metrics.lower_bound_witness_s)
    assert metrics.makespan_s > metrics.lower_bound_s > 0.0


def test_a_narrow_slanted_corridor_is_no_longer_than_it_is():
    # Marched over cells of 0.1 m it was too long: 102 s at least, though complete after 73 s.
    corridor = affinity.rotate(shapely.box(0, 0, 40, 0.14), 45.0, origin=(0, 0))
    start = affinity.rotate(shapely.Point(0.5, 0.07), 45.0, origin=(0, 0))
    metrics = measure(
        explore(
            Environment("corridor", corridor),
            robots=[robot((start.x, start.y), body="disc:0.04")],
            seed=1,
        ).recording,
        witnesses=True,
    )
    assert metrics.coverage > 0.99
    assert metrics.known_complete_s is not None
    assert 0.9 * (39.0 - 4.0) / 0.5 < metrics.lower_bound_s <= (39.5 - 4.0) / 0.5
    assert metrics.lower_bound_s < metrics.known_complete_s


def test_slits_that_cells_would_close_are_open():
    # Slits join two corridors; cells of 0.1 m have no free centre in them, and then the far end of
    # the second corridor is 40 m away, around the end of both.
    slits = [shapely.box(x, 1.0, x + 0.04, 1.5) for x in range(1, 20)]
    corridors = [shapely.box(0, 0, 20, 1), shapely.box(0, 1.5, 20, 2.5)]
    end = shapely.box(19.5, 0, 20.0, 3.0)
    world = Environment("comb", shapely.union_all([*corridors, *slits, end]))
    found = bounds(world, robot((0.5, 0.5), body="disc:0.2")).reach_s
    # Through the first slit, and on to (19.8, 2.8).
    shortest = math.hypot(0.5, 0.5) + 0.5 + math.hypot(18.8, 1.3)
    assert 0.9 * (shortest - 4.0) / 0.5 < found <= (shortest - 4.0) / 0.5
