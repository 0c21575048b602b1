"""ORGANIZE: how a master makes the targets of its group jointly feasible.

Source: Multi-SRT, paper section 2, "Coordination"; differs in: the paper leaves open how ORGANIZE
chooses. Here the targets of the largest total frontier length are kept, of those that can be
reached without conflict while all others stay where they are. The others get a new target, or
make a detour, or wait; and a robot that stands in another's way gives way.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Protocol

from multisrt.planners.motion.sweep import Sweep
from multisrt.planners.motion.trajectory import Trajectory
from multisrt.robots.knowledge import NodeId
from multisrt.robots.multi_srt.conflicts import Conflicts, Prospect
from multisrt.robots.multi_srt.messages import Order, path_of

MAX_EXACT = 12
"""Number of robots up to which the best set of targets is found by trying all sets; above, sets
are built greedily."""


def best_targets(conflicts: Conflicts) -> tuple[int, ...]:
    """Choose the targets that are jointly feasible and of the largest total frontier length.

    A robot may go to its target if its path conflicts with no path of the others that go, and with
    no body of those that stay. Of equal sets that one is taken whose robots have waited longest,
    so that a robot that gave way does not step back at once; then the larger set, then that of
    the lower numbers.

    Returns
    -------
    tuple of int
        Robots that may go, in rising order. The best set up to `MAX_EXACT` robots that could go;
        above, one built greedily, the longest frontier first.
    """
    prospects = conflicts.prospects
    free = [i for i in sorted(prospects) if prospects[i].moves and not conflicts.in_the_way(i)]
    foes: dict[int, set[int]] = {i: set() for i in free}
    for i, j in conflicts.pairs:
        if i in foes and j in foes:
            foes[i].add(j)
            foes[j].add(i)
    if len(free) > MAX_EXACT:
        chosen: list[int] = []
        for i in sorted(free, key=lambda i: (-prospects[i].frontier_m, -prospects[i].waited, i)):
            if not foes[i].intersection(chosen):
                chosen.append(i)
        return tuple(sorted(chosen))
    best: tuple[float, int, int, tuple[int, ...]] = (0.0, 0, 0, ())
    for size in range(1, len(free) + 1):
        for group in itertools.combinations(free, size):
            if any(foes[i].intersection(group) for i in group):
                continue
            total = math.fsum(prospects[i].frontier_m for i in group)
            waited = sum(prospects[i].waited for i in group)
            if (total, waited, size) > best[:3]:
                best = total, waited, size, group
    return best[3]


class Alternatives(Protocol):
    """A master's knowledge of other motions that the robots of its group could make."""

    def new_targets(self, robot: int) -> Iterator[Trajectory]:
        """Draw other targets for a robot, in the order in which they are to be tried."""

    def detours(
        self, robot: int, gap_m: float, prospects: Mapping[int, Prospect]
    ) -> Iterator[Trajectory]:
        """Find first steps of paths around the bodies in a robot's way, shortest first."""

    def motions_aside(
        self, robot: int, sweep: Sweep, gap_m: float, prospects: Mapping[int, Prospect]
    ) -> Iterator[tuple[float, Trajectory, NodeId | None]]:
        """Find where a robot could move out of another's path.

        Yields
        ------
        length_m : float
            Length of the path to there.
        motion : Trajectory
            Its first step.
        node : NodeId or None
            The node at the end of that step, if there is one.
        """

    def sweep(self, robot: int, motion: Trajectory) -> Sweep:
        """Return what a robot's body sweeps on a motion."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Arrangement:
    """The decision of ORGANIZE.

    Attributes
    ----------
    orders : dict of int to Order
        The order for every robot.
    targets : dict of int to (x, y)
        The position of every robot after the step, in metres.
    """

    orders: dict[int, Order]
    targets: dict[int, tuple[float, float]]

    @property
    def is_deadlock(self) -> bool:
        """Whether no robot can move."""
        return all(order.order == "wait" for order in self.orders.values())


def organize(conflicts: Conflicts, alternatives: Alternatives) -> Arrangement:
    """ORGANIZE: rearrange the targets of a group so that all can move at once.

    Parameters
    ----------
    conflicts : Conflicts
        The planned motions of the group, and their conflicts.
    alternatives : Alternatives
        Other motions.
    """
    prospects = conflicts.prospects
    grants = _Grants(conflicts, alternatives)
    for i in best_targets(conflicts):
        grants.grant(i, Order(order="keep"), prospects[i].motion, prospects[i].sweep)
    rest = [i for i in prospects if i not in grants.orders and prospects[i].moves]
    rest.sort(key=lambda i: (-prospects[i].frontier_m, i))
    for i in rest:
        if prospects[i].frontier_m > 0.0:
            grants.redirect(i, alternatives.new_targets(i))
    for i in rest:
        if i not in grants.orders and (standing := conflicts.in_the_way(i)):
            gap_m = max(conflicts.gap(i, j) for j in standing)
            grants.redirect(i, alternatives.detours(i, gap_m, prospects))
    for i in rest:
        if i not in grants.orders:
            grants.clear_the_way(i)
    for i in prospects:
        grants.orders.setdefault(i, Order(order="wait"))
    return Arrangement(orders=dict(sorted(grants.orders.items())), targets=grants.targets)


class _Grants:
    # What robots are allowed to do so far: their orders, what they sweep, and where they end.

    def __init__(self, conflicts: Conflicts, alternatives: Alternatives) -> None:
        self.orders: dict[int, Order] = {}
        self.targets = {
            i: (p.motion.start.x, p.motion.start.y) for i, p in conflicts.prospects.items()
        }
        self._sweeps = {i: prospect.body for i, prospect in conflicts.prospects.items()}
        self._conflicts = conflicts
        self._alternatives = alternatives

    def grant(self, i: int, order: Order, motion: Trajectory, sweep: Sweep) -> None:
        self.orders[i], self._sweeps[i] = order, sweep
        self.targets[i] = motion.end.x, motion.end.y

    def is_clear(self, i: int, sweep: Sweep) -> bool:
        # Of the paths of all others, which begin with their bodies where they stand.
        sweeps = self._sweeps
        return not any(self._conflicts.meet(i, sweep, j, sweeps[j]) for j in sweeps if j != i)

    def redirect(self, i: int, motions: Iterable[Trajectory]) -> None:
        # To the first of some places that the robot reaches without conflict.
        for motion in motions:
            sweep = self._alternatives.sweep(i, motion)
            if self.is_clear(i, sweep):
                return self.grant(i, Order(order="new target", path=path_of(motion)), motion, sweep)

    def clear_the_way(self, i: int) -> None:
        # Bodies stand in the way of i. Where two robots block one another, the one with the
        # shorter way aside gives way; a robot that only stands there does so in any case.
        conflicts, prospects = self._conflicts, self._conflicts.prospects
        for j in conflicts.in_the_way(i):
            if j in self.orders:
                continue
            pairs = [(j, i)]
            if prospects[j].moves and i in conflicts.in_the_way(j):
                pairs.append((i, j))
            found = [
                aside for pair in pairs if (aside := self._best_motion_aside(*pair)) is not None
            ]
            if found:
                _, giver, order, motion, sweep = min(found, key=lambda option: option[:2])
                self.grant(giver, order, motion, sweep)
                if giver == i:
                    return

    def _best_motion_aside(
        self, giver: int, other: int
    ) -> tuple[float, int, Order, Trajectory, Sweep] | None:
        # The shortest path on which a robot moves out of another's path: its length, and its order.
        prospects = self._conflicts.prospects
        gap_m = self._conflicts.gap(giver, other)
        options = self._alternatives.motions_aside(giver, prospects[other].sweep, gap_m, prospects)
        for length_m, motion, node in options:
            sweep = self._alternatives.sweep(giver, motion)
            if self.is_clear(giver, sweep):
                order = Order(order="give way", path=path_of(motion), node=node)
                return length_m, giver, order, motion, sweep
        return None
