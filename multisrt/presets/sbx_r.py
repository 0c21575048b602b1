"""SBX-R against Yamauchi's and Stachniss's strategies with radios of limited range.

Tables I to V of the paper give medians by strategy, range of the radio and team size. A mark says
whether SBX-R is significantly better (+) or worse (-) than the strategy of the row.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace

import numpy as np

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
    EQUAL_CHANGES,
    FAR_OVERLAP,
    FOLLOWS_PATH,
    FORGETS,
    LARGE_BETA,
    NO_SIGNALS,
    NOTHING_LEFT,
)
from multisrt.presets.sbx_r_claims import ALL, CLAIMS, Cell, CellClaim, conditions_by_cell
from multisrt.presets.sbx_r_cohesion import DONE, ISOLATED, bids_table, shares_table
from multisrt.presets.sbx_r_effects import effects_table
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
from multisrt.presets.words import Sides, number
from multisrt.reporting.claims import Claim, PrintedTable
from multisrt.spec import RangeFinderSpec, StopRule
from multisrt.statistics.rank_tests import Mark
from multisrt.statistics.summaries import median

QUICK_TEAMS = (3,)
PAIR = 2
REPETITIONS, QUICK_REPETITIONS = 31, 6
RANGE_M = 4.0
TIME, SPLIT = measure_named("known_complete_s"), measure_named("split_s")

BESIDE = {ISOLATED: (SPLIT, "while the team was split"), TIME: (DONE, "until all are done")}
"""What else claims on a measure are judged by, and what is shown beside the paper's table."""

DEVIATIONS = (
    Deviation(
        "World: an office of 50 x 25 m, the size of the paper's map, which is not available. Ours "
        "has more rooms and furniture: marks can be compared, times and distances cannot. It is "
        "one generated office, the same in all repetitions, and the claims are judged in it alone."
    ),
    Deviation(
        f"Robots: discs with a radius of 0.25 m, differential, 0.5 m/s; range finders {RANGE_M:g} "
        "m, all around, exact. The paper simulates Pioneer 2-DX robots in Player/Stage, with "
        "lasers of the same range and view. Bodies do not hide what is behind them; in Stage they "
        "do. Messages are relayed; walls do not block them."
    ),
    Deviation(
        "Driving: all strategies drive by Smooth Nearness Diagram, as SBX-R does in the paper. "
        "It is slow near obstacles.",
        (FOLLOWS_PATH,),
    ),
    Deviation(
        "Nearness diagram: where it makes no progress for 5 s, finds no admissible command, or "
        "comes within 0.5 m of the goal, the robot follows its path for the rest of the drive. A "
        "table says how often."
    ),
    Deviation(
        "Starts: the paper does not give them. Here the configuration of the first robot is drawn "
        "in each repetition and the others stand around it. All strategies have the same starts."
    ),
    Deviation(
        "Choosing: when the last goal is reached, in sight within half the range of the sensor, "
        "even if it is no frontier any more; with self-bidding also on a stop signal. So says "
        "Algorithm 1 of the paper, while section III, state 2, has a robot choose again when its "
        "goal has been explored. In all strategies also where the path turns out not to be free, "
        "after giving way to another robot or waiting for others, and where a robot that was done "
        "hears something new.",
        (NOTHING_LEFT, NO_SIGNALS),
    ),
    Deviation(
        "Settings: all strategies choose, reach their goals, plan by EEDT and drive in the same "
        "way; the paper says so of SBX-R alone. Lengths by which goals are compared are those of a "
        "fast march.",
        tuple(EQUAL_CHANGES),
    ),
    Deviation(
        "Maps and goals are sent to all within range after every scan that shows something new, "
        "and goals also when a drive begins and every 2 s, by all strategies. By the paper's "
        "Algorithm 1 a robot asks for maps and goals when it chooses, and then sends its goal."
    ),
    Deviation(
        "Members of the team: by self-bidding a robot out of range counts with its last known "
        "place and goal until it is broken, and none is; the leader of utility assigns goals to "
        "the robots that it heard from in the last 15 s.",
        (FORGETS,),
    ),
    Deviation(
        "Bids: robots that are done, also because others block all their paths, do not take part, "
        "and their places hold no bridge; in the paper all robots that are not broken bid. The "
        "radius phi bounds paths as in Equation 1; the text above it has 0.9 phi."
    ),
    Deviation(
        "Stop signals: only self-bidding sends them. A robot sends one for a goal that it has "
        "explored itself; the paper's section III.B also has one where another robot has just "
        "chosen the same frontier, which its Algorithm 1 lacks.",
        (NO_SIGNALS,),
    ),
    Deviation(
        "Utility: the leader answers a robot that asks, and the others keep their goals; the paper "
        "does not say how its leader answers. A cost counts as a share of the largest one, with a "
        "weight (beta) of 1. Goals take utility from targets up to the range of the range finder, "
        "as Burgard et al. have it; areas that are seen from two places overlap up to twice that.",
        (FAR_OVERLAP, LARGE_BETA),
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
        "Time: until one robot's map is complete. The claims on times are judged by the time "
        "until all are done as well, and both are shown."
    ),
    Deviation(
        "Isolation: of a robot that is out of range of all others, until the last robot is done. "
        "The paper calls the total time that in which some robot was isolated, and also that in "
        "which the network was broken: two pairs out of range of each other break it, and neither "
        "is isolated. The claims on the total time are judged by the time in which the team was "
        "split as well, and both are shown."
    ),
    Deviation(
        "Statements that no claim tests: that cells do not differ significantly, and single cells "
        "of Table IV, as of two robots with a radio range of 20 m, where self-bidding is printed "
        "as faster than utility. The tables of marks show them beside ours."
    ),
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
        effects_table(cells),
        *(beside(cells, table) for table in PAPER),
        *(beside(cells, _by_other(table)) for table in PAPER if table.measure in BESIDE),
        shares_table(cells),
        bids_table(cells),
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
            sides=_sides(claim),
            beside=_beside(cells, claim),
        )
        for claim in CLAIMS
    ]


