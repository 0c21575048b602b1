"""What is significant and what is not, in plain sentences that claim no more than the numbers."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from multisrt.experiments.measures import Measure
from multisrt.reporting.layout import number
from multisrt.reporting.study import Comparison, Study, team_name
from multisrt.statistics.rank_tests import SIGNIFICANCE

LESS_AND_MORE = {
    "exploration_time_s": ("needs {} less time", "needs {} more time"),
    "makespan_s": ("is home {} sooner", "is home {} later"),
    "total_distance_m": ("drives {} less", "drives {} more"),
}
"""What is said of some measures where the median is lower or higher, by so many percent."""

HOW_TO_READ = (
    "Strategies are compared run by run under the same conditions (paired Wilcoxon signed-rank "
    "test); p-values are corrected by Holm's procedure over all comparisons by one measure, and a "
    f"difference is called significant where p < {SIGNIFICANCE:g}. A is the probability that a run "
    "of the one named first is better than one of the other (Vargha and Delaney), 0.5 being "
    "neither. Runs that were not complete count as worse than all others. No significant "
    "difference does not mean that there is none."
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Findings:
    """What one measure says.

    Attributes
    ----------
    measure : Measure
        By what strategies were compared.
    counts : tuple of str
        A sentence for each strategy: in how many settings it is better or worse.
    significant : tuple of str
        A sentence for each significant difference.
    others : tuple of str
        A sentence for each group of comparisons without one.
    too_few : str
        How many comparisons and runs there are, if none of them could be significant; else empty.
    """

    measure: Measure
    counts: tuple[str, ...]
    significant: tuple[str, ...]
    others: tuple[str, ...]
    too_few: str = ""


def findings(study: Study, measure: Measure) -> Findings:
    """Say what a measure tells about the strategies, compared with the baseline."""
    compared = study.comparisons(measure)
    if not compared:
        nothing = (_nothing_compared(study),)
        return Findings(measure=measure, counts=(), significant=(), others=nothing)
    return Findings(
        measure=measure,
        counts=tuple(_counts(study, compared)),
        significant=tuple(difference(study, c) for c in compared if c.mark),
        others=tuple(_groups(study, [c for c in compared if not c.mark])),
        too_few="" if any(c.decidable for c in compared) else _too_few(compared),
    )


def difference(study: Study, found: Comparison) -> str:
    """Say a significant difference in a sentence."""
    digits, unit = found.measure.digits, found.measure.unit
    of = " ".join((number(found.median, digits), unit)).strip()
    against = " ".join((number(found.baseline_median, digits), unit)).strip()
    where = study.words(found.setting)
    return (
        f"{where[0].upper()}{where[1:]} {_what_differs(found)} "
        f"(median {of} against {against}; {found.pairs} pairs, paired rank test, Holm-corrected "
        f"p {p_value(found.p_value)}; A = {found.better_share:.2f}, {found.size})."
    )


def p_value(p: float) -> str:
    """Write a p-value with its sign.

    Examples
    --------
    >>> p_value(0.0321), p_value(0.00004)
    ('= 0.032', '< 0.001')
    """
    return "< 0.001" if p < 0.001 else f"= {p:.2g}"


def what_was_run(study: Study) -> str:
    """Say in a sentence or two what was run and how it went."""
    results = study.results
    made, asked = len(results), results.asked
    worlds = len({setting.environment for setting in study.settings})
    teams = list(dict.fromkeys(team_name(setting) for setting in study.settings))
    failed = sum(result.failed for result in results)
    text = f"{_counted(asked, 'run')} asked for, {made} made"
    if made < asked:
        text += f" ({asked - made} still missing: what follows is of those that are there)"
    text += f"; {failed or 'none'} of them failed. "
    if study.strategies:
        text += (
            f"{_counted(len(study.strategies), 'strategy', 'strategies')} "
            f"({_listed(study.strategies)}) in {_counted(worlds, 'world')}, with {_listed(teams)}."
        )
    return text


def _what_differs(found: Comparison) -> str:
    mine, theirs = found.median, found.baseline_median
    strategy, baseline, measure = found.strategy, found.baseline, found.measure
    lower = (found.mark == "+") == measure.lower_is_better
    title = measure.title.partition(":")[0]
    title = f"{title[0].lower()}{title[1:]}"
    # The ranks decide; medians may be equal, or infinite, or even point the other way.
    if not (math.isfinite(mine) and math.isfinite(theirs)) or theirs <= 0.0:
        better = "better" if found.mark == "+" else "worse"
        return f"{strategy} does significantly {better} than {baseline} by {title}"
    if (mine < theirs) != lower or mine == theirs:
        tends = "lower" if lower else "higher"
        return f"{strategy} tends to a {tends} {title} than {baseline}"
    change = _change(mine, theirs)
    if measure.name in LESS_AND_MORE:
        verb = LESS_AND_MORE[measure.name][not lower].format(change)
        return f"{strategy} {verb} than {baseline}"
    tends = "lower" if lower else "higher"
    return f"the {title} is {change} {tends} with {strategy} than with {baseline}"


def _change(mine: float, theirs: float) -> str:
    percent = 100.0 * abs(mine - theirs) / theirs
    return f"{number(percent, 0 if percent >= 1.0 else 2)} %"


def _nothing_compared(study: Study) -> str:
    if len(study.strategies) < 2:
        return "There is one strategy only, so that there is nothing to compare."
    return (
        f"No strategy has runs with such values beside {study.baseline} under the same "
        "conditions, so that there is nothing to compare."
    )


def _counts(study: Study, compared: Sequence[Comparison]) -> list[str]:
    sentences = []
    for strategy in study.rivals:
        own = [c for c in compared if c.strategy == strategy]
        kinds = (
            ("better in {}", sum(c.mark == "+" for c in own)),
            ("worse in {}", sum(c.mark == "-" for c in own)),
            ("no significant difference in {}", sum(not c.mark and c.decidable for c in own)),
            ("too few runs to tell in {}", sum(not c.mark and not c.decidable for c in own)),
        )
        if own:
            told = ", ".join(text.format(count) for text, count in kinds if count)
            settings = _counted(len(own), "setting")
            sentences.append(f"{strategy} against {study.baseline}, {settings}: {told}.")
    return sentences


def _groups(study: Study, unclear: Sequence[Comparison]) -> list[str]:
    sentences = []
    for strategy in study.rivals:
        own = [c for c in unclear if c.strategy == strategy]
        decided = [c for c in own if c.decidable]
        undecided = [c for c in own if not c.decidable]
        if decided:
            which = "; ".join(
                f"{study.name(c.setting)} (p {p_value(c.p_value)}, A = {c.better_share:.2f})"
                for c in decided
            )
            sentences.append(
                f"No significant difference between {strategy} and {study.baseline}: {which}."
            )
        if undecided:
            which = "; ".join(study.name(c.setting) for c in undecided)
            sentences.append(
                f"Too few runs to tell {strategy} from {study.baseline}, however clear a "
                f"difference were ({_pairs(undecided)} of runs): {which}."
            )
    return sentences


def _too_few(compared: Sequence[Comparison]) -> str:
    return f"{_counted(len(compared), 'comparison')} of {_pairs(compared)}"


def _pairs(compared: Sequence[Comparison]) -> str:
    pairs = sorted({c.pairs for c in compared})
    if len(pairs) == 1:
        return _counted(pairs[0], "pair")
    return f"{pairs[0]} to {pairs[-1]} pairs"


def _counted(count: int, one: str, many: str | None = None) -> str:
    return f"{count:,} {one if count == 1 else many or one + 's'}"


def _listed(items: Sequence[str]) -> str:
    return items[0] if len(items) == 1 else f"{', '.join(items[:-1])} and {items[-1]}"
