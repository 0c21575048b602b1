"""The table of the decisions of robots, as text for spreadsheets, pages and papers."""

from __future__ import annotations

from collections.abc import Sequence

from multisrt.analysis.decision_counts import decision_rows
from multisrt.explain.terms import meanings
from multisrt.recording import Recording
from multisrt.reporting.layout import Cell, Table


def decision_table(recordings: Sequence[Recording], robots: Sequence[int] | None = None) -> Table:
    """Return how often the robots of some runs decided what, and why.

    Parameters
    ----------
    recordings : sequence of Recording
        The runs; those of one strategy are added up.
    robots : sequence of int, optional
        The robots that have columns; by default all. The columns of sums and shares are of these.

    Returns
    -------
    Table
        A row for each strategy, choice and reason; see
        `multisrt.analysis.decision_counts.decision_rows`.

    Raises
    ------
    InvalidInputError
        If the runs hold no decision.

    Examples
    --------
    >>> import multisrt as ms
    >>> run = ms.explore("open", strategy="minpos", robots=2, seed=1)
    >>> print(decision_table([run.recording]).csv().splitlines()[0])
    Strategy,Decision,Reason,Robot 0,Robot 1,All,Share
    """
    rows = decision_rows(recordings, robots)
    shown = {name for row in rows for name in (row.choice, row.reason)}
    team = range(len(rows[0].counts)) if robots is None else robots
    return Table(
        name="decisions",
        title="Decisions by strategy, choice and reason",
        columns=(
            *("Strategy", "Decision", "Reason"),
            *(f"Robot {robot}" for robot in team),
            *("All", "Share"),
        ),
        rows=tuple(
            (
                *(Cell(text=text) for text in (row.strategy, row.choice, row.reason)),
                *(_count(count) for count in row.counts),
                _count(row.total),
                Cell(text=f"{100.0 * row.share:.1f} %", sort=row.share),
            )
            for row in rows
        ),
        labels=3,
        notes=tuple(f"{name}: {meaning}." for name, meaning in meanings().items() if name in shown),
    )


def _count(count: int) -> Cell:
    return Cell(text=str(count), sort=float(count))
