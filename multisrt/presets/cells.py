"""The runs of an experiment by condition, and their comparisons in pairs of repetitions.

A repetition has one seed: in all conditions the same worlds, the same first or the same drawn
starts, and the same streams of random numbers. So the runs of two conditions are pairs, whether
these differ in their strategy, team size or radio, and the cells of a family share repetitions.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from copy import copy
from dataclasses import dataclass, field
from typing import Protocol

from multisrt.experiments.crossing import Condition, conditions
from multisrt.experiments.measures import Measure
from multisrt.experiments.results import Result, Results


class Quantity(Protocol):
    """The quantity of a comparison, as tables show it; a `Measure` is one."""

    @property
    def heading(self) -> str:
        """Title with unit."""

    @property
    def unit(self) -> str:
        """Unit; may be empty."""

    @property
    def digits(self) -> int:
        """Number of decimals in texts."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Comparison:
    """Two sets of runs under one condition, of which the first is claimed to have lower values.

    Attributes
    ----------
    where : str
        Name of the comparison.
    lower, higher : mapping from int to float
        Values of the two sets by repetition, infinite for failed runs; empty without runs.
    paired : bool
        Whether the cell's own test is that of pairs (Wilcoxon's) or that of independent runs
        (Mann and Whitney's). The test of the family is another matter; see `Family`.
    """

    where: str
    lower: Mapping[int, float]
    higher: Mapping[int, float]
    paired: bool = True

    @property
    def repetitions(self) -> list[int]:
        """Repetitions that both sets have."""
        return sorted(self.lower.keys() & self.higher.keys())

    @property
    def pairs(self) -> tuple[list[float], list[float]]:
        """Values of both sets in the repetitions that both have."""
        both = self.repetitions
        return [self.lower[k] for k in both], [self.higher[k] for k in both]

    @property
    def sides(self) -> tuple[list[float], list[float]]:
        """Values of both sets that the cell's own test compares."""
        if self.paired:
            return self.pairs
        return list(self.lower.values()), list(self.higher.values())

    @property
    def has_runs(self) -> bool:
        """Whether there are pairs of runs."""
        return bool(self.repetitions)

    @property
    def min_p_value(self) -> float:
        """Smallest p-value that the cell's own test can have; 1 without runs."""
        if not self.has_runs:
            return 1.0
        n, m = map(len, self.sides)
        return min(1.0, 2.0 / (2.0**n if self.paired else float(math.comb(n + m, n))))


@dataclass(frozen=True, slots=True, kw_only=True)
class Family:
    """The comparisons that a claim makes, by one quantity.

    Attributes
    ----------
    comparisons : list of Comparison
        The cells of the family, including those without runs. They share repetitions.
    quantity : Quantity
        What is compared.
    paired : bool
        Whether values with one repetition number are pairs, with the same world or starts. If
        not, one number still means one repetition in all cells of a side.
    parts : mapping of str to Family
        Some of the cells, by name, which are also tested by themselves; no verdict depends on it.
    """

    comparisons: list[Comparison]
    quantity: Quantity
    paired: bool = True
    parts: Mapping[str, Family] = field(default_factory=dict)

    @property
    def with_runs(self) -> list[Comparison]:
        """The comparisons that have runs."""
        return [comparison for comparison in self.comparisons if comparison.has_runs]

    @property
    def min_p_value(self) -> float:
        """Smallest p-value that the family's test can have; 1 without runs."""
        found = self.with_runs
        if self.paired:
            n = len(set().union(*(comparison.repetitions for comparison in found)))
            return min(1.0, 2.0 / 2.0**n)
        n, m = (
            len(set().union(*sides))
            for sides in ([one.lower for one in found], [one.higher for one in found])
        )
        return min(1.0, 2.0 / math.comb(n + m, n))


class Cells:
    """The runs of an experiment by condition; conditions without runs are included.

    Parameters
    ----------
    results : Results
        Results of the experiment, which may be incomplete.
    """

    def __init__(self, results: Results) -> None:
        self.experiment = results.experiment
        self._runs: dict[Condition, dict[int, Result]] = {
            condition: {} for condition in conditions(results.experiment)
        }
        for result in results:
            self._runs.setdefault(result.condition, {})[result.repetition] = result

    def where(self, is_meant: Callable[[Condition], bool]) -> Cells:
        """Return the cells without the conditions for which a function returns false."""
        some = copy(self)
        some._runs = {at: runs for at, runs in self._runs.items() if is_meant(at)}
        return some

    def conditions(self) -> list[Condition]:
        """Return all conditions, in the order of the experiment."""
        return list(self._runs)

    def of(self, condition: Condition) -> list[Result]:
        """Return the runs of a condition."""
        return list(self.by_repetition(condition).values())

    def by_repetition(self, condition: Condition) -> Mapping[int, Result]:
        """Return the runs of a condition by repetition."""
        return self._runs.get(condition, {})

    def values(self, condition: Condition, measure: Measure) -> dict[int, float]:
        """Return a measure of the runs of a condition by repetition; failed runs are infinite."""
        runs = self.by_repetition(condition)
        return dict(zip(runs, measure.values(runs.values()), strict=True))

    def compared(
        self,
        where: str,
        *,
        lower: Condition,
        higher: Condition,
        measure: Measure,
        paired: bool = True,
    ) -> Comparison:
        """Return the comparison of two conditions; see `Comparison` for its parameters."""
        return Comparison(
            where=where,
            lower=self.values(lower, measure),
            higher=self.values(higher, measure),
            paired=paired,
        )
