"""How one quantity grows with another: a power law, fitted in logarithms."""

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
    """A fit of y = factor · x ** exponent.

    Attributes
    ----------
    factor : Interval
        What y is at x = 1.
    exponent : Interval
        -1 where doubling x halves y, 0 where x does not matter.
    r_squared : float
        Share of the variance of log y that the fit explains; 1 where all y are equal.
    """

    factor: Interval
    exponent: Interval
    r_squared: float

    def at(self, x: ArrayLike) -> FloatArray:
        """Give what the fit says of y at x > 0."""
        return self.factor.value * np.asarray(x, dtype=np.float64) ** self.exponent.value


def fit_power_law(x: ArrayLike, y: ArrayLike, *, level: float = LEVEL) -> PowerLaw:
    """Fit y = factor · x ** exponent by least squares of the logarithms.

    Intervals are by Student's t with n - 2 degrees of freedom: they hold where log y scatters
    normally, and equally widely at all x. The factor's is that of its logarithm, and so lies
    unevenly around it.

    Parameters
    ----------
    x, y : array_like, shape (n,)
        Positive and finite; at least three points, at two different x.
    level : float
        Level of the intervals.

    Raises
    ------
    InvalidInputError
        If they are not as said.
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
        # Nothing varies: linregress has no correlation to give.
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
