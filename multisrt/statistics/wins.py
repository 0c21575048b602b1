"""Comparison of every run of one set with every run of another."""

from __future__ import annotations

import numpy as np

from multisrt.geometry.numerics.arrays import FloatArray


def win_table(a: FloatArray, b: FloatArray) -> FloatArray:
    """Return whether each value of `a` is lower than each of `b`.

    Parameters
    ----------
    a, b : ndarray of float, shapes (n,) and (m,)
        Values of runs.

    Returns
    -------
    ndarray of float, shape (n, m)
        1 where `a` is lower, 0 where it is higher, 0.5 where they are equal.
    """
    lower = np.less.outer(a, b).astype(np.float64)
    return lower + 0.5 * np.equal.outer(a, b)


def share_of_wins(a: FloatArray, b: FloatArray) -> float:
    """Return the share of pairs in which the value of `a` is lower.

    Parameters
    ----------
    a, b : ndarray of float, shapes (n,) and (m,)
        Values of runs.

    Returns
    -------
    float
        The mean of `win_table`, from 0 to 1; ties count half.
    """
    return float(win_table(a, b).sum() / (a.size * b.size))
