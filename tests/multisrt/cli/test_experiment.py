"""The commands of `multisrt experiment`."""

import json
import os
import re
import signal
import subprocess
import sys
import time
import tomllib
from functools import partial
from pathlib import Path
from typing import Any

import msgspec
import pytest

import multisrt as ms
from multisrt import terminal
from multisrt.analysis.metrics import Metrics
from multisrt.cli.experiment_check import MAX_ROWS
from multisrt.experiments import live, runner, template, worker
from multisrt.experiments.crossing import runs
from multisrt.experiments.job import Compiled, Compiling, Job
from multisrt.experiments.live import LiveProgress, duration, line_of, note_of
from multisrt.experiments.mission import make_run
from multisrt.experiments.results import Result
from multisrt.experiments.runner import Progress, job_of
from multisrt.experiments.schema import schema
from multisrt.experiments.spec import ExperimentSpec
from multisrt.experiments.store import Store
from multisrt.geometry.errors import InvalidInputError
from multisrt.presets import PRESETS
from tests.multisrt.cli.commands import MAPS, Call
from tests.multisrt.experiments.results import result_of

SMALL = """
name = "small"
environments = ["room.wkt"]
strategies = ["srt-star", "srt-radial"]
robots = [1, 2]
repetitions = 2
"""


@pytest.fixture
def folder(folder: Path) -> Path:
    """The working directory, which contains the experiment `SMALL` too."""
    (folder / "small.toml").write_text(SMALL)
    return folder


@pytest.fixture
def call(call: Call) -> Call:
    """Run `multisrt experiment`."""
    return partial(call, "experiment")


@pytest.fixture(scope="module")
def measured() -> Metrics:
    """Metrics of a run that is a success."""
    return ms.explore("open", strategy="closest").metrics


@pytest.fixture
def fake_runs(monkeypatch, measured) -> dict[str, Any]:
    """Simulate nothing: results have the status that is set here for their repetition.

    Complete runs are a success, the others were not measured.
    """
    said: dict[str, Any] = {"status": {}, "stop": None, "lost": None, "calls": []}

    def run_experiment(store, *, workers, cluster, modules, progress):
        said["calls"].append({"workers": workers, "cluster": cluster, "modules": modules})
        for number, run in enumerate(store.missing()):
            if number == said["lost"]:
                raise InvalidInputError("the cluster is lost")
            if number == said["stop"]:
                raise KeyboardInterrupt
            status = said["status"].get(run.repetition, "complete")
            metrics = measured if status == "complete" else None
            store.add(result_of(run, status, metrics=metrics))

    monkeypatch.setattr(runner, "run_experiment", run_experiment)
    return said


# New -----------------------------------------------------------------------------------------


def test_new_writes_an_experiment_and_its_schema(call, folder):
    code, out, err = call("new", "sub/star.toml")
    assert (code, err) == (0, "")
    assert out.splitlines() == [
        "sub/star.toml",
        "sub/experiment.schema.json",
        "next: multisrt experiment check sub/star.toml",
    ]
    text = (folder / "sub" / "star.toml").read_text()
    assert text.startswith("#:schema ./experiment.schema.json\n")
    assert "multisrt experiment run star.toml" in text
    assert json.loads((folder / "sub" / "experiment.schema.json").read_text()) == schema()
    spec = ExperimentSpec.from_toml(text)
    assert (spec.environments, spec.strategies) == (
        ("garden", "clutter"),
        ("srt-star", "srt-radial"),
    )
    assert (spec.robots, spec.repetitions) == ((1, 2, 4, 8), 20)
    assert len(runs(spec)) == 2 * 2 * 4 * 20


def test_the_template_writes_the_defaults():
    spec = ExperimentSpec.from_toml(template.TEMPLATE)
    plain = ExperimentSpec(
        name=spec.name,
        about=spec.about,
        environments=spec.environments,
        strategies=spec.strategies,
        robots=spec.robots,
    )
    assert spec == plain
    # Every field is set, or shown in a comment.
    for name in ExperimentSpec.__struct_fields__:
        assert re.search(rf"^(# )?(\[*){name}\b", template.TEMPLATE, re.MULTILINE), name


