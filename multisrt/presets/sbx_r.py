"""SBX-R against Yamauchi's and Stachniss's strategies with radios of limited range.

Tables I to V of the paper give medians by strategy, range of the radio and team size. A mark says
whether SBX-R is significantly better (+) or worse (-) than the strategy of the row.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace

import numpy as np

from multisrt.experiments.crossing import Condition
from multisrt.experiments.measures import Measure, measure_named
from multisrt.experiments.results import Results
from multisrt.experiments.spec import (
    EnvironmentChoice,
    ExperimentSpec,
    Only,
    RadioChoice,
    StartsChoice,
)
from multisrt.presets.cells import Cells, Comparison, Family
from multisrt.presets.findings import Finding, weigh
from multisrt.presets.judging import Judged, judge
from multisrt.presets.preset import Deviation, Preset, in_world
from multisrt.presets.sbx_r_ablations import (
    ABLATIONS,
    FORGETS,
    NO_SIGNALS,
    NOTHING_LEFT,
    TO_THE_CELL,
)
from multisrt.presets.sbx_r_claims import ALL, CLAIMS, Cell, CellClaim
from multisrt.presets.sbx_r_settings import MAX_TIME_S, STRATEGIES, diagram_table
from multisrt.presets.sbx_r_tables import (
    NAMES,
    OTHERS,
    PAPER,
    RADIO_RANGES_M,
    SBX_R,
    TEAMS,
    UTILITY,
    PaperTable,
    radio_label,
)
from multisrt.presets.words import number
from multisrt.reporting.claims import Claim, PrintedTable
from multisrt.spec import RangeFinderSpec, StopRule
from multisrt.statistics.rank_tests import Mark
from multisrt.statistics.summaries import median

QUICK_TEAMS = (3,)
REPETITIONS, QUICK_REPETITIONS = 31, 6
RANGE_M = 4.0
TIME, HOME = measure_named("known_complete_s"), measure_named("makespan_s")

DEVIATIONS = (
    Deviation(
        "World: an office of 50 x 25 m, the size of the paper's map, which is not available. Ours "
        "has more rooms and furniture: marks can be compared, times and distances cannot."
    ),
    Deviation(
        f"Robots: discs of 0.25 m, differential, 0.5 m/s; range finders {RANGE_M:g} m, all around, "
        "exact. The paper simulates Pioneer 2-DX robots in Player/Stage, with lasers of the same "
        "range and view. Messages are relayed; walls do not block them."
    ),
    Deviation(
        "Driving: all strategies drive by Smooth Nearness Diagram, as in the paper. "
        "It is slow near obstacles: teams take more than twice as long as with path following."
    ),
    Deviation(
        "Starts: the paper does not give them. Here the configuration of the first robot is drawn "
        "in each repetition and the others stand around it. All strategies have the same starts."
    ),
    Deviation(
        "Choosing: when the last goal is reached, in sight within half the range of the sensor, "
        "even if it is no frontier any more, as the paper describes SBX-R; with self-bidding also "
        "on a stop signal. In all strategies also where the path turns out not to be free, or "
        "after giving way to another robot.",
        (NOTHING_LEFT, NO_SIGNALS),
    ),
    Deviation(
        "Settings: all strategies choose, reach their goals, plan by EEDT and drive in the same "
        "way; the paper says so of SBX-R alone. Lengths by which goals are compared are those of a "
        "fast march.",
        (TO_THE_CELL,),
    ),
    Deviation(
        "Members of the team: by self-bidding a robot out of range counts with its last known "
        "place and goal until it is broken, and none is; the leader of utility assigns goals to "
        "the robots in contact. Only self-bidding sends stop signals.",
        (FORGETS, NO_SIGNALS),
    ),
    Deviation(
        "Utility: the leader answers a robot that asks, and the others keep their goals. The paper "
        "does not say how its leader answers."
    ),
    Deviation(
        "Nearness diagram: where it makes no progress for 5 s, sees no opening, or comes within "
        "0.5 m of the goal, the robot follows its path for the rest of the drive. A table says how "
        "often."
    ),
    Deviation(
        "For a single robot all strategies are the same: it runs 'closest' once per repetition, as "
        "in the paper."
    ),
    Deviation(f"Runs: {REPETITIONS} of each case by default, as many as in the paper."),
    Deviation(
        "The paper does not name its test. The marks of single cells are by Mann-Whitney's, "
        "two-sided at 5 %, its p-values adjusted by Holm's procedure over the 12 cells of a table "
        "against one strategy. A claim is judged by one test of all its cells together, by signed "
        "ranks in pairs of repetitions, which have the same starts in all cells. Runs that failed "
        "count as worse than all others."
    ),
    Deviation(
        "Time: until a robot knows the map complete. The claims on times are judged by the time "
        "until all are home as well, and both are shown."
    ),
    Deviation("Isolation counts until the last robot is home."),
)

READING = (
    "Some of the paper's signs are illegible in print (an asterisk in Tables IV and V); they are "
    "read as its text says, in words or by its counts. Table III prints 2.881 m for Stachniss at "
    "15 m with 3 robots and marks it as worse than the 6.841 m of SBX-R: one of the two is a "
    "misprint. The text counts 12 of 13 cases in Table III, where the table marks 11 of 12. For "
    "Table IV against Yamauchi it counts 6 better, 1 worse and 6 neither, of 12 in total."
)


def experiment(quick: bool) -> ExperimentSpec:
    """Return the experiment of the paper, or a quick one with one team size and fewer runs."""
    radios = tuple(RadioChoice(range_m=float(r), label=radio_label(r)) for r in RADIO_RANGES_M)
    return ExperimentSpec(
        name="sbx-r quick" if quick else "sbx-r",
        about="What it brings and what it costs to keep a team within its radio's range",
        environments=(
            EnvironmentChoice(name="office", parameters={"width_m": 50.0, "height_m": 25.0}),
        ),
        strategies=STRATEGIES,
        robots=(1, *(QUICK_TEAMS if quick else TEAMS)),
        starts=(StartsChoice(how="clustered", first="drawn"),),
        radios=radios,
        exclude=(
            Only(robots=1, strategy=(UTILITY, SBX_R)),
            Only(robots=1, radio=tuple(radio_label(r) for r in RADIO_RANGES_M[1:])),
        ),
        repetitions=QUICK_REPETITIONS if quick else REPETITIONS,
        range_finder=RangeFinderSpec(range_m=RANGE_M),
        stop=StopRule(max_time_s=MAX_TIME_S),
    )


# Claims -------------------------------------------------------------------------------------


def claims(results: Results) -> list[Claim]:
    """Return the judged claims of the paper."""
    return [judged.claim for judged in _judged(results)]


def tables(results: Results) -> list[PrintedTable]:
    """Return our medians and marks beside Tables I to V, their agreement, and comparisons."""
    cells = Cells(results)
    return [
        *(beside(cells, table) for table in PAPER),
        *(beside(cells, _until_home(table)) for table in PAPER if table.measure == TIME),
        agreement(cells),
        diagram_table(cells),
        *(judged.table for judged in _judged(results)),
    ]


def _judged(results: Results) -> list[Judged]:
    cells = Cells(results)
    return [
        judge(
            claim.text,
            f"SBX-R, section IV, Table {claim.table.number}",
            _family(cells, claim, claim.table.measure),
            scope="always",
            so="self-bidding is better" if claim.better else "self-bidding is worse",
            otherwise="it is worse" if claim.better else "it is better",
            sides=(SBX_R, "the other") if claim.better else ("the other", SBX_R),
            beside=_family(cells, claim, HOME) if claim.table.measure == TIME else None,
        )
        for claim in CLAIMS
    ]


def _family(cells: Cells, claim: CellClaim, measure: Measure) -> Family:
    # Cells that a quick experiment lacks are left out.
    made = _places(cells)
    return Family(
        comparisons=[
            _compared(cells, measure, cell, claim.better) for cell in claim.cells if cell in made
        ],
        quantity=measure,
    )


def _places(cells: Cells) -> dict[Cell, Condition]:
    return {(at.strategy, int(at.radio.split()[0]), at.robots): at for at in cells.conditions()}


def _compared(cells: Cells, measure: Measure, cell: Cell, better: bool = True) -> Comparison:
    places = _places(cells)
    other, radio_m, robots = cell
    ours, theirs = places[SBX_R, radio_m, robots], places[cell]
    return cells.compared(
        f"{other}, {radio_label(radio_m)} radio, {robots} robots",
        lower=ours if better else theirs,
        higher=theirs if better else ours,
        measure=measure,
        # A cell's own mark is that of the paper, whose runs are not known to be pairs.
        paired=False,
    )


# Tables -------------------------------------------------------------------------------------


def marks(cells: Cells, table: PaperTable) -> dict[Cell, Mark]:
    """Return the marks of the cells with runs; each other strategy is a family of tests."""
    places = _places(cells)
    found: dict[Cell, Mark] = {}
    for other in OTHERS:
        there = {
            cell: comparison
            for cell in ALL[other]
            if cell in places and (comparison := _compared(cells, table.measure, cell)).has_runs
        }
        found |= dict(zip(there, map(_mark, weigh(there.values())), strict=True))
    return found


def _mark(finding: Finding) -> Mark:
    return "+" if finding.saying == "for" else "-" if finding.saying == "against" else ""


def beside(cells: Cells, table: PaperTable) -> PrintedTable:
    """Return a table in the paper's layout, with each of its rows below ours."""
    places, ours = _places(cells), marks(cells, table)
    rows = []
    for strategy in (*OTHERS, SBX_R):
        for radio_m in RADIO_RANGES_M:
            keys = [(strategy, radio_m, robots) for robots in TEAMS]
            own = [
                _entry(
                    cells.values(places[key], table.measure).values(),
                    table.measure,
                    ours.get(key, ""),
                )
                if key in places
                else "-"
                for key in keys
            ]
            printed = [f"{table.median(*key)} {table.mark(*key)}".strip() for key in keys]
            rows.append((strategy, radio_label(radio_m), *own))
            rows.append((f"paper: {NAMES[strategy]}", radio_label(radio_m), *printed))
    return PrintedTable(
        title=f"Table {table.number}. {table.title} ({table.measure.unit})",
        source=f"SBX-R, Table {table.number}",
        columns=("strategy", "radio", *(f"{robots} robots" for robots in TEAMS)),
        rows=tuple(rows),
        note="Medians and marks: self-bidding is significantly better (+) or worse (-) than the "
        "strategy of the row." + (f" {READING}" if table.number == "I" else ""),
    )


