"""Print the table of ratios."""

from benchmarks.kernels import main

main()