def test_examples_in_the_template_are_valid(folder):
    (folder / "maps").mkdir()
    (folder / "maps" / "floor.wkt").write_text(MAPS["room"])
    text = template.TEMPLATE.replace("floor.yaml", "floor.wkt")
    shown = re.findall(r"^(?:  # (\{.*?\}|\".*\"),|# (\w+ = .*))(?:  .*)?$", text, re.MULTILINE)
    assert len(shown) >= 12
    rest = re.split(r"\n(?=# \[\[exclude)", text)[0]
    for element, line in shown:
        if "plan.png" in element:
            continue  # there is no such image
        name = line.partition(" = ")[0]
        if element:
            plain = {"environments": ["open"], "strategies": ["srt-star"], "name": "x"}
            value = tomllib.loads(f"x = {element}")["x"]
            kind = "strategies" if "srt-" in element else "environments"
            assert runs(ExperimentSpec.from_dict(plain | {kind: [value], "repetitions": 1}), folder)
        elif name in ("robots", "starts", "radios", "bodies", "faults") and "{" in line:
            spec = re.sub(rf"^{name} = .*$", line, rest, count=1, flags=re.MULTILINE)
            read = ExperimentSpec.from_toml(spec.replace("repetitions = 20", "repetitions = 1"))
            assert getattr(read, name) != getattr(ExperimentSpec.from_toml(template.TEMPLATE), name)


@pytest.mark.parametrize("name", PRESETS)
def test_new_like_a_preset(name, call, folder):
    code, _, err = call("new", "paper.toml", "--like", name, "--no-schema")
    assert (code, err) == (0, "")
    text = (folder / "paper.toml").read_text()
    assert ExperimentSpec.from_toml(text) == PRESETS[name].experiment(False)
    assert "#:schema" not in text
    assert not (folder / "experiment.schema.json").exists()


def test_new_does_not_overwrite(call, folder):
    before = (folder / "small.toml").read_text()
    code, out, err = call("new", "small.toml")
    assert (code, out) == (2, "")
    assert err == "error: small.toml exists already; choose another name\n"
    assert (folder / "small.toml").read_text() == before
    assert not (folder / "experiment.schema.json").exists()


def test_new_replaces_only_an_older_schema(call, folder):
    path = folder / "experiment.schema.json"
    path.write_text('{"title": "ExperimentSpec"}')
    assert call("new", "a.toml")[0] == 0
    assert json.loads(path.read_text()) == schema()
    for other in ('{"title": "mine"}', "[]", "no JSON"):
        path.write_text(other)
        code, _, err = call("new", "b.toml")
        assert code == 2
        assert "is no schema of experiments; move it away, or write without one" in err
        assert path.read_text() == other
        assert not (folder / "b.toml").exists()


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("new", "a.txt"), "a.txt must have the suffix .toml"),
        (("new", "a.toml", "--like", "minpoz"), "no preset 'minpoz' (did you mean 'minpos'?)"),
        (("new", "room.wkt/a.toml"), "cannot write room.wkt/a.toml"),
        (("check", "no.toml"), "no.toml: No such file or directory"),
        (("run", "no.toml"), "no.toml: No such file or directory"),
        (("check", "room.wkt"), "room.wkt: not an experiment: "),
        (("run", "small.toml", "--workers", "-1"), "-1 is not in the range x>=0"),
        (
            ("run", "small.toml", "--workers", "2", "--cluster", "tcp://here:1"),
            "give --workers or --cluster, not both",
        ),
        (("run", "small.toml", "--import", "no_such"), "there is no module 'no_such'"),
        (("run", "small.toml", "--store", "room.wkt"), "room.wkt: not a file of results"),
        (("export", "no.sqlite", "a.csv"), "no.sqlite: No such file or directory"),
        (("export", "small.toml", "a.csv"), "small.toml: not a file of results"),
        (("export", "small.toml", "a.xls"), "a table is written as .csv or .parquet"),
    ],
)
def test_bad_input_is_reported_in_one_line(words, told, call, folder):
    there = sorted(folder.iterdir())
    code, out, err = call(*words)
    assert (code, out) == (2, "")
    assert told in err
    assert err.splitlines()[-1].lower().startswith("error: ")
    assert "Traceback" not in err
    assert sorted(folder.iterdir()) == there


