"""Álvarez's rules on ten maps, as in chapter 4 of the thesis, beside its Table 4.1.

For each map the thesis fits y = a x^b to the mean exploration time and to the mean path length of
a robot, for teams of x robots. The coefficient a measures the task, the exponent b how well the
team shares it: -1 is a team without any loss.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass

import msgspec
import numpy as np

from multisrt.experiments.crossing import conditions
from multisrt.experiments.measures import Measure, measure_named
from multisrt.experiments.results import Result, Results
from multisrt.experiments.spec import (
    Block,
    EnvironmentChoice,
    ExperimentSpec,
    StartsChoice,
    StrategyChoice,
)
from multisrt.presets.alvarez_maps import PASSAGE_M, QUICK_SCENARIOS, SCENARIOS, Scenario
from multisrt.presets.cells import Cells, Family
from multisrt.presets.exponents import Laws, Quantity, falls_as_printed, interval_text, law
from multisrt.presets.judging import Judged, judge
from multisrt.presets.preset import WORLD, Preset, in_world
from multisrt.reporting.claims import Claim, PrintedTable, Verdict
from multisrt.spec import DriveSpec, RangeFinderSpec, Scalar, StopRule
from multisrt.statistics.intervals import wilson
from multisrt.statistics.power_law import PowerLaw

STRATEGY = "rules"
TEAMS, QUICK_TEAMS = (1, 2, 3, 4, 5, 6, 7, 8), (1, 2, 4)
REPETITIONS, QUICK_REPETITIONS = 20, 7
PAPERS_REPETITIONS = 40
SPEED_M_S, RANGE_M, CELL_M = 0.1, 4.5, 0.5
"""Speed, range of the laser and width of cells in the thesis (chapter 4, section 3.1)."""

BODY = "disc:0.335"
"""Disc as wide as a Husky A200 (0.67 m)."""

OPTIONS: dict[str, Scalar] = {
    "cell_m": CELL_M,
    "search_cell_m": CELL_M,
    "sense_period_s": 2.5,
    "exchange_when": "nearer",
}
"""Options of the strategy: the thesis's cells and swaps; a scan for every 0.25 m."""

MAX_TIME_S = 86_400.0
"""Limit of a run in simulated time: twice what one robot needs on the largest map."""

COVERED = 0.95
"""Minimum share of the explorable area that a successful run has covered."""

TIME, HOME = measure_named("known_complete_s"), measure_named("makespan_s")
"""The time by which the claims are judged, and the one that is shown beside it."""

TO_95, DISTANCE = measure_named("time_to_95_s"), measure_named("distance_per_robot_m")

TIME_FALLS = Quantity("exploration time", HOME.heading, (-1.02, -0.70))
DISTANCE_FALLS = Quantity("path length of a robot", "", (-1.42, -0.74))
"""What falls, with the bounds of 99 % of all exponents by the thesis (section 4.2.1)."""

M2_PER_ROBOT = 60.0
"""Area per robot below which more robots do not help, by the thesis (section 4.2.1)."""

MIN_SUCCESS = min(scenario.success_percent for scenario in SCENARIOS)

ABLATION_LABEL = next(scenario.label for scenario in SCENARIOS if scenario.number == 43)
ABLATION_TEAMS = (1, 2, 4, 8)
ABLATIONS: dict[str, dict[str, Scalar]] = {
    "swaps by sums": {**OPTIONS, "exchange_when": "shorter"},
    "no swaps": {**OPTIONS, "exchange": False},
    "fine cells": {**OPTIONS, "cell_m": 0.5 * CELL_M},
}
"""Variants of the strategy by label, which are run on one map to see what exponents depend on."""

