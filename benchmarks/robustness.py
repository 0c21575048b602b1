"""Outcomes of teams with faults: ``python -m benchmarks.robustness robustness robustness.sqlite``.

Prints in Markdown a row for every strategy of the experiment `examples/robustness.toml`, or
`examples/robustness_returning.toml` for ``robustness_returning``, and the reasons of runs that were
not complete. Of several files, each may have some of the strategies. The exit code is 1 if any run
collided, ran out of time or did not end.
"""

from __future__ import annotations

import argparse
import re
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Final

import pandas as pd

from multisrt import load_results
from multisrt.presets.summary import markdown_table
from multisrt.recording.files import atomic_write

TITLES: Final = {
    "robustness": "Teams whose robots die, fall silent or start late",
    "robustness_returning": "Teams that return data, whose robots die, fall silent or start late",
}
"""Titles of the pages, by experiment."""

NOTES: Final = {
    "robustness_returning": " `worth`, `relays`, `chain` and `pursuit` are options of `minpos`.",
}
"""What is added about the strategies of an experiment."""

ENDED = ("complete", "stalled")
COLUMNS = (
    "strategy",
    "runs",
    "complete",
    "stalled",
    "neither",
    "collisions",
    "minimum distance between two bodies (m)",
    "coverage: median",
    "lower quartile",
    "minimum",
    "delivered: median",
    "area lost with dead robots (m2): median",
)


def main() -> None:
    """Print the page; exit with 1 if a run collided or did not end."""
    parser = argparse.ArgumentParser(description="outcomes of teams with faults")
    parser.add_argument("experiment", choices=TITLES, help="the experiment")
    parser.add_argument("files", type=Path, nargs="+", help="its stores, or tables of its runs")
    parser.add_argument("--table", type=Path, help="CSV file that the runs are written to")
    given = parser.parse_args()
    results = latest([read(file) for file in given.files])
    if given.table is not None:
        with atomic_write(given.table) as file:
            results.to_csv(file, index=False)
    print("\n".join(page(results, given.experiment)))
    sys.exit(0 if is_right(results) else 1)


def read(file: Path) -> pd.DataFrame:
    """Return the runs of a table, or of the store of an experiment."""
    return pd.read_csv(file) if file.suffix == ".csv" else load_results(file)


def latest(tables: Sequence[pd.DataFrame]) -> pd.DataFrame:
    """Return the runs of several tables: of a strategy in more than one, those of the last."""
    last = {name: k for k, runs in enumerate(tables) for name in runs["strategy"].unique()}
    parts = [runs[runs["strategy"].map(last) == k] for k, runs in enumerate(tables)]
    order = {name: k for k, name in enumerate(last)}
    whole = pd.concat(parts, ignore_index=True)
    return whole.sort_values("strategy", key=lambda names: names.map(order), kind="stable")


def is_right(results: pd.DataFrame) -> bool:
    """Return whether all runs ended without a collision."""
    return bool(results["status"].isin(ENDED).all() and (results["collisions"] == 0).all())


def page(results: pd.DataFrame, experiment: str) -> list[str]:
    """Return the lines of the page of an experiment."""
    has_base = bool(results["delivered_coverage"].notna().any())
    delivered = (
        " Delivered is the share of this that the base station knows at the end."
        if has_base
        else ""
    )
    strategies = results.groupby("strategy", sort=False)
    summaries = [summary(str(name), runs) for name, runs in strategies]
    columns = [name for name in COLUMNS if has_base or not name.startswith("delivered")]
    lines = [
        f"# {TITLES[experiment]}",
        "",
        f"Made with `multisrt experiment run examples/{experiment}.toml` and "
        f"`python -m benchmarks.robustness {experiment} {experiment}.sqlite`.",
        "",
        f"{len(results):,} runs in {', '.join(sorted(results['environment'].unique()))}, each "
        "with its own faults. Half of the teams start together, with walls that block the "
        "radio; the others start apart, with a radio that loses one message in three and delays "
        "the others by up to two seconds. Coverage is a share of what the whole team could have "
        f"seen; a robot that is shut in behind a dead one covers little, and reports this."
        f"{delivered}{NOTES.get(experiment, '')}",
        "",
        markdown_table(columns, ([row[name] for name in columns] for row in summaries)),
        "",
        "## Runs that were not complete",
        "",
    ]
    reasons = results.loc[results["status"] != "complete", ["strategy", "status", "reason"]].copy()
    reasons["reason"] = [kind_of(reason) for reason in reasons["reason"]]
    counts = reasons.groupby(["strategy", "status", "reason"], sort=False).size()
    if counts.empty:
        return [*lines, "None."]
    rows = counts.reset_index().astype(str).itertuples(index=False, name=None)
    return [*lines, markdown_table(("strategy", "outcome", "why", "runs"), rows)]


def summary(name: str, runs: pd.DataFrame) -> dict[str, str]:
    """Return the row of a strategy, by column."""
    ends = runs["status"].value_counts()
    coverage = runs["coverage"].quantile([0.5, 0.25, 0.0])
    row = (
        name,
        str(len(runs)),
        *(str(ends.get(end, 0)) for end in ENDED),
        str((~runs["status"].isin(ENDED)).sum()),
        f"{runs['collisions'].sum():.0f}",
        f"{runs['min_distance_between_robots_m'].min():.3f}",
        *(f"{share:.3f}" for share in coverage),
        f"{runs['delivered_coverage'].median():.3f}",
        f"{runs['lost_area_m2'].median():.1f}",
    )
    return dict(zip(COLUMNS, row, strict=True))


PLAIN = (
    (r"^(robot \d+|all robots|all others): ", ""),
    (r"\d+\.\d+", "some"),
    (r"robots? \d+(, \d+)*( and \d+)?", "others"),
    (r"others, which does", "others, which do"),
    (r"stands in the way", "stand in the way"),
)
"""What is replaced in a reason, in turn, so that numbers do not tell reasons apart."""


def kind_of(reason: str) -> str:
    """Return a reason without numbers and robots, by which equal ones are counted."""
    whys = reason.split("; ")
    for pattern, plain in PLAIN:
        whys = [re.sub(pattern, plain, why) for why in whys]
    return "; ".join(sorted(set(whys)))


if __name__ == "__main__":
    main()