# Check ---------------------------------------------------------------------------------------


def test_check_lists_the_conditions(call):
    code, out, err = call("check", "small.toml", "--seconds", "0")
    assert (code, err) == (0, "")
    lines = [line.split() for line in out.splitlines() if line.startswith(" room")]
    assert lines == [
        ["room", "srt-star", "1"],
        ["room", "srt-star", "2"],
        ["room", "srt-radial", "1"],
        ["room", "srt-radial", "2"],
    ]
    assert out.startswith("small: 8 runs, 4 conditions of 2 repetitions (seeds 0 to 1)\n")
    assert "all: starts scattered, radio unlimited, body disc:0.25, faults none" in out
    assert out.endswith("next: multisrt experiment run small.toml\n")
    assert "about" not in out
    assert "informed" not in out


def test_check_counts_the_plans_of_the_reference(call, folder):
    (folder / "beside.toml").write_text('reference = "informed"\n' + SMALL)
    code, out, _ = call("check", "beside.toml", "--seconds", "0")
    assert code == 0
    # Two teams, two seeds; the strategies share them.
    assert "beside the informed plan: at most 4 plans" in out


def test_check_cuts_a_long_table(call, folder):
    (folder / "long.toml").write_text(
        SMALL.replace("[1, 2]", str([*range(1, 8)])) + 'starts = ["scattered", "clustered"]'
    )
    code, out, _ = call("check", "long.toml", "--seconds", "0")
    assert code == 0
    shown = [line for line in out.splitlines() if line.startswith(" room")]
    assert len(shown) == MAX_ROWS - 4
    assert "... and 8 more conditions" in out
    assert max(map(len, out.splitlines())) <= 100


@pytest.mark.slow
def test_check_estimates_from_a_few_runs(call, monkeypatch, measured):
    monkeypatch.setattr(worker.Worker, "make", lambda self, job, tell: _priced(job, measured))
    code, out, err = call("check", "small.toml", "--seconds", "9", "--workers", "1")
    assert (code, err) == (0, "")
    # 2 repetitions of 2 x (0.5 + 1.0) s.
    assert "estimate: 6 s with 1 worker (5 s to 7 s)\n" in out
    assert "from one run each of 4 of 4 conditions, in " in out
    assert re.findall(r"^ room .* (\S+) *$", out, re.MULTILINE) == ["0.5", "1", "0.5", "1"]


@pytest.mark.slow
def test_check_shows_that_kernels_are_compiled(call, monkeypatch, measured):
    shown = []

    def make(self, job, tell):
        tell(Compiling(5, 41))
        tell(Compiled())
        return _priced(job, measured)

    monkeypatch.setattr(worker.Worker, "make", make)
    monkeypatch.setattr(LiveProgress, "update", lambda self, **what: shown.append(what))
    call("check", "small.toml", "--seconds", "9", "--workers", "1")
    assert {"description": "compiling kernels (5 of about 41)"} in shown
    assert shown[-1] == {"description": "runs"}


@pytest.mark.slow
def test_check_warns_of_trial_runs_without_success(call, monkeypatch, measured):
    little = msgspec.structs.replace(measured, coverage=0.3, seen=0.4)
    monkeypatch.setattr(worker.Worker, "make", lambda self, job, tell: _priced(job, little))
    _, _, err = call("check", "small.toml", "--seconds", "9", "--workers", "1")
    told = "warning: [room, srt-star, 1 robot, scattered, unlimited, disc:0.25]"
    assert err.startswith(told)
    assert "complete: covered 30.0 %, seen 40.0 %" in err


def _priced(job: Job, metrics: Metrics) -> Result:
    computing_s = 0.5 * job.condition.robots
    return result_of(job, computing_s=computing_s, wall_s=0.5, metrics=metrics)


def test_check_warns_of_impossible_runs(call, folder):
    (folder / "full.toml").write_text(SMALL.replace("[1, 2]", "[1, 200]"))
    code, out, err = call("check", "full.toml", "--seconds", "0")
    assert code == 0
    assert "full.toml" in out
    warnings = err.splitlines()
    assert len(warnings) == 1
    assert warnings[0].startswith("warning: [room, srt-")
    assert "and 1 more condition: " in warnings[0]
    assert "200 robots" in warnings[0]
    assert "fit at the start" in warnings[0]


