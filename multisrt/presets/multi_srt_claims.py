"""The claims in section 3 of the Multi-SRT paper that compare times or distances."""

from __future__ import annotations

from collections import defaultdict
from itertools import pairwise
from typing import Final

from multisrt.experiments.crossing import Condition
from multisrt.experiments.measures import Measure, measure_named
from multisrt.experiments.spec import RadioChoice
from multisrt.presets.cells import Cells, Family
from multisrt.presets.judging import Judged, judge

STAR, RADIAL = "srt-star", "srt-radial"

RADIO_RANGE_M = 15.0
UNLIMITED: Final = "unlimited"
LIMITED = f"{RADIO_RANGE_M:g} m"
"""Names of the radios of the experiment."""

LIMITED_RADIO = RadioChoice(range_m=RADIO_RANGE_M, label=LIMITED)

TIME, KNOWN = measure_named("makespan_s"), measure_named("known_complete_s")
"""The times by which claims are judged: one or the other is the paper's exploration time."""

TIMES = {TIME: "until all are done", KNOWN: "until one robot's map is complete"}
"""Both of them, as claims name them."""

DISTANCE = measure_named("total_distance_m")

SOURCE = "Multi-SRT, section 3 (simulation results), Figure 7"

TIME_FALLS = {
    time: f"With scattered starts the time {until} falls as the team grows."
    for time, until in TIMES.items()
}
NOT_IN_EVERY_STEP = {
    time: f"With clustered starts there is a step in team size at which the time {until} rises."
    for time, until in TIMES.items()
}
DISTANCE_GROWS = {
    UNLIMITED: "With an unlimited radio the total distance grows with the number of robots.",
    LIMITED: f"With a radio range of {LIMITED} the total distance grows with the number of "
    "robots as well.",
}
"""By radio: the paper names none, and its reason exists with the unlimited one only."""

WHY_DISTANCE_GROWS = {
    UNLIMITED: "'because more robots try to support the others', which by section 2 is 'only used "
    "when an unlimited communication range is handled'",
    LIMITED: "if its sentence on the distance is meant for both radios; the reason that it "
    "gives, support, exists with the unlimited one only",
}
"""What the source of these claims says of the radio."""


def compared(cells: Cells) -> list[Judged]:
    """Return the judged claims, in the order of the page."""
    return [
        *(time_falls(cells, time) for time in TIMES),
        *(time_does_not_always_fall(cells, time) for time in TIMES),
        *(distance_grows(cells, radio) for radio in DISTANCE_GROWS),
        *(radial_is_better(cells, measure) for measure in (*TIMES, DISTANCE)),
    ]


def time_falls(cells: Cells, time: Measure) -> Judged:
    """Return the judged claim on scattered starts, by neighbouring team sizes."""
    return judge(
        TIME_FALLS[time],
        SOURCE,
        _growing(cells, time, ("scattered",), larger_is_lower=True),
        scope="always",
        so="it falls",
        otherwise="it rises",
        sides=("larger team", "smaller team"),
    )


def time_does_not_always_fall(cells: Cells, time: Measure) -> Judged:
    """Return the judged claim that with clustered starts the time does not fall in every step.

    It holds if there is a step in which the time rises significantly, and does not hold if the
    time falls significantly in every step.
    """
    return judge(
        NOT_IN_EVERY_STEP[time],
        f"{SOURCE} ('in the case of the clustered start, there are examples where this affirmation "
        "is not verified')",
        _growing(cells, time, ("clustered",)),
        scope="somewhere",
        so="the time rises",
        otherwise="it falls",
        sides=("smaller team", "larger team"),
    )


def distance_grows(cells: Cells, radio: str) -> Judged:
    """Return the judged claim on the total distance with a radio, by neighbouring team sizes."""
    with_radio = cells.where(lambda at: at.robots == 1 or at.radio == radio)
    return judge(
        DISTANCE_GROWS[radio],
        f"{SOURCE} ({WHY_DISTANCE_GROWS[radio]})",
        _growing(with_radio, DISTANCE, ("scattered", "clustered")),
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
    """Return the comparisons of neighbouring team sizes.

    With several kinds of starts each is a part, without and with the step from a single robot.
    """
    comparisons, parts = [], defaultdict(list)
    for how in starts:
        for small, large in _steps(cells, how):
            step = cells.compared(
                (f"{how}: " if len(starts) > 1 else "") + _step(small, large),
                lower=large if larger_is_lower else small,
                higher=small if larger_is_lower else large,
                measure=measure,
            )
            comparisons.append(step)
            size = f"1 to {large.robots} robots" if small.robots == 1 else "larger teams"
            parts[f"{how} starts, {size}"].append(step)
    return Family(
        comparisons=comparisons,
        quantity=measure,
        parts={
            name: Family(comparisons=steps, quantity=measure)
            for name, steps in parts.items()
            if len(starts) > 1
        },
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
