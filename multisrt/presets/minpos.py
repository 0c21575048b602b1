"""MinPos against greedy and closest in mazes and a hospital, as in section V A of its paper.

The gain of a strategy is the reduction of the exploration time against a rival, in percent. It is
computed from the geometric mean of the ratios of the two times in each repetition, in which both
have the same world and starts; this mean favours neither of the two.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from multisrt.experiments.crossing import Condition
from multisrt.experiments.measures import measure_named
from multisrt.experiments.results import Results
from multisrt.experiments.spec import (
    EnvironmentChoice,
    ExperimentSpec,
    Only,
    StartsChoice,
)
from multisrt.geometry.numerics.arrays import FloatArray
from multisrt.presets.judging import Cells, Comparison, Judged, judge
from multisrt.presets.preset import Preset
from multisrt.reporting.claims import Claim, PrintedTable, Verdict
from multisrt.spec import DriveSpec, RangeFinderSpec, StopRule
from multisrt.statistics.intervals import LEVEL, Interval, bootstrap

CLOSEST, GREEDY, MINPOS = "closest", "greedy", "minpos"
MAZE, HOSPITAL = "maze", "hospital"
WORLDS = (MAZE, HOSPITAL)
TEAMS, QUICK_TEAMS = (1, 2, 4, 6, 8, 10, 12), (1, 2, 4)
REPETITIONS, QUICK_REPETITIONS = 20, 8
MAZE_M, MAZE_CELLS = 20.0, 10
RANGE_M = 4.0
MAX_TIME_S = 14_400.0
"""Limit of a run in simulated time: several times what one robot needs."""

MEAN_GAINS = {GREEDY: 8.0, MINPOS: 12.0}
"""Mean gains on closest in the paper, in percent (section V A)."""

LARGEST_GAINS = {HOSPITAL: 15.0, MAZE: 20.0}
"""Largest gains of greedy and minpos on closest in the paper, in percent (section V A)."""

MIN_PAIRS = 6
"""Minimum number of complete pairs of each condition for an interval of a gain."""

SOURCE = "MinPos, section V A, Figures 9 and 10"
TIME = measure_named("known_complete_s")

DEVIATIONS = (
    f"Worlds: perfect mazes of {MAZE_M:g} x {MAZE_M:g} m with {MAZE_CELLS} x {MAZE_CELLS} cells, "
    "one for each repetition, and the hospital of the catalog. The paper's mazes and its hospital "
    "(of Player/Stage) are not available.",
    f"Robots: discs of 0.25 m that drive in any direction, 0.5 m/s; range finders {RANGE_M:g} m, "
    "exact; a radio of unlimited range. The paper's robots have the size of a grid cell and its "
    "time is counted in steps.",
    "Robots obstruct each other: bodies have a size, and robots give way. The paper does not say "
    "whether its simulated robots do.",
    "Starts: close together, as in the paper (section II), which does not say where. Here the "
    "configuration of the first robot is drawn in each repetition and the others stand around it. "
    "All strategies have the same starts and worlds.",
    "The paper gives neither team sizes nor the number of runs in its text, and times as curves "
    "only: there are no printed figures for single team sizes.",
    "All strategies choose again on news, at most once per second.",
    "An exploration ends when one of the robots has a complete map, as in the paper (section II).",
)


def experiment(quick: bool) -> ExperimentSpec:
    """Return the experiment of the paper, or a quick one with fewer teams and runs."""
    return ExperimentSpec(
        name="minpos quick" if quick else "minpos",
        about="How much sooner a team is done that does not go to the closest frontier",
        environments=(
            EnvironmentChoice(
                name=MAZE,
                parameters={"size_m": MAZE_M, "cells": MAZE_CELLS},
                seed="repetition",
            ),
            HOSPITAL,
        ),
        strategies=(CLOSEST, GREEDY, MINPOS),
        robots=QUICK_TEAMS if quick else TEAMS,
        starts=(StartsChoice(how="clustered", first="drawn"),),
        # For a single robot all strategies are the same.
        exclude=(Only(robots=1, strategy=(GREEDY, MINPOS)),),
        repetitions=QUICK_REPETITIONS if quick else REPETITIONS,
        drive=DriveSpec(kind="holonomic"),
        range_finder=RangeFinderSpec(range_m=RANGE_M),
        stop=StopRule(max_time_s=MAX_TIME_S),
    )


# Gains --------------------------------------------------------------------------------------


class Times:
    """The exploration times of an experiment's teams.

    Parameters
    ----------
    results : Results
        Results of the experiment, which may be incomplete.
    """

    def __init__(self, results: Results) -> None:
        self.cells = Cells(results)
        self._at: dict[tuple[str, str, int], Condition] = {
            (at.environment, at.strategy, at.robots): at for at in self.cells.conditions()
        }
        self.teams = sorted({robots for _, _, robots in self._at if robots > 1})

    def compared(self, world: str, robots: int, strategy: str, rival: str) -> Comparison:
        """Return the comparison of a strategy with a rival, in pairs of repetitions."""
        return self.cells.paired(
            f"{world}, {robots} robots",
            lower=self._at[world, strategy, robots],
            higher=self._at[world, rival, robots],
            measure=TIME,
        )

    def ratios(self, world: str, robots: int, strategy: str, rival: str) -> FloatArray:
        """Return the logarithms of the ratios of both times, for pairs of complete runs."""
        pairs = self.compared(world, robots, strategy, rival)
        both = np.array([pairs.lower, pairs.higher])
        ours, rivals = np.log(both[:, np.isfinite(both).all(axis=0)])
        return np.asarray(ours - rivals)


def gain(strata: Iterable[FloatArray], level: float = LEVEL) -> Interval | None:
    """Return a gain in percent with its interval; None if a condition has too few pairs.

    Parameters
    ----------
    strata : iterable of (n,) array
        Logarithms of the ratios of times, by condition. All pairs have equal weights.
    level : float, optional
        Confidence level of the interval.
    """
    ratios = list(strata)
    if not ratios or min(map(len, ratios)) < MIN_PAIRS:
        return None
    return bootstrap(ratios, _percent, level=level, rng=0)


def _percent(log_ratios: FloatArray) -> FloatArray:
    return np.asarray(100.0 * (1.0 - np.exp(np.mean(log_ratios, axis=-1))))


def reaches(found: Interval | None, printed: float) -> Verdict:
    """Return the verdict on a printed gain.

    It does not hold if the whole interval of our gain is below it. Otherwise it holds if the
    interval is above 0.
    """
    if found is None:
        return "not tested"
    if found.high < printed:
        return "does not hold"
    return "holds" if found.low > 0.0 else "not significant"


# Claims -------------------------------------------------------------------------------------


def claims(results: Results) -> list[Claim]:
    """Return the judged claims of the paper."""
    times = Times(results)
    faster, others = _faster(times), _others(times)
    return [
        *(judged.claim for judged in faster),
        *(mean_gain(times, strategy) for strategy in (GREEDY, MINPOS)),
        *(largest_gain(times, world) for world in (HOSPITAL, MAZE)),
        before_greedy(times),
        *(judged.claim for judged in others),
    ]


def tables(results: Results) -> list[PrintedTable]:
    """Return our gains beside the paper's, and the comparisons behind the claims."""
    times = Times(results)
    return [
        gains(times),
        *(judged.table for judged in (*_faster(times), *_others(times))),
    ]


