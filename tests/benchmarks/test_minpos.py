"""The report on MinPos: gains worked out by hand, and what it says of the paper's claims."""

import pytest

from benchmarks import minpos
from benchmarks import minpos_report as report
from benchmarks.minpos_report import Case, Measures, Row


def made_up(
    strategy: str,
    *,
    seed: int,
    time_s: float | None,
    world: str = "maze",
    robots: int = 4,
    status: str = "complete",
) -> Row:
    return Row(
        case=Case(world=world, strategy=strategy, robots=robots, seed=seed),
        status=status,
        reason="as made up",
        measures=Measures(
            exploration_time_s=time_s,
            total_distance_m=300.0,
            coverage=1.0,
            collisions=0,
            makespan_s=600.0,
            waiting_time_s=10.0,
            overlap_share=0.5,
        ),
        seconds=1.0,
        program="abc",
    )


def series(strategy: str, times: list[float], **what: object) -> list[Row]:
    return [made_up(strategy, seed=seed, time_s=t, **what) for seed, t in enumerate(times)]


def test_a_gain_is_that_of_the_means_over_pairs():
    rows = [*series("closest", [100.0, 200.0, 900.0]), *series("minpos", [90.0, 150.0])]
    gain = report.gain(rows, "maze", "minpos", 4)
    # 300 s in the two pairs against 240 s; the third seed has no partner.
    assert (gain.percent, gain.pairs, gain.p) == (pytest.approx(20.0), 2, 1.0)
    assert report.gain(rows, "maze", "greedy", 4) is None
    assert report.gain(rows, "hospital", "minpos", 4) is None


def test_runs_that_are_not_complete_make_no_pair():
    rows = [*series("closest", [100.0, 100.0]), made_up("minpos", seed=0, time_s=50.0)]
    rows.append(made_up("minpos", seed=1, time_s=1.0, status="stalled"))
    gain = report.gain(rows, "maze", "minpos", 4)
    assert (gain.percent, gain.pairs) == (pytest.approx(50.0), 1)


def test_signed_rank_is_exact_for_few_pairs():
    # Six changes of one sign: two of 2^6 = 64 ways of choosing signs are as far out.
    before = [10.0, 20.0, 30.0, 40.0, 50.0, 60.0]
    after = [9.0, 18.0, 27.0, 36.0, 45.0, 54.0]
    assert report.signed_rank(before, after) == pytest.approx(2 / 64)
    assert report.signed_rank(before[:5], after[:5]) == 1.0
    assert report.signed_rank(before, before) == 1.0


def test_the_mean_gain_is_over_worlds_and_teams_and_not_over_runs():
    rows = [
        *series("closest", [100.0] * 9),
        *series("minpos", [90.0] * 9),
        *series("closest", [100.0], world="hospital", robots=2),
        *series("minpos", [70.0], world="hospital", robots=2),
    ]
    assert report.mean_gain(rows, "minpos") == pytest.approx((10.0 + 30.0) / 2)
    assert report.mean_gain(rows, "greedy") is None


def test_the_statement_gives_ours_beside_the_papers():
    times = [100.0 + seed for seed in range(10)]
    rows = [
        *series("closest", times),
        *series("greedy", [1.1 * t for t in times]),
        *series("minpos", [0.7 * t for t in times]),
    ]
    text = report.statement(rows)
    assert "greedy gains -10.0 % on closest" in text
    assert "minpos gains +30.0 % on closest" in text
    assert "The largest gain in the maze: +30.0 % (minpos with 4 robots); the paper: 20 %." in text
    assert "The largest gain in the hospital: no data; the paper: 15 %." in text
    assert "MinPos is ahead of greedy" in text
    assert "beyond chance it is faster in 0 and slower in 1." in text
    assert "| paper's mean |" in report.gains(rows)


def test_times_are_in_the_order_of_strategies_and_teams():
    rows = [
        *series("minpos", [90.0], robots=12),
        *series("minpos", [95.0], robots=2),
        *series("closest", [300.0], robots=1),
    ]
    lines = [
        [field.strip() for field in line.strip("|").split("|")]
        for line in report.times(rows, "maze").splitlines()[2:]
    ]
    assert [line[:4] for line in lines] == [
        ["-", "1", "1/1", "300"],
        ["minpos", "2", "1/1", "95"],
        ["minpos", "12", "1/1", "90"],
    ]


def test_report_is_whole_with_and_without_results():
    assert "no data" in minpos.report([], 10, "made so")
    text = minpos.report([made_up("greedy", seed=4, time_s=None, status="stalled")], 1, "made so")
    assert "python -m benchmarks.minpos --spec maze/greedy/4/4 > run.toml" in text


def test_grid_has_every_run_once_and_a_maze_for_each_seed():
    cases = minpos.grid(2)
    assert len(cases) == len(set(cases)) == 2 * 2 * (1 + 6 * 3)
    first, second = (
        minpos.spec_of(Case(world="maze", strategy="minpos", robots=12, seed=seed))
        for seed in (0, 1)
    )
    assert (first.environment.seed, second.environment.seed) == (0, 1)
    assert (len(first.robots), first.starts) == (12, "clustered")
    assert {robot.drive.kind for robot in first.robots} == {"holonomic"}
