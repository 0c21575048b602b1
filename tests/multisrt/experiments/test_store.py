import math
import os
import sqlite3
from typing import Any

import msgspec
import pytest

from multisrt.experiments.crossing import runs
from multisrt.experiments.mission import make_run
from multisrt.experiments.spec import ExperimentSpec, Limits, StrategyChoice
from multisrt.experiments.store import Store
from multisrt.experiments.store_file import FORMAT, LOG, labels_in
from multisrt.geometry.errors import InvalidInputError
from tests.multisrt.experiments.results import metrics_of, result_of

SPEC = ExperimentSpec(
    name="small",
    environments=("open", "rooms"),
    strategies=("srt-radial", "srt-star"),
    robots=(1, 2),
    repetitions=2,
    limits=Limits(computing_s=10.0, memory_mb=500),
)


def changed(**fields: Any) -> ExperimentSpec:
    return msgspec.structs.replace(SPEC, **fields)


@pytest.fixture
def filled(path):
    """Path of a store in which the first three runs have results."""
    with Store.create_or_open(path, SPEC) as store:
        for run in store.missing()[:3]:
            store.add(result_of(run))
    return path


# Storing results -----------------------------------------------------------------------------


def test_a_reader_folds_in_a_log_that_no_writer_needs(path):
    log = path.with_name(path.name + "-wal")
    with Store.create_or_open(path, SPEC) as writer:
        writer.add(result_of(writer.missing()[0]))
        with Store.open(path) as reader:
            assert reader.done == 1
        assert log.exists()
        # What a killed writer leaves: its files as they are, and no process that holds them.
        left = {end: path.with_name(path.name + end).read_bytes() for end in ("", *LOG)}
    assert not log.exists()
    copy = path.with_name("left.sqlite")
    for end, content in left.items():
        copy.with_name(copy.name + end).write_bytes(content)
    for _ in range(2):
        with Store.open(copy) as reader:
            assert reader.done == 1
        assert not any(copy.with_name(copy.name + end).exists() for end in LOG)


def test_results_are_read_back_unchanged(path):
    first, second, *_ = runs(SPEC)
    made = make_run(first, SPEC.limits)
    made = made.to_horizon(metrics_of(made).makespan_s)
    crashed = result_of(second, "crashed", wall_s=1.5)
    with Store.create_or_open(path, SPEC) as store:
        store.add(crashed)
        store.add(made)
        assert store.results().results == (made, crashed)
        assert (store.done, store.failed, store.planned) == (2, 1, 16)
    with Store.open(path) as store:
        results = store.results()
    assert results.results == (made, crashed)
    assert results.experiment == SPEC
    assert results.planned == 16
    assert results.provenance.program == store.provenance.program


def test_a_collision_counts_as_failed(path):
    run = runs(SPEC)[0]
    made = make_run(run, SPEC.limits)
    metrics = msgspec.structs.replace(metrics_of(made), collisions=1)
    with Store.create_or_open(path, SPEC) as store:
        store.add(msgspec.structs.replace(made, metrics=metrics))
        assert store.failed == 1 == sum(result.failed for result in store.results())


def test_missing_runs_are_in_the_experiments_order(filled):
    every = runs(SPEC)
    with Store.create_or_open(filled, SPEC) as store:
        assert store.missing() == every[3:]
        store.add(result_of(every[10]))
        assert store.missing() == every[3:10] + every[11:]
        assert [r.key for r in store.results()] == [r.key for r in (*every[:3], every[10])]
    with Store.open(filled) as store:
        assert store.missing() == every[3:10] + every[11:]


def test_a_result_is_stored_once(filled):
    first = runs(SPEC)[0]
    with Store.create_or_open(filled, SPEC) as store:
        store.add(result_of(first, "crashed"))
        assert store.done == 3
        assert store.results().results[0].status == "complete"