def _entry(values: Collection[float], measure: Measure, mark: Mark) -> str:
    if not values:
        return "-"
    return f"{number(float(median(np.array([*values]))), measure.digits)} {mark}".strip()


def _until_home(table: PaperTable) -> PaperTable:
    """Return a table of times with our times until all are home."""
    return replace(table, title=f"{table.title}, ours until all are home", measure=HOME)


def agreement(cells: Cells) -> PrintedTable:
    """Return the table of the numbers of our marks that agree with the paper's."""
    rows = []
    for table in PAPER:
        ours = marks(cells, table)
        for other in OTHERS:
            pairs = [(ours[cell], table.mark(*cell)) for cell in ALL[other] if cell in ours]
            rows.append(
                (
                    f"Table {table.number}, against {other}",
                    str(len(pairs)),
                    str(sum(mine == theirs for mine, theirs in pairs)),
                    str(sum(bool(mine) and not theirs for mine, theirs in pairs)),
                    str(sum(bool(theirs) and not mine for mine, theirs in pairs)),
                    str(sum({mine, theirs} == {"+", "-"} for mine, theirs in pairs)),
                )
            )
    return PrintedTable(
        title="Marks that agree with the paper's",
        source="SBX-R, Tables I to V",
        columns=("marks", "compared", "the same", "only ours", "only the paper's", "opposite"),
        rows=tuple(rows),
    )


SBX_R_PRESET = Preset(
    name="sbx-r",
    about="Self-bidding against closest and utility, how long and far robots are out of touch",
    paper="J. C. Elizondo, G. Ramírez, E. Rodriguez and J. R. Martínez, Multi-robot Exploration "
    "Using Self-Biddings under Constraints on Communication Range",
    experiment=experiment,
    claims=claims,
    tables=tables,
    deviations=DEVIATIONS,
    run_s=9.0,
    quick_run_s=7.0,
    on_map=in_world,
    ablations=ABLATIONS,
)
