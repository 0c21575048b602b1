"""Small runs over all strategies, bodies, drives, radios and faults, and what comes out of them.

``python tests/golden/golden_runs.py`` (or ``make golden``) makes them and writes their digests to
`digests.json`; `test_golden.py` compares with these. A difference is a change of behaviour: write
it down in the changelog when it is meant.
"""

import hashlib
import json
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import Any

import msgspec

from multisrt import (
    BaseSpec,
    CatalogEnvironment,
    Death,
    DriveSpec,
    LateStart,
    RadioSpec,
    RangeFinderSpec,
    RobotSpec,
    RunSpec,
    Silence,
    StopRule,
    measure,
    simulate,
)
from multisrt.analysis.metrics import METRIC_GROUPS

FILE = Path(__file__).with_name("digests.json")

ROOMS = CatalogEnvironment(name="rooms", parameters={"size_m": 18.0, "rooms_per_side": 3}, seed=3)
OFFICE = CatalogEnvironment(name="office", parameters={"width_m": 20.0, "height_m": 14.0}, seed=1)
GARDEN = CatalogEnvironment(name="garden", parameters={"size_m": 18.0, "plots": 2}, seed=2)
CLUTTER = CatalogEnvironment(name="clutter", parameters={"size_m": 16.0, "cover": 0.08}, seed=4)
MAZE = CatalogEnvironment(name="maze", parameters={"size_m": 10.0, "cells": 5, "loops": 0.3})
HALL = CatalogEnvironment(name="open", parameters={"size_m": 16.0, "columns": 6}, seed=1)
APARTMENT = CatalogEnvironment(name="apartment")

ROBOT = RobotSpec()
BOX = RobotSpec(footprint="box:0.5x0.3")
WEDGE = RobotSpec(footprint="polygon:-0.2,-0.15 0.3,0 -0.2,0.15")
LASER = RobotSpec(range_finder=RangeFinderSpec(beams=180))
HOLONOMIC = RobotSpec(drive=DriveSpec(kind="holonomic", speed_m_s=0.8))
SMALL = RobotSpec(footprint="disc:0.15", range_finder=RangeFinderSpec(range_m=3.0))
REEDS_SHEPP = RobotSpec(
    footprint="box:0.5x0.3", drive=DriveSpec(kind="reeds-shepp", turning_radius_m=0.4)
)
DUBINS = RobotSpec(drive=DriveSpec(kind="dubins", turning_radius_m=0.4))

SHORT_RADIO = RadioSpec(range_m=12.0, walls="block")
WEAK_RADIO = RadioSpec(range_m=14.0, walls="weaken", multi_hop=False)
BAD_RADIO = RadioSpec(latency_s=0.4, jitter_s=0.3, loss=0.25)
BAD_SHORT_RADIO = RadioSpec(range_m=7.0, latency_s=0.4, jitter_s=0.3, loss=0.25)
BASE = BaseSpec(x=1.0, y=7.0)
DEATH_AND_SILENCE = (
    Death(robot=1, time_s=15.0, when="moving"),
    Silence(robot=0, time_s=20.0, duration_s=25.0),
)


def _spec(
    environment: CatalogEnvironment,
    strategy: str,
    *robots: RobotSpec,
    max_time_s: float = 1500.0,
    **more: Any,
) -> RunSpec:
    return RunSpec(
        environment=environment,
        strategy=strategy,
        robots=robots,
        seed=1,
        stop=StopRule(max_time_s=max_time_s),
        **more,
    )


