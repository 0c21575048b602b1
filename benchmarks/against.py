"""What missions of frontier bidding cost, compared with an older version of multisrt.

``python -m benchmarks.against CHECKOUT [STRATEGY ...]`` runs the same missions with this version
and with the one in another checkout, in turns, each in a process of its own. It compares the
processor time of a mission, and that of a robot for a simulated second where the missions differ in
length.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

HERE = Path(__file__).parents[1]

STRATEGIES = ("closest", "greedy", "minpos", "utility", "rules", "self-bidding")
WORLD, ROBOTS = "museum", 4

SEEDS = 4
"""Number of missions, with other starts, of which the means count: lengths differ by chance."""

ROUNDS = 2
"""Turns of each version, of which the faster counts."""

MISSION = """
import hashlib, sys, time
from multisrt import CatalogEnvironment, RobotSpec, RunSpec, StopRule, environment, simulate

world, strategy, robots, seeds, limit_s = sys.argv[1:]
free = environment(world)

def mission(seed):
    return RunSpec(
        environment=CatalogEnvironment(name=world),
        strategy=strategy,
        robots=(RobotSpec(),) * int(robots),
        starts="scattered",
        stop=StopRule(max_time_s=float(limit_s)),
        seed=seed,
    )

simulate(mission(1), free)  # compiles or loads the kernels
spent_s, time_s, digest = 0.0, 0.0, hashlib.sha256()
for seed in range(1, int(seeds) + 1):
    begin = time.process_time()
    recording = simulate(mission(seed), free)
    spent_s += time.process_time() - begin
    time_s += recording.footer.time_s
    digest.update(repr(recording.events).encode())
print(spent_s / int(seeds), time_s / int(seeds), digest.hexdigest())
"""
"""Uses only names that older versions have, too."""


class Cost(NamedTuple):
    """What missions cost, in the mean.

    Attributes
    ----------
    cpu_s : float
        Processor time of the simulation.
    time_s : float
        Simulated time at its end.
    digest : str
        Digest of all events of the missions.
    """

    cpu_s: float
    time_s: float
    digest: str


def mission_cost(checkout: Path, strategy: str, seeds: int, limit_s: float) -> Cost:
    """Measure missions with the version in a checkout.

    Raises
    ------
    SystemExit
        If that version does not run them.
    """
    order = (WORLD, strategy, ROBOTS, seeds, limit_s)
    done = subprocess.run(
        [sys.executable, "-P", "-c", MISSION, *map(str, order)],
        env={**os.environ, "PYTHONPATH": str(checkout)},
        capture_output=True,
        text=True,
        check=False,
    )
    if done.returncode:
        sys.exit(f"{checkout} does not run {strategy}:\n{done.stderr}")
    cpu_s, time_s, digest = done.stdout.split()
    return Cost(float(cpu_s), float(time_s), digest)


def compare(checkout: Path, strategy: str, seeds: int, limit_s: float, rounds: int) -> str:
    """Return the line of the table for a strategy."""
    turns = [
        tuple(mission_cost(side, strategy, seeds, limit_s) for side in (checkout, HERE))
        for _ in range(rounds)
    ]
    old, new = (min(side, key=lambda cost: cost.cpu_s) for side in zip(*turns, strict=True))
    per_second = (old.cpu_s / old.time_s) / (new.cpu_s / new.time_s)
    return (
        f"{strategy:>14} {old.cpu_s:8.2f} {new.cpu_s:8.2f} {old.cpu_s / new.cpu_s:7.2f} "
        f"{old.time_s:9.1f} {new.time_s:9.1f} {per_second:7.2f}  "
        f"{'the same' if old.digest == new.digest else 'different'}"
    )


def main(arguments: Sequence[str] | None = None) -> None:
    """Print the table of the strategies that are named, or all."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.against", description=__doc__)
    parser.add_argument("checkout", type=Path, help="folder of the older version")
    parser.add_argument("strategies", metavar="STRATEGY", nargs="*", default=STRATEGIES)
    parser.add_argument("--seeds", type=int, default=SEEDS, help="number of missions")
    parser.add_argument("--rounds", type=int, default=ROUNDS, help="turns of each version")
    parser.add_argument(
        "--limit", type=float, default=86400.0, metavar="S", help="end of missions (simulated s)"
    )
    named = parser.parse_args(arguments)
    if not (named.checkout / "multisrt" / "__init__.py").is_file():
        parser.error(f"{named.checkout} holds no multisrt: name the root of a checkout")
    print(
        f"{WORLD}, {ROBOTS} robots; means of {named.seeds} missions\n"
        f"{'':>14} {'processor time, s':>25} {'mission, s':>19} {'a robot and second':>18}\n"
        f"{'strategy':>14} {'old':>8} {'new':>8} {'old/new':>7} "
        f"{'old':>9} {'new':>9} {'old/new':>7}  events"
    )
    for strategy in named.strategies:
        line = compare(named.checkout.resolve(), strategy, named.seeds, named.limit, named.rounds)
        print(line, flush=True)


if __name__ == "__main__":
    main()
