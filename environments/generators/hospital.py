"""A hospital: a main street with an entrance hall, and long wings of wards off it."""

from collections.abc import Callable

import numpy as np
import shapely
from shapely import box
from shapely.geometry.base import BaseGeometry

from multisrt.environments.environment import Environment
from multisrt.environments.generators.bay import Bay, clear_zone, shared_widths
from multisrt.environments.generators.parameters import call_text, number, seed_number, whole
from multisrt.environments.generators.passable import passable, starts_near

WALL_M = 0.2
STREET_M = 3.0
CORRIDOR_M = 2.4
WARD_DEPTH_M = 4.8
CLINIC_DEPTH_M = 4.6
HALL_M = 8.0
DAY_ROOM_M = 4.4
COURT_M = 4.0
WING_M = 2 * (WARD_DEPTH_M + WALL_M) + CORRIDOR_M
BED_M = (2.1, 0.95)
DRAWS = 12
"""Number of random rows of rooms that are drawn, of which the best fitting one is built."""

Furnish = Callable[[float, float], list[BaseGeometry]]
"""Furniture of a room in its own frame, from its width and depth."""


def hospital(
    *,
    wings: int = 3,
    wing_length_m: float = 22.0,
    door_m: float = 1.2,
    links: float = 0.6,
    seed: int = 0,
) -> Environment:
    """Draw a hospital of parallel wings with courts between them.

    Each wing has a corridor with wards, single rooms and stores on both sides, a nurse station
    open to the corridor at half its length, and a day room at its end. Links between
    neighbouring day rooms close loops.

    Parameters
    ----------
    wings : int
        Number of wings, 1 to 12; each adds 16.4 m to the width.
    wing_length_m : float
        Length of the wings, 16 to 120 m.
    door_m : float
        Width of the doors, 0.9 to 1.6 m.
    links : float
        Probability, from 0 to 1, of a link between two neighbouring wings.
    seed : int
        Seed of the rooms, their furniture and the links.

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
    >>> hospital(wings=1).name
    'hospital'
    """
    wings = whole("hospital", "wings", wings, 1, 12)
    wing_length_m = number("hospital", "wing_length_m", wing_length_m, 16.0, 120.0)
    door_m = number("hospital", "door_m", door_m, 0.9, 1.6)
    links = number("hospital", "links", links, 0.0, 1.0)
    seed = seed_number("hospital", seed)

    rng = np.random.default_rng(seed)
    width = wings * WING_M + (wings - 1) * COURT_M
    street_y = CLINIC_DEPTH_M + WALL_M
    wing_y = street_y + STREET_M
    top = wing_y + wing_length_m
    plan = _Plan(door_m, rng)
    plan.open(box(0.0, street_y, width, wing_y))
    hall = _clinic_row(plan, width, street_y)
    lefts = [wing * (WING_M + COURT_M) for wing in range(wings)]
    for left in lefts:
        _wing(plan, left, wing_y, wing_length_m)
    linked = rng.random(wings - 1) < links
    for left in (left for left, link in zip(lefts, linked, strict=False) if link):
        low = top - DAY_ROOM_M / 2 - 1.0
        plan.open(box(left + WING_M, low, left + WING_M + COURT_M, low + 2.0))

    free = passable(plan.free(), door_m)
    middle = CORRIDOR_M / 2
    ends = [(left + WING_M / 2, top - DAY_ROOM_M + 1.0) for left in lefts]
    return Environment(
        "hospital",
        free,
        starts=starts_near(
            free, [(hall, street_y - 1.0), *ends, (middle, street_y + STREET_M / 2)]
        ),
        origin=call_text(
            "hospital",
            wings=wings,
            wing_length_m=wing_length_m,
            door_m=door_m,
            links=links,
            seed=seed,
        ),
    )


