"""Multi-SRT in two worlds, after the simulations in section 3 of its paper."""

from __future__ import annotations

from collections import defaultdict
from itertools import pairwise

import numpy as np

from multisrt.experiments.crossing import Condition
from multisrt.experiments.measures import Measure, measure_named
from multisrt.experiments.results import Result, Results
from multisrt.experiments.spec import ExperimentSpec, Only
from multisrt.presets.cells import Cells, Family
from multisrt.presets.judging import Judged, judge
from multisrt.presets.multi_srt_ablations import (
    ABLATIONS,
    DISTANCE_GROWS,
    FOUR_BODIES,
    IN_CONTACT,
    KNOWN,
    LIMITED,
    NEAREST_OPEN,
    NO_CUTS,
    NO_GAPS,
    NO_TAKE_OVER,
    NONE_SUPPORTED,
    OPEN_ENTRY,
    PAPERS_PLANNER_ALONE,
    PLANNER_TELLS,
    RADIAL,
    RADIO_RANGE_M,
    STAR,
    TAKES_LONGER,
    TIME,
    TIMES,
    TWO_BODIES,
)
from multisrt.presets.preset import Deviation, Preset
from multisrt.presets.words import failed_runs, number
from multisrt.reporting.claims import Claim, PrintedTable, Verdict
from multisrt.spec import RangeFinderSpec, StopRule
from multisrt.statistics.ratios import POWER
from multisrt.statistics.summaries import median

WORLDS = ("garden", "clutter")
TEAMS, QUICK_TEAMS = (1, 2, 4, 8, 16), (1, 2, 4)
REPETITIONS, QUICK_REPETITIONS = 20, 10
RANGE_M = 4.0
MAX_TIME_S = 14_400.0
"""Limit of a run in simulated time: several times what one robot needs."""

MAX_LISTED = 10
"""Upper bound of the runs that the grounds of a claim name one by one."""

DISTANCE = measure_named("total_distance_m")
OTHERS = tuple(map(measure_named, ("waiting_time_s", "overlap_share", "coverage", "deadlocks")))

SOURCE = "Multi-SRT, section 3 (simulation results), Figure 7"

DEVIATIONS = (
    Deviation(
        "Planning has two stages beyond the paper's, without which explorations end with unseen "
        "rooms: an approach to frontiers that no random draw reaches, and at the root a path back "
        "to frontiers left open. Frontier that no reachable place can open is closed, so that an "
        "exploration ends with its map known complete.",
        (PAPERS_PLANNER_ALONE, PLANNER_TELLS),
    ),
    Deviation(
        "d_min, the minimum distance between nodes, is the body's width. The paper gives no value.",
        (TWO_BODIES, FOUR_BODIES),
    ),
    Deviation(
        "Gaps count as frontier: the edges of what a corner hides. The paper does not say.",
        (NO_GAPS,),
    ),
    Deviation(
        "Cuts count as frontier: where a cone of a star ends before an obstacle that stands in "
        "another part of it. The paper has no such frontier; its obstacle would hide all doors "
        "that are narrower than a cone.",
        (NO_CUTS,),
    ),
    Deviation(
        "From a node with nothing to do robots go back step by step to the parent, as in the "
        "paper. The option of going straight to the nearest node with a frontier is off.",
        (NEAREST_OPEN,),
    ),
    Deviation(
        "Support: a tree may be supported from an open frontier of the sensing range per active "
        "robot (the paper gives no F bar). Trees are joined by bridges, and robots go home from "
        "where they stand; the paper leaves both open. As in the paper, support begins at the root "
        "of a tree.",
        (NONE_SUPPORTED, OPEN_ENTRY),
    ),
    Deviation(
        "Take-over: with the limited radio a robot that is done takes over the frontier of one "
        "that it has not heard from for two minutes. In the paper there is no support then.",
        (NO_TAKE_OVER, IN_CONTACT),
    ),
    Deviation(
        "Worlds: the garden and the clutter of the catalog, with their default parameters. The "
        "paper describes and shows its two square worlds, but gives no sizes."
    ),
    Deviation(
        f"Robots: discs of 0.25 m, differential, 0.5 m/s; range finders {RANGE_M:g} m, exact. The "
        "paper does not specify its robots."
    ),
    Deviation(
        f"Radio: unlimited, or {RADIO_RANGE_M:g} m and relayed. The paper does not give its "
        "limited range."
    ),
    Deviation(
        "A single robot starts where the world suggests; its runs are made once, as neither starts "
        "nor radio affect it."
    ),
    Deviation("Frontier shorter than the body's width is dropped. The paper has no such bound."),
    Deviation(
        "Groups agree on a key before any robot moves, a master that does not answer is replaced, "
        "and robots stop before bodies in sight, of which a detector gives number and pose. The "
        "paper describes none of these."
    ),
    Deviation(
        "Time: the paper does not define its exploration time. Its explorations end at the roots "
        "(section 2), so that the time until all robots are home is the likely one; each claim on "
        "times is judged by the time until a robot knows the map complete as well."
    ),
    Deviation(
        "The paper averages 20 runs and shows curves only: there are no printed figures for "
        "comparison, and no tests."
    ),
)


