import re
from collections import defaultdict
from itertools import product

import numpy as np
import pandas as pd
import pytest

from benchmarks.beyond import (
    FULL,
    LIMITED,
    RADIOS,
    TURNING,
    WORLDS,
    beside_the_best,
    best_of,
    compared,
    cross_validated_ratio,
    experiment,
    of_all,
    page,
    read,
    united,
)
from multisrt.experiments.crossing import runs as runs_of

TIMES = {"gain": 80.0, "minpos": 120.0, "utility": 100.0}


def made(times: dict[str, float], *, repetitions: int = 12) -> pd.DataFrame:
    """Return runs in two worlds by two teams, with times that differ from pair to pair."""
    rng = np.random.default_rng(1)
    rows = []
    for world, team, radio in product(("a", "b"), (2, 4), (FULL, LIMITED)):
        for seed in range(repetitions):
            luck = rng.uniform(0.9, 1.1)
            rows += [
                {
                    "environment": world,
                    "robots": team,
                    "radio": radio,
                    "seed": seed,
                    "strategy": name,
                    "status": "complete",
                    "collisions": 0,
                    "time_to_99_s": luck * time * rng.uniform(0.99, 1.01) / team,
                    "makespan_s": luck * time * 1.2 / team,
                    "over_informed": time / 70.0,
                }
                for name, time in times.items()
            ]
    return pd.DataFrame(rows)


def test_the_experiment_has_worlds_of_all_suites():
    spec = experiment(None, repetitions=1, reference=False)
    conditions = runs_of(spec)
    worlds = {run.condition.environment for run in conditions}
    assert worlds == {
        f"{suite}/{number:02d}" for suite, numbers in WORLDS.items() for number in numbers
    }
    assert not any(
        run.condition.radio == LIMITED and run.condition.robots == 1 for run in conditions
    )


def test_a_strategy_is_compared_by_pairs():
    found = compared(made(TIMES), "gain", "minpos", "time_to_99_s")
    assert found.ratio.low < 2.0 / 3.0 < found.ratio.high
    assert found.mean == pytest.approx(2.0 / 3.0, rel=0.01)
    assert (found.cells, found.pairs, found.faster, found.slower) == (8, 96, 8, 0)
    assert found.p_value < 0.001


def test_a_run_that_is_not_complete_is_slower_than_all_others():
    runs = made(TIMES)
    runs.loc[(runs["strategy"] == "gain") & (runs["environment"] == "a"), "status"] = "stalled"
    found = compared(runs, "gain", "minpos", "time_to_99_s")
    assert (found.faster, found.slower) == (4, 4)


def test_a_failure_improves_no_mean():
    before, runs = made(TIMES), made(TIMES)
    # It stops early, and covers too little.
    failed = (runs["strategy"] == "gain") & (runs["environment"] == "a")
    runs.loc[failed, ["time_to_99_s", "makespan_s"]] = np.nan, 1.0
    papers = ["minpos", "utility"]
    for quantity in ("time_to_99_s", "makespan_s"):
        means = [compared(table, "gain", "minpos", quantity).mean for table in (before, runs)]
        assert means[1] > 1.2 * means[0]
        besides = [beside_the_best(table, "gain", papers, quantity) for table in (before, runs)]
        assert besides[1] > 1.2 * besides[0]
    # Where those of the papers fail, the one that is best elsewhere is the best.
    runs = made(TIMES)
    where = runs["strategy"].isin(papers) & (runs["environment"] == "a")
    runs.loc[where, "status"] = "stalled"
    assert best_of(runs, papers, "time_to_99_s") == "utility"
    assert 0.0 < compared(runs, "gain", "utility", "time_to_99_s").mean < 0.8


def test_few_repetitions_have_no_intervals():
    lines = "\n".join(page(made(TIMES, repetitions=2))).splitlines()
    row = next(line for line in lines if "| utility (best) |" in line)
    cells = [cell.strip() for cell in row.strip("|").split("|")]
    assert "(" not in cells[2]
    assert cells[4] == cells[7] == cells[8] == ""


def test_the_best_strategy_has_the_lowest_mean_over_cells():
    assert best_of(made(TIMES), ["minpos", "utility"], "time_to_99_s") == "utility"