RUNS = {
    "srt-radial alone": _spec(OFFICE, "srt-radial", ROBOT),
    "srt-radial team": _spec(ROOMS, "srt-radial", *[ROBOT] * 4, starts="clustered"),
    "srt-radial short radio": _spec(OFFICE, "srt-radial", *[ROBOT] * 3, radio=SHORT_RADIO),
    "srt-radial bad radio, death, silence": _spec(
        GARDEN, "srt-radial", *[ROBOT] * 3, radio=BAD_RADIO, faults=DEATH_AND_SILENCE
    ),
    "srt-radial late start, master dies": _spec(
        ROOMS,
        "srt-radial",
        *[ROBOT] * 4,
        starts="clustered",
        faults=(Death(robot=3, time_s=5.0, when="master"), LateStart(robot=2, time_s=20.0)),
    ),
    "srt-radial mixed bodies": _spec(APARTMENT, "srt-radial", ROBOT, BOX, WEDGE, SMALL),
    "srt-radial Reeds-Shepp car": _spec(ROOMS, "srt-radial", REEDS_SHEPP),
    "srt-radial Dubins car": _spec(HALL, "srt-radial", DUBINS),
    "srt-radial sensing on the way": _spec(
        ROOMS, "srt-radial", *[ROBOT] * 2, options={"sense": "moving"}
    ),
    "srt-radial single-robot SRT": _spec(
        ROOMS,
        "srt-radial",
        ROBOT,
        options={"frontier_bias": False, "approach": False, "complete": False},
    ),
    "srt-star team": _spec(GARDEN, "srt-star", *[ROBOT] * 3, starts="clustered"),
    "srt-star laser, holonomic": _spec(CLUTTER, "srt-star", LASER, HOLONOMIC),
    "srt-ball team": _spec(CLUTTER, "srt-ball", *[SMALL] * 2),
    "closest alone": _spec(APARTMENT, "closest", ROBOT),
    "closest together, no radio": _spec(
        MAZE, "closest", *[ROBOT] * 3, starts="clustered", radio=RadioSpec(range_m=0.0)
    ),
    "closest Reeds-Shepp car": _spec(GARDEN, "closest", REEDS_SHEPP, ROBOT),
    "closest Dubins car": _spec(HALL, "closest", DUBINS),
    "greedy team, short radio": _spec(OFFICE, "greedy", *[ROBOT] * 3, radio=SHORT_RADIO),
    "minpos team": _spec(ROOMS, "minpos", *[ROBOT] * 4, starts="clustered"),
    "minpos laser, faults": _spec(
        GARDEN,
        "minpos",
        LASER,
        LASER,
        BOX,
        radio=BAD_RADIO,
        faults=(*DEATH_AND_SILENCE, LateStart(robot=2, time_s=10.0)),
    ),
    "utility team": _spec(OFFICE, "utility", *[ROBOT] * 3, starts="clustered"),
    "utility bad radio, leader dies": _spec(
        ROOMS, "utility", *[HOLONOMIC] * 3, radio=BAD_RADIO, faults=(Death(robot=0, time_s=12.0),)
    ),
    "gain team": _spec(APARTMENT, "gain", *[ROBOT] * 3, starts="clustered"),
    "gain bad radio, robot dies": _spec(
        ROOMS, "gain", *[HOLONOMIC] * 3, radio=BAD_RADIO, faults=(Death(robot=0, time_s=12.0),)
    ),
    "gain rooms and routes": _spec(
        ROOMS,
        "gain",
        *[ROBOT] * 3,
        starts="clustered",
        options={"room_m2": 30.0, "routes_below_m2": 10.0},
    ),
    "routes team": _spec(OFFICE, "routes", *[ROBOT] * 3, starts="clustered"),
    "routes bad radio, robot dies": _spec(
        ROOMS, "routes", *[HOLONOMIC] * 3, radio=BAD_RADIO, faults=(Death(robot=0, time_s=12.0),)
    ),
    "self-bidding team": _spec(
        OFFICE, "self-bidding", *[ROBOT] * 3, starts="clustered", radio=SHORT_RADIO
    ),
    "self-bidding path, weak radio": _spec(
        CLUTTER, "self-bidding", *[SMALL] * 4, radio=WEAK_RADIO, options={"drive": "path"}
    ),
    "informed team": _spec(
        MAZE, "informed", *[ROBOT] * 2, starts="clustered", options={"effort": 0.05}
    ),
    "rules team": _spec(ROOMS, "rules", *[ROBOT] * 3, starts="clustered"),
    "rules crowd": _spec(MAZE, "rules", *[SMALL] * 5, starts="clustered"),
    "minpos crowd": _spec(MAZE, "minpos", *[ROBOT] * 6, starts="clustered"),
    "srt-star crowd": _spec(MAZE, "srt-star", *[SMALL] * 6, starts="clustered"),
    "srt-star alone, base": _spec(OFFICE, "srt-star", ROBOT, radio=SHORT_RADIO, base=BASE),
    "minpos team, base, bad radio": _spec(
        OFFICE, "minpos", *[ROBOT] * 3, radio=BAD_SHORT_RADIO, base=BASE, starts="clustered"
    ),
    "minpos home in time": _spec(
        OFFICE,
        "minpos",
        *[ROBOT] * 2,
        radio=RadioSpec(range_m=5.0, walls="block"),
        base=BASE,
        starts="clustered",
        options={"home": "in-time"},
        max_time_s=90.0,
    ),
    "minpos relays, bad radio": _spec(
        OFFICE,
        "minpos",
        *[ROBOT] * 2,
        radio=RadioSpec(range_m=5.0, walls="block", loss=0.3, latency_s=0.1),
        base=BASE,
        starts="clustered",
        options={"home": "relays"},
        max_time_s=200.0,
    ),
    "srt-radial home if worth": _spec(
        OFFICE,
        "srt-radial",
        ROBOT,
        radio=RadioSpec(range_m=5.0),
        base=BASE,
        options={"home": "worth"},
        max_time_s=200.0,
    ),
    "gain chain, robot dies": _spec(
        OFFICE,
        "gain",
        *[ROBOT] * 4,
        radio=RadioSpec(range_m=6.0, walls="block"),
        base=BASE,
        starts="clustered",
        options={"home": "chain"},
        faults=(Death(robot=2, time_s=40.0),),
    ),
    "greedy pursuit": _spec(
        OFFICE,
        "greedy",
        *[ROBOT] * 3,
        radio=RadioSpec(range_m=4.0, walls="block"),
        starts="clustered",
        options={"pursue": True},
    ),
    "rules bad radio, death": _spec(
        APARTMENT, "rules", *[ROBOT] * 3, radio=BAD_RADIO, faults=DEATH_AND_SILENCE
    ),
}


