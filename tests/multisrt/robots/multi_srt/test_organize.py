"""ORGANIZE in small worlds by hand."""

from collections.abc import Callable

import pytest

from multisrt.geometry.bodies.footprint import Footprint
from multisrt.planners.motion.sweep import Sweep
from multisrt.robots.exploration_map import NodeId
from multisrt.robots.multi_srt.conflicts import Conflicts
from multisrt.robots.multi_srt.messages import motion_of, path_of
from multisrt.robots.multi_srt.organize import best_targets, organize

GUARD_M = 0.1
DISC = Footprint.disc(0.25)


class ByHand:
    """Alternatives given by hand: other targets, detours, and ways aside with their lengths."""

    def __init__(self, targets=None, around=None, aside=None, bodies=None):
        self.targets = targets or {}
        self.around = around or {}
        self.aside = aside or {}
        self.bodies = bodies or {}
        self.asked: list[tuple[int, float]] = []

    def new_targets(self, robot):
        yield from self.targets.get(robot, ())

    def detours(self, robot, gap_m, prospects):
        self.asked.append((robot, gap_m))
        yield from self.around.get(robot, ())

    def motions_aside(self, robot, sweep, gap_m, prospects):
        yield from self.aside.get(robot, ())

    def sweep(self, robot, motion):
        return Sweep(self.bodies.get(robot, DISC), motion)


def test_bodies_that_stay_never_conflict(prospect):
    near = {0: prospect(0, (0, 0)), 1: prospect(1, (0.501, 0))}
    assert Conflicts(near, GUARD_M).pairs == ()


@pytest.mark.parametrize(("nearest_m", "orders"), [(0.0276, "keep"), (0.0274, "wait")])
def test_how_near_a_robot_may_pass_by_one_that_it_starts_beside(prospect, nearest_m, orders):
    # The bodies are 30 mm apart. A motion that begins there is stopped at a quarter of the guard
    # distance, 25 mm; paths keep half of the difference more, 27.5 mm.
    prospects = {
        0: prospect(0, (0, 0)),
        1: prospect(1, (0.53, 0), (0.5 + nearest_m, 0), (0.5 + nearest_m, 4)),
    }
    conflicts = Conflicts(prospects, GUARD_M)
    assert conflicts.gap(0, 1) == pytest.approx(0.0275, abs=1e-9)
    assert orders_of(organize(conflicts, ByHand())) == {0: "wait", 1: orders}


def test_paths_survive_a_message(line):
    motion = line((0, 0), (3, 4), (3, 6), heading=0.7)
    assert path_of(motion) == ((0.0, 0, 0, 0.7), (5.0, 3, 4, 0.7), (7.0, 3, 6, 0.7))
    assert motion_of(path_of(motion)) == motion


@pytest.fixture(scope="module")
def crossing(prospect) -> Callable[..., Conflicts]:
    """Robot 0 goes east and robot 1 north, across the other's way."""

    def build(first_m: float, second_m: float) -> Conflicts:
        east = prospect(0, (0, 0), (4, 0), frontier_m=first_m)
        north = prospect(1, (2, -2), (2, 2), frontier_m=second_m)
        return Conflicts({0: east, 1: north}, GUARD_M)

    return build


def orders_of(arrangement) -> dict[int, str]:
    return {robot: order.order for robot, order in arrangement.orders.items()}


@pytest.mark.parametrize(
    ("first_m", "second_m", "orders"),
    [
        (3.0, 1.0, {0: "keep", 1: "wait"}),
        (1.0, 3.0, {0: "wait", 1: "keep"}),
        (2.0, 2.0, {0: "keep", 1: "wait"}),
    ],
)
def test_of_two_that_cross_the_longer_frontier_goes(crossing, first_m, second_m, orders):
    conflicts = crossing(first_m, second_m)
    assert conflicts.pairs == ((0, 1),)
    arrangement = organize(conflicts, ByHand())
    assert orders_of(arrangement) == orders
    assert not arrangement.is_deadlock
    waits = 1 if orders[1] == "wait" else 0
    assert arrangement.targets[waits] == (2, -2) if waits else (0, 0)


def test_of_two_equal_robots_the_one_that_waited_goes(prospect):
    east = prospect(0, (0, 0), (4, 0), waited=1)
    north = prospect(1, (2, -2), (2, 2), waited=2)
    arrangement = organize(Conflicts({0: east, 1: north}, GUARD_M), ByHand())
    assert orders_of(arrangement) == {0: "wait", 1: "keep"}


def test_the_other_gets_the_first_clear_new_target(line, crossing):
    across, aside = line((2, -2), (3, 1)), line((2, -2), (2, -5))
    wits = ByHand(targets={1: [across, aside, line((2, -2), (5, -2))]})
    arrangement = organize(crossing(3.0, 1.0), wits)
    assert orders_of(arrangement) == {0: "keep", 1: "new target"}
    assert arrangement.orders[1].path == path_of(aside)
    assert arrangement.targets == {0: (4, 0), 1: (2, -5)}