def test_check_only_warns_if_another_repetition_can_be_run(call, folder):
    # The base station is in an obstacle of the forest of seed 0 alone.
    (folder / "forest.toml").write_text(
        'name = "forest"\nenvironments = [{ name = "forest", seed = "repetition" }]\n'
        'strategies = ["minpos"]\nrobots = [2]\nrepetitions = 4\n'
        "[base]\nx = 1.5\ny = 11.5\n[stop]\nmax_time_s = 3.0\n"
    )
    code, _, err = call("check", "forest.toml", "--seconds", "0")
    assert code == 0
    assert "the base station (1.5, 11.5) is not in the free space" in err


def test_check_refuses_a_base_station_in_a_wall_and_warns_of_too_little_time(call, folder):
    based = SMALL + "\n[base]\nx = 50.0\ny = 1.0\n"
    (folder / "wall.toml").write_text(based)
    code, _, err = call("check", "wall.toml", "--seconds", "0")
    assert code == 2
    first, refusal = err.splitlines()
    assert first == "error: no run can be made:"
    assert "the base station (50, 1) is not in the free space" in refusal
    assert "the nearest place in free space, 0.25 m from walls, is" in refusal
    home = 'strategies = [{ name = "minpos", options = { home = "in-time" } }, "minpos"]'
    late = re.sub("^strategies = .*$", home, based.replace("50.0", "1.0"), flags=re.MULTILINE)
    (folder / "late.toml").write_text(late + "\n[stop]\nmax_time_s = 5.0\n")
    code, _, err = call("check", "late.toml", "--seconds", "0")
    assert code == 0
    assert err.startswith("warning: [room, minpos (home=in-time), 1 robot")
    assert "the time limit of 5 s is too short to deliver data" in err


# Run -----------------------------------------------------------------------------------------


@pytest.mark.slow
def test_run_stores_results_and_prints_them(call, folder, monkeypatch):
    def run_experiment(store, **_):
        for run in store.missing():
            store.add(make_run(run, store.experiment.limits))

    monkeypatch.setattr(runner, "run_experiment", run_experiment)
    code, out, err = call("run", "small.toml")
    assert (code, err) == (0, "")
    assert out.startswith("small: 8 of 8 runs succeeded (8 complete), in small.sqlite\n")
    assert all(head in out for head in ("success", "95 % (s)", "known (s)", "done (s)"))
    assert "srt-radial" in out
    assert out.endswith("next: multisrt report small.sqlite --out small-report\n")
    code, out, _ = call("export", "small.sqlite", "small.csv")
    assert (code, out) == (0, "small.csv: 8 runs\n")
    assert len((folder / "small.csv").read_text().splitlines()) == 9


def test_incomplete_runs_are_exit_code_3(call, folder, fake_runs):
    fake_runs["status"] = {1: "crashed"}
    code, out, err = call("run", "small.toml", "--store", "r.sqlite", "--workers", "3")
    assert (code, err) == (3, "")
    assert out.startswith("small: 4 of 8 runs succeeded (4 complete, 4 crashed), in r.sqlite\n")
    assert out.count("repetition 1: no reason") == 4
    assert "--retry repeats runs that failed without a result" in out
    assert fake_runs["calls"] == [{"workers": 3, "cluster": None, "modules": ()}]
    # Nothing is left to do, except with --retry.
    fake_runs["status"] = {}
    assert call("run", "small.toml", "--store", "r.sqlite", "--quiet") == (3, "", "")
    code, out, _ = call("run", "small.toml", "--store", "r.sqlite", "--retry")
    assert code == 0
    assert "8 of 8 runs succeeded" in out


def test_an_interrupted_run_reports_and_continues(call, folder, fake_runs):
    fake_runs["stop"] = 3
    code, out, err = call("run", "small.toml")
    assert (code, out) == (130, "")
    assert err.splitlines() == [
        "3 of 8 runs are stored in small.sqlite; the same command continues",
        "interrupted",
    ]
    fake_runs["stop"] = None
    assert call("run", "small.toml", "--quiet") == (0, "", "")
    with Store.open(folder / "small.sqlite") as store:
        assert store.done == 8


