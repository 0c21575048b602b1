"""How well teams kept together: isolation as a share of the mission, and bids by radius."""

from __future__ import annotations

import math
from functools import partial
from typing import Final

import numpy as np

from multisrt.analysis.bids import BIDS
from multisrt.experiments.crossing import Condition
from multisrt.experiments.measures import Measure, measure_named
from multisrt.experiments.results import Result
from multisrt.presets.cells import Cells
from multisrt.presets.sbx_r_claims import Cell, conditions_by_cell
from multisrt.presets.sbx_r_tables import (
    NAMES,
    OTHERS,
    PAPER,
    RADIO_RANGES_M,
    SBX_R,
    TEAMS,
    radio_label,
)
from multisrt.presets.words import number
from multisrt.reporting.claims import PrintedTable
from multisrt.statistics.summaries import median

ISOLATED, DONE = measure_named("isolated_total_s"), measure_named("makespan_s")


def shares_table(cells: Cells) -> PrintedTable:
    """Return the table of isolation as a share of the mission, the paper's rows below ours."""
    places = conditions_by_cell(cells)
    rows, larger = [], []
    for strategy in (*OTHERS, SBX_R):
        found: list[tuple[float, float]] = []
        for radio_m in RADIO_RANGES_M:
            keys = [(strategy, radio_m, robots) for robots in TEAMS]
            ours = [_share(cells, places.get(key)) for key in keys]
            printed = [_printed_share(key) for key in keys]
            for name, shares in ((strategy, ours), (f"paper: {NAMES[strategy]}", printed)):
                rows.append((name, radio_label(radio_m), *map(_percent, shares)))
            found += [(own, its) for own, its in zip(ours, printed, strict=True) if own is not None]
        count = sum(own > its for own, its in found)
        larger.append(f"with {strategy} in {count} of {len(found)} cells")
    return PrintedTable(
        title="Time in which some robot is isolated, as a share of the mission (%)",
        source="SBX-R, Tables I and IV",
        columns=("strategy", "radio", *(f"{robots} robots" for robots in TEAMS)),
        rows=tuple(rows),
        note="Median of the time over median of the mission: until all are done; in the paper, its "
        "exploration time. Teams are less cohesive here than in the paper where the share is "
        f"larger: {', '.join(larger)}.",
    )


def _share(cells: Cells, at: Condition | None) -> float | None:
    """Return our share; None without runs."""
    if at is None or not cells.of(at):
        return None
    isolated, mission = (
        float(median(np.array([*cells.values(at, measure).values()])))
        for measure in (ISOLATED, DONE)
    )
    # Where half of the runs failed there is no share; it counts as the largest.
    return isolated / mission if math.isfinite(isolated) else math.inf


def _printed_share(key: Cell) -> float:
    isolation, _, _, time, _ = PAPER
    return float(isolation.median(*key)) / float(time.median(*key))


def _percent(share: float | None) -> str:
    return "-" if share is None else number(100.0 * share, 0)


def _bid_for(how: str, result: Result) -> float:
    return 0.0 if result.metrics is None else result.metrics.bids_by_radius.get(how, 0)


COUNTS: Final = tuple(
    # Counted in all runs: a run that failed bid, too.
    Measure(name=how, title=how, unit="", lower_is_better=False, get=partial(_bid_for, how))
    for how in BIDS
)


def bids_table(cells: Cells) -> PrintedTable:
    """Return the table of how self-bidding chose its goals, by the radius of cohesion."""
    rows = []
    for (strategy, radio_m, robots), at in conditions_by_cell(cells).items():
        counts = [sum(cells.values(at, measure).values()) for measure in COUNTS]
        if strategy == SBX_R and sum(counts) > 0:
            shares = (number(100.0 * count / sum(counts), 0) for count in counts)
            rows.append((radio_label(radio_m), str(robots), number(sum(counts), 0), *shares))
    return PrintedTable(
        title="Goals of self-bidding by the radius of cohesion (%)",
        source="SBX-R, Algorithm 2",
        columns=("radio", "robots", "goals", *BIDS),
        rows=tuple(rows),
        note="Over all runs. Only goals of the first radius keep a path within the radio's range "
        "of others' goals; a robot that is matched to a virtual frontier goes to its nearest one, "
        "which no radius bounds.",
    )