DEVIATIONS = (
    f"{WORLD} generated maps with the outer size and of the kind of the thesis's maps, which are "
    "not available; offices without furniture. Areas in the thesis are taken as those of whole "
    f"maps. Doors and corridors are at least {PASSAGE_M:g} m wide, for which cells of {CELL_M:g} m "
    "leave room; in scenario 18 obstacles are as close as 1.2 m, so that some gaps are closed, as "
    "the thesis reports of its own (Figures 4.14 and 4.15). `--map` takes a map instead.",
    "Mazes have so many corridors and loops that the path of a single robot is about as long as "
    "printed (coefficient a of the distance), up to one and a half times.",
    f"Robots: differential, {SPEED_M_S:g} m/s; range finders {RANGE_M:g} m, exact; a radio of "
    f"unlimited range, all as in the thesis. The body is a disc as wide as the Husky A200 "
    f"({BODY}): the thesis says that cells of {CELL_M:g} m are almost the size of its robots, "
    "while a Husky of 0.99 x 0.67 m needs 1.2 m to turn.",
    f"Cells are {CELL_M:g} m wide for the map as well as for goals, as in the thesis. Obstacles "
    "are grown by the exact radius of the body; the thesis does not grow them.",
    "The size of the map is not known to the robots; in the thesis it is.",
    "Starts: drawn at random in each repetition, with the robots of a team far apart. The thesis "
    "draws starts as well, without details.",
    f"Success: the team ended with a complete map and saw {100 * COVERED:g} % of the explorable "
    "area. The thesis does not define success. Means are over successful runs.",
    f"The thesis makes {PAPERS_REPETITIONS} runs of each case, this experiment {REPETITIONS} by "
    "default.",
    "Time: until a robot knows the map complete. The claims on times are judged by the time until "
    "all are home as well, and both are shown.",
    "Laws are fitted to means over successful runs, as in the thesis. That twice the robots help "
    "is tested in pairs of repetitions, over all maps together, where failed runs are the worst.",
    "The coefficients of the thesis do not agree with its speed: at 0.1 m/s the distance of a "
    "single robot (a of the distance) takes longer than the printed time (a of the time). Speeds "
    "of 0.13 to 0.19 m/s would agree.",
    "The printed exponents of time and distance do not agree with each other either: on all ten "
    "maps the distance falls faster than the time, though robots that drive at one speed and "
    "explore all the time have both in proportion.",
    f"The thesis finds that more robots help up to one per {M2_PER_ROBOT:g} m2. Its smallest map "
    "has room for ten by this rule, and neither experiment has larger teams.",
)


def experiment(quick: bool) -> ExperimentSpec:
    """Return the experiment of the thesis, or a quick one with fewer maps, teams and runs."""
    maps = tuple(
        EnvironmentChoice(name=scenario.name, label=scenario.label, parameters=scenario.parameters)
        for scenario in SCENARIOS
        if not quick or scenario.number in QUICK_SCENARIOS
    )
    variants = Block(
        environments=tuple(one for one in maps if one.label == ABLATION_LABEL),
        strategies=tuple(
            StrategyChoice(name=STRATEGY, label=label, options=options)
            for label, options in ABLATIONS.items()
        ),
        robots=ABLATION_TEAMS,
    )
    return ExperimentSpec(
        name="alvarez quick" if quick else "alvarez",
        about="How time and distance fall with the team by Álvarez's rules, and how many succeed",
        environments=maps,
        strategies=(StrategyChoice(name=STRATEGY, options=OPTIONS),),
        robots=QUICK_TEAMS if quick else TEAMS,
        starts=(StartsChoice(how="scattered", first="drawn"),),
        bodies=(BODY,),
        blocks=() if quick else (Block(), variants),
        repetitions=QUICK_REPETITIONS if quick else REPETITIONS,
        drive=DriveSpec(speed_m_s=SPEED_M_S),
        range_finder=RangeFinderSpec(range_m=RANGE_M),
        stop=StopRule(max_time_s=MAX_TIME_S),
    )


def in_one_world(spec: ExperimentSpec, world: EnvironmentChoice) -> ExperimentSpec:
    """Return an experiment in one world, for which the thesis prints no figures."""
    return in_world(msgspec.structs.replace(spec, blocks=()), world)


# Success and laws ---------------------------------------------------------------------------


