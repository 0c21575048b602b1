"""Small worlds for tests: free space as shapely polygons, and places in them.

Rooms and offices have straight walls with doors; clutter is irregular convex stones;
crates are turned boxes, right-angled and well apart.
"""

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import MultiPolygon, Polygon, affinity, box

from multisrt.geometry.regions.edge_index import EdgeIndex

Array = NDArray[np.float64]


def hall() -> Polygon:
    """Return an empty hall of 10 x 10 m."""
    return box(0, 0, 10, 10)


def pillar() -> Polygon:
    """Return a hall of 10 x 10 m with a pillar of 2 x 2 m in the middle."""
    return Polygon(hall().exterior, [box(4, 4, 6, 6).exterior])


def rooms(width: float = 18.0, count: int = 3, door: float = 1.5, wall: float = 0.15) -> Polygon:
    """Return count x count empty rooms, with doors between neighbours."""
    walls = _walls(width, count, door, wall, np.random.default_rng(0))
    return _free(width, walls)


def office(width: float = 20.0, count: int = 4, desks: int = 2, seed: int = 1) -> Polygon:
    """Return rooms with desks, one desk in four turned."""
    rng = np.random.default_rng(seed)
    solid = _walls(width, count, 1.0, 0.15, rng)
    room = width / count
    for i in range(count):
        for j in range(count):
            for _ in range(desks):
                x, y = rng.uniform(0.9, room - 0.9, 2)
                w, h = rng.uniform(0.25, 0.6, 2)
                desk = box(i * room + x - w, j * room + y - h, i * room + x + w, j * room + y + h)
                solid.append(affinity.rotate(desk, rng.choice([0.0, 0.0, 0.0, rng.uniform(0, 90)])))
    return _free(width, solid)


def clutter(width: float = 16.0, count: int = 220, seed: int = 2) -> Polygon:
    """Return a hall with many small stones of 5 to 11 corners, some of them overlapping."""
    rng = np.random.default_rng(seed)
    solid = []
    for _ in range(count):
        centre = rng.uniform(0, width, 2)
        radius, corners = rng.uniform(0.08, 0.3), int(rng.integers(5, 12))
        angles = np.sort(rng.uniform(0, 2 * np.pi, corners))
        reach = radius * rng.uniform(0.6, 1, corners)
        offsets = reach[:, None] * np.column_stack([np.cos(angles), np.sin(angles)])
        stone = Polygon(centre + offsets)
        if stone.is_valid:
            solid.append(stone)
    return _free(width, solid)


def crates(width: float = 20.0, size: float = 0.8, seed: int = 3) -> Polygon:
    """Return a hall with randomly turned boxes on a lattice, with passages between them."""
    rng = np.random.default_rng(seed)
    solid = []
    for x in np.arange(1.5, width - 1.0, 2.0):
        for y in np.arange(1.5, width - 1.0, 2.0):
            dx, dy = rng.uniform(-0.3, 0.3, 2)
            crate = box(x + dx - size / 2, y + dy - size / 2, x + dx + size / 2, y + dy + size / 2)
            solid.append(affinity.rotate(crate, rng.uniform(0, 90)))
    return _free(width, solid)


WORLDS = {"rooms": rooms, "office": office, "clutter": clutter, "crates": crates}


def edges(free: Polygon | MultiPolygon) -> Array:
    """Return the directed edges of free space, ``(n, 4)``, with free space on their left."""
    parts = shapely.get_parts(shapely.orient_polygons(free))
    rings = [ring for part in parts for ring in (part.exterior, *part.interiors)]
    corners = [np.asarray(ring.coords)[:, :2] for ring in rings]
    return np.vstack([np.hstack([ring[:-1], ring[1:]]) for ring in corners])


def index(free: Polygon | MultiPolygon, range_m: float = 4.0) -> EdgeIndex:
    """Return an edge index for queries of a range."""
    return EdgeIndex(edges(free), range_m / 3.0)


def viewpoints(free: Polygon, count: int, *, clearance: float = 0.15, seed: int = 0) -> Array:
    """Return random places that keep a clearance, ``(count, 2)``."""
    rng = np.random.default_rng(seed)
    inner = free.buffer(-clearance)
    shapely.prepare(inner)
    x0, y0, x1, y1 = free.bounds
    found = np.empty((0, 2))
    while len(found) < count:
        places = rng.uniform((x0, y0), (x1, y1), (4 * count, 2))
        found = np.vstack([found, places[shapely.contains_xy(inner, places)]])
    return found[:count]


def disc(x: float, y: float, radius: float) -> Polygon:
    """Return a polygon with 8000 corners on a circle, within 1e-7 of its radius everywhere."""
    angles = np.arange(8000) * (2 * np.pi / 8000)
    return Polygon(np.column_stack([x + radius * np.cos(angles), y + radius * np.sin(angles)]))


def _walls(
    width: float, count: int, door: float, wall: float, rng: np.random.Generator
) -> list[Polygon]:
    room, half = width / count, wall / 2
    walls = []
    for i in range(1, count):
        for j in range(count):
            for upright in (False, True):
                at = rng.uniform(0.4, room - 0.4 - door)
                begin, end = j * room, (j + 1) * room
                for low, high in (
                    (begin - half, begin + at),
                    (begin + at + door, end + half),
                ):
                    across = (i * room - half, i * room + half)
                    walls.append(
                        box(across[0], low, across[1], high)
                        if upright
                        else box(low, across[0], high, across[1])
                    )
    return walls


def _free(width: float, solid: list[Polygon]) -> Polygon:
    free = box(0, 0, width, width).difference(shapely.union_all(solid))
    largest = max(shapely.get_parts(free), key=lambda part: float(part.area))
    return shapely.normalize(shapely.simplify(largest, 0))
