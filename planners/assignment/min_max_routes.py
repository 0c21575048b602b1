"""Min-max routing: places divided among robots and ordered to minimise the makespan.

This is a min-max multiple travelling salesman problem. The cost of a route is its time: that of its
legs and of the turns between them. As robots may drive backwards, a turn from one line to another
is at most a right angle, and only the lines of headings count. So the time inside a reversed
segment stays the same, and a move is evaluated from a few places around it.

2-opt reverses segments, Or-opt moves them, and 2-opt* exchanges the tails of two routes. Each move
has to reduce the objective: the largest time of all robots plus a tenth of the mean.

Source: Lin and Kernighan (1973), Or (1976), and Potvin and Rousseau (1995) for the moves. Differs
in: the objective.
"""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np

from multisrt.geometry.numerics.kernel import FloatArray, IntArray, kernel

MEAN_WEIGHT: Final = 0.1
"""Weight of the mean time of all robots against the largest."""

MAX_SEGMENT: Final = 4
"""Maximum number of consecutive places that are moved together."""

MIN_GAIN_S: Final = 1e-7
"""Minimum decrease by a move, in seconds: less is rounding."""

MAX_PASSES: Final = 60
"""Maximum number of passes of the local search."""


class Costs(NamedTuple):
    """Costs of legs between m places and the starts of n robots, as the kernel takes them.

    Attributes
    ----------
    time_s : (kinds, m + n, m + n) array
        Time of each leg without the turns at its ends; inf where there is no path. Robot r starts
        at index m + r.
    angle : (kinds, m + n, m + n) array
        Angle of the line along which the leg from i to j leaves i, in radians within [0, pi).
    turn_s : (kinds,) array
        Time of a turn by one radian; 0 for a body that need not turn.
    kind : (n,) array of int
        The kind of each robot.
    heading : (n,) array
        Angle of the line that each robot faces at its start.
    home : bool
        Whether routes lead back to their start.
    """

    time_s: FloatArray
    angle: FloatArray
    turn_s: FloatArray
    kind: IntArray
    heading: FloatArray
    home: bool


@kernel
def route_times(routes: IntArray, sizes: IntArray, costs: Costs) -> FloatArray:
    """Return the time of each route in seconds.

    Parameters
    ----------
    routes : (n, capacity) array of int
        For each robot the index of its start, and those of its places in order.
    sizes : (n,) array of int
        Number of entries of each row that are used.
    costs : Costs
        Costs of the legs.
    """
    times = np.zeros(len(sizes))
    for r in range(len(sizes)):
        times[r] = _route_time(routes[r], sizes[r], r, costs)
    return times


@kernel
def objective(times: FloatArray) -> float:
    """Return the objective: the largest time plus `MEAN_WEIGHT` times the mean, in seconds."""
    value: float = times.max() + MEAN_WEIGHT * times.mean()
    return value


@kernel
def improve(routes: IntArray, sizes: IntArray, costs: Costs) -> tuple[IntArray, IntArray]:
    """Return routes that no move of 2-opt, Or-opt or 2-opt* improves.

    Parameters
    ----------
    routes, sizes, costs
        As for `route_times`. The capacity must suffice for all places in one route.

    Notes
    -----
    The search ends after `MAX_PASSES` passes in any case.
    """
    routes, sizes = routes.copy(), sizes.copy()
    times = route_times(routes, sizes, costs)
    for _ in range(MAX_PASSES):
        better = _reverse(routes, sizes, times, costs)
        better = _move(routes, sizes, times, costs) or better
        better = _swap_tails(routes, sizes, times, costs) or better
        if not better:
            break
    return routes, sizes


@kernel
def insert(route: IntArray, size: int, position: int, place: int) -> None:
    """Insert a place into a route, in place."""
    for k in range(size, position, -1):
        route[k] = route[k - 1]
    route[position] = place


@kernel
def _route_time(route: IntArray, size: int, robot: int, costs: Costs) -> float:
    chain = np.empty(size + 1, np.int64)
    chain[:size] = route[:size]
    length = size
    if costs.home and size > 1:
        chain[size] = route[0]
        length += 1
    return _chain_time(chain, length, robot, costs)


@kernel
def _chain_time(chain: IntArray, size: int, robot: int, costs: Costs) -> float:
    # The time of some consecutive places of a route: all legs, and the turns between them. That
    # at the first place is included if it is the start.
    kind = costs.kind[robot]
    time, angle, turn_s = costs.time_s[kind], costs.angle[kind], costs.turn_s[kind]
    total = 0.0
    for k in range(size - 1):
        total += time[chain[k], chain[k + 1]]
        if turn_s > 0.0:
            ahead = angle[chain[k], chain[k + 1]]
            if k > 0:
                total += turn_s * _turn(angle[chain[k], chain[k - 1]], ahead)
            elif chain[0] >= time.shape[0] - len(costs.kind):
                total += turn_s * _turn(costs.heading[robot], ahead)
    return total


@kernel
def _turn(a: float, b: float) -> float:
    # The angle between two lines, at most a right angle.
    turn = abs(a - b)
    return min(turn, np.pi - turn)


@kernel
def _at(route: IntArray, size: int, position: int, home: bool) -> int:
    # The place at a position of a route; -1 before and after.
    place = -1
    if 0 <= position < size:
        place = route[position]
    elif home and position == size and size > 1:
        place = route[0]
    return place


