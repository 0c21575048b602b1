"""Print the tables of ratios; exit with 1 where one is not met."""

import sys
from itertools import chain

from benchmarks import frontier, kernels, machine, team, throughput
from benchmarks.harness import show


def main() -> None:
    """Measure the kernels, then teams of either family, then whole experiments."""
    print(machine.account(), flush=True)
    claims = chain(kernels.claims(), team.claims(), frontier.claims(), throughput.claims())
    all_met = show(claims)
    # All figures are printed, whether the first are good or not.
    all_met &= team.show_figures()
    all_met &= frontier.show_figures()
    sys.exit(0 if all_met else 1)


if __name__ == "__main__":
    main()