class _Plan:
    """An unfinished drawing: floors and openings, and the furniture on them."""

    def __init__(self, door_m: float, rng: np.random.Generator) -> None:
        self.door_m = door_m
        self.rng = rng
        self._floors: list[BaseGeometry] = []
        self._furniture: list[BaseGeometry] = []

    def open(self, *floors: BaseGeometry) -> None:
        self._floors += floors

    def furnish(self, bay: Bay, pieces: list[BaseGeometry]) -> None:
        self._furniture += map(bay.place, pieces)

    def free(self) -> BaseGeometry:
        return shapely.union_all(self._floors).difference(shapely.union_all(self._furniture))


def _clinic_row(plan: _Plan, width: float, street_y: float) -> float:
    """Draw the entrance hall and the consulting rooms; return the middle x of the hall."""
    row = Bay(
        x=0.0,
        y=street_y - WALL_M,
        along=(1.0, 0.0),
        inward=(0.0, -1.0),
        width_m=width,
        depth_m=CLINIC_DEPTH_M,
    )
    side = round((width - HALL_M) / 2 - WALL_M, 2)
    left, hall, right = row.split(np.array([side, width - side * 2 - 2 * WALL_M, side]), WALL_M)
    for part in (left, right):
        count = max(1, round(part.width_m / 4.0))
        shares = plan.rng.choice([0.9, 1.0, 1.4], size=count)
        for room in part.split(shared_widths(part.width_m, shares, WALL_M), WALL_M):
            _room(plan, room, _waiting_room if room.width_m > 5.0 else _consulting_room)
    plan.open(hall.floor(), hall.doorway(hall.width_m / 2, hall.width_m, WALL_M))
    plan.furnish(hall, [box(2.0, 2.0, hall.width_m - 2.0, 2.8)])
    return hall.x + hall.width_m / 2


def _wing(plan: _Plan, left: float, low: float, length: float) -> None:
    """Draw one wing: corridor, rooms on both sides, day room across the end."""
    corridor_x = left + WARD_DEPTH_M + WALL_M
    rows_end = low + length - DAY_ROOM_M - WALL_M
    day_room = box(left, rows_end + WALL_M, left + WING_M, low + length)
    plan.open(box(corridor_x, low, corridor_x + CORRIDOR_M, rows_end + WALL_M), day_room)
    sofas = Bay(
        x=left,
        y=rows_end + WALL_M,
        along=(1.0, 0.0),
        inward=(0.0, 1.0),
        width_m=WING_M,
        depth_m=DAY_ROOM_M,
    )
    plan.furnish(
        sofas,
        [
            box(1.6, 1.5, 3.4, 2.9),
            box(WING_M - 3.4, 1.5, WING_M - 1.6, 2.9),
            box(WING_M / 2 - 1.5, DAY_ROOM_M - 0.8, WING_M / 2 + 1.5, DAY_ROOM_M),
        ],
    )
    station_side = int(plan.rng.integers(2))
    for side, (x, inward) in enumerate(
        ((corridor_x - WALL_M, -1.0), (corridor_x + CORRIDOR_M + WALL_M, 1.0))
    ):
        row = Bay(
            x=x,
            y=low + WALL_M,
            along=(0.0, 1.0),
            inward=(inward, 0.0),
            width_m=rows_end - low - WALL_M,
            depth_m=WARD_DEPTH_M,
        )
        _ward_row(plan, row, with_station=side == station_side)


def _ward_row(plan: _Plan, row: Bay, *, with_station: bool) -> None:
    """Fill one side of a wing with rooms, the nurse station in the middle of it."""
    rooms = min(
        (_ward_rooms(plan, row.width_m, with_station=with_station) for _ in range(DRAWS)),
        key=lambda drawn: abs(sum(length + WALL_M for _, length in drawn) - row.width_m),
    )
    middle = len(rooms) // 2
    shares = np.array([length for _, length in rooms])
    bays = row.split(shared_widths(row.width_m, shares, WALL_M), WALL_M)
    for index, (bay, (furnish, _)) in enumerate(zip(bays, rooms, strict=True)):
        if with_station and index == middle:
            plan.open(bay.floor(), bay.doorway(bay.width_m / 2, bay.width_m, WALL_M))
            plan.furnish(bay, furnish(bay.width_m, bay.depth_m))
        else:
            _room(plan, bay, furnish)


