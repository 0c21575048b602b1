"""The search for places and routes from which a team sees enough in little time.

A greedy cover gives the first places (Chvátal, 1979): of all places that which shows most that is
new. Then places are removed and others inserted (large neighbourhood search, Shaw, 1998; ruin and
recreate, Schrimpf et al., 2000), while what is seen on the way counts, and routes are improved in
between. Changes for the worse are accepted by a temperature that falls (simulated annealing).
"""

from __future__ import annotations

import heapq
import math
import random
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from multisrt.geometry.numerics.kernel import FloatArray, IntArray
from multisrt.informed.team import Team
from multisrt.informed.views import Bits, count, numbers_in
from multisrt.planners.assignment.min_max_routes import Costs, improve, objective, route_times

HOT, COLD = 0.02, 0.0005
"""Temperature at the beginning and at the end, as a share of the first objective."""

MAX_REMOVED = 6
"""Maximum number of places that are removed at once, and a quarter of all."""

MAX_CHOICES = 64
"""Maximum number of places that are weighed to see one cell."""

INSERTED_WEIGHT = 0.3
"""Weight of the time of a robot beside the largest, when a place is inserted."""

Routes = tuple[tuple[int, ...], ...]
"""For each robot its places in order."""

Progress = Callable[[float], None]
"""Called with the share of the search that is done."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Solution:
    """Routes and what they cost.

    Attributes
    ----------
    routes : tuple of tuple of int
        For each robot the places of the team that it visits, in order.
    times_s : tuple of float
        The time of each route, in seconds.
    cost : float
        What the search minimises.
    seen : Bits
        The cells that are seen.
    """

    routes: Routes
    times_s: tuple[float, ...]
    cost: float
    seen: Bits


class Search:
    """A search for routes.

    Parameters
    ----------
    team : Team
        The robots and places.
    at_start : Bits
        The cells that are seen from the starts.
    target : int
        Number of cells to see.
    seed : int
        Seed of the search; equal seeds give equal routes.
    """

    def __init__(self, team: Team, at_start: Bits, target: int, seed: int) -> None:
        self._team = team
        self._target = target
        self._rng = random.Random(seed)
        self._at_start = at_start
        self._everything = team.cells.all()

    def run(self, iterations: int, progress: Progress | None = None) -> Solution:
        """Return the best routes found.

        Parameters
        ----------
        iterations : int
            How often routes are changed.
        progress : callable, optional
            Called with the share that is done.
        """
        first = self._dropped(self._in_order(self._cover()))
        best = now = first
        rng = self._rng
        for step in range(iterations):
            if progress is not None and step % 8 == 0:
                progress(step / iterations)
            if best.cost <= 0.0:
                break
            found = self._changed(now)
            share = step / iterations
            heat = first.cost * HOT * (COLD / HOT) ** share
            if found is None or found.cost > now.cost - heat * math.log(1.0 - rng.random()):
                continue
            now = found
            if now.cost < best.cost - 1e-9:
                now = self._dropped(now)
                best = now
        return best

    # Where to look ----------------------------------------------------------------------

    def _cover(self) -> list[int]:
        # Lazy greedy cover: what a place adds never grows, so old values are bounds.
        seen = self._at_start.copy()
        views = self._team.views
        heap = [(-int(n), p) for p, n in enumerate(np.bitwise_count(views).sum(axis=1))]
        heapq.heapify(heap)
        chosen: list[int] = []
        have = count(seen)
        while have < self._target and heap:
            _, place = heapq.heappop(heap)
            new = count(views[place] & ~seen)
            if new == 0:
                continue
            if heap and new < -heap[0][0]:
                heapq.heappush(heap, (-new, place))
                continue
            chosen.append(place)
            seen |= views[place]
            have += new
        return chosen

    def _in_order(self, places: Sequence[int]) -> Solution:
        # The farthest first, each where it costs least.
        routes: list[list[int]] = [[] for _ in self._team.members]
        every = np.arange(len(self._team.places))
        far = np.min([self._team.distances(r, -1, every) for r in range(len(routes))], axis=0)
        for place in sorted(places, key=lambda p: (-float(far[p]), p)):
            self._insert(routes, np.array([place]), np.zeros(1))
        return self._improved(routes)

    def _improved(self, routes: Sequence[Sequence[int]]) -> Solution:
        places = [place for route in routes for place in route]
        costs = self._team.costs(places)
        arrays, sizes = _arrays(routes, len(places))
        arrays, sizes = improve(arrays, sizes, costs)
        return self._solution(places, arrays, sizes, costs)

    def _evaluated(self, routes: Sequence[Sequence[int]]) -> Solution:
        places = [place for route in routes for place in route]
        arrays, sizes = _arrays(routes, len(places))
        return self._solution(places, arrays, sizes, self._team.costs(places))

    def _solution(
        self, places: Sequence[int], arrays: IntArray, sizes: IntArray, costs: Costs
    ) -> Solution:
        times = route_times(arrays, sizes, costs)
        routes = tuple(
            tuple(places[k] for k in row[1:size])
            for row, size in zip(arrays.tolist(), sizes.tolist(), strict=True)
        )
        return Solution(
            routes=routes,
            times_s=tuple(times.tolist()),
            cost=float(objective(times)),
            seen=self._seen(routes),
        )

    def _seen(self, routes: Sequence[Sequence[int]]) -> Bits:
        seen = self._at_start.copy()
        for robot, route in enumerate(routes):
            for a, b in zip((-1, *route), route, strict=False):
                seen |= self._team.seen_on_leg(robot, a, b)
        return seen

    def _sees_enough(self, solution: Solution) -> bool:
        return count(solution.seen) >= self._target

    # Changes ----------------------------------------------------------------------------

    def _changed(self, now: Solution) -> Solution | None:
        routes = self._ruined(now)
        if self._rng.random() < 0.3:
            routes = [list(route) for route in self._improved(routes).routes]
        if not self._repair(routes):
            return None
        found = self._improved(routes)
        if not self._sees_enough(found):
            # The routes in a better order pass by other places.
            again = [list(route) for route in found.routes]
            if not self._repair(again):
                return None
            found = self._evaluated(again)
            if not self._sees_enough(found):
                return None
        return found

    def _ruined(self, now: Solution) -> list[list[int]]:
        rng, routes = self._rng, [list(route) for route in now.routes]
        places = [place for route in routes for place in route]
        if not places:
            return routes
        many = rng.randint(1, max(1, min(MAX_REMOVED, len(places) // 4)))
        longest = max(range(len(routes)), key=lambda r: now.times_s[r])
        chance = rng.random()
        if chance < 0.35:
            gone = set(rng.sample(places, min(many, len(places))))
        elif chance < 0.65 and routes[longest]:
            # A stretch of the route that takes longest.
            route = routes[longest]
            begin = rng.randrange(len(route))
            gone = set(route[begin : begin + many])
        else:
            # Neighbours of a place, on any route.
            pool = routes[longest] if routes[longest] and rng.random() < 0.5 else places
            x, y = self._team.places[rng.choice(pool)].tolist()
            where = self._team.places[places]
            near = np.argsort(np.hypot(where[:, 0] - x, where[:, 1] - y), kind="stable")[:many]
            gone = {places[k] for k in near.tolist()}
        return [[place for place in route if place not in gone] for route in routes]

    def _repair(self, routes: list[list[int]]) -> bool:
        # Insert places until enough is seen, in place; return whether it is.
        rng, team = self._rng, self._team
        second_per_cell = self._second_per_cell(routes)
        seen, is_exact = self._seen(routes), True
        for _ in range(2 * MAX_REMOVED + 4):
            lacking = self._target - count(seen)
            if lacking <= 0 and not is_exact:
                # Of the legs that were replaced, some cells may be seen no more.
                seen, is_exact = self._seen(routes), True
                lacking = self._target - count(seen)
            if lacking <= 0:
                return True
            missing = numbers_in(self._everything & ~seen)
            cell = int(missing[rng.randrange(len(missing))])
            word, bit = cell >> 6, np.uint64(cell & 63)
            able = np.flatnonzero((team.views[:, word] >> bit) & np.uint64(1))
            if not len(able):
                continue
            if len(able) > MAX_CHOICES:
                stride = len(able) // MAX_CHOICES + 1
                able = able[rng.randrange(stride) :: stride]
            new = np.bitwise_count(team.views[able] & ~seen).sum(axis=1).astype(np.float64)
            # What is seen beyond need is worth nothing.
            worth = rng.uniform(0.0, 1.5) * second_per_cell
            robot, position = self._insert(routes, able, worth * np.minimum(new, lacking))
            if robot >= 0:
                route = (-1, *routes[robot])
                for a, b in pairwise(route[position : position + 3]):
                    seen = seen | team.seen_on_leg(robot, a, b)
                is_exact = False
        return self._target <= count(self._seen(routes))

    def _second_per_cell(self, routes: Sequence[Sequence[int]]) -> float:
        speed = max(member.kinematics.speed_m_s for member in self._team.members)
        length = 0.0
        for robot, route in enumerate(routes):
            for a, b in zip((-1, *route), route, strict=False):
                length += float(self._team.distances(robot, a, np.array([b]))[0])
        return max(length, 1.0) / speed / self._team.cells.count

    def _insert(
        self, routes: list[list[int]], able: IntArray, bonus: FloatArray
    ) -> tuple[int, int]:
        # Insert one of some places where it costs least, by lengths, less a bonus for each; return
        # the robot and the position in its route, or -1 if no robot gets there.
        team = self._team
        times = np.zeros(len(routes))
        added: list[tuple[int, int, FloatArray]] = []
        for robot, route in enumerate(routes):
            speed = team.members[robot].kinematics.speed_m_s
            # Columns: the places that may be inserted, and those of the route.
            columns = np.concatenate((able, np.array(route, np.int64)))
            rows = [team.distances(robot, place, columns) for place in (-1, *route)]
            for k, row in enumerate(rows):
                more, leg = row[: len(able)], 0.0
                if k < len(route):
                    leg = float(row[len(able) + k])
                    more = more + rows[k + 1][: len(able)] - leg
                elif team.home:
                    leg = float(rows[0][-1]) if route else 0.0
                    more = more + rows[0][: len(able)] - leg
                times[robot] += leg / speed
                added.append((robot, k, more / speed))
        value = np.empty((len(added), len(able)))
        for k, (robot, _, more) in enumerate(added):
            others = float(np.delete(times, robot).max(initial=0.0))
            largest = np.maximum(others, times[robot] + more)
            value[k] = largest + INSERTED_WEIGHT * more - bonus
        k, place = divmod(int(np.argmin(value)), len(able))
        if not math.isfinite(float(value[k, place])):
            return -1, -1
        robot, position, _ = added[k]
        routes[robot].insert(position, int(able[place]))
        return robot, position

    def _dropped(self, solution: Solution) -> Solution:
        # Leave out every place without which enough is seen, the last of each route first.
        for robot in range(len(solution.routes)):
            for position in reversed(range(len(solution.routes[robot]))):
                routes = [list(route) for route in solution.routes]
                del routes[robot][position]
                if count(self._seen(routes)) >= self._target:
                    found = self._evaluated(routes)
                    if found.cost <= solution.cost:
                        solution = found
        better = self._improved(solution.routes)
        if better.cost < solution.cost and self._sees_enough(better):
            return better
        return solution


def _arrays(routes: Sequence[Sequence[int]], places: int) -> tuple[IntArray, IntArray]:
    # Routes as `min_max_routes.improve` takes them: places are numbered in the order of the routes.
    arrays = np.full((len(routes), places + 1), -1, np.int64)
    sizes = np.ones(len(routes), np.int64)
    number = 0
    for robot, route in enumerate(routes):
        arrays[robot, 0] = places + robot
        for k in range(len(route)):
            arrays[robot, k + 1] = number
            number += 1
        sizes[robot] += len(route)
    return arrays, sizes
