"""Álvarez's rules on ten maps, as in chapter 4 of the thesis, beside its Table 4.1.

For each map the thesis fits y = a x^b to the mean exploration time and to the mean path length of
a robot, for teams of x robots. The coefficient a measures the task, the exponent b how well the
team shares it: -1 is a team without any loss.
"""

from __future__ import annotations

import math
from collections import defaultdict
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from multisrt.experiments.measures import Measure, measure_named
from multisrt.experiments.results import Result, Results
from multisrt.experiments.spec import EnvironmentChoice, ExperimentSpec, StartsChoice
from multisrt.presets.alvarez_maps import QUICK_SCENARIOS, SCENARIOS, Scenario
from multisrt.presets.cells import Cells, Family
from multisrt.presets.findings import Saying
from multisrt.presets.judging import Judged, judge, verdict
from multisrt.presets.preset import Preset
from multisrt.reporting.claims import Claim, PrintedTable, Verdict
from multisrt.spec import RangeFinderSpec, StopRule
from multisrt.statistics.intervals import LEVEL, Interval, student, wilson
from multisrt.statistics.power_law import PowerLaw, fit_power_law

STRATEGY = "rules"
TEAMS, QUICK_TEAMS = (1, 2, 3, 4, 5, 6, 7, 8), (1, 2, 4)
REPETITIONS, QUICK_REPETITIONS = 10, 7
PAPERS_REPETITIONS = 40
RANGE_M = 4.5
MAX_TIME_S = 28_800.0
"""Limit of a run in simulated time: several times what one robot needs on the largest map."""

COVERED = 0.95
"""Minimum share of the explorable area that a successful run has covered."""

TIME_EXPONENTS, DISTANCE_EXPONENTS = (-1.02, -0.70), (-1.42, -0.74)
"""Bounds of 99 % of all exponents, by the thesis (section 4.2.1)."""

M2_PER_ROBOT = 60.0
"""Area per robot below which more robots do not help, by the thesis (section 4.2.1)."""

TIME, HOME = measure_named("known_complete_s"), measure_named("makespan_s")
"""The time by which the claims are judged, and the one that is shown beside it."""

DISTANCE = measure_named("distance_per_robot_m")

MIN_SUCCESS = min(scenario.success_percent for scenario in SCENARIOS)

DEVIATIONS = (
    "Worlds: generated maps with the outer size and of the kind of the thesis's maps, which are "
    "not available. Areas in the thesis are taken as those of whole maps.",
    f"Robots: discs of 0.25 m, differential, 0.5 m/s; range finders {RANGE_M:g} m, exact; a radio "
    "of unlimited range. The thesis has 0.1 m/s and the Husky A200, which is larger. Times are "
    "shorter here for this reason alone: exponents and distances can be compared, times cannot.",
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
    f"The thesis finds that more robots help up to one per {M2_PER_ROBOT:g} m2. Its smallest map "
    "has room for ten by this rule, and neither experiment has larger teams.",
)


def experiment(quick: bool) -> ExperimentSpec:
    """Return the experiment of the thesis, or a quick one with fewer maps, teams and runs."""
    return ExperimentSpec(
        name="alvarez quick" if quick else "alvarez",
        about="How time and distance fall with the team by Álvarez's rules, and how many succeed",
        environments=tuple(
            EnvironmentChoice(
                name=scenario.name, label=scenario.label, parameters=scenario.parameters
            )
            for scenario in SCENARIOS
            if not quick or scenario.number in QUICK_SCENARIOS
        ),
        strategies=(STRATEGY,),
        robots=QUICK_TEAMS if quick else TEAMS,
        starts=(StartsChoice(how="scattered", first="drawn"),),
        repetitions=QUICK_REPETITIONS if quick else REPETITIONS,
        range_finder=RangeFinderSpec(range_m=RANGE_M),
        stop=StopRule(max_time_s=MAX_TIME_S),
    )


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
    """Results on the map in place of a scenario.

    Attributes
    ----------
    scenario : Scenario
        The scenario.
    runs, successes : int
        Numbers of runs and of successful runs.
    time, home, distance : dict from int to float
        Means over the successful runs by team size: exploration time (s), time until all are home
        (s), path length of a robot (m).
    """

    scenario: Scenario
    runs: int
    successes: int
    time: dict[int, float]
    home: dict[int, float]
    distance: dict[int, float]


def outcomes(results: Results) -> list[Outcome]:
    """Return the results on every map of the experiment, in the order of the thesis."""
    asked = {
        given if isinstance(given, str) else given.label
        for given in results.experiment.environments
    }
    runs: defaultdict[str, list[Result]] = defaultdict(list)
    for result in results:
        runs[result.condition.environment].append(result)
    return [
        Outcome(
            scenario=scenario,
            runs=len(here := runs[scenario.label]),
            successes=sum(map(success, here)),
            time=_means(here, TIME),
            home=_means(here, HOME),
            distance=_means(here, DISTANCE),
        )
        for scenario in SCENARIOS
        if scenario.label in asked
    ]


def _means(results: list[Result], measure: Measure) -> dict[int, float]:
    by_team: defaultdict[int, list[float]] = defaultdict(list)
    for result in results:
        value = measure.of(result)
        if success(result) and value is not None:
            by_team[result.condition.robots].append(value)
    return {robots: float(np.mean(by_team[robots])) for robots in sorted(by_team)}


