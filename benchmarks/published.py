"""Check of published runs against this program: ``python -m benchmarks.published multi-srt``.

Draws runs of a page of `docs/results/` at random, repeats them, and compares the digests of their
recordings with those in the CSV file of the page. The exit code is 1 if any differs. A small
sample may miss rare differences: ``--runs 0`` repeats all runs. Digests agree on machines of one
architecture with the packages of `constraints.txt`.
"""

from __future__ import annotations

import argparse
import csv
import random
import sys
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path

from multisrt.experiments.crossing import PlannedRun, runs
from multisrt.experiments.spec import ExperimentSpec
from multisrt.presets import PRESETS
from multisrt.simulation.simulate import simulate
from multisrt.terminal import LiveLine

ROOT = Path(__file__).resolve().parents[1]
RESULTS = ROOT / "docs" / "results"
EXAMPLES = {
    "robustness": "robustness.toml",
    "robustness-returning": "robustness_returning.toml",
}
"""Pages whose experiments are files of the folder `examples`."""

EARLIER = "Made by an earlier version of this experiment"
"""How a page says that its runs are to be made anew."""


def main() -> None:
    """Print the runs that differ; exit with 1 if there are any."""
    given = _arguments()
    published = read_digests(RESULTS / f"{given.page}.csv")
    planned = {run.key: run for run in runs(experiment(given.page), ROOT)}
    unknown = published.keys() - planned.keys()
    drawn = draw([run for key, run in planned.items() if key in published], given.runs, given.seed)
    differ = []
    with LiveLine(True, given.page, "runs repeated", counted=True) as line:
        for done, (run, digest) in enumerate(repeated(drawn, given.workers), start=1):
            line.update(completed=done, total=len(drawn))
            if digest != published[run.key]:
                differ.append(run)
    for run in differ:
        print(f"differs: [{run.condition}], repetition {run.repetition}")
    if unknown:
        print(f"rows of {given.page}.csv that are no runs of its experiment: {len(unknown)}")
    print(f"{len(drawn) - len(differ)} of {len(drawn)} runs are as published in {given.page}.csv")
    sys.exit(1 if differ or unknown else 0)


def experiment(page: str) -> ExperimentSpec:
    """Return the experiment of a page."""
    if page in EXAMPLES:
        return ExperimentSpec.from_toml((ROOT / "examples" / EXAMPLES[page]).read_text("utf-8"))
    return PRESETS[page].experiment(False)


def read_digests(file: Path) -> dict[str, str]:
    """Return the digests of the published runs with a recording, by key."""
    with file.open(newline="", encoding="utf-8") as lines:
        return {row["key"]: row["digest"] for row in csv.DictReader(lines) if row["digest"]}


def draw(planned: Sequence[PlannedRun], count: int, seed: int) -> list[PlannedRun]:
    """Return a random sample of runs, or all of them if `count` is 0 or too large."""
    shuffled = random.Random(seed).sample(planned, len(planned))
    return shuffled[:count] if count else shuffled


def repeated(planned: Sequence[PlannedRun], workers: int) -> Iterator[tuple[PlannedRun, str]]:
    """Yield every run with the digest of its repeated recording."""
    with ProcessPoolExecutor(workers, mp_context=get_context("spawn")) as pool:
        yield from zip(planned, pool.map(_digest, planned), strict=True)


def _digest(run: PlannedRun) -> str:
    return simulate(run.spec).footer.digest


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description="check published runs against this program")
    parser.add_argument("page", choices=(*PRESETS, *EXAMPLES))
    parser.add_argument(
        "--runs", type=int, default=40, help="number of runs; 0 for all (default: 40)"
    )
    parser.add_argument("--seed", type=int, default=0, help="seed of the sample (default: 0)")
    parser.add_argument("--workers", type=int, default=2, help="number of processes (default: 2)")
    given = parser.parse_args()
    if given.runs < 0 or given.workers < 1:
        parser.error("--runs is 0 or more, --workers 1 or more")
    return given


if __name__ == "__main__":
    main()
