"""Goals: places to drive to, and the path there."""

from __future__ import annotations

from dataclasses import dataclass

from multisrt.geometry.numerics.kernel import FloatArray

Place = tuple[float, float]
"""A position x, y in metres."""


@dataclass(frozen=True, slots=True, eq=False)
class Goal:
    """A place to drive to.

    Attributes
    ----------
    x, y : float
        The place in metres: the centre of a cell, except where noted.
    path : (n, 2) array
        The path to it from where the robot was when it chose the goal, in metres.
    cost_m : float
        Length of the path in metres.

    Examples
    --------
    >>> import numpy as np
    >>> goal = Goal(3.0, 4.0, np.array([[0.0, 0.0], [3.0, 4.0]]), 5.0)
    >>> goal.place
    (3.0, 4.0)
    """

    x: float
    y: float
    path: FloatArray
    cost_m: float

    @property
    def place(self) -> Place:
        """The place as a pair."""
        return self.x, self.y
