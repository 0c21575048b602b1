"""The probability that one strategy does better than another."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from multisrt.geometry.errors import InvalidInputError
from multisrt.statistics.intervals import (
    LEVEL,
    RESAMPLES,
    Interval,
    drawn_counts,
    interval_around,
    wilson,
)
from multisrt.statistics.samples import checked_resamples, strata_of
from multisrt.statistics.wins import win_table


def probability_of_improvement(
    a_by_stratum: Sequence[ArrayLike],
    b_by_stratum: Sequence[ArrayLike],
    *,
    lower_is_better: bool = True,
    level: float = LEVEL,
    resamples: int = RESAMPLES,
    rng: np.random.Generator | int,
) -> Interval:
    """Return the probability that a run of `a` is better than one of `b` at the same task.

    The estimate is the mean over tasks, of equal weight, of the share of all pairs of runs in
    which that of `a` is better; ties count half. The interval is a percentile bootstrap that draws
    the runs of `a` and of `b` independently within each task. Where every run of one is better
    than every run of the other, all resamples are equal and the bootstrap has no width; the
    interval is then Wilson's for as many pairs as can be formed that share no run.

    Source: Agarwal et al., NeurIPS 2021, section 4.3.

    Parameters
    ----------
    a_by_stratum, b_by_stratum : sequence of array_like
        Values of the runs of each task, tasks in the same order; numbers of runs may differ.
    lower_is_better : bool
        Whether lower values are better.
    level, resamples, rng
        As in `intervals.bootstrap`.

    Returns
    -------
    Interval
        The probability, from 0 to 1, with its interval.

    Raises
    ------
    InvalidInputError
        If the numbers of tasks differ, or a task has no runs or nan.

    Examples
    --------
    >>> a, b = [[1.0, 2.0, 3.0]], [[2.0, 4.0, 5.0]]
    >>> round(probability_of_improvement(a, b, rng=0).value, 3)
    0.833
    """
    a, b = strata_of(a_by_stratum, "a"), strata_of(b_by_stratum, "b")
    if len(a) != len(b):
        raise InvalidInputError(
            f"a and b must have runs of the same tasks, but a has {len(a)} and b has {len(b)}"
        )
    if not lower_is_better:
        a, b = [-values for values in a], [-values for values in b]
    generator = np.random.default_rng(rng)
    value, drawn = 0.0, np.zeros(checked_resamples(resamples))
    for of_a, of_b in zip(a, b, strict=True):
        wins, pairs = win_table(of_a, of_b), of_a.size * of_b.size
        value += float(wins.sum()) / pairs
        counts_of_a = drawn_counts(of_a.size, resamples, generator)
        counts_of_b = drawn_counts(of_b.size, resamples, generator)
        wins_by_run_of_b = np.einsum("ra,ab->rb", counts_of_a, wins)
        drawn += np.einsum("rb,rb->r", wins_by_run_of_b, counts_of_b) / pairs
    if value in (0.0, len(a)):
        # Pairs that share no run are independent, and all of them have the same winner.
        disjoint = sum(min(of_a.size, of_b.size) for of_a, of_b in zip(a, b, strict=True))
        return wilson(disjoint if value else 0, disjoint, level=level)
    return interval_around(value / len(a), drawn / len(a), level)
