"""MinPos against greedy and closest in mazes and a hospital, as in section V A of its paper."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import chain

import numpy as np

from multisrt.experiments.results import Results
from multisrt.presets.cells import Comparison, Family, Quantity
from multisrt.presets.judging import Judged, judge
from multisrt.presets.minpos_ablations import ABLATIONS
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
from multisrt.presets.minpos_deviations import DEVIATIONS
from multisrt.presets.minpos_experiment import (
    CELL_M,
    CLOSEST,
    GREEDY,
    HOSPITAL,
    MAZE,
    MINPOS,
    RULES,
    STEP_S,
    WORLDS,
    experiment,
    for_hospital,
)
from multisrt.presets.minpos_gains import (
    MIN_PAIRS,
    TIME,
    TO_99,
    Ratios,
    Times,
    complete,
    gain,
    gain_text,
    largest,
    reaches,
    rule,
)
from multisrt.presets.preset import Preset
from multisrt.reporting.claims import Claim, PrintedTable, Verdict
from multisrt.statistics.intervals import LEVEL, Interval
from multisrt.statistics.ratios import POWER, smallest_reduction

# Claims -------------------------------------------------------------------------------------


BothTimes = tuple[Times, Times]
"""The times by which claims are judged, and those that are shown beside them."""


def both_times(results: Results) -> BothTimes:
    """Return both times of the results of an experiment."""
    return Times(results, TIME), Times(results, TO_99)


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
        waits(both[0]),
        *(judged.table for judged in (*_faster(both), *_others(both))),
    ]


def _faster(both: BothTimes) -> list[Judged]:
    found = []
    for strategy in (GREEDY, MINPOS):
        judged, beside = (
            _by_world(
                {
                    world: [
                        times.compared(*at, strategy, CLOSEST)
                        for at in times.places
                        if at[0] == world
                    ]
                    for world in WORLDS
                },
                times.measure,
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


def _by_world(comparisons: Mapping[str, list[Comparison]], quantity: Quantity) -> Family:
    """Return the family of all comparisons, whose parts are those in each world."""
    whole = Family(comparisons=[*chain.from_iterable(comparisons.values())], quantity=quantity)
    return replace(
        whole,
        parts={world: replace(whole, comparisons=of) for world, of in comparisons.items()},
    )


def _others(both: BothTimes) -> list[Judged]:
    return [more_with_more_robots(both), more_in_mazes(both)]


def mean_gain(both: BothTimes, strategy: str) -> Claim:
    """Return the judged claim on the mean gain of a strategy on closest, by all cells together."""
    printed = MEAN_GAINS[strategy]
    found, beside = (times.family_gain(times.places, strategy, CLOSEST) for times in both)
    return Claim(
        text=ON_AVERAGE[strategy],
        source="MinPos, section V A",
        verdict=reaches(found, printed),
        grounds=(
            *_told(found, printed),
            *_means_told(both[0], strategy, CLOSEST),
            *_told_beside(beside),
        ),
        would_show=_known_to(found) + _would_show(found),
    )


def largest_gain(both: BothTimes, world: str) -> Claim:
    """Return the judged claim on the largest gain in a world.

    The intervals of all gains hold simultaneously (Bonferroni), and the largest gain lies between
    the largest of their lower and of their upper bounds; see `largest`.
    """
    printed = LARGEST_GAINS[world]
    level = _at_once(2 * len(both[0].teams))
    gains_here, beside = (_gains_in(times, world, level) for times in both)
    if not gains_here:
        return Claim(
            text=UP_TO[world],
            source="MinPos, section V A",
            verdict="not tested",
            grounds=(TOO_FEW,),
        )
    found = largest(gains_here)
    verdict = reaches(found.gain, printed)
    # The claim fails by the largest upper bound, and otherwise needs the largest lower one.
    deciding = gains_here[found.high_at if verdict == "does not hold" else found.low_at]
    return Claim(
        text=UP_TO[world],
        source="MinPos, section V A",
        verdict=verdict,
        grounds=(
            _ours(found.gain, "the largest of simultaneous bounds by signed ranks", printed),
            f"the largest estimate is that of {found.at}, the largest lower bound that of "
            f"{found.low_at}, the largest upper bound that of {found.high_at}",
            rule(printed),
            _power_told(deciding, level),
            *_told_beside(largest(beside).gain if beside else None),
        ),
        would_show=_known_to(found.gain) + _would_show(deciding, level),
    )


def _at_once(many: int) -> float:
    return 1.0 - (1.0 - LEVEL) / max(1, many)


def _gains_in(times: Times, world: str, level: float) -> dict[str, Interval]:
    """Return the gains on closest in a world, by strategy and team; none if one has no interval."""
    found = {
        f"{strategy} with {robots} robots": times.family_gain(
            [(world, robots)], strategy, CLOSEST, level
        )
        for robots in times.teams
        for strategy in (GREEDY, MINPOS)
    }
    known = {name: of for name, of in found.items() if of is not None}
    return known if len(known) == len(found) else {}


def before_greedy(both: BothTimes) -> Claim:
    """Return the judged claim that minpos is "slightly better" than greedy on average."""
    found, beside = (times.family_gain(times.places, MINPOS, GREEDY) for times in both)
    in_worlds = {
        world: both[0].family_gain(
            [place for place in both[0].places if place[0] == world], MINPOS, GREEDY
        )
        for world in WORLDS
    }
    verdict = _any_gain(found)
    return Claim(
        text=BEFORE_GREEDY,
        source="MinPos, section V A",
        verdict=verdict,
        grounds=(
            *_told(found, None),
            *_means_told(both[0], MINPOS, GREEDY),
            *(
                f"{world}: {_percent_text(of)}, by signed ranks"
                for world, of in in_worlds.items()
                if of is not None
            ),
            *_told_beside(beside),
        ),
        would_show=_would_show(found),
        other_verdicts=tuple(
            (world, by_world)
            for world, of in in_worlds.items()
            if (by_world := _any_gain(of)) != verdict
        ),
    )


def _any_gain(found: Interval | None) -> Verdict:
    if found is None:
        return "not tested"
    if found.low > 0.0:
        return "holds"
    return "does not hold" if found.high < 0.0 else "inconclusive"


def more_with_more_robots(both: BothTimes) -> Judged:
    """Return the judged claim that the gain on closest grows with team size.

    In each repetition it is the slope over all team sizes by which the ratio of times falls.
    """
    judged, beside = (
        _by_world(
            {
                world: [_slopes_compared(times, world, strategy) for strategy in (GREEDY, MINPOS)]
                for world in WORLDS
            },
            RatioOfTimes(f"{times.measure.title}, over that of closest: factor"),
        )
        for times in both
    )
    return judge(
        MORE_WITH_MORE_ROBOTS,
        SOURCE,
        judged,
        scope="mostly",
        so="the gain grows with the team",
        otherwise="it shrinks",
        sides=("with each doubling of the team", "no change"),
        beside=beside,
    )


def _slopes_compared(times: Times, world: str, strategy: str) -> Comparison:
    slopes = times.slopes(world, strategy, CLOSEST)
    return _ratios_compared(f"{world}, {strategy}", slopes, dict.fromkeys(slopes, 0.0))


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
            quantity=RatioOfTimes(f"{times.measure.title}, over that of greedy"),
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

    heading: str
    unit: str = ""
    digits: int = 2


TOO_FEW = f"too few runs: every condition needs {MIN_PAIRS} pairs"


def _told(found: Interval | None, printed: float | None) -> list[str]:
    if found is None:
        return [TOO_FEW]
    rules = [] if printed is None else [rule(printed)]
    ours = _ours(found, "by signed ranks of all cells together", printed)
    return [ours, *rules, _power_told(found, LEVEL)]


def _ours(found: Interval, how: str, printed: float | None) -> str:
    papers = "" if printed is None else f"; the paper: {printed:g} %"
    return f"ours: {_percent_text(found)}, {how}{papers}"


def _power_told(found: Interval, level: float) -> str:
    share = _detectable(found, level)
    if share >= 1.0:
        return "with this spread no gain, however large, would have been detected"
    return (
        f"of experiments with this spread, {100.0 * POWER:.0f} % would find a true gain of "
        f"{100.0 * share:.1f} %"
    )


def _means_told(times: Times, strategy: str, rival: str) -> list[str]:
    geometric = gain(times.over(strategy, rival))
    plain = times.gain_of_means(strategy, rival)
    if geometric is None or plain is None:
        return []
    return [
        f"by geometric means of ratios, without failed runs: {_percent_text(geometric)}",
        f"by ratios of mean times, averaged over conditions, without failed runs: {plain:+.1f} %; "
        "which mean the paper prints is open",
    ]


def _told_beside(found: Interval | None) -> list[str]:
    return [] if found is None else [f"{TO_99.heading}: {_percent_text(found)}"]


def _percent_text(found: Interval) -> str:
    return f"{found.value:+.1f} % (interval {found.low:+.1f} to {found.high:+.1f})"


def _detectable(found: Interval, level: float) -> float:
    # A gain of g percent is a ratio of 1 - g / 100 of the times.
    value, low, high = (1.0 - 0.01 * end for end in (found.value, found.high, found.low))
    return smallest_reduction(Interval(value, low, high), power=POWER, level=level)


def _known_to(found: Interval | None) -> str:
    if found is None:
        return ""
    half = 0.5 * (found.high - found.low)
    return f"known to ±{half:.1f} points; " if np.isfinite(half) else "without bound; "


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
    means = [gain(times.over(strategy, CLOSEST)) for strategy in both]
    rows.append(("mean of all", "", *map(gain_text, means), ""))
    plain = [times.gain_of_means(strategy, CLOSEST) for strategy in both]
    texts = ["-" if found is None else f"{found:+.1f}" for found in plain]
    rows.append(("mean of all, by ratios of mean times", "", *texts, ""))
    rows.append(("paper: mean", "", *(f"{MEAN_GAINS[s]:+.1f}" for s in both), ""))
    for world in WORLDS:
        text = f"{LARGEST_GAINS[world]:+.1f} by the better one"
        rows.append((f"paper: largest, {world}", "", text, text, ""))
    return PrintedTable(
        title=f"Gains on closest (percent). {times.measure.title}",
        source=SOURCE,
        columns=("world", "robots", *both, "pairs"),
        rows=tuple(rows),
        note="By geometric means of ratios, with 95 % intervals, over repetitions in which both "
        "runs are complete. Which mean the paper prints is open.",
    )


def times_table(times: Times) -> PrintedTable:
    """Return the exploration times of all conditions, in seconds and in steps."""
    rows = []
    for world, robots in times.places:
        row = [world, str(robots)]
        for strategy in RULES:
            values = times.values(world, robots, strategy)
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


def waits(times: Times) -> PrintedTable:
    """Return the share of the robots' time in which they stood still, in all conditions."""
    return PrintedTable(
        title="Share of robots' time in which they stood still (percent)",
        source="",
        columns=("world", "robots", *RULES),
        rows=tuple(
            (world, str(robots), *(times.waiting(world, robots, one) for one in RULES))
            for world, robots in times.places
        ),
        note="Of the time until all are done, all robots and runs together: while others passed, "
        "or without a frontier to go to. Where closest stands more than the others, a part of "
        "their gains may be that robots which spread are less in each other's way.",
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
