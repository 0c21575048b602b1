"""Which lasers find all obstacles of a world."""

import shapely

from multisrt.campaign.lasers import are_found, finds_all
from multisrt.environments.environment import Environment
from multisrt.spec import CatalogEnvironment, RangeFinderSpec, RobotSpec, RunSpec

HALL = shapely.box(0.0, 0.0, 10.0, 10.0)


def _hall_around(obstacle: shapely.Polygon) -> Environment:
    return Environment("hall", HALL.difference(obstacle))


def test_an_obstacle_thinner_than_the_spacing_may_be_missed():
    world = _hall_around(shapely.box(4.0, 4.0, 4.15, 7.0))
    assert are_found(world, 0.1)
    assert not are_found(world, 0.2)


def test_a_pillar_thinner_than_the_spacing_may_be_missed():
    assert not are_found(_hall_around(shapely.Point(5.0, 5.0).buffer(0.012)), 0.1)
    assert are_found(_hall_around(shapely.Point(5.0, 5.0).buffer(0.12)), 0.1)


def test_a_wall_between_two_rooms_counts_as_an_obstacle():
    left, right = shapely.box(0, 0, 4, 4), shapely.box(4.1, 0, 8, 4)
    world = Environment("rooms", shapely.union_all([left, right, shapely.box(4, 1, 4.1, 2)]))
    assert are_found(world, 0.05)
    assert not are_found(world, 0.2)


def test_a_corner_sharper_than_45_degrees_may_be_missed():
    # Angles of 90, 45 and 45 degrees, and then of 90, about 27 and 63.
    assert not are_found(_hall_around(shapely.Polygon([(4, 4), (8, 4), (4, 6)])), 0.05)
    assert are_found(_hall_around(shapely.Polygon([(4, 4), (6, 4), (5, 5.2)])), 0.05)


def test_a_thin_end_of_an_obstacle_that_grows_wide_may_be_missed():
    wedge = shapely.Polygon([(2, 5), (7, 4.5), (7, 5.6), (2, 5.1)])  # its end is 0.1 m wide
    assert are_found(_hall_around(wedge), 0.08)
    assert not are_found(_hall_around(wedge), 0.2)


def test_round_obstacles_and_the_corners_of_a_hall_are_found():
    assert are_found(_hall_around(shapely.Point(5.0, 5.0).buffer(0.5)), 0.2)
    assert are_found(Environment("hall", HALL), 0.4)


def test_the_widest_spacing_of_a_team_counts():
    maze = CatalogEnvironment(name="maze", parameters={"size_m": 10.0, "cells": 5})
    fine = RobotSpec(range_finder=RangeFinderSpec(range_m=4.0, beams=360))
    coarse = RobotSpec(range_finder=RangeFinderSpec(range_m=4.0, beams=60))
    assert finds_all(RunSpec(environment=maze, robots=(RobotSpec(), fine)))
    assert not finds_all(RunSpec(environment=maze, robots=(fine, coarse)))
