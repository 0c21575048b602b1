"""MINPOS: a robot goes to the frontier for which the fewest robots are nearer than itself."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from multisrt.geometry.numerics.arrays import FloatArray, IntArray
from multisrt.planners.assignment.costs import check_robot, cost_table


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class MinPosChoice:
    """One robot's choice, and the table of positions that it rests on.

    Attributes
    ----------
    costs : (n, m) array
        The table decided on, in metres.
    ranks : tuple of rows
        Each robot's position towards each frontier: how many robots come before it.
    choice : int or None
        The frontier; None: the robot can reach none.
    """

    costs: FloatArray
    ranks: tuple[tuple[int, ...], ...]
    choice: int | None


def minpos(costs: ArrayLike, robot: int) -> MinPosChoice:
    """Choose the frontier towards which one robot is in the best position.

    Parameters
    ----------
    costs : (n, m) array
        Distance of each robot to each frontier in metres; ``inf`` where there is no way.
    robot : int
        The row of the robot that chooses.

    Returns
    -------
    MinPosChoice

    Raises
    ------
    InvalidInputError
        If `costs` is not a table of distances, or `robot` no row of it.

    Notes
    -----
    The lowest rank wins, among equal ranks the nearest frontier, then the lowest index. Ranks
    are those of `positions`. Cost: O(n m log n) for the ranks of all robots.

    Source: A. Bautin, O. Simonin and F. Charpillet, Towards a communication free coordination
    for multi-robot exploration, Algorithm 3; differs in: ties, see `positions`.

    Examples
    --------
    A robot between a companion and two frontiers leaves the nearer one to the companion:

    >>> minpos([[3.0, 4.0], [1.0, 6.0]], 0).choice
    1
    """
    table = cost_table(costs)
    check_robot(robot, len(table))
    ranks = positions(table)
    reachable = np.flatnonzero(np.isfinite(table[robot]))
    choice = None
    if len(reachable):
        row, distances = ranks[robot, reachable], table[robot, reachable]
        choice = int(reachable[np.lexsort((distances, row))[0]])
    return MinPosChoice(costs=table, ranks=tuple(map(tuple, ranks.tolist())), choice=choice)


def positions(costs: FloatArray) -> IntArray:
    """Count for every robot and frontier the robots that come before it there.

    Parameters
    ----------
    costs : (n, m) array
        As `cost_table` gives it.

    Returns
    -------
    (n, m) array of int; each column holds 0 to n - 1 once each

    Notes
    -----
    P_ij of the paper, the number of robots k with C_kj < C_ij, with its ties broken; where no
    distances are equal it is the paper's. Of robots equally far from a frontier the lower id
    comes first.

    That alone would not part robots that are at one place, which the paper's strict comparison
    sends all to the same frontier: whoever is behind is behind everywhere, and so chooses by
    distance as the one in front does. Robots whose distances are all equal therefore take turns:
    at their nearest frontier the first by id is in front, at the next nearest the second, and
    so on, over and over when there are more robots than frontiers. On their own they then
    spread evenly, the first to the nearest frontier, and a frontier has at most one robot more
    than another (the paper's criterion 1, and what its Figure 6 shows for robots close together).
    """
    robots, frontiers = costs.shape
    if not frontiers:
        return np.zeros((robots, 0), np.int64)
    first_there: dict[bytes, int] = {}
    at_place: dict[int, int] = {}
    place = np.empty(robots, np.int64)
    number = np.empty(robots, np.int64)
    for i, row in enumerate(costs):
        place[i] = first_there.setdefault(row.tobytes(), i)
        number[i] = at_place[int(place[i])] = at_place.get(int(place[i]), -1) + 1

    # Robot r of a place is in front at the place's frontiers r, r + m, ... in order of distance.
    order = np.argsort(costs, axis=1, kind="stable")
    nearness = np.argsort(order, axis=1, kind="stable")
    within_reach = np.maximum(np.isfinite(costs).sum(axis=1), 1)
    turn = (number[:, None] - nearness) % within_reach[:, None]

    shape = costs.shape
    keys = (
        np.broadcast_to(number[:, None], shape),
        turn,
        np.broadcast_to(place[:, None], shape),
        costs,
    )
    in_order = np.lexsort(keys, axis=0)
    ranks = np.empty(shape, np.int64)
    np.put_along_axis(ranks, in_order, np.arange(robots)[:, None], axis=0)
    return ranks
