"""One table for all: success, coverage, both ends of the exploration, and distance."""

from __future__ import annotations

from collections.abc import Sequence

from multisrt.experiments.crossing import Condition
from multisrt.experiments.measures import Measure, measure_named
from multisrt.experiments.results import Results
from multisrt.reporting.layout import Cell, Table, number
from multisrt.reporting.study import Comparison, Study
from multisrt.reporting.tables import labels
from multisrt.reporting.words import (
    INFINITY_NOTE,
    UNCLAIMED,
    constants_note,
    significance_note,
    success_words,
    unclaimed_note,
)

COLUMNS = {
    "time_to_95_s": "95 % (s)",
    "known_complete_s": "known (s)",
    "makespan_s": "done (s)",
    "total_distance_m": "driven (m)",
}
"""Headings of the measures in the table, by name."""


SHARES = {"coverage": "covered", "delivered_coverage": "delivered"}
"""Headings of the shares in the table, by name; without a base station nothing is delivered."""


def overview_table(results: Results, *, baseline: str | None = None) -> Table:
    """Return the table of a comparison: a row for each setting and strategy.

    Parameters
    ----------
    results : Results
        Results of an experiment.
    baseline : str, optional
        Label of the strategy that marks compare with; by default the first one.

    Returns
    -------
    Table
        Successful runs, and medians of the coverage, of what was delivered to a base station, the
        time to 95 %, both ends of the exploration, and the distance.

    Raises
    ------
    InvalidInputError
        If no strategy has the label of the baseline.

    Examples
    --------
    >>> import multisrt as ms
    >>> from multisrt.reporting.overview import overview_table
    >>> found = ms.compare("open", ["srt-radial", "closest"], seeds=1, progress=False)
    >>> overview_table(found.results).columns[:3]
    ('Strategy', 'success', 'covered')
    """
    return overview(Study(results, baseline))


DELIVERED = ", and known to the base station"
"""Of the area in the notes."""


def overview(study: Study) -> Table:
    """Return the table of a study; see `overview_table`."""
    measures = [measure_named(name) for name in COLUMNS]
    compared = {
        (measure.name, found.setting, found.strategy): found
        for measure in measures
        for found in study.comparisons(measure)
    }
    named = [labels(study, setting) for setting in study.settings]
    # What all rows have in common is in the title.
    varying = [column for column in (0, 1) if len({label[column].text for label in named}) > 1]
    shares = {name: heading for name, heading in SHARES.items() if _has(study, name)}
    rows = [
        (
            *(label[column] for column in varying),
            Cell(text=strategy),
            _success(study, setting, strategy),
            *(_share(study, measure_named(name), setting, strategy) for name in shares),
            *(
                _median(study, m, setting, strategy, compared.get((m.name, setting, strategy)))
                for m in measures
            ),
        )
        for setting, label in zip(study.settings, named, strict=True)
        for strategy in study.here(setting)
    ]
    common = [named[0][column].text for column in (0, 1) if named and column not in varying]
    return Table(
        name="overview",
        title=": ".join(("Overview", *((", ".join(common),) if common else ()))),
        columns=(
            *(("World", "Team")[column] for column in varying),
            "Strategy",
            "success",
            *shares.values(),
            *COLUMNS.values(),
        ),
        rows=tuple(rows),
        labels=len(varying) + 1,
        notes=_notes(study, measures[0], rows),
    )


def _notes(study: Study, main: Measure, rows: Sequence[Sequence[Cell]]) -> tuple[str, ...]:
    notes = [
        f"Success: {success_words(study.results)}. The other columns are medians: the area "
        f"covered{DELIVERED if _has(study, 'delivered_coverage') else ''}; the time to 95 % of it; "
        "the time at which a robot knows its map complete, and at which all are done; the distance "
        "of all robots."
    ]
    if any(found.kind != "none" for found in study.comparisons(main)):
        notes.append(significance_note(study, main))
    if study.has_constants:
        notes.append(constants_note(study))
    # Runs that were not executed are reported with the reason of the first.
    missing = [result for result in study.results if result.metrics is None]
    if missing:
        first = missing[0]
        notes.append(
            f"{len(missing)} of {len(study.results)} runs were not measured: "
            f"{first.condition.strategy}, {first.status.replace('_', ' ')}: {first.reason}"
        )
    if any("∞" in cell.line for row in rows for cell in row):
        notes.append(INFINITY_NOTE)
    if study.unclaimed:
        notes.append(unclaimed_note(study))
    return tuple(notes)


def _success(study: Study, setting: Condition, strategy: str) -> Cell:
    results = study.distinct(setting, strategy)
    good = sum(result.success for result in results)
    return Cell(
        text=f"{good} of {len(results)}",
        detail="(1 run)" if study.is_constant(setting, strategy) else "",
        sort=good / len(results),
        data={"successes": good, "runs": len(results)},
    )


def _has(study: Study, name: str) -> bool:
    """Return whether any run has a value of a measure."""
    measure = measure_named(name)
    return any(measure.of(result) is not None for result in study.results)


def _share(study: Study, measure: Measure, setting: Condition, strategy: str) -> Cell:
    found = study.summary(measure, setting, strategy)
    if found is None:
        return Cell(text="", sort=0.0)
    return Cell(
        text=f"{number(100.0 * found.median, 1)} %",
        sort=found.median,
        data={"median": found.median},
    )


def _median(
    study: Study, measure: Measure, setting: Condition, strategy: str, compared: Comparison | None
) -> Cell:
    if study.is_unknown(measure, strategy):
        return Cell(text=UNCLAIMED, sort=float("inf"))
    found = study.summary(measure, setting, strategy)
    if found is None:
        return Cell(text="", sort=float("inf"))
    return Cell(
        text=number(found.median, measure.digits),
        mark="" if compared is None else compared.mark,
        sort=found.median,
        data={"median": found.median},
    )