@kernel
def _window(
    route: IntArray, size: int, first: int, last: int, chain: IntArray, costs: Costs
) -> int:
    # Copy the places from one position to another, as far as there are; return how many.
    count = 0
    for position in range(first, last + 1):
        place = _at(route, size, position, costs.home)
        if place >= 0:
            chain[count] = place
            count += 1
    return count


@kernel
def _reverse(routes: IntArray, sizes: IntArray, times: FloatArray, costs: Costs) -> bool:
    # 2-opt within routes. The time inside a reversed segment stays the same.
    chain = np.empty(8, np.int64)
    found = False
    for r in range(len(sizes)):
        route, size = routes[r], sizes[r]
        for i in range(1, size):
            for j in range(i + 1, size):
                count = _window(route, size, i - 2, i + 1, chain, costs)
                old = _chain_time(chain, count, r, costs)
                count = _window(route, size, j - 1, j + 2, chain, costs)
                old += _chain_time(chain, count, r, costs)
                count = _window(route, size, i - 2, i - 1, chain, costs)
                chain[count], chain[count + 1] = route[j], route[j - 1]
                new = _chain_time(chain, count + 2, r, costs)
                chain[0], chain[1] = route[i + 1], route[i]
                count = 2
                for position in (j + 1, j + 2):
                    place = _at(route, size, position, costs.home)
                    if place >= 0:
                        chain[count] = place
                        count += 1
                new += _chain_time(chain, count, r, costs)
                if new < old - MIN_GAIN_S:
                    route[i : j + 1] = route[i : j + 1][::-1].copy()
                    times[r] = _route_time(route, size, r, costs)
                    found = True
    return found


@kernel
def _move(routes: IntArray, sizes: IntArray, times: FloatArray, costs: Costs) -> bool:
    # Or-opt: move each short segment to its best position in its own or another route.
    found = False
    rest, trial = np.empty_like(routes[0]), times.copy()
    chain = np.empty(MAX_SEGMENT + 8, np.int64)
    for r in range(len(sizes)):
        first = 1
        while first < sizes[r]:
            best = objective(times) - MIN_GAIN_S
            to, where, length, backwards = -1, 0, 0, False
            for many in range(1, min(MAX_SEGMENT, sizes[r] - first) + 1):
                left = sizes[r] - many
                rest[:first] = routes[r, :first]
                rest[first:left] = routes[r, first + many : sizes[r]]
                without = _route_time(rest, left, r, costs)
                for s in range(len(sizes)):
                    target = rest if s == r else routes[s]
                    size = left if s == r else sizes[s]
                    before = without if s == r else times[s]
                    for position in range(1, size + 1):
                        count = _window(target, size, position - 2, position + 1, chain, costs)
                        old = _chain_time(chain, count, s, costs)
                        for turned in range(2):
                            head = _window(target, size, position - 2, position - 1, chain, costs)
                            for k in range(many):
                                step = many - 1 - k if turned else k
                                chain[head + k] = routes[r, first + step]
                            count = head + many
                            if costs.home and position == size:
                                chain[count] = target[0]
                                count += 1
                            else:
                                for ahead in (position, position + 1):
                                    place = _at(target, size, ahead, costs.home)
                                    if place >= 0:
                                        chain[count] = place
                                        count += 1
                            after = before + _chain_time(chain, count, s, costs) - old
                            trial[:] = times
                            trial[r] = without
                            trial[s] = after
                            value = objective(trial)
                            if value < best:
                                best, to, where = value, s, position
                                length, backwards = many, turned == 1
            if to < 0:
                first += 1
                continue
            segment = routes[r, first : first + length].copy()
            if backwards:
                segment = segment[::-1].copy()
            routes[r, first : sizes[r] - length] = routes[r, first + length : sizes[r]].copy()
            sizes[r] -= length
            for k in range(length):
                insert(routes[to], sizes[to], where + k, segment[k])
                sizes[to] += 1
            times[r] = _route_time(routes[r], sizes[r], r, costs)
            times[to] = _route_time(routes[to], sizes[to], to, costs)
            found = True
    return found


@kernel
def _swap_tails(routes: IntArray, sizes: IntArray, times: FloatArray, costs: Costs) -> bool:
    # 2-opt*: two routes exchange what follows a position of each.
    found = False
    one, two = np.empty_like(routes[0]), np.empty_like(routes[0])
    trial = times.copy()
    for r in range(len(sizes)):
        for s in range(r + 1, len(sizes)):
            i = 1
            while i <= sizes[r]:
                j = 1
                while j <= sizes[s]:
                    size_r, size_s = i + sizes[s] - j, j + sizes[r] - i
                    one[:i] = routes[r, :i]
                    one[i:size_r] = routes[s, j : sizes[s]]
                    two[:j] = routes[s, :j]
                    two[j:size_s] = routes[r, i : sizes[r]]
                    trial[:] = times
                    trial[r] = _route_time(one, size_r, r, costs)
                    trial[s] = _route_time(two, size_s, s, costs)
                    if objective(trial) < objective(times) - MIN_GAIN_S:
                        routes[r, :size_r], routes[s, :size_s] = one[:size_r], two[:size_s]
                        sizes[r], sizes[s] = size_r, size_s
                        times[r], times[s] = trial[r], trial[s]
                        found = True
                    j += 1
                i += 1
    return found
