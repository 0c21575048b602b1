"""How probable it is that one way of doing things does better than another."""

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
    """Probability that a run of `a` is better than one of `b` at the same task.

    It is the mean over the tasks of the share of all couples of runs in which `a`'s is better,
    ties being half; all tasks weigh the same. The interval is by the percentile bootstrap, in
    which the runs of `a` and `b` are drawn apart from each other within each task.

    Parameters
    ----------
    a_by_stratum, b_by_stratum : sequence of array_like
        Values of the runs of each task, tasks in the same order; numbers of runs may differ.
    lower_is_better : bool
        Else higher values are.
    level, resamples, rng
        As in `intervals.bootstrap`.

    Raises
    ------
    InvalidInputError
        If they have not the same number of tasks, or a task has no runs or nan.

    Source: Agarwal et al., NeurIPS 2021, section 4.3.
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
        wins, couples = win_table(of_a, of_b), of_a.size * of_b.size
        value += float(wins.sum()) / couples
        counts_of_a = drawn_counts(of_a.size, resamples, generator)
        counts_of_b = drawn_counts(of_b.size, resamples, generator)
        wins_by_run_of_b = np.einsum("ra,ab->rb", counts_of_a, wins)
        drawn += np.einsum("rb,rb->r", wins_by_run_of_b, counts_of_b) / couples
    return interval_around(value / len(a), drawn / len(a), level)
