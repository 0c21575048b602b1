"""What the values of runs may be, and refusing what they may not."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.numerics.arrays import FloatArray


def sample_of(values: ArrayLike, name: str = "values") -> FloatArray:
    """Take the values of some runs, of which some may have failed.

    Parameters
    ----------
    values : array_like, shape (n,)
        At least one number, none of them nan. Runs that failed have one infinite value, ``inf``
        or ``-inf``, whichever is worse than all others.
    name : str
        What an error calls them.

    Returns
    -------
    ndarray of float, shape (n,)

    Raises
    ------
    InvalidInputError
        If it is anything else.
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
    """Take the values of some runs none of which failed; else like `sample_of`."""
    sample = sample_of(values, name)
    refuse_infinite(sample, name)
    return sample


def ascending(places: ArrayLike, name: str) -> FloatArray:
    """Take the places of an axis: finite, each above the one before, else InvalidInputError."""
    at = finite_sample_of(places, name)
    if np.any(np.diff(at) <= 0.0):
        raise InvalidInputError(f"{name} must ascend, each above the one before")
    return at


def strata_of(strata: Sequence[ArrayLike], name: str = "strata") -> list[FloatArray]:
    """Take the values of runs, one array for each task.

    Raises
    ------
    InvalidInputError
        If there is no stratum, or one of them is no sample (see `sample_of`), or a failure is
        ``inf`` in one and ``-inf`` in another.
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
    """Give a level of confidence, or raise InvalidInputError unless it is between 0 and 1."""
    if not 0.0 < level < 1.0:
        raise InvalidInputError(f"the level of an interval must be between 0 and 1, not {level}")
    return level


def checked_resamples(resamples: int) -> int:
    """Give a number of resamples, or raise InvalidInputError unless it is at least 1."""
    if resamples < 1:
        raise InvalidInputError(f"a bootstrap needs at least 1 resample, not {resamples}")
    return resamples
