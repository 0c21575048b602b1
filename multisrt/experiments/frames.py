"""Results as tables: data frames, CSV and Parquet."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Literal, get_args, overload

import msgspec

from multisrt.analysis.given_up import LEFT_OPEN, NO_FRONTIER
from multisrt.analysis.metrics import Metrics
from multisrt.events import ArcReason
from multisrt.experiments.crossing import Condition
from multisrt.experiments.measures import MEASURES, Measure
from multisrt.experiments.results import Result, Results
from multisrt.extras import extra
from multisrt.extras.frames import Column, DataFrame, Package, data_frame
from multisrt.geometry.errors import InvalidInputError
from multisrt.recording import atomic_write

if TYPE_CHECKING:
    import pandas
    import polars

Value = bool | int | float | str | None

_GIVEN_UP = {
    f"given_up_{reason.replace(' ', '_')}_m2": reason
    for reason in (*get_args(ArcReason), LEFT_OPEN, NO_FRONTIER)
}
"""Columns of the area that was left uncovered, with their reasons."""

_KINDS: dict[object, type] = {
    bool: bool,
    int: int,
    float: float,
    float | None: float,
    str: str,
}


def columns() -> dict[str, type]:
    """Return the columns of a table of results.

    They are the labels of the condition, the identity and the end of a run, the metrics that are
    a single number, the area left by reason, and the measures computed from them. Integrals
    run to `horizon_s`. `same_as` is the repetition of which a run is a copy, if it is one.

    Returns
    -------
    dict of str to type
        The type of each column: bool, int, float or str.

    Examples
    --------
    >>> list(columns())[:3], columns()["makespan_s"]
    (['environment', 'strategy', 'robots'], <class 'float'>)
    """
    labels: dict[str, type] = dict.fromkeys(Condition.__struct_fields__, str)
    return {
        **labels,
        "robots": int,
        "repetition": int,
        "seed": int,
        "status": str,
        "reason": str,
        "success": bool,
        "digest": str,
        "key": str,
        "chance": bool,
        "same_as": int,
        "horizon_s": float,
        "computing_s": float,
        "wall_s": float,
        "memory_mb": float,
        **_scalars(),
        **dict.fromkeys(_GIVEN_UP, float),
        **{measure.name: float for measure in _computed()},
    }


def _computed() -> list[Measure]:
    """Return the measures that are neither a metric nor reported for every run."""
    return [m for m in MEASURES if m.name not in _scalars() and m.name not in _OF_RESULTS]


def _scalars() -> dict[str, type]:
    return {
        field.name: _KINDS[field.type]
        for field in msgspec.structs.fields(Metrics)
        if field.type in _KINDS
    }


def rows(results: Results) -> Iterator[dict[str, Value]]:
    """Yield one row for each run.

    Parameters
    ----------
    results : Results
        The results.

    Yields
    ------
    dict
        Values by the names of `columns`, None where the run has none; runs in the experiment's
        order.
    """
    scalars, computed = _scalars(), _computed()
    for result in results:
        yield {
            **{name: getattr(result.condition, name) for name in Condition.__struct_fields__},
            "repetition": result.repetition,
            "seed": results.experiment.first_seed + result.repetition,
            **{name: getattr(result, name) for name in _OF_RESULTS},
            **{name: _metric(result, name) for name in scalars},
            **{name: _given_up(result, reason) for name, reason in _GIVEN_UP.items()},
            **{measure.name: measure.of(result) for measure in computed},
        }


_OF_RESULTS = (
    "status",
    "reason",
    "success",
    "digest",
    "key",
    "chance",
    "same_as",
    "horizon_s",
    "computing_s",
    "wall_s",
    "memory_mb",
)


def _given_up(result: Result, reason: str) -> float | None:
    return None if result.metrics is None else result.metrics.given_up_m2.get(reason, 0.0)


def _metric(result: Result, name: str) -> Value:
    return None if result.metrics is None else getattr(result.metrics, name)


def frame_of(results: Results, frame: Package | None = None) -> DataFrame:
    """Return results as a data frame.

    Parameters
    ----------
    results : Results
        The results.
    frame : {"pandas", "polars"}, optional
        Library of the data frame; by default pandas if it is installed, else polars.

    Returns
    -------
    pandas.DataFrame or polars.DataFrame
        One row for each run, with the columns of `columns`.

    Raises
    ------
    InvalidInputError
        If there is no such package of data frames.
    MissingExtraError
        If it is not installed.
    """
    made = list(rows(results))
    return data_frame(
        {name: Column(kind, [row[name] for row in made]) for name, kind in columns().items()},
        frame,
    )


@overload
def load_results(
    path: str | Path, *, frame: Literal["pandas"] | None = None
) -> pandas.DataFrame: ...


@overload
def load_results(path: str | Path, *, frame: Literal["polars"]) -> polars.DataFrame: ...


def load_results(path: str | Path, *, frame: Package | None = None) -> DataFrame:
    """Read the results of an experiment as a data frame.

    Parameters
    ----------
    path : str or Path
        The file written by ``multisrt experiment run`` or `compare`, which may still be running.
    frame : {"pandas", "polars"}, optional
        Library of the data frame; by default pandas if it is installed, else polars.

    Returns
    -------
    pandas.DataFrame or polars.DataFrame
        One row for each run: labels of its condition, how it ended, metrics and measures.

    Raises
    ------
    InvalidInputError
        If the file contains no results, or `frame` is not supported.
    MissingExtraError
        If neither pandas nor polars is installed (``multisrt[frames]``).

    Examples
    --------
    >>> import multisrt as ms
    >>> frame = ms.load_results("results.sqlite")  # doctest: +SKIP
    >>> frame.groupby(["strategy", "robots"])["known_complete_s"].median()  # doctest: +SKIP
    """
    return frame_of(_stored(path), frame)


def export(path: str | Path, out: str | Path) -> int:
    """Write the results of an experiment as a table, one row for each run.

    Parameters
    ----------
    path : str or Path
        File of the results.
    out : str or Path
        File of the table, ``.csv`` or ``.parquet``; it is written completely or not at all, and
        replaced if it exists.

    Returns
    -------
    int
        Number of rows.

    Raises
    ------
    InvalidInputError
        If the suffix is another one, the results cannot be read, or the file cannot be written.
    MissingExtraError
        If pyarrow is missing, which Parquet needs (``multisrt[parquet]``).
    """
    out = Path(out)
    encode = {".csv": _csv, ".parquet": _parquet}.get(out.suffix)
    if encode is None:
        raise InvalidInputError(f"{out}: a table is written as .csv or .parquet; name one of them")
    made = list(rows(_stored(path)))
    with atomic_write(out) as file:
        file.write(encode(made))
    return len(made)


def _stored(path: str | Path) -> Results:
    from multisrt.experiments.store import Store

    with Store.open(path) as store:
        return store.results()


def _csv(made: Sequence[dict[str, Value]]) -> bytes:
    text = io.StringIO(newline="")
    writer = csv.DictWriter(text, list(columns()), lineterminator="\n")
    writer.writeheader()
    writer.writerows(made)
    return text.getvalue().encode()


def _parquet(made: Sequence[dict[str, Value]]) -> bytes:
    with extra("parquet", "a Parquet file"):
        import pyarrow as arrow
        from pyarrow import parquet

    kinds = {int: arrow.int64(), float: arrow.float64(), str: arrow.string(), bool: arrow.bool_()}
    fields = [arrow.field(name, kinds[kind]) for name, kind in columns().items()]
    file = io.BytesIO()
    parquet.write_table(arrow.Table.from_pylist(list(made), schema=arrow.schema(fields)), file)
    return file.getvalue()
