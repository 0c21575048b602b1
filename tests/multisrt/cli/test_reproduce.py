from functools import partial
from pathlib import Path

import msgspec
import pytest

from multisrt.experiments.store import Store
from tests.multisrt.cli.commands import Call
from tests.multisrt.experiments.results import result_of
from tests.multisrt.presets.constructed import PLAIN, SOME


@pytest.fixture(autouse=True)
def told(monkeypatch) -> list[tuple[object, ...]]:
    """Simulate nothing: runs have the values of `SOME`, and pages are empty.

    Returns the workers, the cluster and the modules of each call.
    """

    calls: list[tuple[object, ...]] = []

    def fake_runs(store: Store, *, workers, cluster, modules, progress) -> None:
        calls.append((workers, cluster, modules))
        name = store.experiment.name.split()[0]
        for run in store.missing():
            measured = SOME[name](run.condition, run.repetition)
            store.add(result_of(run, metrics=msgspec.structs.replace(PLAIN, **measured)))

    def fake_page(results, out: Path, *, claims, comparisons, gallery, progress) -> Path:
        out.mkdir(exist_ok=True)
        page = out / "index.html"
        page.write_text(f"{len(results)} runs, {len(claims)} claims, {len(comparisons)} tables")
        return page

    monkeypatch.setattr("multisrt.experiments.runner.run_experiment", fake_runs)
    monkeypatch.setattr("multisrt.reporting.page.write_report", fake_page)
    return calls


@pytest.fixture
def reproduce(call: Call) -> Call:
    """Run `multisrt reproduce`."""
    return partial(call, "reproduce")


def test_runs_are_made_here_or_on_a_cluster(reproduce, told, tmp_path):
    assert reproduce("alvarez", "--quick", "--seeds", "1", "--workers", "3")[0] == 0
    words = ("alvarez", "--quick", "--seeds", "2", "--cluster", "tcp://host:8786")
    (tmp_path / "reproduced" / "alvarez-quick" / "results-ablations.sqlite").unlink()
    assert reproduce(*words, "--quiet") == (0, "", "")
    # The experiment and its ablations.
    assert told == [(3, None, ())] * 2 + [(None, "tcp://host:8786", ())] * 2
    there = sorted(tmp_path.rglob("*"))
    for both in (("--workers", "2", "--cluster", "c"), ("--cluster", "c", "--workers", "2")):
        code, out, err = reproduce("minpos", *both)
        assert (code, out) == (2, "")
        assert err.splitlines()[-1] == (
            "error: give --workers or --cluster, not both: a cluster has its own; see "
            "'multisrt reproduce --help'"
        )
    code, _, err = reproduce("minpos", "--workers", "-1")
    assert code == 2
    assert "-1 is not in the range x>=0" in err
    assert sorted(tmp_path.rglob("*")) == there


def test_reproduce_writes_a_report_and_a_summary(reproduce, tmp_path):
    code, out, _ = reproduce("alvarez", "--quick")
    folder = tmp_path / "reproduced" / "alvarez-quick"
    assert code == 0
    assert "alvarez: 63 of 63 runs succeeded (63 complete)" in out
    # Success, and twice the robots; exponents are not the printed ones of these maps.
    assert out.count("holds") == 3
    assert out.startswith("63 runs, about ")
    assert "an interrupted experiment continues with the same command" in out
    assert {path.name for path in folder.iterdir()} >= {"results.sqlite", "report", "summary.md"}
    assert "63 runs, 5 claims" in (folder / "report" / "index.html").read_text()
    assert "`multisrt reproduce alvarez --quick`" in (folder / "summary.md").read_text()
    # More repetitions go on in the same store, and so does a reference.
    code, out, _ = reproduce("alvarez", "--quick", "--seeds", "8", "--reference", "informed")
    assert "72 of 72 runs succeeded" in out
    assert out.startswith("9 of 72 runs, about ")
    assert "--seeds 8 --reference informed`" in (folder / "summary.md").read_text()


@pytest.mark.slow
def test_an_interruption_reports_that_nothing_is_lost(reproduce, monkeypatch):
    assert reproduce("alvarez", "--quick", "--seeds", "1")[0] == 0

    def interrupted(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("multisrt.experiments.runner.run_experiment", interrupted)
    code, _, err = reproduce("alvarez", "--quick", "--seeds", "2")
    assert code == 130
    assert "9 of 18 runs are stored" in err


def test_runs_that_failed_show_in_the_exit_code(reproduce, monkeypatch):
    fine = SOME["alvarez"]
    monkeypatch.setitem(
        SOME, "alvarez", lambda at, k: fine(at, k) | {"collisions": int(at.robots == 4)}
    )
    assert reproduce("alvarez", "--quick", "--seeds", "1")[0] == 3


def test_a_store_of_another_paper_is_refused(reproduce):
    assert reproduce("alvarez", "--quick", "--seeds", "1", "--store", "it.sqlite")[0] == 0
    code, _, err = reproduce("minpos", "--quick", "--seeds", "1", "--store", "it.sqlite")
    assert code == 2
    assert err.startswith("error: it.sqlite: holds another experiment")
    assert err.count("\n") == 1


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (("min-pos",), "error: there is no preset 'min-pos' (did you mean 'minpos'?)"),
        (("alvarez", "--out", "taken"), "error: cannot create the folder taken: "),
        (("alvarez", "--quick", "--seeds", "1", "--store", "taken"), "error: taken: not a file of"),
    ],
)
def test_bad_input_gets_one_clear_line(reproduce, tmp_path, words, says):
    (tmp_path / "taken").write_text("a letter to a friend")
    code, _, err = reproduce(*words)
    assert code == 2
    assert err.startswith(says)
    assert err.count("\n") == 1