def test_a_store_that_cannot_be_removed_hides_no_error(call, folder, fake_runs, monkeypatch):
    def refuses(path):
        raise PermissionError(13, "Permission denied", str(path))

    def locks_the_folder(*args, **options):
        monkeypatch.setattr(Path, "unlink", refuses)
        raise InvalidInputError("cannot write a recording: Permission denied")

    monkeypatch.setattr(runner, "run_experiment", locks_the_folder)
    code, _, err = call("run", "small.toml")
    assert (code, err) == (2, "error: cannot write a recording: Permission denied\n")


def test_no_store_is_left_if_nothing_could_run(call, folder, fake_runs):
    fake_runs["lost"] = 0
    told = (2, "", "error: the cluster is lost\n")
    assert call("run", "small.toml") == told
    assert not list(folder.glob("small.sqlite*"))
    fake_runs["lost"] = 3
    assert call("run", "small.toml") == told
    fake_runs["lost"] = 0
    assert call("run", "small.toml") == told
    with Store.open(folder / "small.sqlite") as store:
        assert store.done == 3


def test_options_of_run_are_passed_on(call, folder, fake_runs):
    (folder / "my_strategies.py").write_text("")
    code, _, err = call(
        *("run", "small.toml", "--recordings", "all", "--cluster", "tcp://host:8786"),
        *("--import", "my_strategies", "--reference", "informed", "--quiet"),
    )
    assert (code, err) == (0, "")
    assert fake_runs["calls"] == [
        {"workers": None, "cluster": "tcp://host:8786", "modules": ("my_strategies",)}
    ]
    with Store.open(folder / "small.sqlite") as store:
        assert store.experiment.recordings == "all"
        assert store.experiment.reference == "informed"
        assert store.folder == folder


def test_long_lists_of_failures_are_cut(call, folder, fake_runs):
    (folder / "many.toml").write_text(SMALL.replace("repetitions = 2", "repetitions = 5"))
    fake_runs["status"] = dict.fromkeys(range(5), "stalled")
    code, out, _ = call("run", "many.toml")
    assert code == 3
    assert out.count("stalled: [room") == 10
    assert "... and 10 more" in out
    assert "--retry" not in out


def test_an_experiment_in_another_folder(call, folder, fake_runs, monkeypatch):
    (folder / "else").mkdir()
    monkeypatch.chdir(folder / "else")
    assert call("run", "../small.toml", "--quiet")[0] == 0
    assert (folder / "small.sqlite").exists()


