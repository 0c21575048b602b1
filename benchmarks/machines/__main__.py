"""``python -m benchmarks.machines``."""

from benchmarks.machines.command import main

if __name__ == "__main__":
    main()
