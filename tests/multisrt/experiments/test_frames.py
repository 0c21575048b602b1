"""Results as tables: data frames, CSV and Parquet files."""

import csv
import math
import sys

import msgspec
import pandas
import polars
import pyarrow.parquet
import pytest

import multisrt as ms
from multisrt.analysis.metrics import Metrics
from multisrt.experiments.crossing import runs
from multisrt.experiments.frames import columns, export, frame_of, load_results, rows
from multisrt.experiments.measures import MEASURES
from multisrt.experiments.mission import make_run
from multisrt.experiments.results import Result
from multisrt.experiments.spec import ExperimentSpec, Limits
from multisrt.experiments.store import Store
from multisrt.extras import MissingExtraError
from multisrt.geometry.errors import InvalidInputError
from tests.multisrt.experiments.results import metrics_of, result_of
from tests.multisrt.experiments.small import ROOM

SPEC = ExperimentSpec.from_dict(
    {
        "name": "rooms",
        "environments": [{"name": "room, with a comma", "wkt": ROOM}],
        "strategies": ["srt-radial"],
        "robots": [1, 2],
        "repetitions": 2,
        "first_seed": 40,
    }
)


@pytest.fixture(scope="module")
def made() -> Result:
    """A run of two robots."""
    return make_run(runs(SPEC)[1], Limits())


@pytest.fixture
def path(tmp_path, made):
    """Three of four runs: one complete, one without some times, one crashed."""
    one, two, three, _ = runs(SPEC)
    short = msgspec.structs.replace(metrics_of(made), known_complete_s=None, beyond_range_m=None)
    with Store.create_or_open(tmp_path / "results.sqlite", SPEC) as store:
        store.add(result_of(one, "crashed", 'ended by "signal" 9, twice'))
        store.add(made)
        store.add(result_of(three, "stalled", "stands", metrics=short, computing_s=0.5))
    assert two.key == made.key
    return tmp_path / "results.sqlite"


def test_a_frame_has_a_row_for_each_run(path, made):
    frame = load_results(path)
    assert list(frame.columns) == list(columns())
    assert list(frame["status"]) == ["crashed", "complete", "stalled"]
    assert list(frame["robots"]) == [1, 2, 1]
    assert list(frame["repetition"]) == [0, 0, 1]
    assert list(frame["seed"]) == [40, 40, 41]
    assert list(frame["environment"].unique()) == ["room, with a comma"]
    assert frame["coverage"].dtype == "float64"
    assert frame["nodes"].dtype == frame["robots"].dtype == "Int64"
    row = frame.iloc[1]
    assert (row["key"], row["digest"], row["reason"]) == (made.key, made.digest, made.reason)
    for measure in MEASURES:
        value = measure.of(made)
        told = float("nan") if pandas.isna(row[measure.name]) else float(row[measure.name])
        assert told == value or (math.isnan(told) and value is None), measure.name
    assert list(frame["coverage"].isna()) == [True, False, False]
    assert list(frame["nodes"].isna()) == [True, False, False]
    assert list(frame["known_complete_s"].isna()) == [True, False, True]
    assert frame["coverage"].iloc[2] == metrics_of(made).coverage


def test_every_scalar_metric_is_a_column():
    # Determined from values, not from annotated types.
    (run, *_) = runs(SPEC)
    metrics = make_run(run, Limits()).metrics
    plain = {n: v for n, v in msgspec.to_builtins(metrics).items() if isinstance(v, (int, float))}
    assert set(plain) <= set(columns())
    parts = {
        n for n, v in msgspec.to_builtins(metrics).items() if isinstance(v, (list, tuple, dict))
    }
    # The area that was given up is there in total and by reason.
    assert parts & set(columns()) == {"given_up_m2"}
    assert {"given_up_too_narrow_m2", "given_up_blocked_by_a_robot_m2"} <= set(columns())
    assert set(Metrics.__struct_fields__) - parts - set(columns()) == {"outcome"}


