"""Keywords of `multisrt.explore`: numbers of numpy taken; other kinds, and unused ones, refused."""

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
"""What is given instead of options of map files, of which worlds are made before."""


def checked(name: str, value: Any) -> Any:
    """Return the value of a keyword, with builtin numbers where it is a number.

    Parameters
    ----------
    name : str
        The keyword.
    value : object
        What was given for it, not None.

    Returns
    -------
    object
        The value; a tuple for faults.

    Raises
    ------
    InvalidInputError
        If the value is of another kind than the keyword asks for.

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
    """Check that a function has no keyword that it does not take.

    Parameters
    ----------
    function : str
        Its name.
    given : iterable of str
        The keywords that it was given and may not take.
    known : iterable of str
        Those that it takes.
    instead : mapping of str to str, optional
        How it is given what another function takes by a keyword.

    Raises
    ------
    InvalidInputError
        If there is such a keyword; the message says what to give instead, or names one that is
        written alike.

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
    """Check that a run uses what its user gave for a team.

    Parameters
    ----------
    spec : RunSpec
        The run.
    given : mapping of str to str
        What was given for a team, ``starts`` or a part of the radio, with its name as the user
        wrote it.
    size : str
        How the user gives the size of a team.
    sized : bool
        Whether the size was given. A team of one is not a mistake then: sizes may be tried in turn.

    Raises
    ------
    InvalidInputError
        If a way to draw starts was given and every robot has its start, or something was given
        for a team and no team.

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
        # A single robot uses its radio, too; but starts are drawn for teams alone.
        given = {name: text for name, text in given.items() if name == "starts"}
    if given and not sized and len(spec.robots) == 1:
        raise InvalidInputError(
            f"{next(iter(given.values()))} is for teams, and there is one robot: give {size}, "
            "or leave it out"
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
        x and y in metres, and perhaps the heading in radians.

    Returns
    -------
    tuple of float
        As many as were given.

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
    """Return a base station that is given as its spec or as its place.

    Parameters
    ----------
    base : BaseSpec or (x, y)
        The base station, or where it is, in metres.

    Returns
    -------
    BaseSpec
        The base station.

    Raises
    ------
    InvalidInputError
        If it is neither.

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
