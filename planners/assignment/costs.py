"""Tables of costs as the rules of assignment take them."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.numerics.arrays import FloatArray

NOBODY: Final = -1
"""In an assignment: the robot has no frontier."""


def cost_table(values: ArrayLike, name: str = "costs", *, dimensions: int = 2) -> FloatArray:
    """Check distances, and copy them so that a decision keeps what it was made on.

    Parameters
    ----------
    values : array
        Distances in metres, 0 or more; ``inf``: no way.
    name : str
        What the array is called in errors.
    dimensions : {1, 2}
        Whether it is one row or a table.

    Returns
    -------
    array that cannot be written to

    Raises
    ------
    InvalidInputError
        If the array has another number of dimensions, or holds NaN or a negative number.
    """
    table = np.array(values, np.float64)
    if table.ndim != dimensions:
        raise InvalidInputError(f"{name} has {table.ndim} dimensions; it must have {dimensions}")
    wrong = np.argwhere(~(table >= 0.0))
    if len(wrong):
        place = tuple(wrong[0].tolist())
        raise InvalidInputError(
            f"{name} is {table[place]} at {list(place)}; distances are 0 or more, inf for no way"
        )
    table += 0.0  # makes -0.0 equal to 0.0 bit by bit
    table.setflags(write=False)
    return table


def check_robot(robot: int, robots: int) -> None:
    """Raise unless `robot` is a row of a table for so many robots."""
    if not 0 <= robot < robots:
        raise InvalidInputError(f"robot is {robot}; the table has rows 0 to {robots - 1}")


def longest(table: FloatArray) -> float:
    """Give the largest finite distance of a table; 0 if there is none."""
    return float(table[np.isfinite(table)].max(initial=0.0))
