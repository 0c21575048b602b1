"""What an experiment costs: missions in yardsticks, with one worker and with two."""

from __future__ import annotations

import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

from benchmarks.harness import Benchmark, Claim
from benchmarks.yardstick import yardstick_at_once_s
from multisrt.experiments.runner import Progress, run_experiment
from multisrt.experiments.spec import ExperimentSpec
from multisrt.experiments.store import Store

MISSIONS = 40
"""Missions of one experiment."""

ROUNDS = 4
"""Number of alternating measurements; the shortest counts."""

MAX_YARDSTICKS = 28.0
"""Upper bound of the time from one mission to the next, with two workers; 17 to 21 are measured,
by machine."""

MAX_LOSS = 1.25
"""Upper bound of a mission's cost with two workers over its cost with one, in yardsticks of as
many processes each: what the workers lose beyond what the machine loses."""

MAX_OVERHEAD = 1.1
"""Upper bound of the time from one run to the next over the time of the run itself."""


def throughput() -> Iterator[Claim]:
    """Measure the same experiment with one worker and with two, alternately."""
    spent: dict[int, list[float]] = {1: [], 2: []}
    yardsticks: dict[int, list[float]] = {1: [], 2: []}
    overheads = []
    for _ in range(ROUNDS):
        for workers in (1, 2):
            yardsticks[workers].append(yardstick_at_once_s(workers))
            between_s, own_s = _mission_s(workers)
            spent[workers].append(between_s)
            if workers == 1:
                overheads.append(between_s / own_s)
    mission_s = {workers: min(times) for workers, times in spent.items()}
    yardstick_s = {workers: min(times) for workers, times in yardsticks.items()}
    cost = {workers: mission_s[workers] / yardstick_s[workers] for workers in (1, 2)}
    yield Claim(
        text="mission, srt-radial, garden, 4 robots, 2 workers: yardstick",
        ours=mission_s[2] * 1e6,
        theirs=yardstick_s[2] * 1e6,
        at_most=MAX_YARDSTICKS,
        note=f"{3600.0 / mission_s[2]:,.0f} missions an hour",
    )
    yield Claim(
        text="a mission's cost with two workers: with one",
        ours=cost[2],
        theirs=cost[1],
        unit="yardsticks",
        at_most=MAX_LOSS,
        note=f"{mission_s[1] / mission_s[2]:.2f} times the missions of one worker; "
        f"yardsticks: {yardstick_s[1] / yardstick_s[2]:.2f}",
    )
    overhead = min(overheads)
    yield Claim(
        text="from one run of an experiment to the next: the run itself",
        ours=overhead * mission_s[1] * 1e6,
        theirs=mission_s[1] * 1e6,
        at_most=MAX_OVERHEAD,
    )


BENCHMARKS: dict[str, Benchmark] = {"throughput of experiments": throughput}


def _mission_s(workers: int) -> tuple[float, float]:
    # Seconds by the clock from one stored run to the next, and those of the runs themselves,
    # without the first runs of every worker, which import and compile.
    experiment = ExperimentSpec(
        name="throughput",
        environments=("garden",),
        strategies=("srt-radial",),
        robots=(4,),
        repetitions=MISSIONS,
        recordings="none",
    )
    moments: list[float] = []
    own: list[float] = []

    def note(progress: Progress) -> None:
        if progress.latest is not None:
            moments.append(time.perf_counter())
            own.append(progress.latest.wall_s)

    with (
        tempfile.TemporaryDirectory() as folder,
        Store.create_or_open(Path(folder) / "results.sqlite", experiment) as store,
    ):
        run_experiment(store, workers=workers, progress=note)
    warm = 2 * workers
    each = (moments[-1] - moments[warm - 1]) / (len(moments) - warm)
    return each, sum(own[warm:]) / (len(own) - warm)