def experiment(quick: bool) -> ExperimentSpec:
    """Return the experiment of the paper, or a quick one with fewer teams and runs."""
    return ExperimentSpec(
        name="multi-srt quick" if quick else "multi-srt",
        about="How team size, starts and radio bear on Multi-SRT, Star and Radial",
        environments=WORLDS,
        strategies=(STAR, RADIAL),
        robots=QUICK_TEAMS if quick else TEAMS,
        starts=("scattered", "clustered"),
        radios=("unlimited", LIMITED),
        exclude=(Only(robots=1, starts="clustered"), Only(robots=1, radio=f"{RADIO_RANGE_M:g} m")),
        repetitions=QUICK_REPETITIONS if quick else REPETITIONS,
        range_finder=RangeFinderSpec(range_m=RANGE_M),
        stop=StopRule(max_time_s=MAX_TIME_S),
    )


def claims(results: Results) -> list[Claim]:
    """Return the judged claims of the paper."""
    return [
        *(judged.claim for judged in _compared(results)),
        all_complete(results),
        no_collision(results),
    ]


def tables(results: Results) -> list[PrintedTable]:
    """Return the measures by team size, and the comparisons behind the claims."""
    cells = Cells(results)
    return [
        *(_by_team(cells, measure, drawn=True) for measure in (TIME, KNOWN, DISTANCE)),
        *(_by_team(cells, measure, drawn=False) for measure in OTHERS),
        *(judged.table for judged in _compared(results)),
    ]


# Claims that compare ------------------------------------------------------------------------


def _compared(results: Results) -> list[Judged]:
    cells = Cells(results)
    return [
        *(time_falls(cells, time) for time in TIMES),
        *(time_does_not_always_fall(cells, time) for time in TIMES),
        distance_grows(cells),
        *(radial_is_better(cells, measure) for measure in (*TIMES, DISTANCE)),
    ]


def time_falls(cells: Cells, time: Measure) -> Judged:
    """Return the judged claim on scattered starts, by neighbouring team sizes."""
    return judge(
        f"With scattered starts the time {TIMES[time]} falls as the team grows.",
        SOURCE,
        _growing(cells, time, ("scattered",), larger_is_lower=True),
        scope="always",
        so="it falls",
        otherwise="it rises",
        sides=("larger team", "smaller team"),
    )


def time_does_not_always_fall(cells: Cells, time: Measure) -> Judged:
    """Return the judged claim on clustered starts, which has exceptions in the paper."""
    return judge(
        TAKES_LONGER[time],
        SOURCE,
        _growing(cells, time, ("clustered",)),
        scope="somewhere",
        so="the time rises",
        otherwise="it falls",
        sides=("smaller team", "larger team"),
    )


