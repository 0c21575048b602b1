"""Settings of the three strategies in the SBX-R preset, and what each of them changes.

In the paper's table all strategies have equal settings. The ablations change one of them each, in
one cell of the tables.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import partial
from types import MappingProxyType
from typing import Final, get_args

import numpy as np

from multisrt.events import DiagramEnd
from multisrt.experiments.crossing import Condition
from multisrt.experiments.measures import Measure, measure_named
from multisrt.experiments.results import Result
from multisrt.experiments.spec import RadioChoice, StrategyChoice
from multisrt.presets.cells import Cells
from multisrt.presets.sbx_r_tables import CLOSEST, SBX_R, UTILITY
from multisrt.presets.words import number
from multisrt.reporting.claims import PrintedTable
from multisrt.spec import Scalar
from multisrt.statistics.summaries import median

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
    StrategyChoice(name=UTILITY, options=dict(EQUAL)),
    StrategyChoice(name=SBX_R, options=dict(PAPERS)),
)


@dataclass(frozen=True, slots=True)
class Ablation:
    """A strategy of the paper's table with other settings.

    Attributes
    ----------
    strategy : str
        The strategy.
    label : str
        How tables call it.
    changed : dict
        The settings that differ.
    """

    strategy: str
    label: str
    changed: MappingProxyType[str, Scalar]

    @property
    def choice(self) -> StrategyChoice:
        """The strategy with these settings."""
        whole = PAPERS if self.strategy == SBX_R else EQUAL
        return StrategyChoice(
            name=self.strategy, label=self.label, options={**whole, **self.changed}
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


def _ablation(strategy: str, what: str, **changed: Scalar) -> Ablation:
    return Ablation(strategy, f"{strategy}, {what}", MappingProxyType(changed))


ABLATIONS: Final = (
    _ablation(SBX_R, "forgets after 15 s", lost_after_s=15.0),
    _ablation(SBX_R, "no stop signals", stop_signals=False),
    _ablation(SBX_R, "chooses when nothing is left", replan="target"),
    _ablation(SBX_R, "to the cell, march", reached="cell", paths="march"),
    _ablation(CLOSEST, "to the cell, march", reached="cell", paths="march"),
    _ablation(UTILITY, "to the cell, march", reached="cell", paths="march"),
)

ABLATION_ROBOTS: Final = 3
ABLATION_RADIO: Final = RadioChoice(range_m=15.0, label="15 m")

MEASURES: Final = tuple(
    map(
        measure_named,
        ("isolated_total_s", "isolated_longest_s", "known_complete_s", "total_distance_m"),
    )
)


def ablations(cells: Cells) -> PrintedTable:
    """Return the table of what single settings change."""
    found = {at.strategy: at for at in cells.conditions() if _is_cell(at)}
    changed = {one.label: one.strategy for one in ABLATIONS}
    rows = []
    for label in dict.fromkeys(
        name for one in ABLATIONS for name in (one.strategy, one.label) if name in found
    ):
        values = [cells.values(found[label], measure) for measure in MEASURES]
        if any(values):
            rows.append(
                (
                    label if label in changed else f"{label}, as in the tables",
                    str(len(values[0])),
                    *(
                        _middle([*each.values()], measure.digits)
                        for each, measure in zip(values, MEASURES, strict=True)
                    ),
                )
            )
    return PrintedTable(
        title="What single settings change",
        source=f"{ABLATION_ROBOTS} robots, {ABLATION_RADIO.label} radio",
        columns=("strategy", "n", *(measure.heading for measure in MEASURES)),
        rows=tuple(rows),
        note="Medians. Each row below that of a strategy changes what it names and nothing else.",
    )


def diagram_table(cells: Cells) -> PrintedTable:
    """Return the table of how often robots left the nearness diagram to follow their path."""
    rows = []
    for choice in STRATEGIES:
        places = [at for at in cells.conditions() if at.strategy == choice.name]
        run_m = _total(cells, places, DISTANCE)
        if run_m > 0.0:
            counts = [_total(cells, places, measure) for measure in LEFT]
            rows.append((choice.name, *(number(100.0 * count / run_m, 1) for count in counts)))
    return PrintedTable(
        title="Drives finished by following the path (per 100 m)",
        source="Smooth Nearness Diagram",
        columns=("strategy", *REASONS),
        rows=tuple(rows),
        note="How often the nearness diagram was left for the rest of a drive, by reason, over all "
        "runs of a strategy in the tables.",
    )


def _total(cells: Cells, places: Iterable[Condition], measure: Measure) -> float:
    return sum(sum(cells.values(at, measure).values()) for at in places)


def _is_cell(at: Condition) -> bool:
    return at.robots == ABLATION_ROBOTS and at.radio == ABLATION_RADIO.label


def _middle(values: list[float], digits: int) -> str:
    return number(float(median(np.array(values))), digits) if values else "-"
