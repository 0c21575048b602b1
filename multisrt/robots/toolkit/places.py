"""Places in all forms that explorers use: numbers, arrays, configurations, goals, nodes."""

from __future__ import annotations

from typing import Any

import numpy as np

from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.numerics.arrays import FloatArray
from multisrt.robots.defects import brief


def places_of(places: Any, name: str = "places") -> FloatArray:
    """Return places as an array.

    Parameters
    ----------
    places : (n, 2) or (n, 3) array_like, or a single place
        x, y and optionally the heading of each. A place may also be a `Configuration`, or an object
        with an attribute `place` or `configuration`, such as a `Frontier` or a `Node`. A list or
        tuple may mix all of these.
    name : str
        Name of the argument in error messages.

    Returns
    -------
    (n, 2) array
        x and y in metres; a new array.

    Raises
    ------
    InvalidInputError
        If the argument has another form, or a number is not finite.

    Examples
    --------
    >>> from multisrt.geometry.configuration import Configuration
    >>> places_of((1, 2)).tolist()
    [[1.0, 2.0]]
    >>> places_of([Configuration(3.0, 4.0, 0.5), (5.0, 6.0)]).tolist()
    [[3.0, 4.0], [5.0, 6.0]]
    >>> places_of(np.zeros((4, 3))).shape, places_of([]).shape
    ((4, 2), (0, 2))
    >>> places_of([1.0, float("nan")])
    Traceback (most recent call last):
    multisrt.geometry.errors.InvalidInputError: places[0] is (1, nan); give finite metres
    """
    return np.ascontiguousarray(rows_of(places, name)[:, :2])


def rows_of(places: Any, name: str = "places") -> FloatArray:
    """Return places like `places_of`, ``(n, 2)``, or ``(n, 3)`` if all have headings."""
    rows = _numbers(places)
    try:
        if isinstance(rows, list | tuple) and any(np.ndim(row) for row in rows):
            least = min(len(row) for row in rows)
            rows = [row[: max(2, min(3, least))] if len(row) <= 3 else row for row in rows]
        found = np.array(rows, np.float64)
    except (TypeError, ValueError):
        found = np.empty((0, 0, 0))
    if found.ndim < 3 and found.size == 0:
        return np.empty((0, 2))
    if found.ndim == 1:
        found = found[None]
    if found.ndim != 2 or found.shape[1] not in (2, 3):
        raise InvalidInputError(
            f"{name} is {brief(places)}; give x, y of one place, or an array (n, 2) or (n, 3) of "
            "x, y and perhaps headings"
        )
    wrong = np.flatnonzero(~np.isfinite(found).all(axis=1))
    if len(wrong):
        values = ", ".join(f"{value:g}" for value in found[wrong[0]])
        raise InvalidInputError(f"{name}[{wrong[0]}] is ({values}); give finite metres")
    return found


def is_single(places: Any) -> bool:
    """Whether the argument is a single place, not a sequence or an array of places.

    Examples
    --------
    >>> is_single((1.0, 2.0)), is_single([(1.0, 2.0)])
    (True, False)
    """
    rows = _numbers(places)
    if isinstance(rows, list | tuple):
        return len(rows) > 0 and not any(np.ndim(row) for row in rows)
    return np.ndim(rows) == 1 and np.size(rows) > 0


def _numbers(value: Any) -> Any:
    # Objects with a place are replaced by its numbers, also in lists and tuples.
    for name in ("place", "configuration"):
        if hasattr(value, name):
            return tuple(getattr(value, name))
    if isinstance(value, list | tuple):
        return [_numbers(part) for part in value]
    return value
