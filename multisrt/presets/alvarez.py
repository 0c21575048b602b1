"""Álvarez's rules on ten maps, as in chapter 4 of the thesis, beside its Table 4.1.

For each map the thesis fits y = a x^b to the mean exploration time and to the mean path length of
a robot, for teams of x robots. The coefficient a measures the task, the exponent b how well the
team shares it: -1 is a team without any loss.
"""

from __future__ import annotations

import math

from multisrt.experiments.measures import Measure
from multisrt.experiments.results import Results
from multisrt.presets.alvarez_ablations import (
    ABLATIONS,
    FINE_CELLS,
    NO_RANDOM_GOALS,
    NO_SWAPS,
    RANDOM_STARTS,
    SWAPS_BY_SUMS,
    WAITS_WITHOUT_END,
)
from multisrt.presets.alvarez_experiment import (
    BODY,
    CELL_M,
    COVERED,
    DISTANCE,
    DISTANCE_FALLS,
    HOME,
    M2_PER_ROBOT,
    MIN_SUCCESS,
    PAPERS_REPETITIONS,
    RANGE_M,
    REPETITIONS,
    SPEED_M_S,
    SUCCEEDS,
    TAKES_LESS,
    TIME,
    TIME_FALLS,
    TRAVELS_LESS,
    experiment,
)
from multisrt.presets.alvarez_maps import PASSAGE_M
from multisrt.presets.alvarez_outcomes import Outcome, outcomes
from multisrt.presets.cells import Cells, Family
from multisrt.presets.exponents import Laws, falls_as_printed, law
from multisrt.presets.judging import Judged, judge
from multisrt.presets.preset import WORLD, Deviation, Preset, in_world
from multisrt.reporting.claims import Claim, PrintedTable, Verdict
from multisrt.statistics.intervals import wilson
from multisrt.statistics.power_law import PowerLaw

DEVIATIONS = (
    Deviation(
        f"{WORLD} generated maps with the outer size and of the kind of the thesis's maps, which "
        "are not included (they are of a library that the thesis cites); offices without "
        "furniture. Areas in the thesis are taken as those of "
        f"whole maps. Doors and corridors are at least {PASSAGE_M:g} m wide, for which cells of "
        f"{CELL_M:g} m leave room; in scenario 18 obstacles are as close as 1.2 m, so that some "
        "gaps are closed, as the thesis reports of its own (Figures 4.14 and 4.15). `--map` takes "
        "a map instead."
    ),
    Deviation(
        "Mazes were chosen after single runs on them had been looked at: their numbers of cells "
        "and loops are such that the path of a single robot is about as long as printed "
        "(coefficient a of the distance), up to one and a half times. P-values and intervals "
        "assume maps that were fixed beforehand. For the three mazes this is not so: the length "
        "of a single robot's path is a point of the curves to which exponents are fitted, so that "
        "their exponents, and the mean over maps, may be biased in a direction that is not known. "
        "Verdicts without the mazes are therefore given beside. P-values "
        "of the claims on twice as many robots are about repetitions on these maps as they are, "
        "and the interval of the success rate about such runs; neither says anything of mazes "
        "that were not chosen so."
    ),
    Deviation(
        f"Robots: differential, {SPEED_M_S:g} m/s; range finders {RANGE_M:g} m, exact; a radio of "
        "unlimited range, all as in the thesis. The body is a disc as wide as the Husky A200 "
        f"({BODY}): the thesis says that cells of {CELL_M:g} m are almost the size of its robots, "
        "while a Husky of 0.99 x 0.67 m needs 1.2 m to turn."
    ),
    Deviation(
        f"Cells are {CELL_M:g} m wide for the map as well as for goals, as in the thesis. "
        "Obstacles are grown by the exact radius of the body; the thesis calls this indispensable "
        "(2.4.2.1), and does not say whether its planner does so.",
        (FINE_CELLS,),
    ),
    Deviation(
        "Goals are swapped as by the thesis's Algorithm 6, whatever the other robot gets in "
        "return, and compared whenever one is new; the thesis compares them all the time.",
        (SWAPS_BY_SUMS, NO_SWAPS),
    ),
    Deviation("The size of the map is not known to the robots; in the thesis it is."),
    Deviation(
        "Starts: drawn at random in each repetition, with the robots of a team far apart: each "
        "takes the farthest of 30 random places. In the thesis they are random, without details "
        "(chapter 4). Robots that start far apart need not spread first, which favours larger "
        "teams: steeper exponents.",
        (RANDOM_STARTS,),
    ),
    Deviation(
        f"Success: the team ended with a complete map and covered {100 * COVERED:g} % of the "
        "explorable area. The thesis does not define success. Means are over successful runs."
    ),
    Deviation(
        "Recovery behaviours that the thesis's algorithm does not have: the success rate is that "
        "of the algorithm with them. A "
        "robot waits for others only a limited number of times, and then drives on until the "
        "protective stop, after which robots ask each other to give way; one that could not drive "
        "to three goals in a row goes to a random place, which the thesis proposes as future work "
        "for robots that are stuck (section 5.1).",
        (NO_RANDOM_GOALS, WAITS_WITHOUT_END),
    ),
    Deviation(
        "Two more recovery behaviours, which cannot be switched off: where no unexplored cell can "
        "be reached and a frontier is left, the nearest frontier is the goal; and a cell counts as "
        "inaccessible once all robots that are present found it so, where the thesis asks the "
        "whole team."
    ),
    Deviation(
        "Scores: the search for goals ends when it has found as many unexplored cells as 5 % "
        "of all cells of the known rectangle (Algorithm 2; the text of the thesis has 5 % of the "
        "unexplored cells); the turn is the smaller one of the two, at most 180 degrees; the term "
        "of the others' goals is the sum over them, where Equation 3.4 leaves open which one it "
        "means. The path to where the known area ends is the shortest one, not one from cell to "
        "cell."
    ),
    Deviation(
        f"The thesis makes {PAPERS_REPETITIONS} runs of each case, this experiment {REPETITIONS} "
        "by default."
    ),
    Deviation(
        "Time: until one robot's map is complete. The claims on times are judged by the time "
        "until all are done as well, and both are shown."
    ),
    Deviation(
        "Laws are fitted to means over successful runs, as in the thesis. That twice the robots "
        "help is tested in pairs of repetitions, over all maps together, where failed runs are "
        "the worst."
    ),
    Deviation(
        "The coefficients of the thesis do not agree with its speed: at 0.1 m/s the distance of a "
        "single robot (a of the distance) takes longer than the printed time (a of the time). "
        "Speeds of 0.13 to 0.19 m/s would agree."
    ),
    Deviation(
        "The printed exponents of time and distance do not agree with each other either: on all "
        "ten maps the distance falls faster than the time, though robots that drive at one speed "
        "and explore all the time have both in proportion."
    ),
    Deviation(
        f"The thesis finds that more robots help up to one per {M2_PER_ROBOT:g} m2. Its smallest "
        "map has room for ten by this rule, and neither experiment has larger teams."
    ),
)


