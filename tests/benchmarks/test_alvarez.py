"""The report on Álvarez's rules: fits of known laws, success, the thesis's table."""

import pytest

from benchmarks import alvarez
from benchmarks import alvarez_report as report
from benchmarks.alvarez_report import SCENARIOS, TEAMS, Case, Measures, Row


def made_up(
    *,
    robots: int,
    seed: int = 0,
    scenario: int = 1,
    time_s: float | None = 100.0,
    distance_m: float = 50.0,
    coverage: float = 1.0,
    status: str = "complete",
) -> Row:
    return Row(
        case=Case(scenario=scenario, strategy="rules", robots=robots, seed=seed),
        status=status,
        reason="as made up",
        measures=Measures(
            exploration_time_s=time_s,
            total_distance_m=distance_m,
            coverage=coverage,
            collisions=0,
            makespan_s=600.0,
            waiting_time_s=10.0,
            smallest_clearance_m=0.1,
        ),
        seconds=1.0,
        program="abc",
    )


def lawful(a: float, b: float, **what: object) -> list[Row]:
    """Runs whose times follow a law, and whose robots all travel 200 m together."""
    return [made_up(robots=n, time_s=a * n**b, distance_m=200.0, **what) for n in TEAMS]


def test_a_fit_finds_the_law_that_made_the_means():
    law = report.fit({n: 750.0 * n**-0.9 for n in TEAMS})
    assert (law.a, law.b, law.r2) == (pytest.approx(750.0), pytest.approx(-0.9), pytest.approx(1.0))


def test_a_fit_is_by_least_squares_of_logarithms():
    # log2 of the means is 3, 1, 2 at log2 of the teams 0, 1, 2: slope -1/2, middle 2, of a sum of
    # squares of 2 the line leaves 3/2.
    law = report.fit({1: 8.0, 2: 2.0, 4: 4.0})
    assert (law.a, law.b) == (pytest.approx(2.0**2.5), pytest.approx(-0.5))
    assert law.r2 == pytest.approx(0.25)


def test_one_team_size_makes_no_law():
    assert report.fit({3: 100.0}) is None
    assert report.fit({}) is None


def test_distance_is_that_of_one_robot():
    assert report.means(lawful(700.0, -0.9), report.distance_m)[8] == pytest.approx(25.0)
    (result,) = report.results_of(lawful(700.0, -0.9))
    assert (result.distance.a, result.distance.b) == (pytest.approx(200.0), pytest.approx(-1.0))


@pytest.mark.parametrize(
    ("what", "good"),
    [
        ({}, True),
        ({"coverage": 0.94}, False),
        ({"status": "stalled"}, False),
        ({"time_s": None}, False),
    ],
)
def test_success_needs_a_whole_map(what: dict[str, object], good: bool):
    assert report.success(made_up(robots=2, **what)) == good


def test_runs_without_success_count_in_the_rate_only():
    rows = [
        made_up(robots=2, time_s=100.0),
        made_up(robots=2, seed=1, time_s=9e9, coverage=0.5),
        made_up(robots=2, seed=2, status="out_of_time", time_s=None),
        made_up(robots=2, seed=3, time_s=200.0),
    ]
    assert report.success_rate(rows) == 50.0
    assert report.means(rows, report.time_s) == {2: 150.0}
    assert "150 (2/4)" in report.means_table(rows, report.time_s)


def test_the_statement_tells_exponents_inside_the_theses_limits():
    text = report.statement(lawful(700.0, -0.9) + lawful(900.0, -0.5, scenario=11))
    assert "Exponents of the exploration time: -0.700 ± 0.283" in text
    assert "1 of 2 lie within the -1.02 to -0.7 " in text
    assert (
        "Success: 100.0 % of all runs, 100.0 to 100.0 % by map; the thesis: 94.1 to 99.1 %" in text
    )
    assert report.statement([]) == "No data."


def test_the_law_table_gives_ours_beside_the_theses():
    table = report.law_table(lawful(700.0, -0.9), {1: "office"})
    (line,) = table.splitlines()[2:]
    assert [field.strip() for field in line.strip("|").split("|")] == [
        "1 (rooms and corridors)",
        "office",
        "600",
        "100.0 / 97.5",
        "700, -0.900 / 747, -0.891",
        "200.0, -1.000 / 141.0, -1.362",
        "1.000",
        "1.000",
    ]


def test_report_is_whole_with_and_without_results():
    assert "No data." in alvarez.report([], 10, "made so")
    text = alvarez.report([made_up(robots=3, status="stalled")], 1, "made so")
    assert "python -m benchmarks.alvarez --spec 1/rules/3/0 > run.toml" in text


@pytest.mark.parametrize("number", list(SCENARIOS))
def test_maps_have_the_theses_outer_size(number: int):
    x0, y0, x1, y1 = alvarez.world_of(alvarez.WORLDS[number]).bounds
    assert (x1 - x0) * (y1 - y0) == pytest.approx(SCENARIOS[number].area_m2, rel=0.01)


def test_grid_has_every_run_once():
    cases = alvarez.grid(2)
    assert len(cases) == len(set(cases)) == 2 * 10 * 8
    spec = alvarez.spec_of(Case(scenario=11, strategy="closest", robots=3, seed=1))
    assert (spec.environment.name, len(spec.robots), spec.starts) == ("maze", 3, "scattered")
    assert spec.robots[0].range_finder.range_m == 4.5
