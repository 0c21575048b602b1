"""ORGANIZE: how the targets of a group become feasible together.

Source: Multi-SRT, paper section 2, "Coordination". The paper leaves open how ORGANIZE chooses;
ours keeps, of the targets that can be reached without conflict while all others stay where they
are, those of the largest total frontier length. The others get a new target, or wait; and who
stands in another's way, gives way.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

from multisrt.geometry.bodies.footprint import Footprint
from multisrt.planners.motion.sweep import SAGITTA_M, Sweep
from multisrt.planners.motion.trajectory import Trajectory, Waypoint
from multisrt.robots.exploration_map import NodeId
from multisrt.robots.multi_srt.messages import Order, Path
from multisrt.robots.protective_stop import BEYOND_GUARD, least_gap

MOST_EXACT = 12
"""Up to so many robots the best set of targets is found; above, a good one."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Prospect:
    """What a robot would do in this step.

    Attributes
    ----------
    robot : int
        Which.
    footprint : Footprint
        Its body.
    motion : Trajectory
        Where it would go.
    frontier_m : float
        Length of the local frontier that it goes for.
    waited : int
        How often in a row it had to wait.
    """

    robot: int
    footprint: Footprint
    motion: Trajectory
    frontier_m: float
    waited: int = 0

    @cached_property
    def body(self) -> Sweep:
        """What its body covers where it stands."""
        return Sweep(self.footprint, Trajectory(self.motion.waypoints[:1]))

    @cached_property
    def way(self) -> Sweep:
        """What its body sweeps on the way; the body, if it stays."""
        return Sweep(self.footprint, self.motion) if self.moves else self.body

    @cached_property
    def bounds(self) -> tuple[float, float, float, float]:
        """The least x and y that its body may come to on the way, and the greatest."""
        waypoints = self.motion.waypoints
        # An arc of at most half a circle stays in the circle that has its chord as diameter.
        bulge = max(
            (
                0.5 * math.dist(a[1:3], b[1:3])
                for a, b in itertools.pairwise(waypoints)
                if a.heading != b.heading
            ),
            default=0.0,
        )
        reach = self.footprint.circumscribed_radius_m + bulge + SAGITTA_M
        xs, ys = [w.x for w in waypoints], [w.y for w in waypoints]
        return min(xs) - reach, min(ys) - reach, max(xs) + reach, max(ys) + reach

    @property
    def moves(self) -> bool:
        """Whether it would go anywhere."""
        return len(self.motion.waypoints) > 1

    @property
    def target(self) -> tuple[float, float]:
        """Where it would be."""
        end = self.motion.end
        return end.x, end.y


def path_of(motion: Trajectory) -> Path:
    """Write a motion as messages hold it."""
    return tuple((w.time_s, w.x, w.y, w.heading) for w in motion.waypoints)


def motion_of(path: Path) -> Trajectory:
    """Read a motion from a message."""
    return Trajectory(tuple(Waypoint(*waypoint) for waypoint in path))


class Conflicts:
    """Which ways of a group's robots conflict, computed once for each pair.

    Parameters
    ----------
    prospects : dict of int to Prospect
        The group's plans.
    guard_m : float
        At what distance bodies stop before one another.
    """

    def __init__(self, prospects: Mapping[int, Prospect], guard_m: float) -> None:
        self.prospects = prospects
        self.guard_m = guard_m
        self._gaps: dict[tuple[int, int], float] = {}
        numbers = sorted(prospects)
        self.pairs = tuple(
            (i, j)
            for i, j in itertools.combinations(numbers, 2)
            if self._may_meet(prospects[i], prospects[j])
            and self.meet(i, prospects[i].way, j, prospects[j].way)
        )

    def _may_meet(self, a: Prospect, b: Prospect) -> bool:
        # Most are far apart, which shows without looking at their ways.
        gap = BEYOND_GUARD * self.guard_m
        (ax0, ay0, ax1, ay1), (bx0, by0, bx1, by1) = a.bounds, b.bounds
        return max(ax0 - bx1, bx0 - ax1) < gap and max(ay0 - by1, by0 - ay1) < gap

    def gap(self, i: int, j: int) -> float:
        """How near two robots' ways may come."""
        pair = min(i, j), max(i, j)
        if pair not in self._gaps:
            a, b = self.prospects[pair[0]], self.prospects[pair[1]]
            self._gaps[pair] = least_gap(a.body.distance_to(b.body), self.guard_m)
        return self._gaps[pair]

    def meet(self, i: int, way_i: Sweep, j: int, way_j: Sweep) -> bool:
        """Whether two robots' ways come too near to one another."""
        apart = way_i.distance_to(way_j)
        if apart >= BEYOND_GUARD * self.guard_m:  # which is the widest gap
            return False
        if way_i is self.prospects[i].body and way_j is self.prospects[j].body:
            return False
        return apart < self.gap(i, j)

    def in_the_way(self, i: int) -> list[int]:
        """Give the robots that stand in the way of one."""
        way = self.prospects[i].way
        return [
            j
            for j in sorted(self.prospects)
            if j != i and self.meet(i, way, j, self.prospects[j].body)
        ]


