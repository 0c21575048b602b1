"""Results put in order for reading: settings, strategies, and who is compared with whom.

A setting is a condition without its strategy: within one, repetition k of every strategy met the
same world, starts, faults and draws of the radio, so that strategies are compared pair by pair.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import msgspec
import numpy as np

from multisrt.experiments.crossing import Condition
from multisrt.experiments.measures import MEASURES, Measure, measure_named
from multisrt.experiments.results import Result, Results
from multisrt.geometry.errors import InvalidInputError, did_you_mean
from multisrt.statistics.effect_size import Magnitude, magnitude, vargha_delaney
from multisrt.statistics.intervals import Interval, bootstrap
from multisrt.statistics.rank_tests import (
    SIGNIFICANCE,
    Mark,
    RankTest,
    corrected,
    mark,
    paired,
)
from multisrt.statistics.summaries import interquartile_mean, median

SEED = 0
"""Of every bootstrap, so that the same results give the same report."""

HEADLINES = ("exploration_time_s", "total_distance_m", "coverage_integral_s", "coverage")
"""What reports speak of, unless told otherwise; the other measures are at hand in tables."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Summary:
    """The values of a measure in a condition, in a few numbers.

    Attributes
    ----------
    runs, measured : int
        How many runs there are, and how many of them have a finite value.
    median : float
        Infinite where half of the runs or more have none.
    middle : Interval
        Interquartile mean with its interval.
    """

    runs: int
    measured: int
    median: float
    middle: Interval


@dataclass(frozen=True, slots=True, kw_only=True)
class Comparison:
    """A strategy beside the baseline, by one measure in one setting.

    Attributes
    ----------
    measure : Measure
        By what.
    setting : Condition
        Where; its strategy is empty.
    strategy, baseline : str
        Who.
    median, baseline_median : float
        Of the pairs' runs.
    pairs : int
        Repetitions that both have.
    p_value : float
        Of the paired rank test, corrected by Holm's procedure over all comparisons by the measure.
    better_share : float
        Vargha and Delaney's A: probability that a run of the strategy is better, ties half.
    size : str
        Vargha and Delaney's word for it.
    mark : str
        "+" significantly better than the baseline, "-" worse, "" neither.
    decidable : bool
        Whether so many pairs could be significant at all, were they all to say the same.
    """

    measure: Measure
    setting: Condition
    strategy: str
    baseline: str
    median: float
    baseline_median: float
    pairs: int
    p_value: float
    better_share: float
    size: Magnitude
    mark: Mark
    decidable: bool


