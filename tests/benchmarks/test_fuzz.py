import copy
import ctypes
import json
import os
import re
import signal
import sqlite3
import time
import tomllib
import warnings
from contextlib import closing, suppress

import numpy as np
import pytest
import shapely

from benchmarks.fuzz import judging
from benchmarks.fuzz.command import main, report_of, shares, write
from benchmarks.fuzz.flaws import flaw_of_message, flaw_of_world
from benchmarks.fuzz.judging import Outcome, Verdict, judge
from benchmarks.fuzz.mutations import MAX_BYTES, of_text
from benchmarks.fuzz.processes import Campaign
from benchmarks.fuzz.report import Report
from benchmarks.fuzz.tables import of_sqlite
from benchmarks.fuzz.target import Target
from benchmarks.fuzz.targets import TARGETS
from benchmarks.fuzz.trees import changed, of_json, of_toml
from multisrt.environments.environment import Environment
from multisrt.geometry.errors import MapFormatError

HALL = Environment("hall", shapely.box(0, 0, 4, 3))


def crash(path):
    raise ZeroDivisionError("none of ours")


def abort(path):
    signal.signal(signal.SIGABRT, signal.SIG_DFL)
    os.kill(os.getpid(), signal.SIGABRT)


def hang(path):
    signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGINT])
    while True:
        ctypes.pythonapi.Py_IsInitialized()


def swell(path):
    return Environment("hall", shapely.box(0, 0, len(b"x" * 1_200_000_000), 3))


def swallow(path):
    try:
        np.zeros(2**50)
    except MemoryError as error:
        raise MapFormatError(f"{path} is damaged") from error


def warn(path):
    warnings.warn("a surprise", RuntimeWarning, stacklevel=1)
    return HALL


def say(message):
    def refuse(path):
        raise MapFormatError(message.format(path=path))

    return refuse


def target_of(read):
    return Target(name="wkt", read=read)


@pytest.mark.parametrize(
    ("read", "verdict"),
    [
        (lambda path: HALL, Verdict.READ),
        (say("{path}, line 1 is wrong; mend it"), Verdict.REFUSED),
        (say("line 1 is wrong"), Verdict.MESSAGE),
        (say("{path}: <ast.Compare object at 0x7f04>"), Verdict.MESSAGE),
        (say("{path} is " + "very " * 300 + "wrong"), Verdict.MESSAGE),
        (crash, Verdict.CRASH),
        (swallow, Verdict.MEMORY),
        (warn, Verdict.WARNING),
    ],
)
def test_each_outcome_has_its_verdict(read, verdict, tmp_path):
    target = target_of(read)
    assert judge(target, target.input(0, 0), tmp_path).verdict is verdict


def test_messages_are_one_line_that_names_a_file(tmp_path):
    folder = (str(tmp_path),)
    assert not flaw_of_message(f"{tmp_path}/a.wkt is wrong", folder)
    assert "one line" in flaw_of_message(f"{tmp_path}/a.wkt\nis wrong", folder)
    assert "one line" in flaw_of_message(f"{tmp_path}/a.wkt \x1b[2J", folder)
    assert "does not name" in flaw_of_message("line 1 is wrong", folder)


def test_flaws_of_worlds_are_found():
    assert not flaw_of_world(HALL)
    # A name may be anything; what the package says of a world may not.
    assert not flaw_of_world(Environment("a\nb", shapely.box(0, 0, 4, 3)))
    strange = Environment("a", shapely.box(0, 0, 4, 3), origin="a\nb")
    assert "printable" in flaw_of_world(strange)


def test_inputs_follow_from_their_number():
    for target in TARGETS.values():
        numbers = range(len(target.seeds), len(target.seeds) + 30)
        first = [target.input(3, number) for number in numbers]
        assert first == [target.input(3, number) for number in numbers]
        assert first != [target.input(4, number) for number in numbers]
        assert max(len(one.content) for one in first) <= MAX_BYTES + 8


def test_numbers_are_multiplied_however_long_they_are():
    text = b"1.4453986005980007e+00"
    changes = {of_text(text, np.random.default_rng(k), [text], [b"x"]) for k in range(2000)}
    multiplied = [c for c in changes if re.fullmatch(rb"-?[0-9.]+", c)]
    assert len(multiplied) > 20


def test_the_first_inputs_are_the_seeds():
    target = TARGETS["geojson"]
    found = [target.input(9, number).content for number in range(len(target.seeds))]
    assert found == [content for _, content in target.seeds]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("fault", "verdict"),
    [(hang, Verdict.HANG), (abort, Verdict.CRASH), (swell, Verdict.MEMORY)],
)
def test_processes_that_end_are_replaced(fault, verdict, tmp_path, monkeypatch):
    monkeypatch.setattr("benchmarks.fuzz.processes.MAX_SECONDS", 4.0)
    calls = tmp_path / "calls"
    target = target_of(lambda path: HALL)
    numbers = range(len(target.seeds), len(target.seeds) + 9)
    bad = target.input(0, numbers[4]).content

    def read(path):
        return fault(path) if path.read_bytes() == bad else HALL

    campaign = Campaign(target=target_of(read), seed=0, numbers=numbers, workers=2)
    report = report_of(campaign, calls)
    assert report.counts == {Verdict.READ: 8, verdict: 1}
    assert list(report.faults.values()) == [[numbers[4]]]
    assert [path.read_bytes() for path in calls.iterdir()] == [bad]


