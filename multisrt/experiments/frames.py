"""Results as rows: CSV, Parquet, and frames of pandas."""

from __future__ import annotations

import csv
import io
import os
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import msgspec

from multisrt.analysis.metrics import Metrics
from multisrt.experiments.crossing import Condition
from multisrt.experiments.measures import MEASURES
from multisrt.experiments.results import Result, Results
from multisrt.geometry.errors import InvalidInputError

if TYPE_CHECKING:
    import pandas

Value = bool | int | float | str | None

_KINDS: dict[object, type] = {
    bool: bool,
    int: int,
    float: float,
    float | None: float,
    str: str,
}


def columns() -> dict[str, type]:
    """Give the columns of a frame of results, and what each holds.

    A condition's labels, what a run is and how it ended, its metrics that are a single number,
    and the measures that are computed from them.
    """
    labels: dict[str, type] = dict.fromkeys(Condition.__struct_fields__, str)
    return {
        **labels,
        "robots": int,
        "repetition": int,
        "seed": int,
        "status": str,
        "reason": str,
        "digest": str,
        "key": str,
        "computing_s": float,
        "wall_s": float,
        "memory_mb": float,
        **_scalars(),
        **{measure.name: float for measure in MEASURES if measure.name not in _scalars()},
    }


def _scalars() -> dict[str, type]:
    return {
        field.name: _KINDS[field.type]
        for field in msgspec.structs.fields(Metrics)
        if field.type in _KINDS
    }


def rows(results: Results) -> Iterator[dict[str, Value]]:
    """Give a row for each run, in the experiment's order; None where it has no value."""
    scalars = _scalars()
    others = [measure for measure in MEASURES if measure.name not in scalars]
    for result in results:
        yield {
            **{name: getattr(result.condition, name) for name in Condition.__struct_fields__},
            "repetition": result.repetition,
            "seed": results.experiment.first_seed + result.repetition,
            **{name: getattr(result, name) for name in _OF_RESULTS},
            **{name: _metric(result, name) for name in scalars},
            **{measure.name: measure.of(result) for measure in others},
        }


_OF_RESULTS = ("status", "reason", "digest", "key", "computing_s", "wall_s", "memory_mb")


def _metric(result: Result, name: str) -> Value:
    return None if result.metrics is None else getattr(result.metrics, name)


def frame_of(results: Results) -> pandas.DataFrame:
    """Give a frame of results: a row for each run, `columns` as its columns.

    Raises
    ------
    InvalidInputError
        If pandas is not installed.
    """
    package = _package("pandas")
    kinds = {int: "Int64", float: "float64", str: "object", bool: "boolean"}
    made = list(rows(results))
    series = {
        name: package.Series([row[name] for row in made], dtype=kinds[kind])
        for name, kind in columns().items()
    }
    frame: pandas.DataFrame = package.DataFrame(series)
    return frame


def load_results(path: str | Path) -> pandas.DataFrame:
    """Read an experiment's results as a frame of pandas, a row for each run.

    Parameters
    ----------
    path : path
        The file that `multisrt experiment run` fills; it may go on filling meanwhile.

    Raises
    ------
    InvalidInputError
        If the file holds no results, or pandas is not installed (``multisrt[frames]``).

    Examples
    --------
    >>> import multisrt as ms
    >>> frame = ms.load_results("results.sqlite")  # doctest: +SKIP
    >>> frame.groupby(["strategy", "robots"])["exploration_time_s"].median()  # doctest: +SKIP
    """
    _package("pandas")
    return frame_of(_stored(path))


def export(path: str | Path, out: str | Path) -> int:
    """Write an experiment's results as a table, a row for each run.

    The file is written wholly or not at all; one that is there is replaced.

    Parameters
    ----------
    path : path
        The results.
    out : path
        What to write: ``.csv`` or ``.parquet``.

    Returns
    -------
    int
        How many rows it has.

    Raises
    ------
    InvalidInputError
        If the name says no format, the results cannot be read, the file cannot be written, or
        pyarrow is not installed, which Parquet needs (``multisrt[frames]``).
    """
    out = Path(out)
    encode = {".csv": _csv, ".parquet": _parquet}.get(out.suffix)
    if encode is None:
        raise InvalidInputError(f"{out}: what is written is .csv or .parquet; name one of them")
    if out.suffix == ".parquet":
        _package("pyarrow")
    made = list(rows(_stored(path)))
    with _replacing(out) as unfinished:
        unfinished.write_bytes(encode(made))
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
    arrow, parquet = _package("pyarrow"), _package("pyarrow.parquet")
    kinds = {int: arrow.int64(), float: arrow.float64(), str: arrow.string(), bool: arrow.bool_()}
    fields = [arrow.field(name, kinds[kind]) for name, kind in columns().items()]
    file = io.BytesIO()
    parquet.write_table(arrow.Table.from_pylist(list(made), schema=arrow.schema(fields)), file)
    return file.getvalue()


def _package(name: str) -> Any:
    from importlib import import_module

    try:
        return import_module(name)
    except ImportError:
        raise InvalidInputError(
            f"this needs {name.partition('.')[0]}, which is not installed: "
            "pip install multisrt[frames]"
        ) from None


@contextmanager
def _replacing(path: Path) -> Iterator[Path]:
    # A file beside the one asked for, which takes its place when it is complete.
    try:
        descriptor, name = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
        os.close(descriptor)
        unfinished = Path(name)
        try:
            yield unfinished
            unfinished.chmod(0o666 & ~_umask())
            unfinished.replace(path)
        finally:
            unfinished.unlink(missing_ok=True)
    except OSError as error:
        raise InvalidInputError(f"cannot write {path}: {error.strerror or error}") from None


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask
