"""How many missions an hour an experiment makes, and what its runner costs beside the runs."""

from __future__ import annotations

import itertools
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from benchmarks.harness import Claim, least_of_parts
from multisrt.experiments.crossing import runs
from multisrt.experiments.description import ExperimentSpec
from multisrt.experiments.runner import Progress, run_experiment
from multisrt.experiments.store import Store

MISSIONS, WARM, ROUNDS = 80, 4, 7
AN_HOUR = 30_000
"""Missions that two workers are to make in an hour."""


class Round(NamedTuple):
    """One experiment.

    Attributes
    ----------
    workers : int
        How many made it.
    apart_s : float
        By the clock, from one stored run to the next.
    own_s : list of float
        What every run took of its own, in the order of their keys.
    """

    workers: int
    apart_s: float
    own_s: list[float]

    @property
    def beside(self) -> float:
        """What went by from run to run over the runs' own time."""
        return self.apart_s * self.workers * len(self.own_s) / sum(self.own_s)


def claims() -> Iterator[Claim]:
    """Measure the same experiment with one worker and with two, in turns."""
    alone, both = [], []
    for _ in range(ROUNDS):
        alone.append(a_round(1))
        both.append(a_round(2))
    one, two = _mission_s(alone), _mission_s(both)
    what = "Multi-SRT Radial, garden, 4 robots"
    by_clock = min(each.apart_s for each in both)
    yield Claim(
        text=f"missions an hour with two workers, {what}",
        ours_us=two * 1e6,
        theirs_us=3600.0e6 / AN_HOUR,
        at_least=1.0,
        note=f"{3600.0 / two:,.0f} an hour, {3600.0 / by_clock:,.0f} in the quickest round; "
        f"the other side is {AN_HOUR:,}",
    )
    runner = min(each.beside for each in alone)
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


def _mission_s(rounds: list[Round]) -> float:
    # From run to run, if each takes what it took in its quickest round.
    own = least_of_parts([each.own_s for each in rounds]) / len(rounds[0].own_s)
    return own * min(each.beside for each in rounds) / rounds[0].workers


def a_round(workers: int) -> Round:
    """Make the experiment once; what comes before the workers are warm does not count."""
    experiment = ExperimentSpec(
        name="throughput",
        environments=("garden",),
        strategies=("srt-radial",),
        robots=(4,),
        repetitions=MISSIONS,
        recordings="none",
    )
    moments: list[float] = []
    own: dict[str, float] = {}

    def note(progress: Progress) -> None:
        if progress.latest is not None:
            moments.append(time.perf_counter())
            own[progress.latest.key] = progress.latest.wall_s

    with (
        tempfile.TemporaryDirectory() as folder,
        Store.create_or_open(Path(folder) / "results.sqlite", experiment) as store,
    ):
        run_experiment(store, workers=workers, progress=note)
        cold = {run.key for run in itertools.islice(runs(experiment, None), WARM)}
    apart_s = (moments[-1] - moments[WARM - 1]) / (len(moments) - WARM)
    return Round(workers, apart_s, [own[key] for key in sorted(own) if key not in cold])
