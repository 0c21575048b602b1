"""Ablations: an experiment with one thing changed, beside the same runs without the change.

They show what a difference from a paper's method does, or why a claim does not hold. They are made
in few conditions and repetitions. Runs without the change are those of the experiment that the
claims are judged by, where it has them. Where a difference may decide a verdict, that of the runs
with a change is given beside it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import msgspec
import numpy as np

from multisrt.experiments.crossing import Condition, conditions
from multisrt.experiments.measures import Measure
from multisrt.experiments.results import Result, Results
from multisrt.experiments.spec import Block, ExperimentSpec, StartsChoice, StrategyChoice
from multisrt.presets.cells import Cells, Comparison, Family
from multisrt.presets.findings import weigh_family
from multisrt.presets.words import number, p_text
from multisrt.reporting.claims import Claim, PrintedTable
from multisrt.spec import Scalar
from multisrt.statistics.summaries import median

NOTE = (
    "Medians without and with the change, over all runs, successful or not; in brackets the "
    "estimated difference and the p-value of Wilcoxon's test on pairs of repetitions, for each "
    "figure by itself. The difference is estimated by pairs, so its sign may be another than that "
    "of the medians."
)
"""How to read a table of ablations."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Topic:
    """What some ablations ask about. They make one table.

    Attributes
    ----------
    title : str
        Title of the table.
    measures : tuple of Measure
        What is shown.
    claims : tuple of str
        Texts of the claims of which the ablations ask why they do not hold.
    """

    title: str
    measures: tuple[Measure, ...]
    claims: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class Ablation:
    """One change of an experiment, and the conditions in which it is made.

    Attributes
    ----------
    topic : Topic
        What the change asks about.
    change : str
        What is changed, as a row of the table names it.
    base, changed : Block
        Conditions without and with the change, in the same order. Those with the change need
        labels of their own.
    is_quick : bool
        Whether it is part of a quick experiment, too.
    """

    topic: Topic
    change: str
    base: Block
    changed: Block
    is_quick: bool = True

    @property
    def setting(self) -> str:
        """What is set in the place of the experiment's choice, as it is written in a file."""
        changed = [
            (name, before, after)
            for name in Block.__struct_fields__
            if (before := getattr(self.base, name)) != (after := getattr(self.changed, name))
        ]
        return "; ".join(
            text for name, before, after in changed for text in _settings(name, before, after)
        )

    def pairs(self, experiment: ExperimentSpec) -> list[tuple[Condition, Condition]]:
        """Return each condition without the change, and the same one with it.

        Parameters
        ----------
        experiment : ExperimentSpec
            The experiment from which choices are taken that the blocks do not have.
        """
        base, changed = (
            conditions(msgspec.structs.replace(experiment, blocks=(block,), exclude=()))
            for block in (self.base, self.changed)
        )
        return list(zip(base, changed, strict=True))


def with_options(
    choice: StrategyChoice, change: str, options: Mapping[str, Scalar]
) -> StrategyChoice:
    """Return a strategy with other options, and with a label that names the change.

    Examples
    --------
    >>> print(with_options(StrategyChoice(name="minpos"), "to the target", {"replan": "target"}))
    StrategyChoice(name='minpos', label='minpos, to the target', options={'replan': 'target'})
    """
    return StrategyChoice(
        name=choice.name,
        label=f"{choice.label or choice.name}, {change}",
        options={**choice.options, **options},
    )


def _settings(name: str, before: Sequence[object], after: Sequence[object]) -> list[str]:
    """Return what a choice of a block is set to; of strategies, their options that differ."""
    if name != "strategies":
        return [f"{name} = {', '.join(map(_written, after))}"]
    found = []
    for old, new in zip(map(_as_choice, before), map(_as_choice, after), strict=True):
        if old.name != new.name:
            found.append(f"{new.name} in the place of {old.name}")
        found += [
            f"{option} = {_written(value)}"
            for option, value in new.options.items()
            if old.options.get(option) != value
            if old.name == new.name or option not in old.options
        ]
    return [*dict.fromkeys(found)]


def _as_choice(strategy: object) -> StrategyChoice:
    return strategy if isinstance(strategy, StrategyChoice) else StrategyChoice(name=str(strategy))


def _written(value: object) -> str:
    if isinstance(value, StartsChoice):
        return f"{value.how}, drawn" if value.first == "drawn" else value.how
    return str(value).lower() if isinstance(value, bool) else str(value)


OwnTables = Callable[[Cells, Sequence[Ablation]], list[PrintedTable]]
"""Function that returns tables of its own for the runs and the ablations of an experiment."""

Beside = Callable[[Cells], Mapping[str, Sequence[Claim]]]
"""Function that returns, by change, claims of the preset as judged by the runs with it."""

