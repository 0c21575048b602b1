"""MinPos against greedy and closest in mazes and a hospital, as in section V A of its paper."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from multisrt.experiments.results import Results
from multisrt.presets.cells import Comparison, Family
from multisrt.presets.judging import Judged, judge
from multisrt.presets.minpos_ablations import ABLATIONS, APART, TARGETS, WIDE
from multisrt.presets.minpos_claims import (
    BEFORE_GREEDY,
    FASTER,
    LARGEST_GAINS,
    MEAN_GAINS,
    MORE_IN_MAZES,
    MORE_WITH_MORE_ROBOTS,
    ON_AVERAGE,
    SOURCE,
    UP_TO,
)
from multisrt.presets.minpos_experiment import (
    BODY,
    CELL_M,
    CLOSEST,
    GREEDY,
    HOSPITAL,
    MAZE,
    MAZE_CELLS,
    MAZE_M,
    MINPOS,
    RANGE_M,
    RULES,
    SCAN_STEPS,
    SPEED_M_S,
    STEP_S,
    WORLDS,
    experiment,
    for_hospital,
)
from multisrt.presets.minpos_gains import (
    HOME,
    MIN_PAIRS,
    TIME,
    Ratios,
    Times,
    complete,
    gain,
    gain_text,
    reaches,
)
from multisrt.presets.preset import WORLD, Deviation, Preset
from multisrt.reporting.claims import Claim, PrintedTable, Verdict
from multisrt.statistics.intervals import LEVEL, Interval
from multisrt.statistics.ratios import POWER, smallest_reduction

DEVIATIONS = (
    Deviation(
        f"Mazes: perfect mazes of {MAZE_M:g} x {MAZE_M:g} m with {MAZE_CELLS} x {MAZE_CELLS} "
        "cells, one for each repetition. The paper's are not available."
    ),
    Deviation(
        f"{WORLD} a generated hospital of 143.6 x 60 m. That of the paper is one of Player/Stage, "
        "140 x 60 m; `--map` takes that file, or another one, in its place."
    ),
    Deviation(
        f"Robots: discs of 0.4 m ({BODY}) that drive in any direction, on cells of {CELL_M:g} m; "
        "in the paper they are as wide as a cell, which would close some doors here. "
        f"{SPEED_M_S:g} m/s, so that a step from cell to cell takes {STEP_S:g} s; range finders "
        f"{RANGE_M:g} m, exact; a radio of unlimited range. The paper gives no range."
    ),
    Deviation(
        "Robots obstruct each other where two cannot pass: bodies have a size, and robots give "
        "way. Doors and corridors have room for two. The paper does not say whether its simulated "
        "robots obstruct each other.",
        (WIDE,),
    ),
    Deviation(
        "Starts: close together, as in the paper (section II), which does not say where. Here the "
        "configuration of the first robot is drawn in each repetition and the others stand around "
        "it. All strategies have the same starts and worlds.",
        (APART,),
    ),
    Deviation(
        "The paper gives neither team sizes nor the number of runs in its text, and times as "
        "curves only: there are no printed figures for single team sizes."
    ),
    Deviation(
        f"All strategies take a scan every fourth step ({SCAN_STEPS * STEP_S:g} s, "
        f"{SCAN_STEPS * CELL_M:g} m), and choose again if it shows news. In the paper time is "
        "discrete, and robots sense and choose at steps.",
        (TARGETS,),
    ),
    Deviation(
        "An exploration ends when one of the robots has a complete map, as in the paper (section "
        "II). The claims are judged by the time until all are done as well, and both are shown."
    ),
)


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
        times_table(both[0]),
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
                FASTER[strategy],
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
    """Return the judged claim on the mean gain of a strategy on closest, by all cells together."""
    printed = MEAN_GAINS[strategy]
    found, home = (times.family_gain(times.places, strategy, CLOSEST) for times in both)
    means = gain(both[0].over_closest(strategy))
    return Claim(
        text=ON_AVERAGE[strategy],
        source="MinPos, section V A",
        verdict=reaches(found, printed),
        grounds=(*_told(found, printed), *_mean_told(means), *_told_beside(home)),
        would_show=_would_show(found),
    )


def largest_gain(both: BothTimes, world: str) -> Claim:
    """Return the judged claim on the largest gain in a world.

    The largest of several estimates is biased upwards, so the intervals of all of them hold
    simultaneously (Bonferroni).
    """
    printed = LARGEST_GAINS[world]
    level = _at_once(2 * len(both[0].teams))
    (best, found), (_, home) = (_best(times, world, level) for times in both)
    grounds = _told(found, printed, level, "pairs of one cell")
    if best:
        grounds.append(f"the largest gain is that of {best}")
    return Claim(
        text=UP_TO[world],
        source="MinPos, section V A",
        verdict=reaches(found, printed),
        grounds=(*grounds, *_told_beside(home)),
        would_show=_would_show(found, level),
    )


def _at_once(many: int) -> float:
    return 1.0 - (1.0 - LEVEL) / max(1, many)


def _best(times: Times, world: str, level: float) -> tuple[str, Interval | None]:
    """Return the strategy and team with the largest gain on closest, and that gain."""
    found = {
        f"{strategy} with {robots} robots": one
        for robots in times.teams
        for strategy in (GREEDY, MINPOS)
        if (one := times.family_gain([(world, robots)], strategy, CLOSEST, level))
    }
    best = max(found, key=lambda at: found[at].value, default="")
    return best, found.get(best)


def before_greedy(both: BothTimes) -> Claim:
    """Return the judged claim that minpos is "slightly better" than greedy on average."""
    found, home = (times.family_gain(times.places, MINPOS, GREEDY) for times in both)
    means = gain([both[0].ratios(*at, MINPOS, GREEDY) for at in both[0].places])
    verdict: Verdict = "not tested"
    if found is not None:
        verdict = "holds" if found.low > 0.0 else "not significant"
        verdict = "does not hold" if found.high < 0.0 else verdict
    return Claim(
        text=BEFORE_GREEDY,
        source="MinPos, section V A",
        verdict=verdict,
        grounds=(*_told(found, None), *_mean_told(means), *_told_beside(home)),
        would_show=_would_show(found),
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
        MORE_WITH_MORE_ROBOTS,
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
        MORE_IN_MAZES,
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


def _told(
    found: Interval | None,
    printed: float | None,
    level: float = LEVEL,
    what: str = "all cells together",
) -> list[str]:
    if found is None:
        return [f"too few runs: every condition needs {MIN_PAIRS} pairs"]
    papers = "" if printed is None else f"; the paper: {printed:g} %"
    told = [f"ours: {_percent_text(found)}, by signed ranks of {what}{papers}"]
    share = _detectable(found, level)
    if share < 1.0:
        told.append(
            f"of experiments with this spread, {100.0 * POWER:.0f} % would find a true gain of "
            f"{100.0 * share:.1f} %"
        )
    else:
        told.append("with this spread no gain, however large, would have been detected")
    return told


def _mean_told(found: Interval | None) -> list[str]:
    if found is None:
        return []
    return [f"by geometric means of ratios, without failed runs: {_percent_text(found)}"]


def _told_beside(found: Interval | None) -> list[str]:
    return [] if found is None else [f"{HOME.heading}: {_percent_text(found)}"]


def _percent_text(found: Interval) -> str:
    return f"{found.value:+.1f} % (interval {found.low:+.1f} to {found.high:+.1f})"


def _detectable(found: Interval, level: float) -> float:
    # A gain of g percent is a ratio of 1 - g / 100 of the times.
    value, low, high = (1.0 - 0.01 * end for end in (found.value, found.high, found.low))
    return smallest_reduction(Interval(value, low, high), power=POWER, level=level)


def _would_show(found: Interval | None, level: float = LEVEL) -> str:
    if found is None:
        return ""
    if _detectable(found, level) >= 1.0:
        return "no gain would have been detected in these runs"
    return f"a gain of {100.0 * _detectable(found, level):.1f} % would have been detected"


# Tables -------------------------------------------------------------------------------------


def gains(times: Times) -> PrintedTable:
    """Return the gains on closest in all conditions, beside the paper's mean and largest gains."""
    both = (GREEDY, MINPOS)
    rows = []
    for world, robots in times.places:
        ratios = [times.ratios(world, robots, strategy, CLOSEST) for strategy in both]
        pairs = "/".join(str(len(complete(of))) for of in ratios)
        rows.append((world, str(robots), *(gain_text(gain([of])) for of in ratios), pairs))
    means = [gain(times.over_closest(strategy)) for strategy in both]
    rows.append(("mean of all", "", *map(gain_text, means), ""))
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


