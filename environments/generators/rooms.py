"""A grid of large rooms with doors between them."""

import numpy as np
import shapely
from shapely import box
from shapely.geometry.base import BaseGeometry

from multisrt.environments.environment import Environment
from multisrt.environments.generators.grid_walls import Cell, open_walls
from multisrt.environments.generators.parameters import call_text, number, seed_number, whole
from multisrt.environments.generators.passable import passable, starts_near
from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.numerics.kernel import FloatArray

WALL_M = 0.2
JAMB_M = 0.5
"""Minimum width of the wall between a door and the corner of its room, in metres."""


def rooms(
    *,
    size_m: float = 30.0,
    rooms_per_side: int = 4,
    door_m: float = 1.2,
    loops: float = 0.5,
    seed: int = 0,
) -> Environment:
    """Draw a square building: a grid of rooms of different sizes with doors between them.

    Every room can be reached, and with large `loops` most of them by several routes.

    Parameters
    ----------
    size_m : float
        Inner width and height, 6 to 200 m.
    rooms_per_side : int
        Rooms in each row and column, 1 to 40. A row must be at least 3 m wide and have room for
        its doors.
    door_m : float
        Width of the doors, 0.8 to 4 m.
    loops : float
        Probability, from 0 to 1, of a door in a wall between rooms that are connected already.
    seed : int
        Seed of the walls and the doors.

    Returns
    -------
    Environment
        The world, in metres, with suggested starts.

    Raises
    ------
    InvalidInputError
        If a parameter is out of range or the rooms become too narrow.

    Examples
    --------
    >>> rooms(size_m=12, rooms_per_side=2).bounds
    (0.0, 0.0, 12.0, 12.0)
    """
    size_m = number("rooms", "size_m", size_m, 6.0, 200.0)
    rooms_per_side = whole("rooms", "rooms_per_side", rooms_per_side, 1, 40)
    door_m = number("rooms", "door_m", door_m, 0.8, 4.0)
    loops = number("rooms", "loops", loops, 0.0, 1.0)
    seed = seed_number("rooms", seed)
    pitch = size_m / rooms_per_side
    least = max(3.0, 1.4 * (door_m + 2 * JAMB_M + WALL_M))
    if pitch < least:
        raise InvalidInputError(
            f"rooms: rooms_per_side={rooms_per_side} leaves {pitch:.3g} m a room, less than "
            f"{least:.3g} m; with size_m={size_m:g} and door_m={door_m:g} give at most "
            f"{int(size_m / least)}, or a greater size_m"
        )

    rng = np.random.default_rng(seed)
    x_walls = _wall_lines(rooms_per_side, size_m, rng)
    y_walls = _wall_lines(rooms_per_side, size_m, rng)
    floors = {
        (column, row): _floor(x_walls, y_walls, (column, row))
        for column in range(rooms_per_side)
        for row in range(rooms_per_side)
    }
    doors = [
        _door(floors[one], floors[other], door_m, rng)
        for one, other in open_walls(rooms_per_side, rooms_per_side, loops, rng)
    ]
    free = passable(shapely.union_all([*floors.values(), *doors]), door_m)
    middle, last = rooms_per_side // 2, rooms_per_side - 1
    wanted = [floors[middle, 0], floors[middle, middle], floors[0, last], floors[last, last]]
    return Environment(
        "rooms",
        free,
        starts=starts_near(free, [(room.centroid.x, room.centroid.y) for room in wanted]),
        origin=call_text(
            "rooms",
            size_m=size_m,
            rooms_per_side=rooms_per_side,
            door_m=door_m,
            loops=loops,
            seed=seed,
        ),
    )


def _wall_lines(count: int, size_m: float, rng: np.random.Generator) -> FloatArray:
    """Return the centre lines of the walls along one axis, the outer ones included."""
    pitch = size_m / count
    inner = (np.arange(1, count) + rng.uniform(-0.14, 0.14, count - 1)) * pitch
    return np.concatenate([[-WALL_M / 2], np.round(inner, 2), [size_m + WALL_M / 2]])


def _floor(x_walls: FloatArray, y_walls: FloatArray, cell: Cell) -> BaseGeometry:
    column, row = cell
    half = WALL_M / 2
    (left, right), (low, high) = x_walls[column : column + 2], y_walls[row : row + 2]
    return box(float(left) + half, float(low) + half, float(right) - half, float(high) - half)


def _door(
    one: BaseGeometry, other: BaseGeometry, door_m: float, rng: np.random.Generator
) -> BaseGeometry:
    """Return the opening in the wall between a room and its right or upper neighbour."""
    x0, y0, x1, y1 = one.bounds
    other_x0, other_y0, _, _ = other.bounds
    if other_x0 > x1:
        low = round(rng.uniform(y0 + JAMB_M, y1 - JAMB_M - door_m), 2)
        return box(x1, low, other_x0, low + door_m)
    low = round(rng.uniform(x0 + JAMB_M, x1 - JAMB_M - door_m), 2)
    return box(low, y1, low + door_m, other_y0)
