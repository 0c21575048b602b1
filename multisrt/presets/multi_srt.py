"""Multi-SRT in two worlds, after the simulations in section 3 of its paper."""

from __future__ import annotations

import numpy as np

from multisrt.experiments.crossing import Condition
from multisrt.experiments.measures import Measure, measure_named
from multisrt.experiments.results import Results
from multisrt.experiments.spec import ExperimentSpec, Only
from multisrt.presets.cells import Cells
from multisrt.presets.multi_srt_ablations import (
    ABLATIONS,
    FOUR_BODIES,
    IN_CONTACT,
    NEAREST_OPEN,
    NO_CUTS,
    NO_GAPS,
    NO_TAKE_OVER,
    NONE_SUPPORTED,
    OPEN_ENTRY,
    PAPERS_PLANNER_ALONE,
    PLANNER_TELLS,
    TWO_BODIES,
)
from multisrt.presets.multi_srt_claims import (
    DISTANCE,
    KNOWN,
    LIMITED,
    LIMITED_RADIO,
    RADIAL,
    RADIO_RANGE_M,
    STAR,
    TIME,
    UNLIMITED,
    compared,
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

OTHERS = tuple(map(measure_named, ("waiting_time_s", "overlap_share", "coverage", "deadlocks")))

DEVIATIONS = (
    Deviation(
        "Planning has two stages beyond the paper's, without which explorations end with unseen "
        "rooms: an approach to frontiers that no random draw reaches, and at the root a path back "
        "to frontiers left open. Frontier that no reachable place can open is closed, so that an "
        "exploration ends with its map known complete. The paper does not claim that explorations "
        "are complete, and no claim here is about it.",
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
    Deviation("Teams: 1, 2, 4, 8 and 16 robots. The paper gives no sizes in its text."),
    Deviation(
        "Clustered starts: the robots stand around the place where the world suggests to start, "
        "the same in all repetitions, which differ by the random draws of the strategy alone. "
        "Scattered starts differ. The paper gives none."
    ),
    Deviation(
        "Groups: robots are coupled where their targets are nearer than 2 R_p, with both radios. "
        "For the unlimited one the paper names 3 R_p, 'as in the above case', where that is the "
        "largest distance between two such robots."
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
        "times is judged by the time until one robot's map is complete as well."
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
        radios=(UNLIMITED, LIMITED_RADIO),
        exclude=(Only(robots=1, starts="clustered"), Only(robots=1, radio=LIMITED)),
        repetitions=QUICK_REPETITIONS if quick else REPETITIONS,
        range_finder=RangeFinderSpec(range_m=RANGE_M),
        stop=StopRule(max_time_s=MAX_TIME_S),
    )


def claims(results: Results) -> list[Claim]:
    """Return the judged claims of the paper."""
    return [
        *(judged.claim for judged in compared(Cells(results))),
        no_collision(results),
    ]


def tables(results: Results) -> list[PrintedTable]:
    """Return the measures by team size, and the comparisons behind the claims."""
    cells = Cells(results)
    return [
        *(_by_team(cells, measure, drawn=True) for measure in (TIME, KNOWN, DISTANCE)),
        *(_by_team(cells, measure, drawn=False) for measure in OTHERS),
        *(judged.table for judged in compared(cells)),
    ]


def no_collision(results: Results) -> Claim:
    """Return the judged claim that there are no collisions.

    A single one refutes it, and it holds only if all runs are made.
    """
    measured = [result.metrics for result in results if result.metrics is not None]
    bad = [r for r in results if r.metrics is not None and r.metrics.collisions > 0]
    verdict: Verdict = "does not hold" if bad else "not tested"
    if not bad and len(results) == results.planned > 0:
        verdict = "holds"
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
    would_show = ""
    if measured:
        share = 1.0 - (1.0 - POWER) ** (1.0 / len(measured))
        would_show = f"a collision in {100.0 * share:.2g} % of runs would have been detected"
    return Claim(
        text="The motion of the team is free of collisions.",
        source="Multi-SRT, section 3 ('guarantees that the collective motion of the robots is "
        "feasible from the collision viewpoint')",
        verdict=verdict,
        grounds=(*grounds, *failed_runs(bad, MAX_LISTED)),
        would_show=would_show,
    )


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
    paper="A. Sánchez López and A. Toriz Palacios, Coordinated multi-agent exploration "
    "(Multi-SRT), CEUR Workshop Proceedings 408, 2008",
    experiment=experiment,
    claims=claims,
    tables=tables,
    deviations=DEVIATIONS,
    run_s=1.2,
    quick_run_s=0.7,
    ablations=ABLATIONS,
)
