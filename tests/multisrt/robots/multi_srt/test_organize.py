"""ORGANIZE: against all sets of targets and shapely, and in small worlds by hand."""

import itertools
import math

import numpy as np
import pytest
import shapely
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from multisrt.geometry.bodies.footprint import Footprint
from multisrt.planners.motion.sweep import Sweep
from multisrt.planners.motion.trajectory import Trajectory, Waypoint
from multisrt.robots.exploration_map import NodeId
from multisrt.robots.multi_srt.conflicts import Conflicts, Prospect
from multisrt.robots.multi_srt.messages import motion_of, path_of
from multisrt.robots.multi_srt.organize import MAX_EXACT, best_targets, organize

GUARD_M = 0.1
DISC = Footprint.disc(0.25)
BODIES = [DISC, Footprint.disc(0.4), Footprint.box(0.6, 0.4), Footprint.box(1.0, 0.3)]


def line(*places, heading=0.0) -> Trajectory:
    """A motion along straight lines at 1 m/s, with one heading."""
    waypoints = [Waypoint(0.0, *places[0], heading)]
    for a, b in itertools.pairwise(places):
        waypoints.append(Waypoint(waypoints[-1].time_s + math.dist(a, b), *b, heading))
    return Trajectory(tuple(waypoints))


def prospect(robot, *places, frontier_m=1.0, body=DISC, heading=0.0, waited=0) -> Prospect:
    return Prospect(
        robot=robot,
        footprint=body,
        motion=line(*places, heading=heading),
        frontier_m=frontier_m,
        waited=waited,
    )


class ByHand:
    """Alternatives given by hand: other targets, detours, and ways aside with their lengths."""

    def __init__(self, targets=None, around=None, aside=None, bodies=None):
        self.targets = targets or {}
        self.around = around or {}
        self.aside = aside or {}
        self.bodies = bodies or {}
        self.planned = []

    def new_targets(self, robot):
        yield from self.targets.get(robot, ())

    def detours(self, robot, gap_m, prospects):
        self.planned.append((robot, gap_m))
        yield from self.around.get(robot, ())

    def ways_aside(self, robot, way, gap_m, prospects):
        yield from self.aside.get(robot, ())

    def sweep(self, robot, motion):
        return Sweep(self.bodies.get(robot, DISC), motion)


# Random teams ----------------------------------------------------------------------------------


class Plan:
    """One robot of a random team: its body, and the positions along its path."""

    def __init__(self, number, body, heading, places, frontier_m, waited):
        self.number, self.body, self.heading = number, body, heading
        self.places, self.frontier_m, self.waited = places, frontier_m, waited

    def prospect(self) -> Prospect:
        return prospect(
            self.number,
            *self.places,
            frontier_m=self.frontier_m,
            body=self.body,
            heading=self.heading,
            waited=self.waited,
        )

    def covered(self, places):
        """What the body covers on straight lines, by shapely, and the radius to buffer it by."""
        if self.body.is_disc:
            way = shapely.LineString(places) if len(places) > 1 else shapely.Point(places[0])
            return way, self.body.radius_m
        at = [
            shapely.affinity.translate(
                shapely.affinity.rotate(
                    shapely.Polygon(self.body.vertices), self.heading, (0, 0), use_radians=True
                ),
                *place,
            )
            for place in places
        ]
        legs = [shapely.union(a, b).convex_hull for a, b in itertools.pairwise(at)]
        return shapely.union_all(legs or at), 0.0


def apart(a, b) -> float:
    return max(0.0, shapely.distance(a[0], b[0]) - a[1] - b[1])


