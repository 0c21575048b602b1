"""MinPos against greedy and closest in mazes and a hospital, as in section V A of its paper.

The gain of a strategy is the reduction of the exploration time against a rival, in percent. It is
computed from the geometric mean of the ratios of the two times in each repetition, in which both
have the same world and starts; this mean favours neither of the two. Repetitions are shared by all
team sizes and strategies, so intervals resample whole repetitions.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from multisrt.experiments.crossing import Condition
from multisrt.experiments.measures import Measure, measure_named
from multisrt.experiments.results import Results
from multisrt.experiments.spec import (
    EnvironmentChoice,
    ExperimentSpec,
    Only,
    StartsChoice,
)
from multisrt.geometry.numerics.arrays import FloatArray
from multisrt.presets.cells import Cells, Comparison, Family
from multisrt.presets.judging import Judged, judge
from multisrt.presets.preset import Preset
from multisrt.reporting.claims import Claim, PrintedTable, Verdict
from multisrt.spec import DriveSpec, RangeFinderSpec, StopRule
from multisrt.statistics.intervals import LEVEL, Interval, bootstrap
from multisrt.statistics.ratios import POWER, smallest_reduction

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
"""Maximum gains of greedy and minpos on closest in the paper, in percent (section V A)."""

MIN_PAIRS = 6
"""Minimum number of complete pairs of each condition for an interval of a gain."""

SOURCE = "MinPos, section V A, Figures 9 and 10"
TIME, HOME = measure_named("known_complete_s"), measure_named("makespan_s")
"""The time by which the claims are judged, and the one that is shown beside it."""

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
    "An exploration ends when one of the robots has a complete map, as in the paper (section II). "
    "The claims are judged by the time until all are done as well, and both are shown.",
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

Ratios = dict[int, float]
"""Logarithms of the ratios of two times by repetition; infinite where one of the runs failed."""


class Times:
    """The exploration times of an experiment's teams.

    Parameters
    ----------
    results : Results
        Results of the experiment, which may be incomplete.
    measure : Measure
        Which time.
    """

    def __init__(self, results: Results, measure: Measure = TIME) -> None:
        self.cells = Cells(results)
        self.measure = measure
        self._at: dict[tuple[str, str, int], Condition] = {
            (at.environment, at.strategy, at.robots): at for at in self.cells.conditions()
        }
        self.teams = sorted({robots for _, _, robots in self._at if robots > 1})
        self.places = [(world, robots) for world in WORLDS for robots in self.teams]

    def compared(self, world: str, robots: int, strategy: str, rival: str) -> Comparison:
        """Return the comparison of a strategy with a rival, in pairs of repetitions."""
        return self.cells.compared(
            f"{world}, {robots} robots",
            lower=self._at[world, strategy, robots],
            higher=self._at[world, rival, robots],
            measure=self.measure,
        )

    def ratios(self, world: str, robots: int, strategy: str, rival: str) -> Ratios:
        """Return the logarithms of the ratios of both times, without pairs of two failed runs."""
        both = self.compared(world, robots, strategy, rival)
        return {
            repetition: float(np.log(ours) - np.log(rivals))
            for repetition, ours, rivals in zip(both.repetitions, *both.pairs, strict=True)
            if np.isfinite(ours) or np.isfinite(rivals)
        }

    def over_closest(self, strategy: str) -> list[Ratios]:
        """Return the ratios of a strategy's times to those of closest, for each condition."""
        return [self.ratios(*at, strategy, CLOSEST) for at in self.places]


def gain(cells: Sequence[Ratios], level: float = LEVEL) -> Interval | None:
    """Return a gain in percent with its interval; None if a condition has too few pairs.

    The interval is a percentile bootstrap of repetitions. Those of one number are drawn together
    in all conditions, which may share their world and starts.

    Parameters
    ----------
    cells : sequence of Ratios
        Logarithms of the ratios of times, by condition. All conditions have equal weights.
    level : float, optional
        Confidence level of the interval.
    """
    finite = [complete(of) for of in cells]
    if not finite or min(map(len, finite)) < MIN_PAIRS:
        return None
    means = [float(np.mean([*of.values()])) for of in finite]
    # A pair of which a run failed has the mean of its condition.
    by_repetition = [
        float(np.mean([of.get(k, mean) for of, mean in zip(finite, means, strict=True)]))
        for k in sorted(set().union(*finite))
    ]
    return bootstrap([by_repetition], _percent, level=level, rng=0)