def _sides(claim: CellClaim) -> Sides:
    """Return the names of the sets of runs, first of the one that is claimed to be lower."""
    rival = " or ".join(claim.rivals)
    return (SBX_R, rival) if claim.better else (rival, SBX_R)


def _family(cells: Cells, claim: CellClaim, measure: Measure) -> Family:
    """Return the family of a claim; pairs of robots and larger teams are parts of it."""
    # Cells that a quick experiment lacks are left out.
    made = [cell for cell in claim.cells if cell in conditions_by_cell(cells)]
    pairs = [cell for cell in made if cell[2] == PAIR]
    larger = [cell for cell in made if cell[2] != PAIR]

    def family(of: Collection[Cell]) -> Family:
        compared = [_compared(cells, measure, cell, claim.better) for cell in of]
        return Family(comparisons=compared, quantity=measure)

    parts = {"2 robots": pairs, "larger teams": larger} if pairs and larger else {}
    return replace(family(made), parts={name: family(of) for name, of in parts.items()})


def _beside(cells: Cells, claim: CellClaim) -> Family | None:
    other = BESIDE.get(claim.table.measure)
    return None if other is None else _family(cells, claim, other[0])


def _compared(cells: Cells, measure: Measure, cell: Cell, better: bool = True) -> Comparison:
    places = conditions_by_cell(cells)
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


def marks(cells: Cells, table: PaperTable, *, adjusted: bool = True) -> dict[Cell, Mark]:
    """Return the marks of the cells with runs; each other strategy is a family of tests."""
    places = conditions_by_cell(cells)
    found: dict[Cell, Mark] = {}
    for other in OTHERS:
        there = {
            cell: comparison
            for cell in ALL[other]
            if cell in places and (comparison := _compared(cells, table.measure, cell)).has_runs
        }
        found |= dict(zip(there, map(_mark, weigh(there.values(), adjusted=adjusted)), strict=True))
    return found


def _mark(finding: Finding) -> Mark:
    return "+" if finding.saying == "for" else "-" if finding.saying == "against" else ""


def beside(cells: Cells, table: PaperTable) -> PrintedTable:
    """Return a table in the paper's layout, with each of its rows below ours."""
    places, ours = conditions_by_cell(cells), marks(cells, table)
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
        "strategy of the row. Yamauchi is closest, Stachniss is utility.",
    )


def _entry(values: Collection[float], measure: Measure, mark: Mark) -> str:
    if not values:
        return "-"
    return f"{number(float(median(np.array([*values]))), measure.digits)} {mark}".strip()


def _by_other(table: PaperTable) -> PaperTable:
    """Return a table with our values of the measure in `BESIDE`."""
    measure, words = BESIDE[table.measure]
    return replace(table, title=f"{table.title}, ours {words}", measure=measure)


def agreement(cells: Cells) -> PrintedTable:
    """Return the table of the numbers of our marks that agree with the paper's."""
    rows = []
    for table in PAPER:
        for adjusted in (False, True):
            ours = marks(cells, table, adjusted=adjusted)
            for other in OTHERS:
                pairs = [(ours[cell], table.mark(*cell)) for cell in ALL[other] if cell in ours]
                rows.append(
                    (
                        f"Table {table.number}, against {other}",
                        "by Holm" if adjusted else "as they are",
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
        columns=(
            *("marks", "p-values", "compared"),
            *("the same", "only ours", "only the paper's", "opposite"),
        ),
        rows=tuple(rows),
        note="By p-values of our tests as they are, and adjusted by Holm's procedure as those of "
        f"the tables above. The paper speaks of no adjustment. {READING}",
    )


SBX_R_PRESET = Preset(
    name="sbx-r",
    about="Self-bidding against closest and utility: time and distance out of radio range",
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