def test_csv_reads_back(path, tmp_path):
    assert export(path, tmp_path / "out.csv") == 3
    with (tmp_path / "out.csv").open(newline="") as file:
        read = list(csv.DictReader(file))
    with Store.open(path) as store:
        wanted = list(rows(store.results()))
    assert [list(row) for row in read] == [list(columns())] * 3
    for row, want in zip(read, wanted, strict=True):
        for name, value in want.items():
            if isinstance(value, float):
                assert float(row[name]) == value
            else:
                assert row[name] == ("" if value is None else str(value))


def test_parquet_reads_back(path, tmp_path):
    assert export(path, tmp_path / "out.parquet") == 3
    table = pyarrow.parquet.read_table(tmp_path / "out.parquet")
    with Store.open(path) as store:
        assert table.to_pylist() == list(rows(store.results()))
    kinds = {int: "int64", float: "double", str: "string", bool: "bool"}
    assert {field.name: str(field.type) for field in table.schema} == {
        name: kinds[kind] for name, kind in columns().items()
    }


def test_an_empty_export_has_the_same_columns(tmp_path):
    Store.create_or_open(tmp_path / "r.sqlite", SPEC).close()
    for name in ("a.csv", "a.parquet"):
        assert export(tmp_path / "r.sqlite", tmp_path / name) == 0
    assert (tmp_path / "a.csv").read_text().strip() == ",".join(columns())
    assert pyarrow.parquet.read_table(tmp_path / "a.parquet").column_names == list(columns())
    with Store.open(tmp_path / "r.sqlite") as store:
        frame = frame_of(store.results())
    assert len(frame) == 0
    assert frame["nodes"].dtype == "Int64"
    assert frame["coverage"].dtype == "float64"


def test_load_results_is_public_and_takes_polars(path):
    frame = ms.load_results(path, frame="polars")
    assert frame.shape == (3, len(columns()))
    assert frame["coverage"].dtype == polars.Float64
    assert frame["nodes"].is_null().to_list() == [True, False, False]


# Errors --------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["out.xlsx", "out", "csv"])
def test_unknown_formats_are_refused(name, path, tmp_path):
    with pytest.raises(InvalidInputError, match=r"a table is written as \.csv or \.parquet"):
        export(path, tmp_path / name)
    assert not (tmp_path / name).exists()


def test_files_without_results_are_refused(tmp_path):
    (tmp_path / "x.sqlite").write_text("no results")
    for read in (load_results, lambda path: export(path, tmp_path / "out.csv")):
        with pytest.raises(InvalidInputError, match="not a file of results"):
            read(tmp_path / "x.sqlite")
    assert not (tmp_path / "out.csv").exists()


@pytest.mark.parametrize("name", ["out.csv", "out.parquet"])
def test_a_file_is_written_completely_or_not_at_all(name, path, tmp_path, monkeypatch):
    out = tmp_path / name
    out.write_text("before")
    there = sorted(tmp_path.iterdir())

    def full(*_):
        raise OSError(28, "No space left on device")

    with monkeypatch.context() as patch:
        patch.setattr("multisrt.recording.files.os.replace", full)
        with pytest.raises(InvalidInputError, match=r"cannot write .*: No space left on device"):
            export(path, out)
    assert out.read_text() == "before"
    assert sorted(tmp_path.iterdir()) == there
    export(path, out)
    assert out.read_bytes() != b"before"
    assert sorted(tmp_path.iterdir()) == there
    (tmp_path / "plain").touch()
    assert out.stat().st_mode == (tmp_path / "plain").stat().st_mode


def test_a_missing_folder_is_reported(path, tmp_path):
    with pytest.raises(InvalidInputError, match=r"cannot write .*: No such file or directory"):
        export(path, tmp_path / "no" / "out.csv")


def test_csv_needs_no_other_package_and_parquet_pyarrow(path, tmp_path, monkeypatch):
    for missing in ("pandas", "polars", "pyarrow"):
        monkeypatch.setitem(sys.modules, missing, None)
    with pytest.raises(MissingExtraError, match=r"needs pandas, .*'multisrt\[frames\]'"):
        load_results(path)
    with pytest.raises(MissingExtraError, match=r"needs pyarrow, .*'multisrt\[parquet\]'"):
        export(path, tmp_path / "out.parquet")
    assert not (tmp_path / "out.parquet").exists()
    assert export(path, tmp_path / "out.csv") == 3
