"""Conflicts and ORGANIZE of random teams, against all sets of targets and shapely."""

import itertools
import math
from collections.abc import Callable, Sequence

import numpy as np
import pytest
import shapely
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from shapely.geometry.base import BaseGeometry

from multisrt.geometry.bodies.footprint import Footprint
from multisrt.planners.motion.sweep import Sweep
from multisrt.planners.motion.trajectory import Trajectory, Waypoint
from multisrt.robots.multi_srt.conflicts import Conflicts, Prospect
from multisrt.robots.multi_srt.messages import Order
from multisrt.robots.multi_srt.organize import MAX_EXACT, best_targets, organize

GUARD_M = 0.1
DISC = Footprint.disc(0.25)
BODIES = [DISC, Footprint.disc(0.4), Footprint.box(0.6, 0.4), Footprint.box(1.0, 0.3)]
Place = tuple[float, float]
Covered = tuple[BaseGeometry, float]


class Plan:
    """One robot of a random team: its body, and the positions along its path."""

    def __init__(
        self,
        number: int,
        body: Footprint,
        heading: float,
        places: list[Place],
        frontier_m: float,
        waited: int,
    ) -> None:
        self.number, self.body, self.heading = number, body, heading
        self.places, self.frontier_m, self.waited = places, frontier_m, waited

    def prospect(self, build: Callable[..., Prospect]) -> Prospect:
        return build(
            self.number,
            *self.places,
            frontier_m=self.frontier_m,
            body=self.body,
            heading=self.heading,
            waited=self.waited,
        )

    def covered(self, places: Sequence[Place]) -> Covered:
        """What the body covers on straight lines, by shapely, and the radius to buffer it by."""
        if self.body.is_disc:
            line = shapely.LineString(places) if len(places) > 1 else shapely.Point(places[0])
            return line, self.body.radius_m
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


def apart(a: Covered, b: Covered) -> float:
    return max(0.0, shapely.distance(a[0], b[0]) - a[1] - b[1])


@st.composite
def teams(draw: st.DrawFn, least: int = 1, most: int = 8, side_m: float = 9.0) -> list[Plan]:
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


@pytest.fixture(scope="module")
def conflicts_of(prospect) -> Callable[..., Conflicts]:
    """Build the conflicts of a team, whose robots are given in some order."""

    def build(plans: Sequence[Plan], order: Sequence[int] | None = None) -> Conflicts:
        members = [plans[i] for i in order or range(len(plans))]
        return Conflicts({plan.number: plan.prospect(prospect) for plan in members}, GUARD_M)

    return build


def gap_between(a: Plan, b: Plan) -> float:
    """The distance that two robots have to keep, from their distance now."""
    now = apart(a.covered(a.places[:1]), b.covered(b.places[:1]))
    if now > GUARD_M:
        return GUARD_M if now < 1.2 * GUARD_M else 1.2 * GUARD_M
    # Halfway to where the protective stop ends a motion that begins at this distance.
    stop = 0.5 * now if now > 0.5 * GUARD_M else min(0.25 * GUARD_M, 0.999 * now)
    return 0.5 * (now + stop)


def is_feasible(
    plans: Sequence[Plan], driven_paths: dict[int, list[Place]], exact: bool = True
) -> bool:
    """Whether all can follow their paths (one position: it stays) at once."""
    slack = 0.0 if exact else 1e-6
    for a, b in itertools.combinations(plans, 2):
        if len(driven_paths[a.number]) == len(driven_paths[b.number]) == 1:
            continue
        gap = apart(a.covered(driven_paths[a.number]), b.covered(driven_paths[b.number]))
        if gap < gap_between(a, b) - slack:
            return False
    return True


def conflict_tables(plans: Sequence[Plan]) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """For every pair: whether the ways conflict, and whether a body is in the other's way."""
    count = len(plans)
    swept = [plan.covered(plan.places) for plan in plans]
    bodies = [plan.covered(plan.places[:1]) for plan in plans]
    both, body = np.zeros((count, count), bool), np.zeros((count, count), bool)
    for i, j in itertools.permutations(range(count), 2):
        gap = gap_between(plans[i], plans[j])
        for table, other in ((both, swept[j]), (body, bodies[j])):
            distance = apart(swept[i], other)
            # Cases that rounding decides are left out.
            assume(abs(distance - gap) > 1e-7)
            table[i, j] = distance < gap
    return both, body


