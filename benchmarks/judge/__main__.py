"""``python -m benchmarks.judge``."""

from benchmarks.judge.command import main

if __name__ == "__main__":
    main()