def test_a_summary_of_something_else_is_not_replaced(reproduce, folder):
    (folder / "mine").mkdir()
    (folder / "mine" / "summary.md").write_text("mine")
    words = ("minpos", "--quick", "--seeds", "6", "--out", "mine")
    code, out, err = reproduce(*words)
    assert (code, out) == (2, "")
    assert err.startswith("error: mine/summary.md exists already")
    assert [path.name for path in (folder / "mine").iterdir()] == ["summary.md"]


@pytest.mark.slow
def test_ablations_have_a_store_and_tables_of_their_own(reproduce, folder):
    code, out, _ = reproduce("sbx-r", "--quick", "--seeds", "6")
    assert code == 0
    # By hand: 10 conditions; 16 of ablations, which have six repetitions however many are asked,
    # and of which 3 are conditions of the experiment.
    expected, again = (line for line in out.splitlines() if "of one core" in line)
    assert expected.startswith("60 runs, about ")
    assert "; then 78 runs of ablations, about " in expected
    assert expected.endswith("; an interrupted experiment continues with the same command")
    assert again.startswith("78 of 96 runs of ablations, about ")
    made = folder / "reproduced" / "sbx-r-quick"
    with (
        Store.open(made / "results.sqlite") as experiment,
        Store.open(made / "results-ablations.sqlite") as ablations,
    ):
        own = {run.key: run.metrics for run in experiment.results()}
        again_made = {run.key: run.metrics for run in ablations.results()}
    assert len(own.keys() & again_made.keys()) == 18
    assert all(again_made[key] == own[key] for key in own.keys() & again_made.keys())
    text = (made / "summary.md").read_text()
    assert "96 of 96 runs, 6 repetitions" in text
    assert "### What settings of self-bidding change: 3 robots, 15 m radio" in text
    # Effects, medians and marks of five tables, two more by other measures, shares of isolation,
    # bids, agreement, driving, thirteen claims, and five of the ablations.
    page = (made / "report" / "index.html").read_text()
    assert page == "60 runs, 13 claims, 30 tables"
    # A second call has nothing to do, and says nothing of time.
    _, out, _ = reproduce("sbx-r", "--quick", "--seeds", "6")
    assert "of one core" not in out
    assert (made / "summary.md").read_text() == text


@pytest.mark.slow
def test_ablations_can_be_left_out(reproduce, folder):
    words = ("sbx-r", "--quick", "--seeds", "1")
    assert reproduce(*words, "--no-ablations")[0] == 0
    made = folder / "reproduced" / "sbx-r-quick"
    assert not (made / "results-ablations.sqlite").exists()
    text = (made / "summary.md").read_text()
    assert "--seeds 1 --no-ablations`" in text
    assert "## Ablations" not in text
    # They can be added.
    assert reproduce(*words)[0] == 0
    assert "96 of 96 runs, 6 repetitions" in (made / "summary.md").read_text()


def test_a_map_of_ones_own_takes_the_place_of_the_worlds(reproduce, folder):
    (folder / "office.wkt").write_text("POLYGON ((0 0, 20 0, 20 12, 0 12, 0 0))")
    words = ("sbx-r", "--quick", "--seeds", "1", "--map", "office.wkt")
    assert reproduce(*words)[0] == 0
    text = (folder / "reproduced" / "sbx-r-on-office-quick" / "summary.md").read_text()
    assert "--map office.wkt --seeds 1`" in text
    assert "World: the map office.wkt" in text
    assert "96 of 96 runs, 6 repetitions" in text
    code, _, err = reproduce("sbx-r", "--map", "nowhere.wkt")
    assert (code, "nowhere.wkt" in err) == (2, True)
    code, _, err = reproduce("sbx-r", "--resolution", "0.05")
    assert err.startswith("error: --resolution is for an image that --map names")
    code, _, err = reproduce("sbx-r", "--starts-from", "team.txt")
    assert err.startswith("error: --starts-from is for an image that --map names")
    (folder / "broken.wkt").write_text("POLYGON ((0 0")
    code, _, err = reproduce("sbx-r", "--quick", "--map", "broken.wkt")
    assert (code, err.count("\n")) == (2, 1)
    assert "broken.wkt" in err
