"""The rows of a store's table of runs, and the results that they hold."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import msgspec

from multisrt.experiments.crossing import Condition
from multisrt.experiments.results import Result
from multisrt.experiments.store_file import OR_ANOTHER, sane
from multisrt.geometry.errors import InvalidInputError, reason_of, shown
from multisrt.validation_errors import UNREADABLE

_LABELS = Condition.__struct_fields__
_FIELDS = tuple(
    name
    for name in Result.__struct_fields__
    if name not in ("condition", "success_coverage", "reference", "no_reference", "delivered_at_s")
)
COLUMNS = ("position", *_LABELS, *_FIELDS)
"""Names of the columns."""


class _Curves(msgspec.Struct, frozen=True, kw_only=True):
    """What stands in the column `covered_at_s` of a run with a base station."""

    covered: tuple[float | None, ...]
    delivered: tuple[float | None, ...] = ()


def row_of(result: Result, position: int) -> tuple[Any, ...]:
    """Return the row of a result.

    Parameters
    ----------
    result : Result
        The result.
    position : int
        Number of the run in the experiment's order.

    Returns
    -------
    tuple
        Values in the order of `COLUMNS`.
    """
    values = {name: getattr(result.condition, name) for name in _LABELS}
    values |= {name: getattr(result, name) for name in Result.__struct_fields__}
    values["position"] = position
    if result.delivered_at_s:
        values["covered_at_s"] = _Curves(
            covered=result.covered_at_s, delivered=result.delivered_at_s
        )
    for name in ("metrics", "covered_at_s"):
        if values[name] is not None:
            values[name] = msgspec.json.encode(values[name]).decode()
    return tuple(values[name] for name in COLUMNS)


def result_of(path: Path, row: tuple[Any, ...], success_coverage: float) -> Result:
    """Return the result that a row holds.

    Parameters
    ----------
    path : Path
        The file, for messages.
    row : tuple
        Values in the order of `COLUMNS`.
    success_coverage : float
        Share of the explorable area that a success has covered.

    Returns
    -------
    Result
        The result.

    Raises
    ------
    InvalidInputError
        If the row is damaged.
    """
    given = dict(zip(COLUMNS, row, strict=True))
    key = given["key"]
    try:
        for name in ("metrics", "covered_at_s"):
            if given[name] is not None:
                given[name] = msgspec.json.decode(given[name])
        given = sane(given)
        curves: Any = msgspec.convert(given["covered_at_s"], tuple[float | None, ...] | _Curves)
        if not isinstance(curves, _Curves):
            curves = _Curves(covered=curves)
        given |= {
            "condition": {label: given.pop(label) for label in _LABELS},
            "chance": _CHANCE[given["chance"]],
            "covered_at_s": curves.covered,
            "delivered_at_s": curves.delivered,
            "success_coverage": success_coverage,
        }
        return msgspec.convert(given, Result)
    except (*UNREADABLE, TypeError, KeyError) as error:
        raise InvalidInputError(
            f"{path}: the result of run {shown(key)} is damaged: {reason_of(error)}; {OR_ANOTHER}"
        ) from None


_CHANCE = {0: False, 1: True}
