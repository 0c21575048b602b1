"""Worlds of the benchmarks: grids of rooms of any size, with or without desks."""

from __future__ import annotations

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import Polygon, affinity, box

WALL_M = 0.15

FloatArray = NDArray[np.float64]


def rooms(width: float = 40.0, count: int = 3) -> Polygon:
    """Return count x count empty rooms with a door in every wall."""
    return _free(width, _walls(width, count, 1.5, np.random.default_rng(0)))


def office(width: float = 40.0, count: int = 8, desks: int = 2, seed: int = 1) -> Polygon:
    """Return rooms of 5 m with desks, one in four of them turned; 1,200 edges at 40 m."""
    rng = np.random.default_rng(seed)
    solid = _walls(width, count, 1.0, rng)
    room = width / count
    for i in range(count):
        for j in range(count):
            for _ in range(desks):
                x, y = rng.uniform(0.9, room - 0.9, 2) + np.array([i, j]) * room
                w, h = rng.uniform(0.25, 0.6, 2)
                turn = rng.choice([0.0, 0.0, 0.0, rng.uniform(0, 90)])
                solid.append(affinity.rotate(box(x - w, y - h, x + w, y + h), turn))
    return _free(width, solid)


def edges(free: Polygon) -> FloatArray:
    """Return the ``(n, 4)`` directed edges of free space, which is on their left."""
    free = shapely.orient_polygons(free)
    rings = [np.asarray(ring.coords)[:, :2] for ring in (free.exterior, *free.interiors)]
    return np.vstack([np.hstack([ring[:-1], ring[1:]]) for ring in rings])


def viewpoints(free: Polygon, count: int, seed: int) -> FloatArray:
    """Return ``(count, 2)`` random places at least 0.15 m from all walls."""
    rng = np.random.default_rng(seed)
    inner = free.buffer(-0.15)
    shapely.prepare(inner)
    x0, y0, x1, y1 = free.bounds
    found = np.empty((0, 2))
    while len(found) < count:
        places = rng.uniform((x0, y0), (x1, y1), (2 * count, 2))
        found = np.vstack([found, places[shapely.contains_xy(inner, places)]])
    return found[:count]


def _walls(width: float, count: int, door: float, rng: np.random.Generator) -> list[Polygon]:
    room, half = width / count, WALL_M / 2
    walls = []
    for i in range(1, count):
        low, high = i * room - half, i * room + half
        for j in range(count):
            for upright in (False, True):
                begin, end = j * room - half, (j + 1) * room + half
                at = j * room + rng.uniform(0.4, room - 0.4 - door)
                for a, b in ((begin, at), (at + door, end)):
                    walls.append(box(low, a, high, b) if upright else box(a, low, b, high))
    return walls


def _free(width: float, solid: list[Polygon]) -> Polygon:
    free = box(0, 0, width, width).difference(shapely.union_all(solid))
    largest: Polygon = max(shapely.get_parts(free), key=lambda part: float(part.area))
    return shapely.normalize(shapely.simplify(largest, 0))
