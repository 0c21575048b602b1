"""Tables of results: a measure by condition and strategy, success, gaps, growth, computing time."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from multisrt.experiments.crossing import Condition
from multisrt.experiments.measures import TO_HORIZON, Measure, measure_named
from multisrt.experiments.results import Result, Results
from multisrt.geometry.errors import InvalidInputError
from multisrt.reporting.layout import Cell, Table, number, slug
from multisrt.reporting.study import SEED, Comparison, Study, team_name
from multisrt.reporting.words import (
    INFINITY_NOTE,
    UNCLAIMED,
    constants_note,
    horizon_note,
    reference_notes,
    significance_note,
    success_words,
    unclaimed_note,
)
from multisrt.statistics.intervals import Interval, wilson
from multisrt.statistics.power_law import fit_power_law
from multisrt.statistics.profiles import gap

__all__ = [
    "Table",
    "computing_table",
    "gap_table",
    "growth_table",
    "measure_table",
    "success_table",
    "summary_table",
]

MIN_RUNS_FOR_INTERVALS = 10
"""Minimum number of runs for which bootstrap intervals have about their nominal coverage."""

NOTHING = Cell(text="", sort=math.inf)
"""Cell of a condition without runs."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Gap:
    """How a time is reported as a gap above another.

    Attributes
    ----------
    title : str
        Title of tables and figures.
    column : str
        Heading of a column.
    there : callable
        Whether a run that was measured has the other time, or needs none.
    """

    title: str
    column: str
    there: Callable[[Result], bool]


GAPS = {
    "over_informed": Gap(
        title="Time to 99 % above that of the informed plan",
        column="99 % above informed",
        there=lambda result: result.reference is not None,
    ),
    "over_bound": Gap(
        title="Makespan above its lower bound",
        column="Makespan above bound",
        # A run that covers no more than is seen from the starts has no bound.
        there=lambda result: result.failed or measure_named("over_bound").of(result) is not None,
    ),
}
"""Divisors of times, by the names of the measures."""


def summary_table(
    results: Results, measure: Measure | str, *, baseline: str | None = None
) -> Table:
    """Return the table of a measure: a row for each setting, a column for each strategy.

    Parameters
    ----------
    results : Results
        Results of an experiment.
    measure : Measure or str
        A measure or its name.
    baseline : str, optional
        Label of the strategy that marks compare with; by default the first one.

    Returns
    -------
    Table
        Medians with interquartile means and their intervals.

    Raises
    ------
    InvalidInputError
        If there is no such measure or strategy.
    """
    chosen = measure_named(measure) if isinstance(measure, str) else measure
    return measure_table(Study(results, baseline), chosen)


def measure_table(study: Study, measure: Measure) -> Table:
    """Return the table of a measure; see `summary_table`."""
    compared = {(c.setting, c.strategy): c for c in study.comparisons(measure)}
    rows = []
    for setting in study.settings:
        cells = [
            _summary_cell(study, measure, setting, strategy, compared.get((setting, strategy)))
            for strategy in study.strategies
        ]
        rows.append((*labels(study, setting), *cells))
    notes = [
        "Median of all runs, and in brackets the interquartile mean with its "
        f"95 % interval (stratified bootstrap); it is left out where it equals the median. "
        f"{'Lower' if measure.lower_is_better else 'Higher'} is better."
    ]
    sizes = [
        len(study.distinct(s, name))
        for s in study.settings
        for name in study.here(s)
        if not study.is_constant(s, name)
    ]
    fewest = min(sizes, default=0)
    if 1 < fewest < MIN_RUNS_FOR_INTERVALS:
        notes.append(
            f"Some conditions have only {fewest} runs: bootstrap intervals of so few runs are too "
            "narrow."
        )
    if measure.name in TO_HORIZON:
        notes.append(horizon_note(study))
    if any(c.kind != "none" for c in compared.values()):
        notes.append(significance_note(study, measure))
    if study.has_constants:
        notes.append(constants_note(study))
    if any("∞" in cell.line for row in rows for cell in row):
        notes.append(INFINITY_NOTE)
    if any(study.is_unknown(measure, strategy) for strategy in study.strategies):
        notes.append(unclaimed_note(study))
    return Table(
        name=slug(measure.name),
        title=measure.heading,
        columns=("World", "Team", *study.strategies),
        rows=tuple(rows),
        labels=2,
        notes=tuple(notes),
    )


