"""Ablations of SBX-R: settings that are changed one at a time, and strategies under each."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from types import MappingProxyType
from typing import Final

from multisrt.experiments.measures import measure_named
from multisrt.experiments.spec import Block, RadioChoice, StrategyChoice
from multisrt.presets.ablations import Ablation, Ablations, Topic, with_options
from multisrt.presets.sbx_r_claims import claims_about
from multisrt.presets.sbx_r_settings import STRATEGIES
from multisrt.presets.sbx_r_tables import CLOSEST, OTHERS, SBX_R, UTILITY, radio_label
from multisrt.spec import Scalar

ROBOTS, RADIO_M = 3, 15
"""Team size and radio (m) of most ablations."""

MEASURES = tuple(
    map(
        measure_named,
        ("isolated_total_s", "isolated_longest_s", "known_complete_s", "total_distance_m"),
    )
)

Options = Mapping[str, Scalar]

FORGETS = "forgets after 15 s"
NO_SIGNALS = "no stop signals"
WIDER = "twice the radius of cohesion"
NOTHING_LEFT = "chooses when nothing is left"
TO_THE_CELL = "to the cell, march"
FOLLOWS_PATH = "follows its path"
FAR_OVERLAP = "areas overlap up to two ranges"
LARGE_BETA = "beta of 10"
IN_PLACE_OF: Final = MappingProxyType(
    {other: f"self-bidding in the place of {other}" for other in OTHERS}
)

EQUAL_CHANGES: Final[dict[str, Options]] = {
    NOTHING_LEFT: {"replan": "target"},
    TO_THE_CELL: {"reached": "cell", "paths": "march"},
    FOLLOWS_PATH: {"drive": "path"},
}
"""Changes of the settings that all strategies share."""

OWN_CHANGES: Final[Mapping[str, dict[str, Options]]] = MappingProxyType(
    {
        SBX_R: {
            FORGETS: {"lost_after_s": 15.0},
            WIDER: {"phi_factor": 1.8},
            NO_SIGNALS: {"stop_signals": False},
        },
        CLOSEST: {},
        UTILITY: {FAR_OVERLAP: {"overlap_ranges": 2.0}, LARGE_BETA: {"beta": 10.0}},
    }
)
"""Changes of one strategy alone."""

CHOICES: Final = MappingProxyType({choice.name: choice for choice in STRATEGIES})


def _ablation(
    subject: str,
    change: str,
    base: StrategyChoice,
    changed: StrategyChoice,
    *,
    against: Collection[str] = OTHERS,
    robots: int = ROBOTS,
    radio_m: int = RADIO_M,
) -> Ablation:
    """Return the ablation of one condition.

    Parameters
    ----------
    subject, change : str
        Begin of the title of its table, and its row there.
    base, changed : StrategyChoice
        The two sides.
    against : collection of str
        It asks about claims on self-bidding against these, where they refer to the condition.
    robots, radio_m : int
        Team size, and range of the radio in metres.
    """

    def block(choice: StrategyChoice) -> Block:
        radio = RadioChoice(range_m=float(radio_m), label=radio_label(radio_m))
        return Block(strategies=(choice,), robots=(robots,), radios=(radio,))

    topic = Topic(
        title=f"{subject}: {robots} robots, {radio_label(radio_m)} radio",
        measures=MEASURES,
        claims=claims_about(against, radio_m, robots),
    )
    return Ablation(
        topic=topic,
        change=change,
        base=block(base),
        changed=block(changed),
        is_quick=(robots, radio_m) == (ROBOTS, RADIO_M) and change != WIDER,
    )


def _settings(strategy: str, changes: Mapping[str, Options]) -> Iterator[Ablation]:
    """Yield the ablations that change a setting of a strategy."""
    choice = CHOICES[strategy]
    for change, options in changes.items():
        yield _ablation(
            f"What settings of {strategy} change",
            change,
            choice,
            with_options(choice, change, options),
            against=OTHERS if strategy == SBX_R else (strategy,),
        )


def _in_place_of(other: str) -> Iterator[Ablation]:
    """Yield self-bidding in the place of another strategy, without and with each changed setting.

    They need no runs of their own.
    """
    ours, theirs = CHOICES[SBX_R], CHOICES[other]
    sides = [(theirs, ours)]
    for change, options in EQUAL_CHANGES.items():
        sides.append((with_options(theirs, change, options), with_options(ours, change, options)))
    for change, options in OWN_CHANGES[other].items():
        sides.append((with_options(theirs, change, options), ours))
    for base, changed in sides:
        yield _ablation(
            f"Self-bidding in the place of {other}, with changed settings",
            IN_PLACE_OF[other],
            base,
            changed,
            against=(other,),
        )


def _on_paths(others: Collection[str], *, robots: int, radio_m: int) -> Iterator[Ablation]:
    """Yield ablations of another condition, where all strategies follow their paths.

    That takes about half of the computing time. They ask whether a claim on the condition fails
    because of the nearness diagram, and whether it is cohesion that decides.
    """
    ours, *theirs = (
        with_options(CHOICES[name], FOLLOWS_PATH, EQUAL_CHANGES[FOLLOWS_PATH])
        for name in (SBX_R, *others)
    )
    wider = with_options(ours, WIDER, OWN_CHANGES[SBX_R][WIDER])
    for change, base, changed in (
        *((IN_PLACE_OF[choice.name], choice, ours) for choice in theirs),
        (WIDER, ours, wider),
    ):
        yield _ablation(
            "Where all follow their paths",
            change,
            base,
            changed,
            against=others,
            robots=robots,
            radio_m=radio_m,
        )


def _where_it_takes_longer(other: str, *, robots: int, radio_m: int) -> Iterator[Ablation]:
    """Yield ablations of a condition where self-bidding takes longer than another strategy.

    They ask whether cohesion, absent robots or the nearness diagram is the reason.
    """
    ours, theirs = CHOICES[SBX_R], CHOICES[other]
    sides = [(IN_PLACE_OF[other], theirs, ours)]
    for change in (WIDER, FORGETS):
        changed = with_options(ours, change, OWN_CHANGES[SBX_R][change])
        sides.append((f"{IN_PLACE_OF[other]}, {change}", theirs, changed))
    base, changed = (
        with_options(choice, FOLLOWS_PATH, EQUAL_CHANGES[FOLLOWS_PATH]) for choice in (theirs, ours)
    )
    sides.append((IN_PLACE_OF[other], base, changed))
    for change, base, changed in sides:
        yield _ablation(
            f"Where self-bidding takes longer than {other}",
            change,
            base,
            changed,
            against=(other,),
            robots=robots,
            radio_m=radio_m,
        )


ABLATIONS = Ablations(
    repetitions=15,
    run_s=6.0,
    quick_repetitions=6,
    changes=(
        *_settings(SBX_R, OWN_CHANGES[SBX_R] | EQUAL_CHANGES),
        *_settings(CLOSEST, EQUAL_CHANGES),
        *_settings(UTILITY, EQUAL_CHANGES | OWN_CHANGES[UTILITY]),
        *(one for other in OTHERS for one in _in_place_of(other)),
        *_on_paths(OTHERS, robots=3, radio_m=30),
        *_on_paths((CLOSEST,), robots=2, radio_m=15),
        *_on_paths(OTHERS, robots=2, radio_m=20),
        *_on_paths((UTILITY,), robots=5, radio_m=15),
        *_where_it_takes_longer(UTILITY, robots=3, radio_m=20),
        *_where_it_takes_longer(UTILITY, robots=4, radio_m=20),
    ),
)
"""The ablations of the page."""
