"""A base station: the place to which the data of the exploration is delivered."""

from __future__ import annotations

import math

import msgspec

from multisrt.geometry.errors import InvalidInputError
from multisrt.spec.part import Part


class BaseSpec(Part, frozen=True, kw_only=True):
    """A base station, which robots reach by radio.

    It has no body and no range finder, never moves and never fails. It collects the nodes and
    closings in the messages that reach it, requests those that are missing, and relays messages if
    robots do.

    Attributes
    ----------
    x, y : float
        Its place in metres.

    Raises
    ------
    InvalidInputError
        If a coordinate is not finite.

    Examples
    --------
    >>> BaseSpec(x=1, y=2.5)
    BaseSpec(x=1.0, y=2.5)
    """

    x: float
    y: float

    def __post_init__(self) -> None:
        place = float(self.x), float(self.y)
        if not all(map(math.isfinite, place)):
            raise InvalidInputError(f"the place of a base station is finite, not {place}")
        for name, value in zip(("x", "y"), place, strict=True):
            msgspec.structs.force_setattr(self, name, value)

    @property
    def place(self) -> tuple[float, float]:
        """Its place in metres."""
        return self.x, self.y