def success_table(study: Study) -> Table:
    """Return the table of the shares of runs that are a success, and of how runs ended."""

    def cell(setting: Condition, strategy: str) -> Cell:
        results = study.distinct(setting, strategy)
        good = sum(result.success for result in results)
        share = wilson(good, len(results))
        ends = Counter(result.status for result in results)
        told = [f"{100 * share.low:.0f} to {100 * share.high:.0f} %"]
        if study.is_constant(setting, strategy):
            told = ["1 run"]
        if set(ends) != {"complete"}:
            told += [f"{count} {status.replace('_', ' ')}" for status, count in ends.items()]
        return Cell(
            text=f"{good} of {len(results)}",
            detail=f"({', '.join(told)})",
            sort=share.value,
            data={
                "successes": good,
                "runs": len(study.of(setting, strategy)),
                "distinct": len(results),
                "low": share.low,
                "high": share.high,
                **{str(status): count for status, count in ends.items()},
            },
        )

    notes = [
        "In brackets Wilson's 95 % interval of the success rate; then how the runs ended, unless "
        "all of them were complete."
    ]
    if study.has_constants:
        notes.append(constants_note(study))
    return Table(
        name="success-rates",
        title=f"Successful runs: {success_words(study.results)}",
        columns=("World", "Team", *study.strategies),
        rows=_rows(study, cell),
        labels=2,
        notes=tuple(notes),
    )


def gap_table(study: Study) -> Table | None:
    """Return the table of times above those of the informed plan and above lower bounds.

    None if runs have neither.
    """
    found = {name: gaps_above(study, name) for name in GAPS}
    there = {name: gaps for name, gaps in found.items() if gaps}
    if not there:
        return None
    rows = [
        (Cell(text=strategy), *(_gap_cell(gaps[strategy]) for gaps in there.values()))
        for strategy in study.strategies
    ]
    notes = [
        "Interquartile mean over all runs in the settings that all strategies share, with its 95 % "
        "interval (stratified bootstrap). Unsuccessful runs, and runs that never cover 99 % where "
        "this is compared, count as infinite."
    ]
    if "over_informed" in there:
        notes.append(
            f"Informed: {_settings(study, 'over_informed')}; 0 % is the time in which a team that "
            "knows the map covers 99 % from the same starts: less may be possible."
        )
    if "over_bound" in there:
        notes.append(
            f"Bound: {_settings(study, 'over_bound')}; 0 % is a time in which no team of these "
            "robots can see the share that was covered, even if it knows the map."
        )
    return Table(
        name="gap",
        title="; ".join(GAPS[name].title for name in there).replace("; M", "; m"),
        columns=("Strategy", *(GAPS[name].column for name in there)),
        rows=tuple(rows),
        notes=(*notes, *reference_notes(study)),
    )


def _settings(study: Study, name: str) -> str:
    count = len(settings_with(study, name))
    return f"{count} setting{'s' * (count != 1)}"


def _gap_cell(found: Interval) -> Cell:
    return Cell(
        text=_percent(found.value),
        detail=f"({_percent(found.low)} to {_percent(found.high)})",
        sort=found.value,
        data={"gap": found.value, "low": found.low, "high": found.high},
    )


def gaps_above(study: Study, name: str) -> dict[str, Interval]:
    """Return the gaps between times and what a measure in `GAPS` divides them by, by strategy."""
    over = measure_named(name)
    settings = settings_with(study, name)
    if not settings:
        return {}
    gaps = {}
    for strategy in study.strategies:
        ratios = [np.array(over.values(study.of(setting, strategy))) for setting in settings]
        gaps[strategy] = gap(ratios, [1.0] * len(ratios), rng=SEED)
    return gaps


def settings_with(study: Study, name: str) -> list[Condition]:
    """Return the settings that all strategies share and whose times can all be divided.

    Parameters
    ----------
    study : Study
        The results.
    name : str
        A measure in `GAPS`: every measured run has what its time is divided by.
    """
    found = []
    for setting in study.shared_settings():
        results = [r for strategy in study.strategies for r in study.of(setting, strategy)]
        measured = [result for result in results if result.metrics is not None]
        if measured and all(map(GAPS[name].there, measured)):
            found.append(setting)
    return found


