"""Ablations of Multi-SRT: what the differences from its paper do, and where claims fail."""

from __future__ import annotations

from typing import Literal

import msgspec

from multisrt.experiments.measures import measure_named
from multisrt.experiments.spec import Block, RadioChoice, StrategyChoice, Teams
from multisrt.presets.ablations import Ablation, Ablations, Topic, with_options
from multisrt.spec import Scalar

STAR, RADIAL = "srt-star", "srt-radial"
RADIO_RANGE_M = 15.0

TIME, KNOWN = measure_named("makespan_s"), measure_named("known_complete_s")
"""The times by which claims are judged: one or the other is the paper's exploration time."""

TIMES = {TIME: "until all are home", KNOWN: "until a robot knows the map complete"}
"""Both of them, as claims name them."""

DISTANCE_GROWS = "The total distance grows with the number of robots."
TAKES_LONGER = {
    time: f"With clustered starts there are teams in which more robots take longer {until}."
    for time, until in TIMES.items()
}

MEASURES = (
    KNOWN,
    TIME,
    *map(measure_named, ("total_distance_m", "nodes", "coverage")),
)

DIFFERENCES = Topic(title="What the differences from the paper do", measures=MEASURES)
DISTANCE = Topic(
    title="Why the total distance does not grow with every team",
    measures=MEASURES,
    claims=(DISTANCE_GROWS,),
)
CLUSTERED = Topic(
    title="Why larger clustered teams know the map complete no later",
    measures=MEASURES,
    claims=tuple(TAKES_LONGER.values()),
)

PAPERS_PLANNER_ALONE = "the paper's planner alone"
TWO_BODIES, FOUR_BODIES = "d_min of two bodies", "d_min of four bodies"
NO_GAPS = "gaps are no frontier"
NO_CUTS = "cuts are obstacles"
NEAREST_OPEN = "back to the nearest open node"
NONE_SUPPORTED, NO_TAKE_OVER = "no support", "no take-over"
OPEN_ENTRY = "support begins at the nearest open node"
IN_CONTACT = "support of robots in contact"
PLANNER_TELLS = "the paper's planner alone, robots tell of nodes without a place"

CLUSTER: Teams = (8,)
LIMITED = RadioChoice(range_m=RADIO_RANGE_M, label=f"{RADIO_RANGE_M:g} m")
"""The limited radio of the experiment."""

PAPERS_PLANNER: dict[str, Scalar] = {"approach": False, "complete": False}
"""Without the two stages of planning that are not the paper's."""

NO_SUPPORT: dict[str, Scalar] = {"support": False}
"""Without support of other trees; with the limited radio this is the take-over of theirs."""

ENTRY: dict[str, Scalar] = {"entry": "nearest_open"}
"""Support from the nearest open node of a tree instead of its root."""


def _ablation(
    topic: Topic,
    change: str,
    options: dict[str, Scalar],
    *,
    strategy: str = RADIAL,
    robots: Teams = CLUSTER,
    starts: Literal["clustered", "scattered"] = "clustered",
    radio: Literal["unlimited"] | RadioChoice = "unlimited",
) -> Ablation:
    """Return an ablation in the garden, by options of a strategy."""
    base = Block(
        environments=("garden",),
        strategies=(strategy,),
        robots=robots,
        starts=(starts,),
        radios=(radio,),
    )
    named = with_options(StrategyChoice(name=strategy), change, options)
    return Ablation(
        topic=topic,
        change=change,
        base=base,
        changed=msgspec.structs.replace(base, strategies=(named,)),
    )


_LARGE: Teams = (4, 8, 16)

ABLATIONS = Ablations(
    repetitions=10,
    run_s=3.0,
    quick_repetitions=6,
    changes=(
        _ablation(DIFFERENCES, PAPERS_PLANNER_ALONE, PAPERS_PLANNER, robots=(1, 8)),
        _ablation(DIFFERENCES, PLANNER_TELLS, {**PAPERS_PLANNER, "no_place_after": 3}),
        _ablation(DIFFERENCES, TWO_BODIES, {"d_min_m": 1.0}),
        _ablation(DIFFERENCES, FOUR_BODIES, {"d_min_m": 2.0}),
        _ablation(DIFFERENCES, NO_GAPS, {"gaps_count": False}),
        _ablation(
            DIFFERENCES,
            NO_CUTS,
            {"contact_tolerance_m": 4.0},
            strategy=STAR,
        ),
        _ablation(DIFFERENCES, NEAREST_OPEN, {"backtrack": "nearest_open"}),
        _ablation(DIFFERENCES, OPEN_ENTRY, ENTRY),
        _ablation(DIFFERENCES, NONE_SUPPORTED, NO_SUPPORT),
        _ablation(DIFFERENCES, NO_TAKE_OVER, NO_SUPPORT, radio=LIMITED),
        _ablation(DIFFERENCES, IN_CONTACT, {"support_in_contact": True}, radio=LIMITED),
        _ablation(
            DISTANCE,
            NO_TAKE_OVER,
            NO_SUPPORT,
            robots=_LARGE,
            starts="scattered",
            radio=LIMITED,
        ),
        _ablation(DISTANCE, NONE_SUPPORTED, NO_SUPPORT, robots=_LARGE, starts="scattered"),
        _ablation(CLUSTERED, PAPERS_PLANNER_ALONE, PAPERS_PLANNER, robots=_LARGE),
        _ablation(CLUSTERED, NONE_SUPPORTED, NO_SUPPORT, robots=_LARGE),
        _ablation(CLUSTERED, OPEN_ENTRY, ENTRY, robots=_LARGE),
    ),
)
"""The ablations of the page."""