def test_the_best_strategy_is_one_of_those_repeated_most_often():
    runs = made(TIMES | {"greedy": 110.0, "minpos": 90.0}, repetitions=8)
    # In the first repetition alone `greedy` is best.
    lucky = (runs["strategy"] == "greedy") & (runs["seed"] == 0)
    runs.loc[lucky, "time_to_99_s"] /= 2.0
    few = runs[(runs["strategy"] != "minpos") | (runs["seed"] == 0)]
    papers = ["greedy", "minpos", "utility"]
    assert best_of(few, papers, "time_to_99_s") == "utility"
    assert best_of(few[few["seed"] == 0], papers, "time_to_99_s") == "greedy"
    assert "`routes` needs 1.60 (in 1 repetition) of" in "\n".join(
        page(pd.concat([few, made({"routes": 160.0}, repetitions=1)]))
    )


def test_the_best_of_each_cell_is_known_afterwards():
    runs = made(TIMES)
    runs.loc[(runs["strategy"] == "minpos") & (runs["environment"] == "a"), "time_to_99_s"] /= 3.0
    found = beside_the_best(runs, "gain", ["minpos", "utility"], "time_to_99_s")
    assert found == pytest.approx((80.0 / 40.0 * 80.0 / 100.0) ** 0.5, rel=0.02)


def test_the_page_compares_with_the_best():
    text = "\n".join(page(made(TIMES)))
    assert "\n| gain | utility (best) |" in text
    assert "in each cell, which is known only afterwards, the mean of `gain` is 0.8" in text
    assert "\n| unlimited | gain | 1.14 | 1.14 | 1.14 |" in text


def test_the_better_of_ours_in_each_cell_is_told_if_there_are_two():
    assert "If the better one" not in "\n".join(page(made(TIMES)))
    text = "\n".join(page(made(TIMES | {"routes": 160.0})))
    told = re.findall(r"better one of `gain` and `routes` is chosen .* the mean is (0\.\d+)", text)
    assert [float(ratio) for ratio in told] == pytest.approx([0.8] * 4, abs=0.03)


def test_the_better_one_is_chosen_and_measured_in_different_repetitions():
    # In each repetition another one of two equal strategies is lucky by a half.
    runs = made({"gain": 100.0, "routes": 100.0, "utility": 100.0}, repetitions=4)
    lucky = runs["strategy"].map({"gain": 0, "routes": 1}) == runs["seed"] % 2
    runs.loc[lucky, "time_to_99_s"] *= 0.5
    found = cross_validated_ratio(runs, ["gain", "routes"], "utility", "time_to_99_s")
    assert found == pytest.approx(1.0, abs=0.03)
    one = runs[runs["seed"] == 0]
    assert cross_validated_ratio(one, ["gain", "routes"], "utility", "time_to_99_s") is None
    # Cells without a second repetition are left out.
    part = runs[(runs["environment"] == "a") | (runs["seed"] == 0)]
    alone = runs[runs["environment"] == "a"]
    assert cross_validated_ratio(
        part, ["gain", "routes"], "utility", "time_to_99_s"
    ) == cross_validated_ratio(alone, ["gain", "routes"], "utility", "time_to_99_s")
    # What is really better in a cell is found.
    runs = made({"gain": 80.0, "routes": 160.0, "utility": 100.0}, repetitions=4)
    runs.loc[(runs["strategy"] == "routes") & (runs["environment"] == "a"), "time_to_99_s"] /= 4.0
    found = cross_validated_ratio(runs, ["gain", "routes"], "utility", "time_to_99_s")
    assert found == pytest.approx((0.4 * 0.8) ** 0.5, rel=0.03)


def test_repetitions_of_one_radio_are_told_with_it():
    runs = made(TIMES | {"routes": 160.0}, repetitions=3)
    few = runs[(runs["strategy"] != "routes") | (runs["radio"] == "full") | (runs["seed"] == 0)]
    text = "\n".join(page(few))
    assert "1 repetition of all strategies, 3 of `gain`, 3 of `minpos`, 3 of `routes` with" in text
    assert "`routes` with unlimited radio, 3 of `utility`." in text


def test_parts_of_the_runs_are_told_by_strategy():
    text = "\n".join(page(made(TIMES | {"routes": 160.0})))
    by_team = text[text.index("By team size") : text.index("By world")]
    rows = [line.strip("| ").split(" | ") for line in by_team.splitlines() if line.startswith("|")]
    teams = sorted({row[0] for row in rows[2:]}, key=int)
    assert [tuple(row[:2]) for row in rows[2:]] == [
        (team, name) for team in teams for name in ("gain", "routes")
    ]
    assert [float(row[3]) for row in rows[2:4]] == pytest.approx([0.8, 1.6], rel=0.05)


