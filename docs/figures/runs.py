"""Pictures of single runs, and of the published ones, on the pages that show their commands."""

from __future__ import annotations

import csv
import math
import re
from collections import defaultdict
from collections.abc import Callable
from functools import cache, partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import multisrt as ms
from multisrt.drawing import tree_svg
from multisrt.drawing.animation import animation_svg
from multisrt.experiments.measures import measure_named
from multisrt.replay import replay_html
from multisrt.reporting.figures import size_lines
from multisrt.reporting.study import SEED
from multisrt.robots.loading import load_strategy
from multisrt.statistics.intervals import bootstrap
from multisrt.statistics.summaries import median

DOCS = Path(__file__).resolve().parents[1]
TUTORIAL = DOCS / "tutorials" / "own-strategy.md"
PUBLISHED = DOCS / "results" / "multi-srt.csv"
SHOWN = {"environment": "garden", "starts": "scattered", "radio": "unlimited"}
STRATEGIES = ("srt-star", "srt-radial")


def explored(environment: str, strategy: str | ms.Strategy, **given: Any) -> str:
    """Draw a run as `multisrt explore` does."""
    return tree_svg(ms.explore(environment, strategy=strategy, seed=1, **given).recording)


@cache
def museum_team() -> ms.Recording:
    """Return the run at the top of the README."""
    return ms.explore("museum", strategy="srt-radial", robots=4, seed=1).recording


@cache
def isolated() -> ms.Recording:
    """Return a run of robots whose radio does not reach far."""
    given: dict[str, Any] = {"robots": 3, "starts": "clustered", "seed": 1}
    radio = ms.RadioSpec(range_m=5.0)
    return ms.explore("apartment", strategy="minpos", radio=radio, **given).recording


def lonely_first() -> str:
    """Draw the run of the tutorial, with the strategy that stands there."""
    code = re.search(r"^```python lonely\.py\n(.*?)^```$", TUTORIAL.read_text(), re.S | re.M)
    assert code is not None
    with TemporaryDirectory() as folder:
        file = Path(folder) / "lonely.py"
        file.write_text(code[1], encoding="utf-8")
        return explored("clinic", load_strategy(str(file)), robots=2)


def star_and_radial() -> str:
    """Draw the published times of SRT-Star and SRT-Radial by team size."""
    measure = measure_named("time_to_95_s")
    times_s: dict[tuple[str, int], list[float]] = defaultdict(list)
    with PUBLISHED.open(encoding="utf-8", newline="") as file:
        for row in csv.DictReader(file):
            if all(row[label] == value for label, value in SHOWN.items()):
                time_s = float(row[measure.name] or math.inf)
                times_s[row["strategy"], int(row["robots"])].append(time_s)
    lines = {
        strategy: [
            (robots, bootstrap([own], median, rng=SEED))
            for (name, robots), own in sorted(times_s.items())
            if name == strategy
        ]
        for strategy in STRATEGIES
    }
    return size_lines(lines, STRATEGIES, measure, SHOWN["environment"]).svg.decode()


FIGURES: dict[str, Callable[[], str]] = {
    "museum-team-radial": lambda: tree_svg(museum_team()),
    "museum-team-animation": lambda: animation_svg(museum_team()),
    "apartment-minpos-animation": lambda: animation_svg(isolated()),
    "museum-team-star": partial(explored, "museum", "srt-star", robots=4),
    "apartment-minpos": partial(explored, "apartment", "minpos", robots=3),
    "lonely-first": lonely_first,
    "star-radial-teams": star_and_radial,
}
PAGES: dict[str, Callable[[], str]] = {"apartment-minpos-replay": lambda: replay_html(isolated())}
