"""Checks of the keywords of `multisrt.explore`, which accept numbers of numpy."""

from __future__ import annotations

import operator
from collections.abc import Callable, Iterable, Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from multisrt.geometry.errors import InvalidInputError, did_you_mean
from multisrt.spec.base import BaseSpec
from multisrt.spec.faults import Death, LateStart, Silence

if TYPE_CHECKING:
    from multisrt.spec.run import RunSpec

OF_MAP_FILES = {
    option: f"the world that ms.read_environment(file, {option}=...) returns"
    for option in ("resolution_m", "threshold", "starts_from")
}
"""Replacements for options of map files, whose worlds are built before."""


def checked(name: str, value: Any) -> Any:
    """Return the value of a keyword, with numbers converted to builtin ones.

    Parameters
    ----------
    name : str
        The keyword.
    value : object
        Its value, not None.

    Returns
    -------
    object
        The value; for faults, a tuple.

    Raises
    ------
    InvalidInputError
        If the value has the wrong type for the keyword.

    Examples
    --------
    >>> import numpy as np
    >>> checked("range_m", np.float32(0.5)), checked("seed", np.int64(3))
    (0.5, 3)
    """
    if name in ("range_m", "radio_range_m", "max_time_s"):
        return _converted(name, value, float, "a number")
    if name in ("seed", "beams"):
        return _converted(name, value, operator.index, "a whole number")
    if name == "options" and not isinstance(value, Mapping):
        raise InvalidInputError(f"options are a dictionary of names and values, not {value!r}")
    if name == "faults":
        value = tuple(value) if isinstance(value, Iterable) else (value,)
        for fault in value:
            if not isinstance(fault, Death | Silence | LateStart):
                raise InvalidInputError(
                    f"faults are instances of Death, Silence and LateStart, not {fault!r}"
                )
    return value


def refuse_unknown(
    function: str,
    given: Iterable[str],
    known: Iterable[str],
    instead: Mapping[str, str] = MappingProxyType({}),
) -> None:
    """Check that a function is given only keywords that it takes.

    Parameters
    ----------
    function : str
        Its name.
    given : iterable of str
        The keywords that it was given.
    known : iterable of str
        The keywords that it takes.
    instead : mapping of str to str, optional
        For keywords of other functions: what to give instead.

    Raises
    ------
    InvalidInputError
        If there is an unknown keyword; the message says what to give instead, or suggests one with
        a similar name.

    Examples
    --------
    >>> refuse_unknown("explore", ["seeds"], ["seed", "options"])
    Traceback (most recent call last):
    ...
    multisrt.geometry.errors.InvalidInputError: explore takes no argument 'seeds' (did you mean \
'seed'?)
    """
    known = tuple(known)
    for name in given:
        if name not in known:
            hint = f": give {instead[name]}" if name in instead else did_you_mean(name, known)
            raise InvalidInputError(f"{function} takes no argument {name!r}{hint}")


def require_use(spec: RunSpec, given: Mapping[str, str], size: str, *, sized: bool) -> None:
    """Check that a run uses the arguments that apply to teams only.

    Parameters
    ----------
    spec : RunSpec
        The run.
    given : mapping of str to str
        The arguments for teams that were given, ``starts`` or parts of the radio, with their names
        as the user wrote them.
    size : str
        Name of the argument for the size of a team.
    sized : bool
        Whether the size was given. A team of one is then accepted, because sizes may be varied.

    Raises
    ------
    InvalidInputError
        If `starts` says how to draw starts although every robot has one, or if an argument for
        teams was given without a team.

    Examples
    --------
    >>> import multisrt as ms
    >>> ms.explore("open", starts="clustered")
    Traceback (most recent call last):
    ...
    multisrt.geometry.errors.InvalidInputError: starts is for teams, and there is one robot: ...
    """
    if "starts" in given and all(robot.start is not None for robot in spec.robots):
        raise InvalidInputError(
            f"{given['starts']} says how starts are drawn, but every robot was given its start: "
            "leave out one of them"
        )
    if spec.base is not None:
        # A single robot uses its radio, too, and may start there; other starts are for teams.
        is_for_teams = "starts" in given and spec.starts != "base"
        given = {"starts": given["starts"]} if is_for_teams else {}
    if given and not sized and len(spec.robots) == 1:
        name, text = next(iter(given.items()))
        base = "" if name == "starts" else " or a base station"
        raise InvalidInputError(
            f"{text} is for teams, and there is one robot: give {size}{base}, or leave it out"
        )


def _converted(name: str, value: Any, convert: Callable[[Any], Any], kind: str) -> Any:
    if isinstance(value, bool | str):
        raise InvalidInputError(f"{name} is {kind}, not {value!r}")
    try:
        return convert(value)
    except (TypeError, ValueError):
        raise InvalidInputError(f"{name} is {kind}, not {value!r}") from None


def start_of(start: Iterable[float]) -> tuple[float, ...]:
    """Return a start as a tuple of builtin numbers.

    Parameters
    ----------
    start : iterable of float
        x and y in metres, and optionally the heading in radians.

    Returns
    -------
    tuple of float
        As many numbers as were given.

    Raises
    ------
    InvalidInputError
        If it is not a sequence of numbers.

    Examples
    --------
    >>> import numpy as np
    >>> start_of(np.array([1, 2]))
    (1.0, 2.0)
    """
    try:
        return tuple(float(value) for value in start)
    except (TypeError, ValueError):
        raise InvalidInputError(
            f"a start is (x, y) or (x, y, heading) in metres and radians, not {start!r}"
        ) from None


def base_of(base: BaseSpec | Iterable[float]) -> BaseSpec:
    """Return the spec of a base station that is given as a spec or a place.

    Parameters
    ----------
    base : BaseSpec or (x, y)
        The base station, or its place in metres.

    Returns
    -------
    BaseSpec
        The base station.

    Raises
    ------
    InvalidInputError
        If it is neither of these.

    Examples
    --------
    >>> base_of((1, 2))
    BaseSpec(x=1.0, y=2.0)
    """
    if isinstance(base, BaseSpec):
        return base
    try:
        x, y = (float(value) for value in base)
    except (TypeError, ValueError):
        raise InvalidInputError(
            f"a base station is given as its place (x, y) in metres, not {base!r}"
        ) from None
    return BaseSpec(x=x, y=y)
