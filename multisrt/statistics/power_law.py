"""Power laws, fitted by least squares of logarithms."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy import stats

from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.numerics.arrays import FloatArray
from multisrt.statistics.intervals import LEVEL, Interval
from multisrt.statistics.samples import checked_level, finite_sample_of


@dataclass(frozen=True, slots=True, kw_only=True)
class PowerLaw:
    """A fitted power law, y = factor · x ** exponent.

    Attributes
    ----------
    factor : Interval
        Value of y at x = 1.
    exponent : Interval
        Exponent: -1 if doubling x halves y, 0 if y does not depend on x.
    r_squared : float
        Share of the variance of log y that the fit explains; 1 if all y are equal.
    """

    factor: Interval
    exponent: Interval
    r_squared: float

    def at(self, x: ArrayLike) -> FloatArray:
        """Return the fitted values of y.

        Parameters
        ----------
        x : array_like of float
            Positive values.

        Returns
        -------
        ndarray of float
            y, in the shape of `x`.
        """
        return self.factor.value * np.asarray(x, dtype=np.float64) ** self.exponent.value


def fit_power_law(x: ArrayLike, y: ArrayLike, *, level: float = LEVEL) -> PowerLaw:
    """Fit y = factor · x ** exponent by least squares of the logarithms.

    Intervals are those of Student's t with n - 2 degrees of freedom, which assume that log y is
    normally distributed with the same variance at all x. That of the factor is computed for its
    logarithm, and so is not symmetric.

    Parameters
    ----------
    x, y : array_like, shape (n,)
        Positive and finite values; at least three points at two different x.
    level : float
        Confidence level, between 0 and 1.

    Returns
    -------
    PowerLaw
        The fit.

    Raises
    ------
    InvalidInputError
        If there are too few points, a value is not positive and finite, or the level is out of
        range.

    Examples
    --------
    >>> law = fit_power_law([1.0, 2.0, 4.0, 8.0], [90.0, 47.0, 22.0, 11.5])
    >>> round(law.exponent.value, 2), round(float(law.at(16.0)), 1)
    (-1.0, 5.7)
    """
    log_x, log_y = _logarithms(x, "x"), _logarithms(y, "y")
    if log_x.size != log_y.size:
        raise InvalidInputError(f"a fit needs a y for each x, not {log_y.size} for {log_x.size}")
    if log_x.size < 3 or np.ptp(log_x) == 0.0:
        raise InvalidInputError(
            "a power law with intervals needs at least three points, at two different x, not "
            f"{log_x.size} points at {np.unique(log_x).size}"
        )
    spread = float(stats.t.ppf((1.0 + checked_level(level)) / 2.0, log_x.size - 2))
    if np.ptp(log_y) == 0.0:
        # linregress cannot compute a correlation of a constant.
        same = float(np.asarray(y, dtype=np.float64)[0])
        return PowerLaw(
            factor=Interval(same, same, same), exponent=Interval(0.0, 0.0, 0.0), r_squared=1.0
        )
    line = stats.linregress(log_x, log_y)
    slope, intercept = float(line.slope), float(line.intercept)
    of_slope = spread * float(line.stderr)
    of_intercept = spread * float(line.intercept_stderr)
    factor = np.exp([intercept, intercept - of_intercept, intercept + of_intercept])
    return PowerLaw(
        factor=Interval(*map(float, factor)),
        exponent=Interval(slope, slope - of_slope, slope + of_slope),
        r_squared=float(line.rvalue) ** 2,
    )


def _logarithms(values: ArrayLike, name: str) -> FloatArray:
    sample = finite_sample_of(values, name)
    if sample.min() <= 0.0:
        raise InvalidInputError(
            f"a power law is fitted to positive numbers, but {name} has {sample.min()}"
        )
    return np.log(sample)
