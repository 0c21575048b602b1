"""How runs are spread over thresholds, and how far they stay from a bound."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.numerics.arrays import FloatArray
from multisrt.statistics.intervals import (
    LEVEL,
    RESAMPLES,
    Band,
    Interval,
    bootstrap,
    drawn_counts,
    percentile_ends,
)
from multisrt.statistics.samples import (
    ascending,
    checked_resamples,
    finite_sample_of,
    sample_of,
    strata_of,
)
from multisrt.statistics.summaries import interquartile_mean


def performance_profile(
    strata: Sequence[ArrayLike],
    thresholds: ArrayLike,
    *,
    level: float = LEVEL,
    resamples: int = RESAMPLES,
    rng: np.random.Generator | int,
) -> Band:
    """Share of runs with a value of at most each threshold, mean over the tasks.

    A profile that lies above another everywhere is better throughout; a run that failed is below
    no threshold. All tasks weigh the same, so that values of different tasks should be
    comparable: relative to a bound, say.

    Parameters
    ----------
    strata : sequence of array_like, shapes (n_i,)
        Values of the runs of each task; lower is better.
    thresholds : array_like, shape (k,)
        Finite and ascending.
    level, resamples, rng
        As in `intervals.bootstrap`.

    Returns
    -------
    Band
        At the thresholds, with pointwise percentile intervals of the stratified bootstrap.

    Raises
    ------
    InvalidInputError
        If a stratum is empty or holds nan, or the thresholds are not as said.

    Source: Agarwal et al., NeurIPS 2021, section 4.2, run-score distributions; differs in: there
    higher is better and a profile counts the runs above a threshold.
    """
    samples = strata_of(strata)
    at = ascending(thresholds, "thresholds")
    generator = np.random.default_rng(rng)
    value = np.zeros(at.size)
    drawn = np.zeros((checked_resamples(resamples), at.size))
    for sample in samples:
        reached = (sample[:, np.newaxis] <= at).astype(np.float64)
        value += reached.mean(axis=0)
        counts = drawn_counts(sample.size, resamples, generator)
        drawn += np.einsum("ri,ik->rk", counts, reached) / sample.size
    low, high = percentile_ends((drawn / len(samples)).T, level)
    return Band(at=at, value=value / len(samples), low=low, high=high)


def gap(
    strata: Sequence[ArrayLike],
    bounds: Sequence[ArrayLike],
    *,
    level: float = LEVEL,
    resamples: int = RESAMPLES,
    rng: np.random.Generator | int,
) -> Interval:
    """Gap to a lower bound, value / bound - 1: interquartile mean of all runs, with its interval.

    The optimality gap of rliable is another number: with scores from 0 to 1, the mean of how much
    is missing to 1. Taken of the score bound / value, a run of gap g has there g / (1 + g). That
    never exceeds 1, where ours says how many times the bound came on top: 0.5 is half as much
    again.

    Parameters
    ----------
    strata : sequence of array_like, shapes (n_i,)
        Values of the runs of each task; lower is better.
    bounds : sequence of array_like, shapes () or (n_i,)
        For each task, the bound of all its runs or of each one.
    level, resamples, rng
        As in `intervals.bootstrap`.

    Raises
    ------
    InvalidInputError
        See `gaps_to_bound`; also if there are not as many bounds as tasks.
    """
    if len(strata) != len(bounds):
        raise InvalidInputError(
            f"each task needs its bound, but there are {len(strata)} tasks and {len(bounds)} bounds"
        )
    gaps = [gaps_to_bound(values, bound) for values, bound in zip(strata, bounds, strict=True)]
    return bootstrap(gaps, interquartile_mean, level=level, resamples=resamples, rng=rng)


def gaps_to_bound(values: ArrayLike, bound: ArrayLike) -> FloatArray:
    """Gap of each run to its lower bound, value / bound - 1; ``inf`` for a run that failed.

    Parameters
    ----------
    values : array_like, shape (n,)
        Of runs of one task.
    bound : array_like, shape () or (n,)
        Of all of them, or of each; positive and finite.

    Raises
    ------
    InvalidInputError
        If they are not as said.
    """
    sample = sample_of(values)
    of_each = finite_sample_of(np.atleast_1d(bound), "bounds")
    if of_each.size not in (1, sample.size):
        raise InvalidInputError(
            f"{sample.size} values need one bound or one each, not {of_each.size}"
        )
    if of_each.min() <= 0.0:
        raise InvalidInputError(
            f"a gap is relative to its bound, which must be positive, not {of_each.min()}"
        )
    return sample / of_each - 1.0