@pytest.mark.slow
def test_run_with_real_workers(folder):
    """Interrupt worker processes from the keyboard, and continue to the same results."""
    command = [sys.executable, "-m", "multisrt.cli", "experiment", "run", "small.toml"]
    (folder / "small.toml").write_text(SMALL.replace("repetitions = 2", "repetitions = 200"))
    first = subprocess.Popen(
        [*command, "--workers", "1"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    try:
        deadline = time.monotonic() + 300.0
        while time.monotonic() < deadline and not _done(folder / "small.sqlite"):
            time.sleep(0.05)
        os.killpg(first.pid, signal.SIGINT)
        out, err = first.communicate(timeout=60)
    finally:
        first.kill()
        first.wait()
    assert (first.returncode, out) == (130, "")
    # Lines of progress come before it if the first run takes long.
    done = re.search(
        r"^(\d+) of 800 runs are stored in small.sqlite; the same command continues", err, re.M
    )
    assert done is not None, err
    with Store.open(folder / "small.sqlite") as store:
        assert 0 < store.done == int(done[1]) < 800
        kept = {result.key: result.digest for result in store.results()}
        planned = {run.key: run for run in runs(store.experiment, folder)}
    key = next(iter(kept))
    assert make_run(planned[key], store.experiment.limits).digest == kept[key]


def _done(path: Path) -> bool:
    try:
        with Store.open(path) as store:
            return store.done > 0
    except InvalidInputError:
        return False  # not there yet


# Progress ------------------------------------------------------------------------------------


def progress(done, made, elapsed_s, failed=0):
    return Progress(
        total=100, done=done, failed=failed, made=made, elapsed_s=elapsed_s, latest=None
    )


@pytest.mark.parametrize(
    ("now", "told"),
    [
        (progress(0, 0, 0.0), "starting workers"),
        (progress(40, 20, 60.0), "1 200 an hour, 3 min left"),
        (progress(40, 20, 2.0, failed=3), "36 000 an hour, 6 s left, 3 unsuccessful"),
        (progress(100, 20, 60.0), "1 200 an hour"),
        (progress(100, 0, 0.0, failed=1), "1 unsuccessful"),
    ],
)
def test_notes_of_the_progress_bar(now, told):
    assert note_of(now) == told


@pytest.mark.parametrize(
    ("seconds", "told"),
    [
        (0.2, "0 s"),
        (99.4, "99 s"),
        (100.0, "2 min"),
        (5940.0, "99 min"),
        (6000.0, "1.7 h"),
        (170_000.0, "47.2 h"),
        (180_000.0, "2.1 days"),
    ],
)
def test_durations(seconds, told):
    assert duration(seconds) == told


def test_kernels_being_compiled_are_noted_instead_of_the_longest_run():
    spec = ExperimentSpec(name="x", environments=("open",), strategies=("minpos",))
    first, second = (job_of(run, spec) for run in runs(spec)[:2])
    now = progress(0, 0, 0.0)
    with now.under_way.making(first) as tell, now.under_way.making(second) as tell_too:
        assert note_of(now) == "starting workers"
        tell(Compiling(2, 40))
        tell_too(Compiling(5, 41))
        assert note_of(now) == "compiling kernels (5 of about 41)"
        assert line_of(now) == "0 of 100 runs; compiling kernels (5 of about 41)"
        tell_too(Compiled())
        assert note_of(now) == "compiling kernels (2 of about 40)"
        tell(Compiled())
        assert note_of(now) == ""
        assert "has run for" in line_of(now)
        tell(Compiling(3, 40))
    assert now.under_way.compiling() is None


def test_no_bar_without_a_terminal(capsys):
    with LiveProgress() as bar:
        bar(progress(40, 20, 60.0))
        bar.say("something")
    assert capsys.readouterr() == ("", "")


def test_without_a_terminal_a_line_names_the_longest_run(monkeypatch, capsys, tmp_path):
    monkeypatch.setattr(terminal, "FIRST_S", 0.01)
    monkeypatch.setattr(terminal, "EVERY_S", 0.01)
    spec = ExperimentSpec(name="x", environments=("open",), strategies=("minpos",))
    run = runs(spec)[2]
    now = progress(99, 20, 60.0, failed=1)
    with now.under_way.making(job_of(run, spec)), LiveProgress() as bar:
        bar(now)
        time.sleep(0.3)
    told = r"99 of 100 runs, 1 unsuccessful; open, minpos, 1 robot, repetition 2 has run for \d s\n"
    out, err = capsys.readouterr()
    assert out == ""
    assert re.fullmatch(f"({told})+", err)
    assert now.under_way.longest() is None
    with LiveProgress(shown=False) as bar:
        bar(now)
        time.sleep(0.05)
    assert capsys.readouterr() == ("", "")


def test_the_note_of_a_bar_is_renewed_between_runs(monkeypatch):
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True, raising=False)
    monkeypatch.setattr(live, "NOTE_S", 0.01)
    spec = ExperimentSpec(name="x", environments=("open",), strategies=("minpos",))
    now = progress(0, 0, 0.0)
    with LiveProgress() as bar, now.under_way.making(job_of(runs(spec)[0], spec)) as tell:
        bar(now)
        tell(Compiling(5, 41))
        until = time.monotonic() + 5.0
        while bar._now["note"] == "starting workers" and time.monotonic() < until:
            time.sleep(0.01)
        assert bar._now["note"] == "compiling kernels (5 of about 41)"


def test_a_bar_on_a_terminal(monkeypatch, capsys):
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True, raising=False)
    with LiveProgress() as bar:
        bar(progress(40, 20, 60.0))
        bar._bar.refresh()
    out, err = capsys.readouterr()
    assert out == ""
    assert "40/100" in err
    with LiveProgress(shown=False) as bar:
        bar(progress(40, 20, 60.0))
    assert capsys.readouterr() == ("", "")
