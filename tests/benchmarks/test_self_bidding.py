"""The report on self-bidding: marks worked out by hand, the paper's tables, agreement."""

import pytest

from benchmarks import self_bidding
from benchmarks import self_bidding_report as report
from benchmarks.self_bidding_report import PAPER, Case, Measures, Row, mark


def made_up(
    strategy: str,
    *,
    seed: int,
    robots: int = 2,
    radio: float = 15.0,
    isolated_s: float = 0.0,
    time_s: float = 500.0,
    status: str = "complete",
) -> Row:
    return Row(
        case=Case(strategy=strategy, radio_range_m=radio, robots=robots, seed=seed),
        status=status,
        reason="as made up",
        measures=Measures(
            exploration_time_s=time_s,
            total_distance_m=300.0,
            coverage=1.0,
            collisions=0,
            makespan_s=600.0,
            waiting_time_s=10.0,
            isolated_total_s=isolated_s,
            isolated_longest_s=isolated_s,
            beyond_range_m=0.0,
            split_s=isolated_s,
            known_to_one_m2s=0.0,
        ),
        seconds=1.0,
        program="abc",
    )


def ten(strategy: str, first_s: float, **what: object) -> list[Row]:
    """Ten seeds, each isolated a second longer than the one before."""
    return [made_up(strategy, seed=s, isolated_s=first_s + s, **what) for s in range(10)]


# Of 4 against 4 values without overlap the exact p of the rank test is 2 / C(8, 4) = 0.029; with
# one pair the other way round it is 4 / 70 = 0.057; of 3 against 3, 2 / C(6, 3) = 0.1.
@pytest.mark.parametrize(
    ("ours", "others", "sign"),
    [
        ([1, 2, 3, 4], [5, 6, 7, 8], "+"),
        ([5, 6, 7, 8], [1, 2, 3, 4], "-"),
        ([1, 2, 3, 5], [4, 6, 7, 8], ""),
        ([1, 2, 3], [4, 5, 6], ""),
        ([0, 0, 0, 0], [0, 0, 0, 0], ""),
        ([], [1, 2, 3, 4], ""),
    ],
)
def test_marks_are_those_of_the_rank_test(ours: list[float], others: list[float], sign: str):
    assert mark(ours, others) == sign


def test_the_papers_marks_add_up_to_the_counts_in_its_text():
    def count(number: str, strategy: str, sign: str) -> int:
        (table,) = (table for table in PAPER if table.number == number)
        cells = (marks for (name, _), marks in table.marks.items() if name == strategy)
        return "".join(cells).count(sign)

    assert [count("II", name, "+") for name in report.OTHERS] == [11, 11]
    assert [count("IV", "closest", sign) for sign in "+-"] == [6, 1]
    assert [count("IV", "utility", sign) for sign in "+-"] == [7, 1]
    assert [count("V", "closest", sign) for sign in "+-"] == [6, 1]
    assert [count("V", "utility", sign) for sign in "+-"] == [2, 5]


def test_the_papers_marks_go_the_way_of_its_medians():
    wrong = []
    for table in PAPER:
        for (strategy, radio), marks in table.marks.items():
            assert len(marks) == len(report.TEAMS)
            for robots in report.TEAMS:
                cell = (strategy, radio, robots)
                ahead = table.median(cell) - table.median(("self-bidding", radio, robots))
                if ahead * {"+": 1, "-": -1, "": 0}[table.mark(cell)] < 0:
                    wrong.append((table.number, cell))
    # The one that the report calls a misprint.
    assert wrong == [("III", ("utility", 15.0, 3))]


def test_agreement_counts_marks_and_lists_those_that_differ():
    # Table I at 15 m with 2 robots: the paper has + against both.
    rows = [*ten("self-bidding", 100.0), *ten("closest", 200.0), *ten("utility", 0.0)]
    verdicts = {(c.table.number, c.cell[0]): (c.ours, c.verdict) for c in report.comparisons(rows)}
    assert verdicts["I", "closest"] == ("+", "agree")
    assert verdicts["I", "utility"] == ("-", "opposite")
    assert verdicts["III", "closest"] == ("", "the paper's alone")
    assert verdicts["V", "closest"] == ("", "agree")
    text = report.agreement(rows)
    assert "Table I, utility, 15 m, 2 robots: ours -, the paper's +" in text
    assert "Table I, closest" not in text


def test_a_table_gives_median_mean_and_mark_above_the_papers():
    rows = [*ten("self-bidding", 100.0), *ten("closest", 200.0)]
    lines = [
        [field.strip() for field in line.strip("|").split("|")]
        for line in report.table(rows, PAPER[0]).splitlines()
    ]
    assert lines[2][:4] == ["closest", "15 m", "204 (204 ± 3) +", "-"]
    assert lines[3][:4] == ["paper: Yamauchi", "15 m", "201.1 +", "290.9 +"]
    assert ["self-bidding", "15 m", "104 (104 ± 3)"] in [line[:3] for line in lines]


def test_runs_that_are_not_complete_do_not_count():
    rows = [*ten("self-bidding", 100.0), *ten("closest", 200.0, status="out_of_time")]
    assert {c.ours for c in report.comparisons(rows)} == {""}
    assert "0/10" in report.completeness(rows)


def test_report_is_whole_with_and_without_results():
    assert "No data." in self_bidding.report([], 10, "made so")
    text = self_bidding.report([made_up("closest", seed=4, status="stalled")], 1, "made so")
    assert "`made so`" in text
    assert (
        "- stalled: as made up\n  `python -m benchmarks.self_bidding --spec closest/15/2/4" in text
    )


def test_grid_has_every_run_once_and_the_robot_alone_once_for_each_seed():
    cases = self_bidding.grid(3)
    assert len(cases) == len(set(cases)) == 3 * (1 + 4 * 3 * 3)
    spec = self_bidding.spec_of(cases[-1])
    assert (spec.strategy, len(spec.robots), spec.radio.range_m) == ("self-bidding", 5, 30.0)
    assert spec.robots[0].start is not None
    assert {robot.start for robot in spec.robots[1:]} == {None}
    other = self_bidding.spec_of(Case(strategy="closest", radio_range_m=15.0, robots=3, seed=2))
    assert other.robots[0].start == spec.robots[0].start


def test_the_world_is_as_large_as_the_papers():
    x0, y0, x1, y1 = self_bidding.world_of(self_bidding.WORLD).bounds
    assert (x1 - x0, y1 - y0) == pytest.approx((50.0, 25.0))
