"""Results by setting and strategy, and comparisons of strategies with a baseline.

A setting is a condition without its strategy. In a setting, repetition k of every strategy has the
same world, starts, faults and draws of the radio, so that strategies are compared in pairs.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Literal

import msgspec
import numpy as np

from multisrt.experiments.crossing import Condition
from multisrt.experiments.measures import MEASURES, Measure, measure_named
from multisrt.experiments.modules import choices_of
from multisrt.experiments.results import Result, Results, setting_of
from multisrt.geometry.errors import InvalidInputError, did_you_mean
from multisrt.robots.registry import is_built_in
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

CLAIM = "known_complete_s"
"""Name of the measure that rests on what explorers record about their own maps."""

HEADLINES = (
    "time_to_95_s",
    "known_complete_s",
    "makespan_s",
    "total_distance_m",
    "coverage_integral_s",
    "coverage",
)
"""Names of the measures that reports discuss by default; the others have tables only."""

DELIVERY = ("delivered_coverage", "delivery_delay_s")
"""Names of those that they discuss, too, if there is a base station."""

Kind = Literal["paired", "one-sample", "none"]
"""Test of a comparison: of two samples, of a sample and one run for every seed, or of two such."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Summary:
    """Summary of the values of a measure in a condition.

    Attributes
    ----------
    runs : int
        Number of runs, copies included.
    distinct : int
        Number of distinct runs, from which all else is computed.
    measured : int
        Number of distinct runs with a finite value.
    median : float
        Median; infinite if half of the runs or more have no value.
    middle : Interval
        Interquartile mean with its 95 % interval.
    """

    runs: int
    distinct: int
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
    kind : {"paired", "one-sample", "none"}
        How the two are tested. A strategy whose runs do not depend on the seed has one value:
        a sample is compared with it by the one-sample signed-rank test, and two such values are
        not tested, because they do not vary.
    pairs : int
        Number of repetitions that both have, or of distinct runs that are compared with one value.
    p_value : float or None
        P-value of the signed-rank test, adjusted by Holm's procedure over all tests by the
        measure; None without a test.
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
    kind: Kind
    pairs: int
    p_value: float | None
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
    unclaimed : set of str
        Labels of user-defined strategies that succeed, and of which no run has a `MapComplete`
        that counts: when their robots know the map complete is not known.

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
        self.unclaimed = _unclaimed(results)

    @property
    def rivals(self) -> list[str]:
        """Labels of the strategies that are compared with the baseline."""
        return [strategy for strategy in self.strategies if strategy != self.baseline]

    def rivals_in(self, measure: Measure) -> list[str]:
        """Return the labels of the strategies that are compared with the baseline in a measure."""
        if self.is_unknown(measure, self.baseline):
            return []
        return [name for name in self.rivals if not self.is_unknown(measure, name)]

    def of(self, setting: Condition, strategy: str) -> list[Result]:
        """Return the results of a strategy in a setting in the order of repetitions, maybe none."""
        return self._by_condition.get(in_setting(setting, strategy), [])

    def distinct(self, setting: Condition, strategy: str) -> list[Result]:
        """Return the distinct runs of a strategy in a setting: those that were made.

        For one that was made and is not here, the first of its copies stands.
        """
        found: dict[int, Result] = {}
        for result in sorted(self.of(setting, strategy), key=lambda one: one.same_as is not None):
            made = result.repetition if result.same_as is None else result.same_as
            found.setdefault(made, result)
        return list(found.values())

    def is_constant(self, setting: Condition, strategy: str) -> bool:
        """Return whether a strategy has one run in a setting that is the same for every seed."""
        distinct = self.distinct(setting, strategy)
        return len(distinct) == 1 and not distinct[0].chance

    @property
    def has_constants(self) -> bool:
        """Whether some strategy has one run in a setting that is the same for every seed."""
        return any(self.is_constant(s, name) for s in self.settings for name in self.here(s))

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
        """Return whether any two runs that were measured differ in a measure, or in having it."""
        return len({measure.of(r) for r in self.results if r.metrics is not None}) > 1

    def has(self, measure: Measure, setting: Condition) -> bool:
        """Return whether any run in a setting has a value of a measure."""
        return any(
            measure.of(result) is not None
            for strategy in self.here(setting)
            for result in self.of(setting, strategy)
        )

    def is_unknown(self, measure: Measure, strategy: str) -> bool:
        """Return whether a strategy does not tell what a measure is about."""
        return measure.name == CLAIM and strategy in self.unclaimed

    def summary(self, measure: Measure, setting: Condition, strategy: str) -> Summary | None:
        """Return a summary of a measure in a condition; None if no run has a value."""
        results = self.distinct(setting, strategy)
        if not results or not self.has(measure, setting) or self.is_unknown(measure, strategy):
            return None
        values = np.array(measure.values(results))
        return Summary(
            runs=len(self.of(setting, strategy)),
            distinct=len(results),
            measured=sum(map(measure.counts, results)),
            median=float(median(values)),
            middle=bootstrap([values], interquartile_mean, rng=SEED),
        )

    def median_interval(
        self, measure: Measure, setting: Condition, strategy: str
    ) -> Interval | None:
        """Return the median of a measure in a condition with its interval; None as in `summary`."""
        results = self.distinct(setting, strategy)
        if not results or not self.has(measure, setting) or self.is_unknown(measure, strategy):
            return None
        return bootstrap([measure.values(results)], median, rng=SEED)

    def finite(self, measure: Measure, setting: Condition, strategy: str) -> list[float]:
        """Return the finite values of a measure in a condition."""
        if self.is_unknown(measure, strategy):
            return []
        return measure.values(filter(measure.counts, self.distinct(setting, strategy)))

    # Comparing ---------------------------------------------------------------------------------

    def comparisons(self, measure: Measure) -> list[Comparison]:
        """Return the comparisons of all strategies with the baseline in all settings.

        They are one family of tests, whose p-values are adjusted by Holm's procedure.
        """
        if measure.name not in self._compared:
            self._compared[measure.name] = self._compare(measure)
        return self._compared[measure.name]

    def _compare(self, measure: Measure) -> list[Comparison]:
        found: list[_Sides] = []
        for setting in self.settings:
            if self.has(measure, setting):
                for strategy in self.rivals_in(measure):
                    sides = self._sides(measure, setting, strategy)
                    if sides.mine:
                        found.append(sides)
        tested = [sides for sides in found if sides.kind != "none"]
        tests = iter(corrected([paired(sides.mine, sides.theirs) for sides in tested]))
        pairs = [len(sides.mine) for sides in tested]
        return [
            self._comparison(measure, sides, None if sides.kind == "none" else next(tests), pairs)
            for sides in found
        ]

    def _sides(self, measure: Measure, setting: Condition, strategy: str) -> _Sides:
        """Return the values of a strategy and of the baseline that are compared."""
        mine = {result.repetition: result for result in self.distinct(setting, strategy)}
        theirs = {result.repetition: result for result in self.distinct(setting, self.baseline)}
        constant = [self.is_constant(setting, name) for name in (strategy, self.baseline)]
        kind: Kind = "none" if all(constant) else "one-sample" if any(constant) else "paired"
        both = sorted(mine.keys() & theirs.keys())
        a = measure.values(mine[k] for k in (mine if any(constant) else both))
        b = measure.values(theirs[k] for k in (theirs if any(constant) else both))
        # One value stands for each run of the other side.
        if constant[0] and not constant[1]:
            a *= len(b)
        elif constant[1] and not constant[0]:
            b *= len(a)
        if not (a and b):
            a, b = [], []
        return _Sides(setting=setting, strategy=strategy, kind=kind, mine=a, theirs=b)

    def _comparison(
        self, measure: Measure, sides: _Sides, test: RankTest | None, pairs: Iterable[int]
    ) -> Comparison:
        a, b = sides.mine, sides.theirs
        a_lower = vargha_delaney(a, b)
        # The smallest adjusted p-value that this number of pairs can have.
        clearest = 2.0 ** (1 - len(a)) * sum(other <= len(a) for other in pairs)
        return Comparison(
            measure=measure,
            setting=sides.setting,
            strategy=sides.strategy,
            baseline=self.baseline,
            median=float(median(np.array(a))),
            baseline_median=float(median(np.array(b))),
            kind=sides.kind,
            pairs=len(a),
            p_value=None if test is None else test.p_value,
            better_share=a_lower if measure.lower_is_better else 1.0 - a_lower,
            size=magnitude(a_lower),
            mark="" if test is None else mark(test, lower_is_better=measure.lower_is_better),
            decidable=test is not None and clearest < SIGNIFICANCE,
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class _Sides:
    """Values of a strategy and of the baseline in a setting, in pairs; empty without runs."""

    setting: Condition
    strategy: str
    kind: Kind
    mine: list[float]
    theirs: list[float]


def _unclaimed(results: Results) -> set[str]:
    claim = measure_named(CLAIM)
    claimed = {r.condition.strategy for r in results if claim.of(r) is not None}
    # One that never succeeds is behind in this as in all else.
    good = {r.condition.strategy for r in results if r.success}
    names = {choice.label or choice.name: choice.name for choice in choices_of(results.experiment)}
    return {label for label in good - claimed if not is_built_in(names.get(label, label))}


def in_setting(setting: Condition, strategy: str) -> Condition:
    """Return the condition of a strategy in a setting."""
    return msgspec.structs.replace(setting, strategy=strategy)


def team_name(setting: Condition) -> str:
    """Return the name of a team, or its size."""
    return setting.team or f"{setting.robots} robot{'s' * (setting.robots != 1)}"


def chosen_measures(study: Study, names: Sequence[str] = ()) -> tuple[Measure, ...]:
    """Return the measures of the given names, by default `HEADLINES` and perhaps `DELIVERY`.

    Raises
    ------
    InvalidInputError
        If there is no measure of a name.
    """
    has_base = any(r.metrics and r.metrics.delivered_coverage is not None for r in study.results)
    return tuple(
        map(measure_named, dict.fromkeys(names) or (*HEADLINES, *(DELIVERY if has_base else ())))
    )


def other_measures(chosen: Sequence[Measure]) -> list[Measure]:
    """Return all measures but the given ones; success has tables of its own."""
    names = {"success", *(measure.name for measure in chosen)}
    return [measure for measure in MEASURES if measure.name not in names]