@st.composite
def teams(draw, least=1, most=8, side_m=9.0):
    """Robots whose bodies are apart; some stand, some next to one another."""
    count = draw(st.integers(least, most))
    rng = np.random.default_rng(draw(st.integers(0, 2**32)))
    plans: list[Plan] = []
    while len(plans) < count:
        body = BODIES[rng.integers(len(BODIES))]
        start = rng.uniform(0.0, side_m, 2)
        if plans and rng.random() < 0.3:
            start = np.array(plans[-1].places[0]) + rng.uniform(-0.9, 0.9, 2)
        places = [tuple(start.tolist())]
        if rng.random() < 0.8:
            places.append(tuple((start + rng.uniform(-3.0, 3.0, 2)).tolist()))
        frontier_m = float(rng.choice([0.0, 1.0, 2.0, rng.uniform(0.0, 5.0)]))
        waited = int(rng.integers(3))
        plan = Plan(len(plans), body, float(rng.uniform(-3, 3)), places, frontier_m, waited)
        body_there = plan.covered(places[:1])
        if all(apart(body_there, other.covered(other.places[:1])) > 0.01 for other in plans):
            plans.append(plan)
    return plans


def conflicts_of(plans, order=None) -> Conflicts:
    return Conflicts({i: plans[i].prospect() for i in order or range(len(plans))}, GUARD_M)


def gap_between(a, b) -> float:
    """The distance that two robots have to keep, from their distance now."""
    now = apart(a.covered(a.places[:1]), b.covered(b.places[:1]))
    if now <= GUARD_M:
        return max(0.75 * now, min(0.9995 * now, 0.3 * GUARD_M))
    return GUARD_M if now < 1.2 * GUARD_M else 1.2 * GUARD_M


def is_feasible(plans, ways, exact=True) -> bool:
    """Whether all can follow their paths (one position: it stays) at once."""
    slack = 0.0 if exact else 1e-6
    for a, b in itertools.combinations(plans, 2):
        if len(ways[a.number]) == len(ways[b.number]) == 1:
            continue
        gap = apart(a.covered(ways[a.number]), b.covered(ways[b.number]))
        if gap < gap_between(a, b) - slack:
            return False
    return True


def conflict_tables(plans):
    """For every pair: whether the ways conflict, and whether a body is in the other's way."""
    count = len(plans)
    ways = [plan.covered(plan.places) for plan in plans]
    bodies = [plan.covered(plan.places[:1]) for plan in plans]
    both, body = np.zeros((count, count), bool), np.zeros((count, count), bool)
    for i, j in itertools.permutations(range(count), 2):
        gap = gap_between(plans[i], plans[j])
        for table, other in ((both, ways[j]), (body, bodies[j])):
            distance = apart(ways[i], other)
            # Cases that rounding decides are left out.
            assume(abs(distance - gap) > 1e-7)
            table[i, j] = distance < gap
    return both, body


def best_by_trying_all(plans) -> tuple[int, ...]:
    both, body = conflict_tables(plans)
    movers = [plan.number for plan in plans if len(plan.places) > 1]
    best = (0.0, 0, 0, ())
    for choice in range(1 << len(movers)):
        going = [i for k, i in enumerate(movers) if choice >> k & 1]
        staying = [i for i in range(len(plans)) if i not in going]
        if both[np.ix_(going, going)].any() or body[np.ix_(going, staying)].any():
            continue
        total = math.fsum(plans[i].frontier_m for i in going)
        rank = (total, sum(plans[i].waited for i in going), len(going))
        if rank > best[:3] or (rank == best[:3] and tuple(going) < best[3]):
            best = (*rank, tuple(going))
    return best[3]


@settings(max_examples=150)
@given(
    st.sampled_from(BODIES),
    st.lists(st.tuples(st.floats(-3, 3), st.floats(-3, 3), st.floats(-3, 3)), max_size=4),
)
def test_a_prospect_stays_within_its_bounds(body, legs):
    waypoints = [Waypoint(0.0, 0.0, 0.0, 0.3)]
    for dx, dy, turn in legs:
        at = waypoints[-1]
        waypoints.append(Waypoint(at.time_s + 1.0, at.x + dx, at.y + dy, at.heading + turn))
    found = Prospect(robot=0, footprint=body, motion=Trajectory(tuple(waypoints)), frontier_m=0.0)
    assert shapely.box(*found.bounds).covers(shapely.box(*found.way.bounds))


