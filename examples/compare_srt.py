"""SRT-Star against SRT-Radial, over seeds and sizes of the team.

`python examples/compare_srt.py` prints a table; it takes some ten seconds.
"""

from statistics import mean

import multisrt as ms

STRATEGIES = ("srt-star", "srt-radial")
HEADINGS = ("strategy", "robots", "makespan s", "distance m", "nodes", "coverage", "complete")


def rows(environment, teams, seeds):
    """Give a row for each strategy and team: means over the seeds."""
    for strategy in STRATEGIES:
        for robots in teams:
            runs = [
                ms.explore(environment, strategy=strategy, robots=robots, seed=seed)
                for seed in range(seeds)
            ]
            metrics = [run.metrics for run in runs]
            yield (
                strategy,
                str(robots),
                f"{mean(m.makespan_s for m in metrics):.0f}",
                f"{mean(m.total_distance_m for m in metrics):.0f}",
                f"{mean(m.nodes for m in metrics):.0f}",
                f"{mean(m.coverage for m in metrics):.2%}",
                f"{sum(run.outcome == 'complete' for run in runs)} of {seeds}",
            )


def main(environment="apartment", teams=(1, 2, 4), seeds=3):
    """Print the table."""
    world = ms.environment(environment)
    print(f"Means over {seeds} seeds in {environment}:")
    for row in (HEADINGS, *rows(world, teams, seeds)):
        print("".join(f"{cell:>12}" for cell in row))


if __name__ == "__main__":
    main()
