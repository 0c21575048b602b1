"""The ratio of two sets of runs with its interval, and the smallest difference that runs show.

A rank test of `a` against `ratio * b` is inverted: the estimate is the ratio at which neither side
is lower, and the interval holds the ratios that the test does not reject. So estimate and interval
agree with the test: the interval excludes 1 exactly if the test is significant. They are as
robust as ranks are: failed runs are worse than all others at any ratio.

Source: Hodges and Lehmann, Estimates of location based on rank tests, Annals of Mathematical
Statistics 34, 1963, here for ratios instead of differences.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache

from scipy import stats

from multisrt.geometry.errors import InvalidInputError
from multisrt.statistics.intervals import LEVEL, Interval
from multisrt.statistics.rank_tests import RankTest
from multisrt.statistics.samples import checked_level

MAX_LOG_RATIO = math.log(1e6)
"""Bound of the logarithms of ratios that are searched; beyond, an end is 0 or infinite."""

TOLERANCE = 1e-4
"""Relative precision of the estimate and of the ends of an interval."""

POWER = 0.8
"""Default probability with which a difference is to be found."""


def ratio_of(test: Callable[[float], RankTest], *, level: float = LEVEL) -> Interval:
    """Return the ratio of the values of `a` to those of `b`, with its interval.

    Parameters
    ----------
    test : callable
        ``test(ratio)`` returns the `RankTest` of `a` and ``ratio * b``, as of
        `families.paired_family`. The larger the ratio, the lower is `a` in comparison.
    level : float
        Confidence level, between 0 and 1.

    Returns
    -------
    Interval
        The ratio, below 1 if `a` is lower; 0 or infinite where failed runs or zeros leave no
        other. An end is 0 or infinite if the runs bound nothing on that side. If all pairs are
        equal, the ratio is 1 without bounds.

    Raises
    ------
    InvalidInputError
        If the level is out of range, or the test refuses its values.

    Examples
    --------
    >>> from multisrt.statistics.families import paired_family
    >>> b = [[100.0, 120.0, 90.0, 130.0, 110.0, 105.0], [10.0, 9.0, 13.0, 12.0, 15.0, 11.0]]
    >>> a = [[80.0, 97.0, 71.0, 106.0, 89.0, 82.0], [8.2, 7.1, 10.3, 9.7, 11.8, 8.7]]
    >>> found = ratio_of(lambda ratio: paired_family(a, b, ratio=ratio))
    >>> round(found.value, 2), round(found.low, 2), round(found.high, 2)
    (0.8, 0.79, 0.81)
    """
    significance = 1.0 - checked_level(level)

    @cache
    def at(log_ratio: float) -> RankTest:
        return test(math.exp(log_ratio))

    def rejected(log_ratio: float) -> bool:
        return at(log_ratio).p_value < significance

    least, most = -MAX_LOG_RATIO, MAX_LOG_RATIO
    # From where on `a` is not the higher one, and is the lower one.
    middle = _middle(
        _first(lambda x: at(x).a_lower >= 0.5, least, most),
        _first(lambda x: at(x).a_lower > 0.5, least, most),
    )
    inside = min(max(middle, least), most)
    # Ratio 1 is inside or outside as the test says, whatever steps a p-value takes between.
    within_one = not rejected(0.0)
    low_from, high_to = least, most
    low_to = high_from = inside
    if within_one:
        low_to, high_from = min(inside, 0.0), max(inside, 0.0)
    elif inside > 0.0:
        low_from = 0.0
    else:
        high_to = 0.0
    low = _first(lambda x: not rejected(x), low_from, low_to)
    high = -_first(lambda x: not rejected(-x), -high_to, -high_from)
    return Interval(_exp(middle), _exp(min(low, middle)), _exp(max(high, middle)))


def smallest_reduction(
    found: Interval, *, power: float | None = None, level: float = LEVEL
) -> float:
    """Return the smallest reduction, as a share, that runs like these would have shown.

    Without `power` it is the observed reduction from which on the test would have been
    significant, if these runs had another ratio but the same spread: had all values of `a` been
    multiplied by c, the interval would have been c times as high, and below 1 if c is below
    1 / high; the ratio is then value / high. If the true ratio is that one, about half of such
    experiments find it.

    With `power` it is the true reduction that this share of such experiments finds. The distance
    of the ratio from 1 in logarithms grows by (z_power + z_level) / z_level, as for any estimate
    that is about normal; the standard error is that of the interval, and so of the rank test.

    Parameters
    ----------
    found : Interval
        A ratio with its interval, of `ratio_of`.
    power : float, optional
        Probability with which the reduction is to be found, between 0.5 and 1.
    level : float
        Confidence level of the interval.

    Returns
    -------
    float
        Share by which `a` must be lower than `b`, from 0 to 1; 1 if no reduction would have been
        found.

    Raises
    ------
    InvalidInputError
        If the power or the level is out of range.

    Examples
    --------
    >>> found = Interval(1.0, 0.8, 1.25)
    >>> round(smallest_reduction(found), 3), round(smallest_reduction(found, power=0.8), 3)
    (0.2, 0.273)
    """
    factor = 1.0
    if power is not None:
        if not 0.5 <= power < 1.0:
            raise InvalidInputError(f"a power must be at least 0.5 and below 1, not {power}")
        z_level = stats.norm.ppf(0.5 + 0.5 * checked_level(level))
        factor += float(stats.norm.ppf(power) / z_level)
    if not 0.0 < found.value < math.inf or math.isinf(found.high):
        return 1.0
    return 1.0 - float((found.value / found.high) ** factor)


def _first(holds: Callable[[float], bool], low: float, high: float) -> float:
    """Return the first place from which on a condition holds that holds at `high`, by bisection.

    If it holds at `low` already, or not at `high` either where that is the end of the search, the
    place is minus or plus infinite.
    """
    if low == -MAX_LOG_RATIO and holds(low):
        return -math.inf
    if high == MAX_LOG_RATIO and not holds(high):
        return math.inf
    while high - low > TOLERANCE:
        middle = 0.5 * (low + high)
        if holds(middle):
            high = middle
        else:
            low = middle
    return high


def _middle(first: float, last: float) -> float:
    """Return the middle of a span; of one without bounds 0, of one with a single bound that."""
    if math.isinf(first) and math.isinf(last):
        return first if first == last else 0.0
    finite = [end for end in (first, last) if math.isfinite(end)]
    return sum(finite) / len(finite)


def _exp(log_ratio: float) -> float:
    return math.exp(log_ratio) if log_ratio < math.inf else math.inf
