"""SBX-R against Yamauchi's and Stachniss's strategies with radios of limited range.

Tables I to V of the paper give medians by strategy, range of the radio and team size. A mark says
whether SBX-R is significantly better (+) or worse (-) than the strategy of the row.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, replace

import numpy as np

from multisrt.experiments.crossing import Condition
from multisrt.experiments.measures import Measure, measure_named
from multisrt.experiments.results import Results
from multisrt.experiments.spec import (
    Block,
    EnvironmentChoice,
    ExperimentSpec,
    Only,
    RadioChoice,
    StartsChoice,
)
from multisrt.presets.cells import Cells, Comparison, Family
from multisrt.presets.findings import Finding, weigh
from multisrt.presets.judging import Judged, judge
from multisrt.presets.preset import Preset, in_world
from multisrt.presets.sbx_r_settings import (
    ABLATION_RADIO,
    ABLATION_ROBOTS,
    ABLATIONS,
    MAX_TIME_S,
    STRATEGIES,
    ablations,
    diagram_table,
)
from multisrt.presets.sbx_r_tables import (
    CLOSEST,
    NAMES,
    OTHERS,
    PAPER,
    RADIO_RANGES_M,
    SBX_R,
    TEAMS,
    UTILITY,
    PaperTable,
)
from multisrt.presets.words import number
from multisrt.reporting.claims import Claim, PrintedTable
from multisrt.spec import RangeFinderSpec, StopRule
from multisrt.statistics.rank_tests import Mark
from multisrt.statistics.summaries import median

QUICK_TEAMS = (3,)
REPETITIONS, QUICK_REPETITIONS = 31, 6
RANGE_M = 4.0
ABLATED = Block(
    strategies=tuple(one.choice for one in ABLATIONS),
    robots=(ABLATION_ROBOTS,),
    radios=(ABLATION_RADIO,),
)

TIME, HOME = measure_named("known_complete_s"), measure_named("makespan_s")

DEVIATIONS = (
    "World: an office of 50 x 25 m, the size of the paper's map, which is not available. Ours has "
    "more rooms and furniture: marks can be compared, times and distances cannot.",
    f"Robots: discs of 0.25 m, differential, 0.5 m/s; range finders {RANGE_M:g} m, all around, "
    "exact. The paper simulates Pioneer 2-DX robots in Player/Stage, with lasers of the same range "
    "and view. Messages are relayed; walls do not block them.",
    "Driving: all strategies drive by Smooth Nearness Diagram, as in the paper. "
    "It is slow near obstacles: teams take more than twice as long as with path following.",
    "Starts: the paper does not give them. Here the configuration of the first robot is drawn in "
    "each repetition and the others stand around it. All strategies have the same starts.",
    "Choosing: when the last goal is reached, in sight within half the range of the sensor, even "
    "if it is no frontier any more, as the paper describes SBX-R; with self-bidding also on a stop "
    "signal. In all strategies also where the path turns out not to be free, or after giving way "
    "to another robot.",
    "Settings: all strategies choose, reach their goals, plan by EEDT and drive in the same way; "
    "the paper says so of SBX-R alone. Lengths by which goals are compared are those of a fast "
    "march. What remains different: stop signals, which only self-bidding sends; and who counts as "
    "a member of the team. By self-bidding a robot out of range counts with its last known place "
    "and goal until it is broken, and none is; the leader of utility assigns goals to the robots "
    "in contact. A table shows what single settings change.",
    "Utility: the leader answers a robot that asks, and the others keep their goals. The paper "
    "does not say how its leader answers.",
    "Nearness diagram: where it makes no progress for 5 s, sees no opening, or comes within 0.5 m "
    "of the goal, the robot follows its path for the rest of the drive. A table says how often.",
    "For a single robot all strategies are the same: it runs 'closest' once per repetition, as in "
    "the paper.",
    f"Runs: {REPETITIONS} of each case by default, as many as in the paper. Where a difference is "
    "not significant, the verdict names the smallest one that so many runs would have shown.",
    "The paper does not name its test. The marks of single cells are by Mann-Whitney's, two-sided "
    "at 5 %, its p-values adjusted by Holm's procedure over the 12 cells of a table against one "
    "strategy. A claim is judged by one test of all its cells together, by signed ranks in pairs "
    "of repetitions, which have the same starts in all cells. Runs that failed count as worse than "
    "all others.",
    "Time: until a robot knows the map complete. The claims on times are judged by the time until "
    "all are home as well, and both are shown.",
    "Isolation counts until the last robot is home.",
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
    radios = tuple(RadioChoice(range_m=float(r), label=_radio(r)) for r in RADIO_RANGES_M)
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
        blocks=() if quick else (Block(), ABLATED),
        exclude=(
            Only(robots=1, strategy=(UTILITY, SBX_R)),
            Only(robots=1, radio=tuple(_radio(r) for r in RADIO_RANGES_M[1:])),
        ),
        repetitions=QUICK_REPETITIONS if quick else REPETITIONS,
        range_finder=RangeFinderSpec(range_m=RANGE_M),
        stop=StopRule(max_time_s=MAX_TIME_S),
    )


def _radio(range_m: int) -> str:
    return f"{range_m} m"


# Claims -------------------------------------------------------------------------------------

Cell = tuple[str, int, int]
"""The strategy that SBX-R is compared with, the range of the radio (m), and the team size."""

ALL: dict[str, tuple[Cell, ...]] = {
    other: tuple((other, radio, robots) for radio in RADIO_RANGES_M for robots in TEAMS)
    for other in OTHERS
}
"""The cells of a table by the strategy that SBX-R is compared with."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CellClaim:
    """A claim of the paper on some cells of a table.

    Attributes
    ----------
    text : str
        The claim.
    table : PaperTable
        The table.
    cells : tuple of Cell
        The cells that the claim refers to.
    better : bool
        Whether SBX-R is claimed to be better, or worse.
    """

    text: str
    table: PaperTable
    cells: tuple[Cell, ...]
    better: bool = True


