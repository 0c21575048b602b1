"""Ablations: an experiment with one thing changed, beside the same runs without the change.

They show what a difference from a paper's method does, or why a claim does not hold. They are run
apart from the experiment that the claims are judged by, in few conditions and repetitions, and
have no verdicts.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import msgspec
import numpy as np

from multisrt.experiments.crossing import Condition, conditions
from multisrt.experiments.measures import Measure
from multisrt.experiments.results import Result, Results
from multisrt.experiments.spec import Block, ExperimentSpec
from multisrt.presets.cells import Comparison, Family
from multisrt.presets.findings import weigh_family
from multisrt.presets.words import number, p_text
from multisrt.reporting.claims import PrintedTable
from multisrt.statistics.summaries import median

NOTE = (
    "Medians without and with the change, over all runs, successful or not; in brackets the "
    "estimated difference and the p-value of Wilcoxon's test on pairs of repetitions, for each "
    "figure by itself."
)
"""How to read a table of ablations."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Ablation:
    """One change of an experiment, and the conditions in which it is made.

    Attributes
    ----------
    topic : str
        What the change asks about: a claim, or the differences from the paper. Ablations of one
        topic make one table.
    change : str
        What is changed, as a row of the table names it.
    base, changed : Block
        Conditions without and with the change, in the same order. Those with the change need
        labels of their own.
    measures : tuple of Measure
        What is shown; the same for all ablations of a topic.
    """

    topic: str
    change: str
    base: Block
    changed: Block
    measures: tuple[Measure, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Ablations:
    """The ablations of a preset.

    Attributes
    ----------
    changes : tuple of Ablation
        The ablations, in the order of the page.
    repetitions, quick_repetitions : int
        Repetitions of each condition in the whole experiment and in a quick one. Six is the
        smallest number with which a difference between pairs can be significant.

    Examples
    --------
    >>> from multisrt.presets import PRESETS
    >>> preset = PRESETS["multi-srt"]
    >>> spec = preset.ablations.experiment(preset.experiment(False), quick=True)
    >>> spec.name, spec.repetitions
    ('multi-srt ablations quick', 6)
    """

    changes: tuple[Ablation, ...]
    repetitions: int
    quick_repetitions: int

    def experiment(self, whole: ExperimentSpec, *, quick: bool) -> ExperimentSpec:
        """Return the experiment that has the runs of all ablations.

        Parameters
        ----------
        whole : ExperimentSpec
            The preset's experiment, from which everything else is taken.
        quick : bool
            Whether to make fewer repetitions.

        Returns
        -------
        ExperimentSpec
            An experiment of blocks, in which conditions that several ablations share are run once.
        """
        return msgspec.structs.replace(
            whole,
            name=f"{whole.name.removesuffix(' quick')} ablations{' quick' * quick}",
            about=f"What differences do: {whole.about}",
            blocks=tuple(block for one in self.changes for block in (one.base, one.changed)),
            exclude=(),
            repetitions=self.quick_repetitions if quick else self.repetitions,
            recordings="none",
        )

    def tables(self, results: Results) -> list[PrintedTable]:
        """Return a table for each topic, with a row for each change and condition.

        Parameters
        ----------
        results : Results
            Results of `experiment`, which may be incomplete.

        Returns
        -------
        list of PrintedTable
            The tables, in the order of the topics' first ablations.
        """
        runs: dict[Condition, dict[int, Result]] = {}
        for result in results:
            runs.setdefault(result.condition, {})[result.repetition] = result
        topics = dict.fromkeys(one.topic for one in self.changes)
        return [
            _table(topic, [one for one in self.changes if one.topic == topic], results, runs)
            for topic in topics
        ]


def _table(
    topic: str,
    changes: Sequence[Ablation],
    results: Results,
    runs: dict[Condition, dict[int, Result]],
) -> PrintedTable:
    measures = changes[0].measures
    rows = []
    for one in changes:
        base, changed = (
            conditions(msgspec.structs.replace(results.experiment, blocks=(block,)))
            for block in (one.base, one.changed)
        )
        for before, after in zip(base, changed, strict=True):
            of = runs.get(before, {}), runs.get(after, {})
            fields = [_field(measure, *of) for measure in measures]
            pairs = len(of[0].keys() & of[1].keys())
            rows.append((one.change, _where(before), str(pairs), _successes(*of), *fields))
    return PrintedTable(
        title=topic,
        source="",
        columns=("change", "where", "pairs", "successful", *(m.heading for m in measures)),
        rows=tuple(rows),
        note=NOTE,
    )


def _where(at: Condition) -> str:
    size = at.team or f"{at.robots} robot{'s' * (at.robots != 1)}"
    if at.robots == 1:
        return f"{at.environment}, {at.strategy}, {size}"
    return f"{at.environment}, {at.strategy}, {size}, {at.starts}, {at.radio} radio"


def _successes(before: dict[int, Result], after: dict[int, Result]) -> str:
    return " → ".join(
        f"{sum(run.success for run in side.values())} of {len(side)}" if side else "-"
        for side in (before, after)
    )


def _field(measure: Measure, before: dict[int, Result], after: dict[int, Result]) -> str:
    """Return the medians of both sides, and the difference with its p-value where there is one."""
    sides = [{k: _value(measure, run) for k, run in side.items()} for side in (before, after)]
    if not (sides[0].keys() & sides[1].keys()):
        return "-"
    medians = (number(float(median(np.array([*side.values()]))), measure.digits) for side in sides)
    pair = Comparison(where="", lower=sides[1], higher=sides[0])
    found = weigh_family(Family(comparisons=[pair], quantity=measure))
    assert found is not None
    share = found.ratio.value
    change = f"{100.0 * (share - 1.0):+.0f} %, " if math.isfinite(share) else ""
    return f"{' → '.join(medians)} ({change}p {p_text(found.test.p_value)})"


def _value(measure: Measure, run: Result) -> float:
    value = measure.of(run)
    return math.inf if value is None else value
