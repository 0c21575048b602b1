"""Print the tables of ratios; exit with 1 where one is not met."""

import sys
from itertools import chain

from benchmarks import kernels, team
from benchmarks.harness import show


def main() -> None:
    """Measure the kernels, then teams."""
    all_met = show(chain(kernels.claims(), team.claims()))
    sys.exit(0 if team.show_figures() and all_met else 1)


if __name__ == "__main__":
    main()
