"""Curves of many runs against time, such as coverage: a common grid, median and quartiles."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.numerics.arrays import FloatArray
from multisrt.statistics.samples import ascending, finite_sample_of
from multisrt.statistics.summaries import median, quantile

StepCurve = tuple[ArrayLike, ArrayLike]
"""Times at which a share changes, never descending, and the share from each on; before, it is 0."""

GRID_POINTS = 200
"""Default number of times of a grid."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class CurveBands:
    """Median and quartiles of many curves.

    Attributes
    ----------
    times : ndarray of float, shape (n,)
        The grid.
    median, lower_quartile, upper_quartile : ndarray of float, shape (n,)
        Quantiles of the runs at each time. The quartiles show how much runs differ; they are no
        confidence interval.
    """

    times: FloatArray
    median: FloatArray
    lower_quartile: FloatArray
    upper_quartile: FloatArray


def curve_bands(curves: Sequence[StepCurve], times: ArrayLike) -> CurveBands:
    """Return median and quartiles of the curves of several runs.

    Parameters
    ----------
    curves : sequence of (times, shares)
        One curve for each run.
    times : array_like, shape (n,)
        The grid, ascending; see `common_grid`.

    Returns
    -------
    CurveBands
        The quantiles at each time of the grid.

    Raises
    ------
    InvalidInputError
        As in `on_grid`.

    Examples
    --------
    >>> fast, slow = ([0.0, 2.0], [0.5, 1.0]), ([1.0, 4.0], [0.5, 1.0])
    >>> curve_bands([fast, slow], [0.0, 2.0, 4.0]).median
    array([0.25, 0.75, 1.  ])
    """
    shares = on_grid(curves, times).T
    return CurveBands(
        times=ascending(times, "times"),
        median=median(shares),
        lower_quartile=quantile(shares, 0.25),
        upper_quartile=quantile(shares, 0.75),
    )


def on_grid(curves: Sequence[StepCurve], times: ArrayLike) -> FloatArray:
    """Return the shares of several runs at the same times.

    A share holds from its time to the next change, the last one for ever; before the first change
    the share is 0. Of several changes at one time the last counts.

    Parameters
    ----------
    curves : sequence of (times, shares)
        One curve for each run.
    times : array_like, shape (n,)
        The grid, ascending.

    Returns
    -------
    ndarray of float, shape (len(curves), n)
        One row for each run.

    Raises
    ------
    InvalidInputError
        If there is no curve, or a curve has no point, descends in time or is not finite.

    Examples
    --------
    >>> on_grid([([1.0, 3.0], [0.5, 0.9])], [0.0, 1.0, 2.0, 5.0])
    array([[0. , 0.5, 0.5, 0.9]])
    """
    at = ascending(times, "times")
    rows = []
    for changed, shares in _checked(curves):
        last = np.searchsorted(changed, at, side="right")
        rows.append(np.concatenate([[0.0], shares])[last])
    return np.stack(rows)


def common_grid(curves: Sequence[StepCurve], points: int = GRID_POINTS) -> FloatArray:
    """Return evenly spaced times from 0 to the last change of any curve.

    Parameters
    ----------
    curves : sequence of (times, shares)
        One curve for each run.
    points : int
        Number of times, at least 2.

    Returns
    -------
    ndarray of float, shape (points,)
        The grid, ascending.

    Raises
    ------
    InvalidInputError
        As in `on_grid`; also if nothing changes after time 0, or `points` is below 2.

    Examples
    --------
    >>> common_grid([([0.0, 4.0], [0.5, 1.0])], points=5)
    array([0., 1., 2., 3., 4.])
    """
    if points < 2:
        raise InvalidInputError(f"a grid of times has at least 2 points, not {points}")
    end = max(float(changed[-1]) for changed, _ in _checked(curves))
    if end <= 0.0:
        raise InvalidInputError("no curve changes after time 0: there is no span to lay a grid on")
    return np.linspace(0.0, end, points)


def _checked(curves: Sequence[StepCurve]) -> list[tuple[FloatArray, FloatArray]]:
    if len(curves) == 0:
        raise InvalidInputError("there must be at least one curve, not none")
    checked = []
    for i, (times, shares) in enumerate(curves):
        changed = finite_sample_of(times, f"times of curve {i}")
        reached = finite_sample_of(shares, f"shares of curve {i}")
        if changed.size != reached.size:
            raise InvalidInputError(
                f"curve {i} must have a share for each time, not {reached.size} for {changed.size}"
            )
        if np.any(np.diff(changed) < 0.0):
            raise InvalidInputError(f"times of curve {i} must not descend")
        checked.append((changed, reached))
    return checked
