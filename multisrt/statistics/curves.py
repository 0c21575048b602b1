"""Curves of many runs against time, such as coverage: brought to one grid, median and bands."""

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
"""Times at which a share changed, never descending, and the share from each on; 0 before."""

GRID_POINTS = 200
"""Times of a grid, unless told otherwise."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class CurveBands:
    """The curves of many runs in one.

    Attributes
    ----------
    times : ndarray of float, shape (n,)
        The grid.
    median, lower_quartile, upper_quartile : ndarray of float, shape (n,)
        Of the runs at each time: the quartiles say how much runs differ.
    """

    times: FloatArray
    median: FloatArray
    lower_quartile: FloatArray
    upper_quartile: FloatArray


def curve_bands(curves: Sequence[StepCurve], times: ArrayLike) -> CurveBands:
    """Median and quartiles of the curves of runs, against time.

    Parameters
    ----------
    curves : sequence of (times, shares)
        One for each run of a condition.
    times : array_like, shape (n,)
        The grid, ascending; see `common_grid`.

    Raises
    ------
    InvalidInputError
        See `on_grid`.
    """
    shares = on_grid(curves, times).T
    return CurveBands(
        times=ascending(times, "times"),
        median=median(shares),
        lower_quartile=quantile(shares, 0.25),
        upper_quartile=quantile(shares, 0.75),
    )


def on_grid(curves: Sequence[StepCurve], times: ArrayLike) -> FloatArray:
    """Shares of all runs at the same times.

    A run keeps its share until the next change, and its last one for ever; before its first
    change it has 0. Of several changes at one time the last counts.

    Parameters
    ----------
    curves : sequence of (times, shares)
        One for each run.
    times : array_like, shape (n,)
        The grid, ascending.

    Returns
    -------
    ndarray of float, shape (runs, n)

    Raises
    ------
    InvalidInputError
        If there is no curve, or one has no point, descends in time or is not finite.
    """
    at = ascending(times, "times")
    rows = []
    for changed, shares in _checked(curves):
        last = np.searchsorted(changed, at, side="right")
        rows.append(np.concatenate([[0.0], shares])[last])
    return np.stack(rows)


def common_grid(curves: Sequence[StepCurve], points: int = GRID_POINTS) -> FloatArray:
    """Evenly spaced times from 0 to the last change of any run.

    Raises
    ------
    InvalidInputError
        As in `on_grid`; also if nothing changes after time 0, or `points` is below 2.
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
