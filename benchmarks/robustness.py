"""Outcomes of teams with faults: ``python -m benchmarks.robustness robustness.sqlite``.

Prints in Markdown a row for every strategy of the experiment `examples/robustness.toml`, and the
reasons of runs that were not complete. The exit code is 1 if any run collided, ran out of time or
did not end.
"""

from __future__ import annotations

import argparse
import re
import sys

import pandas as pd

from multisrt import load_results
from multisrt.presets.summary import markdown_table

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
    "area lost with dead robots (m2): median",
)


def main() -> None:
    """Print the page; exit with 1 if a run collided or did not end."""
    parser = argparse.ArgumentParser(description="outcomes of teams with faults")
    parser.add_argument("results", help="the store of `multisrt experiment run`")
    results = load_results(parser.parse_args().results)
    print("\n".join(page(results)))
    sys.exit(0 if is_right(results) else 1)


def is_right(results: pd.DataFrame) -> bool:
    """Return whether all runs ended without a collision."""
    return bool(results["status"].isin(ENDED).all() and (results["collisions"] == 0).all())


def page(results: pd.DataFrame) -> list[str]:
    """Return the lines of the page."""
    lines = [
        "# Teams whose robots die, fall silent or come late",
        "",
        "Made with `multisrt experiment run examples/robustness.toml` and "
        "`python -m benchmarks.robustness robustness.sqlite`.",
        "",
        f"{len(results)} runs in {', '.join(sorted(results['environment'].unique()))}, with faults "
        "of their own each. Half of the teams start together, with walls that block the radio; "
        "the others start apart, with a radio that loses one message in three and delays the "
        "others by up to two seconds. Coverage is a share of what the whole team could have "
        "seen; a robot that is shut in behind a dead one covers little and says so.",
        "",
        markdown_table(
            COLUMNS,
            (summary(str(name), runs) for name, runs in results.groupby("strategy", sort=False)),
        ),
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


def summary(name: str, runs: pd.DataFrame) -> tuple[str, ...]:
    """Return the row of a strategy."""
    ends = runs["status"].value_counts()
    coverage = runs["coverage"].quantile([0.5, 0.25, 0.0])
    return (
        name,
        str(len(runs)),
        *(str(ends.get(end, 0)) for end in ENDED),
        str((~runs["status"].isin(ENDED)).sum()),
        f"{runs['collisions'].sum():.0f}",
        f"{runs['min_distance_between_robots_m'].min():.3f}",
        *(f"{share:.3f}" for share in coverage),
        f"{runs['lost_area_m2'].median():.1f}",
    )


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
