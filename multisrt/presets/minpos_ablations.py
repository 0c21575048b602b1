"""Ablations of MinPos: what the gains in mazes depend on."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import msgspec

from multisrt.experiments.crossing import Condition
from multisrt.experiments.spec import Block, StartsChoice
from multisrt.presets.ablations import Ablation, Ablations, Topic, with_options
from multisrt.presets.cells import Cells
from multisrt.presets.minpos_claims import BEFORE_GREEDY, FASTER, ON_AVERAGE, UP_TO
from multisrt.presets.minpos_experiment import (
    BODY,
    CLOSEST,
    GREEDY,
    MAZE,
    MAZES,
    MINPOS,
    STARTS,
    STRATEGIES,
)
from multisrt.presets.minpos_gains import HOME, TIME, complete, gain, gain_text, ratios_of
from multisrt.reporting.claims import PrintedTable

ROBOTS = 4

TIMES = Topic(
    title=f"What the times depend on: {MAZE}, {ROBOTS} robots",
    measures=(TIME, HOME),
    claims=(*FASTER.values(), *ON_AVERAGE.values(), UP_TO[MAZE], BEFORE_GREEDY),
)

TARGETS = "goals kept until they are reached"
WIDE = "bodies of 1 m, of which two cannot pass in a corridor"
APART = "starts far apart"

_BASE = Block(
    environments=(MAZES,),
    robots=(ROBOTS,),
    strategies=STRATEGIES,
    bodies=(BODY,),
    starts=(STARTS,),
)


def _ablation(change: str, changed: Block) -> Ablation:
    return Ablation(topic=TIMES, change=change, base=_BASE, changed=changed)


CHANGES = (
    _ablation(
        TARGETS,
        msgspec.structs.replace(
            _BASE,
            strategies=tuple(
                with_options(one, "targets", {"replan": "target"}) for one in STRATEGIES
            ),
        ),
    ),
    _ablation(WIDE, msgspec.structs.replace(_BASE, bodies=("disc:0.5",))),
    _ablation(
        APART,
        msgspec.structs.replace(_BASE, starts=(StartsChoice(how="scattered", first="drawn"),)),
    ),
)


def gains(cells: Cells, changes: Sequence[Ablation]) -> list[PrintedTable]:
    """Return the gains on closest without and with each change."""
    base, rows = {}, []
    for one in changes:
        pairs = one.pairs(cells.experiment)
        base = {before.strategy: before for before, _ in pairs}
        rows.append(_row(one.change, cells, {before.strategy: after for before, after in pairs}))
    return [
        PrintedTable(
            title=f"What gains depend on: {MAZE}, {ROBOTS} robots",
            source="",
            columns=("change", GREEDY, MINPOS, "pairs"),
            rows=(_row("as in the experiment", cells, base), *rows),
            note=f"Gains on closest (percent) with 95 % intervals. {TIME.title}.",
        )
    ]


def _row(what: str, cells: Cells, at: Mapping[str, Condition]) -> tuple[str, ...]:
    ratios = [ratios_of(cells, TIME, at[rule], at[CLOSEST]) for rule in (GREEDY, MINPOS)]
    pairs = "/".join(str(len(complete(of))) for of in ratios)
    return (what, *(gain_text(gain([of])) for of in ratios), pairs)


ABLATIONS = Ablations(
    changes=CHANGES, repetitions=30, quick_repetitions=6, own_tables=gains, run_s=None
)
"""The ablations of the page."""