def complete(ratios: Ratios) -> Ratios:
    """Return the ratios of pairs in which neither run failed."""
    return {repetition: ratio for repetition, ratio in ratios.items() if np.isfinite(ratio)}


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


BothTimes = tuple[Times, Times]
"""The times by which claims are judged, and those that are shown beside them."""


def both_times(results: Results) -> BothTimes:
    """Return both times of the results of an experiment."""
    return Times(results, TIME), Times(results, HOME)


def claims(results: Results) -> list[Claim]:
    """Return the judged claims of the paper."""
    both = both_times(results)
    return [
        *(judged.claim for judged in _faster(both)),
        *(mean_gain(both, strategy) for strategy in (GREEDY, MINPOS)),
        *(largest_gain(both, world) for world in (HOSPITAL, MAZE)),
        before_greedy(both),
        *(judged.claim for judged in _others(both)),
    ]


def tables(results: Results) -> list[PrintedTable]:
    """Return our gains beside the paper's, and the comparisons behind the claims."""
    both = both_times(results)
    return [
        *(gains(times) for times in both),
        *(judged.table for judged in (*_faster(both), *_others(both))),
    ]


def _faster(both: BothTimes) -> list[Judged]:
    found = []
    for strategy in (GREEDY, MINPOS):
        judged, beside = (
            Family(
                comparisons=[times.compared(*at, strategy, CLOSEST) for at in times.places],
                quantity=times.measure,
            )
            for times in both
        )
        found.append(
            judge(
                f"{strategy} is faster than closest.",
                SOURCE,
                judged,
                scope="mostly",
                so=f"{strategy} is faster",
                otherwise="it is slower",
                sides=(strategy, CLOSEST),
                beside=beside,
            )
        )
    return found


def _others(both: BothTimes) -> list[Judged]:
    return [more_with_more_robots(both), more_in_mazes(both)]


def mean_gain(both: BothTimes, strategy: str) -> Claim:
    """Return the judged claim on the mean gain of a strategy on closest."""
    printed = MEAN_GAINS[strategy]
    found, home = (gain(times.over_closest(strategy)) for times in both)
    return Claim(
        text=f"On average {strategy} shortens the exploration by {printed:g} %, against closest.",
        source="MinPos, section V A",
        verdict=reaches(found, printed),
        grounds=(_told(found, printed), *_told_beside(home)),
        would_show=_would_show(found, reaches(found, printed)),
    )


def largest_gain(both: BothTimes, world: str) -> Claim:
    """Return the judged claim on the largest gain in a world.

    The largest of several estimates is biased upwards, so the intervals of all of them hold
    simultaneously (Bonferroni).
    """
    printed = LARGEST_GAINS[world]
    level = _at_once(2 * len(both[0].teams))
    (best, found), (_, home) = (_best(times, world, level) for times in both)
    grounds = [_told(found, printed)]
    if best:
        grounds.append(f"the largest gain is that of {best}")
    return Claim(
        text=f"In the {world} the exploration gets up to {printed:g} % shorter, against closest.",
        source="MinPos, section V A",
        verdict=reaches(found, printed),
        grounds=(*grounds, *_told_beside(home)),
        would_show=_would_show(found, reaches(found, printed), level),
    )


def _at_once(many: int) -> float:
    return 1.0 - (1.0 - LEVEL) / max(1, many)


def _best(times: Times, world: str, level: float) -> tuple[str, Interval | None]:
    """Return the strategy and team with the largest gain on closest, and that gain."""
    found = {
        f"{strategy} with {robots} robots": one
        for robots in times.teams
        for strategy in (GREEDY, MINPOS)
        if (one := gain([times.ratios(world, robots, strategy, CLOSEST)], level))
    }
    best = max(found, key=lambda at: found[at].value, default="")
    return best, found.get(best)


def before_greedy(both: BothTimes) -> Claim:
    """Return the judged claim that minpos is "slightly better" than greedy on average."""
    found, home = (
        gain([times.ratios(*at, MINPOS, GREEDY) for at in times.places]) for times in both
    )
    verdict: Verdict = "not tested"
    if found is not None:
        verdict = "holds" if found.low > 0.0 else "not significant"
        verdict = "does not hold" if found.high < 0.0 else verdict
    return Claim(
        text="On average minpos is slightly faster than greedy.",
        source="MinPos, section V A",
        verdict=verdict,
        grounds=(_told(found, None), *_told_beside(home)),
        would_show=_would_show(found, verdict),
    )


