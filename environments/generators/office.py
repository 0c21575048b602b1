"""An office floor: corridors, rooms with doors on both sides of them, desks in the rooms."""

import math
from collections.abc import Callable

import numpy as np
import shapely
from shapely import Point, box
from shapely.geometry.base import BaseGeometry

from multisrt.environments.environment import Environment
from multisrt.environments.generators.bay import Bay, clear_zone, shared_widths
from multisrt.environments.generators.parameters import call_text, flag, number, seed_number
from multisrt.environments.generators.passable import passable, starts_near
from multisrt.geometry.errors import InvalidInputError

WALL_M = 0.15
BLOCK_M = 12.5
"""Usual depth of two rows of rooms with their corridor."""

MIN_ROOM_DEPTH_M = 3.4
CROSSING_EVERY_M = 18.0
LOBBY_M = 6.0


def office(
    *,
    width_m: float = 34.0,
    height_m: float = 25.0,
    corridor_m: float = 1.8,
    door_m: float = 1.0,
    connecting: float = 0.15,
    furnished: bool = True,
    seed: int = 0,
) -> Environment:
    """Draw an office floor of one or more corridors, joined by cross corridors.

    Each corridor has rooms on both sides. Each room has a door to its corridor, and some have
    another to the room beside them. A lobby without a front wall opens onto the lowest corridor.

    Parameters
    ----------
    width_m, height_m : float
        Inner size, 14 to 200 m and 9 to 200 m.
    corridor_m : float
        Width of the corridors, 1.2 to 4 m.
    door_m : float
        Width of the doors, 0.8 to 1.6 m.
    connecting : float
        Probability, from 0 to 1, of a door between neighbouring rooms.
    furnished : bool
        Whether there is furniture in the rooms. Walls and doors do not depend on it.
    seed : int
        Seed of the rooms, their furniture and their doors.

    Returns
    -------
    Environment
        The world, in metres, with suggested starts.

    Raises
    ------
    InvalidInputError
        If a parameter is out of range or the rooms become too shallow.

    Examples
    --------
    >>> office(width_m=20, height_m=12, seed=3).origin
    'office(width_m=20, height_m=12, corridor_m=1.8, door_m=1, connecting=0.15, seed=3)'
    """
    width_m = number("office", "width_m", width_m, 14.0, 200.0)
    height_m = number("office", "height_m", height_m, 9.0, 200.0)
    corridor_m = number("office", "corridor_m", corridor_m, 1.2, 4.0)
    door_m = number("office", "door_m", door_m, 0.8, 1.6)
    connecting = number("office", "connecting", connecting, 0.0, 1.0)
    furnished = flag("office", "furnished", furnished)
    seed = seed_number("office", seed)
    blocks = max(1, round(height_m / BLOCK_M))
    depth = (height_m - blocks * (corridor_m + 2 * WALL_M) - (blocks - 1) * WALL_M) / (2 * blocks)
    if depth < MIN_ROOM_DEPTH_M:
        raise InvalidInputError(
            f"office: height_m={height_m:g} with corridor_m={corridor_m:g} leaves rooms "
            f"{depth:.2g} m deep, less than {MIN_ROOM_DEPTH_M:g} m; give a greater height_m or "
            "narrower corridors"
        )

    rng = np.random.default_rng(seed)
    pitch = 2 * (depth + WALL_M) + corridor_m + WALL_M
    lows = [block * pitch + depth + WALL_M for block in range(blocks)]
    corridors: list[BaseGeometry] = [box(0.0, low, width_m, low + corridor_m) for low in lows]
    crossings = _crossings(width_m, corridor_m, rng) if blocks > 1 else []
    corridors += [
        box(left, lows[0], left + corridor_m, lows[-1] + corridor_m) for left in crossings
    ]

    opened: list[BaseGeometry] = list(corridors)
    furniture: list[BaseGeometry] = []
    lobby_x = width_m / 2
    for block, low in enumerate(lows):
        for upper in (False, True):
            outer = (block == 0 and not upper) or (block == blocks - 1 and upper)
            y, inward = (low + corridor_m + WALL_M, 1.0) if upper else (low - WALL_M, -1.0)
            for left, right in _stretches(width_m, [] if outer else crossings, corridor_m):
                row = Bay(
                    x=left,
                    y=y,
                    along=(1.0, 0.0),
                    inward=(0.0, inward),
                    width_m=right - left,
                    depth_m=depth,
                )
                if block == 0 and not upper:
                    lobby_x = _row_with_lobby(row, door_m, connecting, rng, opened, furniture)
                else:
                    _row(row, door_m, connecting, rng, opened, furniture)

    floors = shapely.union_all(opened)
    if furnished:
        floors = floors.difference(shapely.union_all(furniture))
    free = passable(floors, door_m)
    middle = corridor_m / 2
    far = lows[-1] + middle
    return Environment(
        "office",
        free,
        starts=starts_near(
            free,
            [
                (lobby_x, lows[0] - WALL_M),
                (middle, lows[0] + middle),
                (width_m - middle, far),
                (middle, far),
            ],
        ),
        origin=call_text(
            "office",
            width_m=width_m,
            height_m=height_m,
            corridor_m=corridor_m,
            door_m=door_m,
            connecting=connecting,
            # Only if it is not the default: recordings hold this text.
            **({} if furnished else {"furnished": False}),
            seed=seed,
        ),
    )


