"""What it costs to step through a mission, beside the same mission made as a whole."""

from __future__ import annotations

import time
from collections.abc import Iterator

import numpy as np

from benchmarks.harness import Benchmark, Claim
from multisrt.environments.catalog import environment
from multisrt.simulation.simulate import simulate
from multisrt.simulation.stepping import Stepping
from multisrt.spec import CatalogEnvironment, RobotSpec, RunSpec

WORLD, ROBOTS = "museum", 4

ROUNDS = 7
"""Number of alternating runs of both sides; the shortest counts."""

MAX_RATIO = 1.1
"""Upper bound of the time in steps over that of the whole."""


def stepped() -> Iterator[Claim]:
    """Measure missions of both families in steps against the same missions as a whole."""
    world = environment(WORLD)
    for strategy in ("srt-radial", "minpos"):
        spec = RunSpec(
            environment=CatalogEnvironment(name=WORLD),
            strategy=strategy,
            robots=(RobotSpec(),) * ROBOTS,
            starts="clustered",
            seed=1,
        )
        whole = simulate(spec, world)
        best = {"whole": np.inf, "steps": np.inf}
        count = 0
        for _ in range(ROUNDS):
            begin = time.process_time()
            simulate(spec, world)
            best["whole"] = min(best["whole"], time.process_time() - begin)
            begin = time.process_time()
            run = Stepping(spec, world)
            count = sum(1 for _ in run)
            best["steps"] = min(best["steps"], time.process_time() - begin)
            if run.recording.footer.digest != whole.footer.digest:
                raise AssertionError(f"{strategy} in steps is not the run as a whole")
        yield Claim(
            text=f"{strategy}, {ROBOTS} robots, {WORLD}, in steps: as a whole",
            ours=best["steps"] * 1e6,
            theirs=best["whole"] * 1e6,
            at_most=MAX_RATIO,
            note=f"{count:,} steps",
        )


BENCHMARKS: dict[str, Benchmark] = {"stepping": stepped}
