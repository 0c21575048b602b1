"""Intervals of confidence: stratified bootstrap of any statistic, Wilson's of a share."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy import stats

from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.numerics.arrays import FloatArray
from multisrt.statistics.samples import checked_level, checked_resamples, strata_of
from multisrt.statistics.summaries import Statistic, quantile

RESAMPLES = 2000
"""Resamples of a bootstrap, unless told otherwise."""

LEVEL = 0.95
"""Level of an interval, unless told otherwise."""

VALUES_AT_ONCE = 4_000_000
"""Resampled values are held in memory so many at a time."""


@dataclass(frozen=True, slots=True)
class Interval:
    """An estimate and its interval of confidence.

    Attributes
    ----------
    value : float
        The estimate, from the data themselves.
    low, high : float
        Ends of the interval; infinite where failed runs leave no bound.
    """

    value: float
    low: float
    high: float


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Band:
    """An estimate with its interval at each place of an axis.

    Attributes
    ----------
    at : ndarray of float, shape (n,)
        The places: thresholds, times.
    value : ndarray of float, shape (n,)
        The estimate at each.
    low, high : ndarray of float, shape (n,)
        Ends of its interval, pointwise: each holds at its level by itself, not all at once.
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
    """Interval of a statistic by the stratified percentile bootstrap.

    Each resample draws from every stratum as many runs as it has, with replacement, and takes the
    statistic of all of them together; the interval is between two quantiles of the results. All
    runs weigh the same: strata do only if they are of equal size. A stratum of a single run is
    drawn as it is, and adds nothing to the width.

    Parameters
    ----------
    strata : sequence of array_like, shapes (n_i,)
        Values of the runs of each task.
    statistic : callable
        Of values along the last axis, such as `summaries.median`.
    level : float
        Share of such intervals that hold the true value, in the long run. With 20 runs they are a
        little narrow: about 0.93 of those at 0.95 do.
    resamples : int
        How many.
    rng : numpy.random.Generator or int
        Where the draws come from.

    Raises
    ------
    InvalidInputError
        If a stratum is empty or holds nan, if the statistic cannot take the values, or if level
        or resamples are out of range.

    Source: Agarwal et al., NeurIPS 2021, section 4.1.
    """
    samples = strata_of(strata)
    value = float(statistic(np.concatenate(samples)))
    drawn = [statistic(block) for block in _resampled(samples, checked_resamples(resamples), rng)]
    return interval_around(value, np.concatenate(drawn), level)


def interval_around(value: float, drawn: FloatArray, level: float) -> Interval:
    """Percentile interval of an estimate from its values in the resamples, shape (resamples,)."""
    low, high = percentile_ends(drawn, level)
    return Interval(value, float(low), float(high))


def percentile_ends(drawn: FloatArray, level: float) -> tuple[FloatArray, FloatArray]:
    """Give the ends of percentile intervals, of values in the resamples along the last axis."""
    tail = (1.0 - checked_level(level)) / 2.0
    return quantile(drawn, tail), quantile(drawn, 1.0 - tail)


def drawn_counts(runs: int, resamples: int, rng: np.random.Generator) -> FloatArray:
    """How often each run is drawn in each resample, shape (resamples, runs).

    A sum over the runs needs no more: those of all resamples are one product of matrices. It is
    best left to `numpy.einsum`: threads of a linear algebra library cost more than they save here.
    """
    drawn = rng.integers(runs, size=(checked_resamples(resamples), runs))
    cells = drawn + runs * np.arange(resamples)[:, np.newaxis]
    counts = np.bincount(cells.ravel(), minlength=resamples * runs)
    return counts.reshape(resamples, runs).astype(np.float64)


def wilson(successes: int, count: int, level: float = LEVEL) -> Interval:
    """Share of runs that succeeded, with Wilson's interval.

    Parameters
    ----------
    successes, count : int
        Runs that succeeded, and all of them; 0 <= successes <= count, 1 <= count.
    level : float
        Level of the interval.

    Raises
    ------
    InvalidInputError
        If they are out of range.

    Source: Wilson, Probable inference, the law of succession, and statistical inference, Journal
    of the American Statistical Association 22, 1927; without correction for continuity.
    """
    if not 0 <= successes <= count or count < 1:
        raise InvalidInputError(
            f"a share needs at least one run and no more successes than runs, not {successes} "
            f"of {count}"
        )
    result = stats.binomtest(successes, count)
    ends = result.proportion_ci(checked_level(level), method="wilson")
    return Interval(successes / count, float(ends.low), float(ends.high))


def _resampled(
    samples: list[FloatArray], resamples: int, rng: np.random.Generator | int
) -> Iterator[FloatArray]:
    """Resamples of all strata side by side, shape (rows, runs), some rows at a time."""
    generator = np.random.default_rng(rng)
    runs = sum(sample.size for sample in samples)
    rows_at_once = max(1, VALUES_AT_ONCE // runs)
    for begin in range(0, resamples, rows_at_once):
        rows = min(rows_at_once, resamples - begin)
        drawn = [
            sample[generator.integers(sample.size, size=(rows, sample.size))] for sample in samples
        ]
        yield np.concatenate(drawn, axis=-1)
