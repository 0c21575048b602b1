"""How large the effects of self-bidding are, here and in the paper."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np

from multisrt.experiments.crossing import Condition
from multisrt.presets.cells import Cells
from multisrt.presets.sbx_r_claims import CLAIMS, Cell, conditions_by_cell
from multisrt.presets.sbx_r_tables import OTHERS, PAPER, RADIO_RANGES_M, SBX_R, TEAMS, PaperTable
from multisrt.reporting.claims import PrintedTable
from multisrt.statistics.summaries import median


def effects_table(cells: Cells) -> PrintedTable:
    """Return the table of how medians of self-bidding differ from those of its rivals."""
    places = conditions_by_cell(cells)
    rows = []
    for claim in CLAIMS:
        made = [cell for cell in claim.cells if cell in places]
        paper, here = (
            _spread(_change(*of(cells, claim.table, cell)) for cell in made)
            for of in (_printed, _ours)
        )
        rows.append((claim.text, ", ".join(claim.rivals), str(len(made)), paper, here))
    return PrintedTable(
        title="Self-bidding relative to its rivals (%)",
        source="SBX-R, Tables I to V",
        columns=("claim", "rival", "cells", "paper", "here"),
        rows=tuple(rows),
        note="Median of self-bidding over that of the rival, less 1: that of the median cell, and "
        f"in brackets those of all cells. {_scale(cells)}",
    )


def _printed(cells: Cells, table: PaperTable, cell: Cell) -> tuple[float, float]:
    """Return the printed medians of self-bidding and of the rival."""
    other, radio_m, robots = cell
    own, rival = (float(table.median(name, radio_m, robots)) for name in (SBX_R, other))
    return own, rival


def _ours(cells: Cells, table: PaperTable, cell: Cell) -> tuple[float, float]:
    """Return our medians of self-bidding and of the rival; nan without runs."""
    places = conditions_by_cell(cells)
    _, radio_m, robots = cell
    own, rival = (_median(cells, places[key], table) for key in ((SBX_R, radio_m, robots), cell))
    return own, rival


def _median(cells: Cells, at: Condition, table: PaperTable) -> float:
    """Return the median of a condition by the measure of a table; nan without runs."""
    values = [*cells.values(at, table.measure).values()]
    return float(median(np.array(values))) if values else math.nan


def _change(own: float, rival: float) -> float:
    """Return by how much percent a value is above another; nan without a ratio."""
    return 100.0 * (own / rival - 1.0) if rival > 0.0 and math.isfinite(own) else math.nan


def _spread(changes: Iterable[float]) -> str:
    known = [change for change in changes if not math.isnan(change)]
    if not known:
        return "-"
    return f"{np.median(known):+.0f} ({min(known):+.0f} to {max(known):+.0f})"


def _scale(cells: Cells) -> str:
    """Return the sentence on times and distances here over those of the paper."""
    places = conditions_by_cell(cells)
    told = []
    for table, name in zip(PAPER[3:], ("Times", "distances"), strict=True):
        ratios = [
            ours / float(table.median(*key))
            for key in ((s, r, n) for s in (*OTHERS, SBX_R) for r in RADIO_RANGES_M for n in TEAMS)
            if key in places
            for ours in (_median(cells, places[key], table),)
            if math.isfinite(ours)
        ]
        if ratios:
            told.append(f"{name} here are {min(ratios):.1f} to {max(ratios):.1f} times the paper's")
    return f"{', '.join(told)}." if told else ""
