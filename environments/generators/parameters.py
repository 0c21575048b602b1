"""Checks of the parameters of generators, and the text of their calls."""

import math
import operator

from multisrt.geometry.errors import InvalidInputError

MAX_SEED = 2**63 - 1
"""Upper bound of seeds: the largest integer that a spec file can hold."""


def number(generator: str, name: str, value: float, low: float, high: float) -> float:
    """Return a real parameter as a float.

    Raises
    ------
    InvalidInputError
        If it is not a number from `low` to `high`.
    """
    try:
        checked = math.nan if isinstance(value, bool | str) else float(value)
    except (TypeError, ValueError, OverflowError):
        checked = math.nan
    if not low <= checked <= high:
        raise InvalidInputError(
            f"{generator}: {name}={value!r} is out of range; give a number from {low:g} to {high:g}"
        )
    return checked


def whole(generator: str, name: str, value: int, low: int, high: int) -> int:
    """Return an integer parameter as an int.

    Raises
    ------
    InvalidInputError
        If it is not an integer from `low` to `high`.
    """
    try:
        checked = None if isinstance(value, bool) else operator.index(value)
    except TypeError:
        checked = None
    if checked is None or not low <= checked <= high:
        raise InvalidInputError(
            f"{generator}: {name}={value!r} is out of range; "
            f"give a whole number from {low} to {high}"
        )
    return checked


def flag(generator: str, name: str, value: bool) -> bool:
    """Return a parameter that is true or false.

    Raises
    ------
    InvalidInputError
        If it is neither.
    """
    if not isinstance(value, bool):
        raise InvalidInputError(f"{generator}: {name}={value!r} must be true or false")
    return value


def seed_number(generator: str, seed: int) -> int:
    """Return a seed as an int from 0 to `MAX_SEED`; see `whole`."""
    return whole(generator, "seed", seed, 0, MAX_SEED)


def rounded_up(least: float) -> str:
    """Return a minimum for a message, which is not below it in tenths.

    Examples
    --------
    >>> rounded_up(9.21), rounded_up(44.400000000000006)
    ('9.3', '44.4')
    """
    return f"{math.ceil(round(10.0 * least, 6)) / 10.0:g}"


def call_text(generator: str, **parameters: float) -> str:
    """Return the text of a generator's call, by which the world can be generated again.

    Examples
    --------
    >>> call_text("garden", size_m=40.0, seed=3)
    'garden(size_m=40, seed=3)'
    """
    written = (f"{name}={repr(value).removesuffix('.0')}" for name, value in parameters.items())
    return f"{generator}({', '.join(written)})"