def law(means: dict[int, float], level: float = LEVEL) -> PowerLaw | None:
    """Return the power law fitted to means by team size; None for fewer than three sizes."""
    if len(means) < 3:
        return None
    return fit_power_law(list(means), list(means.values()), level=level)


# Claims -------------------------------------------------------------------------------------


def claims(results: Results) -> list[Claim]:
    """Return the judged claims of the thesis."""
    found = outcomes(results)
    return [
        succeeds(found),
        exponents_between(
            "exploration time",
            [Laws(one.scenario.label, one.scenario.time[1], one.time, one.home) for one in found],
            TIME_EXPONENTS,
        ),
        exponents_between(
            "path length of a robot",
            [Laws(one.scenario.label, one.scenario.distance[1], one.distance, {}) for one in found],
            DISTANCE_EXPONENTS,
        ),
        *(judged.claim for judged in _doublings(results)),
    ]


def tables(results: Results) -> list[PrintedTable]:
    """Return our laws and success rates beside Table 4.1, the means, and the comparisons."""
    found = outcomes(results)
    return [
        beside(found),
        _means_table("Mean exploration time (s)", [(one, one.time) for one in found]),
        _means_table("Mean time until all are home (s)", [(one, one.home) for one in found]),
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


class Laws(NamedTuple):
    """Means by team size on one map, by which a law is fitted, and the printed exponent.

    Attributes
    ----------
    label : str
        Label of the map.
    printed : float
        Exponent in the thesis.
    means : dict from int to float
        Means by team size.
    beside : dict from int to float
        Means by the quantity that is shown beside; empty without one.
    """

    label: str
    printed: float
    means: dict[int, float]
    beside: dict[int, float]


def exponents_between(what: str, maps: list[Laws], limits: tuple[float, float]) -> Claim:
    """Return the judged claim that the exponents of all maps lie between two limits.

    The maps are judged together: the mean of their exponents has Student's interval over maps. The
    claim holds if all of it lies between the limits; it does not hold if none of it does, or none
    of the interval of some map, of which all hold simultaneously (Bonferroni).

    Parameters
    ----------
    what : str
        The quantity that falls.
    maps : list of Laws
        The means of each map.
    limits : (float, float)
        The limits.
    """
    low, high = limits
    level = 1.0 - (1.0 - LEVEL) / max(1, len(maps))
    fits = [(one, law(one.means, level)) for one in maps]
    known = [(one, fit.exponent) for one, fit in fits if fit is not None]
    sayings = [_says_between(exponent, limits) for _, exponent in known]
    values = [exponent.value for _, exponent in known]
    together = student(values) if len(values) > 1 else None
    decision: Verdict = "not tested"
    would_show, grounds = "", []
    if together is not None:
        half = together.high - together.value
        grounds += [
            f"all maps together: {_interval_text(together)}; "
            f"{sum(low <= value <= high for value in values)} of {len(known)} exponents lie "
            f"between, and {sayings.count('against')} intervals lie entirely outside",
            f"ours are {_span(values)}; the thesis's {_span([one.printed for one in maps])}",
        ]
        apart = student(
            [value - one.printed for (one, _), value in zip(known, values, strict=True)]
        )
        grounds.append(f"ours minus the thesis's, by map: {_interval_text(apart)}")
        if 2 * len(known) > len(maps):
            decision = verdict(_says_between(together, limits), sayings, "always")
        if decision == "not significant":
            would_show = f"a mean of {low + half:.2f} to {high - half:.2f} would have sufficed"
    if decision == "not tested":
        grounds.append("too few runs: a fit needs three team sizes with successful runs")
    home = [fit.exponent.value for one in maps if (fit := law(one.beside))]
    if len(home) > 1:
        grounds.append(f"{HOME.heading}: {_interval_text(student(home))}")
    grounds += [
        f"{one.label}: {_interval_text(exponent)}, outside"
        for (one, exponent), saying in zip(known, sayings, strict=True)
        if saying == "against"
    ]
    return Claim(
        text=f"The {what} falls with team size by an exponent of {low:g} to {high:g}.",
        source="Álvarez, section 4.2.1 (99 % of all cases), Figures 4.16 to 4.19",
        verdict=decision,
        grounds=tuple(grounds),
        would_show=would_show,
    )


def _says_between(exponent: Interval, limits: tuple[float, float]) -> Saying:
    low, high = limits
    if exponent.high < low or exponent.low > high:
        return "against"
    return "for" if low <= exponent.low and exponent.high <= high else "nothing"


def _interval_text(of: Interval) -> str:
    return f"{of.value:+.3f} ({of.low:+.3f} to {of.high:+.3f})"


def _span(exponents: list[float]) -> str:
    return f"{min(exponents):.3f} to {max(exponents):.3f}, {np.mean(exponents):.3f} on average"


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
        printed, (time, distance) = one.scenario, (law(one.time), law(one.distance))
        rate = 100.0 * one.successes / one.runs if one.runs else math.nan
        rows.append((printed.label, *_line(rate, time, distance)))
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
                one.scenario.label,
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
)
