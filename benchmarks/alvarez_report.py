"""What the runs of `benchmarks.alvarez` say, beside Table 4.1 of the thesis."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass

import msgspec
import numpy as np

from benchmarks import rows as results
from benchmarks.reporting import bullets, markdown, spread

TEAMS = (1, 2, 3, 4, 5, 6, 7, 8)

COVERED = 0.95
"""Share of what can be seen that a successful run has covered at least."""

TIME_EXPONENTS = (-1.02, -0.70)
DISTANCE_EXPONENTS = (-1.42, -0.74)
"""Between these lie 99 % of all exponents, by the thesis (section 4.2.1)."""

M2_FOR_A_ROBOT = 60.0
"""More robots than one for each of this area help no more, by the thesis (section 4.2.1)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Scenario:
    """A map of the thesis, the kind it shows it as, and its line in Table 4.1."""

    number: int
    kind: str
    area_m2: float
    success_percent: float
    time: tuple[float, float]
    distance: tuple[float, float]


SCENARIOS = {
    scenario.number: scenario
    for scenario in (
        Scenario(
            number=1,
            kind="rooms and corridors",
            area_m2=600.0,
            success_percent=97.50,
            time=(747.31, -0.891),
            distance=(140.97, -1.362),
        ),
        Scenario(
            number=11,
            kind="maze",
            area_m2=900.0,
            success_percent=96.56,
            time=(1424.9, -0.886),
            distance=(239.03, -1.154),
        ),
        Scenario(
            number=10,
            kind="rooms and corridors",
            area_m2=1600.0,
            success_percent=95.31,
            time=(2615.7, -0.920),
            distance=(460.03, -1.080),
        ),
        Scenario(
            number=13,
            kind="rooms and corridors",
            area_m2=1600.0,
            success_percent=98.13,
            time=(1642.4, -0.861),
            distance=(288.86, -1.000),
        ),
        Scenario(
            number=43,
            kind="irregular obstacles",
            area_m2=1600.0,
            success_percent=98.44,
            time=(2209.4, -0.801),
            distance=(366.41, -1.005),
        ),
        Scenario(
            number=18,
            kind="irregular obstacles, dense",
            area_m2=1600.0,
            success_percent=94.06,
            time=(2221.9, -0.729),
            distance=(296.85, -0.940),
        ),
        Scenario(
            number=45,
            kind="maze",
            area_m2=1600.0,
            success_percent=99.06,
            time=(2692.6, -0.893),
            distance=(434.44, -1.048),
        ),
        Scenario(
            number=16,
            kind="irregular obstacles",
            area_m2=1600.0,
            success_percent=97.19,
            time=(2639.0, -0.875),
            distance=(401.84, -1.045),
        ),
        Scenario(
            number=21,
            kind="maze",
            area_m2=3600.0,
            success_percent=97.19,
            time=(4745.6, -0.855),
            distance=(772.29, -0.930),
        ),
        Scenario(
            number=46,
            kind="rooms and corridors",
            area_m2=4378.0,
            success_percent=96.56,
            time=(7083.3, -0.910),
            distance=(1180.10, -0.970),
        ),
    )
}
"""Table 4.1, in its order."""


class Case(msgspec.Struct, frozen=True, kw_only=True, order=True):
    """One run of the grid: ours of the map that stands for a scenario of the thesis."""

    scenario: int
    strategy: str
    robots: int
    seed: int


class Measures(results.Measures, frozen=True, kw_only=True):
    """What is kept of a run's metrics."""

    makespan_s: float
    waiting_time_s: float
    smallest_clearance_m: float


Row = results.Row[Case, Measures]


def success(row: Row) -> bool:
    """Whether the robots ended with a complete map, and it is one."""
    return (
        row.status == "complete"
        and row.measures is not None
        and row.measures.exploration_time_s is not None
        and row.measures.coverage >= COVERED
    )


def success_rate(rows: Sequence[Row]) -> float:
    """Percentage of successful runs; not a number without runs."""
    return 100.0 * sum(map(success, rows)) / len(rows) if rows else math.nan


# Fits ---------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class PowerLaw:
    """The law y = a x^b of a mean over team sizes, and r2, its fit in logarithms."""

    a: float
    b: float
    r2: float


def fit(means: Mapping[int, float]) -> PowerLaw | None:
    """Fit y = a x^b to means by team size, by least squares of logarithms.

    None where there are fewer than two team sizes.
    """
    if len(means) < 2:
        return None
    x, y = np.log([*means.keys()]), np.log([*means.values()])
    b, log_a = np.polyfit(x, y, 1)
    rest, whole = np.sum((y - log_a - b * x) ** 2), np.sum((y - y.mean()) ** 2)
    return PowerLaw(float(np.exp(log_a)), float(b), float(1.0 - rest / whole) if whole else 1.0)


