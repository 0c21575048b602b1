"""Lower bound of the total path length of robots that visit regions far from each other.

**Theorem.** Let the robots' paths begin at a common point, the root, and come into each of n
regions, but for some that are left out, whose amounts sum to at most `spare`. Let d(i, j) bound
from below the path between regions i and j, and d(i) that from the root to region i. Cut each path
where it first comes into a region that no path has entered before it in the order of robots and
time: it has at least the sum of d over consecutive regions. So the paths of the team are at least
as long as a spanning tree in which the root has at most as many branches as there are robots and
no region more than two neighbours, while each region left out hangs at the root by an edge of
its own.

For a price p >= 0 of an amount and penalties u >= 0, give the edge (i, j) the weight
d(i, j) + u(i) + u(j), the edge from the root d(i) + u(i) + u(root), and that of a region left out
p a(i) + 2 u(i). The tree above weighs at most the length of the paths, p times the spare amount,
2 u(i) for each region and u(root) for each robot. A minimum spanning tree weighs no more. Hence
the length is at least the weight of a minimum spanning tree less p times the spare amount, the
sum of 2 u(i), and u(root) for each robot; for any price and penalties. Subgradient steps, which
raise the penalty of a region with too many neighbours and lower that of one with too few, look
for good ones. No triangle inequality is used: d need not have it, as paths within a region are
free.

Source: M. Held and R. M. Karp, The traveling-salesman problem and minimum spanning trees,
Operations Research 18 (1970); differs in: open paths of a team, regions left out at a price.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from multisrt.geometry.numerics.kernel import BoolArray, FloatArray, IntArray, kernel

MIN_GAIN_M = 1e-6
"""Minimum gain of the bound for which a region is added or dropped, in metres."""


class Service(NamedTuple):
    """Regions to be served, and by how many robots.

    Attributes
    ----------
    between : (n, n) array
        Lower bounds of the paths between them in metres; symmetric.
    start : (n,) array
        Those from the root.
    amounts : (n,) array
        Weight of each region if it is left out; positive.
    spare : float
        How much may be left out.
    price : float
        Price in metres of a unit of it, at least 0.
    robots : int
        Number of robots.
    """

    between: FloatArray
    start: FloatArray
    amounts: FloatArray
    spare: float
    price: float
    robots: int


@kernel
def min_total_length(service: Service, chosen: IntArray, rounds: int) -> float:
    """Return a lower bound of the total length of the paths that serve some regions, in metres.

    Parameters
    ----------
    service : Service
        The regions and robots.
    chosen : (k,) array of int
        The regions that count.
    rounds : int
        Number of subgradient steps.

    Returns
    -------
    float
        The best bound of all steps, at least 0.

    Examples
    --------
    Two regions on either side of the root, 3 and 4 m away: one robot passes the root again.

    >>> between, start = np.array([[0.0, 7.0], [7.0, 0.0]]), np.array([3.0, 4.0])
    >>> service = Service(between, start, np.ones(2), 0.0, 100.0, 1)
    >>> round(min_total_length(service, np.arange(2), 200), 1)
    10.0
    >>> round(min_total_length(service._replace(robots=2), np.arange(2), 200), 1)
    7.0

    If one of them may be left out, at best the nearer one is served:

    >>> round(min_total_length(service._replace(spare=1.0, price=4.0), np.arange(2), 200), 1)
    3.0
    """
    between, start, amounts, spare, price, robots = service
    n = chosen.shape[0]
    best = 0.0
    penalty, root_penalty, step = np.zeros(n), 0.0, 0.0
    key = np.empty(n)
    parent, degree = np.empty(n, np.int64), np.empty(n, np.int64)
    is_left_out, is_done = np.empty(n, np.bool_), np.empty(n, np.bool_)
    for number in range(rounds):
        for i in range(n):
            key[i] = start[chosen[i]] + root_penalty + penalty[i]
            toll = price * amounts[chosen[i]] + 2.0 * penalty[i]
            is_left_out[i] = toll < key[i]
            key[i] = min(key[i], toll)
            parent[i], degree[i], is_done[i] = -1, 0, False
        weight, root_degree = 0.0, 0
        # Prim's algorithm.
        for _ in range(n):
            k = -1
            for i in range(n):
                if not is_done[i] and (k < 0 or key[i] < key[k]):
                    k = i
            is_done[k] = True
            weight += key[k]
            degree[k] += 1
            if parent[k] >= 0:
                degree[parent[k]] += 1
            elif is_left_out[k]:
                degree[k] += 1
            else:
                root_degree += 1
            for i in range(n):
                through = between[chosen[k], chosen[i]] + penalty[k] + penalty[i]
                if not is_done[i] and through < key[i]:
                    key[i], parent[i] = through, k
        length = weight - 2.0 * penalty.sum() - robots * root_penalty - price * spare
        best = max(best, length)
        if number == 0:
            step = 0.5 * weight / max(1, n)
        size = step * (1.0 - number / rounds) ** 2
        for i in range(n):
            penalty[i] = max(0.0, penalty[i] + size * (degree[i] - 2))
        root_penalty = max(0.0, root_penalty + size * (root_degree - robots))
    return best


@kernel
def chosen_regions(service: Service, chosen: BoolArray, rounds: int) -> IntArray:
    """Return regions for which the bound is good: more of them may bound less.

    From those given, one after the other is taken in or dropped, the best one first, while the
    bound gets better.

    Parameters
    ----------
    service : Service
        The regions and robots.
    chosen : (n,) array of bool
        Those to begin with.
    rounds : int
        Number of subgradient steps for each attempt.
    """
    now = chosen.copy()
    best = min_total_length(service, np.flatnonzero(now), rounds)
    while True:
        change = -1
        for i in range(now.shape[0]):
            now[i] = not now[i]
            length = min_total_length(service, np.flatnonzero(now), rounds)
            now[i] = not now[i]
            if length > best + MIN_GAIN_M:
                best, change = length, i
        if change < 0:
            return np.flatnonzero(now)
        now[change] = not now[change]
