"""Lower bounds of the time that an exploration takes."""

import math

import pytest
import shapely

from multisrt.analysis.bounds import lower_bounds
from multisrt.analysis.coverage import CoverageMeter
from multisrt.environments.environment import Environment
from multisrt.geometry.configuration import Configuration
from multisrt.run import explore
from multisrt.simulation.worlds import inline
from multisrt.spec import DriveSpec, RangeFinderSpec, RobotSpec, RunSpec


def bounds(world, *, start=(1.0, 0.5, 0.0), speed=0.5, range_m=4.0):
    robot = RobotSpec(
        start=start,
        drive=DriveSpec(speed_m_s=speed),
        range_finder=RangeFinderSpec(range_m=range_m),
    )
    spec = RunSpec(environment=inline(world), robots=(robot,))
    starts = (Configuration(*start),)
    meter = CoverageMeter(spec, world, starts)
    return lower_bounds(spec, meter.explorable, starts)


def test_lower_bounds_in_a_corridor():
    # The far end is 19 m away, 15 m of which have to be driven, at half a metre a second.
    reach, area = bounds(Environment("corridor", shapely.box(0, 0, 20, 1)))
    assert 0.97 * 30.0 <= reach <= 30.0
    assert area == 0.0


def test_lower_bounds_in_a_hall():
    # 400 m2, of which a disc of 4 m is seen at once; the rest in a swath 8 m wide.
    reach, area = bounds(Environment("hall", shapely.box(0, 0, 20, 20)), start=(10.0, 10.0, 0.0))
    assert area == pytest.approx((400.0 - 16.0 * math.pi) / (8.0 * 0.5), rel=0.01)
    assert reach == pytest.approx((math.hypot(10, 10) - 4.0) / 0.5, rel=0.03)
    assert reach <= (math.hypot(10, 10) - 4.0) / 0.5


def test_lower_bounds_fall_with_speed_and_range():
    hall = Environment("hall", shapely.box(0, 0, 20, 20))
    slow, fast = bounds(hall, speed=0.5), bounds(hall, speed=1.0)
    assert slow == pytest.approx((2.0 * fast[0], 2.0 * fast[1]))
    assert bounds(hall, range_m=40.0) == (0.0, 0.0)


def test_the_larger_bound_is_the_bound():
    hall = Environment("hall", shapely.box(0, 0, 20, 20), starts=[(10.0, 10.0)])
    metrics = explore(hall, seed=1).metrics
    assert metrics.lower_bound_s == max(metrics.lower_bound_reach_s, metrics.lower_bound_area_s)
    assert metrics.known_complete_s is not None
    assert metrics.known_complete_s > metrics.lower_bound_s > 0.0


def test_the_reach_of_a_team_is_from_the_nearest_start():
    corridor = Environment("corridor", shapely.box(0, 0, 20, 1))
    spec = RunSpec(
        environment=inline(corridor),
        robots=(
            RobotSpec(range_finder=RangeFinderSpec(range_m=2.0)),
            RobotSpec(drive=DriveSpec(speed_m_s=1.0), range_finder=RangeFinderSpec(range_m=4.0)),
        ),
    )
    starts = Configuration(0.5, 0.5), Configuration(14.0, 0.5)
    meter = CoverageMeter(spec, corridor, starts)
    reach, _ = lower_bounds(spec, meter.explorable, starts)
    # The middle is 6.75 m from both; it comes into the longer range after 2.75 m.
    assert 0.9 * 2.75 <= reach <= 2.75
