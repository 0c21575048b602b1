"""Summaries of many runs: mean, median, interquartile mean, quantiles.

All of them reduce the last axis, of one sample or of thousands of resamples: values of shape
``(..., n)`` become an array of shape ``(...)``.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy import stats

from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.numerics.arrays import FloatArray
from multisrt.statistics.samples import refuse_infinite, refuse_unordered

Statistic = Callable[[FloatArray], FloatArray]
"""Reduces values of shape (..., n) to an array of shape (...)."""


def mean(values: FloatArray) -> FloatArray:
    """Return the mean.

    Parameters
    ----------
    values : ndarray of float, shape (..., n)
        Finite values.

    Returns
    -------
    ndarray of float, shape (...)
        The means.

    Raises
    ------
    InvalidInputError
        If a value is not finite, as of a failed run.

    Examples
    --------
    >>> import numpy as np
    >>> float(mean(np.array([1.0, 2.0, 6.0])))
    3.0
    """
    refuse_infinite(values, "values of a mean")
    return np.asarray(np.mean(values, axis=-1))


def median(values: FloatArray) -> FloatArray:
    """Return the median.

    Parameters
    ----------
    values : ndarray of float, shape (..., n)
        Values of runs; failed ones are infinite.

    Returns
    -------
    ndarray of float, shape (...)
        The medians; infinite where half of the runs or more failed.

    Raises
    ------
    InvalidInputError
        As in `quantile`.

    Examples
    --------
    >>> import numpy as np
    >>> float(median(np.array([1.0, 2.0, np.inf])))
    2.0
    """
    return quantile(values, 0.5)


def interquartile_mean(values: FloatArray) -> FloatArray:
    """Return the mean of the middle half of the values.

    Of n values the ``n // 4`` lowest and as many of the highest are left out; the others have
    equal weight. With fewer than four values it is the mean.

    Source: Agarwal et al., Deep Reinforcement Learning at the Edge of the Statistical Precipice,
    NeurIPS 2021, section 4.3, as their library rliable computes it.

    Parameters
    ----------
    values : ndarray of float, shape (..., n)
        Values of runs; failed ones are infinite.

    Returns
    -------
    ndarray of float, shape (...)
        The means; infinite where more runs failed than are left out.

    Raises
    ------
    InvalidInputError
        If values hold nan, or ``inf`` and ``-inf``.

    Examples
    --------
    >>> import numpy as np
    >>> float(interquartile_mean(np.array([1.0, 2.0, 4.0, np.inf])))
    3.0
    """
    refuse_unordered(values, "values of an interquartile mean")
    return np.asarray(stats.trim_mean(values, 0.25, axis=-1))


def quantile(values: FloatArray, share: float) -> FloatArray:
    """Return a quantile, with linear interpolation.

    It is that of `numpy.quantile` except for infinite values: between a finite and an infinite
    neighbour it is infinite, where numpy returns nan.

    Parameters
    ----------
    values : ndarray of float, shape (..., n)
        Values of runs; failed ones are infinite.
    share : float
        Share of the values below the quantile, from 0 to 1.

    Returns
    -------
    ndarray of float, shape (...)
        The quantiles.

    Raises
    ------
    InvalidInputError
        If values hold nan, or ``inf`` and ``-inf``, or the share is not from 0 to 1.

    Examples
    --------
    >>> import numpy as np
    >>> float(quantile(np.array([1.0, 2.0, 4.0]), 0.75))
    3.0
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
    # No rounding between equal neighbours.
    return np.asarray(np.where(below == above, below, between))