def _crossings(width_m: float, corridor_m: float, rng: np.random.Generator) -> list[float]:
    """Return the left sides of the cross corridors, evenly spaced with random offsets."""
    count = max(1, round(width_m / CROSSING_EVERY_M))
    middles = (np.arange(count) + 0.5) * width_m / count
    middles += rng.uniform(-0.08, 0.08, count) * width_m / count
    return [round(float(middle) - corridor_m / 2, 2) for middle in middles]


def _stretches(
    width_m: float, crossings: list[float], corridor_m: float
) -> list[tuple[float, float]]:
    """Return the intervals of x between the cross corridors, which the rooms fill."""
    begins = [0.0, *(left + corridor_m + WALL_M for left in crossings)]
    ends = [*(left - WALL_M for left in crossings), width_m]
    return list(zip(begins, ends, strict=True))


def _row_with_lobby(
    row: Bay,
    door_m: float,
    connecting: float,
    rng: np.random.Generator,
    opened: list[BaseGeometry],
    furniture: list[BaseGeometry],
) -> float:
    """Draw a row of rooms with the lobby in the middle; return the middle x of the lobby."""
    side = round((row.width_m - LOBBY_M) / 2 - WALL_M, 2)
    widths = np.array([side, row.width_m - side - 2 * WALL_M - side, side])
    left, lobby, right = row.split(widths, WALL_M)
    _row(left, door_m, connecting, rng, opened, furniture)
    _row(right, door_m, connecting, rng, opened, furniture)
    opened += [lobby.floor(), lobby.doorway(lobby.width_m / 2, lobby.width_m, WALL_M)]
    desk = box(1.2, lobby.depth_m - 1.9, lobby.width_m - 1.2, lobby.depth_m - 1.1)
    furniture.append(lobby.place(desk))
    return lobby.x + lobby.width_m / 2


def _row(
    row: Bay,
    door_m: float,
    connecting: float,
    rng: np.random.Generator,
    opened: list[BaseGeometry],
    furniture: list[BaseGeometry],
) -> None:
    """Draw a row of rooms side by side, their doors and furniture."""
    count = max(1, round(row.width_m / 4.8))
    shares = rng.choice([0.7, 0.85, 1.0, 1.5], size=count, p=[0.3, 0.3, 0.25, 0.15])
    rooms = row.split(shared_widths(row.width_m, shares, WALL_M), WALL_M)
    beside = rng.random(count - 1) < connecting
    for index, room in enumerate(rooms):
        door_at = door_m / 2 + 0.3 if rng.random() < 0.7 else room.width_m / 2
        room = room.mirrored() if rng.random() < 0.5 else room
        opened += [room.floor(), room.doorway(door_at, door_m, WALL_M)]
        kept_free = [room.place(clear_zone(door_at, door_m, 1.2))]
        for wall in (index - 1, index):
            if 0 <= wall < count - 1 and beside[wall]:
                kept_free.append(_connecting_door(rooms[wall], door_m).buffer(0.7))
        furniture += [
            piece
            for piece in map(room.place, _furniture(room.width_m, room.depth_m, rng))
            if not any(piece.intersects(zone) for zone in kept_free)
        ]
    opened += [
        _connecting_door(room, door_m) for room, door in zip(rooms, beside, strict=False) if door
    ]


