"""A square field cluttered with obstacles of many shapes."""

import math
from collections.abc import Callable

import numpy as np
import shapely
from shapely import Point, Polygon, affinity, box
from shapely.geometry.base import BaseGeometry

from multisrt.environments.environment import Environment
from multisrt.environments.generators.parameters import call_text, number, seed_number
from multisrt.environments.generators.passable import passable, starts_near
from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.numerics import libm

TRIES = 500
"""Number of places tried for an obstacle before a smaller one is tried."""


def clutter(
    *,
    size_m: float = 25.0,
    cover: float = 0.12,
    obstacle_m: float = 3.0,
    passage_m: float = 1.0,
    seed: int = 0,
) -> Environment:
    """Draw a square field with obstacles: discs, boxes, triangles, stars, L, T and U shapes.

    Obstacles keep a distance of at least `passage_m` from each other and from the walls, so that
    robots can drive around each of them.

    Parameters
    ----------
    size_m : float
        Inner width and height, 5 to 250 m.
    cover : float
        Share of the field that obstacles cover, 0.02 to 0.25.
    obstacle_m : float
        Diameter of the largest obstacles, 1 to 6 m; the smallest have a third of it.
    passage_m : float
        Minimum distance between obstacles, 0.8 to 4 m.
    seed : int
        Seed of the shapes and places.

    Returns
    -------
    Environment
        The world, in metres, with suggested starts.

    Raises
    ------
    InvalidInputError
        If a parameter is out of range, or the obstacles do not fit.

    Examples
    --------
    >>> clutter(size_m=15, seed=2).origin
    'clutter(size_m=15, cover=0.12, obstacle_m=3, passage_m=1, seed=2)'
    """
    size_m = number("clutter", "size_m", size_m, 5.0, 250.0)
    cover = number("clutter", "cover", cover, 0.02, 0.25)
    obstacle_m = number("clutter", "obstacle_m", obstacle_m, 1.0, 6.0)
    passage_m = number("clutter", "passage_m", passage_m, 0.8, 4.0)
    seed = seed_number("clutter", seed)

    rng = np.random.default_rng(seed)
    field = box(0.0, 0.0, size_m, size_m)
    obstacles = _scatter(size_m, cover * field.area, obstacle_m, passage_m, rng)
    free = passable(field.difference(shapely.union_all(obstacles)), passage_m)
    near, middle, far = 1.0, size_m / 2, size_m - 1.0
    return Environment(
        "clutter",
        free,
        starts=starts_near(
            free,
            [(middle, middle), (near, near), (far, far), (near, far), (far, near)],
        ),
        origin=call_text(
            "clutter",
            size_m=size_m,
            cover=cover,
            obstacle_m=obstacle_m,
            passage_m=passage_m,
            seed=seed,
        ),
    )


def _scatter(
    size_m: float,
    area_m2: float,
    obstacle_m: float,
    passage_m: float,
    rng: np.random.Generator,
) -> list[BaseGeometry]:
    placed: list[BaseGeometry] = []
    centres, radii = np.empty((0, 2)), np.empty(0)
    covered, scale = 0.0, 1.0
    while covered < area_m2:
        diameter = obstacle_m * max(scale * rng.uniform(0.45, 1.0), 1 / 3)
        shape = _SHAPES[int(rng.integers(len(_SHAPES)))](diameter / 2, passage_m, rng)
        turned = affinity.rotate(shape, rng.uniform(0.0, 360.0), origin=(0.0, 0.0))
        for _ in range(TRIES):
            centre = rng.uniform(0.0, size_m, 2)
            obstacle = affinity.translate(turned, *centre)
            x0, y0, x1, y1 = obstacle.bounds
            if min(x0, y0) < passage_m or max(x1, y1) > size_m - passage_m:
                continue
            reach = radii + diameter / 2 + passage_m
            near = np.flatnonzero(((centres - centre) ** 2).sum(axis=1) < reach**2)
            if all(placed[i].distance(obstacle) >= passage_m for i in near):
                break
        else:
            if scale < 1 / 3:
                raise InvalidInputError(
                    f"clutter: cover={area_m2 / size_m**2:g} does not fit: obstacles cover "
                    f"{covered / size_m**2:.2g} of the field and no more of them keep "
                    f"passage_m={passage_m:g} apart; give a smaller cover, passage_m or "
                    f"obstacle_m than {obstacle_m:g}"
                )
            scale *= 0.8
            continue
        placed.append(obstacle)
        centres, radii = np.vstack([centres, centre]), np.append(radii, diameter / 2)
        covered += obstacle.area
    return placed


# Shapes are centred on the origin and fit into a disc of the given radius. Corners of a U reach
# 6 % beyond it, by which its test against neighbours is less strict.


def _disc(radius: float, passage_m: float, rng: np.random.Generator) -> BaseGeometry:
    return Point(0.0, 0.0).buffer(0.8 * radius, quad_segs=4)


def _box(radius: float, passage_m: float, rng: np.random.Generator) -> BaseGeometry:
    angle = rng.uniform(0.15 * math.pi, 0.25 * math.pi)
    width, height = radius * math.cos(angle), radius * math.sin(angle)
    return box(-width, -height, width, height)


def _triangle(radius: float, passage_m: float, rng: np.random.Generator) -> BaseGeometry:
    angles = np.array([0.0, 2.0, 4.0]) + rng.uniform(-0.35, 0.35, 3)
    return Polygon(radius * np.column_stack([libm.cos(angles), libm.sin(angles)]))


def _polygon(radius: float, passage_m: float, rng: np.random.Generator) -> BaseGeometry:
    corners = int(rng.integers(5, 9))
    angles = (np.arange(corners) + rng.uniform(-0.3, 0.3, corners)) * math.tau / corners
    return Polygon(radius * np.column_stack([libm.cos(angles), libm.sin(angles)]))


def _star(radius: float, passage_m: float, rng: np.random.Generator) -> BaseGeometry:
    tips = int(rng.integers(4, 7))
    angles = np.arange(2 * tips) * math.pi / tips
    reach = np.where(np.arange(2 * tips) % 2 == 0, radius, 0.5 * radius)
    return Polygon(reach[:, None] * np.column_stack([libm.cos(angles), libm.sin(angles)]))


def _l_shape(radius: float, passage_m: float, rng: np.random.Generator) -> BaseGeometry:
    side, thick = 0.7 * radius, 0.5 * radius
    return box(-side, -side, side, side).difference(box(-side + thick, -side + thick, side, side))


def _t_shape(radius: float, passage_m: float, rng: np.random.Generator) -> BaseGeometry:
    side, thick = 0.7 * radius, 0.25 * radius
    return box(-side, side - 2 * thick, side, side).union(box(-thick, -side, thick, side))


def _u_shape(radius: float, passage_m: float, rng: np.random.Generator) -> BaseGeometry:
    """Draw a U if a passage fits into it, else the box that it would fill."""
    side, thick = 0.75 * radius, max(0.2 * radius, 0.2)
    opening = side - thick
    if 2 * opening < 1.1 * passage_m:
        return box(-side, -side, side, side)
    return box(-side, -side, side, side).difference(box(-opening, -opening, opening, side))


_SHAPES: tuple[Callable[[float, float, np.random.Generator], BaseGeometry], ...] = (
    _disc,
    _box,
    _triangle,
    _polygon,
    _star,
    _l_shape,
    _t_shape,
    _u_shape,
)
