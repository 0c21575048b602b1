"""Ablations of Multi-SRT: what the differences from its paper do, and where claims fail."""

from __future__ import annotations

from typing import Literal

import msgspec

from multisrt.experiments.measures import measure_named
from multisrt.experiments.spec import Block, RadioChoice, StrategyChoice, Teams
from multisrt.presets.ablations import Ablation, Ablations
from multisrt.spec import Scalar

STAR, RADIAL = "srt-star", "srt-radial"
RADIO_RANGE_M = 15.0

MEASURES = tuple(
    map(
        measure_named,
        ("known_complete_s", "makespan_s", "total_distance_m", "nodes", "coverage"),
    )
)

DIFFERENCES = "What the differences from the paper do"
DISTANCE = "Why the total distance does not grow with every team"
CLUSTERED = "Why larger clustered teams know the map complete no later"

CLUSTER: Teams = (8,)
LIMITED = RadioChoice(range_m=RADIO_RANGE_M, label=f"{RADIO_RANGE_M:g} m")
"""The limited radio of the experiment."""

PAPERS_PLANNER: dict[str, Scalar] = {"approach": False, "complete": False}
"""Without the two stages of planning that are not the paper's."""

NO_SUPPORT: dict[str, Scalar] = {"support": False}
"""Without support of other trees; with the limited radio this is the take-over of theirs."""


def _ablation(
    topic: str,
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
    named = StrategyChoice(name=strategy, label=f"{strategy}, {change}", options=options)
    return Ablation(
        topic=topic,
        change=change,
        base=base,
        changed=msgspec.structs.replace(base, strategies=(named,)),
        measures=MEASURES,
    )


_LARGE: Teams = (4, 8, 16)

ABLATIONS = Ablations(
    repetitions=10,
    quick_repetitions=6,
    changes=(
        _ablation(DIFFERENCES, "the paper's planner alone", PAPERS_PLANNER, robots=(1, 8)),
        _ablation(DIFFERENCES, "d_min of two bodies", {"d_min_m": 1.0}),
        _ablation(DIFFERENCES, "d_min of four bodies", {"d_min_m": 2.0}),
        _ablation(DIFFERENCES, "gaps are no frontier", {"gaps_count": False}),
        _ablation(
            DIFFERENCES,
            "cuts are obstacles",
            {"contact_tolerance_m": 4.0},
            strategy=STAR,
        ),
        _ablation(DIFFERENCES, "back to the nearest open node", {"backtrack": "nearest_open"}),
        _ablation(DIFFERENCES, "no support", NO_SUPPORT),
        _ablation(DIFFERENCES, "no take-over", NO_SUPPORT, radio=LIMITED),
        _ablation(
            DISTANCE,
            "no take-over",
            NO_SUPPORT,
            robots=_LARGE,
            starts="scattered",
            radio=LIMITED,
        ),
        _ablation(DISTANCE, "no support", NO_SUPPORT, robots=_LARGE, starts="scattered"),
        _ablation(CLUSTERED, "the paper's planner alone", PAPERS_PLANNER, robots=_LARGE),
        _ablation(CLUSTERED, "no support", NO_SUPPORT, robots=_LARGE),
    ),
)
"""The ablations of the page."""
