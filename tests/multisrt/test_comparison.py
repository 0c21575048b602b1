"""`compare` and `Comparison`."""

import importlib.util
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

import msgspec
import pytest
import shapely

import multisrt as ms
from multisrt import comparison
from multisrt.comparison import Comparison, compare
from multisrt.experiments.mission import make_run
from multisrt.experiments.spec import (
    EnvironmentChoice,
    ExperimentSpec,
    MemberChoice,
    RadioChoice,
    StartsChoice,
    StrategyChoice,
    TeamChoice,
)
from multisrt.experiments.store import Store
from multisrt.geometry.errors import InvalidInputError
from multisrt.reporting import page
from multisrt.simulation.worlds import build_environment
from multisrt.spec import Death, RadioSpec

ROOM = shapely.box(0, 0, 6, 5)
WORLD = ms.Environment.from_outline(
    "two rooms", shapely.box(0, 0, 9, 5), [shapely.box(4, 0, 4.3, 3)], starts=[(1, 1)]
)
TWO = ["srt-star", "srt-radial"]


@pytest.fixture
def asked(monkeypatch, tmp_path):
    """Make no runs; record what was asked for."""
    monkeypatch.chdir(tmp_path)
    calls = []

    def take(store, **said):
        calls.append((store.experiment, store.missing(), said))

    monkeypatch.setattr(comparison, "run_experiment", take)
    return calls


@pytest.fixture
def here(monkeypatch):
    """Make runs in this process."""

    def make(store, *, progress=None, **_):
        for run in store.missing():
            store.add(make_run(run, store.experiment.limits))

    monkeypatch.setattr(comparison, "run_experiment", make)


# The experiment that is run ------------------------------------------------------------------


def test_conditions_are_crossed(asked):
    compare(["open", "museum"], TWO, robots=[1, 2, 4, 8])
    spec, planned, said = asked[0]
    assert len(planned) == 2 * 2 * 4 * 20
    assert (spec.repetitions, spec.first_seed, spec.recordings) == (20, 0, "none")
    assert (spec.starts, spec.radios, spec.faults) == (("scattered",), ("unlimited",), ("none",))
    assert (said["workers"], said["cluster"], said["modules"]) == (None, None, ())


def test_a_single_value_needs_no_list(asked):
    compare("open", "srt-star", 3, 2, starts="clustered", radios=15.0, workers=5, imports=["json"])
    spec, planned, said = asked[0]
    assert (spec.environments, spec.strategies, spec.robots) == (("open",), ("srt-star",), (3,))
    assert spec.starts == ("clustered",)
    assert spec.radios == (RadioChoice(range_m=15.0),)
    assert len(planned) == 2
    assert (said["workers"], said["modules"]) == (5, ["json"])