def means(rows: Iterable[Row], measure: Callable[[Row], float]) -> dict[int, float]:
    """Give the mean of a measure over successful runs, by team size."""
    values: defaultdict[int, list[float]] = defaultdict(list)
    for row in rows:
        if success(row):
            values[row.case.robots].append(measure(row))
    return {robots: float(np.mean(values[robots])) for robots in sorted(values)}


def time_s(row: Row) -> float:
    """When the first robot of a successful run knew that nothing is left."""
    assert row.measures is not None
    assert row.measures.exploration_time_s is not None
    return row.measures.exploration_time_s


def distance_m(row: Row) -> float:
    """How far a robot of a successful run travelled on average."""
    assert row.measures is not None
    return row.measures.total_distance_m / row.case.robots


@dataclass(frozen=True, slots=True, kw_only=True)
class Result:
    """What came out for one scenario."""

    scenario: Scenario
    runs: int
    success_percent: float
    time: PowerLaw | None
    distance: PowerLaw | None


def results_of(rows: Sequence[Row]) -> list[Result]:
    """Give what came out for every scenario that has runs, in the thesis's order."""
    found = []
    for number, scenario in SCENARIOS.items():
        here = [row for row in rows if row.case.scenario == number]
        if here:
            found.append(
                Result(
                    scenario=scenario,
                    runs=len(here),
                    success_percent=success_rate(here),
                    time=fit(means(here, time_s)),
                    distance=fit(means(here, distance_m)),
                )
            )
    return found


# Words and tables ---------------------------------------------------------------------------


def statement(rows: Sequence[Row]) -> str:
    """Say in words what agrees with the thesis."""
    found = results_of(rows)
    if not found:
        return "No data."
    papers = [scenario.success_percent for scenario in SCENARIOS.values()]
    rates = [result.success_percent for result in found]
    lines = [
        f"Success: {success_rate(rows):.1f} % of all runs, {min(rates):.1f} to {max(rates):.1f} % "
        f"by map; the thesis: {min(papers):.1f} to {max(papers):.1f} %.",
        _exponents(
            "exploration time",
            [result.time for result in found],
            [scenario.time[1] for scenario in SCENARIOS.values()],
            TIME_EXPONENTS,
        ),
        _exponents(
            "distance of a robot",
            [result.distance for result in found],
            [scenario.distance[1] for scenario in SCENARIOS.values()],
            DISTANCE_EXPONENTS,
        ),
    ]
    return bullets(lines)


def _exponents(
    what: str,
    laws: Sequence[PowerLaw | None],
    papers: Sequence[float],
    limits: tuple[float, float],
) -> str:
    known = [law for law in laws if law is not None]
    if not known:
        return f"Exponents of the {what}: no data."
    low, high = limits
    inside = sum(low <= law.b <= high for law in known)
    return (
        f"Exponents of the {what}: {spread([law.b for law in known], 3)}; the thesis: "
        f"{spread(papers, 3)}. {inside} of {len(known)} lie within the {low:g} to {high:g} that it "
        "gives for 99 % of all cases; one of -1 would be a team without any loss."
    )


def law_table(rows: Sequence[Row], ours: Mapping[int, str]) -> str:
    """Write our laws and success beside Table 4.1; `ours` names the map of each scenario."""
    lines = []
    for result in results_of(rows):
        scenario = result.scenario
        lines.append(
            [
                f"{scenario.number} ({scenario.kind})",
                ours[scenario.number],
                f"{scenario.area_m2:g}",
                f"{result.success_percent:.1f} / {scenario.success_percent:.1f}",
                _beside(result.time, scenario.time, 0),
                _beside(result.distance, scenario.distance, 1),
                "-" if result.time is None else f"{result.time.r2:.3f}",
                "-" if result.distance is None else f"{result.distance.r2:.3f}",
            ]
        )
    columns = (
        *("scenario", "our map", "m2", "success %", "time: a, b", "distance: a, b"),
        *("r2 of time", "r2 of distance"),
    )
    return markdown(columns, lines)


def _beside(law: PowerLaw | None, papers: tuple[float, float], digits: int) -> str:
    mine = "-" if law is None else f"{law.a:.{digits}f}, {law.b:.3f}"
    return f"{mine} / {papers[0]:.{digits}f}, {papers[1]:.3f}"


def means_table(rows: Sequence[Row], measure: Callable[[Row], float]) -> str:
    """Write the means by scenario and team size, with the number of successful runs."""
    lines = []
    for number in SCENARIOS:
        here = [row for row in rows if row.case.scenario == number]
        if here:
            by_team = means(here, measure)
            lines.append([str(number), *(_cell(here, by_team, robots) for robots in TEAMS)])
    return markdown(("scenario", *(f"{robots} robots" for robots in TEAMS)), lines)


def _cell(rows: Sequence[Row], by_team: Mapping[int, float], robots: int) -> str:
    here = [row for row in rows if row.case.robots == robots]
    if not here:
        return ""
    mean = f"{by_team[robots]:.0f}" if robots in by_team else "-"
    good = sum(map(success, here))
    return mean if good == len(here) else f"{mean} ({good}/{len(here)})"
