"""How much a base station learns by each mode of ``home``.

``python -m benchmarks.returning runs.csv`` makes the runs that the table lacks, and prints in
Markdown what was delivered: in three buildings, under a radio that walls block, from starts beside
a base station that are drawn anew for each repetition.
"""

from __future__ import annotations

from itertools import product
from pathlib import Path
from typing import Final

import numpy as np
import pandas as pd
import shapely

import multisrt as ms
from benchmarks.arguments import at_least, parser_of
from multisrt.analysis.measuring import measure
from multisrt.environments.environment import Environment
from multisrt.presets.summary import markdown_table
from multisrt.statistics.intervals import bootstrap
from multisrt.statistics.rank_tests import paired
from multisrt.statistics.summaries import mean

ABOUT: Final = """How much a base station learns by each mode of the option home.

Makes the runs that the table lacks, and prints in Markdown what was delivered. All of them take
about half an hour on one core; after an interruption the same command goes on."""

EXAMPLES: Final = """
out/returning.csv
out/returning.csv --repetitions 3
""".strip()

WORLDS: Final = ("office", "hospital", "library")
RANGES_M: Final = (10.0, 15.0)
MODES: Final = ("never", "in-time", "worth", "relays", "chain")
AGAINST: Final = "in-time"
STRATEGY: Final = "minpos"
ROBOTS: Final = 4
LIMIT_S: Final = 300.0
REPETITIONS: Final = 20

CLEAR_M: Final = 0.5
"""Least distance of the base station from walls, in metres."""

APART_M: Final = 0.8
"""Distance between starts in metres."""

DIGITS: Final = 2
"""Decimals of shares in per cent that are compared."""

COLUMNS: Final = (
    "world",
    "radio (m)",
    "home",
    "delivered (%)",
    "covered (%)",
    "delivery delay (s)",
    f"more than {AGAINST}",
    "p",
)


def drawn_starts(world: Environment, seed: int) -> list[tuple[float, float]]:
    """Return a drawn place for the base station, and the starts beside it in its sight."""
    rng = np.random.default_rng(seed)
    room = world.free.buffer(-CLEAR_M)
    steps = APART_M * np.arange(-3, 4)
    around = np.array(sorted(product(steps, steps), key=lambda at: (np.hypot(*at), at)))
    x0, y0, x1, y1 = world.bounds
    while True:
        base = rng.uniform((x0, y0), (x1, y1))
        places = base + around
        inside = shapely.contains_xy(room, *places.T)
        inside &= shapely.covers(
            world.free, shapely.linestrings([[base, place] for place in places])
        )
        if inside[0] and inside.sum() > ROBOTS:
            return [(float(x), float(y)) for x, y in places[inside][: ROBOTS + 1]]


def run(world: str, range_m: float, mode: str, repetition: int) -> dict[str, object]:
    """Make one run and return its row."""
    environment = ms.environment(world)
    base, *starts = drawn_starts(environment, repetition)
    made = ms.explore(
        environment,
        strategy=STRATEGY,
        robots=ROBOTS,
        starts=starts,
        base=base,
        radio=ms.RadioSpec(range_m=range_m, walls="block"),
        max_time_s=LIMIT_S,
        options={"home": mode},
        seed=repetition,
    )
    # Undelivered area counts up to the same time in all runs, whenever they end.
    metrics = measure(made.recording, environment, horizon_s=LIMIT_S)
    return {
        "world": world,
        "range_m": range_m,
        "home": mode,
        "repetition": repetition,
        "outcome": metrics.outcome,
        "covered": metrics.coverage,
        "delivered": metrics.delivered_coverage,
        "delivery_delay_s": metrics.delivery_delay_s,
        "collisions": metrics.collisions,
    }


def rows(runs: pd.DataFrame) -> list[tuple[str, ...]]:
    """Return the rows of the table, with intervals of the means and paired tests."""
    found: list[tuple[str, ...]] = []
    for (world, range_m), part in runs.groupby(["world", "range_m"], sort=False):
        delivered = part.pivot(index="repetition", columns="home", values="delivered").dropna()
        # What differs by rounding alone is a tie.
        shares = {mode: np.round(100.0 * delivered[mode].to_numpy(), DIGITS) for mode in MODES}
        for mode in MODES:
            own = shares[mode]
            interval = bootstrap([own], mean, rng=0)
            others = part[part["home"] == mode]
            more = np.count_nonzero(own > shares[AGAINST])
            # Lower is better for the test, so shares that are missing are compared.
            test = paired(100.0 - own, 100.0 - shares[AGAINST])
            found.append(
                (
                    str(world),
                    f"{range_m:g}",
                    mode,
                    f"{interval.value:.1f} ({interval.low:.1f} to {interval.high:.1f})",
                    f"{100.0 * others['covered'].mean():.1f}",
                    f"{others['delivery_delay_s'].mean():.1f}",
                    "" if mode == AGAINST else f"{more} of {len(own)}",
                    "" if mode == AGAINST else f"{test.p_value:.2g}",
                )
            )
    return found


def main() -> None:
    """Make the runs that the table lacks, and print the page."""
    parser = parser_of("benchmarks.returning", ABOUT, EXAMPLES)
    parser.add_argument(
        "table", type=Path, metavar="TABLE", help="CSV file with a row for every run"
    )
    parser.add_argument(
        "--repetitions",
        type=at_least(2),
        default=REPETITIONS,
        metavar="N",
        help=f"number of repetitions of each setting (default: {REPETITIONS})",
    )
    given = parser.parse_args()
    held = pd.read_csv(given.table) if given.table.exists() else pd.DataFrame()
    made = {
        (row.world, row.range_m, row.home, row.repetition) for row in held.itertuples(index=False)
    }
    for repetition, world, range_m, mode in product(
        range(given.repetitions), WORLDS, RANGES_M, MODES
    ):
        if (world, range_m, mode, repetition) not in made:
            row = pd.DataFrame([run(world, range_m, mode, repetition)])
            held = pd.concat([held, row], ignore_index=True)
            held.to_csv(given.table, index=False)
    print(markdown_table(COLUMNS, rows(held)))


if __name__ == "__main__":
    main()
