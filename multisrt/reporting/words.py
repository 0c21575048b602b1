"""Sentences on what is significant, which claim no more than the tests do."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import count

from multisrt.experiments.measures import Measure
from multisrt.experiments.results import Results
from multisrt.geometry.errors import counted
from multisrt.reporting.layout import number
from multisrt.reporting.study import Comparison, Study, team_name
from multisrt.robots.naming import joined
from multisrt.statistics.rank_tests import SIGNIFICANCE

LESS_AND_MORE = {
    "time_to_95_s": ("covers 95 % in {} less time", "covers 95 % in {} more time"),
    "known_complete_s": ("needs {} less time", "needs {} more time"),
    "makespan_s": ("is home {} sooner", "is home {} later"),
    "total_distance_m": ("drives {} less", "drives {} more"),
}
"""Predicates for a lower and a higher median, with room for the difference in percent."""

HOW_TO_READ = (
    "Strategies are compared in pairs of runs under the same conditions (paired Wilcoxon "
    "signed-rank test). A strategy whose runs are the same for every seed has one run; the runs of "
    "another are compared with it by the one-sample signed-rank test, and two such runs without a "
    "test. P-values are adjusted by Holm's procedure over all tests by one "
    f"measure; a difference is significant if p < {SIGNIFICANCE:g}. A is the probability that a "
    "run of the first strategy is better than a run of the second (Vargha and Delaney); 0.5 means "
    "no difference. Unsuccessful runs count as worse than all others. A difference that "
    "is not significant may still exist."
)

INFINITY_NOTE = (
    "∞: too many runs were unsuccessful, or did not reach the threshold, for a finite value; "
    "they count as worse than all others."
)


UNCLAIMED = "\N{EN DASH}"
"""What stands for a time that a strategy does not tell."""

HOW_TO_REFER = (
    "For times beside those of a team that knows the map, repeat the command that made the runs "
    'with --reference informed (in Python reference="informed"): it repeats no run.'
)


def success_words(results: Results) -> str:
    """Return what makes a run a success.

    Parameters
    ----------
    results : Results
        Results of an experiment.

    Returns
    -------
    str
        The threshold, in words.
    """
    percent = 100.0 * results.experiment.success_coverage
    return f"at least {percent:g} % of the explorable area covered, without a collision"


def totals(results: Results) -> str:
    """Return how many runs succeeded, how many are distinct, and how they ended.

    Parameters
    ----------
    results : Results
        Results of an experiment.

    Returns
    -------
    str
        Such as "38 of 40 runs succeeded (39 complete, 1 stalled)".
    """
    good = sum(result.success for result in results)
    copies = sum(result.same_as is not None for result in results)
    ends = Counter(result.status.replace("_", " ") for result in results)
    told = [f"{count} {status}" for status, count in ends.items()]
    if copies:
        told.append(f"{len(results) - copies} distinct")
    outcome = f" ({', '.join(told)})" if told else ""
    return f"{good} of {results.planned} runs succeeded{outcome}"


def horizon_note(study: Study) -> str:
    """Return a sentence on the time to which integrals run."""
    if study.results.experiment.horizon_s is not None:
        return f"Integrals run to {study.results.experiment.horizon_s:g} s."
    found = sorted({r.horizon_s for r in study.results if r.horizon_s is not None})
    if not found:
        return "No run was measured."
    span = number(found[0], 1) + (f" to {number(found[-1], 1)}" if len(found) > 1 else "")
    return f"Integrals run to the end of the longest run of each setting ({span} s)."


def reference_notes(study: Study) -> list[str]:
    """Return which settings have no informed plan, and why; without any plan, how to get them.

    Parameters
    ----------
    study : Study
        The results.

    Returns
    -------
    list of str
        A sentence for each reason.
    """
    results = study.results
    lacking = results.unreferenced
    if not lacking and all(result.reference is None for result in results):
        return [HOW_TO_REFER]
    by_reason: dict[str, list[str]] = {}
    for setting, why in lacking.items():
        by_reason.setdefault(why, []).append(study.name(setting))
    return [f"Not beside the plan: {'; '.join(names)} ({why})." for why, names in by_reason.items()]


def unclaimed_note(study: Study) -> str:
    """Return a sentence on strategies that do not tell when a robot knows its map complete."""
    return (
        f"{UNCLAIMED}: no run of {joined(sorted(study.unclaimed))} records a MapComplete that "
        "counts; when a robot knows its map complete is unknown, and not compared."
    )


def constants_note(study: Study) -> str:
    """Return a sentence on strategies that have one run in a setting, the same for every seed."""
    copies = max(
        len(study.of(setting, strategy))
        for setting in study.settings
        for strategy in study.here(setting)
        if study.is_constant(setting, strategy)
    )
    return (
        f"(1 run): {counted(copies, 'repetition')}, 1 distinct run, because nothing in it depends "
        "on the seed. It counts once and has no interval."
    )


def significance_note(study: Study, measure: Measure) -> str:
    """Return a sentence on the marks of a table whose columns are each a family of tests."""
    tested = [found for found in study.comparisons(measure) if found.kind != "none"]
    tests = len(tested)
    if not any(found.decidable for found in tested):
        return (
            f"{_pairs(tested)} of runs: no difference can be significant; take at least "
            f"{enough_pairs(tests)} repetitions."
        )
    return (
        f"+ significantly better than {study.baseline}, - significantly worse, no mark: no "
        "significant difference (Wilcoxon signed-rank test, p < 0.05 after Holm's correction over "
        f"all {tests} comparisons by one measure)."
    )


def enough_pairs(tests: int) -> int:
    """Return how many pairs each of some rank tests needs for any difference to be significant.

    Parameters
    ----------
    tests : int
        Number of tests that are corrected together.

    Returns
    -------
    int
        The least number of pairs, if all tests have as many.

    Examples
    --------
    >>> enough_pairs(1), enough_pairs(10)
    (6, 9)
    """
    return next(pairs for pairs in count(1) if tests * 2.0 ** (1 - pairs) < SIGNIFICANCE)


@dataclass(frozen=True, slots=True, kw_only=True)
class Findings:
    """Sentences on the comparisons by one measure.

    Attributes
    ----------
    measure : Measure
        The measure.
    counts : tuple of str
        A sentence per strategy on the number of settings in which it is better or worse.
    significant : tuple of str
        A sentence per significant difference.
    others : tuple of str
        A sentence per group of comparisons without a significant difference, and per pair of
        strategies that have one run each.
    too_few : str
        The numbers of comparisons and pairs if they are too few for any significance, else empty.
    """

    measure: Measure
    counts: tuple[str, ...]
    significant: tuple[str, ...]
    others: tuple[str, ...]
    too_few: str = ""


def findings(study: Study, measure: Measure) -> Findings:
    """Return the sentences on the comparisons of the strategies with the baseline."""
    compared = study.comparisons(measure)
    if not compared:
        nothing = (_nothing_compared(study),)
        return Findings(measure=measure, counts=(), significant=(), others=nothing)
    return Findings(
        measure=measure,
        counts=tuple(_counts(study, compared)),
        significant=tuple(difference(study, c) for c in compared if c.mark),
        others=(
            *_groups(study, [c for c in compared if not c.mark and c.kind != "none"]),
            *(_without_test(study, c) for c in compared if c.kind == "none"),
        ),
        too_few=""
        if any(c.decidable or c.kind == "none" for c in compared)
        else _too_few(compared),
    )


def difference(study: Study, found: Comparison) -> str:
    """Return a sentence on a significant difference."""
    digits, unit = found.measure.digits, found.measure.unit
    of = " ".join((number(found.median, digits), unit)).strip()
    against = " ".join((number(found.baseline_median, digits), unit)).strip()
    assert found.p_value is not None
    test = (
        f"{found.pairs} pairs, paired rank test"
        if found.kind == "paired"
        else f"{found.pairs} runs against one, one-sample rank test"
    )
    return (
        f"{_where(study, found)} {_what_differs(found)} (median {of} against {against}; {test}, "
        f"Holm-corrected p {p_value(found.p_value)}; A = {found.better_share:.2f}, {found.size})."
    )


def _where(study: Study, found: Comparison) -> str:
    where = study.words(found.setting)
    return f"{where[0].upper()}{where[1:]}"


def _without_test(study: Study, found: Comparison) -> str:
    digits, unit = found.measure.digits, found.measure.unit
    mine, theirs = number(found.median, digits), number(found.baseline_median, digits)
    return (
        f"{_where(study, found)} {found.strategy} and {found.baseline} have one run each, the same "
        f"for every seed: {mine} against {theirs} {unit}".rstrip()
        + "."
    )


def p_value(p: float) -> str:
    """Return a p-value as text, with its relational sign.

    Examples
    --------
    >>> p_value(0.0321), p_value(0.00004)
    ('= 0.032', '< 0.001')
    """
    return "< 0.001" if p < 0.001 else f"= {p:.2g}"


def what_was_run(study: Study) -> str:
    """Return some sentences on the numbers of runs, failures, strategies, worlds and teams."""
    results = study.results
    made, planned = len(results), results.planned
    worlds = len({setting.environment for setting in study.settings})
    teams = list(dict.fromkeys(team_name(setting) for setting in study.settings))
    failed = Counter(r.status.replace("_", " ") for r in results if r.failed)
    copies = sum(result.same_as is not None for result in results)
    text = counted(planned, "run")
    if made < planned:
        text += (
            f" asked for, {made} made ({planned - made} still missing; this report covers those "
            "that were made)"
        )
    if copies:
        text += (
            f", {made - copies} of them distinct: where nothing depends on the seed, repetitions "
            "are one run"
        )
    ends = ", ".join(f"{count} {status}" for status, count in failed.items())
    if not failed:
        text += "; all succeeded" if made > 1 else "; it succeeded" if made else ""
    else:
        are = "is" if failed.total() == 1 else "are"
        text += f"; {failed.total()} of the runs {are} unsuccessful ({ends})"
    text += f". Success: {success_words(results)}. "
    if study.strategies:
        text += (
            f"{counted(len(study.strategies), 'strategy', 'strategies')} "
            f"({joined(study.strategies)}) in {counted(worlds, 'world')}, with {joined(teams)}."
        )
    return text


def _what_differs(found: Comparison) -> str:
    mine, theirs = found.median, found.baseline_median
    strategy, baseline, measure = found.strategy, found.baseline, found.measure
    lower = (found.mark == "+") == measure.lower_is_better
    title = measure.title.partition(":")[0]
    title = f"{title[0].lower()}{title[1:]}"
    # The test is on ranks: medians may be equal, infinite, or even differ the other way.
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
        return "There is only one strategy, so there is nothing to compare."
    return (
        f"No strategy shares conditions with {study.baseline} in which both have such values, so "
        "there is nothing to compare."
    )


def _counts(study: Study, compared: Sequence[Comparison]) -> list[str]:
    sentences = []
    for strategy in study.rivals:
        own = [c for c in compared if c.strategy == strategy]
        kinds = (
            ("better in {}", sum(c.mark == "+" for c in own)),
            ("worse in {}", sum(c.mark == "-" for c in own)),
            ("no significant difference in {}", sum(not c.mark and c.decidable for c in own)),
            (
                "too few runs to tell in {}",
                sum(not c.mark and not c.decidable and c.kind != "none" for c in own),
            ),
            ("one run each in {}", sum(c.kind == "none" for c in own)),
        )
        if own:
            told = ", ".join(text.format(count) for text, count in kinds if count)
            settings = counted(len(own), "setting")
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
                if c.p_value is not None
            )
            sentences.append(
                f"No significant difference between {strategy} and {study.baseline}: {which}."
            )
        if undecided:
            which = "; ".join(study.name(c.setting) for c in undecided)
            sentences.append(
                f"Too few runs for a significant difference between {strategy} and "
                f"{study.baseline} ({_pairs(undecided)} of runs): {which}."
            )
    return sentences


def _too_few(compared: Sequence[Comparison]) -> str:
    return f"{counted(len(compared), 'comparison')} of {_pairs(compared)}"


def _pairs(compared: Sequence[Comparison]) -> str:
    pairs = sorted({c.pairs for c in compared})
    if len(pairs) == 1:
        return counted(pairs[0], "pair")
    return f"{pairs[0]} to {pairs[-1]} pairs"