def more_with_more_robots(both: BothTimes) -> Judged:
    """Return the judged claim that the gain on closest grows with team size."""
    teams = both[0].teams
    few, many = (teams[0], teams[-1]) if len(teams) > 1 else (0, 0)
    judged, beside = (
        Family(
            comparisons=[
                _ratios_compared(
                    f"{world}, {strategy}",
                    times.ratios(world, many, strategy, CLOSEST),
                    times.ratios(world, few, strategy, CLOSEST),
                )
                for world in WORLDS
                for strategy in (GREEDY, MINPOS)
                if many
            ],
            quantity=RatioOfTimes(times.measure.title),
        )
        for times in both
    )
    return judge(
        "The larger the team, the more greedy and minpos gain on closest.",
        SOURCE,
        judged,
        scope="mostly",
        so="the gain is larger in the largest team than in the smallest",
        otherwise="it is smaller",
        sides=(f"{many} robots", f"{few} robots"),
        beside=beside,
    )


def more_in_mazes(both: BothTimes) -> Judged:
    """Return the judged claim that minpos gains more on greedy in mazes than in the hospital.

    A repetition in the maze and one in the hospital are not a pair, but each is one for all teams.
    """
    judged, beside = (
        Family(
            comparisons=[
                _ratios_compared(
                    f"{robots} robots, minpos over greedy",
                    times.ratios(MAZE, robots, MINPOS, GREEDY),
                    times.ratios(HOSPITAL, robots, MINPOS, GREEDY),
                    paired=False,
                )
                for robots in times.teams
            ],
            quantity=RatioOfTimes(times.measure.title),
            paired=False,
        )
        for times in both
    )
    return judge(
        "Minpos gains more on greedy in mazes than in the hospital.",
        SOURCE,
        judged,
        scope="mostly",
        so="it gains more in mazes",
        otherwise="less",
        sides=(MAZE, HOSPITAL),
        beside=beside,
    )


def _ratios_compared(where: str, lower: Ratios, higher: Ratios, paired: bool = True) -> Comparison:
    return Comparison(
        where=where,
        lower={repetition: float(np.exp(ratio)) for repetition, ratio in lower.items()},
        higher={repetition: float(np.exp(ratio)) for repetition, ratio in higher.items()},
        paired=paired,
    )


@dataclass(frozen=True, slots=True)
class RatioOfTimes:
    """The quantity of comparisons of gains: a ratio of two times."""

    time: str
    unit: str = ""
    digits: int = 2

    @property
    def heading(self) -> str:
        """Title, without a unit."""
        return f"{self.time}, over that of the rival"


def _told(found: Interval | None, printed: float | None) -> str:
    if found is None:
        return f"too few runs: every condition needs {MIN_PAIRS} complete pairs"
    papers = "" if printed is None else f"; the paper: {printed:g} %"
    return f"ours: {_percent_text(found)}, bootstrap of repetitions{papers}"


def _told_beside(found: Interval | None) -> list[str]:
    return [] if found is None else [f"{HOME.heading}: {_percent_text(found)}"]


def _percent_text(found: Interval) -> str:
    return f"{found.value:+.1f} % (interval {found.low:+.1f} to {found.high:+.1f})"


def _would_show(found: Interval | None, verdict: Verdict, level: float = LEVEL) -> str:
    if found is None or verdict != "not significant":
        return ""
    # A gain of g percent is a ratio of 1 - g / 100 of the times.
    value, low, high = (1.0 - 0.01 * end for end in (found.value, found.high, found.low))
    share = smallest_reduction(Interval(value, low, high), power=POWER, level=level)
    return f"a gain of {100.0 * share:.1f} % would have been detected"


# Table --------------------------------------------------------------------------------------


def gains(times: Times) -> PrintedTable:
    """Return the gains on closest in all conditions, beside the paper's mean and largest gains."""
    both = (GREEDY, MINPOS)
    rows = []
    for world, robots in times.places:
        ratios = [times.ratios(world, robots, strategy, CLOSEST) for strategy in both]
        pairs = "/".join(str(len(complete(of))) for of in ratios)
        rows.append((world, str(robots), *(_cell(gain([of])) for of in ratios), pairs))
    means = [gain(times.over_closest(strategy)) for strategy in both]
    rows.append(("mean of all", "", *map(_cell, means), ""))
    rows.append(("paper: mean", "", *(f"{MEAN_GAINS[s]:+.1f}" for s in both), ""))
    for world in WORLDS:
        text = f"{LARGEST_GAINS[world]:+.1f} by the better one"
        rows.append((f"paper: largest, {world}", "", text, text, ""))
    return PrintedTable(
        title=f"Gains on closest (percent). {times.measure.title}",
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
