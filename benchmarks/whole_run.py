"""What a whole run costs beside its own kernels.

A run is recorded with every call that it makes to the visibility, frontier and raster kernels:
of its scans, and of the third stage, which asks what is seen in the known space. Then the run and
a replay of just those calls are timed in turns.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any
from unittest import mock

import numpy as np

from benchmarks.harness import Claim
from multisrt.environments.catalog import environment
from multisrt.events import NodeAdded
from multisrt.geometry.grids.raster import Raster
from multisrt.geometry.regions import arc_pieces, known_space, scan, visibility
from multisrt.geometry.regions.frontier_update import PieceArrays, frontier_changes
from multisrt.recording import Recording
from multisrt.simulation.simulate import simulate
from multisrt.spec import CatalogEnvironment, RunSpec

WORLD, SEED, ROUNDS, CELL_M = "hospital", 2, 5, 0.1

Call = tuple[Callable[..., Any], tuple[Any, ...], dict[str, Any]]


def whole_run() -> Iterator[Claim]:
    """Measure a run of about 300 nodes against the kernels that it cannot do without."""
    world = environment(WORLD)
    spec = RunSpec(environment=CatalogEnvironment(name=WORLD), strategy="srt-radial", seed=SEED)
    calls: list[Call] = []
    with _captured(calls):
        recording = simulate(spec, world)
    of_scans = [call for call in calls if call[0].__module__ != known_space.__name__]
    of_third_stage = [call for call in calls if call[0].__module__ == known_space.__name__]
    boundaries = [np.asarray(e.boundary) for e in recording.events if isinstance(e, NodeAdded)]

    def run() -> Recording:
        return simulate(spec, world)

    def replay(some: list[Call]) -> None:
        for function, positional, named in some:
            function(*positional, **named)

    def third_stage() -> None:
        replay(of_third_stage)

    def scans() -> None:
        replay(of_scans)
        raster = Raster(CELL_M, world.bounds)
        for boundary in boundaries:
            raster.paint(boundary)

    best = {run: float("inf"), scans: float("inf"), third_stage: float("inf")}
    for _ in range(ROUNDS):
        for side in best:
            begin = time.perf_counter()
            side()
            best[side] = min(best[side], time.perf_counter() - begin)
    whole, least = best[run], best[scans] + best[third_stage]
    yield Claim(
        text=f"whole run, {len(boundaries)} nodes, {WORLD}: its own kernels",
        ours_us=whole * 1e6,
        theirs_us=least * 1e6,
        at_most=10.0,
        note=f"{len(boundaries) / whole:.0f} nodes a second; {len(calls)} kernel calls; "
        f"{whole / best[scans]:.1f} times those of the scans alone",
    )


@contextmanager
def _captured(calls: list[Call]) -> Iterator[None]:
    # Every module looks its kernels up by their own names: these are what is replaced. Arrays
    # that change in place afterwards are kept as they were.
    def recorder(function: Callable[..., Any]) -> Callable[..., Any]:
        def wrapper(*positional: Any, **named: Any) -> Any:
            calls.append((function, tuple(map(_copied, positional)), named))
            return function(*positional, **named)

        return wrapper

    with (
        mock.patch.object(scan, "visibility_polygon", recorder(visibility.visibility_polygon)),
        mock.patch.object(arc_pieces, "frontier_changes", recorder(frontier_changes)),
        mock.patch.object(arc_pieces, "_note_spans", recorder(arc_pieces._note_spans)),
        mock.patch.object(arc_pieces, "_wide_enough", recorder(arc_pieces._wide_enough)),
        mock.patch.object(known_space, "_border", recorder(known_space._border)),
        mock.patch.object(known_space, "_sees", recorder(known_space._sees)),
    ):
        yield


def _copied(argument: Any) -> Any:
    if isinstance(argument, np.ndarray):
        return argument.copy()
    if isinstance(argument, PieceArrays):
        return PieceArrays(
            spans=argument.spans.copy(),
            lengths_m=argument.lengths_m.copy(),
            pieces=argument.pieces.copy(),
            wholes=argument.wholes.copy(),
        )
    return argument