def test_all_fields_of_an_experiment_can_be_given(asked):
    one_dies: Any = {"label": "one", "faults": [Death(robot=1, time_s=9.0)]}
    compare(
        EnvironmentChoice(name="rooms", seed="repetition"),
        ["srt-radial", StrategyChoice(name="srt-star", label="few", options={"cones": 6})],
        [2, TeamChoice(label="pair", members=(MemberChoice(footprint="disc:0.3"), MemberChoice()))],
        range(100, 103),
        starts=["scattered", StartsChoice(how="clustered", first="drawn")],
        radios=["unlimited", RadioSpec(range_m=15.0, loss=0.1), 20],
        faults=["none", one_dies],
        exclude=[{"robots": "pair", "radio": "20 m"}],
        stop={"max_time_s": 500.0},
        name="all of it",
        about="whatever",
    )
    spec, planned, _ = asked[0]
    assert (spec.name, spec.about, spec.stop.max_time_s) == ("all of it", "whatever", 500.0)
    assert [run.spec.seed for run in planned][:: len(planned) // 3] == [100, 101, 102]
    assert len(planned) == 3 * 2 * (2 * 2 * 3 * 2 - 2 * 2)
    assert {run.condition.radio for run in planned} == {"unlimited", "15 m", "20 m"}
    assert all(run.spec.stop.max_time_s == 500.0 for run in planned)


def test_the_short_form_has_the_defaults_of_the_spec(asked):
    compare("open", "srt-star")
    spec, _, _ = asked[0]
    assert spec == ExperimentSpec(
        environments=("open",), strategies=("srt-star",), name="Comparison", recordings="none"
    )


def test_a_spec_is_run_as_it_is(asked, tmp_path):
    spec = ExperimentSpec(
        name="whole",
        environments=("open", "museum"),
        strategies=("srt-star",),
        robots=(1, 2),
        repetitions=3,
        recordings="all",
    )
    compare(spec, store=tmp_path / "kept.sqlite", workers=2, imports=["json"])
    assert asked[0][0] == spec
    assert len(asked[0][1]) == 2 * 2 * 3
    assert (asked[0][2]["workers"], asked[0][2]["modules"]) == (2, ["json"])


def test_a_spec_without_a_store_keeps_no_recordings(asked):
    spec = ExperimentSpec(name="plain", environments=("open",), strategies=("srt-star",))
    compare(spec)
    assert asked[0][0] == msgspec.structs.replace(spec, recordings="none")
    with pytest.raises(InvalidInputError, match="say where those go"):
        compare(msgspec.structs.replace(spec, recordings="all"))


@pytest.mark.parametrize(
    "given",
    [
        {"strategies": TWO},
        {"robots": 1},
        {"seeds": 20},
        {"starts": "scattered"},
        {"name": "mine"},
        {"recordings": "none"},
        {"range_finder": {"range_m": 3.0}},
    ],
)
def test_a_spec_and_keywords_do_not_mix(given, asked):
    spec = ExperimentSpec(name="plain", environments=("open",), strategies=("srt-star",))
    with pytest.raises(InvalidInputError, match="an ExperimentSpec is complete") as error:
        compare(spec, **given)
    assert str(error.value).endswith(f"leave out {next(iter(given))}")
    assert not asked


def test_the_short_form_needs_strategies(asked):
    with pytest.raises(InvalidInputError, match="name the strategies to compare"):
        compare("open")
    assert not asked


def test_own_environments(asked, tmp_path):
    (tmp_path / "maps").mkdir()
    (tmp_path / "maps" / "hall.wkt").write_text(ROOM.wkt)
    compare([WORLD, Path("maps/hall.wkt")], "srt-star", seeds=1)
    _, (mine, file), _ = asked[0]
    assert mine.condition.environment == "two rooms"
    assert build_environment(mine.spec.environment) == WORLD
    assert build_environment(mine.spec.environment).starts == WORLD.starts
    assert file.condition.environment == "hall"
    assert build_environment(file.spec.environment).free.equals(ROOM)


@pytest.mark.parametrize(
    ("said", "told"),
    [
        ({"seeds": range(0)}, "seeds are consecutive numbers"),
        ({"seeds": range(0, 9, 2)}, "seeds are consecutive numbers, as in range(100, 120)"),
        ({"seeds": [1, 3]}, "seeds are consecutive numbers, as in range(100, 120), not [1, 3]"),
        ({"seeds": ["1"]}, "seeds are whole numbers, not ['1']"),
        ({"seeds": 1.5}, "seeds are a number of repetitions, or a range, not 1.5"),
        ({"environments": None}, "name the environments to compare in"),
        ({"seeds": True}, "seeds are a number of repetitions"),
        ({"seeds": 0}, "seeds are a number of repetitions from 1 on, not 0"),
        ({"robots": [0]}, "robots[0]: Expected a whole number >= 1"),
        ({"robots": []}, "robots: Expected a list of length >= 1"),
        (
            {"robots": object()},
            "an experiment consists of text, numbers and the parts of an Exp",
        ),
        ({"strategies": "srt-str"}, "(did you mean 'srt-star'?)"),
        ({"environments": "opn"}, "there is no environment 'opn' (did you mean 'open'?)"),
        (
            {"starts": "scatered"},
            "starts[0]: unknown value 'scatered'; allowed: 'base', 'clustered'",
        ),
        ({"radios": 5.0, "robots": 2}, "needs a radio range of at least three times"),
        ({"exclude": [{"robot": 1}]}, "exclude[0]: there is no field 'robot' (did you mean"),
        ({"repetition": 3}, "compare takes no argument 'repetition' (did you mean 'repetitions'?)"),
        ({"seed": 3}, "compare takes no argument 'seed' (did you mean 'seeds'?)"),
        (
            {"max_time_s": 9.0},
            "takes no argument 'max_time_s': give stop=ms.StopRule(max_time_s=SECONDS)",
        ),
        ({"recordings": "all"}, "recordings are kept beside the results: say where those go"),
    ],
)
def test_impossible_experiments_are_refused(said, told, asked):
    with pytest.raises(InvalidInputError) as error:
        compare(**({"environments": "open", "strategies": TWO} | said))
    assert told in str(error.value)
    assert "\n" not in str(error.value)
    assert not asked


def test_what_compare_takes_instead_of_keywords_of_explore_is_valid(asked):
    compare(
        "open",
        StrategyChoice(name="minpos", options={"cell_m": 0.2}),
        stop=ms.StopRule(max_time_s=9.0),
        range_finder=ms.RangeFinderSpec(range_m=5.0, beams=90),
        radios=9.0,
    )
    assert asked[0][0].stop.max_time_s == 9.0


def test_a_named_store_is_kept(asked, tmp_path):
    compare("open", TWO, seeds=2, store=tmp_path / "kept.sqlite", recordings="failed")
    with Store.open(tmp_path / "kept.sqlite") as store:
        assert store.experiment == asked[0][0]
        assert store.planned == 4


def test_without_a_store_no_file_is_left(asked, tmp_path, monkeypatch):
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "scratch"))
    (tmp_path / "scratch").mkdir()
    compare("open", TWO, seeds=1)
    assert [path.name for path in tmp_path.iterdir()] == ["scratch"]
    assert not list((tmp_path / "scratch").iterdir())


