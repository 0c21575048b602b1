"""Gains of MinPos and its rivals: reductions of exploration times, in percent.

Two strategies have the same world and starts in each repetition, and the ratio of their two times
is what gains are computed from. Claims are judged by signed ranks, in which failed runs count as
the slowest; tables show geometric means of the ratios, which favour neither strategy. Repetitions
are shared by all team sizes and strategies, so tests and intervals take them as wholes.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from multisrt.experiments.crossing import Condition
from multisrt.experiments.measures import Measure, measure_named
from multisrt.experiments.results import Results
from multisrt.geometry.numerics.arrays import FloatArray
from multisrt.presets.cells import Cells, Comparison, Family
from multisrt.presets.findings import weigh_family
from multisrt.presets.minpos_experiment import WORLDS
from multisrt.reporting.claims import Verdict
from multisrt.statistics.intervals import LEVEL, Interval, bootstrap

MIN_PAIRS = 6
"""Minimum number of complete pairs of each condition for an interval of a gain."""

TIME, TO_99 = measure_named("known_complete_s"), measure_named("time_to_99_s")
"""The time by which the claims are judged, and the one that is shown beside it.

With a radio of unlimited range all robots are done within seconds of the first one, so that the
time until then would show nothing else; what is left after 99 % of coverage may take long.
"""

Ratios = dict[int, float]
"""Logarithms of the ratios of two times by repetition; infinite where one of the runs failed."""


class Times:
    """The exploration times of an experiment's teams.

    Parameters
    ----------
    results : Results
        Results of the experiment, which may be incomplete.
    measure : Measure
        Which time.
    """

    def __init__(self, results: Results, measure: Measure = TIME) -> None:
        self.cells = Cells(results)
        self.measure = measure
        self._at: dict[tuple[str, str, int], Condition] = {
            (at.environment, at.strategy, at.robots): at for at in self.cells.conditions()
        }
        self.teams = sorted({robots for _, _, robots in self._at if robots > 1})
        self.places = [(world, robots) for world in WORLDS for robots in self.teams]

    def values(self, world: str, robots: int, strategy: str) -> list[float]:
        """Return the times of complete runs."""
        found = self.cells.values(self._at[world, strategy, robots], self.measure)
        return [value for value in found.values() if np.isfinite(value)]

    def waiting(self, world: str, robots: int, strategy: str) -> str:
        """Return the share of the robots' time in which they stood still, in percent, as text."""
        runs = [run.metrics for run in self.cells.of(self._at[world, strategy, robots])]
        measured = [metrics for metrics in runs if metrics is not None]
        if not measured:
            return "-"
        waited = sum(metrics.waiting_time_s for metrics in measured)
        return f"{100.0 * waited / sum(robots * metrics.makespan_s for metrics in measured):.1f}"

    def compared(self, world: str, robots: int, strategy: str, rival: str) -> Comparison:
        """Return the comparison of a strategy with a rival, in pairs of repetitions."""
        return self.cells.compared(
            f"{world}, {robots} robots",
            lower=self._at[world, strategy, robots],
            higher=self._at[world, rival, robots],
            measure=self.measure,
        )

    def ratios(self, world: str, robots: int, strategy: str, rival: str) -> Ratios:
        """Return the logarithms of the ratios of both times, without pairs of two failed runs."""
        ours, theirs = (self._at[world, one, robots] for one in (strategy, rival))
        return ratios_of(self.cells, self.measure, ours, theirs)

    def family_gain(
        self,
        places: Sequence[tuple[str, int]],
        strategy: str,
        rival: str,
        level: float = LEVEL,
    ) -> Interval | None:
        """Return the gain of a strategy on a rival by the one test of several cells, in percent.

        It is that of the ratio at which neither is the faster one by signed ranks; see
        `ratio_of`. Failed runs are worse than all others. None if a cell has too few pairs.

        Parameters
        ----------
        places : sequence of (str, int)
            Worlds and team sizes of the cells.
        strategy, rival : str
            The strategies.
        level : float, optional
            Confidence level of the interval.
        """
        cells = [self.compared(*at, strategy, rival) for at in places]
        if not cells or min(len(cell.repetitions) for cell in cells) < MIN_PAIRS:
            return None
        found = weigh_family(Family(comparisons=cells, quantity=self.measure), level=level)
        assert found is not None
        of = found.ratio
        value, low, high = (100.0 * (1.0 - end) for end in (of.value, of.high, of.low))
        return Interval(value, low, high)

    def over(self, strategy: str, rival: str) -> list[Ratios]:
        """Return the ratios of a strategy's times to those of a rival, for each condition."""
        return [self.ratios(*at, strategy, rival) for at in self.places]

    def gain_of_means(self, strategy: str, rival: str) -> float | None:
        """Return the gain by ratios of mean times, averaged over all conditions, in percent.

        Means are over repetitions in which neither run failed. None if a condition has too few.
        """
        gains = []
        for at in self.places:
            ours, theirs = np.array(self.compared(*at, strategy, rival).pairs)
            both = np.isfinite(ours) & np.isfinite(theirs)
            if np.count_nonzero(both) < MIN_PAIRS:
                return None
            gains.append(100.0 * (1.0 - float(ours[both].mean() / theirs[both].mean())))
        return float(np.mean(gains)) if gains else None

    def slopes(self, world: str, strategy: str, rival: str) -> Ratios:
        """Return by how much the ratio changes with each doubling of the team, in logarithms.

        It is the slope of the line of least squares through the ratios of all team sizes, by
        repetition, without those that lack one; infinite where runs failed.
        """
        doublings = np.log2(self.teams) - np.mean(np.log2(self.teams))
        by_team = [self.ratios(world, robots, strategy, rival) for robots in self.teams]
        if len(by_team) < 2:
            return {}
        slopes = {}
        for repetition in sorted(set.intersection(*(set(of) for of in by_team))):
            parts = zip(doublings.tolist(), (of[repetition] for of in by_team), strict=True)
            # Failures in a small team and in a large one leave no slope.
            with np.errstate(invalid="ignore"):
                slope = sum(np.float64(ratio) * x for x, ratio in parts if x != 0.0)
            if not np.isnan(slope):
                slopes[repetition] = float(slope / np.sum(doublings**2))
        return slopes