def times_table(times: Times) -> PrintedTable:
    """Return the exploration times of all conditions, in seconds and in steps."""
    rows = []
    for world, robots in times.places:
        row = [world, str(robots)]
        for rule in RULES:
            values = times.values(world, robots, rule)
            middle = float(np.median(values)) if values else np.nan
            row.append(f"{middle:.0f} s, {middle / STEP_S:.0f} steps" if values else "-")
        rows.append(tuple(row))
    return PrintedTable(
        title=f"{times.measure.title}, in seconds and in steps",
        source="MinPos, Figures 9 and 10 (curves only)",
        columns=("world", "robots", *RULES),
        rows=tuple(rows),
        note=f"Medians of complete runs. A step is a cell of {CELL_M:g} m, {STEP_S:g} s.",
    )


MINPOS_PRESET = Preset(
    name="minpos",
    about="MinPos, greedy and the closest frontier in mazes and a hospital, by team size",
    paper="A. Bautin, O. Simonin and F. Charpillet, Towards a communication free coordination for "
    "multi-robot exploration",
    experiment=experiment,
    claims=claims,
    tables=tables,
    deviations=DEVIATIONS,
    run_s=11.5,
    quick_run_s=6.0,
    on_map=for_hospital,
    ablations=ABLATIONS,
)