def test_two_strategies_may_be_repeated_more_often_in_a_store_of_their_own():
    both = made({"gain": 80.0, "utility": 100.0}, repetitions=12).assign(digest="a")
    runs = united([made(TIMES, repetitions=2).assign(digest="a"), both])
    assert len(runs) == 8 * (2 * 3 + 10 * 2)
    assert set(of_all(runs, ["gain", "minpos", "utility"])["seed"]) == {0, 1}
    assert set(of_all(runs, ["gain", "utility"])["seed"]) == set(range(12))
    text = "\n".join(page(runs))
    assert "2 repetitions of all strategies, 12 of `gain`, 12 of `utility`." in text
    full = text[text.index("## With unlimited radio") : text.index("By team size")]
    assert [row.split(" | ")[5] for row in full.splitlines() if "utility" in row] == ["48", "48"]


def test_a_strategy_that_drives_as_ours_is_never_the_best_of_the_papers():
    text = "\n".join(page(made(TIMES | {TURNING: 90.0})))
    assert "\n| gain | utility (best) |" in text
    assert f"\n| gain | {TURNING} | 0.8" in text
    spec = experiment(None, repetitions=1, reference=False, strategies=["gain", TURNING])
    strategies = {(run.condition.strategy, run.spec.strategy) for run in runs_of(spec)}
    assert strategies == {("gain", "gain"), (TURNING, "utility")}


def test_a_table_of_runs_is_read_as_it_was_written(tmp_path):
    compared_with_plan = made(TIMES, repetitions=2).assign(
        digest="a", reason="", key="k", coverage=1.0, total_distance_m=1.0, computing_s=1.0
    )
    runs = compared_with_plan.assign(over_informed=np.nan)
    united([runs, compared_with_plan]).to_csv(tmp_path / "runs.csv", index=False)
    found = read(tmp_path / "runs.csv")
    assert len(found) == len(runs)
    assert not found["over_informed"].isna().any()
    assert page(found) == page(compared_with_plan)
    assert page(united([found, runs])) == page(found)


def test_a_plan_counts_for_all_runs_from_the_same_starts():
    runs = made(TIMES, repetitions=2).assign(digest="a")
    is_known = (runs["strategy"] == "gain") & (runs["radio"] == FULL)
    informed_s = runs["time_to_99_s"].where(is_known).to_numpy() / 1.25
    runs["over_informed"] = runs["time_to_99_s"] / informed_s
    found = united([runs])
    assert not found["over_informed"].isna().any()
    of_gain = found[(found["strategy"] == "gain") & (found["radio"] == FULL)]
    assert of_gain["over_informed"].to_numpy() == pytest.approx(1.25)
    cell = ["environment", "robots", "seed"]
    plans = (found["time_to_99_s"] / found["over_informed"]).groupby([found[k] for k in cell])
    assert plans.min().to_numpy() == pytest.approx(plans.max().to_numpy())


def test_a_crashed_run_gives_way_to_a_whole_one():
    whole = made(TIMES, repetitions=1).assign(digest="a")
    crashed = whole.assign(digest=np.nan, status="crashed")
    for tables in ([crashed, whole], [whole, crashed]):
        assert set(united(tables)["status"]) == {"complete"}
    assert set(united([crashed])["status"]) == {"crashed"}


def test_repetitions_go_on_from_a_seed():
    spec = experiment(None, repetitions=2, reference=False, strategies=("gain",), first_seed=5)
    assert {run.spec.seed for run in runs_of(spec)} == {5, 6}


def test_each_repetition_begins_elsewhere_and_all_strategies_there():
    spec = experiment(None, repetitions=3, reference=False, strategies=("gain", "utility"))
    starts = defaultdict(set)
    for run in runs_of(spec):
        if run.condition.environment == "indoor-30/03":
            starts[run.spec.seed].add(run.spec.robots[0].start)
    assert [len(first) for first in starts.values()] == [1, 1, 1]
    assert len(set.union(*starts.values())) == 3


def test_radios_divide_the_runs():
    spec = experiment(None, repetitions=1, reference=False, radios=("limited",))
    assert spec.radios == RADIOS[1:]
    with pytest.raises(SystemExit, match="no radio is named broken: full or limited"):
        experiment(None, repetitions=1, reference=False, radios=("full", "broken"))


def test_worlds_are_divided_among_stores():
    spec = experiment(None, repetitions=1, reference=False, only=("mazes-30/03", "indoor-30/08"))
    assert {run.condition.environment for run in runs_of(spec)} == {"mazes-30/03", "indoor-30/08"}
    with pytest.raises(SystemExit, match="no world is named mazes-30/04"):
        experiment(None, repetitions=1, reference=False, only=("mazes-30/04",))


def test_stores_of_two_versions_of_the_program_are_refused():
    runs = made(TIMES, repetitions=2)
    with pytest.raises(SystemExit, match="make one anew"):
        united([runs.assign(digest="a"), runs.assign(digest="b")])
