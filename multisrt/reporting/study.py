"""Results by setting and strategy, and comparisons of strategies with a baseline.

A setting is a condition without its strategy. In a setting, repetition k of every strategy has the
same world, starts, faults and draws of the radio, so that strategies are compared in pairs.
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
"""Seed of every bootstrap: equal results give equal reports."""

HEADLINES = ("known_complete_s", "total_distance_m", "coverage_integral_s", "coverage")
"""Names of the measures that reports discuss by default; the others have tables only."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Summary:
    """Summary of the values of a measure in a condition.

    Attributes
    ----------
    runs : int
        Number of runs.
    measured : int
        Number of runs with a finite value.
    median : float
        Median; infinite if half of the runs or more have no value.
    middle : Interval
        Interquartile mean with its 95 % interval.
    """

    runs: int
    measured: int
    median: float
    middle: Interval


@dataclass(frozen=True, slots=True, kw_only=True)
class Comparison:
    """Comparison of a strategy with the baseline by one measure in one setting.

    Attributes
    ----------
    measure : Measure
        The measure.
    setting : Condition
        The setting; its strategy is empty.
    strategy, baseline : str
        Labels of the two strategies.
    median, baseline_median : float
        Their medians over the pairs.
    pairs : int
        Number of repetitions that both have.
    p_value : float
        P-value of the paired rank test, adjusted by Holm's procedure over all comparisons by the
        measure.
    better_share : float
        Vargha and Delaney's A: probability that a run of the strategy is better, where a tie
        counts half.
    size : str
        Vargha and Delaney's word for the effect.
    mark : {"+", "-", ""}
        Significantly better than the baseline, significantly worse, or neither.
    decidable : bool
        Whether a difference could be significant with this number of pairs.
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
    """Results by setting and strategy.

    Parameters
    ----------
    results : Results
        Results of an experiment.
    baseline : str, optional
        Label of the strategy that the others are compared with; by default the first one.

    Attributes
    ----------
    results : Results
        The results.
    strategies : list of str
        Labels of the strategies, in the order of the experiment.
    settings : list of Condition
        Settings with an empty strategy, in the order of the experiment.
    baseline : str
        Label of the baseline; empty if there are no results.

    Raises
    ------
    InvalidInputError
        If no strategy has the label of the baseline.
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
        """Labels of the strategies that are compared with the baseline."""
        return [strategy for strategy in self.strategies if strategy != self.baseline]

    def of(self, setting: Condition, strategy: str) -> list[Result]:
        """Return the results of a strategy in a setting in the order of repetitions, maybe none."""
        return self._by_condition.get(in_setting(setting, strategy), [])

    def here(self, setting: Condition) -> list[str]:
        """Return the labels of the strategies that have results in a setting."""
        return [strategy for strategy in self.strategies if self.of(setting, strategy)]

    def scenes(self) -> dict[Condition, list[Condition]]:
        """Return the settings by scene, a setting without its team, from the smallest team on."""
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
        """Return the name of a setting, by the properties in which settings differ."""
        return ", ".join((self.scene_name(setting), team_name(setting)))

    def words(self, setting: Condition) -> str:
        """Return the name of a setting as part of a sentence."""
        others = "".join(f", {text}" for text in self._others(setting))
        return f"in {setting.environment} with {team_name(setting)}{others}"

    def scene_name(self, scene: Condition) -> str:
        """Return the name of a setting without its team."""
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
        """Return whether any two runs differ in a measure."""
        values = {measure.of(result) for result in self.results} - {None}
        return len(values) > 1

    def has(self, measure: Measure, setting: Condition) -> bool:
        """Return whether any run in a setting has a value of a measure."""
        return any(
            measure.of(result) is not None
            for strategy in self.here(setting)
            for result in self.of(setting, strategy)
        )

    def summary(self, measure: Measure, setting: Condition, strategy: str) -> Summary | None:
        """Return a summary of a measure in a condition; None if no run has a value."""
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
        """Return the median of a measure in a condition with its interval; None as in `summary`."""
        results = self.of(setting, strategy)
        if not results or not self.has(measure, setting):
            return None
        return bootstrap([measure.values(results)], median, rng=SEED)

    def finite(self, measure: Measure, setting: Condition, strategy: str) -> list[float]:
        """Return the finite values of a measure in a condition."""
        results = [r for r in self.of(setting, strategy) if self._counts(measure, r)]
        return measure.values(results)

    def _counts(self, measure: Measure, result: Result) -> bool:
        return measure.of(result) is not None and (
            not measure.lower_is_better or result.status == "complete"
        )

    # Comparing ---------------------------------------------------------------------------------

    def comparisons(self, measure: Measure) -> list[Comparison]:
        """Return the comparisons of all strategies with the baseline in all settings.

        They are one family of tests, whose p-values are adjusted by Holm's procedure.
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
        # The smallest adjusted p-value that this number of pairs can have.
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
    """Return the name of a team, or its size."""
    return setting.team or f"{setting.robots} robot{'s' * (setting.robots != 1)}"


def chosen_measures(names: Sequence[str] = ()) -> tuple[Measure, ...]:
    """Return the measures of the given names, by default `HEADLINES`.

    Raises
    ------
    InvalidInputError
        If there is no measure of a name.
    """
    return tuple(map(measure_named, dict.fromkeys(names) or HEADLINES))


def other_measures(chosen: Sequence[Measure]) -> list[Measure]:
    """Return all measures but the given ones."""
    names = {measure.name for measure in chosen}
    return [measure for measure in MEASURES if measure.name not in names]
