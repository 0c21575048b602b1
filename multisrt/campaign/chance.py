"""Random choices of a campaign: from streams that depend on nothing but their keys."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TypeVar

import numpy as np

Choice = TypeVar("Choice")


class Chance:
    """Random choices from a stream that its keys determine.

    Numbers are rounded to three significant digits, so that a spec is read easily.

    Parameters
    ----------
    *keys : int
        Keys of the stream, 0 or positive, the seed of the campaign first.

    Examples
    --------
    >>> Chance(7, 1).number(1.0, 2.0) == Chance(7, 1).number(1.0, 2.0)
    True
    """

    def __init__(self, *keys: int) -> None:
        seed, *others = keys
        self._rng = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=tuple(others)))

    def happens(self, probability: float) -> bool:
        """Return whether something of a probability happens."""
        return bool(self._rng.random() < probability)

    def number(self, low: float, high: float) -> float:
        """Return a number, uniform between two bounds."""
        return rounded(float(self._rng.uniform(low, high)))

    def magnitude(self, low: float, high: float) -> float:
        """Return a positive number whose logarithm is uniform between those of two bounds."""
        return rounded(math.exp(float(self._rng.uniform(math.log(low), math.log(high)))))

    def whole(self, low: int, high: int) -> int:
        """Return a whole number, uniform from `low` to `high`, both included."""
        return int(self._rng.integers(low, high + 1))

    def one_of(self, choices: Sequence[Choice]) -> Choice:
        """Return one of some choices, each as likely as the others."""
        return choices[self.whole(0, len(choices) - 1)]

    def weighted(self, choices: Mapping[Choice, float]) -> Choice:
        """Return one of some choices, by their weights."""
        names = list(choices)
        bounds = np.cumsum(list(choices.values()))
        return names[int(np.searchsorted(bounds, self._rng.random() * bounds[-1], side="right"))]

    def some_of(self, choices: Sequence[Choice], number: int) -> list[Choice]:
        """Return some different ones of some choices, in their order."""
        taken = self._rng.permutation(len(choices))[: max(number, 0)]
        return [choices[i] for i in sorted(taken.tolist())]


def rounded(value: float) -> float:
    """Return a number with three significant digits.

    Examples
    --------
    >>> rounded(0.0123456), rounded(123456.0)
    (0.0123, 123000.0)
    """
    return float(f"{value:.3g}")