def growth_table(study: Study, measure: Measure) -> Table | None:
    """Return the table of how a measure changes with team size; None if nothing can be fitted."""
    rows = []
    for scene, settings in study.scenes().items():
        cells = []
        for strategy in study.strategies:
            sizes: list[float] = []
            values: list[float] = []
            for setting in settings:
                own = measure.values(study.distinct(setting, strategy))
                if study.is_unknown(measure, strategy):
                    continue
                sizes += [float(setting.robots)] * len(own)
                values += own
            cells.append(_growth_cell(sizes, values))
        if any(cell is not NOTHING for cell in cells):
            rows.append((Cell(text=study.scene_name(scene)), *cells))
    if not rows:
        return None
    return Table(
        name=f"growth-{slug(measure.name)}",
        title=f"{measure.title}: change with team size",
        columns=("World", *study.strategies),
        rows=tuple(rows),
        notes=(
            "Exponent of a power law in the number of robots, fitted to all runs, with its 95 % "
            "interval: with -1 twice the robots need half, with 0 team size has no effect. "
            "Empty if any run was unsuccessful, or if there are too few runs.",
        ),
    )


def computing_table(study: Study) -> Table:
    """Return the table of computing time and memory of runs."""

    def cell(setting: Condition, strategy: str) -> Cell:
        results = study.distinct(setting, strategy)
        times = [result.computing_s for result in results]
        memory = max(result.memory_mb for result in results)
        middle = float(np.median(times))
        return Cell(
            text=number(middle, 2),
            detail=f"(at most {number(max(times), 2)} s, {number(memory, 0)} MB)",
            sort=middle,
            data={"median_s": middle, "most_s": max(times), "most_mb": memory},
        )

    return Table(
        name="computing",
        title="Computing time of a run (s)",
        columns=("World", "Team", *study.strategies),
        rows=_rows(study, cell),
        labels=2,
        notes=("Median, and in brackets the maximum of time and memory over all runs.",),
    )


def _rows(study: Study, cell: Callable[[Condition, str], Cell]) -> tuple[tuple[Cell, ...], ...]:
    """Return a row for each setting, with a cell for each strategy."""
    rows = []
    for setting in study.settings:
        cells = [
            cell(setting, strategy) if study.distinct(setting, strategy) else NOTHING
            for strategy in study.strategies
        ]
        rows.append((*labels(study, setting), *cells))
    return tuple(rows)


def labels(study: Study, setting: Condition) -> tuple[Cell, Cell]:
    """Return the cells that name a setting: its world and its team."""
    return (
        Cell(text=study.scene_name(setting)),
        Cell(text=team_name(setting), sort=None if setting.team else setting.robots),
    )


def _summary_cell(
    study: Study,
    measure: Measure,
    setting: Condition,
    strategy: str,
    compared: Comparison | None,
) -> Cell:
    found = study.summary(measure, setting, strategy)
    if found is None:
        told = study.is_unknown(measure, strategy) and study.of(setting, strategy)
        return Cell(text=UNCLAIMED, sort=math.inf) if told else NOTHING
    middle = found.middle
    low, value, high = (number(v, measure.digits) for v in (middle.low, middle.value, middle.high))
    data: dict[str, str | int | float] = {
        "median": found.median,
        "iqm": middle.value,
        "low": middle.low,
        "high": middle.high,
        "runs": found.runs,
        "distinct": found.distinct,
        "measured": found.measured,
    }
    if compared is not None:
        data |= {"mark": compared.mark, "A": compared.better_share}
        data |= {} if compared.p_value is None else {"p": compared.p_value}
    # One run has no interval.
    detail = ""
    if found.distinct > 1:
        same = value == number(found.median, measure.digits)
        detail = f"[{low} to {high}]" if same else f"[{value}: {low} to {high}]"
    if study.is_constant(setting, strategy):
        detail = "(1 run)"
    return Cell(
        text=number(found.median, measure.digits),
        detail=detail,
        mark="" if compared is None else compared.mark,
        sort=found.median,
        data=data,
    )


def _growth_cell(sizes: list[float], values: list[float]) -> Cell:
    if not all(0.0 < value < math.inf for value in values):
        return NOTHING
    try:
        law = fit_power_law(sizes, values).exponent
    except InvalidInputError:
        # There are too few runs, or teams of one size only.
        return NOTHING
    return Cell(
        text=number(law.value, 2),
        detail=f"({number(law.low, 2)} to {number(law.high, 2)})",
        sort=law.value,
        data={"exponent": law.value, "low": law.low, "high": law.high},
    )


def _percent(share: float) -> str:
    return number(share, 0) if math.isinf(share) else f"{number(100 * share, 0)} %"