# Results -------------------------------------------------------------------------------------


@pytest.fixture
def found(here, tmp_path, monkeypatch) -> Comparison:
    monkeypatch.chdir(tmp_path)
    return compare(WORLD, TWO, [1, 2], 2, range_finder={"range_m": 3.0})


@pytest.mark.slow
def test_tables_figures_and_frames(found, tmp_path):
    assert len(found.results) == found.results.planned == 8
    table = found.table("total_distance_m")
    assert repr(table) == str(table) == table.text()
    assert [row[0].text for row in table.rows] == ["two rooms", "two rooms"]
    assert table.columns[-2:] == ("srt-star", "srt-radial")
    assert "Distance of all robots" in str(table)
    assert "<table" in table._repr_html_()
    assert repr(found).startswith("Overview: two rooms")
    assert all(head in repr(found) for head in ("95 % (s)", "known (s)", "done (s)"))
    assert max(map(len, found.overview().text(80).splitlines())) <= 80
    assert repr(found).endswith("8 of 8 runs succeeded (8 complete)\n")
    swapped = found.table("makespan_s", baseline="srt-radial")
    assert any("no difference can be significant" in note for note in swapped.notes)

    (drawing,) = found.plot("makespan_s")
    assert b"<svg" in drawing.svg
    assert "makespan" in drawing.name
    written = found.plot().save(tmp_path / "figures")
    assert sorted(path.suffix for path in written) == [".pdf", ".svg"]
    assert all(path.stat().st_size > 1000 for path in written)
    assert "<img" in found.plot()._repr_html_()
    assert "two rooms" in repr(found.plot())

    frame = found.frame()
    assert list(frame["strategy"].unique()) == TWO
    assert (frame["status"] == "complete").all()


def test_a_report_resolves_paths_as_the_comparison_did(asked, tmp_path, monkeypatch):
    told = []
    monkeypatch.setattr(page, "write_report", lambda *said, **more: told.append((said, more)))
    found = compare("open", TWO, seeds=1)
    monkeypatch.chdir("/")
    found.report(tmp_path / "report", latex=True)
    assert told == [((found.results, tmp_path / "report"), {"folder": tmp_path, "latex": True})]


def test_a_single_team_size_is_drawn_as_box_plots(here):
    drawings = compare("open", TWO, 1, 2, range_finder={"range_m": 9.0}).plot()
    assert [picture.name.split("-")[0] for picture in drawings] == ["boxes"]


@pytest.mark.parametrize("ask", [lambda c: c.table("makespan"), lambda c: c.plot("makespan")])
def test_unknown_measures_are_refused(ask, found):
    with pytest.raises(InvalidInputError, match=r"no measure 'makespan' \(did you mean"):
        ask(found)


@pytest.mark.slow
def test_the_example_script(here, tmp_path, capsys):
    path = Path(__file__).parents[2] / "examples" / "compare_star_radial.py"
    spec = importlib.util.spec_from_file_location("compare_star_radial", path)
    assert spec is not None
    assert spec.loader is not None
    example = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(example)
    example.main(environments=["open"], robots=[1, 2], seeds=2, folder=tmp_path)
    told = capsys.readouterr().out
    assert told.startswith("Overview: open")
    assert [line.split()[:3] for line in told.splitlines() if line[1:7] == " robot"] == [
        ["1", "robot", "srt-star"],
        ["1", "robot", "srt-radial"],
        ["2", "robots", "srt-star"],
        ["2", "robots", "srt-radial"],
    ]
    assert len(list(tmp_path.glob("*.svg"))) == 1


SCRIPT = """
import shapely
import multisrt as ms

print("begin")
world = ms.Environment.from_outline("hall", shapely.box(0, 0, 9, 5), [shapely.box(4, 0, 5, 3)])
names = ["srt-star", "srt-radial"]
found = ms.compare(world, names, robots=[1, 2], seeds=2, workers=2, progress=False)
print(found.table())
print(sorted(found.results.results[0].metrics.distance_by_robot_m)[0] > 0)
"""


@pytest.mark.slow
def test_a_script_needs_no_main_guard(tmp_path):
    (tmp_path / "script.py").write_text(SCRIPT)
    done = subprocess.run(
        [sys.executable, "script.py"], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.count("begin") == 1
    assert "hall" in done.stdout
    assert done.stdout.endswith("True\n")
    assert [path.name for path in tmp_path.iterdir()] == ["script.py"]
