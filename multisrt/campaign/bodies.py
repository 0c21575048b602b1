"""Bodies as their spec describes them, without what the simulation computes of them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import Polygon
from shapely.geometry.base import BaseGeometry

from multisrt.geometry.numerics import libm
from multisrt.spec import RunSpec

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class Body:
    """A disc, or a polygon, about its reference point.

    Attributes
    ----------
    radius_m : float
        Radius of a disc in metres; 0 for a polygon.
    outline : Polygon or None
        Outline of a polygon in the frame of the body, in metres; None for a disc.
    """

    radius_m: float
    outline: Polygon | None

    @property
    def inscribed_m(self) -> float:
        """Radius of the largest disc around the reference point in the body."""
        if self.outline is None:
            return self.radius_m
        return float(self.outline.boundary.distance(shapely.Point(0.0, 0.0)))

    @property
    def circumscribed_m(self) -> float:
        """Distance of the reference point to the farthest point of the body."""
        if self.outline is None:
            return self.radius_m
        return float(np.hypot(*shapely.get_coordinates(self.outline).T).max())

    @property
    def width_m(self) -> float:
        """Width of the narrowest straight passage that the body fits through."""
        if self.outline is None:
            return 2.0 * self.radius_m
        corners = shapely.get_coordinates(self.outline.convex_hull)
        along = np.diff(corners, axis=0)
        across = np.column_stack([-along[:, 1], along[:, 0]]) / np.hypot(*along.T)[:, None]
        # The least extent is that across a side.
        return float(np.ptp(libm.product(corners, across.T), axis=0).min())

    def pieces(self) -> list[FloatArray]:
        """Return triangles that make up a polygon, each ``(3, 2)``."""
        triangles = shapely.get_parts(shapely.constrained_delaunay_triangles(self.outline))
        return [shapely.get_coordinates(triangle)[:3] for triangle in triangles]

    def at(self, poses: FloatArray) -> list[BaseGeometry]:
        """Return the body at some poses ``(n, 3)``; of a disc the centre."""
        if self.outline is None:
            return [shapely.Point(x, y) for x, y in poses[:, :2].tolist()]
        corners = shapely.get_coordinates(self.outline)
        shapes: list[BaseGeometry] = np.asarray(shapely.polygons(placed(corners, poses))).tolist()
        return shapes


def placed(corners: FloatArray, poses: FloatArray) -> FloatArray:
    """Return corners ``(k, 2)`` at some poses ``(n, 3)``, as ``(n, k, 2)``."""
    cos, sin = np.cos(poses[:, 2])[:, None], np.sin(poses[:, 2])[:, None]
    x, y = corners[:, 0], corners[:, 1]
    return np.stack([poses[:, :1] + cos * x - sin * y, poses[:, 1:2] + sin * x + cos * y], axis=-1)


def bodies_of(spec: RunSpec) -> list[Body]:
    """Return the bodies of a team."""
    return [body_of(robot.footprint) for robot in spec.robots]


def body_of(text: str) -> Body:
    """Return the body that a text describes: ``disc:R``, ``box:LxW`` or ``polygon:X,Y ...``.

    Examples
    --------
    >>> body_of("disc:0.25").inscribed_m, round(body_of("box:0.6x0.4").inscribed_m, 9)
    (0.25, 0.2)
    """
    kind, _, numbers = text.partition(":")
    if kind == "disc":
        return Body(radius_m=float(numbers), outline=None)
    if kind == "box":
        length, width = map(float, numbers.split("x"))
        outline = shapely.box(-length / 2, -width / 2, length / 2, width / 2)
        return Body(radius_m=0.0, outline=outline)
    corners = [tuple(map(float, word.split(","))) for word in numbers.split()]
    return Body(radius_m=0.0, outline=Polygon(corners))