def _cell_claims() -> list[CellClaim]:
    isolation, longest, beyond, time, distance = PAPER
    together = [
        CellClaim(text=f"{text} than with {other}.", table=table, cells=ALL[other])
        for text, table in (
            ("With self-bidding some robot is isolated for less time", isolation),
            ("With self-bidding the longest isolation of a robot is shorter", longest),
            ("With self-bidding an isolated robot goes less far out of range", beyond),
        )
        for other in OTHERS
    ]
    return [
        *together,
        CellClaim(
            text="In teams of 3 and 4 with a radio of 20 or 30 m self-bidding takes less time than "
            "both others.",
            table=time,
            cells=tuple((o, radio, n) for o in OTHERS for radio in (20, 30) for n in (3, 4)),
        ),
        CellClaim(
            text="Two robots with a radio of 15 m take longer by self-bidding than by closest.",
            table=time,
            cells=((CLOSEST, 15, 2),),
            better=False,
        ),
        CellClaim(
            text="Five robots with a radio of 15 m take longer by self-bidding than by utility.",
            table=time,
            cells=((UTILITY, 15, 5),),
            better=False,
        ),
        CellClaim(
            text="Teams of 3 to 5 travel less by self-bidding than by closest.",
            table=distance,
            cells=tuple((CLOSEST, radio, n) for radio in RADIO_RANGES_M for n in (3, 4, 5)),
        ),
        CellClaim(
            text="With a radio of 15 m teams travel more by self-bidding than by utility.",
            table=distance,
            cells=tuple((UTILITY, 15, n) for n in TEAMS),
            better=False,
        ),
        CellClaim(
            text="With a radio of 30 m teams of 3 and 4 travel less by self-bidding than by "
            "utility.",
            table=distance,
            cells=tuple((UTILITY, 30, n) for n in (3, 4)),
        ),
    ]


CLAIMS = _cell_claims()
"""Claims in the text of section IV, all of which the printed marks support."""


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
        ablations(cells),
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
        f"{other}, {_radio(radio_m)} radio, {robots} robots",
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
            rows.append((strategy, _radio(radio_m), *own))
            rows.append((f"paper: {NAMES[strategy]}", _radio(radio_m), *printed))
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
    on_map=in_world,
)