def best_targets(conflicts: Conflicts) -> tuple[int, ...]:
    """Choose the targets that are jointly feasible and of the largest total frontier length.

    A robot may go to its target if its way conflicts with no way of the others that go, and
    with no body of those that stay. Of equal choices the one whose robots have waited longest
    is taken, so that who gave way does not at once step back; then the one with more robots,
    then the one with the lower numbers.

    Returns
    -------
    tuple of int
        Robots that may go; of the largest total up to `MOST_EXACT` robots that could go, above
        that chosen greedily, the longest frontier first.
    """
    prospects = conflicts.prospects
    free = [i for i in sorted(prospects) if prospects[i].moves and not conflicts.in_the_way(i)]
    foes: dict[int, set[int]] = {i: set() for i in free}
    for i, j in conflicts.pairs:
        if i in foes and j in foes:
            foes[i].add(j)
            foes[j].add(i)
    free.sort(key=lambda i: (-prospects[i].frontier_m, -prospects[i].waited, i))
    if len(free) > MOST_EXACT:
        chosen: list[int] = []
        for i in free:
            if not foes[i].intersection(chosen):
                chosen.append(i)
        return tuple(sorted(chosen))
    best: tuple[float, int, int, tuple[int, ...]] = (0.0, 0, 0, ())
    for size in range(1, len(free) + 1):
        for group in itertools.combinations(sorted(free), size):
            if any(foes[i].intersection(group) for i in group):
                continue
            total = math.fsum(prospects[i].frontier_m for i in group)
            waited = sum(prospects[i].waited for i in group)
            if (total, waited, size) > best[:3]:
                best = total, waited, size, group
    return best[3]


class Wits(Protocol):
    """What a master needs to know to find other targets for the robots of its group."""

    def new_targets(self, robot: int) -> Iterator[Trajectory]:
        """Draw other targets for a robot, in the order in which they shall be tried."""

    def detours(
        self, robot: int, gap_m: float, prospects: Mapping[int, Prospect]
    ) -> Iterator[Trajectory]:
        """Find first steps of ways around those who stand in a robot's way, shortest first."""

    def ways_aside(
        self, robot: int, way: Sweep, gap_m: float, prospects: Mapping[int, Prospect]
    ) -> Iterator[tuple[float, Trajectory, NodeId | None]]:
        """Find where a robot could leave another's way: how far that is, and its first step."""

    def sweep(self, robot: int, motion: Trajectory) -> Sweep:
        """Give what a robot's body sweeps."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Arrangement:
    """What ORGANIZE decided.

    Attributes
    ----------
    orders : dict of int to Order
        What everyone shall do.
    targets : dict of int to (x, y)
        Where everyone will be.
    """

    orders: dict[int, Order]
    targets: dict[int, tuple[float, float]]

    @property
    def is_deadlock(self) -> bool:
        """Whether nobody could be let go."""
        return all(order.order == "wait" for order in self.orders.values())


def organize(conflicts: Conflicts, wits: Wits) -> Arrangement:
    """ORGANIZE: rearrange the targets of a group so that all can move at once.

    Parameters
    ----------
    conflicts : Conflicts
        The group's plans, and where they conflict.
    wits : Wits
        Finds other targets.
    """
    prospects = conflicts.prospects
    orders: dict[int, Order] = {}
    ways = {i: prospect.body for i, prospect in prospects.items()}
    targets = {i: (p.motion.start.x, p.motion.start.y) for i, p in prospects.items()}

    def grant(i: int, order: Order, motion: Trajectory, way: Sweep) -> None:
        orders[i], ways[i] = order, way
        targets[i] = motion.end.x, motion.end.y

    def is_clear(i: int, way: Sweep) -> bool:
        # Of everybody's way, which begins with the body where it stands.
        return not any(conflicts.meet(i, way, j, ways[j]) for j in prospects if j != i)

    def redirect(i: int, motions: Iterable[Trajectory]) -> None:
        # To the first of some places that it gets to without conflict.
        for motion in motions:
            way = wits.sweep(i, motion)
            if is_clear(i, way):
                return grant(i, Order(order="new target", path=path_of(motion)), motion, way)

    for i in best_targets(conflicts):
        grant(i, Order(order="keep"), prospects[i].motion, prospects[i].way)
    rest = [i for i in prospects if i not in orders and prospects[i].moves]
    rest.sort(key=lambda i: (-prospects[i].frontier_m, i))
    for i in rest:
        if prospects[i].frontier_m > 0.0:
            redirect(i, wits.new_targets(i))
    for i in rest:
        if i not in orders and (standing := conflicts.in_the_way(i)):
            gap = max(conflicts.gap(i, j) for j in standing)
            redirect(i, wits.detours(i, gap, prospects))
    for i in rest:
        if i not in orders:
            _clear_the_way(i, conflicts, wits, orders, grant, is_clear)
    for i in prospects:
        orders.setdefault(i, Order(order="wait"))
    return Arrangement(orders=dict(sorted(orders.items())), targets=targets)


class _Grant(Protocol):
    def __call__(self, i: int, order: Order, motion: Trajectory, way: Sweep) -> None: ...


class _IsClear(Protocol):
    def __call__(self, i: int, way: Sweep) -> bool: ...


def _clear_the_way(
    i: int,
    conflicts: Conflicts,
    wits: Wits,
    orders: dict[int, Order],
    grant: _Grant,
    is_clear: _IsClear,
) -> None:
    # Robots stand in the way of i. Where two block one another, the one that has the shorter
    # way aside gives way; a robot that only stands there does so in any case.
    prospects = conflicts.prospects
    for j in conflicts.in_the_way(i):
        if j in orders:
            continue
        options = [(j, i)]
        if prospects[j].moves and i in conflicts.in_the_way(j):
            options.append((i, j))
        found = []
        for who, for_whom in options:
            gap = conflicts.gap(who, for_whom)
            for length, motion, node in wits.ways_aside(
                who, prospects[for_whom].way, gap, prospects
            ):
                way = wits.sweep(who, motion)
                if is_clear(who, way):
                    found.append((length, who, motion, node, way))
                    break
        if found:
            length, who, motion, node, way = min(found, key=lambda option: option[:2])
            grant(who, Order(order="give way", path=path_of(motion), node=node), motion, way)
            if who == i:
                return