def _connecting_door(room: Bay, door_m: float) -> BaseGeometry:
    """Return the opening to the next room, halfway into the depth."""
    low = 0.45 * room.depth_m - door_m / 2
    return room.place(box(room.width_m, low, room.width_m + WALL_M, low + door_m))


# Furniture is drawn in a room's own frame: the door is in the wall y = 0, windows are at the
# far wall. Pieces touch a wall or leave room to walk around them.


def _furniture(width: float, depth: float, rng: np.random.Generator) -> list[BaseGeometry]:
    fitting = [furnish for furnish, least, most in _FURNISHINGS if least <= width <= most]
    return fitting[int(rng.integers(len(fitting)))](width, depth)


def _single_office(width: float, depth: float) -> list[BaseGeometry]:
    """Draw one desk with its end at the side wall, a cabinet along the other."""
    desk = box(width - 1.6, depth - 2.0, width, depth - 1.2)
    return [desk, box(0.0, depth - 1.8, 0.45, depth)]


def _double_office(width: float, depth: float) -> list[BaseGeometry]:
    """Draw two desks face to face at the window, shelves behind the door's side."""
    middle = width / 2
    desks = box(middle - 0.8, depth - 1.6, middle + 0.8, depth)
    return [desks, box(width - 0.4, 0.0, width, min(2.4, depth - 1.8))]


def _store(width: float, depth: float) -> list[BaseGeometry]:
    """Draw shelves along both side walls."""
    return [box(0.0, 1.3, 0.5, depth), box(width - 0.5, 0.0, width, depth)]


def _kitchen(width: float, depth: float) -> list[BaseGeometry]:
    """Draw a counter at the far wall and a round table."""
    table = Point(width / 2, 0.42 * depth).buffer(0.5, quad_segs=3)
    return [box(0.0, depth - 0.65, width, depth), table]


def _lounge(width: float, depth: float) -> list[BaseGeometry]:
    """Draw a corner sofa with a round table before it."""
    sofa = box(width - 0.9, depth - 2.4, width, depth).union(
        box(width - 2.6, depth - 0.9, width, depth)
    )
    return [sofa, Point(width - 2.2, depth - 2.2).buffer(0.4, quad_segs=3)]


def _meeting_room(width: float, depth: float) -> list[BaseGeometry]:
    """Draw a long table in the middle."""
    half_x, half_y = min(width / 2 - 1.2, 2.0), min(depth / 2 - 1.2, 0.9)
    x, y = width / 2, depth / 2 + 0.1
    return [box(x - half_x, y - half_y, x + half_x, y + half_y)]


def _team_office(width: float, depth: float) -> list[BaseGeometry]:
    """Draw islands of four desks, their heads at the window."""
    count = max(1, int((width - 1.1) / 2.7))
    middles = (np.arange(count) + 0.5) * width / count
    length = min(3.2, depth - 1.7)
    return [box(x - 0.8, depth - length, x + 0.8, depth) for x in middles]


_FURNISHINGS: tuple[tuple[Callable[[float, float], list[BaseGeometry]], float, float], ...] = (
    (_store, 0.0, 3.4),
    (_single_office, 2.9, 4.2),
    (_double_office, 3.4, 5.5),
    (_lounge, 3.8, 5.5),
    (_kitchen, 3.6, 5.0),
    (_meeting_room, 3.6, math.inf),
    (_team_office, 4.4, math.inf),
    (_team_office, 5.4, math.inf),
)
"""Furnishings of a room, with the minimum and maximum width of the room."""
