"""Who is lower, run against run."""

from __future__ import annotations

import numpy as np

from multisrt.geometry.numerics.arrays import FloatArray


def win_table(a: FloatArray, b: FloatArray) -> FloatArray:
    """1 where the row's value of `a` is lower than the column's of `b`, 0 where higher, ½ ties."""
    lower = np.less.outer(a, b).astype(np.float64)
    return lower + 0.5 * np.equal.outer(a, b)


def share_of_wins(a: FloatArray, b: FloatArray) -> float:
    """Share of all couples of a run of `a` with one of `b` in which `a`'s is lower, ties half."""
    return float(win_table(a, b).sum() / (a.size * b.size))