# Claims -------------------------------------------------------------------------------------


def claims(results: Results) -> list[Claim]:
    """Return the judged claims of the thesis."""
    found = outcomes(Cells(results))
    printed = [(one, one.scenario) for one in found if one.scenario is not None]
    return [
        succeeds(found),
        falls_as_printed(
            TIME_FALLS,
            [Laws(one.label, of.time[1], one.time, one.home, of.was_seen) for one, of in printed],
        ),
        falls_as_printed(
            DISTANCE_FALLS,
            [Laws(one.label, of.distance[1], one.distance, {}, of.was_seen) for one, of in printed],
        ),
        *(judged.claim for judged in _doublings(results)),
    ]


def tables(results: Results) -> list[PrintedTable]:
    """Return our laws and success rates beside Table 4.1, the means, and the comparisons."""
    found = outcomes(Cells(results))
    return [
        beside(found),
        _means_table("Mean exploration time (s)", [(one, one.time) for one in found]),
        _means_table("Mean time until all are done (s)", [(one, one.home) for one in found]),
        _means_table("Mean path length of a robot (m)", [(one, one.distance) for one in found]),
        *(judged.table for judged in _doublings(results)),
    ]


def succeeds(found: list[Outcome]) -> Claim:
    """Return the judged claim on success rates, by Wilson's interval of all runs."""
    runs, good = sum(one.runs for one in found), sum(one.successes for one in found)
    least = MIN_SUCCESS / 100.0
    decision: Verdict = "not tested"
    grounds = ["there are no runs"]
    if runs:
        share = wilson(good, runs)
        rates = [100.0 * one.successes / one.runs for one in found if one.runs]
        grounds = [
            f"{good} of {runs} runs succeed: {100 * share.value:.1f} % (interval "
            f"{100 * share.low:.1f} to {100 * share.high:.1f} %, Wilson); by map "
            f"{min(rates):.1f} to {max(rates):.1f} %",
            "this is success with recovery behaviours that the thesis's algorithm does not have; "
            "the differences from its experiment list them",
        ]
        if share.high < least:
            decision = "does not hold"
        elif wilson(runs, runs).low < least:
            grounds.append("too few runs: even without a failure the interval would reach below")
        else:
            decision = "holds" if share.low >= least else "inconclusive"
    would_show = "" if decision == "not tested" else _sufficient(runs, least)
    return Claim(
        text=SUCCEEDS,
        source="Álvarez, Table 4.1 (94.06 to 99.06 % by map)",
        verdict=decision,
        grounds=tuple(grounds),
        would_show=would_show,
    )


