"""Intervals: stratified bootstrap of any statistic, Student's of a mean, Wilson's of a share."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy import stats

from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.numerics.arrays import FloatArray
from multisrt.statistics.samples import (
    checked_level,
    checked_resamples,
    finite_sample_of,
    strata_of,
)
from multisrt.statistics.summaries import Statistic, quantile

RESAMPLES = 2000
"""Default number of resamples of a bootstrap."""

LEVEL = 0.95
"""Default confidence level."""

MAX_VALUES_AT_ONCE = 4_000_000
"""Resampled values that are held in memory at a time."""


@dataclass(frozen=True, slots=True)
class Interval:
    """An estimate and its confidence interval.

    Attributes
    ----------
    value : float
        The estimate, computed from the data themselves.
    low, high : float
        Ends of the interval; infinite where failed runs leave no bound.
    """

    value: float
    low: float
    high: float


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Band:
    """An estimate with its confidence interval at each point of an axis.

    Attributes
    ----------
    at : ndarray of float, shape (n,)
        The points, such as thresholds or times.
    value : ndarray of float, shape (n,)
        The estimate at each point.
    low, high : ndarray of float, shape (n,)
        Ends of pointwise intervals: each holds at its level by itself, not all of them together.
    """

    at: FloatArray
    value: FloatArray
    low: FloatArray
    high: FloatArray


def bootstrap(
    strata: Sequence[ArrayLike],
    statistic: Statistic,
    *,
    level: float = LEVEL,
    resamples: int = RESAMPLES,
    rng: np.random.Generator | int,
) -> Interval:
    """Return a statistic with its interval by the stratified percentile bootstrap.

    Each resample draws from every stratum as many runs as it has, with replacement, and computes
    the statistic of all of them together; the ends of the interval are quantiles of the results.
    All runs have equal weight, so that strata do only if they have equal sizes. A stratum of one
    run adds nothing to the width.

    Source: Agarwal et al., NeurIPS 2021, section 4.1.

    Parameters
    ----------
    strata : sequence of array_like, shapes (n_i,)
        Values of the runs of each task.
    statistic : callable
        Statistic along the last axis, such as `summaries.median`.
    level : float
        Confidence level, between 0 and 1. With 20 runs intervals are a little narrow: about 93 %
        of those at 0.95 contain the true value.
    resamples : int
        Number of resamples, at least 1.
    rng : numpy.random.Generator or int
        Generator of the draws, or its seed.

    Returns
    -------
    Interval
        The statistic of the data, and its interval.

    Raises
    ------
    InvalidInputError
        If a stratum is empty or holds nan, if the statistic refuses the values, or if level or
        resamples are out of range.

    Examples
    --------
    >>> from multisrt.statistics.summaries import median
    >>> found = bootstrap([[1.0, 2.0, 4.0], [3.0, 5.0]], median, rng=0)
    >>> found.value
    3.0
    >>> found.low <= found.value <= found.high
    True
    """
    samples = strata_of(strata)
    value = float(statistic(np.concatenate(samples)))
    drawn = [statistic(block) for block in _resampled(samples, checked_resamples(resamples), rng)]
    return interval_around(value, np.concatenate(drawn), level)


def interval_around(value: float, drawn: FloatArray, level: float) -> Interval:
    """Return an estimate with its percentile interval.

    Parameters
    ----------
    value : float
        The estimate.
    drawn : ndarray of float, shape (resamples,)
        Its values in the resamples.
    level : float
        Confidence level.

    Returns
    -------
    Interval
        The estimate, and quantiles of `drawn` as its interval.
    """
    low, high = percentile_ends(drawn, level)
    return Interval(value, float(low), float(high))


def percentile_ends(drawn: FloatArray, level: float) -> tuple[FloatArray, FloatArray]:
    """Return the ends of percentile intervals.

    Parameters
    ----------
    drawn : ndarray of float, shape (..., resamples)
        Values of estimates in the resamples.
    level : float
        Confidence level.

    Returns
    -------
    low, high : ndarray of float, shape (...)
        Ends of the intervals.
    """
    tail = (1.0 - checked_level(level)) / 2.0
    return quantile(drawn, tail), quantile(drawn, 1.0 - tail)


def drawn_counts(runs: int, resamples: int, rng: np.random.Generator) -> FloatArray:
    """Return how often each run is drawn in each resample.

    With these counts the sums over runs in all resamples are one matrix product. Use
    `numpy.einsum` for it: threads of a linear algebra library cost more than they save here.

    Parameters
    ----------
    runs, resamples : int
        Number of runs and of resamples.
    rng : numpy.random.Generator
        Generator of the draws.

    Returns
    -------
    ndarray of float, shape (resamples, runs)
        Counts, as floats; each row sums to `runs`.
    """
    drawn = rng.integers(runs, size=(checked_resamples(resamples), runs))
    cells = drawn + runs * np.arange(resamples)[:, np.newaxis]
    counts = np.bincount(cells.ravel(), minlength=resamples * runs)
    return counts.reshape(resamples, runs).astype(np.float64)


def wilson(successes: int, count: int, level: float = LEVEL) -> Interval:
    """Return the share of successful runs with Wilson's interval.

    Source: Wilson, Probable inference, the law of succession, and statistical inference, Journal
    of the American Statistical Association 22, 1927; without correction for continuity.

    Parameters
    ----------
    successes, count : int
        Number of successful runs and of all runs; 0 <= successes <= count, 1 <= count.
    level : float
        Confidence level, between 0 and 1.

    Returns
    -------
    Interval
        The share, and an interval within [0, 1].

    Raises
    ------
    InvalidInputError
        If an argument is out of range.

    Examples
    --------
    >>> found = wilson(20, 20)
    >>> found.value, round(found.low, 3), found.high
    (1.0, 0.839, 1.0)
    """
    if not 0 <= successes <= count or count < 1:
        raise InvalidInputError(
            f"a share needs at least one run and no more successes than runs, not {successes} "
            f"of {count}"
        )
    result = stats.binomtest(successes, count)
    ends = result.proportion_ci(checked_level(level), method="wilson")
    return Interval(successes / count, float(ends.low), float(ends.high))


def student(values: ArrayLike, level: float = LEVEL) -> Interval:
    """Return the mean of values with Student's interval.

    Parameters
    ----------
    values : array_like, shape (n,)
        At least two finite values.
    level : float
        Confidence level, between 0 and 1.

    Returns
    -------
    Interval
        The mean and its interval.

    Raises
    ------
    InvalidInputError
        If there are fewer than two values, one is not finite, or the level is out of range.

    Examples
    --------
    >>> found = student([1.0, 2.0, 3.0])
    >>> found.value, round(found.low, 3), round(found.high, 3)
    (2.0, -0.484, 4.484)
    """
    sample = finite_sample_of(values)
    if sample.size < 2:
        raise InvalidInputError("Student's interval needs at least two values, not one")
    middle = float(sample.mean())
    quantile_of_t = float(stats.t.ppf(0.5 + 0.5 * checked_level(level), sample.size - 1))
    half = quantile_of_t * float(sample.std(ddof=1)) / math.sqrt(sample.size)
    return Interval(middle, middle - half, middle + half)


def _resampled(
    samples: list[FloatArray], resamples: int, rng: np.random.Generator | int
) -> Iterator[FloatArray]:
    """Yield resamples of all strata side by side, shape (rows, runs), in blocks of rows."""
    generator = np.random.default_rng(rng)
    runs = sum(sample.size for sample in samples)
    rows_at_once = max(1, MAX_VALUES_AT_ONCE // runs)
    for begin in range(0, resamples, rows_at_once):
        rows = min(rows_at_once, resamples - begin)
        drawn = [
            sample[generator.integers(sample.size, size=(rows, sample.size))] for sample in samples
        ]
        yield np.concatenate(drawn, axis=-1)
