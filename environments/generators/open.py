"""A hall, empty or with columns: the simplest world."""

import math

import numpy as np
import shapely
from shapely import Point

from multisrt.environments.environment import Environment
from multisrt.environments.generators.parameters import call_text, number, seed_number, whole
from multisrt.environments.generators.passable import passable, starts_near
from multisrt.geometry.numerics.kernel import FloatArray

COLUMN_RADIUS_M = 0.35

COLUMN_PITCH_M = 2.9
"""Minimum distance between centres of columns, and twice that from centres to walls, in metres."""

PASSAGE_M = COLUMN_PITCH_M / 2 - COLUMN_RADIUS_M


def open_hall(*, size_m: float = 20.0, columns: int = 0, seed: int = 0) -> Environment:
    """Draw a square hall, empty or with round columns spread evenly over it.

    Parameters
    ----------
    size_m : float
        Inner width and height, 5 to 200 m.
    columns : int
        Number of columns, from 0 to one per 16 m2; at most one in a hall narrower than 5.8 m.
    seed : int
        Seed of the places of the columns; an empty hall does not depend on it.

    Returns
    -------
    Environment
        The world, in metres, with suggested starts.

    Raises
    ------
    InvalidInputError
        If a parameter is out of range.

    Examples
    --------
    >>> open_hall(size_m=12).area_m2
    144.0
    """
    size_m = number("open", "size_m", size_m, 5.0, 200.0)
    most = min(int(size_m**2 / 16.0), int(size_m / COLUMN_PITCH_M) ** 2)
    columns = whole("open", "columns", columns, 0, most)
    seed = seed_number("open", seed)

    hall = shapely.box(0.0, 0.0, size_m, size_m)
    centres = _spread(columns, size_m, np.random.default_rng(seed))
    standing = [Point(centre).buffer(COLUMN_RADIUS_M, quad_segs=4) for centre in centres]
    free = passable(hall.difference(shapely.union_all(standing)), PASSAGE_M)
    middle, side = size_m / 2, min(1.5, size_m / 4)
    return Environment(
        "open",
        free,
        starts=starts_near(free, [(middle, side), (middle, middle), (side, side)]),
        origin=call_text("open", size_m=size_m, columns=columns, seed=seed),
    )


def _spread(count: int, size_m: float, rng: np.random.Generator) -> FloatArray:
    """Return random centres in `count` cells of a square grid, as an ``(n, 2)`` array."""
    if count == 0:
        return np.empty((0, 2))
    cells = math.ceil(math.sqrt(count))
    pitch = size_m / cells
    row, column = np.divmod(np.sort(rng.choice(cells * cells, size=count, replace=False)), cells)
    play = min((pitch - COLUMN_PITCH_M) / 2, 0.25 * pitch)
    middles = (np.column_stack([column, row]) + 0.5) * pitch
    return np.round(middles + rng.uniform(-play, play, (count, 2)), 2)