def outcome(name: str) -> dict[str, str]:
    """Make a run, and return how it ended, and the digests of its recording and its metrics."""
    recording = simulate(RUNS[name])
    metrics = msgspec.to_builtins(measure(recording))
    if recording.spec.base is None:
        # Runs without a base station have the digests that they had before there were any.
        metrics = {name: v for name, v in metrics.items() if name not in METRIC_GROUPS["base"]}
    values = sorted(_leaves(metrics))
    return {
        "outcome": recording.footer.outcome,
        "recording": recording.footer.digest,
        "metrics": hashlib.sha256(json.dumps(values).encode()).hexdigest()[:16],
    }


def _leaves(metrics: dict[str, object]) -> Iterator[tuple[str, str]]:
    # By their own names, whatever groups they are in; what a table holds stays with its name.
    for name, value in metrics.items():
        if isinstance(value, dict) and value and all(isinstance(v, dict) for v in value.values()):
            yield from _leaves(value)
        else:
            yield name, json.dumps(value)


def main() -> None:
    """Write the digests, and print which of them are new or differ from the old ones."""
    before = json.loads(FILE.read_text()) if FILE.exists() else {}
    with ProcessPoolExecutor(2) as pool:
        made = dict(zip(RUNS, pool.map(outcome, RUNS), strict=True))
    FILE.write_text(json.dumps(made, indent=2) + "\n")
    for name in [*made, *before]:
        if made.get(name) != before.get(name):
            print(f"{name}: {before.get(name, 'new')} -> {made.get(name, 'gone')}")
    print(f"{len(made)} runs in {FILE.name}")


if __name__ == "__main__":
    main()
