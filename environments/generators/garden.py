"""A square formal garden: beds, hedges and trees, with paths around all of them."""

import math
from collections.abc import Callable
from functools import lru_cache

import numpy as np
import shapely
from shapely import Point, Polygon, affinity, box
from shapely.geometry.base import BaseGeometry

from multisrt.environments.environment import Environment
from multisrt.environments.generators.parameters import call_text, number, seed_number, whole
from multisrt.environments.generators.passable import passable, starts_near
from multisrt.geometry.errors import InvalidInputError

HEDGE_M = 0.6
TREE_RADIUS_M = 0.4

Planting = Callable[[float, float], BaseGeometry]
"""Beds, hedges and trees of a plot, from its width and that of the paths, in metres."""


def garden(
    *, size_m: float = 28.0, plots: int = 4, path_m: float = 1.4, seed: int = 0
) -> Environment:
    """Draw a symmetric garden with a fountain in the middle.

    The left half mirrors the right half. Every plot has paths on all sides, and every hedge has
    several gaps, so that each area can be reached from several sides.

    Parameters
    ----------
    size_m : float
        Inner width and height, 10 to 150 m.
    plots : int
        Plots in each row and column, 2 to 30. A plot is at least 2.4 m and two paths wide.
    path_m : float
        Width of the paths and of the gaps in hedges, 0.9 to 3 m.
    seed : int
        Seed of the planting of the plots.

    Returns
    -------
    Environment
        The world, in metres, with suggested starts.

    Raises
    ------
    InvalidInputError
        If a parameter is out of range or the plots become too narrow.

    Examples
    --------
    >>> garden(size_m=20, plots=2).bounds
    (0.0, 0.0, 20.0, 20.0)
    """
    size_m = number("garden", "size_m", size_m, 10.0, 150.0)
    plots = whole("garden", "plots", plots, 2, 30)
    path_m = number("garden", "path_m", path_m, 0.9, 3.0)
    seed = seed_number("garden", seed)
    plot_m = (size_m - (plots + 1) * path_m) / plots
    least = 2 * path_m + 2.4
    if plot_m < least:
        raise InvalidInputError(
            f"garden: plots={plots} leaves plots of {plot_m:.3g} m, less than {least:.3g} m; "
            f"with size_m={size_m:g} and path_m={path_m:g} give fewer plots, "
            "narrower paths or a greater size_m"
        )

    rng = np.random.default_rng(seed)
    pitch = plot_m + path_m
    corner = path_m + plot_m / 2
    middle_plots = (plots // 2 - 1, plots // 2) if plots % 2 == 0 else (plots // 2,) * 2
    planted: list[BaseGeometry] = []
    deck: list[Planting] = []
    for row in range(plots):
        for column in range((plots + 1) // 2):
            if row in middle_plots and column in middle_plots:
                continue
            if not deck:
                deck = [_PLANTINGS[i] for i in rng.permutation(len(_PLANTINGS))]
            bed = _planted(deck.pop(), plot_m, path_m)
            for mirrored in sorted({column, plots - 1 - column}):
                planted.append(
                    affinity.translate(bed, corner + mirrored * pitch, corner + row * pitch)
                )
    middle = size_m / 2
    wide = plot_m if plots % 2 else 2 * plot_m + path_m
    planted.append(affinity.translate(_planted(_centrepiece, wide, path_m), middle, middle))

    ground = box(0.0, 0.0, size_m, size_m)
    free = passable(ground.difference(shapely.union_all(planted)), path_m)
    side = path_m / 2
    return Environment(
        "garden",
        free,
        starts=starts_near(
            free,
            [(middle, side), (side, middle), (middle, size_m - side), (size_m - side, middle)],
            clearance_m=0.4 * path_m,
        ),
        origin=call_text("garden", size_m=size_m, plots=plots, path_m=path_m, seed=seed),
    )


@lru_cache(maxsize=64)
def _planted(planting: Planting, width: float, path_m: float) -> BaseGeometry:
    # Gardens of one size are planted with the same few plots.
    return planting(width, path_m)


def _centrepiece(wide: float, path_m: float) -> BaseGeometry:
    """Plant a fountain and, where there is room, beds around it and hedges in the corners."""
    inner = 0.5 * wide - path_m
    if inner < 2 * path_m + 1.2:
        return _disc(0.3 * wide)
    basin = 0.35 * (inner - path_m)
    beds = _disc(inner).difference(_disc(basin + path_m))
    walks = shapely.union_all([_walk(wide, path_m, 45.0 + 90.0 * turn) for turn in range(4)])
    corners = box(-wide / 2, -wide / 2, wide / 2, wide / 2).difference(_disc(inner + path_m))
    tips = _cross(wide, 2 * path_m)
    return shapely.union_all([_disc(basin), beds.difference(walks), corners.difference(tips)])


# Plantings are centred on the origin.


def _hedged_round(plot: float, path_m: float) -> BaseGeometry:
    """Plant a square hedge open in the middle of each side, a round bed inside."""
    hedge = _square(plot).difference(_square(plot - 2 * HEDGE_M))
    return hedge.difference(_cross(plot, path_m)).union(_disc(plot / 2 - HEDGE_M - path_m))


def _hedged_square(plot: float, path_m: float) -> BaseGeometry:
    """Plant a square hedge open at its corners, a square bed inside."""
    hedge = _square(plot).difference(_square(plot - 2 * HEDGE_M))
    end = plot / 2 - HEDGE_M - path_m / math.sqrt(2.0)
    gap = box(end, end, plot, plot)
    gaps = [affinity.rotate(gap, 90.0 * turn, origin=(0.0, 0.0)) for turn in range(4)]
    return hedge.difference(shapely.union_all(gaps)).union(_square(plot - 2 * HEDGE_M - 2 * path_m))


def _quarters(plot: float, path_m: float) -> BaseGeometry:
    """Plant four beds, a round place where their paths meet."""
    return _square(plot).difference(shapely.union(_cross(plot, path_m), _disc(1.1 * path_m)))


def _diamond(plot: float, path_m: float) -> BaseGeometry:
    """Plant a diamond between four corner beds."""
    legs = (plot - path_m) / 2
    corner = Polygon([(0.0, 0.0), (legs, 0.0), (0.0, legs)])
    placed = affinity.translate(corner, -plot / 2, -plot / 2)
    corners = [affinity.rotate(placed, 90.0 * turn, origin=(0.0, 0.0)) for turn in range(4)]
    reach = plot - legs - math.sqrt(2.0) * path_m
    middle = Polygon([(reach, 0.0), (0.0, reach), (-reach, 0.0), (0.0, -reach)])
    return shapely.union_all([*corners, middle])


def _ring(plot: float, path_m: float) -> BaseGeometry:
    """Plant a round hedge with four gaps, a round bed inside."""
    hedge = _disc(plot / 2).difference(_disc(plot / 2 - HEDGE_M))
    gaps = [_walk(plot, path_m, 45.0 + 90.0 * turn) for turn in range(4)]
    return hedge.difference(shapely.union_all(gaps)).union(_disc(plot / 2 - HEDGE_M - path_m))


def _strips(plot: float, path_m: float) -> BaseGeometry:
    """Plant long beds side by side."""
    count = max(2, int((plot + path_m) / (path_m + 1.2)))
    width = (plot - (count - 1) * path_m) / count
    lefts = -plot / 2 + np.arange(count) * (width + path_m)
    return shapely.union_all(
        shapely.box(lefts, np.full(count, -plot / 2), lefts + width, np.full(count, plot / 2))
    )


def _trees(plot: float, path_m: float) -> BaseGeometry:
    """Plant an orchard: rows of trees."""
    pitch = path_m + 2 * TREE_RADIUS_M
    count = int((plot - 2 * TREE_RADIUS_M) / pitch) + 1
    step = (plot - 2 * TREE_RADIUS_M) / max(count - 1, 1)
    reach = np.arange(count) * step - (count - 1) * step / 2
    trunk = Point(0.0, 0.0).buffer(TREE_RADIUS_M, quad_segs=2)
    return shapely.union_all([affinity.translate(trunk, x, y) for x in reach for y in reach])


def _lawn(plot: float, path_m: float) -> BaseGeometry:
    """Plant one great bed with a bay for a bench on two sides."""
    bay = box(-0.6 * path_m, plot / 2 - 0.5 * path_m, 0.6 * path_m, plot)
    bays = bay.union(affinity.rotate(bay, 180.0, origin=(0.0, 0.0)))
    return _square(plot).difference(bays)


_PLANTINGS: tuple[Planting, ...] = (
    _hedged_round,
    _hedged_square,
    _quarters,
    _diamond,
    _ring,
    _strips,
    _trees,
    _lawn,
)


def _square(width: float) -> Polygon:
    return box(-width / 2, -width / 2, width / 2, width / 2)


def _disc(radius: float) -> Polygon:
    return Point(0.0, 0.0).buffer(radius, quad_segs=max(4, math.ceil(2.5 * radius)))


def _walk(length: float, path_m: float, angle_deg: float) -> Polygon:
    """Draw a straight path from the middle outwards."""
    straight = box(0.0, -path_m / 2, length, path_m / 2)
    return affinity.rotate(straight, angle_deg, origin=(0.0, 0.0))


def _cross(length: float, path_m: float) -> BaseGeometry:
    return shapely.union_all([_walk(length, path_m, 90.0 * turn) for turn in range(4)])
