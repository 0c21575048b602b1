"""Settings of the three strategies in the SBX-R preset, equal for all, and how robots drove."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from functools import partial
from types import MappingProxyType
from typing import Final, get_args

from multisrt.events import DiagramEnd
from multisrt.experiments.crossing import Condition
from multisrt.experiments.measures import Measure, measure_named
from multisrt.experiments.results import Result
from multisrt.experiments.spec import StrategyChoice
from multisrt.presets.cells import Cells
from multisrt.presets.sbx_r_tables import CLOSEST, SBX_R, UTILITY
from multisrt.presets.words import number
from multisrt.reporting.claims import PrintedTable
from multisrt.spec import Scalar

DRIVE: Final = "nearness-diagram"
MAX_TIME_S: Final = 14_400.0
"""Limit of a run in simulated time: several times what one robot needs."""

EQUAL: Final = MappingProxyType[str, Scalar](
    {"replan": "arrival", "reached": "sight", "paths": "eedt", "drive": DRIVE}
)
"""Settings of all strategies: when they choose, what counts as reached, paths, and driving."""

PAPERS: Final = MappingProxyType[str, Scalar]({**EQUAL, "lost_after_s": MAX_TIME_S})
"""Settings of SBX-R: a robot is left out only when it is broken, and no robot breaks here."""

STRATEGIES: Final = (
    StrategyChoice(name=CLOSEST, options=dict(EQUAL)),
    StrategyChoice(name=UTILITY, options={**EQUAL, "overlap_ranges": 1.0}),
    StrategyChoice(name=SBX_R, options=dict(PAPERS)),
)


def _left(because: str, result: Result) -> float:
    return 0.0 if result.metrics is None else result.metrics.diagram_left.get(because, 0)


REASONS: Final[tuple[DiagramEnd, ...]] = get_args(DiagramEnd)

LEFT: Final = tuple(
    # Counted in all runs: a run that failed drove, too.
    Measure(
        name=because,
        title=because,
        unit="",
        lower_is_better=False,
        get=partial(_left, because),
    )
    for because in REASONS
)

DISTANCE: Final = replace(measure_named("total_distance_m"), lower_is_better=False)
STOPS: Final = replace(measure_named("protective_stops"), lower_is_better=False)


def diagram_table(cells: Cells) -> PrintedTable:
    """Return the table of how often robots left the nearness diagram, and had to stop."""
    rows = []
    for choice in STRATEGIES:
        places = [at for at in cells.conditions() if at.strategy == choice.name and at.robots > 1]
        run_m = _total(cells, places, DISTANCE)
        if run_m > 0.0:
            counts = [_total(cells, places, measure) for measure in (*LEFT, STOPS)]
            rows.append((choice.name, *(number(100.0 * count / run_m, 1) for count in counts)))
    return PrintedTable(
        title="Drives finished by following the path, and protective stops (per 100 m)",
        source="Smooth Nearness Diagram",
        columns=("strategy", *REASONS, "protective stops"),
        rows=tuple(rows),
        note="How often the nearness diagram was left for the rest of a drive, by reason, and how "
        "often a protective stop ended a motion before another body, over all runs of teams.",
    )


def _total(cells: Cells, places: Iterable[Condition], measure: Measure) -> float:
    return sum(sum(cells.values(at, measure).values()) for at in places)
