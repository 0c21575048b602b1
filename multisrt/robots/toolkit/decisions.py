"""Decisions of user-defined explorers, recorded with their text and numbers."""

from __future__ import annotations

from typing import Any, SupportsFloat

import numpy as np

from multisrt.events import MAX_OPTIONS, Decided
from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.numerics.arrays import FloatArray
from multisrt.robots.explorer import Note, RobotSelf
from multisrt.robots.toolkit.places import places_of


def decided(
    me: RobotSelf,
    time_s: SupportsFloat,
    text: str,
    goal: Any = None,
    options: Any = (),
    **values: Any,
) -> Note:
    """Return the action that records a decision.

    ``multisrt why`` shows it, and reports count decisions by strategy. Recording it changes only
    the digest of the run.

    Parameters
    ----------
    me : RobotSelf
        What the robot knows about itself.
    time_s : float
        The present time, taken from the last scan, motion or message.
    text : str
        Reason for the decision; at most `multisrt.events.MAX_TEXT_LENGTH` characters.
    goal : place, optional
        The goal; see `places_of`. By default there is none.
    options : (m, 2) array_like or sequence of places
        The places that were considered. If there are more than `multisrt.events.MAX_OPTIONS`, the
        goal and those with the lowest values of the first criterion are recorded.
    **values : (m,) array_like
        Criteria by name, with one number for each option. Infinite numbers and NaN are recorded as
        missing.

    Returns
    -------
    Note
        The action, to be yielded.

    Raises
    ------
    InvalidInputError
        If a place is invalid, there are not as many values as options, or the text is too long.

    Examples
    --------
    >>> from multisrt.geometry.bodies.footprint import Footprint
    >>> from multisrt.geometry.configuration import Configuration
    >>> from multisrt.planners.motion.kinematics import Differential
    >>> me = RobotSelf(
    ...     robot=0,
    ...     start=Configuration(0.0, 0.0, 0.0),
    ...     footprint=Footprint.disc(0.25),
    ...     kinematics=Differential(),
    ...     range_m=4.0,
    ...     rng=np.random.default_rng(0),
    ... )
    >>> doors = np.array([[2.0, 0.0], [0.0, 5.0]])
    >>> note = decided(me, 3.5, "the nearest door", doors[0], doors, path_m=[2.0, np.inf])
    >>> note.event.goal, note.event.values
    ((2.0, 0.0), {'path_m': (2.0, None)})
    """
    chosen = None if goal is None else _pair(goal)
    places = places_of(options, "options")
    table = {name: _column(name, column, len(places)) for name, column in values.items()}
    kept = np.arange(len(places))
    if len(places) > MAX_OPTIONS:
        first = next(iter(table.values()), np.arange(len(places), dtype=np.float64))
        is_goal = np.zeros(len(places), np.bool_)
        if chosen is not None:
            is_goal = (places == np.array(chosen)).all(axis=1)
        # NaN, which stands for a missing number, is sorted behind all others.
        kept = np.sort(np.lexsort((first, ~is_goal))[:MAX_OPTIONS])
    return Note(
        Decided(
            time_s=float(time_s),
            robot=me.robot,
            text=text,
            goal=chosen,
            options=tuple((x, y) for x, y in places[kept].tolist()),
            values={name: _finite(column[kept].tolist()) for name, column in table.items()},
        )
    )


def _pair(place: Any) -> tuple[float, float]:
    found = places_of(place, "goal")
    if len(found) != 1:
        raise InvalidInputError(f"goal has {len(found)} places; give one, or None")
    x, y = found[0].tolist()
    return x, y


def _column(name: str, values: Any, count: int) -> FloatArray:
    try:
        column = np.array(values, np.float64)
    except (TypeError, ValueError):
        raise InvalidInputError(f"{name} is {values!r}; give one number for each option") from None
    if column.shape != (count,):
        raise InvalidInputError(
            f"{name} has the shape {column.shape}; give one number for each of {count} options"
        )
    column[~np.isfinite(column)] = np.nan
    return column


def _finite(values: list[float]) -> tuple[float | None, ...]:
    return tuple(None if np.isnan(value) else value for value in values)
