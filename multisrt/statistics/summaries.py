"""One number for many runs: mean, median, interquartile mean, quantiles.

All work along the last axis, so that they do for one sample and for thousands of resamples; of a
single sample they give one number.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy import stats

from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.numerics.arrays import FloatArray
from multisrt.statistics.samples import refuse_infinite, refuse_unordered

Statistic = Callable[[FloatArray], FloatArray]
"""Takes values, shape (..., n), and gives one number for each last axis, shape (...)."""


def mean(values: FloatArray) -> FloatArray:
    """Mean of finite values; InvalidInputError for others: a failed run has no mean."""
    refuse_infinite(values, "values of a mean")
    return np.asarray(np.mean(values, axis=-1))


def median(values: FloatArray) -> FloatArray:
    """Median; infinite where half of the runs or more failed."""
    return quantile(values, 0.5)


def interquartile_mean(values: FloatArray) -> FloatArray:
    """Mean of the middle half of the values; infinite where more failed than are cut off.

    Of n values, the ``n // 4`` lowest and as many of the highest are left out, and the rest have
    equal weight. With fewer than four values it is the mean.

    Source: Agarwal et al., Deep Reinforcement Learning at the Edge of the Statistical Precipice,
    NeurIPS 2021, section 4.3, whose library rliable takes it in this way.
    """
    refuse_unordered(values, "values of an interquartile mean")
    return np.asarray(stats.trim_mean(values, 0.25, axis=-1))


def quantile(values: FloatArray, share: float) -> FloatArray:
    """Value below which a share of the values lies, linear between neighbours.

    The same as `numpy.quantile`, but for infinite values: between a finite and an infinite
    neighbour it is infinite, where numpy would give nan.

    Raises
    ------
    InvalidInputError
        On nan, on infinite values at both ends, and unless 0 <= `share` <= 1.
    """
    refuse_unordered(values, "values of a quantile")
    if not 0.0 <= share <= 1.0:
        raise InvalidInputError(f"a quantile is that of a share from 0 to 1, not {share}")
    ordered = np.sort(values, axis=-1)
    place = share * (values.shape[-1] - 1)
    index = int(place)
    below, weight = ordered[..., index], place - index
    if weight == 0.0:
        return np.asarray(below)
    above = ordered[..., index + 1]
    between = (1.0 - weight) * below + weight * above
    # Equal neighbours give their own value, without rounding.
    return np.asarray(np.where(below == above, below, between))