def _sufficient(runs: int, least: float) -> str:
    enough = next((k for k in range(runs + 1) if wilson(k, runs).low >= least), None)
    if enough is None:
        return "no rate would have sufficed in so few runs"
    return f"{enough} of {runs} successful runs would have sufficed"


def _doublings(results: Results) -> list[Judged]:
    cells = Cells(results)
    return [
        doubling(TAKES_LESS, cells, TIME, HOME),
        doubling(TRAVELS_LESS, cells, DISTANCE),
    ]


def doubling(text: str, cells: Cells, measure: Measure, beside: Measure | None = None) -> Judged:
    """Return the judged claim that twice the robots help, on all maps together."""
    return judge(
        text,
        "Álvarez, section 4.2.1",
        _doubled(cells, measure),
        scope="always",
        so="it falls",
        otherwise="it rises",
        sides=("larger team", "smaller team"),
        beside=None if beside is None else _doubled(cells, beside),
    )


def _doubled(cells: Cells, measure: Measure) -> Family:
    at = {(one.environment, one.robots): one for one in cells.conditions()}
    return Family(
        comparisons=[
            cells.compared(
                f"{label}, {few} to {2 * few} robots",
                lower=at[label, 2 * few],
                higher=at[label, few],
                measure=measure,
            )
            for label, few in at
            if few in (1, 2, 4) and (label, 2 * few) in at
        ],
        quantity=measure,
    )


# Tables -------------------------------------------------------------------------------------


def beside(found: list[Outcome]) -> PrintedTable:
    """Return our laws and success rates beside Table 4.1."""
    rows = []
    for one in found:
        time, distance = law(one.time), law(one.distance)
        rate = 100.0 * one.successes / one.runs if one.runs else math.nan
        rows.append((one.label, *_line(rate, time, distance)))
        if (printed := one.scenario) is not None:
            rows.append(
                (
                    f"thesis: {printed.kind}, {printed.area_m2:g} m2",
                    f"{printed.success_percent:.2f}",
                    *(f"{printed.time[0]:g}", f"{printed.time[1]:.3f}"),
                    *(f"{printed.distance[0]:g}", f"{printed.distance[1]:.3f}"),
                    "",
                )
            )
    return PrintedTable(
        title="Table 4.1. Success, and the laws y = a x^b of teams of x",
        source="Álvarez, Table 4.1",
        columns=(
            *("scenario", "success %", "a of time (s)", "b of time"),
            *("a of distance (m)", "b of distance", "r2 of both"),
        ),
        rows=tuple(rows),
        note="Fitted to the means by team size, in logarithms; b with its 95 % interval.",
    )


def _line(rate: float, time: PowerLaw | None, distance: PowerLaw | None) -> list[str]:
    fields = ["-" if math.isnan(rate) else f"{rate:.2f}"]
    for fit, digits in ((time, 0), (distance, 1)):
        if fit is None:
            fields += ["-", "-"]
        else:
            b = fit.exponent
            fields += [
                f"{fit.factor.value:.{digits}f}",
                f"{b.value:.3f} ({b.low:.2f}, {b.high:.2f})",
            ]
    both = [fit for fit in (time, distance) if fit is not None]
    return [*fields, ", ".join(f"{fit.r_squared:.3f}" for fit in both)]


def _means_table(title: str, means: list[tuple[Outcome, dict[int, float]]]) -> PrintedTable:
    teams = sorted({robots for _, by_team in means for robots in by_team})
    return PrintedTable(
        title=title,
        source="Álvarez, Figures 4.4 to 4.13 (curves only)",
        columns=("scenario", *(f"{n} robot{'s' * (n > 1)}" for n in teams), "successful runs"),
        rows=tuple(
            (
                one.label,
                *(f"{by_team[n]:.0f}" if n in by_team else "-" for n in teams),
                f"{one.successes} of {one.runs}",
            )
            for one, by_team in means
        ),
        note="Over successful runs.",
    )


ALVAREZ = Preset(
    name="alvarez",
    about="Álvarez's rules on ten maps, by team size: success, time and distance",
    paper="J. A. Álvarez Jáuregui, Algoritmo descentralizado para la exploración multi-robot de "
    "escenarios 2D, Universidad de Guanajuato, 2018",
    experiment=experiment,
    claims=claims,
    tables=tables,
    deviations=DEVIATIONS,
    run_s=4.0,
    quick_run_s=1.5,
    on_map=in_world,
    ablations=ABLATIONS,
)
