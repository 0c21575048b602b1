"""How many missions an hour an experiment makes, and what its runner costs beside the runs."""

from __future__ import annotations

import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

from benchmarks.harness import Claim
from multisrt.experiments.description import ExperimentSpec
from multisrt.experiments.runner import Progress, run_experiment
from multisrt.experiments.store import Store

MISSIONS, ROUNDS = 80, 7
AN_HOUR = 30_000
"""Missions that two workers are to make in an hour."""


def claims() -> Iterator[Claim]:
    """Measure the same experiment with one worker and with two, in turns."""
    alone, overhead, both = [], [], []
    for _ in range(ROUNDS):
        apart, own = _mission_s(1)
        alone.append(apart)
        overhead.append(apart / own)
        both.append(_mission_s(2)[0])
    one, two, runner = min(alone), min(both), min(overhead)
    what = "Multi-SRT Radial, garden, 4 robots"
    yield Claim(
        text=f"missions an hour with two workers, {what}",
        ours_us=two * 1e6,
        theirs_us=3600.0e6 / AN_HOUR,
        at_least=1.0,
        note=f"{3600.0 / two:,.0f} an hour; the other side is {AN_HOUR:,}",
    )
    yield Claim(
        text="an experiment's runner: its runs' own time",
        ours_us=runner * one * 1e6,
        theirs_us=one * 1e6,
        at_most=1.05,
    )
    yield Claim(
        text="two workers against one",
        ours_us=two * 1e6,
        theirs_us=one * 1e6,
        at_least=1.8,
    )


def _mission_s(workers: int) -> tuple[float, float]:
    # Seconds by the clock from one stored run to the next, and those of the runs themselves. What
    # comes before every worker's first run is left out: it is for starting, once.
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