ANY_COVERAGE = 1e-6
"""Share of the explorable area that a run covers in any case."""


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
    own_tables : callable, optional
        ``own_tables(cells, changes)`` returns tables that come before those of the topics, where
        a paper's quantity is not a measure of a run.
    beside : callable, optional
        ``beside(cells)`` returns, by change, claims of the preset as judged by the runs with it.
        These count successful or not, as in the tables.
    run_s : float or None
        Computing time of a run, on average, in seconds of one core; None if it is not known.

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
    own_tables: OwnTables | None = None
    beside: Beside | None = None
    run_s: float | None = None

    def in_worlds_of(self, experiment: ExperimentSpec) -> Ablations | None:
        """Return the ablations that are made in worlds of an experiment; None if none is.

        Parameters
        ----------
        experiment : ExperimentSpec
            The experiment.
        """
        changes = tuple(
            one
            for one in self.changes
            if all(
                world in experiment.environments
                for block in (one.base, one.changed)
                for world in block.environments or ()
            )
        )
        return replace(self, changes=changes) if changes else None

    def experiment(self, whole: ExperimentSpec, *, quick: bool) -> ExperimentSpec:
        """Return the experiment that has the runs of all ablations.

        Parameters
        ----------
        whole : ExperimentSpec
            The preset's experiment, from which everything else is taken.
        quick : bool
            Whether to make fewer repetitions, of fewer ablations.

        Returns
        -------
        ExperimentSpec
            An experiment of blocks, in which conditions that several ablations share are run once.
        """
        changes = [one for one in self.changes if one.is_quick or not quick]
        return msgspec.structs.replace(
            whole,
            name=f"{whole.name.removesuffix(' quick')} ablations{' quick' * quick}",
            about=f"What differences do: {whole.about}",
            blocks=tuple(block for one in changes for block in (one.base, one.changed)),
            exclude=(),
            repetitions=self.quick_repetitions if quick else self.repetitions,
            recordings="none",
        )

    def made_in(self, experiment: ExperimentSpec) -> Ablations:
        """Return the ablations without those that an experiment does not have.

        Parameters
        ----------
        experiment : ExperimentSpec
            The whole experiment of ablations, or the quick one.
        """
        asked = {*conditions(experiment)}
        return replace(
            self,
            changes=tuple(
                one
                for one in self.changes
                if {at for pair in one.pairs(experiment) for at in pair} <= asked
            ),
        )

    def asking_why(self, claim: str) -> list[Ablation]:
        """Return the ablations that ask why a claim does not hold.

        Parameters
        ----------
        claim : str
            Text of the claim.

        Returns
        -------
        list of Ablation
            The ablations, of which several may be the same change in other conditions.
        """
        return [one for one in self.changes if claim in one.topic.claims]

    def verdicts_beside(self, results: Results) -> dict[str, list[tuple[str, Claim]]]:
        """Return the claims that are judged by runs with a change as well.

        Parameters
        ----------
        results : Results
            Results of `experiment`, which may be incomplete.

        Returns
        -------
        dict of str to list of (str, Claim)
            By the text of a claim the changes, each with the claim as judged by its runs.
        """
        found: dict[str, list[tuple[str, Claim]]] = {}
        if self.beside is not None:
            spec = msgspec.structs.replace(results.experiment, success_coverage=ANY_COVERAGE)
            cells = Cells(Results(spec, results, results.planned, results.provenance))
            for change, claims in self.beside(cells).items():
                for claim in claims:
                    found.setdefault(claim.text, []).append((change, claim))
        return found

    def tables(self, results: Results) -> list[PrintedTable]:
        """Return the preset's own tables, and one for each topic.

        Parameters
        ----------
        results : Results
            Results of `experiment`, which may be incomplete.

        Returns
        -------
        list of PrintedTable
            The tables, in the order of the topics' first ablations. Those of topics have a row
            for each change and condition.
        """
        cells = Cells(results)
        changes = self.made_in(results.experiment).changes
        topics = {one.topic.title: one.topic for one in changes}
        own = [] if self.own_tables is None else self.own_tables(cells, changes)
        return [
            *own,
            *(
                _table(topic, [one for one in changes if one.topic == topic], cells)
                for topic in topics.values()
            ),
        ]


def _table(topic: Topic, changes: Sequence[Ablation], cells: Cells) -> PrintedTable:
    rows = []
    for one in changes:
        for before, after in one.pairs(cells.experiment):
            of = cells.by_repetition(before), cells.by_repetition(after)
            fields = [_field(measure, *of) for measure in topic.measures]
            pairs = len(of[0].keys() & of[1].keys())
            rows.append((one.change, _where(before), str(pairs), _successes(*of), *fields))
    return PrintedTable(
        title=topic.title,
        source="",
        columns=("change", "where", "pairs", "successful", *(m.heading for m in topic.measures)),
        rows=tuple(rows),
        note=NOTE,
    )


def _where(at: Condition) -> str:
    size = at.team or f"{at.robots} robot{'s' * (at.robots != 1)}"
    if at.robots == 1:
        return f"{at.environment}, {at.strategy}, {size}"
    return f"{at.environment}, {at.strategy}, {size}, {at.starts}, {at.radio} radio"


def _successes(before: Mapping[int, Result], after: Mapping[int, Result]) -> str:
    return " → ".join(
        f"{sum(run.success for run in side.values())} of {len(side)}" if side else "-"
        for side in (before, after)
    )


def _field(measure: Measure, before: Mapping[int, Result], after: Mapping[int, Result]) -> str:
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
