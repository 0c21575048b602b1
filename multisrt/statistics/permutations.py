"""Exact distributions of sums of ranks, with ties.

Mean ranks of ties are multiples of a half. Doubled, all are integers, and the number of
arrangements that lead to each sum is counted by adding one rank after the other.

Source: Streitberg and Röhmel, Exact distributions for permutation and rank tests: an introduction
to some recently published algorithms, Statistical Software Newsletter 12, 1986.
"""

from __future__ import annotations

import numpy as np

from multisrt.geometry.numerics.arrays import FloatArray, IntArray

MAX_EXACT = 64
"""Number of values up to which arrangements are counted, in double precision.

Two samples of 32 are at this bound. Counts above 2^53 are rounded, which no p-value shows.
"""


def doubled_ranks(values: FloatArray) -> IntArray:
    """Return twice the ranks of values, from 2; ties have the mean of their ranks.

    Parameters
    ----------
    values : ndarray of float, shape (n,)
        Values, which may be infinite.

    Returns
    -------
    ndarray of int, shape (n,)
        The doubled ranks, in the order of the values.

    Examples
    --------
    >>> import numpy as np
    >>> doubled_ranks(np.array([0.5, np.inf, 0.5, 3.0]))
    array([3, 8, 3, 6])
    """
    ordered = np.sort(values)
    below = np.searchsorted(ordered, values, side="left")
    return np.asarray(below + np.searchsorted(ordered, values, side="right") + 1)


def ways_of_choosing(ranks: IntArray, chosen: int) -> FloatArray:
    """Return, at index s, the number of ways to choose `chosen` ranks with sum s.

    Parameters
    ----------
    ranks : ndarray of int, shape (n,)
        Positive integers.
    chosen : int
        Number of ranks that are chosen.

    Returns
    -------
    ndarray of float, shape (sum of ranks + 1,)
        Numbers of ways.

    Examples
    --------
    >>> import numpy as np
    >>> ways_of_choosing(np.array([1, 2, 3]), 2)
    array([0., 0., 0., 1., 1., 1., 0.])
    """
    ways = np.zeros((chosen + 1, int(ranks.sum()) + 1))
    ways[0, 0] = 1.0
    for rank in ranks:
        ways[1:, rank:] += ways[:-1, :-rank].copy()
    return np.asarray(ways[chosen])


def ways_of_signing(ranks: IntArray) -> FloatArray:
    """Return, at index s, the number of sign vectors whose positive ranks sum to s.

    Parameters
    ----------
    ranks : ndarray of int, shape (n,)
        Integers of at least 0.

    Returns
    -------
    ndarray of float, shape (sum of ranks + 1,)
        Numbers of sign vectors.

    Examples
    --------
    >>> import numpy as np
    >>> ways_of_signing(np.array([1, 1]))
    array([1., 2., 1.])
    """
    ways = np.zeros(int(ranks.sum()) + 1)
    ways[0] = 1.0
    for rank in ranks:
        ways[rank:] += ways[: ways.size - rank].copy()
    return ways


def two_sided(ways: FloatArray, seen: int) -> float:
    """Return twice the smaller probability of the two tails that include the observed sum.

    Parameters
    ----------
    ways : ndarray of float, shape (n,)
        Numbers of ways, or probabilities, of the sums from 0.
    seen : int
        The observed sum.

    Returns
    -------
    float
        The two-sided p-value, at most 1.
    """
    lighter = min(ways[: seen + 1].sum(), ways[seen:].sum())
    return float(min(1.0, 2.0 * lighter / ways.sum()))