def best_by_trying_all(plans: Sequence[Plan]) -> tuple[int, ...]:
    both, body = conflict_tables(plans)
    movers = [plan.number for plan in plans if len(plan.places) > 1]
    best: tuple[float, int, int, tuple[int, ...]] = (0.0, 0, 0, ())
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
    sweep = found.sweep
    covered = shapely.box(*sweep.shape.bounds).buffer(sweep.pad_m, join_style="mitre")
    assert shapely.box(*found.bounds).covers(covered)


@pytest.mark.slow
@given(teams())
def test_best_targets_are_those_of_all_sets_tried(conflicts_of, plans):
    assert best_targets(conflicts_of(plans)) == best_by_trying_all(plans)


@settings(max_examples=8)
@given(teams(least=MAX_EXACT - 1, most=MAX_EXACT, side_m=14.0))
def test_best_targets_of_a_large_group(conflicts_of, plans):
    assert best_targets(conflicts_of(plans)) == best_by_trying_all(plans)


@pytest.mark.slow
@settings(max_examples=10)
@given(teams(least=24, most=30, side_m=25.0))
def test_greedy_targets_are_feasible_and_maximal(conflicts_of, plans):
    conflicts = conflicts_of(plans)
    chosen = best_targets(conflicts)
    driven_paths = {p.number: p.places if p.number in chosen else p.places[:1] for p in plans}
    assert is_feasible(plans, driven_paths)
    for plan in plans:
        if len(plan.places) > 1 and plan.number not in chosen:
            assert not is_feasible(plans, driven_paths | {plan.number: plan.places})


@given(teams())
def test_conflicts_are_those_of_shapely(conflicts_of, plans):
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

    def __init__(self, plans: Sequence[Plan], line: Callable[..., Trajectory]) -> None:
        self.plans, self.line = plans, line

    def _goes(self, robot, lengths):
        plan = self.plans[robot]
        x, y = plan.places[0]
        for length in lengths:
            for k in range(8):
                angle = 0.25 * math.pi * k + robot
                to = (x + length * math.cos(angle), y + length * math.sin(angle))
                yield length, self.line((x, y), to, heading=plan.heading)

    def new_targets(self, robot):
        for _, motion in self._goes(robot, (2.0,)):
            yield motion

    def detours(self, robot, gap_m, prospects):
        for _, motion in self._goes(robot, (1.0, 3.0)):
            yield motion

    def motions_aside(self, robot, sweep, gap_m, prospects):
        plan = self.plans[robot]
        for length, motion in self._goes(robot, (0.5, 1.0, 2.0, 4.0)):
            place = Sweep(plan.body, Trajectory(motion.reversed().waypoints[:1]))
            if place.distance_to(sweep) >= gap_m:
                yield length, motion, None

    def sweep(self, robot, motion):
        return Sweep(self.plans[robot].body, motion)


def driven(plan: Plan, order: Order) -> list[Place]:
    """The positions along which a robot goes by its order."""
    if order.order == "keep":
        return plan.places
    if order.order == "wait":
        return plan.places[:1]
    return [(x, y) for _, x, y, _ in order.path]


@pytest.mark.slow
@settings(max_examples=200)
@given(teams(side_m=6.0))
def test_orders_are_jointly_feasible(line, conflicts_of, plans):
    conflicts = conflicts_of(plans)
    arrangement = organize(conflicts, InThePlane(plans, line))
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


@pytest.mark.slow
@settings(max_examples=100)
@given(teams(side_m=5.0), st.data())
def test_arrangements_do_not_depend_on_the_order_of_robots(line, conflicts_of, plans, data):
    order = data.draw(st.permutations(range(len(plans))))
    wits = InThePlane(plans, line)
    once = organize(conflicts_of(plans), wits)
    again = organize(conflicts_of(plans, order), wits)
    assert (once.orders, once.targets) == (again.orders, again.targets)
    assert organize(conflicts_of(plans), wits) == once
