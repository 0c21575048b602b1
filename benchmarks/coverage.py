"""How well every world is covered, over many seeds: ``python -m benchmarks.coverage``.

Prints a line for every world and strategy. A run passes if it is complete, has no collision,
reaches the minimum coverage of its strategy, and if the body keeps clear of all walls in every
recorded motion, as checked with shapely. The exit code is 1 if any run fails.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections import Counter
from dataclasses import dataclass

import numpy as np

from multisrt.environments.catalog import environment, names
from multisrt.environments.environment import Environment
from multisrt.run import explore
from multisrt.spec import DriveSpec

MIN_COVERAGE = {"srt-radial": 0.99, "srt-star": 0.95, "srt-ball": 0.85}
"""Minimum share of the explorable area. Stars leave out corners, balls more of them."""

MIN_COVERAGE_NO_DISC = 0.90
"""Minimum share for other bodies, of what the disc inscribed in the body could see."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Result:
    """Result of one run."""

    coverage: float
    outcome: str
    collisions: int
    clearance_m: float
    nodes: int
    seconds: float


def main() -> None:
    """Print the table; exit with 1 if a run fails."""
    given = _arguments()
    print(
        f"{'world':10} {'strategy':10} {'least':>8} {'median':>8} {'collisions':>10} "
        f"{'clear mm':>9} {'nodes':>6} {'s a run':>8}  outcomes"
    )
    all_right = True
    for name in given.worlds:
        world = environment(name)
        for strategy in given.strategies:
            results = [
                run(world, strategy, seed, given.footprint, given.drive, given.beams)
                for seed in range(given.seeds)
            ]
            right = is_right(results, strategy, given.footprint)
            all_right = all_right and right
            print(line(name, strategy, results) + ("" if right else "  FAILED"), flush=True)
    sys.exit(0 if all_right else 1)


def run(
    world: Environment, strategy: str, seed: int, footprint: str, drive: str, beams: int | None
) -> Result:
    """Return the result of one run."""
    begin = time.perf_counter()
    explored = explore(
        world,
        strategy=strategy,
        seed=seed,
        footprint=footprint,
        beams=beams,
        drive=DriveSpec(kind="holonomic" if drive == "holonomic" else "differential"),
    )
    seconds = time.perf_counter() - begin
    metrics = explored.metrics
    return Result(
        coverage=metrics.coverage,
        outcome=metrics.outcome,
        collisions=metrics.collisions,
        clearance_m=metrics.min_clearance_m,
        nodes=metrics.nodes,
        seconds=seconds,
    )


def is_right(results: list[Result], strategy: str, footprint: str) -> bool:
    """Return whether all runs of a line pass."""
    least = MIN_COVERAGE.get(strategy, 0.0)
    if not footprint.startswith("disc"):
        least = min(least, MIN_COVERAGE_NO_DISC)
    return all(
        r.outcome == "complete"
        and r.collisions == 0
        and r.clearance_m > 0.0
        and r.coverage >= least
        for r in results
    )


def line(name: str, strategy: str, results: list[Result]) -> str:
    """Return a line of the table."""
    coverage = np.array([r.coverage for r in results])
    outcomes = Counter(r.outcome for r in results)
    return (
        f"{name:10} {strategy:10} {coverage.min():8.2%} {np.median(coverage):8.2%} "
        f"{sum(r.collisions for r in results):10} "
        f"{1e3 * min(r.clearance_m for r in results):9.1f} "
        f"{np.median([r.nodes for r in results]):6.0f} "
        f"{np.median([r.seconds for r in results]):8.2f}  "
        + ", ".join(f"{count} {outcome}" for outcome, count in sorted(outcomes.items()))
    )


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.coverage", description=__doc__)
    parser.add_argument(
        "worlds", nargs="*", default=names(), help="default: all worlds of the catalog"
    )
    parser.add_argument("--strategies", nargs="+", default=["srt-radial", "srt-star"])
    parser.add_argument("--seeds", type=int, default=20, help="number of seeds (default: 20)")
    parser.add_argument("--footprint", default="disc:0.25")
    parser.add_argument("--drive", choices=["differential", "holonomic"], default="differential")
    parser.add_argument("--beams", type=int, help="beams of a laser; default: exact sensor")
    return parser.parse_args()


if __name__ == "__main__":
    main()
