"""What a whole run costs beside the compiled kernels that it calls.

A run is recorded with every call that it makes to a kernel. Then the run and a replay of just
those calls are timed alternately.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from typing import Any
from unittest import mock

import numpy as np
from numba.extending import is_jitted

from benchmarks.harness import Benchmark, Claim
from multisrt.environments.catalog import environment
from multisrt.events import NodeAdded
from multisrt.simulation.simulate import simulate
from multisrt.spec import CatalogEnvironment, RunSpec

WORLD, SEED = "hospital", 2

ROUNDS = 5
"""Number of alternating runs of both sides; the shortest counts."""

MAX_RATIO = 8.0
"""Upper bound of the time of the run over that of its kernels."""

Call = tuple[Callable[..., Any], tuple[Any, ...], dict[str, Any]]


def whole_run() -> Iterator[Claim]:
    """Measure a run of about 300 nodes against the kernels that it calls."""
    world = environment(WORLD)
    spec = RunSpec(environment=CatalogEnvironment(name=WORLD), strategy="srt-radial", seed=SEED)
    simulate(spec, world)  # compiles: kernels cannot be compiled while they are replaced
    calls: list[Call] = []
    with _captured(calls):
        recording = simulate(spec, world)
    nodes = sum(isinstance(event, NodeAdded) for event in recording.events)

    def run() -> None:
        simulate(spec, world)

    def kernels() -> None:
        for function, positional, named in calls:
            function(*positional, **named)

    best = {run: np.inf, kernels: np.inf}
    for _ in range(ROUNDS):
        for side in best:
            begin = time.process_time()
            side()
            best[side] = min(best[side], time.process_time() - begin)
    yield Claim(
        text=f"whole run, {nodes} nodes, {WORLD}: its own kernels",
        ours=best[run] * 1e6,
        theirs=best[kernels] * 1e6,
        at_most=MAX_RATIO,
        note=f"{nodes / best[run]:.0f} nodes a second; {len(calls):,} calls of kernels",
    )


BENCHMARKS: dict[str, Benchmark] = {"whole run": whole_run}


@contextmanager
def _captured(calls: list[Call]) -> Iterator[None]:
    # Every name of the library that stands for a kernel is replaced by a function that notes the
    # call. Arrays may change afterwards, so their copies are kept.
    def recorder(function: Callable[..., Any]) -> Callable[..., Any]:
        def wrapper(*positional: Any, **named: Any) -> Any:
            kept = tuple(map(_copied, positional)), {k: _copied(v) for k, v in named.items()}
            calls.append((function, *kept))
            return function(*positional, **named)

        return wrapper

    with ExitStack() as stack:
        for name, module in list(sys.modules.items()):
            if name.startswith("multisrt."):
                for attribute, value in list(vars(module).items()):
                    if is_jitted(value):
                        stack.enter_context(mock.patch.object(module, attribute, recorder(value)))
        yield


def _copied(value: Any) -> Any:
    if isinstance(value, np.ndarray):
        return value.copy()
    if isinstance(value, tuple):
        copies = map(_copied, value)
        return type(value)._make(copies) if hasattr(value, "_make") else tuple(copies)
    return value
