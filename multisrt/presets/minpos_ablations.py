"""Ablations of MinPos: what gains on closest depend on."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import msgspec

from multisrt.experiments.crossing import Condition
from multisrt.experiments.spec import Block, EnvironmentChoice, StartsChoice
from multisrt.presets.ablations import Ablation, Ablations, Topic, with_options
from multisrt.presets.cells import Cells
from multisrt.presets.minpos_claims import (
    BEFORE_GREEDY,
    FASTER,
    MORE_IN_MAZES,
    MORE_WITH_MORE_ROBOTS,
    ON_AVERAGE,
    UP_TO,
)
from multisrt.presets.minpos_experiment import (
    BODY,
    CLOSEST,
    GREEDY,
    HOSPITAL,
    HOSPITALS,
    MAZE,
    MAZES,
    MINPOS,
    SCAN_STEPS,
    STARTS,
    STRATEGIES,
    TEAMS,
    every,
    scans,
)
from multisrt.presets.minpos_gains import TIME, TO_99, complete, gain, gain_text, ratios_of
from multisrt.reporting.claims import PrintedTable
from multisrt.spec import Scalar

ROBOTS = 4


def _topic(world: str, robots: int, *claims: str) -> Topic:
    return Topic(
        title=f"What the times depend on: {world}, {robots} robots",
        measures=(TIME, TO_99),
        claims=claims,
    )


IN_MAZES = _topic(
    MAZE,
    ROBOTS,
    *FASTER.values(),
    *ON_AVERAGE.values(),
    UP_TO[MAZE],
    BEFORE_GREEDY,
    MORE_WITH_MORE_ROBOTS,
    MORE_IN_MAZES,
)
IN_HOSPITAL = _topic(HOSPITAL, ROBOTS, UP_TO[HOSPITAL], MORE_IN_MAZES)
LARGEST_TEAM = _topic(MAZE, TEAMS[-1], MORE_WITH_MORE_ROBOTS)

OTHER_STEPS = 1 if SCAN_STEPS > 1 else 4
SCANS = f"a scan and a choice at {every(OTHER_STEPS)}"
TARGETS = "goals kept until nothing is left to be seen there"
ARRIVAL = "goals kept until they are reached, as by Yamauchi"
SCANS_ARRIVAL = f"a scan at {every(OTHER_STEPS)}, goals kept until they are reached"
WIDE = "bodies of 1 m, of which two cannot pass in a corridor"
APART = "starts far apart"


def _choosing(label: str, options: Mapping[str, Scalar]) -> Block:
    return Block(strategies=tuple(with_options(one, label, options) for one in STRATEGIES))


CHANGED = {
    SCANS: _choosing("scans", scans(OTHER_STEPS)),
    TARGETS: _choosing("targets", {"replan": "target"}),
    ARRIVAL: _choosing("arrival", {"replan": "arrival"}),
    SCANS_ARRIVAL: _choosing("scans until arrival", {**scans(OTHER_STEPS), "replan": "arrival"}),
    WIDE: Block(bodies=("disc:0.5",)),
    APART: Block(starts=(StartsChoice(how="scattered", first="drawn"),)),
}
"""What each change has in the place of the experiment's."""


WITH_FOUR = (SCANS, TARGETS, ARRIVAL, SCANS_ARRIVAL, APART)
"""The changes that are tried with four robots, in both worlds."""


def _ablation(topic: Topic, world: EnvironmentChoice, robots: int, change: str) -> Ablation:
    base = Block(
        environments=(world,),
        robots=(robots,),
        strategies=STRATEGIES,
        bodies=(BODY,),
        starts=(STARTS,),
    )
    own = CHANGED[change]
    changed = {name: of for name in own.__struct_fields__ if (of := getattr(own, name))}
    return Ablation(
        topic=topic,
        change=change,
        base=base,
        changed=msgspec.structs.replace(base, **changed),
        is_quick=topic == IN_MAZES and change in (TARGETS, APART),
    )


def gains(cells: Cells, changes: Sequence[Ablation]) -> list[PrintedTable]:
    """Return a table for each topic of the gains on closest without and with each change."""
    topics = {one.topic.title: one.topic for one in changes}
    return [
        _gains(cells, topic, [one for one in changes if one.topic == topic])
        for topic in topics.values()
    ]


def _gains(cells: Cells, topic: Topic, changes: Sequence[Ablation]) -> PrintedTable:
    base, rows = {}, []
    for one in changes:
        pairs = one.pairs(cells.experiment)
        base = {before.strategy: before for before, _ in pairs}
        rows.append(_row(one.change, cells, {before.strategy: after for before, after in pairs}))
    return PrintedTable(
        title=topic.title.replace("the times depend", "gains depend"),
        source="",
        columns=("change", GREEDY, MINPOS, f"{MINPOS} on {GREEDY}", "pairs"),
        rows=(_row("as in the experiment", cells, base), *rows),
        note=(
            "Gains on closest, and of minpos on greedy, in percent, with 95 % intervals. "
            f"{TIME.title}."
        ),
    )


def _row(what: str, cells: Cells, at: Mapping[str, Condition]) -> tuple[str, ...]:
    compared = ((GREEDY, CLOSEST), (MINPOS, CLOSEST), (MINPOS, GREEDY))
    ratios = [ratios_of(cells, TIME, at[rule], at[other]) for rule, other in compared]
    pairs = "/".join(str(len(complete(of))) for of in ratios)
    return (what, *(gain_text(gain([of])) for of in ratios), pairs)


ABLATIONS = Ablations(
    changes=(
        *(_ablation(IN_MAZES, MAZES, ROBOTS, change) for change in WITH_FOUR),
        *(_ablation(IN_HOSPITAL, HOSPITALS, ROBOTS, change) for change in WITH_FOUR),
        *(_ablation(LARGEST_TEAM, MAZES, TEAMS[-1], change) for change in (WIDE, APART)),
    ),
    repetitions=20,
    run_s=13.0,
    quick_repetitions=6,
    own_tables=gains,
)
"""The ablations of the page."""
