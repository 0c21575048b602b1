"""The machinery of grids of runs: raw results, runs that fail, starts, single runs."""

import time
from pathlib import Path

import msgspec
import pytest
import shapely

from benchmarks import grid_of_runs, reporting, rows
from benchmarks.rows import Measures, Row
from multisrt.geometry.errors import InvalidInputError
from multisrt.spec import CatalogEnvironment, RunSpec


class Case(msgspec.Struct, frozen=True, kw_only=True):
    strategy: str
    radio_range_m: float
    seed: int


def made_up(
    *, seed: int = 0, time_s: float | None = 100.0, status: str = "complete", collisions: int = 0
) -> Row[Case, Measures]:
    return Row(
        case=Case(strategy="closest", radio_range_m=15.0, seed=seed),
        status=status,
        reason="as made up",
        measures=Measures(
            exploration_time_s=time_s, total_distance_m=50.0, coverage=1.0, collisions=collisions
        ),
        seconds=1.0,
        program="abc",
    )


def spec_of(case: Case) -> RunSpec:
    return RunSpec(environment=CatalogEnvironment(name="open"), seed=case.seed)


def test_raw_results_are_read_back_and_a_cut_line_is_replaced(tmp_path: Path):
    path = tmp_path / "raw.jsonl"
    first, second = made_up(seed=1), made_up(seed=2, time_s=None)
    rows.append(path, first)
    with path.open("ab") as file:
        file.write(b'{"case":{"wor')
    assert rows.read(path, Case, Measures) == {first.case: first}
    rows.append(path, second)
    assert rows.read(path, Case, Measures) == {first.case: first, second.case: second}
    again = made_up(seed=1, status="stalled")
    rows.append(path, again)
    assert rows.read(path, Case, Measures)[first.case] == again


def test_what_is_no_result_is_refused_with_its_line(tmp_path: Path):
    path = tmp_path / "raw.jsonl"
    path.write_bytes(b'{"case": 1}\n')
    with pytest.raises(InvalidInputError, match=r"raw\.jsonl:1: not a result"):
        rows.read(path, Case, Measures)


def test_a_run_that_hangs_is_a_result(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(grid_of_runs, "simulate", lambda *_: time.sleep(60.0))
    row = grid_of_runs.run(made_up().case, spec_of, Measures, 0.05, "abc")
    assert (row.status, row.measures, row.failed) == ("over_limit", None, True)


def test_an_error_in_a_run_is_a_result(monkeypatch: pytest.MonkeyPatch):
    def fail(*_: object) -> None:
        raise ZeroDivisionError("by nothing")

    monkeypatch.setattr(grid_of_runs, "simulate", fail)
    row = grid_of_runs.run(made_up().case, spec_of, Measures, 10.0, "abc")
    assert row.status == "error"
    assert row.reason.startswith("ZeroDivisionError: by nothing (test_grid_of_runs.py:")


def test_a_run_keeps_the_metrics_that_are_asked_for():
    row = grid_of_runs.run(made_up().case, spec_of, Measures, 3600.0, "abc")
    assert (row.status, row.failed, row.program) == ("complete", False, "abc")
    assert row.measures.collisions == 0
    assert row.measures.coverage > 0.99


def test_a_run_is_told_by_a_text_that_names_it_again():
    case = made_up(seed=7).case
    command = grid_of_runs.repeat_by_spec("self_bidding", case)
    assert command == (
        "python -m benchmarks.self_bidding --spec closest/15/7 > run.toml "
        "&& multisrt explore --spec run.toml"
    )
    assert grid_of_runs.case_of("closest/15/7", Case) == case


@pytest.mark.parametrize("text", ["closest/15", "closest/15/7/8", "closest/far/7"])
def test_a_text_that_names_no_run_is_refused(text: str):
    with pytest.raises(InvalidInputError, match="--spec takes strategy/radio_range_m/seed, not"):
        grid_of_runs.case_of(text, Case)


def test_starts_are_drawn_by_the_seed_alone_where_a_body_has_room():
    world = grid_of_runs.world_of(CatalogEnvironment(name="maze"))
    starts = [grid_of_runs.drawn_start(world, seed) for seed in range(30)]
    assert starts == [grid_of_runs.drawn_start(world, seed) for seed in range(30)]
    assert len(set(starts)) == 30
    for x, y, _ in starts:
        assert world.free.boundary.distance(shapely.Point(x, y)) > 0.25
        assert world.free.contains(shapely.Point(x, y))


def test_only_complete_runs_count_where_a_result_is_known():
    made = [made_up(), made_up(time_s=None), made_up(status="stalled", time_s=7.0)]
    assert reporting.known_values(made, lambda m: m.exploration_time_s) == [100.0]


def test_results_of_several_programs_are_told_apart():
    other = msgspec.structs.replace(made_up(), program="def")
    assert "2 states of the program" in reporting.account([made_up(), other], 2, ["So."])
    assert "states of the program" not in reporting.account([made_up()], 2, ["So."])
