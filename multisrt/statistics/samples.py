"""Validation of the values of runs."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.numerics.arrays import FloatArray


def sample_of(values: ArrayLike, name: str = "values") -> FloatArray:
    """Return the values of runs, some of which may have failed, as an array.

    Parameters
    ----------
    values : array_like, shape (n,)
        At least one number, none of them nan. Failed runs are either all ``inf`` or all ``-inf``,
        whichever is worse.
    name : str
        Name of the values in messages.

    Returns
    -------
    ndarray of float, shape (n,)
        The values.

    Raises
    ------
    InvalidInputError
        If the values are anything else.

    Examples
    --------
    >>> sample_of([12, 15, float("inf")])
    array([12., 15., inf])
    """
    try:
        sample = np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise InvalidInputError(f"{name} must be numbers: {error}") from error
    if sample.ndim != 1 or sample.size == 0:
        raise InvalidInputError(
            f"{name} must be a row of at least one number, not an array of shape {sample.shape}"
        )
    refuse_unordered(sample, name)
    return sample


def finite_sample_of(values: ArrayLike, name: str = "values") -> FloatArray:
    """Return the values of runs as `sample_of` does; InvalidInputError if one is infinite."""
    sample = sample_of(values, name)
    refuse_infinite(sample, name)
    return sample


def ascending(places: ArrayLike, name: str) -> FloatArray:
    """Return the points of an axis; InvalidInputError unless finite and strictly ascending."""
    at = finite_sample_of(places, name)
    if np.any(np.diff(at) <= 0.0):
        raise InvalidInputError(f"{name} must ascend, each above the one before")
    return at


def strata_of(strata: Sequence[ArrayLike], name: str = "strata") -> list[FloatArray]:
    """Return the values of runs, one array for each task.

    Parameters
    ----------
    strata : sequence of array_like, shapes (n_i,)
        Values of the runs of each task.
    name : str
        Name of the strata in messages.

    Returns
    -------
    list of ndarray of float
        The values of each task.

    Raises
    ------
    InvalidInputError
        If there is no stratum, or one is no sample (see `sample_of`), or failed runs are ``inf``
        in one and ``-inf`` in another.
    """
    if len(strata) == 0:
        raise InvalidInputError(f"{name} must hold at least one array of values, not none")
    samples = [sample_of(values, f"{name}[{i}]") for i, values in enumerate(strata)]
    refuse_unordered(np.concatenate(samples), name)
    return samples


def refuse_unordered(values: FloatArray, name: str) -> None:
    """Raise InvalidInputError on nan, and on infinite values at both ends."""
    if np.isnan(values).any():
        raise InvalidInputError(
            f"{name} must not hold nan: leave missing runs out, give failed ones the worst value"
        )
    if np.isposinf(values).any() and np.isneginf(values).any():
        raise InvalidInputError(
            f"{name} hold both inf and -inf: a run that failed is worse than all others at one "
            "end only"
        )


def refuse_infinite(values: FloatArray, name: str) -> None:
    """Raise InvalidInputError unless all values are finite."""
    if not np.isfinite(values).all():
        raise InvalidInputError(
            f"{name} must be finite, but {np.count_nonzero(~np.isfinite(values))} of "
            f"{values.size} are not: leave failed runs out, or take a median"
        )


def checked_level(level: float) -> float:
    """Return a confidence level; InvalidInputError unless it is between 0 and 1."""
    if not 0.0 < level < 1.0:
        raise InvalidInputError(f"the level of an interval must be between 0 and 1, not {level}")
    return level


def checked_resamples(resamples: int) -> int:
    """Return a number of resamples; InvalidInputError unless it is at least 1."""
    if resamples < 1:
        raise InvalidInputError(f"a bootstrap needs at least 1 resample, not {resamples}")
    return resamples
