"""``python -m benchmarks.mutants``."""

import sys

from benchmarks.mutants.command import main

if __name__ == "__main__":
    sys.exit(main())
