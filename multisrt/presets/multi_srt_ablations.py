"""Ablations of Multi-SRT: what the differences from its paper do, and where claims fail."""

from __future__ import annotations

from typing import Literal

import msgspec

from multisrt.experiments.measures import measure_named
from multisrt.experiments.spec import Block, RadioChoice, StrategyChoice, Teams
from multisrt.presets.ablations import Ablation, Ablations, Topic, with_options
from multisrt.presets.cells import Cells
from multisrt.presets.multi_srt_claims import (
    DISTANCE,
    DISTANCE_GROWS,
    KNOWN,
    LIMITED_RADIO,
    NOT_IN_EVERY_STEP,
    RADIAL,
    STAR,
    TIME,
    UNLIMITED,
    distance_grows,
    time_does_not_always_fall,
    time_falls,
)
from multisrt.reporting.claims import Claim
from multisrt.spec import Scalar

MEASURES = (KNOWN, TIME, DISTANCE, *map(measure_named, ("nodes", "coverage")))

DIFFERENCES = Topic(title="What the differences from the paper do", measures=MEASURES)
TOTAL_DISTANCE = Topic(
    title="What the total distance depends on",
    measures=MEASURES,
    claims=tuple(DISTANCE_GROWS.values()),
)
LARGER_TEAMS = Topic(
    title="Whether larger teams take longer by the paper's planner alone, or without support",
    measures=MEASURES,
    claims=tuple(NOT_IN_EVERY_STEP.values()),
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


def beside(cells: Cells) -> dict[str, list[Claim]]:
    """Return the claims on larger teams as judged by runs with a change.

    They are those in the garden with `RADIAL` and an unlimited radio. With the paper's planner
    alone no robot knows its map complete, so that the time is that until all are done. Without
    support the distance should not grow, if support is the reason.
    """
    alone, unsupported = (_with(cells, change) for change in (PAPERS_PLANNER_ALONE, NONE_SUPPORTED))
    judged = {
        PAPERS_PLANNER_ALONE: (
            time_falls(alone, TIME),
            time_does_not_always_fall(alone, TIME),
            distance_grows(alone, UNLIMITED),
        ),
        NONE_SUPPORTED: (distance_grows(unsupported, UNLIMITED),),
    }
    return {change: [one.claim for one in of] for change, of in judged.items()}


def _with(cells: Cells, change: str) -> Cells:
    label = with_options(StrategyChoice(name=RADIAL), change, {}).label
    return cells.where(lambda at: at.strategy == label)


_LARGE: Teams = (4, 8, 16)

ABLATIONS = Ablations(
    repetitions=10,
    run_s=3.0,
    quick_repetitions=6,
    beside=beside,
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
        _ablation(DIFFERENCES, NO_TAKE_OVER, NO_SUPPORT, radio=LIMITED_RADIO),
        _ablation(DIFFERENCES, IN_CONTACT, {"support_in_contact": True}, radio=LIMITED_RADIO),
        _ablation(
            TOTAL_DISTANCE,
            NO_TAKE_OVER,
            NO_SUPPORT,
            robots=_LARGE,
            starts="scattered",
            radio=LIMITED_RADIO,
        ),
        _ablation(TOTAL_DISTANCE, NONE_SUPPORTED, NO_SUPPORT, robots=_LARGE, starts="scattered"),
        _ablation(LARGER_TEAMS, PAPERS_PLANNER_ALONE, PAPERS_PLANNER, robots=(2, *_LARGE)),
        # Sixteen scattered robots would take two minutes a run.
        _ablation(
            LARGER_TEAMS,
            PAPERS_PLANNER_ALONE,
            PAPERS_PLANNER,
            robots=(2, 4, 8),
            starts="scattered",
        ),
        _ablation(LARGER_TEAMS, NONE_SUPPORTED, NO_SUPPORT, robots=_LARGE),
        _ablation(LARGER_TEAMS, OPEN_ENTRY, ENTRY, robots=_LARGE),
    ),
)
"""The ablations of the page."""
