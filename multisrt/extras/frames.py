"""Data frames of pandas or polars, whichever is there."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from importlib import import_module
from importlib.util import find_spec
from typing import Any, Final, Literal, NamedTuple, TypeAlias

from numpy.typing import NDArray

from multisrt.extras import extra
from multisrt.geometry.errors import InvalidInputError

Package = Literal["pandas", "polars"]
"""A package of data frames."""

DataFrame: TypeAlias = Any
"""A `pandas.DataFrame` or a `polars.DataFrame`."""

_PACKAGES: Final[tuple[Package, ...]] = ("pandas", "polars")
_EXTRAS: Final = {"pandas": "frames", "polars": "polars"}

_PANDAS_TYPES: Final = {bool: "boolean", int: "Int64", float: "float64", str: "object"}
_POLARS_TYPES: Final = {bool: "Boolean", int: "Int64", float: "Float64", str: "String"}


class Column(NamedTuple):
    """A column of a table: bool, int, float or str, and its values, None where there is none."""

    kind: type
    values: Sequence[Any] | NDArray[Any]


def data_frame(columns: Mapping[str, Column], package: Package | None = None) -> DataFrame:
    """Return a data frame.

    Parameters
    ----------
    columns : mapping of str to Column
        The columns by name, of equal length.
    package : {"pandas", "polars"}, optional
        Library of the data frame; by default pandas if it is installed, else polars.

    Returns
    -------
    pandas.DataFrame or polars.DataFrame
        The data frame. Columns of pandas have the types `boolean`, `Int64`, `float64` and
        `object`, so that whole numbers may be missing.

    Raises
    ------
    InvalidInputError
        If there is no such package of data frames.
    MissingExtraError
        If the package is not installed; without `package`, if neither is.

    Examples
    --------
    >>> data_frame({"robot": Column(int, [0, 1]), "x_m": Column(float, [0.5, None])}, "pandas")
       robot  x_m
    0      0  0.5
    1      1  NaN
    """
    if package is not None and package not in _PACKAGES:
        raise InvalidInputError(f'frame is "pandas" or "polars", not {package!r}')
    chosen = _found() if package is None else package
    with extra(_EXTRAS[chosen], "a data frame"):
        module = import_module(chosen)
    if chosen == "polars":
        return module.DataFrame(
            [
                module.Series(name, values, getattr(module, _POLARS_TYPES[kind]))
                for name, (kind, values) in columns.items()
            ]
        )
    return module.DataFrame(
        {
            name: module.Series(values, dtype=_PANDAS_TYPES[kind])
            for name, (kind, values) in columns.items()
        }
    )


def _found() -> Package:
    # The first that is installed; where none is, the one whose extra is to be named.
    return next((name for name in _PACKAGES if _is_there(name)), "pandas")


def _is_there(name: str) -> bool:
    try:
        return find_spec(name) is not None
    except ValueError:  # a module that is hidden has no spec
        return False