@given(teams())
def test_best_targets_are_those_of_all_sets_tried(plans):
    assert best_targets(conflicts_of(plans)) == best_by_trying_all(plans)


@settings(max_examples=8)
@given(teams(least=MAX_EXACT - 1, most=MAX_EXACT, side_m=14.0))
def test_best_targets_of_a_large_group(plans):
    assert best_targets(conflicts_of(plans)) == best_by_trying_all(plans)


@settings(max_examples=10)
@given(teams(least=24, most=30, side_m=25.0))
def test_greedy_targets_are_feasible_and_maximal(plans):
    conflicts = conflicts_of(plans)
    chosen = best_targets(conflicts)
    ways = {p.number: p.places if p.number in chosen else p.places[:1] for p in plans}
    assert is_feasible(plans, ways)
    for plan in plans:
        if len(plan.places) > 1 and plan.number not in chosen:
            assert not is_feasible(plans, ways | {plan.number: plan.places})


@given(teams())
def test_conflicts_are_those_of_shapely(plans):
    both, body = conflict_tables(plans)
    conflicts = conflicts_of(plans)
    moving = [len(plan.places) > 1 for plan in plans]
    expected = tuple(
        (i, j)
        for i, j in itertools.combinations(range(len(plans)), 2)
        if both[i, j] and (moving[i] or moving[j])
    )
    assert conflicts.pairs == expected
    for i, goes in enumerate(moving):
        if goes:
            assert conflicts.in_the_way(i) == np.flatnonzero(body[i]).tolist()


class InThePlane:
    """Alternatives in an open plane: every robot tries the same directions."""

    def __init__(self, plans):
        self.plans = plans

    def _goes(self, robot, lengths):
        plan = self.plans[robot]
        x, y = plan.places[0]
        for length in lengths:
            for k in range(8):
                angle = 0.25 * math.pi * k + robot
                to = (x + length * math.cos(angle), y + length * math.sin(angle))
                yield length, line((x, y), to, heading=plan.heading)

    def new_targets(self, robot):
        for _, motion in self._goes(robot, (2.0,)):
            yield motion

    def detours(self, robot, gap_m, prospects):
        for _, motion in self._goes(robot, (1.0, 3.0)):
            yield motion

    def ways_aside(self, robot, way, gap_m, prospects):
        plan = self.plans[robot]
        for length, motion in self._goes(robot, (0.5, 1.0, 2.0, 4.0)):
            place = Sweep(plan.body, Trajectory(motion.reversed().waypoints[:1]))
            if place.distance_to(way) >= gap_m:
                yield length, motion, None

    def sweep(self, robot, motion):
        return Sweep(self.plans[robot].body, motion)


def driven(plan, order) -> list[tuple[float, float]]:
    """The positions along which a robot goes by its order."""
    if order.order == "keep":
        return plan.places
    if order.order == "wait":
        return plan.places[:1]
    return [(x, y) for _, x, y, _ in order.path]


@settings(max_examples=200)
@given(teams(side_m=6.0))
def test_orders_are_jointly_feasible(plans):
    conflicts = conflicts_of(plans)
    arrangement = organize(conflicts, InThePlane(plans))
    assert list(arrangement.orders) == list(range(len(plans)))
    ways = {p.number: driven(p, arrangement.orders[p.number]) for p in plans}
    assert is_feasible(plans, ways, exact=False)
    for plan in plans:
        order = arrangement.orders[plan.number]
        assert ways[plan.number][0] == plan.places[0]
        assert arrangement.targets[plan.number] == ways[plan.number][-1]
        if order.order == "keep":
            assert len(plan.places) > 1
            assert not conflicts.in_the_way(plan.number)
        if len(plan.places) == 1:
            assert order.order in ("wait", "give way")
    assert best_targets(conflicts) == tuple(
        i for i, order in arrangement.orders.items() if order.order == "keep"
    )
    stays = all(len(way) == 1 for way in ways.values())
    assert arrangement.is_deadlock == stays
    moves_freely = [p for p in plans if len(p.places) > 1 and not conflicts.in_the_way(p.number)]
    assert not (moves_freely and stays)


