"""Performance profiles over thresholds, and gaps to a lower bound."""

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
    """Return the share of runs with a value of at most each threshold, averaged over tasks.

    A profile above another everywhere is better throughout; a failed run is below no threshold.
    Tasks have equal weight, so that their values should be comparable, such as ratios to a bound.

    Source: Agarwal et al., NeurIPS 2021, section 4.2, run-score distributions; differs in: there
    higher is better and a profile counts the runs above a threshold.

    Parameters
    ----------
    strata : sequence of array_like, shapes (n_i,)
        Values of the runs of each task; lower is better.
    thresholds : array_like, shape (k,)
        Finite, ascending thresholds.
    level, resamples, rng
        As in `intervals.bootstrap`.

    Returns
    -------
    Band
        The shares at the thresholds, with pointwise intervals by the stratified percentile
        bootstrap.

    Raises
    ------
    InvalidInputError
        If a stratum is empty or holds nan, or the thresholds do not ascend.

    Examples
    --------
    >>> band = performance_profile([[1.0, 2.0], [1.5, 4.0]], [1.0, 2.0, 4.0], rng=0)
    >>> band.value
    array([0.25, 0.75, 1.  ])
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
    """Return the interquartile mean of the gap to a lower bound, value / bound - 1.

    The optimality gap of rliable is another number: the mean of 1 - score for scores from 0 to 1.
    With the score bound / value, a run with gap g has g / (1 + g) there, which never exceeds 1.
    Here 0.5 means half as much again as the bound.

    Parameters
    ----------
    strata : sequence of array_like, shapes (n_i,)
        Values of the runs of each task; lower is better.
    bounds : sequence of array_like, shapes () or (n_i,)
        For each task the bound of all its runs, or of each.
    level, resamples, rng
        As in `intervals.bootstrap`.

    Returns
    -------
    Interval
        The mean of all runs, with its interval.

    Raises
    ------
    InvalidInputError
        As in `gaps_to_bound`; also if there are not as many bounds as tasks.

    Examples
    --------
    >>> gap([[12.0, 15.0], [30.0, 24.0]], [10.0, 20.0], rng=0).value
    0.35
    """
    if len(strata) != len(bounds):
        raise InvalidInputError(
            f"each task needs its bound, but there are {len(strata)} tasks and {len(bounds)} bounds"
        )
    gaps = [gaps_to_bound(values, bound) for values, bound in zip(strata, bounds, strict=True)]
    return bootstrap(gaps, interquartile_mean, level=level, resamples=resamples, rng=rng)


def gaps_to_bound(values: ArrayLike, bound: ArrayLike) -> FloatArray:
    """Return the gap of each run to its lower bound, value / bound - 1.

    Parameters
    ----------
    values : array_like, shape (n,)
        Values of the runs of one task.
    bound : array_like, shape () or (n,)
        Positive, finite bound of all runs, or of each.

    Returns
    -------
    ndarray of float, shape (n,)
        The gaps; ``inf`` for failed runs.

    Raises
    ------
    InvalidInputError
        If a bound is not positive and finite, or their number differs from that of the values.

    Examples
    --------
    >>> gaps_to_bound([10.0, 15.0, float("inf")], 10.0)
    array([0. , 0.5, inf])
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