def test_results_of_runs_of_another_experiment_are_taken(path, tmp_path):
    with Store.create_or_open(path, changed(first_seed=1)) as other:
        for run in other.missing()[:3]:
            other.add(result_of(run, wall_s=3.0))
        made = {run.key: run for run in other.results()}
    # A seed earlier, with another label, and without the other strategy.
    again = StrategyChoice(name="srt-radial", label="again")
    with Store.create_or_open(tmp_path / "own.sqlite", changed(strategies=(again,))) as store:
        asked = {run.key: run for run in store.runs()}
        common = made.keys() & asked.keys()
        assert 0 < len(common) < 3
        with Store.open(path) as other:
            assert store.take_from(other) == len(common)
            assert store.take_from(other) == 0
        taken = store.results()
        assert {result.key for result in taken} == common
        for result in taken:
            run, old = asked[result.key], made[result.key]
            assert result.condition == run.condition != old.condition
            assert result.repetition == run.repetition == old.repetition + 1
            assert result.wall_s == 3.0
        assert len(store.missing()) == len(asked) - len(common)


def test_runs_without_a_result_or_of_another_program_are_not_taken(path, tmp_path, monkeypatch):
    with Store.create_or_open(path, SPEC) as other:
        other.add(result_of(other.missing()[0], "crashed"))
        with Store.create_or_open(tmp_path / "same.sqlite", SPEC) as store:
            assert store.take_from(other) == 0
            mine = msgspec.structs.replace(store.provenance, program="another")
            monkeypatch.setattr(store, "provenance", mine)
            with pytest.raises(InvalidInputError, match="another program"):
                store.take_from(other)


def test_results_can_be_deleted_by_status(filled):
    every = runs(SPEC)
    with Store.create_or_open(filled, SPEC) as store:
        store.add(result_of(every[5], "crashed"))
        store.add(result_of(every[6], "stalled"))
        assert store.forget() == 1
        assert every[5] in store.missing()
        assert store.forget(["stalled"]) == 1
        assert store.done == 3


def test_a_closed_store_is_one_file(filled):
    assert [file.name for file in filled.parent.iterdir()] == ["results.sqlite"]


def test_a_store_can_be_read_in_a_read_only_folder(filled):
    filled.chmod(0o444)
    filled.parent.chmod(0o555)
    try:
        with Store.open(filled) as store:
            assert store.done == 3
    finally:
        filled.parent.chmod(0o755)


def test_readers_and_a_writer_do_not_block_each_other(filled):
    with Store.create_or_open(filled, SPEC) as writer:
        with Store.open(filled) as reader:
            assert reader.done == 3
            writer.add(result_of(writer.missing()[0]))
            assert reader.done == 4
            assert len(reader.results()) == 4
        with Store.open(filled) as reader:
            writer.close()
            assert reader.done == 4
    with Store.open(filled) as store:
        assert store.done == 4


def test_partial_recordings_are_removed(path):
    with Store.create_or_open(path, SPEC) as store:
        whole = store.recording_path("abc")
        part = whole.with_name("def.jsonl.part")
        whole.write_text("{}")
        part.write_text("{")  # as of a run whose process is ended by an interrupt
    assert not part.exists()
    part.write_text("{")  # as by a process that was killed
    with Store.create_or_open(path, SPEC):
        assert whole.exists()
        assert not part.exists()


# Continuing ----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "more",
    [
        {"repetitions": 3},
        {"robots": (4, 2, 1)},
        {"environments": ("office", "rooms", "open")},
        {"name": "renamed", "about": "to see", "recordings": "all"},
        {"limits": Limits(computing_s=20.0, memory_mb=500)},
    ],
)
def test_an_experiment_may_grow(filled, more):
    spec = changed(**more)
    with Store.create_or_open(filled, spec) as store:
        assert store.done == 3
        assert len(store.missing()) == len(runs(spec)) - 3
    with Store.open(filled) as store:
        assert store.experiment == spec
        assert store.planned == len(runs(spec))
        order = [run.key for run in runs(spec)]
        keys = [result.key for result in store.results()]
        assert keys == sorted(keys, key=order.index)


def test_new_labels_replace_stored_ones(filled):
    spec = ExperimentSpec.from_json(
        SPEC.to_json().replace('"srt-radial"', '{"name": "srt-radial", "label": "ours"}')
    )
    with Store.create_or_open(filled, spec) as store:
        assert {r.condition.strategy for r in store.results()} == {"ours", "srt-star"}