def test_without_a_frontier_there_is_no_new_target(line, crossing):
    wits = ByHand(targets={1: [line((2, -2), (2, -5))]})
    assert orders_of(organize(crossing(3.0, 0.0), wits))[1] == "wait"


def test_two_small_frontiers_together_beat_a_large_one(prospect):
    prospects = {
        0: prospect(0, (0, 0), (8, 0), frontier_m=3.0),
        1: prospect(1, (2, -2), (2, 2), frontier_m=2.0),
        2: prospect(2, (6, -2), (6, 2), frontier_m=2.0),
    }
    arrangement = organize(Conflicts(prospects, GUARD_M), ByHand())
    assert orders_of(arrangement) == {0: "wait", 1: "keep", 2: "keep"}


@pytest.fixture(scope="module")
def head_on(prospect) -> Callable[..., Conflicts]:
    """Two robots in a corridor, each on its way to where the other stands."""

    def build(frontiers: tuple[float, float] = (1.0, 1.0)) -> Conflicts:
        east = prospect(0, (0, 0), (4, 0), frontier_m=frontiers[0])
        west = prospect(1, (4, 0), (0, 0), frontier_m=frontiers[1])
        return Conflicts({0: east, 1: west}, GUARD_M)

    return build


@pytest.mark.parametrize(("near", "far"), [(0, 1), (1, 0)])
def test_head_on_the_shorter_way_aside_decides(line, head_on, near, far):
    start = {0: (0, 0), 1: (4, 0)}
    niche = {robot: line(start[robot], (start[robot][0], -2)) for robot in (0, 1)}
    node = NodeId(near, 7)
    wits = ByHand(aside={near: [(2.0, niche[near], node)], far: [(2.5, niche[far], None)]})
    for frontiers in ((1.0, 1.0), (1.0, 2.0), (2.0, 1.0)):
        arrangement = organize(head_on(frontiers), wits)
        assert orders_of(arrangement) == {near: "give way", far: "wait"}
        assert arrangement.orders[near].path == path_of(niche[near])
        assert arrangement.orders[near].node == node
        assert arrangement.targets == {near: (start[near][0], -2), far: start[far]}
        assert not arrangement.is_deadlock


def test_a_path_aside_through_the_other_does_not_count(line, head_on):
    through = line((0, 0), (6, 0))
    wits = ByHand(aside={0: [(1.0, through, None)], 1: [(9.0, line((4, 0), (13, 0)), None)]})
    assert orders_of(organize(head_on(), wits)) == {0: "wait", 1: "give way"}


def test_head_on_without_a_path_aside_is_a_deadlock(head_on):
    arrangement = organize(head_on(), ByHand())
    assert orders_of(arrangement) == {0: "wait", 1: "wait"}
    assert arrangement.is_deadlock
    assert arrangement.targets == {0: (0, 0), 1: (4, 0)}


def test_a_robot_that_stands_in_the_way_gives_way(line, prospect):
    prospects = {0: prospect(0, (0, 0), (4, 0)), 1: prospect(1, (2, 0), frontier_m=0.0)}
    conflicts = Conflicts(prospects, GUARD_M)
    assert conflicts.in_the_way(0) == [1]
    aside = line((2, 0), (2, 1))
    # Robot 0 has the shorter way aside, but it is not in anybody's way.
    wits = ByHand(aside={0: [(0.1, line((0, 0), (0, 1)), None)], 1: [(1.0, aside, None)]})
    arrangement = organize(conflicts, wits)
    assert orders_of(arrangement) == {0: "wait", 1: "give way"}
    assert arrangement.targets == {0: (0, 0), 1: (2, 1)}
    assert organize(conflicts, ByHand()).is_deadlock


def test_a_robot_with_a_new_target_drives_no_other_away(line, prospect):
    prospects = {0: prospect(0, (0, 0), (4, 0)), 1: prospect(1, (2, 0), frontier_m=0.0)}
    back = line((0, 0), (-3, 0))
    wits = ByHand(targets={0: [back]}, aside={1: [(1.0, line((2, 0), (2, 1)), None)]})
    arrangement = organize(Conflicts(prospects, GUARD_M), wits)
    assert orders_of(arrangement) == {0: "new target", 1: "wait"}


@pytest.fixture(scope="module")
def blocked(prospect) -> Callable[..., Conflicts]:
    """Robot 1 stands in the way of robot 0, with 1.5 m between their bodies."""

    def build(frontier_m: float = 1.0) -> Conflicts:
        goes = prospect(0, (0, 0), (4, 0), frontier_m=frontier_m)
        return Conflicts({0: goes, 1: prospect(1, (2, 0), frontier_m=0.0)}, GUARD_M)

    return build


