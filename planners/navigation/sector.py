"""The sector ahead of a robot, in which it looks for obstacles and for other robots.

Source: J. A. Álvarez Jáuregui, Algoritmo descentralizado para la exploración multi-robot de
escenarios 2D (Universidad de Guanajuato, 2018), sections 3.2.4 and 3.2.7.
"""

from __future__ import annotations

import math
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from multisrt.geometry.configuration import Configuration
from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.numerics import libm
from multisrt.geometry.numerics.arrays import BoolArray, FloatArray

SECTOR_RAD: Final = math.radians(15.0)
"""Half of the sector's opening angle."""

EDGE: Final = 1e-9
"""Tolerance in metres and radians: points on the border of a rectangle or sector are inside."""


def is_in_sector(
    at: Configuration,
    teammate: Configuration,
    radius_m: float,
    half_opening_rad: float = SECTOR_RAD,
) -> bool:
    """Whether another robot is in the sector ahead of a robot.

    Parameters
    ----------
    at : Configuration
        Configuration of the robot; the sector opens along its heading.
    teammate : Configuration
        Configuration of the other robot. One at the same place is in the sector.
    radius_m : float
        Radius of the sector in metres.
    half_opening_rad : float
        Half of its opening angle in radians.

    Returns
    -------
    bool

    Examples
    --------
    >>> is_in_sector(Configuration(0.0, 0.0, 0.0), Configuration(2.0, 0.5, 0.0), 3.0)
    True
    >>> is_in_sector(Configuration(0.0, 0.0, 0.0), Configuration(2.0, 0.6, 0.0), 3.0)
    False
    """
    distance = at.distance(teammate)
    if distance == 0.0:
        return True
    if distance > radius_m:
        return False
    offset = np.array([[teammate.x - at.x, teammate.y - at.y]])
    return bool(_in_sector(offset, at.heading, half_opening_rad)[0])


def cells_ahead(
    centres: ArrayLike,
    place: ArrayLike,
    goal: ArrayLike,
    cell_m: float,
    *,
    sector_rad: float = SECTOR_RAD,
) -> BoolArray:
    """Return which cells lie ahead of a robot on its way to a goal.

    Parameters
    ----------
    centres : (c, 2) array
        Centres of cells in metres.
    place, goal : (2,) array
        Positions of the robot and its goal in metres.
    cell_m : float
        Width of a cell in metres.
    sector_rad : float
        Maximum difference between the bearings of a cell and of the goal in radians.

    Returns
    -------
    (c,) array of bool
        All False if the robot is at its goal.

    Raises
    ------
    InvalidInputError
        If points are not finite pairs, or `cell_m` is not positive.

    Notes
    -----
    A cell is ahead if it is in the sector towards the goal and in the rectangle with robot and
    goal in opposite corners. A cell whose centre is the robot's position has no bearing and is not
    ahead.

    Source: section 3.2.4; differs in: the rectangle is larger by half a cell on each side. The
    thesis counts cells, so that a path along an axis is one cell wide.

    Examples
    --------
    >>> centres = [(1.5, 0.5), (2.5, 0.5), (2.5, 1.5), (4.5, 0.5)]
    >>> cells_ahead(centres, (0.5, 0.5), (3.5, 0.5), 1.0).tolist()
    [True, True, False, False]
    """
    points = _points(centres, "centres")
    start, end = _points(np.array([place, goal], np.float64), "place and goal")
    if not 0.0 < cell_m < math.inf:
        raise InvalidInputError(f"a cell is a positive width in metres, not {cell_m}")
    margin = 0.5 * cell_m + EDGE
    low, high = np.minimum(start, end) - margin, np.maximum(start, end) + margin
    between: BoolArray = ((points >= low) & (points <= high)).all(axis=1)
    if np.array_equal(start, end):
        return np.zeros(len(points), np.bool_)
    x, y = (end - start).tolist()
    return between & _in_sector(points - start, math.atan2(y, x), sector_rad)


def wrapped(angles: FloatArray) -> FloatArray:
    """Return angles in radians reduced to [-pi, pi).

    As `wrap_angle`, for arrays: that one reduces to (-pi, pi], and rounds differently.
    """
    reduced: FloatArray = (angles + math.pi) % (2.0 * math.pi) - math.pi
    return reduced


def _in_sector(offsets: FloatArray, heading_rad: float, half_rad: float) -> BoolArray:
    """Whether bearings of offsets differ from a heading by at most `half_rad`; not for (0, 0)."""
    x, y = offsets[:, 0], offsets[:, 1]
    bearings = libm.arctan2(y, x) - heading_rad
    within: BoolArray = (np.abs(wrapped(bearings)) <= half_rad + EDGE) & ((x != 0) | (y != 0))
    return within


def _points(values: ArrayLike, name: str) -> FloatArray:
    points = np.asarray(values, np.float64)
    if points.ndim != 2 or points.shape[1] != 2 or not np.isfinite(points).all():
        raise InvalidInputError(f"{name}: pairs x, y of finite numbers, not {points.shape}")
    return points
