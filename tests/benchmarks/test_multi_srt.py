"""The results script of Multi-SRT on made-up results: tables, claims, continuing."""

import pytest

from benchmarks import multi_srt, multi_srt_report
from benchmarks.multi_srt_report import Case, Measures, Row
from multisrt.spec import RunSpec


def made_up(
    *,
    strategy: str = "srt-radial",
    starts: str = "scattered",
    radio: float | None = None,
    robots: int = 2,
    seed: int = 0,
    time_s: float | None = 100.0,
    distance_m: float = 50.0,
    status: str = "complete",
    collisions: int = 0,
    coverage: float = 1.0,
) -> Row:
    return Row(
        case=Case(
            world="garden",
            strategy=strategy,
            starts=starts,
            radio_range_m=radio,
            robots=robots,
            seed=seed,
        ),
        status=status,
        reason="as made up",
        measures=Measures(
            exploration_time_s=time_s,
            makespan_s=120.0,
            total_distance_m=distance_m,
            waiting_time_s=3.0,
            overlap_share=0.25,
            coverage=coverage,
            nodes=10,
            messages=20,
            bytes_sent=1000,
            coordinations=2,
            deadlocks=1,
            protective_stops=2,
            collisions=collisions,
            smallest_clearance_m=0.01,
        ),
        seconds=1.0,
        program="abc",
    )


def series(times: dict[int, float], **what: object) -> list[Row]:
    """Five seeds for each team size, a second apart, about the times given."""
    return [
        made_up(robots=robots, seed=seed, time_s=time_s + seed - 2, **what)
        for robots, time_s in times.items()
        for seed in range(5)
    ]


def fields(table: str) -> list[list[str]]:
    return [[f.strip() for f in line.strip("|").split("|")] for line in table.splitlines()]


def test_table_gives_mean_and_deviation_of_a_cell():
    rows = [made_up(seed=seed, time_s=t) for seed, t in enumerate((90.0, 100.0, 110.0))]
    rows.append(made_up(seed=3, time_s=None, status="stalled", collisions=1, coverage=0.5))
    header, _, line = fields(multi_srt_report.table(rows, "garden"))
    cell = dict(zip(header, line, strict=True))
    assert cell["complete"] == "3/4"
    assert cell["exploration time s"] == "100 ± 10"
    assert cell["overlap %"] == "25.0 ± 0.0"
    assert cell["coverage min / mean %"] == "50.00 / 87.50"
    assert (cell["collisions"], cell["deadlocks"], cell["protective stops"]) == ("1", "4", "8")


def test_table_has_a_line_for_each_cell_and_leaves_out_what_was_not_measured():
    lost = Row(
        case=made_up(robots=4).case,
        status="error",
        reason="",
        measures=None,
        seconds=1.0,
        program="abc",
    )
    lines = fields(multi_srt_report.table([made_up(), made_up(radio=15.0), lost], "garden"))
    assert [line[2:5] for line in lines[2:]] == [
        ["unlimited", "2", "1/1"],
        ["unlimited", "4", "0/1"],
        ["15 m", "2", "1/1"],
    ]
    assert lines[3][5:11] == ["-"] * 6


def test_falling_time_is_told_from_one_that_rises():
    falls = multi_srt_report.time_falls(series({1: 400, 2: 200, 4: 120}), "scattered")
    assert falls.verdict.startswith("holds: at 2 of 2")
    rises = multi_srt_report.time_falls(series({1: 400, 2: 200, 4: 300}), "scattered")
    assert rises.verdict.startswith("does not hold throughout: at 1 of 2")
    assert "1 of the other 1 go the other way beyond chance" in rises.verdict
    assert "200 s in a team of 2, 300 s in a team of 4" in rises.grounds[-1]


def test_the_robot_alone_begins_every_series():
    rows = series({1: 400})
    for radio in (None, 15.0):
        rows += series({2: 200}, starts="clustered", radio=radio)
    steps = multi_srt_report.steps_of(rows, "clustered", lambda m: m.exploration_time_s)
    assert [(step.sizes, step.before, step.after) for step in steps] == [((1, 2), 400, 200)] * 2
    assert multi_srt_report.steps_of(rows, "scattered", lambda m: m.exploration_time_s) == []


@pytest.mark.parametrize(
    ("last_s", "verdict"),
    [(300, "holds: "), (201, "holds weakly"), (100, "does not hold")],
)
def test_clustered_starts_need_one_rise(last_s: float, verdict: str):
    rows = series({2: 200, 4: last_s}, starts="clustered")
    assert multi_srt_report.time_does_not_always_fall(rows).verdict.startswith(verdict)


def test_distance_is_judged_by_its_own_numbers():
    rows = [made_up(robots=n, seed=s, distance_m=10.0 * n + s) for n in (2, 4) for s in range(5)]
    assert multi_srt_report.distance_grows(rows).verdict.startswith("holds: at 1 of 1")
    rows = [made_up(robots=n, seed=s, distance_m=90.0 / n + s) for n in (2, 4) for s in range(5)]
    assert multi_srt_report.distance_grows(rows).verdict.startswith("does not hold: at 0 of 1")


def test_radial_is_compared_with_star_in_the_same_cell():
    radial = series({2: 100, 4: 90})
    slow, fast = {2: 150, 4: 130}, {2: 150, 4: 60}
    finding = multi_srt_report.radial_before_star(
        radial + series(slow, strategy="srt-star", distance_m=80.0)
    )
    assert finding.verdict.startswith("holds: at 4 of 4")
    assert "exploration time: radial needs less in 2 of 2 cells" in finding.grounds[0]
    finding = multi_srt_report.radial_before_star(
        radial + series(fast, strategy="srt-star", distance_m=80.0)
    )
    assert finding.verdict.startswith("does not hold throughout: at 3 of 4")
    assert any("4 robots (60 s with star, 90 s with radial" in line for line in finding.grounds)


def test_claims_without_results_have_no_data():
    assert [finding.verdict for finding in multi_srt_report.findings([])] == ["no data"] * 4


def test_runs_that_did_not_end_complete_do_not_count_for_claims():
    rows = [
        *series({2: 200, 4: 100}),
        made_up(robots=4, seed=9, time_s=9e9, status="stalled"),
    ]
    (step,) = multi_srt_report.steps_of(rows, "scattered", lambda m: m.exploration_time_s)
    assert step.after == 100


def test_report_lists_failures_with_the_command_that_repeats_them():
    bad = made_up(status="stalled", radio=15.0, starts="clustered", robots=4, seed=7)
    touched = made_up(collisions=1, seed=8)
    text = multi_srt.report([made_up(), bad, touched], 5, "made so")
    assert "Runs: 3 of 5; 2 complete, 2 failed." in text
    assert "`made so`" in text
    assert (
        "- stalled: as made up\n  `multisrt explore garden --strategy srt-radial --robots 4 "
        "--starts clustered --radio-range 15 --seed 7 --max-time 14400`" in text
    )
    assert "- collision: as made up" in text


def test_grid_has_every_run_once_and_the_robot_alone_once_for_each_seed():
    cases = multi_srt.grid(3)
    assert len(cases) == len(set(cases)) == 3 * 2 * 2 * (1 + 4 * 2 * 2)
    spec = multi_srt.spec_of(cases[-1])
    assert isinstance(spec, RunSpec)
    assert (len(spec.robots), spec.starts, spec.radio.range_m) == (16, "clustered", 15.0)
    assert spec.robots[0].range_finder.range_m == 4.0