@pytest.mark.parametrize("frontier_m", [0.0, 1.0])
def test_a_robot_with_a_detour_drives_no_other_away(line, blocked, frontier_m):
    # Also a robot that goes for no frontier: it is on its way home, or to a tree.
    through, around = line((0, 0), (6, 0)), line((0, 0), (0, 3), (4, 3))
    wits = ByHand(
        around={0: [through, around, line((0, 0), (0, -3))]},
        aside={1: [(0.1, line((2, 0), (2, 1)), None)]},
    )
    arrangement = organize(blocked(frontier_m), wits)
    assert orders_of(arrangement) == {0: "new target", 1: "wait"}
    assert arrangement.orders[0].path == path_of(around)
    assert arrangement.targets == {0: (4, 3), 1: (2, 0)}
    # The way around keeps the distance that the ways of these two must keep.
    assert wits.asked == [(0, blocked().gap(0, 1))] == [(0, 1.2 * GUARD_M)]


def test_a_new_target_comes_before_a_detour(line, blocked):
    back = line((0, 0), (-3, 0))
    wits = ByHand(targets={0: [back]}, around={0: [line((0, 0), (0, 3))]})
    arrangement = organize(blocked(), wits)
    assert arrangement.orders[0].path == path_of(back)
    assert wits.asked == []


def test_without_a_detour_the_other_clears_the_path(line, blocked):
    wits = ByHand(
        around={0: [line((0, 0), (3, 0.5))]}, aside={1: [(1.0, line((2, 0), (2, 1)), None)]}
    )
    assert orders_of(organize(blocked(), wits)) == {0: "wait", 1: "give way"}


def test_only_a_body_in_the_way_is_reason_for_a_detour(line, crossing):
    # Robot 1 waits for robot 0 to pass; nothing stands in its own way.
    wits = ByHand(around={1: [line((2, -2), (2, -5))]})
    assert orders_of(organize(crossing(3.0, 1.0), wits)) == {0: "keep", 1: "wait"}
    assert wits.asked == []


def test_a_detour_keeps_clear_of_moving_robots(line, prospect):
    # Robot 2 goes its way above; a way around through that is none, below is free.
    prospects = {
        0: prospect(0, (0, 0), (4, 0)),
        1: prospect(1, (2, 0), frontier_m=0.0),
        2: prospect(2, (4, 2), (-1, 2), frontier_m=5.0),
    }
    below = line((0, 0), (0, -2), (4, -2))
    wits = ByHand(around={0: [line((0, 0), (0, 2), (4, 2)), below]})
    arrangement = organize(Conflicts(prospects, GUARD_M), wits)
    assert orders_of(arrangement) == {0: "new target", 1: "wait", 2: "keep"}
    assert arrangement.orders[0].path == path_of(below)


def test_three_robots_in_a_cycle(line, prospect):
    corners = [(0.0, 0.0), (4.0, 0.0), (2.0, 3.0)]
    prospects = {k: prospect(k, corners[k], corners[(k + 1) % 3]) for k in range(3)}
    conflicts = Conflicts(prospects, GUARD_M)
    assert conflicts.pairs == ((0, 1), (0, 2), (1, 2))
    assert best_targets(conflicts) == ()
    # Only robot 2, at the top, has room behind it: it lets robot 1 go next.
    wits = ByHand(aside={2: [(1.0, line((2, 3), (2, 6)), None)]})
    arrangement = organize(conflicts, wits)
    assert orders_of(arrangement) == {0: "wait", 1: "wait", 2: "give way"}
    assert arrangement.targets[2] == (2, 6)
    assert organize(conflicts, ByHand()).is_deadlock


def test_the_end_of_a_line_goes_first(prospect):
    # Each goes to where the next stands; the last one goes on.
    prospects = {k: prospect(k, (2.0 * k, 0), (2.0 * k + 2.0, 0)) for k in range(3)}
    arrangement = organize(Conflicts(prospects, GUARD_M), ByHand())
    assert orders_of(arrangement) == {0: "wait", 1: "wait", 2: "keep"}


@pytest.mark.parametrize(
    ("to", "meet"), [((-3, 0), False), ((0, 3), False), ((0.2, 1), False), ((0.3, 1), True)]
)
def test_bodies_next_to_one_another_may_part(prospect, to, meet):
    # They are 50 mm apart, nearer than the guard distance: 37.5 mm is what must be left. Towards
    # (0.2, 1) the centre passes by the other's at 0.55 / sqrt(1.04) m = 539 mm, so 39 mm are
    # left; towards (0.3, 1) at 0.55 / sqrt(1.09) m = 527 mm, which leaves 27 mm.
    prospects = {0: prospect(0, (0, 0), to), 1: prospect(1, (0.55, 0))}
    assert bool(Conflicts(prospects, GUARD_M).pairs) == meet
