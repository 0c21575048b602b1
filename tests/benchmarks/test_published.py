import csv
import sys

import pytest

from benchmarks import published
from multisrt.experiments.crossing import runs
from multisrt.experiments.spec import ExperimentSpec
from multisrt.presets import PRESETS
from multisrt.simulation.simulate import simulate

EXPERIMENT = ExperimentSpec(
    name="small",
    environments=("open",),
    strategies=("srt-ball", "closest"),
    robots=(1,),
    repetitions=2,
)
PLANNED = runs(EXPERIMENT)


@pytest.fixture(scope="module")
def digests():
    return {run.key: simulate(run.spec).footer.digest for run in PLANNED}


def check(digests, tmp_path, monkeypatch, *options):
    with (tmp_path / "multi-srt.csv").open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(("key", "digest"))
        writer.writerows(digests.items())
    monkeypatch.setattr(published, "RESULTS", tmp_path)
    monkeypatch.setattr(published, "experiment", lambda page: EXPERIMENT)
    monkeypatch.setattr(sys, "argv", ["published", "multi-srt", *options])
    with pytest.raises(SystemExit) as ended:
        published.main()
    return ended.value.code


@pytest.mark.slow
def test_runs_that_are_as_published_are_counted(digests, tmp_path, monkeypatch, capsys):
    assert check(digests, tmp_path, monkeypatch) == 0
    assert "4 of 4 runs are as published" in capsys.readouterr().out


@pytest.mark.slow
def test_a_run_that_differs_is_named(digests, tmp_path, monkeypatch, capsys):
    other = PLANNED[2]
    changed = {**digests, other.key: "f" * 64}
    assert check(changed, tmp_path, monkeypatch, "--runs", "0", "--workers", "1") == 1
    out = capsys.readouterr().out
    assert f"differs: [{other.condition}], repetition {other.repetition}" in out
    assert out.count("differs") == 1
    assert "3 of 4 runs are as published" in out


@pytest.mark.slow
def test_a_row_of_another_experiment_is_reported(digests, tmp_path, monkeypatch, capsys):
    more = {**digests, "0" * 32: "f" * 64}
    assert check(more, tmp_path, monkeypatch, "--runs", "1", "--workers", "1") == 1
    out = capsys.readouterr().out
    assert "rows of multi-srt.csv that are no runs of its experiment: 1" in out
    assert "1 of 1 runs are as published" in out


def test_the_sample_depends_on_the_seed_alone():
    assert published.draw(PLANNED, 3, 7) == published.draw(PLANNED, 3, 7)
    assert len({published.draw(PLANNED, 1, seed)[0].key for seed in range(20)}) > 1
    for count in (0, 100):
        assert {run.key for run in published.draw(PLANNED, count, 7)} == {r.key for r in PLANNED}


@pytest.mark.slow
@pytest.mark.parametrize("page", [*PRESETS, *published.EXAMPLES])
def test_every_page_has_the_runs_of_its_experiment_or_says_that_it_has_not(page):
    keys = {run.key for run in runs(published.experiment(page), published.ROOT)}
    same = keys == published.read_digests(published.RESULTS / f"{page}.csv").keys()
    assert same != (published.EARLIER in (published.RESULTS / f"{page}.md").read_text("utf-8"))


@pytest.mark.slow
@pytest.mark.parametrize("options", [("--runs", "-1"), ("--workers", "0")])
def test_counts_that_cannot_be_are_refused(digests, tmp_path, monkeypatch, capsys, options):
    assert check(digests, tmp_path, monkeypatch, *options) == 2
    assert "--runs is 0 or more, --workers 1 or more" in capsys.readouterr().err
