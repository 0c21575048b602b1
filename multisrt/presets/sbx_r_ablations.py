"""Ablations of SBX-R: settings of a strategy that are changed one at a time."""

from __future__ import annotations

import msgspec

from multisrt.experiments.measures import measure_named
from multisrt.experiments.spec import Block, RadioChoice
from multisrt.presets.ablations import Ablation, Ablations, Topic, with_options
from multisrt.presets.sbx_r_claims import CLAIMS
from multisrt.presets.sbx_r_settings import STRATEGIES
from multisrt.presets.sbx_r_tables import CLOSEST, SBX_R, UTILITY, radio_label
from multisrt.spec import Scalar

ROBOTS = 3
MEASURES = tuple(
    map(
        measure_named,
        ("isolated_total_s", "isolated_longest_s", "known_complete_s", "total_distance_m"),
    )
)

SETTINGS = Topic(
    title="What single settings change",
    measures=MEASURES,
    claims=tuple(claim.text for claim in CLAIMS),
)

FORGETS = "forgets after 15 s"
NO_SIGNALS = "no stop signals"
WIDER = "twice the radius of cohesion"
NOTHING_LEFT = "chooses when nothing is left"
TO_THE_CELL = "to the cell, march"


def _ablation(
    change: str, strategy: str = SBX_R, *, radio_m: int = 15, **options: Scalar
) -> Ablation:
    (choice,) = (one for one in STRATEGIES if one.name == strategy)
    base = Block(
        strategies=(choice,),
        robots=(ROBOTS,),
        radios=(RadioChoice(range_m=float(radio_m), label=radio_label(radio_m)),),
    )
    changed = with_options(choice, change, options)
    return Ablation(
        topic=SETTINGS,
        change=change,
        base=base,
        changed=msgspec.structs.replace(base, strategies=(changed,)),
        is_quick=radio_m == 15 and change != WIDER,
    )


ABLATIONS = Ablations(
    repetitions=15,
    run_s=10.0,
    quick_repetitions=6,
    changes=(
        _ablation(FORGETS, lost_after_s=15.0),
        _ablation(FORGETS, radio_m=30, lost_after_s=15.0),
        _ablation(WIDER, phi_factor=1.8),
        _ablation(WIDER, radio_m=30, phi_factor=1.8),
        _ablation(NO_SIGNALS, stop_signals=False),
        _ablation(NOTHING_LEFT, replan="target"),
        *(
            _ablation(TO_THE_CELL, strategy, reached="cell", paths="march")
            for strategy in (SBX_R, CLOSEST, UTILITY)
        ),
    ),
)
"""The ablations of the page."""
