"""Positions of robots towards frontiers, the criterion of MinPos."""

from __future__ import annotations

import numpy as np

from multisrt.geometry.numerics.arrays import FloatArray, IntArray


def positions(costs: FloatArray) -> IntArray:
    """Return each robot's position towards each frontier.

    Parameters
    ----------
    costs : (n, m) array
        Cost of each robot to each frontier in metres; ``inf`` where there is no path.

    Returns
    -------
    (n, m) array of int
        Number of robots that come before robot i at frontier j. Every column is a permutation of
        0 to n - 1.

    Notes
    -----
    Without ties this is the paper's P_ij, the number of robots k with C_kj < C_ij. Of robots
    equally far from a frontier the lower number comes first.

    Robots at the same place, whose costs are all equal, take turns: the first is in front at the
    nearest frontier of that place, the second at the next nearest, and so on, starting over where
    there are more robots than frontiers. They then spread evenly over the frontiers (the paper's
    criterion 1). The strict comparison alone would send all of them to the nearest frontier, and
    an order by number would put the same robot in front at every frontier.

    Cost: O(n m log(n m)). Source: A. Bautin, O. Simonin and F. Charpillet, Towards a communication
    free coordination for multi-robot exploration, section IV.C; differs in: ties.

    Examples
    --------
    >>> positions(np.array([[2.0, 18.0], [3.0, 17.0], [4.0, 16.0]])).tolist()
    [[0, 2], [1, 1], [2, 0]]

    Two robots at one place take turns:

    >>> positions(np.array([[2.0, 5.0], [2.0, 5.0]])).tolist()
    [[0, 1], [1, 0]]
    """
    robots, frontiers = costs.shape
    if not frontiers:
        return np.zeros((robots, 0), np.int64)
    first_there: dict[bytes, int] = {}
    counts: dict[int, int] = {}
    place = np.empty(robots, np.int64)
    number = np.empty(robots, np.int64)
    for i, row in enumerate(costs):
        place[i] = first_there.setdefault(row.tobytes(), i)
        number[i] = counts[int(place[i])] = counts.get(int(place[i]), -1) + 1

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