def test_repetitions_follow_a_new_first_seed(path):
    with Store.create_or_open(path, changed(first_seed=1)) as store:
        store.add(result_of(store.missing()[0]))
    with Store.create_or_open(path, SPEC) as store:
        assert [result.repetition for result in store.results()] == [1]


@pytest.mark.parametrize(
    ("less", "said"),
    [
        ({"strategies": ("srt-star",)}, "strategies"),
        ({"environments": ("rooms",), "robots": (1, 2, 3)}, "environments, robots"),
        ({"first_seed": 7}, "first_seed"),
    ],
)
def test_another_experiment_is_refused(filled, less, said):
    with pytest.raises(InvalidInputError, match=rf"another experiment: .*\(what differs: {said}\)"):
        Store.create_or_open(filled, changed(**less))
    with Store.create_or_open(filled, SPEC) as store:  # unchanged, and not locked
        assert store.done == 3


def test_fewer_repetitions_than_stored_are_refused(filled):
    with Store.create_or_open(filled, changed(repetitions=1)) as store:
        assert len(store.missing()) == 5
    with Store.create_or_open(filled, SPEC) as store:
        store.add(result_of(runs(SPEC)[-1]))
    with pytest.raises(InvalidInputError, match=r"1 of its 4 runs .*repetitions"):
        Store.create_or_open(filled, changed(repetitions=1))


def test_higher_limits_repeat_runs_that_exceeded_them(filled):
    every = runs(SPEC)
    with Store.create_or_open(filled, SPEC) as store:
        store.add(result_of(every[8], "over_time"))
        store.add(result_of(every[9], "over_memory"))
    with Store.create_or_open(filled, changed(limits=Limits(computing_s=20, memory_mb=500))) as s:
        assert every[8] in s.missing()
        assert every[9] not in s.missing()
    with pytest.raises(InvalidInputError, match=r"allowed more \(limits.computing_s\)"):
        Store.create_or_open(filled, SPEC)


# Errors --------------------------------------------------------------------------------------


def doctored(path, statement, *values):
    connection = sqlite3.connect(path)
    with connection:
        connection.execute(statement, values)
    connection.close()


def both_ways(path, match):
    with pytest.raises(InvalidInputError, match=match):
        Store.open(path)
    with pytest.raises(InvalidInputError, match=match):
        Store.create_or_open(path, SPEC)


def test_other_files_are_refused(tmp_path, path):
    with pytest.raises(InvalidInputError, match="No such file"):
        Store.open(path)
    both_ways(tmp_path, "is a folder; name the file of results in it")
    path.write_text("key,status\n")
    both_ways(path, "not a file of results")
    assert path.read_text() == "key,status\n"


def test_missing_folders_are_made(tmp_path):
    path = tmp_path / "new" / "newer" / "x.sqlite"
    with Store.create_or_open(path, SPEC) as store:
        assert store.done == 0
    assert [file.name for file in path.parent.iterdir()] == ["x.sqlite"]
    with pytest.raises(InvalidInputError, match=r"cannot create the folder .*x.sqlite.more: .*; c"):
        Store.create_or_open(path / "more" / "y.sqlite", SPEC)


def test_an_empty_file_becomes_a_store(path):
    path.touch()
    with pytest.raises(InvalidInputError, match="not a file of results"):
        Store.open(path)
    with Store.create_or_open(path, SPEC) as store:
        assert store.done == 0


def test_other_databases_are_refused(path):
    doctored(path, "CREATE TABLE runs (key TEXT)")
    before = path.read_bytes()
    both_ways(path, "an SQLite file, but not one of results")
    assert path.read_bytes() == before


@pytest.mark.parametrize(
    ("version", "which"), [(FORMAT + 1, "a newer version"), (FORMAT - 1, "an older version")]
)
def test_other_formats_are_refused(filled, version, which):
    doctored(filled, f"PRAGMA user_version = {version}")
    both_ways(filled, rf"results in format {version}, of {which} of multisrt")


