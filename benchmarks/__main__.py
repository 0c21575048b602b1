"""Print the table of all benchmarks; a missed target or an error is a line of it."""

import argparse
from collections.abc import Sequence

from benchmarks import (
    frontier,
    kernels,
    learning,
    machine,
    replay,
    stepping,
    team,
    throughput,
    whole_run,
)
from benchmarks.harness import show

# The kernels, then whole runs, teams of either family, and experiments.
PARTS = {
    "kernels": kernels.BENCHMARKS,
    "whole_run": whole_run.BENCHMARKS,
    "stepping": stepping.BENCHMARKS,
    "team": team.BENCHMARKS,
    "frontier": frontier.BENCHMARKS,
    "learning": learning.BENCHMARKS,
    "replay": replay.BENCHMARKS,
    "throughput": throughput.BENCHMARKS,
}


def main(arguments: Sequence[str] | None = None) -> None:
    """Measure the parts that are named, or all."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks", description=__doc__)
    parser.add_argument(
        "parts", metavar="PART", nargs="*", help=f"{', '.join(PARTS)}; without any, all of them"
    )
    named = parser.parse_args(arguments).parts
    for name in named:
        if name not in PARTS:
            parser.error(f"there is no part {name!r}; there are: {', '.join(PARTS)}")
    print(machine.account(), flush=True)
    show({key: row for name in named or PARTS for key, row in PARTS[name].items()})


if __name__ == "__main__":
    main()
