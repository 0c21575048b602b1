"""Print the table of all benchmarks; a missed target or an error is a line of it."""

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


def main() -> None:
    """Measure the kernels, then whole runs, teams of either family, and experiments."""
    print(machine.account(), flush=True)
    show(
        kernels.BENCHMARKS
        | whole_run.BENCHMARKS
        | stepping.BENCHMARKS
        | team.BENCHMARKS
        | frontier.BENCHMARKS
        | learning.BENCHMARKS
        | replay.BENCHMARKS
        | throughput.BENCHMARKS
    )


if __name__ == "__main__":
    main()