def distance_grows(cells: Cells) -> Judged:
    """Return the judged claim on the total distance, by neighbouring team sizes."""
    return judge(
        DISTANCE_GROWS,
        SOURCE,
        _growing(cells, DISTANCE, ("scattered", "clustered")),
        scope="always",
        so="it grows",
        otherwise="it falls",
        sides=("smaller team", "larger team"),
    )


def radial_is_better(cells: Cells, measure: Measure) -> Judged:
    """Return the judged claim on the two strategies, with equal starts."""
    what = f"less time {TIMES[measure]}" if measure in TIMES else "a shorter total distance"
    return judge(
        f"Radial needs {what} than Star.",
        f"{SOURCE} ('the efficiency of Multi-SRT Radial over Multi-SRT Star')",
        _radial_and_star(cells, measure),
        scope="mostly",
        so="Radial needs less",
        otherwise="it needs more",
        sides=("Radial", "Star"),
    )


def _growing(
    cells: Cells, measure: Measure, starts: tuple[str, ...], *, larger_is_lower: bool = False
) -> Family:
    """Return the comparisons of neighbouring team sizes."""
    return Family(
        comparisons=[
            cells.compared(
                (f"{how}: " if len(starts) > 1 else "") + _step(small, large),
                lower=large if larger_is_lower else small,
                higher=small if larger_is_lower else large,
                measure=measure,
            )
            for how in starts
            for small, large in _steps(cells, how)
        ],
        quantity=measure,
    )


def _radial_and_star(cells: Cells, measure: Measure) -> Family:
    pairs: defaultdict[tuple[object, ...], dict[str, Condition]] = defaultdict(dict)
    for at in cells.conditions():
        pairs[at.environment, at.robots, at.starts, at.radio][at.strategy] = at
    return Family(
        comparisons=[
            cells.compared(_place(of[STAR]), lower=of[RADIAL], higher=of[STAR], measure=measure)
            for of in pairs.values()
            if of.keys() >= {STAR, RADIAL}
        ],
        quantity=measure,
    )


def _steps(cells: Cells, starts: str) -> list[tuple[Condition, Condition]]:
    # Neighbouring team sizes in each series; every series begins with the single robot.
    series: defaultdict[tuple[str, ...], list[Condition]] = defaultdict(list)
    alone: dict[tuple[str, str], Condition] = {}
    for at in cells.conditions():
        if at.robots == 1:
            alone[at.environment, at.strategy] = at
        elif at.starts == starts:
            series[at.environment, at.strategy, at.radio].append(at)
    return [
        step
        for (world, strategy, _), teams in series.items()
        for step in pairwise(
            ([alone[world, strategy]] if (world, strategy) in alone else [])
            + sorted(teams, key=lambda at: at.robots)
        )
    ]


def _step(small: Condition, large: Condition) -> str:
    return (
        f"{large.environment}, {large.strategy}, {large.radio} radio, {small.robots} to "
        f"{large.robots} robots"
    )


def _place(at: Condition) -> str:
    if at.robots == 1:
        return f"{at.environment}, a single robot"
    return f"{at.environment}, {at.robots} robots, {at.starts}, {at.radio} radio"


# Claims on every run ------------------------------------------------------------------------


def all_complete(results: Results) -> Claim:
    """Return the judged claim that every exploration is completed: is complete, and a success."""
    bad = [result for result in results if result.failed or result.status != "complete"]
    return Claim(
        text="All explorations are completed.",
        source="Multi-SRT, section 2 (robots return to their roots when no frontier is left)",
        verdict=_of_all(results, bad),
        grounds=(
            f"{len(results) - len(bad)} of {len(results)} runs are complete and cover at least "
            f"{100.0 * results.experiment.success_coverage:.0f} %, of {results.planned} asked for",
            *failed_runs(bad, MAX_LISTED),
        ),
        would_show=_rare(len(results)),
    )


