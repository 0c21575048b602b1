"""Ablations of Álvarez's rules: what the exponents depend on, and what success does."""

from __future__ import annotations

from collections.abc import Sequence

import msgspec

from multisrt.experiments.crossing import Condition
from multisrt.experiments.measures import measure_named
from multisrt.experiments.spec import Block, StartsChoice, StrategyChoice
from multisrt.presets.ablations import Ablation, Ablations, Topic, with_options
from multisrt.presets.alvarez_experiment import (
    CELL_M,
    DISTANCE,
    DISTANCE_FALLS,
    HOME,
    OPTIONS,
    STRATEGY,
    SUCCEEDS,
    TAKES_LESS,
    TIME,
    TIME_FALLS,
    TO_95,
    TRAVELS_LESS,
    map_of,
)
from multisrt.presets.alvarez_maps import SCENARIOS
from multisrt.presets.alvarez_outcomes import outcome_of
from multisrt.presets.cells import Cells
from multisrt.presets.exponents import interval_text, law
from multisrt.reporting.claims import PrintedTable
from multisrt.spec import Scalar

TEAMS = (1, 2, 4, 8)

(SCENARIO,) = (scenario for scenario in SCENARIOS if scenario.number == 43)

RULES = Topic(
    title=f"What single rules change: {SCENARIO.label}",
    measures=(TIME, TO_95, DISTANCE),
    claims=(SUCCEEDS, TIME_FALLS.claim, DISTANCE_FALLS.claim, TAKES_LESS, TRAVELS_LESS),
)

STARTS = Topic(
    title=f"What starts change: {SCENARIO.label}",
    measures=(TIME, TO_95, DISTANCE),
    claims=(TIME_FALLS.claim, DISTANCE_FALLS.claim),
)

HARDEST = tuple(scenario for scenario in SCENARIOS if scenario.number in (1, 18))
"""The least area for each robot, and the densest obstacles with the lowest printed success."""

RESCUES = Topic(
    title=f"What recovery behaviours bring: {', '.join(one.label for one in HARDEST)}, "
    f"{TEAMS[-1]} robots",
    measures=(TIME, HOME, measure_named("protective_stops")),
    claims=(SUCCEEDS,),
)

SWAPS_BY_SUMS, NO_SWAPS, FINE_CELLS = "swaps by sums", "no swaps", "fine cells"
RANDOM_STARTS = "starts drawn uniformly"
NO_RANDOM_GOALS, WAITS_WITHOUT_END = "no random goals", "waits without end"

NEVER = 1_000_000
"""More often than anything happens in a run."""

_CHOICE = StrategyChoice(name=STRATEGY, options=OPTIONS)
_BASE = Block(environments=(map_of(SCENARIO),), strategies=(_CHOICE,), robots=TEAMS)
_HARD = Block(environments=tuple(map(map_of, HARDEST)), strategies=(_CHOICE,), robots=(TEAMS[-1],))


def _ablation(
    change: str, topic: Topic = RULES, base: Block = _BASE, **options: Scalar
) -> Ablation:
    changed = with_options(_CHOICE, change, options)
    return Ablation(
        topic=topic,
        change=change,
        base=base,
        changed=msgspec.structs.replace(base, strategies=(changed,)),
        is_quick=topic != RESCUES,
    )


def exponents(cells: Cells, changes: Sequence[Ablation]) -> list[PrintedTable]:
    """Return the exponents of the laws without and with each change on the one map."""
    base: list[Condition] = []
    rows = []
    for one in changes:
        if one.topic == RESCUES:
            continue
        pairs = one.pairs(cells.experiment)
        base = [before for before, _ in pairs]
        rows.append(_row(one.change, cells, [after for _, after in pairs]))
    printed = (SCENARIO.time[1], SCENARIO.distance[1])
    return [
        PrintedTable(
            title=f"What the exponents depend on: {SCENARIO.label}, teams of "
            f"{', '.join(map(str, TEAMS))}",
            source="",
            columns=("change", "b of time", "b of time to 95 %", "b of distance", "successful"),
            rows=(_row("as in the experiment", cells, base), *rows),
            note=f"With 95 % intervals. The thesis: time {printed[0]:.3f}, distance "
            f"{printed[1]:.3f} (Table 4.1). Swaps by sums: only if the sum of both paths does not "
            f"grow. Fine cells: {0.5 * CELL_M:g} m for the map.",
        )
    ]


def _row(what: str, cells: Cells, at: Sequence[Condition]) -> tuple[str, ...]:
    one = outcome_of(SCENARIO.label, None, [run for team in at for run in cells.of(team)])
    laws = (law(means) for means in (one.time, one.to_95, one.distance))
    texts = ["-" if fit is None else interval_text(fit.exponent) for fit in laws]
    return (what, *texts, f"{one.successes} of {one.runs}")


ABLATIONS = Ablations(
    changes=(
        _ablation(SWAPS_BY_SUMS, exchange_when="shorter"),
        _ablation(NO_SWAPS, exchange=False),
        _ablation(FINE_CELLS, cell_m=0.5 * CELL_M),
        Ablation(
            topic=STARTS,
            change=RANDOM_STARTS,
            base=_BASE,
            changed=msgspec.structs.replace(
                _BASE, starts=(StartsChoice(how="random", first="drawn"),)
            ),
        ),
        _ablation(NO_RANDOM_GOALS, RESCUES, _HARD, random_goal_after=NEVER),
        _ablation(WAITS_WITHOUT_END, RESCUES, _HARD, patience=NEVER),
    ),
    repetitions=15,
    run_s=3.0,
    quick_repetitions=6,
    own_tables=exponents,
)
"""The ablations of the page."""