def _ward_rooms(
    plan: "_Plan", length_m: float, *, with_station: bool
) -> list[tuple[Furnish, float]]:
    """Draw random rooms until they roughly fill a length."""
    rooms: list[tuple[Furnish, float]] = []
    while sum(length + WALL_M for _, length in rooms) < length_m - 1.0:
        rooms.append(_WARD_ROOMS[int(plan.rng.choice(len(_WARD_ROOMS), p=_WARD_CHANCES))])
    if with_station:
        rooms[len(rooms) // 2] = (_nurse_station, 5.6)
    return rooms


# Rooms are drawn in their own frame: the door is in the wall y = 0.


def _room(plan: _Plan, room: Bay, furnish: Furnish) -> None:
    """Draw a room with a door: in the middle of wide rooms, at one side of narrow ones."""
    narrow = room.width_m < 5.0
    door_at = plan.door_m / 2 + 0.3 if narrow else room.width_m / 2
    if narrow and plan.rng.random() < 0.5:
        room = room.mirrored()
    kept_free = clear_zone(door_at, plan.door_m, 1.2)
    pieces = [
        piece for piece in furnish(room.width_m, room.depth_m) if not piece.intersects(kept_free)
    ]
    plan.open(room.floor(), room.doorway(door_at, plan.door_m, WALL_M))
    plan.furnish(room, pieces)


def _ward(width: float, depth: float) -> list[BaseGeometry]:
    """Draw beds with their heads at the side walls: at both if the ward is wide enough."""
    length, breadth = BED_M
    count = int((depth - 0.85) / (breadth + 0.85))
    gap = (depth - count * breadth) / (count + 1)
    lows = [gap + index * (breadth + gap) for index in range(count)]
    heads = (0.0, width - length) if width > 2 * length + 1.4 else (width - length,)
    return [box(left, low, left + length, low + breadth) for low in lows for left in heads]


def _single_room(width: float, depth: float) -> list[BaseGeometry]:
    """Draw one bed, a cupboard beside the door."""
    length, breadth = BED_M
    low = depth - 1.2 - breadth
    return [box(width - length, low, width, low + breadth), box(width - 0.6, 0.0, width, 1.1)]


def _bathroom(width: float, depth: float) -> list[BaseGeometry]:
    """Draw a tub along the far wall, basins along one side."""
    return [box(0.0, depth - 0.8, width, depth), box(width - 0.5, 0.0, width, depth - 2.4)]


def _store(width: float, depth: float) -> list[BaseGeometry]:
    """Draw shelves along both side walls and the far one."""
    return [
        box(0.0, 1.3, 0.5, depth),
        box(width - 0.5, 0.0, width, depth),
        box(0.0, depth - 0.5, width, depth),
    ]


def _nurse_station(width: float, depth: float) -> list[BaseGeometry]:
    """Draw a counter in a U towards the corridor, cupboards at the far wall."""
    outer = box(1.3, 0.2, width - 1.3, 2.6)
    inner = box(1.9, 0.8, width - 1.9, 2.6)
    return [outer.difference(inner), box(0.0, depth - 0.5, width, depth)]


def _consulting_room(width: float, depth: float) -> list[BaseGeometry]:
    """Draw a couch at the far wall, a desk with its end at the side wall."""
    return [box(0.0, depth - 0.8, 2.0, depth), box(width - 0.75, 1.2, width, depth - 2.0)]


def _waiting_room(width: float, depth: float) -> list[BaseGeometry]:
    """Draw benches along three walls and a table."""
    benches = box(0.0, 1.2, width, depth).difference(box(0.6, 0.0, width - 0.6, depth - 0.6))
    x, y = width / 2, 0.55 * depth
    return [benches, box(x - 0.6, y - 0.4, x + 0.6, y + 0.4)]


_WARD_ROOMS: tuple[tuple[Furnish, float], ...] = (
    (_ward, 6.4),
    (_single_room, 3.6),
    (_bathroom, 2.8),
    (_store, 2.8),
)
_WARD_CHANCES = (0.5, 0.26, 0.12, 0.12)