def no_collision(results: Results) -> Claim:
    """Return the judged claim that there are no collisions."""
    measured = [result.metrics for result in results if result.metrics is not None]
    bad = [r for r in results if r.metrics is not None and r.metrics.collisions > 0]
    apart = [
        one.min_distance_between_robots_m
        for one in measured
        if one.min_distance_between_robots_m is not None
    ]
    grounds = [
        f"collisions in {len(bad)} of {len(measured)} runs that were measured, of "
        f"{results.planned} asked for"
    ]
    if apart:
        grounds.append(
            f"minimum distance between two bodies: {min(apart):.3f} m; between a body and an "
            f"obstacle: {min(one.min_clearance_m for one in measured):.3f} m"
        )
    return Claim(
        text="The motion of the team is free of collisions.",
        source="Multi-SRT, section 3 ('guarantees that the collective motion of the robots is "
        "feasible from the collision viewpoint')",
        verdict=_of_all(results, bad),
        grounds=(*grounds, *failed_runs(bad, MAX_LISTED)),
        would_show=_rare(len(measured)),
    )


def _of_all(results: Results, bad: list[Result]) -> Verdict:
    # One run refutes a claim on all runs; it holds only if all of them are made.
    if bad:
        return "does not hold"
    return "holds" if len(results) == results.planned > 0 else "not tested"


def _rare(runs: int) -> str:
    """Return the share of bad runs of which `POWER` of such experiments have one or more."""
    if not runs:
        return ""
    share = 1.0 - (1.0 - POWER) ** (1.0 / runs)
    return f"{100.0 * share:.2g} % of bad runs would have been detected"


# Tables -------------------------------------------------------------------------------------


def _by_team(cells: Cells, measure: Measure, *, drawn: bool) -> PrintedTable:
    teams = sorted({at.robots for at in cells.conditions()})
    lines: dict[tuple[str, ...], dict[int, Condition]] = {}
    for at in cells.conditions():
        how = ("", "") if at.robots == 1 else (at.starts, at.radio)
        lines.setdefault((at.environment, at.strategy, *how), {})[at.robots] = at
    return PrintedTable(
        title=f"{measure.heading} by team size",
        source="Multi-SRT, Figure 7 (curves only)" if drawn else "",
        columns=(
            *("world", "strategy", "starts", "radio"),
            *(f"{n} robot{'s' * (n > 1)}" for n in teams),
        ),
        rows=tuple(
            (
                *name,
                *(
                    _spread([*cells.values(of[n], measure).values()], measure) if n in of else ""
                    for n in teams
                ),
            )
            for name, of in lines.items()
        ),
        note="Medians, and in brackets means and standard deviations, over all runs."
        + " The paper shows its means as curves, without figures." * drawn,
    )


def _spread(values: list[float], measure: Measure) -> str:
    if not values:
        return "-"
    of = np.array(values)
    known = of[np.isfinite(of)]
    middle = number(float(median(of)), measure.digits)
    if not len(known):
        return middle
    mean, deviation = float(known.mean()), float(known.std(ddof=1)) if len(known) > 1 else 0.0
    some = "" if len(known) == len(of) else f", {len(known)} of {len(of)}"
    return f"{middle} ({mean:.{measure.digits}f} ± {deviation:.{measure.digits}f}{some})"


MULTI_SRT = Preset(
    name="multi-srt",
    about="Multi-SRT Star and Radial in a garden and in clutter, by team size, starts and radio",
    paper="A. Toriz Palacios, A. Sánchez López and co-authors, Coordinated multi-agent exploration "
    "(Multi-SRT)",
    experiment=experiment,
    claims=claims,
    tables=tables,
    deviations=DEVIATIONS,
    run_s=1.2,
    quick_run_s=0.7,
    ablations=ABLATIONS,
)