@settings(max_examples=100)
@given(teams(side_m=5.0), st.data())
def test_arrangements_do_not_depend_on_the_order_of_robots(plans, data):
    order = data.draw(st.permutations(range(len(plans))))
    wits = InThePlane(plans)
    once = organize(conflicts_of(plans), wits)
    again = organize(conflicts_of(plans, order), wits)
    assert (once.orders, once.targets) == (again.orders, again.targets)
    assert organize(conflicts_of(plans), wits) == once


def test_bodies_that_stay_never_conflict():
    near = {0: prospect(0, (0, 0)), 1: prospect(1, (0.501, 0))}
    assert Conflicts(near, GUARD_M).pairs == ()


def test_paths_survive_a_message():
    motion = line((0, 0), (3, 4), (3, 6), heading=0.7)
    assert path_of(motion) == ((0.0, 0, 0, 0.7), (5.0, 3, 4, 0.7), (7.0, 3, 6, 0.7))
    assert motion_of(path_of(motion)) == motion


# Worlds by hand --------------------------------------------------------------------------------


def crossing(first_m, second_m) -> Conflicts:
    """Robot 0 goes east and robot 1 north, across the other's way."""
    east = prospect(0, (0, 0), (4, 0), frontier_m=first_m)
    north = prospect(1, (2, -2), (2, 2), frontier_m=second_m)
    return Conflicts({0: east, 1: north}, GUARD_M)


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
def test_of_two_that_cross_the_longer_frontier_goes(first_m, second_m, orders):
    conflicts = crossing(first_m, second_m)
    assert conflicts.pairs == ((0, 1),)
    arrangement = organize(conflicts, ByHand())
    assert orders_of(arrangement) == orders
    assert not arrangement.is_deadlock
    waits = 1 if orders[1] == "wait" else 0
    assert arrangement.targets[waits] == (2, -2) if waits else (0, 0)


def test_of_two_equal_robots_the_one_that_waited_goes():
    east = prospect(0, (0, 0), (4, 0), waited=1)
    north = prospect(1, (2, -2), (2, 2), waited=2)
    arrangement = organize(Conflicts({0: east, 1: north}, GUARD_M), ByHand())
    assert orders_of(arrangement) == {0: "wait", 1: "keep"}


def test_the_other_gets_the_first_clear_new_target():
    across, aside = line((2, -2), (3, 1)), line((2, -2), (2, -5))
    wits = ByHand(targets={1: [across, aside, line((2, -2), (5, -2))]})
    arrangement = organize(crossing(3.0, 1.0), wits)
    assert orders_of(arrangement) == {0: "keep", 1: "new target"}
    assert arrangement.orders[1].path == path_of(aside)
    assert arrangement.targets == {0: (4, 0), 1: (2, -5)}


def test_without_a_frontier_there_is_no_new_target():
    wits = ByHand(targets={1: [line((2, -2), (2, -5))]})
    assert orders_of(organize(crossing(3.0, 0.0), wits))[1] == "wait"


def test_two_small_frontiers_together_beat_a_large_one():
    prospects = {
        0: prospect(0, (0, 0), (8, 0), frontier_m=3.0),
        1: prospect(1, (2, -2), (2, 2), frontier_m=2.0),
        2: prospect(2, (6, -2), (6, 2), frontier_m=2.0),
    }
    arrangement = organize(Conflicts(prospects, GUARD_M), ByHand())
    assert orders_of(arrangement) == {0: "wait", 1: "keep", 2: "keep"}


def head_on(frontiers=(1.0, 1.0)) -> Conflicts:
    """Two robots in a corridor, each on its way to where the other stands."""
    east = prospect(0, (0, 0), (4, 0), frontier_m=frontiers[0])
    west = prospect(1, (4, 0), (0, 0), frontier_m=frontiers[1])
    return Conflicts({0: east, 1: west}, GUARD_M)


@pytest.mark.parametrize(("near", "far"), [(0, 1), (1, 0)])
def test_head_on_the_shorter_way_aside_decides(near, far):
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