def test_faults_that_are_alike_are_told_once(tmp_path):
    report = Report(TARGETS["wkt"])
    for number in range(5):
        report.add(number, Outcome(Verdict.CRASH, detail=f"ValueError: {number} (wkt.py:7)"))
    assert not report.add(5, Outcome(Verdict.READ, 0.5))
    assert report.slowest == (0.5, 5)
    assert len(list(report.failures())) == 1
    assert "5 x crash: ValueError: 0 (wkt.py:7) (number 0, 1, 2)" in next(report.failures())
    assert write(report.target, 0, 7, tmp_path).name == "wkt-0-7.wkt"


def test_shares_add_up():
    assert shares(1000, 14) == sorted(shares(1000, 14))
    assert sum(shares(1000, 14)) == 1000


def test_the_command_prints_a_table_and_reads_again(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(SystemExit) as ended:
        main(["--inputs", "20", "--format", "wkt"])
    assert ended.value.code == 0
    title, row, total = capsys.readouterr().out.splitlines()
    assert title.split()[:4] == ["format", "inputs", "read", "refused"]
    assert row.split()[:2] == ["wkt", "20"]
    assert total == "20 inputs of 1 format, 0 failed"
    with pytest.raises(SystemExit):
        main(["--format", "wkt", "--number", "1"])
    assert "read in" in capsys.readouterr().out
    assert (tmp_path / "out/fuzz/wkt-0-1.wkt").is_file()


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--inputs", "0"], "'0' is not a whole number of at least 1"),
        (["--inputs", "-5"], "'-5' is not a whole number of at least 1"),
        (["--inputs", "many"], "'many' is not a whole number of at least 1"),
        (["--inputs", "1", "--format", "wkt", "--format", "svg"], "less than one for each of 2"),
        (["--workers", "0"], "'0' is not a whole number of at least 1"),
        (["--format", "svg", "--number", "-3"], "'-3' is not a whole number of at least 0"),
    ],
)
def test_numbers_out_of_bounds_are_refused(words, said, capsys):
    with pytest.raises(SystemExit) as ended:
        main(words)
    assert ended.value.code == 2
    assert said in capsys.readouterr().err


def test_the_command_writes_a_page(tmp_path):
    path = tmp_path / "fuzz.md"
    with pytest.raises(SystemExit):
        main(["--inputs", "10", "--seed", "3", "--format", "wkt", "--page", str(path)])
    lines = path.read_text().splitlines()
    assert lines[2].startswith("10 inputs of 1 format, 0 failed.")
    assert [line.split()[1:4] for line in lines if line.startswith("| `wkt`")] == [
        ["`wkt`", "|", "10"]
    ]
    made_by = "python -m benchmarks.fuzz --inputs 10 --seed 3 --format wkt"
    assert f"{made_by} --page docs/results/fuzz.md" in lines


def test_trees_are_changed_and_written_again():
    rng = np.random.default_rng(1)
    before = {"a": [1, 2, {"b": None}], "c": "text"}
    found = {json.dumps(changed(copy.deepcopy(before), rng)) for _ in range(200)}
    assert len(found) > 100
    for mutate, read in ((of_toml, tomllib.loads), (of_json, json.loads)):
        text = b'{"a": [1, 2]}' if mutate is of_json else b"a = [1, 2]"
        made = [mutate(text, rng, [text], ()) for _ in range(50)]
        assert sum(_can(read, content.decode(errors="replace")) for content in made) > 20


def _can(read, content):
    try:
        read(content)
    except ValueError:
        return False
    return True


def test_stores_are_made_of_sql_and_damaged_as_tables():
    target = TARGETS["campaign_store"]
    [(suffix, content)] = target.seeds
    assert suffix == ".sqlite"
    rng = np.random.default_rng(1)
    opened = 0
    for _ in range(50):
        with closing(sqlite3.connect(":memory:")) as connection:
            connection.deserialize(of_sqlite(content, rng, [content], target.words))
            with suppress(sqlite3.Error, UnicodeDecodeError):
                opened += bool(connection.execute("SELECT count(*) FROM sqlite_master").fetchone())
    assert opened > 30


def test_the_limit_of_time_counts_the_processor(tmp_path, monkeypatch):
    monkeypatch.setattr(judging, "MAX_SECONDS", 0.01)

    def slow(path):
        begin = time.process_time()
        while time.process_time() - begin < 0.02:
            pass
        return HALL

    target = target_of(slow)
    assert judge(target, target.input(0, 0), tmp_path).verdict is Verdict.HANG
