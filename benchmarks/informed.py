"""The informed plan against minpos: ``python -m benchmarks.informed --worlds 100``.

In random small worlds, with teams of one to four robots, prints the time until 99 % are covered
by both, and in the end the worlds in which minpos took less. A plan that knows the map should
never be the slower one; the exit code is 1 if it was.
"""

from __future__ import annotations

import argparse
import statistics
import sys

import numpy as np

import multisrt as ms
from multisrt.spec import Scalar

SHARE = 0.99


def main() -> None:
    """Print a line for each world, and the exceptions."""
    parser = argparse.ArgumentParser(description="the informed plan against minpos")
    parser.add_argument("--worlds", type=int, default=100, help="number of worlds")
    parser.add_argument("--first", type=int, default=0, help="number of the first world")
    parser.add_argument("--effort", type=float, default=0.2, help="option of the plan")
    given = parser.parse_args()
    multiples: list[float] = []
    slower: list[str] = []
    unreached: list[str] = []
    for number in range(given.first, given.first + given.worlds):
        spec = spec_of(number)
        minpos = ms.explore(spec)
        informed = ms.explore(
            ms.RunSpec(
                environment=spec.environment,
                strategy="informed",
                options={"effort": given.effort},
                robots=spec.robots,
                starts=spec.starts,
                seed=spec.seed,
            )
        ).metrics
        ours, theirs = informed.time_to_99_s, minpos.metrics.time_to_99_s
        line = (
            f"{number:5} {minpos.environment.name:8} {len(spec.robots)} {spec.starts:9} "
            f"informed {_seconds(ours)} minpos {_seconds(theirs)} "
            f"coverage {informed.coverage:.4f} collisions {informed.collisions} "
            f"stops {informed.protective_stops}"
        )
        print(line, flush=True)
        if ours is None or informed.collisions or informed.protective_stops:
            unreached.append(line)
        elif theirs is not None:
            if ours > 0.0:
                multiples.append(theirs / ours)
            if ours > theirs + 1e-6:
                slower.append(line)
    print(f"minpos took {statistics.median(multiples):.2f} times the informed plan (median), ")
    print(f"from {min(multiples):.2f} to {max(multiples):.2f}, in {len(multiples)} worlds")
    print(f"slower than minpos: {len(slower)}", *slower, sep="\n")
    print(f"99 % not reached, a collision or a stop: {len(unreached)}", *unreached, sep="\n")
    sys.exit(1 if slower or unreached else 0)


def spec_of(number: int) -> ms.RunSpec:
    """Return the run of minpos in the world of a number."""
    rng = np.random.default_rng(number)
    worlds: list[tuple[str, dict[str, Scalar]]] = [
        ("rooms", {"size_m": float(rng.integers(8, 15)), "rooms_per_side": 2}),
        ("clutter", {"size_m": float(rng.integers(9, 14)), "cover": 0.06}),
        ("maze", {"size_m": 10.0, "cells": int(rng.integers(4, 6)), "loops": 0.2}),
        ("garden", {"size_m": float(rng.integers(15, 18)), "plots": 2}),
        ("office", {"width_m": 16.0, "height_m": float(rng.integers(12, 15))}),
        ("open", {"size_m": float(rng.integers(9, 15)), "columns": int(rng.integers(0, 5))}),
    ]
    name, parameters = worlds[number % len(worlds)]
    return ms.RunSpec(
        environment=ms.CatalogEnvironment(name=name, parameters=parameters, seed=number),
        strategy="minpos",
        robots=(ms.RobotSpec(),) * int(rng.integers(1, 5)),
        starts="clustered" if rng.integers(2) else "scattered",
        seed=number,
    )


def _seconds(value: float | None) -> str:
    return "   never" if value is None else f"{value:6.1f} s"


if __name__ == "__main__":
    main()