def ratios_of(cells: Cells, measure: Measure, ours: Condition, theirs: Condition) -> Ratios:
    """Return the logarithms of the ratios of the times under two conditions.

    Pairs of two failed runs are left out.
    """
    both = cells.compared("", lower=ours, higher=theirs, measure=measure)
    return {
        repetition: float(np.log(of_ours) - np.log(of_theirs))
        for repetition, of_ours, of_theirs in zip(both.repetitions, *both.pairs, strict=True)
        if np.isfinite(of_ours) or np.isfinite(of_theirs)
    }


def gain(cells: Sequence[Ratios], level: float = LEVEL) -> Interval | None:
    """Return a gain in percent with its interval; None if a condition has too few pairs.

    The interval is a percentile bootstrap of repetitions. Those of one number are drawn together
    in all conditions, which may share their world and starts.

    Parameters
    ----------
    cells : sequence of Ratios
        Logarithms of the ratios of times, by condition. All conditions have equal weights.
    level : float, optional
        Confidence level of the interval.
    """
    finite = [complete(of) for of in cells]
    if not finite or min(map(len, finite)) < MIN_PAIRS:
        return None
    means = [float(np.mean([*of.values()])) for of in finite]
    # A pair of which a run failed has the mean of its condition.
    by_repetition = [
        float(np.mean([of.get(k, mean) for of, mean in zip(finite, means, strict=True)]))
        for k in sorted(set().union(*finite))
    ]
    return bootstrap([by_repetition], _percent, level=level, rng=0)


def complete(ratios: Ratios) -> Ratios:
    """Return the ratios of pairs in which neither run failed."""
    return {repetition: ratio for repetition, ratio in ratios.items() if np.isfinite(ratio)}


def gain_text(found: Interval | None) -> str:
    """Return a gain in percent with its interval as text."""
    if found is None:
        return "-"
    return f"{found.value:+.1f} ({found.low:+.1f} to {found.high:+.1f})"


def _percent(log_ratios: FloatArray) -> FloatArray:
    return np.asarray(100.0 * (1.0 - np.exp(np.mean(log_ratios, axis=-1))))


class Largest(NamedTuple):
    """The largest of several gains.

    Attributes
    ----------
    gain : Interval
        The largest estimate, between the largest of all lower bounds and the largest of all upper
        bounds.
    at, low_at, high_at : str
        Names of the gains that have these.
    """

    gain: Interval
    at: str
    low_at: str
    high_at: str


def largest(gains: Mapping[str, Interval]) -> Largest:
    """Return the largest of several gains with the interval that theirs imply.

    If all intervals hold together, the largest gain is at least the largest of their lower bounds,
    and at most the largest of their upper bounds, which need not be of the same gain. The interval
    of the largest estimate alone bounds that gain, not the largest one.

    Parameters
    ----------
    gains : mapping from str to Interval
        Gains by name, at least one, with simultaneous intervals.

    Examples
    --------
    >>> found = largest({"few": Interval(9.0, 6.0, 12.0), "many": Interval(11.0, 1.0, 21.0)})
    >>> found.gain, found.at, found.low_at, found.high_at
    (Interval(value=11.0, low=6.0, high=21.0), 'many', 'few', 'many')
    """
    at = max(gains, key=lambda name: gains[name].value)
    low_at = max(gains, key=lambda name: gains[name].low)
    high_at = max(gains, key=lambda name: gains[name].high)
    ends = gains[at].value, gains[low_at].low, gains[high_at].high
    return Largest(Interval(*ends), at, low_at, high_at)


def reaches(found: Interval | None, printed: float) -> Verdict:
    """Return the verdict on a printed gain; `rule` says it in words.

    It does not hold if the whole interval of our gain is below it. Otherwise it holds if the
    interval is above 0.
    """
    if found is None:
        return "not tested"
    if found.high < printed:
        return "does not hold"
    return "holds" if found.low > 0.0 else "inconclusive"


def rule(printed: float) -> str:
    """Return the rule of `reaches` in words."""
    return (
        f"it holds if our gain is above 0 and not smaller than {printed:g} %: if the interval is "
        f"above 0, and not all of it below {printed:g} %; a larger gain does not refute it"
    )
