"""Where the numbers of robots stand on a map: at their starts, as far as there is room."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import product
from typing import Final, NamedTuple

import numpy as np

from multisrt.events import Point
from multisrt.geometry.numerics.kernel import FloatArray

BADGE_MM: Final = (1.3, 2.1)
"""Range of the radius of the badges of a team, which are smaller where starts are crowded."""

BADGE_SHARE: Final = 0.4
"""Radius of a badge as a share of the distance to the next start, clipped to `BADGE_MM`."""

APART: Final = 1.02 / BADGE_SHARE
"""Minimum distance of two badges, in radii: the tip of one does not reach the number of another."""

MAX_STEPS: Final = 400
"""Upper bound of the steps in which badges are moved apart."""

GOLDEN_ANGLE: Final = math.pi * (3.0 - math.sqrt(5.0))

Box = tuple[float, float, float, float]


class Disc(NamedTuple):
    """A marker that badges and labels keep clear of: centre and radius, in metres."""

    x: float
    y: float
    radius: float


def badge_radius_mm(starts: Sequence[Point], metres_per_mm: float) -> float:
    """Return the radius of the badges of a team, in millimetres on paper.

    Parameters
    ----------
    starts : sequence of (x, y)
        Starts of the robots, in metres.
    metres_per_mm : float
        Metres of the world per millimetre on paper.

    Returns
    -------
    float
        The radius in millimetres on paper.

    Examples
    --------
    >>> badge_radius_mm([(0.0, 0.0), (0.5, 0.0)], 0.125)
    1.6
    """
    if len(starts) < 2:
        return BADGE_MM[1]
    x, y = np.asarray(starts, np.float64).T
    apart = np.hypot(x[:, None] - x[None, :], y[:, None] - y[None, :])
    np.fill_diagonal(apart, np.inf)
    crowd = float(np.quantile(apart.min(axis=0), 0.1))
    return float(np.clip(BADGE_SHARE * crowd / metres_per_mm, *BADGE_MM))


def spread(
    places: Sequence[Point],
    radius: float,
    fixed: Sequence[Disc] = (),
    within: Box | None = None,
) -> FloatArray:
    """Move badges apart until none covers another one or a marker, as far as there is room.

    Parameters
    ----------
    places : sequence of (x, y)
        Where the badges belong.
    radius : float
        Radius of each badge.
    fixed : sequence of Disc
        Markers to keep clear of.
    within : (x0, y0, x1, y1), optional
        Box that badges do not leave.

    Returns
    -------
    (n, 2) array
        Where the badges stand. Those with enough room have not been moved.

    Examples
    --------
    >>> spread([(0.0, 0.0), (9.0, 0.0)], 1.0)
    array([[0., 0.],
           [9., 0.]])
    >>> near = spread([(0.0, 0.0), (1.0, 0.0)], 1.0)
    >>> bool(np.hypot(*(near[1] - near[0])) > 2.5)
    True
    """
    home = np.asarray(places, np.float64).reshape(-1, 2)
    at = home.copy()
    others = np.asarray(fixed, np.float64).reshape(-1, 3)
    for _ in range(MAX_STEPS):
        push = _push(at, at, np.full(len(at), APART * radius), 0.5)
        push += _push(at, others[:, :2], 1.05 * (radius + others[:, 2]), 1.0)
        if not push.any():
            break
        at = _kept(at + push, radius, within)
    return _kept(at, radius, within)


def _kept(at: FloatArray, radius: float, within: Box | None) -> FloatArray:
    if within is None:
        return at
    x0, y0, x1, y1 = within
    return np.clip(at, (x0 + radius, y0 + radius), (x1 - radius, y1 - radius))


def label_place(
    beside: Point, size: tuple[float, float], offset: float, taken: Sequence[Box]
) -> Point:
    """Return a place for a label beside a marker that covers as little as possible.

    Parameters
    ----------
    beside : (x, y)
        Centre of the marker.
    size : (width, height)
        Size of the label.
    offset : float
        Distance of the label from the centre of the marker.
    taken : sequence of (x0, y0, x1, y1)
        What should not be covered.

    Returns
    -------
    (x, y)
        The middle of the label.

    Examples
    --------
    >>> label_place((0.0, 0.0), (1.0, 1.0), 1.0, [])
    (1.5, 1.5)
    >>> label_place((0.0, 0.0), (1.0, 1.0), 1.0, [(0.5, 0.5, 3.0, 3.0)])
    (1.5, -1.5)
    """
    dx, dy = offset + 0.5 * size[0], offset + 0.5 * size[1]
    sides = [(a, b) for a, b in product((1, -1, 0), (1, -1, 0)) if a or b]
    # Farther away only if there is no room beside the marker.
    tries = [(beside[0] + f * a * dx, beside[1] + f * b * dy) for f in (1, 2) for a, b in sides]
    covered = [sum(_overlap(box_at(place, size), box) for box in taken) for place in tries]
    return tries[int(np.argmin(covered))]


def box_at(place: Point, size: tuple[float, float]) -> Box:
    """Return the box of a size around a place."""
    x, y = place
    return x - 0.5 * size[0], y - 0.5 * size[1], x + 0.5 * size[0], y + 0.5 * size[1]


def _overlap(a: Box, b: Box) -> float:
    width = min(a[2], b[2]) - max(a[0], b[0])
    height = min(a[3], b[3]) - max(a[1], b[1])
    return max(0.0, width) * max(0.0, height)


def _push(at: FloatArray, others: FloatArray, room: FloatArray, share: float) -> FloatArray:
    # How far each badge moves away from what is nearer to it than `room`.
    if not len(at) or not len(others):
        return np.zeros_like(at)
    away = at[:, None] - others[None, :]
    distance = np.hypot(away[..., 0], away[..., 1])
    lacking = np.maximum(0.0, room[None, :] - distance)
    if others is at:
        np.fill_diagonal(lacking, 0.0)
    # Badges at one place leave it in directions of their own.
    turn = GOLDEN_ANGLE * np.arange(len(at))
    own = np.stack([np.cos(turn), np.sin(turn)], axis=-1)
    same = distance < 1e-9
    direction = np.where(
        same[..., None], own[:, None], away / np.where(same, 1.0, distance)[..., None]
    )
    lacking[lacking < 1e-9] = 0.0
    # A little more than is lacking, so that the last steps end.
    moved: FloatArray = (1.02 * share * lacking[..., None] * direction).sum(axis=1)
    return moved