def test_a_way_aside_through_the_other_does_not_count():
    through = line((0, 0), (6, 0))
    wits = ByHand(aside={0: [(1.0, through, None)], 1: [(9.0, line((4, 0), (13, 0)), None)]})
    assert orders_of(organize(head_on(), wits)) == {0: "wait", 1: "give way"}


def test_head_on_without_a_way_aside_is_a_deadlock():
    arrangement = organize(head_on(), ByHand())
    assert orders_of(arrangement) == {0: "wait", 1: "wait"}
    assert arrangement.is_deadlock
    assert arrangement.targets == {0: (0, 0), 1: (4, 0)}


def test_a_robot_that_stands_in_the_way_gives_way():
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


def test_a_robot_with_a_new_target_drives_no_other_away():
    prospects = {0: prospect(0, (0, 0), (4, 0)), 1: prospect(1, (2, 0), frontier_m=0.0)}
    back = line((0, 0), (-3, 0))
    wits = ByHand(targets={0: [back]}, aside={1: [(1.0, line((2, 0), (2, 1)), None)]})
    arrangement = organize(Conflicts(prospects, GUARD_M), wits)
    assert orders_of(arrangement) == {0: "new target", 1: "wait"}


def blocked(frontier_m=1.0) -> Conflicts:
    """Robot 1 stands in the way of robot 0, with 1.5 m between their bodies."""
    goes = prospect(0, (0, 0), (4, 0), frontier_m=frontier_m)
    return Conflicts({0: goes, 1: prospect(1, (2, 0), frontier_m=0.0)}, GUARD_M)


@pytest.mark.parametrize("frontier_m", [0.0, 1.0])
def test_a_robot_with_a_detour_drives_no_other_away(frontier_m):
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


def test_a_new_target_comes_before_a_detour():
    back = line((0, 0), (-3, 0))
    wits = ByHand(targets={0: [back]}, around={0: [line((0, 0), (0, 3))]})
    arrangement = organize(blocked(), wits)
    assert arrangement.orders[0].path == path_of(back)
    assert wits.asked == []


def test_without_a_detour_the_other_clears_the_way():
    wits = ByHand(
        around={0: [line((0, 0), (3, 0.5))]}, aside={1: [(1.0, line((2, 0), (2, 1)), None)]}
    )
    assert orders_of(organize(blocked(), wits)) == {0: "wait", 1: "give way"}


def test_only_a_body_in_the_way_is_reason_for_a_detour():
    # Robot 1 waits for robot 0 to pass; nothing stands in its own way.
    wits = ByHand(around={1: [line((2, -2), (2, -5))]})
    assert orders_of(organize(crossing(3.0, 1.0), wits)) == {0: "keep", 1: "wait"}
    assert wits.asked == []


def test_a_detour_keeps_clear_of_moving_robots():
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


def test_three_robots_in_a_cycle():
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


def test_the_end_of_a_line_goes_first():
    # Each goes to where the next stands; the last one goes on.
    prospects = {k: prospect(k, (2.0 * k, 0), (2.0 * k + 2.0, 0)) for k in range(3)}
    arrangement = organize(Conflicts(prospects, GUARD_M), ByHand())
    assert orders_of(arrangement) == {0: "wait", 1: "wait", 2: "keep"}


@pytest.mark.parametrize(
    ("to", "meet"), [((-3, 0), False), ((0, 3), False), ((0.2, 1), False), ((0.3, 1), True)]
)
def test_bodies_next_to_one_another_may_part(to, meet):
    # They are 50 mm apart, nearer than the guard distance: 37.5 mm is what must be left. Towards
    # (0.2, 1) the centre passes by the other's at 0.55 / sqrt(1.04) m = 539 mm, so 39 mm are
    # left; towards (0.3, 1) at 0.55 / sqrt(1.09) m = 527 mm, which leaves 27 mm.
    prospects = {0: prospect(0, (0, 0), to), 1: prospect(1, (0.55, 0))}
    assert bool(Conflicts(prospects, GUARD_M).pairs) == meet
