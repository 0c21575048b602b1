"""Prospective motions of a group of robots, and which of them conflict.

Source: Multi-SRT, paper section 2, "GER path feasibility check". Differs in: in the paper paths
conflict that intersect; here motions on which the bodies come nearer to one another than the
protective stop allows (`planned_gap`).
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

from multisrt.geometry.bodies.footprint import Footprint
from multisrt.planners.motion.sweep import SAGITTA_M, Sweep
from multisrt.planners.motion.trajectory import Trajectory
from multisrt.robots.protective_stop import conflict, max_gap, planned_gap


@dataclass(frozen=True, kw_only=True, eq=False)
class Prospect:
    """The plan of a robot for this step.

    Attributes
    ----------
    robot : int
        Its number.
    footprint : Footprint
        Its body.
    motion : Trajectory
        Its planned motion; a single waypoint if it stays.
    frontier_m : float
        Length in metres of the local frontier that it goes for.
    waited : int
        How many times in a row it had to wait.
    """

    robot: int
    footprint: Footprint
    motion: Trajectory
    frontier_m: float
    waited: int = 0

    @cached_property
    def body(self) -> Sweep:
        """Area that its body covers where it stands."""
        return Sweep(self.footprint, Trajectory(self.motion.waypoints[:1]))

    @cached_property
    def sweep(self) -> Sweep:
        """Area that its body sweeps on the way; the body, if it stays."""
        return Sweep(self.footprint, self.motion) if self.moves else self.body

    @cached_property
    def bounds(self) -> tuple[float, float, float, float]:
        """Minimum x and y, maximum x and y that its body may come to on the way, in metres."""
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
        """Position at the end of its motion."""
        end = self.motion.end
        return end.x, end.y


class Conflicts:
    """Which motions of a group conflict: come nearer than the protective stop allows.

    Parameters
    ----------
    prospects : dict of int to Prospect
        The planned motions, by robot.
    guard_m : float
        Guard distance of the protective stop, in metres.

    Attributes
    ----------
    pairs : tuple of (int, int)
        Pairs of robots whose planned motions conflict, the lower number first.
    """

    def __init__(self, prospects: Mapping[int, Prospect], guard_m: float) -> None:
        self.prospects = prospects
        self.guard_m = guard_m
        numbers = sorted(prospects)
        self.pairs = tuple(
            (i, j)
            for i, j in itertools.combinations(numbers, 2)
            if self._may_meet(prospects[i], prospects[j])
            and self.meet(i, prospects[i].sweep, j, prospects[j].sweep)
        )

    def _may_meet(self, a: Prospect, b: Prospect) -> bool:
        # Most robots are far apart: bounding boxes rule them out before their paths are compared.
        gap = max_gap(self.guard_m)
        (ax0, ay0, ax1, ay1), (bx0, by0, bx1, by1) = a.bounds, b.bounds
        return max(ax0 - bx1, bx0 - ax1) < gap and max(ay0 - by1, by0 - ay1) < gap

    def gap(self, i: int, j: int) -> float:
        """Return the distance in metres that the paths of two robots have to keep."""
        apart_m = self.prospects[i].body.distance_to(self.prospects[j].body)
        return planned_gap(apart_m, self.guard_m)

    def meet(self, i: int, sweep_i: Sweep, j: int, sweep_j: Sweep) -> bool:
        """Return whether paths of two robots conflict; those that both stay never do."""
        body_i, body_j = self.prospects[i].body, self.prospects[j].body
        if sweep_i is body_i and sweep_j is body_j:
            return False
        return conflict(sweep_i, body_i, sweep_j, body_j, self.guard_m)

    def in_the_way(self, i: int) -> list[int]:
        """Return the robots whose bodies stand in the planned path of one."""
        sweep = self.prospects[i].sweep
        return [
            j
            for j in sorted(self.prospects)
            if j != i and self.meet(i, sweep, j, self.prospects[j].body)
        ]
