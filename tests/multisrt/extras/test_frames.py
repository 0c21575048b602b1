"""Data frames of both packages hold the same."""

import numpy as np
import pandas
import polars
import pytest

from multisrt.extras.frames import Column, data_frame
from multisrt.geometry.errors import InvalidInputError

COLUMNS = {
    "robot": Column(int, [0, None]),
    "x_m": Column(float, [0.5, None]),
    "time_s": Column(float, np.array([1.0, 2.0])),
    "purpose": Column(str, ["explore", None]),
    "success": Column(bool, [True, None]),
}


def test_pandas_keeps_whole_numbers_that_are_missing():
    frame = data_frame(COLUMNS)
    assert isinstance(frame, pandas.DataFrame)
    assert [str(one) for one in frame.dtypes] == [
        "Int64",
        "float64",
        "float64",
        "object",
        "boolean",
    ]
    assert frame["robot"].isna().tolist() == [False, True]


def test_polars_has_the_same_columns_and_values():
    frame = data_frame(COLUMNS, "polars")
    assert frame.schema == {
        "robot": polars.Int64,
        "x_m": polars.Float64,
        "time_s": polars.Float64,
        "purpose": polars.String,
        "success": polars.Boolean,
    }
    assert frame.rows() == [(0, 0.5, 1.0, "explore", True), (None, None, 2.0, None, None)]


@pytest.mark.parametrize("package", ["pandas", "polars"])
def test_tables_without_rows_keep_their_columns(package):
    frame = data_frame({name: Column(kind, []) for name, (kind, _) in COLUMNS.items()}, package)
    assert list(frame.columns) == list(COLUMNS)
    assert len(frame) == 0


def test_other_packages_are_refused():
    with pytest.raises(InvalidInputError, match='"pandas" or "polars", not \'dask\''):
        data_frame(COLUMNS, "dask")  # type: ignore[arg-type]