def test_a_damaged_file_is_reported(filled):
    content = bytearray(filled.read_bytes())
    content[4096:] = os.urandom(len(content) - 4096)
    filled.write_bytes(content)
    with pytest.raises(InvalidInputError, match="damaged file of results"), Store.open(filled) as s:
        s.results()


def test_a_damaged_row_is_reported(filled):
    doctored(filled, "UPDATE runs SET metrics = '{}'")
    with (
        Store.open(filled) as store,
        pytest.raises(InvalidInputError, match=r"the result of run '\w+' is damaged"),
    ):
        store.results()


@pytest.mark.parametrize(
    "change",
    [
        "CREATE VIEW more AS SELECT * FROM runs",
        "CREATE TRIGGER more AFTER INSERT ON runs BEGIN DELETE FROM runs; END",
        "ALTER TABLE runs ADD COLUMN more",
        "DROP TABLE runs",
    ],
)
def test_tables_that_are_not_ours_are_refused(filled, change):
    doctored(filled, change)
    assert labels_in(filled) == []
    with pytest.raises(InvalidInputError, match="its tables are not those that multisrt makes"):
        Store.open(filled)
    with pytest.raises(InvalidInputError, match="its tables are not those that multisrt makes"):
        Store.create_or_open(filled, SPEC)


def test_a_key_that_its_index_lacks_is_told(filled):
    with sqlite3.connect(filled) as connection:
        (key,) = connection.execute("SELECT key FROM runs ORDER BY position").fetchone()
    content = filled.read_bytes()
    assert content.count(key.encode()) == 2  # in the table, and in its index
    at = content.index(key.encode() + b"open")
    filled.write_bytes(content[:at] + b"?" + content[at + 1 :])
    with pytest.raises(InvalidInputError, match="is in its table and not in its index"):
        Store.create_or_open(filled, SPEC)


def test_names_of_tables_that_are_no_text_are_told(filled):
    filled.write_bytes(filled.read_bytes().replace(b"TABLE runs", b"TABLE r\xc7ns"))
    assert labels_in(filled) == []
    with pytest.raises(InvalidInputError, match="a damaged file of results"):
        Store.open(filled)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('"program":"', '"program":"0', "another source of multisrt"),
        ('"numpy":"', '"numpy":"0', "numpy 0"),
    ],
)
def test_results_of_another_version_are_not_continued(filled, old, new, said):
    doctored(
        filled, "UPDATE meta SET value = replace(value, ?, ?) WHERE name = 'provenance'", old, new
    )
    with pytest.raises(InvalidInputError, match=rf"made by another program \({said}"):
        Store.create_or_open(filled, SPEC)
    with Store.open(filled) as store:  # reading them is allowed
        assert store.done == 3


def test_a_second_writer_is_refused(filled):
    holder = rf"another process .*\(process {os.getpid()}\)"
    with (
        Store.create_or_open(filled, SPEC),
        pytest.raises(InvalidInputError, match=holder),
    ):
        Store.create_or_open(filled, SPEC)
    with Store.create_or_open(filled, SPEC) as store:
        assert store.done == 3


def test_an_impossible_experiment_leaves_no_file(path):
    with pytest.raises(InvalidInputError, match="there is no strategy"):
        Store.create_or_open(path, changed(strategies=("nonsense",)))
    assert not path.exists()


def test_a_full_database_is_reported_and_stays_sound(filled):
    with Store.create_or_open(filled, SPEC) as store:
        pages = store._connection.execute("PRAGMA page_count").fetchone()[0]
        store._connection.execute(f"PRAGMA max_page_count = {pages}")
        results = [result_of(run, covered_at_s=(math.pi,) * 101) for run in store.missing()]
        with pytest.raises(
            InvalidInputError, match=r"the disk is full; .*the same command continues"
        ):
            any(map(store.add, results))  # `add` returns None: all are added
        done = store.done
        assert 3 <= done < 16
    with Store.create_or_open(filled, SPEC) as store:
        assert len(store.missing()) == 16 - done
        assert store._connection.execute("PRAGMA integrity_check").fetchone() == ("ok",)