def success(result: Result) -> bool:
    """Return whether a run covered at least `COVERED`, and ended with a map known complete."""
    return (
        result.success
        and result.metrics is not None
        and result.metrics.known_complete_s is not None
        and result.metrics.reached(COVERED)
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class Outcome:
    """Results on a map.

    Attributes
    ----------
    label : str
        Label of the map.
    scenario : Scenario or None
        The scenario of the thesis that it stands for; None for a map that was given.
    runs, successes : int
        Numbers of runs and of successful runs.
    time, home, to_95, distance : dict from int to float
        Means over the successful runs by team size: exploration time (s), time until all are done
        (s), time to 95 % coverage (s), path length of a robot (m).
    """

    label: str
    scenario: Scenario | None
    runs: int
    successes: int
    time: dict[int, float]
    home: dict[int, float]
    to_95: dict[int, float]
    distance: dict[int, float]


def outcomes(results: Results) -> list[Outcome]:
    """Return the results on every map of the experiment, in its order."""
    by_label = {scenario.label: scenario for scenario in SCENARIOS}
    asked = dict.fromkeys(
        at.environment for at in conditions(results.experiment) if at.strategy == STRATEGY
    )
    runs = _runs(results)
    return [outcome_of(label, by_label.get(label), runs[label, STRATEGY]) for label in asked]


def outcome_of(label: str, scenario: Scenario | None, here: Sequence[Result]) -> Outcome:
    """Return what runs on one map come to."""
    return Outcome(
        label=label,
        scenario=scenario,
        runs=len(here),
        successes=sum(map(success, here)),
        time=_means(here, TIME),
        home=_means(here, HOME),
        to_95=_means(here, TO_95),
        distance=_means(here, DISTANCE),
    )


def _runs(results: Results) -> defaultdict[tuple[str, str], list[Result]]:
    runs: defaultdict[tuple[str, str], list[Result]] = defaultdict(list)
    for result in results:
        runs[result.condition.environment, result.condition.strategy].append(result)
    return runs


def _means(results: Sequence[Result], measure: Measure) -> dict[int, float]:
    by_team: defaultdict[int, list[float]] = defaultdict(list)
    for result in results:
        value = measure.of(result)
        if success(result) and value is not None:
            by_team[result.condition.robots].append(value)
    return {robots: float(np.mean(by_team[robots])) for robots in sorted(by_team)}


# Claims -------------------------------------------------------------------------------------


def claims(results: Results) -> list[Claim]:
    """Return the judged claims of the thesis."""
    found = outcomes(results)
    printed = [(one, one.scenario) for one in found if one.scenario is not None]
    return [
        succeeds(found),
        falls_as_printed(
            TIME_FALLS, [Laws(one.label, of.time[1], one.time, one.home) for one, of in printed]
        ),
        falls_as_printed(
            DISTANCE_FALLS,
            [Laws(one.label, of.distance[1], one.distance, {}) for one, of in printed],
        ),
        *(judged.claim for judged in _doublings(results)),
    ]


def tables(results: Results) -> list[PrintedTable]:
    """Return our laws and success rates beside Table 4.1, the means, and the comparisons."""
    found = outcomes(results)
    return [
        beside(found),
        *ablations(results),
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
            f"{min(rates):.1f} to {max(rates):.1f} %"
        ]
        if share.high < least:
            decision = "does not hold"
        elif wilson(runs, runs).low < least:
            grounds.append("too few runs: even without a failure the interval would reach below")
        else:
            decision = "holds" if share.low >= least else "not significant"
    would_show = ""
    if decision == "not significant":
        enough = next(k for k in range(good, runs + 1) if wilson(k, runs).low >= least)
        would_show = f"a rate of {100.0 * enough / runs:.1f} % would have sufficed"
    return Claim(
        text=f"At least {MIN_SUCCESS:g} % of all explorations succeed.",
        source="Álvarez, Table 4.1 (94.06 to 99.06 % by map)",
        verdict=decision,
        grounds=tuple(grounds),
        would_show=would_show,
    )


def _doublings(results: Results) -> list[Judged]:
    cells = Cells(results)
    return [
        doubling("The exploration takes less time with twice as many robots", cells, TIME, HOME),
        doubling("A robot travels less with twice as many robots", cells, DISTANCE),
    ]


def doubling(text: str, cells: Cells, measure: Measure, beside: Measure | None = None) -> Judged:
    """Return the judged claim that twice the robots help, on all maps together."""
    return judge(
        f"{text}, up to one per {M2_PER_ROBOT:g} m2.",
        "Álvarez, section 4.2.1",
        _doubled(cells, measure),
        scope="always",
        so="it falls",
        otherwise="it rises",
        sides=("larger team", "smaller team"),
        beside=None if beside is None else _doubled(cells, beside),
    )


def _doubled(cells: Cells, measure: Measure) -> Family:
    at = {
        (one.environment, one.robots): one for one in cells.conditions() if one.strategy == STRATEGY
    }
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


def ablations(results: Results) -> list[PrintedTable]:
    """Return the exponents of variants of the strategy on one map; none if there are none."""
    runs = _runs(results)
    asked = {at.strategy for at in conditions(results.experiment)}
    variants = [label for label in ABLATIONS if label in asked]
    if not variants:
        return []
    rows = []
    for label in (STRATEGY, *variants):
        here = [
            result
            for result in runs[ABLATION_LABEL, label]
            if result.condition.robots in ABLATION_TEAMS
        ]
        one = outcome_of(ABLATION_LABEL, None, here)
        name = "as in the experiment" if label == STRATEGY else label
        laws = [law(means) for means in (one.time, one.to_95, one.distance)]
        texts = ["-" if fit is None else interval_text(fit.exponent) for fit in laws]
        rows.append((name, *texts, f"{one.successes} of {one.runs}"))
    return [
        PrintedTable(
            title=f"What the exponents depend on: {ABLATION_LABEL}, teams of "
            f"{', '.join(map(str, ABLATION_TEAMS))}",
            source="Álvarez, Table 4.1: time -0.801, distance -1.005",
            columns=("variant", "b of time", "b of time to 95 %", "b of distance", "successful"),
            rows=tuple(rows),
            note="Swaps by sums: only if the sum of both paths does not grow. Fine cells: "
            f"{0.5 * CELL_M:g} m for the map. With 95 % intervals.",
        )
    ]


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
    run_s=5.0,
    quick_run_s=3.0,
    on_map=in_one_world,
)
