"""What became of teams with faults: ``python -m benchmarks.robustness robustness.sqlite``.

Writes, as Markdown, a line for every strategy of the experiment `examples/robustness.toml`, and
why runs ended that were not complete. The exit code is 1 if any run collided, ran out of time
or came to no end.
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
    "least distance between two bodies (m)",
    "coverage: median",
    "lower quartile",
    "least",
    "area lost with the dead (m2): median",
)


def main() -> None:
    """Print the page; exit with 1 where a run collided or did not end."""
    parser = argparse.ArgumentParser(description="what became of teams with faults")
    parser.add_argument("results", help="what `multisrt experiment run` has filled")
    results = load_results(parser.parse_args().results)
    print("\n".join(page(results)))
    sys.exit(0 if is_right(results) else 1)


def is_right(results: pd.DataFrame) -> bool:
    """Whether all runs came to an end without a collision."""
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
        "of their own each; half of the teams begin together, with walls that block the radio, "
        "half apart, with a radio that loses a message in three and takes up to two seconds. "
        "What is covered is a share of what the whole team could have seen; who is shut in "
        "behind a body that stands for good covers little, and says so.",
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
    """Return a strategy's line."""
    ends = runs["status"].value_counts()
    coverage = runs["coverage"].quantile([0.5, 0.25, 0.0])
    return (
        name,
        str(len(runs)),
        *(str(ends.get(end, 0)) for end in ENDED),
        str((~runs["status"].isin(ENDED)).sum()),
        f"{runs['collisions'].sum():.0f}",
        f"{runs['smallest_distance_between_robots_m'].min():.3f}",
        *(f"{share:.3f}" for share in coverage),
        f"{runs['lost_area_m2'].median():.1f}",
    )


def kind_of(reason: str) -> str:
    """Leave numbers and robots out of a reason, so that equal ones can be counted."""
    whys = [re.sub(r"^(robot \d+|all robots): ", "", part) for part in reason.split("; ")]
    plain = (re.sub(r"robots? [\d, ]*\d", "others", re.sub(r"\d+\.\d+", "some", w)) for w in whys)
    return "; ".join(sorted(set(plain)))


if __name__ == "__main__":
    main()