class Study:
    """Results in the order in which reports go through them.

    Parameters
    ----------
    results : Results
        What came out.
    baseline : str, optional
        Which strategy the others are compared with; by default the first.

    Attributes
    ----------
    results : Results
        As given.
    strategies : list of str
        Their labels, in the experiment's order.
    settings : list of Condition
        Where they ran, in the experiment's order; the strategy is empty.
    baseline : str
        Empty where there are no results.

    Raises
    ------
    InvalidInputError
        If the baseline is none of the strategies.
    """

    def __init__(self, results: Results, baseline: str | None = None) -> None:
        self.results = results
        self._by_condition: dict[Condition, list[Result]] = defaultdict(list)
        for result in results:
            self._by_condition[result.condition].append(result)
        for found in self._by_condition.values():
            found.sort(key=lambda result: result.repetition)
        self.strategies = list(dict.fromkeys(c.strategy for c in self._by_condition))
        self.settings = list(dict.fromkeys(map(setting_of, self._by_condition)))
        if baseline is not None and baseline not in self.strategies:
            raise InvalidInputError(
                f"the results have no strategy {baseline!r}"
                f"{did_you_mean(baseline, self.strategies)}; they have: "
                f"{', '.join(self.strategies) or 'none'}"
            )
        self.baseline = baseline or next(iter(self.strategies), "")
        self._varying = {
            name
            for name in ("starts", "radio", "body", "faults")
            if len({getattr(setting, name) for setting in self.settings}) > 1
        }
        self._compared: dict[str, list[Comparison]] = {}

    @property
    def rivals(self) -> list[str]:
        """The strategies that are compared with the baseline."""
        return [strategy for strategy in self.strategies if strategy != self.baseline]

    def of(self, setting: Condition, strategy: str) -> list[Result]:
        """Return the results of a strategy in a setting, by repetition; there may be none."""
        return self._by_condition.get(in_setting(setting, strategy), [])

    def here(self, setting: Condition) -> list[str]:
        """Return the strategies that have results in a setting."""
        return [strategy for strategy in self.strategies if self.of(setting, strategy)]

    def scenes(self) -> dict[Condition, list[Condition]]:
        """Return the settings by all but the size of the team, from the smallest team."""
        scenes: dict[Condition, list[Condition]] = defaultdict(list)
        for setting in self.settings:
            scenes[msgspec.structs.replace(setting, robots=0, team="")].append(setting)
        return {
            scene: sorted(settings, key=lambda s: (s.robots, s.team))
            for scene, settings in scenes.items()
        }

    def shared_settings(self) -> list[Condition]:
        """Return the settings in which all strategies have results."""
        return [s for s in self.settings if len(self.here(s)) == len(self.strategies)]

    def name(self, setting: Condition) -> str:
        """Name a setting, by what settings differ in."""
        return ", ".join((self.scene_name(setting), team_name(setting)))

    def words(self, setting: Condition) -> str:
        """Name a setting in a sentence."""
        others = "".join(f", {text}" for text in self._others(setting))
        return f"in {setting.environment} with {team_name(setting)}{others}"

    def scene_name(self, scene: Condition) -> str:
        """Name a setting without its team's size."""
        return ", ".join((scene.environment, *self._others(scene)))

    def _others(self, setting: Condition) -> list[str]:
        titles = {"starts": "starts", "radio": "radio", "body": "body", "faults": "faults"}
        return [
            f"{title} {getattr(setting, name)}"
            for name, title in titles.items()
            if name in self._varying
        ]

    # Measures ----------------------------------------------------------------------------------

    def varies(self, measure: Measure) -> bool:
        """Whether a measure tells any two runs apart."""
        values = {measure.of(result) for result in self.results} - {None}
        return len(values) > 1

    def has(self, measure: Measure, setting: Condition) -> bool:
        """Whether any run in a setting has a value of a measure."""
        return any(
            measure.of(result) is not None
            for strategy in self.here(setting)
            for result in self.of(setting, strategy)
        )

    def summary(self, measure: Measure, setting: Condition, strategy: str) -> Summary | None:
        """Sum up a measure in a condition; None where it has no runs, or none is measured."""
        results = self.of(setting, strategy)
        if not results or not self.has(measure, setting):
            return None
        values = np.array(measure.values(results))
        return Summary(
            runs=len(values),
            measured=sum(self._counts(measure, result) for result in results),
            median=float(median(values)),
            middle=bootstrap([values], interquartile_mean, rng=SEED),
        )

    def median_interval(
        self, measure: Measure, setting: Condition, strategy: str
    ) -> Interval | None:
        """Median of a measure in a condition with its interval; None as in `summary`."""
        results = self.of(setting, strategy)
        if not results or not self.has(measure, setting):
            return None
        return bootstrap([measure.values(results)], median, rng=SEED)

    def finite(self, measure: Measure, setting: Condition, strategy: str) -> list[float]:
        """Return the values of the runs that have one."""
        results = [r for r in self.of(setting, strategy) if self._counts(measure, r)]
        return measure.values(results)

    def _counts(self, measure: Measure, result: Result) -> bool:
        return measure.of(result) is not None and (
            not measure.lower_is_better or result.status == "complete"
        )

    # Comparing ---------------------------------------------------------------------------------

    def comparisons(self, measure: Measure) -> list[Comparison]:
        """Compare every strategy with the baseline in every setting, by one measure.

        All of them are one family of tests, which is corrected by Holm's procedure.
        """
        if measure.name not in self._compared:
            self._compared[measure.name] = self._compare(measure)
        return self._compared[measure.name]

    def _compare(self, measure: Measure) -> list[Comparison]:
        found = []
        for setting in self.settings:
            if not self.has(measure, setting):
                continue
            for strategy in self.rivals:
                a, b = self._pairs(measure, setting, strategy)
                if a:
                    found.append((setting, strategy, a, b))
        tests = corrected([paired(a, b) for _, _, a, b in found])
        pairs = [len(a) for _, _, a, _ in found]
        return [
            self._comparison(measure, setting, strategy, a, b, test, pairs)
            for (setting, strategy, a, b), test in zip(found, tests, strict=True)
        ]

    def _pairs(
        self, measure: Measure, setting: Condition, strategy: str
    ) -> tuple[list[float], list[float]]:
        mine = {result.repetition: result for result in self.of(setting, strategy)}
        theirs = {result.repetition: result for result in self.of(setting, self.baseline)}
        both = sorted(mine.keys() & theirs.keys())
        return (
            measure.values(mine[repetition] for repetition in both),
            measure.values(theirs[repetition] for repetition in both),
        )

    def _comparison(
        self,
        measure: Measure,
        setting: Condition,
        strategy: str,
        a: Sequence[float],
        b: Sequence[float],
        test: RankTest,
        pairs: Iterable[int],
    ) -> Comparison:
        a_lower = vargha_delaney(a, b)
        # The clearest that so many pairs can be, after all comparisons that could be clearer.
        clearest = 2.0 ** (1 - len(a)) * sum(other <= len(a) for other in pairs)
        return Comparison(
            measure=measure,
            setting=setting,
            strategy=strategy,
            baseline=self.baseline,
            median=float(median(np.array(a))),
            baseline_median=float(median(np.array(b))),
            pairs=len(a),
            p_value=test.p_value,
            better_share=a_lower if measure.lower_is_better else 1.0 - a_lower,
            size=magnitude(a_lower),
            mark=mark(test, lower_is_better=measure.lower_is_better),
            decidable=clearest < SIGNIFICANCE,
        )


def setting_of(condition: Condition) -> Condition:
    """Return a condition without its strategy."""
    return in_setting(condition, "")


def in_setting(setting: Condition, strategy: str) -> Condition:
    """Return the condition of a strategy in a setting."""
    return msgspec.structs.replace(setting, strategy=strategy)


def team_name(setting: Condition) -> str:
    """Say how large a team is, or what it is called."""
    return setting.team or f"{setting.robots} robot{'s' * (setting.robots != 1)}"


def chosen_measures(names: Sequence[str] = ()) -> tuple[Measure, ...]:
    """Return the measures of these names, or those that reports speak of.

    Raises
    ------
    InvalidInputError
        If there is none of a name.
    """
    return tuple(map(measure_named, dict.fromkeys(names) or HEADLINES))


def other_measures(chosen: Sequence[Measure]) -> list[Measure]:
    """Return all measures but these."""
    names = {measure.name for measure in chosen}
    return [measure for measure in MEASURES if measure.name not in names]