def _faster(times: Times) -> list[Judged]:
    return [
        judge(
            f"{strategy} is faster than closest.",
            SOURCE,
            [times.compared(*at, strategy, CLOSEST) for at in _places(times)],
            scope="mostly",
            quantity=TIME,
            so=f"{strategy} is faster",
            otherwise="it is slower",
            sides=(strategy, CLOSEST),
        )
        for strategy in (GREEDY, MINPOS)
    ]


def _others(times: Times) -> list[Judged]:
    return [more_with_more_robots(times), more_in_mazes(times)]


def mean_gain(times: Times, strategy: str) -> Claim:
    """Return the judged claim on the mean gain of a strategy on closest."""
    printed = MEAN_GAINS[strategy]
    found = gain(times.ratios(*at, strategy, CLOSEST) for at in _places(times))
    return Claim(
        text=f"On average {strategy} shortens the exploration by {printed:g} %, against closest.",
        source="MinPos, section V A",
        verdict=reaches(found, printed),
        grounds=(_told(found, printed),),
    )


def largest_gain(times: Times, world: str) -> Claim:
    """Return the judged claim on the largest gain in a world.

    The largest of several estimates is biased upwards, so the intervals of all of them hold
    simultaneously (Bonferroni).
    """
    printed = LARGEST_GAINS[world]
    places = [(robots, s) for robots in times.teams for s in (GREEDY, MINPOS)]
    found = {
        (robots, s): one
        for robots, s in places
        if (one := gain([times.ratios(world, robots, s, CLOSEST)], _at_once(len(places))))
    }
    best = max(found, key=lambda at: found[at].value, default=None)
    grounds = [_told(found[best] if best else None, printed)]
    if best:
        grounds.append(f"the largest gain is that of {best[1]} with {best[0]} robots")
    return Claim(
        text=f"In the {world} the exploration gets up to {printed:g} % shorter, against closest.",
        source="MinPos, section V A",
        verdict=reaches(found[best] if best else None, printed),
        grounds=tuple(grounds),
    )


def _at_once(many: int) -> float:
    return 1.0 - (1.0 - LEVEL) / many


