"""Observations and actions of a robot whose goals are chosen by a policy."""

from __future__ import annotations

import math
import operator
from typing import Any, Literal, get_args

import msgspec
import numpy as np

from multisrt.geometry.errors import InvalidInputError, did_you_mean
from multisrt.geometry.numerics.arrays import FloatArray

Part = Literal["frontiers", "others", "map"]
"""A part of an observation that may be left out."""

MAX_MAP_CELLS = 1024
"""Maximum number of rows and columns of an observed map."""

MAX_FRONTIERS = 1000
"""Maximum number of frontiers to choose from."""


Answer = Any
"""The number of a frontier among the nearest, or the offset of a place as two numbers from -1 to 1;
see `DecisionSpec.actions`."""

OFFSET_NUMBERS = 2
"""Numbers of the answer that is a place."""


class DecisionSpec(msgspec.Struct, frozen=True, kw_only=True):
    """Observations and actions of a robot whose goals are chosen by a policy.

    Attributes
    ----------
    actions : {"frontier", "place"}
        Whether an answer is the number of a frontier, or a place.
    frontiers : int
        Number of frontiers to choose from: the nearest ones by their path.
    place_m : float
        With places: an answer of 1 means this distance in metres along an axis.
    observe : tuple of {"frontiers", "others", "map"}
        The parts of the observation. What is left out is not computed.
    map_cells : int
        Number of rows and columns of the observed map.
    map_scale : int
        Width of a cell of the observed map, in cells of the robot's own raster.
    map_centre : {"robot", "start"}
        What the middle of the observed map shows: where the robot is, or where it started.

    Raises
    ------
    InvalidInputError
        If a value is out of range or a part is unknown or named twice.

    Examples
    --------
    >>> spec = DecisionSpec(frontiers=5, observe=("frontiers",))
    >>> spec.actions, spec.no_op
    ('frontier', 5)
    >>> DecisionSpec(observe=("maps",))
    Traceback (most recent call last):
    ...
    multisrt.geometry.errors.InvalidInputError: an observation has no part 'maps' (did you mean...
    """

    actions: Literal["frontier", "place"] = "frontier"
    frontiers: int = 8
    place_m: float = 5.0
    observe: tuple[Part, ...] = get_args(Part)
    map_cells: int = 64
    map_scale: int = 2
    map_centre: Literal["robot", "start"] = "robot"

    def __post_init__(self) -> None:
        known = get_args(Part)
        if not isinstance(self.observe, tuple | list):
            raise InvalidInputError(
                f"observe is a tuple of {', '.join(known)}, not {self.observe!r}"
            )
        for part in self.observe:
            if part not in known:
                raise InvalidInputError(
                    f"an observation has no part {part!r}{did_you_mean(str(part), known)}; "
                    f"it has: {', '.join(known)}"
                )
        if len(set(self.observe)) < len(self.observe):
            raise InvalidInputError(f"observe names a part twice: {', '.join(self.observe)}")
        for name, given, allowed in (
            ("actions", self.actions, ("frontier", "place")),
            ("map_centre", self.map_centre, ("robot", "start")),
        ):
            if given not in allowed:
                raise InvalidInputError(f"{name} is {' or '.join(allowed)}, not {given!r}")
        for name, number, most in (
            ("frontiers", self.frontiers, MAX_FRONTIERS),
            ("map_cells", self.map_cells, MAX_MAP_CELLS),
            ("map_scale", self.map_scale, MAX_MAP_CELLS),
        ):
            if not (type(number) is int and 1 <= number <= most):
                raise InvalidInputError(f"{name} is a whole number from 1 to {most}, not {number}")
        if not (isinstance(self.place_m, float | int) and 0.0 < self.place_m < math.inf):
            raise InvalidInputError(f"place_m is a positive length in m, not {self.place_m!r}")

    @property
    def no_op(self) -> int:
        """The action of a robot that asks nothing and goes on: the number after the frontiers."""
        return self.frontiers

    def checked(self, answer: Answer) -> int | FloatArray:
        """Return an answer as the number of a frontier, or as the offset of a place.

        Parameters
        ----------
        answer : int or (2,) array
            The answer. Whether it can be followed depends on what the robot knows.

        Raises
        ------
        InvalidInputError
            If it is neither a whole number nor, with places, two numbers.

        Examples
        --------
        >>> DecisionSpec(actions="place").checked((0.5, -1)).tolist()
        [0.5, -1.0]
        """
        if self.actions == "frontier":
            try:
                return operator.index(answer)
            except TypeError:
                raise InvalidInputError(
                    f"the number of a frontier is a whole number, not {answer!r}"
                ) from None
        try:
            return np.asarray(answer, np.float64).reshape(OFFSET_NUMBERS)
        except (TypeError, ValueError):
            raise InvalidInputError(
                f"the offset of a place is two numbers from -1 to 1, not {answer!r}"
            ) from None
