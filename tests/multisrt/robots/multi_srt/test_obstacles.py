"""Bodies that a robot plans around: worked out by hand for discs of a quarter metre."""

import numpy as np
import pytest

from multisrt.geometry.bodies.footprint import Footprint
from multisrt.geometry.configuration import Configuration
from multisrt.planners.motion.body import PlanningBody
from multisrt.planners.motion.trajectory import Trajectory, Waypoint
from multisrt.robots.explorer import Sighting
from multisrt.robots.multi_srt.obstacles import Obstacles

DISC = Footprint.disc(0.25)
GUARD_M = 0.1
VIEW = np.array([(-1.0, -1.0), (5.0, -1.0), (5.0, 1.0), (-1.0, 1.0)])


def seen_at(x: float, y: float, robot: int = 1) -> Sighting:
    return Sighting(robot=robot, configuration=Configuration(x, y, 0.0), footprint=DISC)


@pytest.fixture
def obstacles() -> Obstacles:
    return Obstacles(PlanningBody(DISC, 0.02), GUARD_M)


def straight(x: float, y: float) -> Trajectory:
    return Trajectory((Waypoint(0.0, 0.0, 0.0, 0.0), Waypoint(1.0, x, y, 0.0)))


def test_without_bodies_nothing_blocks(obstacles):
    assert not obstacles
    assert obstacles.all == {}
    assert obstacles.blocking(Configuration(0.0, 0.0, 0.0), straight(9.0, 0.0)) is None
    assert obstacles.berths.shape == (0, 3)
    assert obstacles.are_passed_by(np.zeros((2, 4))).tolist() == [True, True]


@pytest.mark.parametrize("kind", ["silent", "avoided"])
def test_a_body_blocks_what_comes_nearer_than_the_guard(obstacles, kind):
    getattr(obstacles, kind)[1] = seen_at(2.0, 0.0)
    here = Configuration(0.0, 0.0, 0.0)
    assert obstacles.blocking(here, straight(4.0, 0.0)) == 1
    # The centres keep 0.5 m, the guard distance and a fifth of it: 0.62 m.
    assert obstacles.blocking(here, straight(2.0 - 0.61, 0.0)) == 1
    assert obstacles.blocking(here, straight(2.0 - 0.63, 0.0)) is None
    assert obstacles.berths == pytest.approx(np.array([[2.0, 0.0, 0.62]]))
    passing = np.array([[0.0, 0.63, 4.0, 0.63], [0.0, 0.61, 4.0, 0.61]])
    assert obstacles.are_passed_by(passing).tolist() == [True, False]


def test_of_a_robot_of_both_kinds_the_later_place_counts(obstacles):
    obstacles.silent[1], obstacles.avoided[1] = seen_at(2.0, 0.0), seen_at(3.0, 0.0)
    obstacles.silent[2] = seen_at(0.0, 2.0, robot=2)
    assert {n: s.configuration[:2] for n, s in obstacles.all.items()} == {1: (3, 0), 2: (0, 2)}


@pytest.mark.parametrize(
    ("seen", "stands"),
    [((seen_at(2.0, 0.0),), True), ((seen_at(2.0, 0.5),), False), ((), False)],
    ids=["there", "elsewhere", "gone"],
)
@pytest.mark.parametrize("kind", ["silent", "avoided"])
def test_a_body_in_view_is_believed_only_where_it_is_seen(obstacles, kind, seen, stands):
    getattr(obstacles, kind)[1] = seen_at(2.0, 0.0)
    obstacles.forget_gone(seen, VIEW)
    assert (1 in obstacles.all) == stands


@pytest.mark.parametrize("view", [None, np.add(VIEW, (9.0, 0.0))])
def test_a_body_out_of_view_is_believed_to_stand(obstacles, view):
    obstacles.silent[1] = obstacles.avoided[2] = seen_at(2.0, 0.0)
    obstacles.forget_gone((), view)
    assert sorted(obstacles.all) == [1, 2]


def test_the_bodies_on_a_path_are_those_that_it_does_not_keep_off(obstacles):
    obstacles.silent[1], obstacles.avoided[2] = seen_at(2.0, 0.0), seen_at(4.0, 2.0, robot=2)
    along, round_the_corner = [0.0, 0.0, 4.0, 0.0], [4.0, 0.0, 4.0, 2.0]
    assert [*obstacles.on(np.array([along]))] == [1]
    assert [*obstacles.on(np.array([along, round_the_corner]))] == [1, 2]
    assert obstacles.on(np.array([[0.0, 0.63, 2.0, 0.63]])) == {}


def test_ignored_bodies_are_back_after_the_block(obstacles):
    obstacles.silent[1], obstacles.avoided[2] = seen_at(2.0, 0.0), seen_at(4.0, 2.0, robot=2)
    with obstacles.ignored():
        assert not obstacles
        assert obstacles.blocking(Configuration(0.0, 0.0, 0.0), straight(4.0, 0.0)) is None
    assert sorted(obstacles.all) == [1, 2]