def before_greedy(times: Times) -> Claim:
    """Return the judged claim that minpos is "slightly better" than greedy on average."""
    found = gain(times.ratios(*at, MINPOS, GREEDY) for at in _places(times))
    verdict: Verdict = "not tested"
    if found is not None:
        verdict = "holds" if found.low > 0.0 else "not significant"
        verdict = "does not hold" if found.high < 0.0 else verdict
    return Claim(
        text="On average minpos is slightly faster than greedy.",
        source="MinPos, section V A",
        verdict=verdict,
        grounds=(_told(found, None),),
    )


def more_with_more_robots(times: Times) -> Judged:
    """Return the judged claim that the gain on closest grows with team size."""
    few, many = (times.teams[0], times.teams[-1]) if len(times.teams) > 1 else (0, 0)
    return judge(
        "The larger the team, the more greedy and minpos gain on closest.",
        SOURCE,
        [
            _growth(times, world, strategy, few, many)
            for world in WORLDS
            for strategy in (GREEDY, MINPOS)
            if many
        ],
        scope="mostly",
        quantity=RatioOfTimes(),
        so="the gain is larger in the largest team than in the smallest",
        otherwise="it is smaller",
        sides=(f"{many} robots", f"{few} robots"),
    )


def _growth(times: Times, world: str, strategy: str, few: int, many: int) -> Comparison:
    return Comparison(
        where=f"{world}, {strategy}",
        lower=tuple(np.exp(times.ratios(world, many, strategy, CLOSEST)).tolist()),
        higher=tuple(np.exp(times.ratios(world, few, strategy, CLOSEST)).tolist()),
    )


def more_in_mazes(times: Times) -> Judged:
    """Return the judged claim that minpos gains more on greedy in mazes than in the hospital."""
    return judge(
        "Minpos gains more on greedy in mazes than in the hospital.",
        SOURCE,
        [
            Comparison(
                where=f"{robots} robots, minpos over greedy",
                lower=tuple(np.exp(times.ratios(MAZE, robots, MINPOS, GREEDY)).tolist()),
                higher=tuple(np.exp(times.ratios(HOSPITAL, robots, MINPOS, GREEDY)).tolist()),
            )
            for robots in times.teams
        ],
        scope="mostly",
        quantity=RatioOfTimes(),
        so="it gains more in mazes",
        otherwise="less",
        sides=(MAZE, HOSPITAL),
    )


@dataclass(frozen=True, slots=True)
class RatioOfTimes:
    """The quantity of comparisons of gains: a ratio of exploration times."""

    heading: str = "Exploration time over that of the rival"
    unit: str = ""
    digits: int = 2


def _places(times: Times) -> list[tuple[str, int]]:
    return [(world, robots) for world in WORLDS for robots in times.teams]


def _told(found: Interval | None, printed: float | None) -> str:
    if found is None:
        return f"too few runs: every condition needs {MIN_PAIRS} complete pairs"
    papers = "" if printed is None else f"; the paper: {printed:g} %"
    return (
        f"ours: {found.value:+.1f} % (interval {found.low:+.1f} to {found.high:+.1f}, stratified "
        f"bootstrap over pairs){papers}"
    )


# Table --------------------------------------------------------------------------------------


def gains(times: Times) -> PrintedTable:
    """Return the gains on closest in all conditions, beside the paper's mean and largest gains."""
    both = (GREEDY, MINPOS)
    rows = [
        (
            world,
            str(robots),
            *(_cell(gain([times.ratios(world, robots, s, CLOSEST)])) for s in both),
            "/".join(str(len(times.ratios(world, robots, s, CLOSEST))) for s in both),
        )
        for world, robots in _places(times)
    ]
    means = [gain(times.ratios(*at, s, CLOSEST) for at in _places(times)) for s in both]
    rows.append(("mean of all", "", *map(_cell, means), ""))
    rows.append(("paper: mean", "", *(f"{MEAN_GAINS[s]:+.1f}" for s in both), ""))
    for world in WORLDS:
        text = f"{LARGEST_GAINS[world]:+.1f} by the better one"
        rows.append((f"paper: largest, {world}", "", text, text, ""))
    return PrintedTable(
        title="Gains on closest (percent of the exploration time)",
        source=SOURCE,
        columns=("world", "robots", *both, "pairs"),
        rows=tuple(rows),
        note="With 95 % intervals, over repetitions in which both runs are complete.",
    )


def _cell(found: Interval | None) -> str:
    if found is None:
        return "-"
    return f"{found.value:+.1f} ({found.low:+.1f} to {found.high:+.1f})"


MINPOS_PRESET = Preset(
    name="minpos",
    about="MinPos, greedy and the closest frontier in mazes and a hospital, by team size",
    paper="A. Bautin, O. Simonin and F. Charpillet, Towards a communication free coordination for "
    "multi-robot exploration",
    experiment=experiment,
    claims=claims,
    tables=tables,
    deviations=DEVIATIONS,
)
