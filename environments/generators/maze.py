"""A maze on a square grid, perfect or with loops."""

import numpy as np
import shapely
from shapely import Polygon, box
from shapely.geometry.base import BaseGeometry

from multisrt.environments.environment import Environment
from multisrt.environments.generators.grid_walls import Cell, open_walls
from multisrt.environments.generators.parameters import call_text, number, seed_number, whole
from multisrt.environments.generators.passable import passable, starts_near
from multisrt.geometry.errors import InvalidInputError

WALL_M = 0.2
MIN_CORRIDOR_M = 0.8


def maze(
    *, size_m: float = 24.0, cells: int = 12, loops: float = 0.0, seed: int = 0
) -> Environment:
    """Draw a square maze.

    Parameters
    ----------
    size_m : float
        Inner width and height, 4 to 200 m.
    cells : int
        Cells in each row and column, 2 to 100. Corridors must be at least 0.8 m wide.
    loops : float
        Probability, from 0 to 1, that a wall between cells that are already connected is
        removed. With 0 there is one path between any two cells, with 1 there are no walls.
    seed : int
        Seed of the walls.

    Returns
    -------
    Environment
        The world, in metres, with suggested starts.

    Raises
    ------
    InvalidInputError
        If a parameter is out of range or the corridors become too narrow.

    Examples
    --------
    >>> maze(size_m=10, cells=5).bounds
    (0.0, 0.0, 10.0, 10.0)
    """
    size_m = number("maze", "size_m", size_m, 4.0, 200.0)
    cells = whole("maze", "cells", cells, 2, 100)
    loops = number("maze", "loops", loops, 0.0, 1.0)
    seed = seed_number("maze", seed)
    pitch = (size_m + WALL_M) / cells
    corridor = pitch - WALL_M
    if corridor < MIN_CORRIDOR_M:
        most = int((size_m + WALL_M) / (MIN_CORRIDOR_M + WALL_M))
        raise InvalidInputError(
            f"maze: cells={cells} leaves corridors of {corridor:.2g} m, less than "
            f"{MIN_CORRIDOR_M:g} m; with size_m={size_m:g} give at most {most}, or a greater size_m"
        )

    def span(one: Cell, other: Cell) -> BaseGeometry:
        return box(
            one[0] * pitch,
            one[1] * pitch,
            other[0] * pitch + corridor,
            other[1] * pitch + corridor,
        )

    opened = open_walls(cells, cells, loops, np.random.default_rng(seed))
    corridors = shapely.union_all([span(one, other) for one, other in opened])
    free = passable(_without_posts(corridors), corridor)
    first, middle, last = corridor / 2, cells // 2 * pitch + corridor / 2, size_m - corridor / 2
    return Environment(
        "maze",
        free,
        starts=starts_near(
            free,
            [(first, first), (middle, middle), (last, last), (first, last), (last, first)],
            clearance_m=0.4 * corridor,
        ),
        origin=call_text("maze", size_m=size_m, cells=cells, loops=loops, seed=seed),
    )


def _without_posts(corridors: BaseGeometry) -> BaseGeometry:
    """Remove corner posts around which all four walls are open."""
    assert isinstance(corridors, Polygon)  # all cells are connected
    holes = [ring for ring in corridors.interiors if Polygon(ring).area > 2 * WALL_M**2]
    return Polygon(corridors.exterior, holes)
