"""The nodes that a robot knows with their regions, by number, by place and by id."""

from __future__ import annotations

import math

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely.geometry.base import BaseGeometry

from multisrt.geometry.numerics.arrays import grown, roomier
from multisrt.geometry.numerics.kernel import IntArray
from multisrt.geometry.numerics.point_hash import PointHash
from multisrt.geometry.numerics.rings import Rings
from multisrt.geometry.regions.known_space import KnownSpace
from multisrt.geometry.regions.overlay import union_on_grid
from multisrt.geometry.regions.union_border import UnionBorder
from multisrt.robots.knowledge import Node, NodeId

Box = tuple[float, float, float, float]


class NodeRegions:
    """Nodes and the boundaries of their regions, numbered in the order in which they are added.

    Parameters
    ----------
    reach_m : float
        Maximum distance in metres of a region's boundary from its node.

    Attributes
    ----------
    reach_m : float
        As given.
    ids : list of NodeId
        The id of every node, by its number.
    id_rows : (c, 2) array of int
        The same for kernels; there may be room for more behind the last.
    numbers : dict of NodeId to int
        The number of every node.
    places : PointHash
        The places of the nodes.
    rings : Rings
        The boundaries of the regions.
    """

    __slots__ = ("_border", "id_rows", "ids", "numbers", "places", "reach_m", "rings")

    def __init__(self, reach_m: float) -> None:
        self.reach_m = reach_m
        self.ids: list[NodeId] = []
        self.id_rows: IntArray = np.zeros((0, 2), np.int64)
        self.numbers: dict[NodeId, int] = {}
        self.places = PointHash(reach_m)
        self.rings = Rings()
        self._border = UnionBorder(self.rings)

    def __len__(self) -> int:
        return len(self.ids)

    def add(self, node: Node) -> int:
        """Add a node and return its number."""
        number = self.rings.add(node.region.boundary)
        if number == len(self.id_rows):
            self.id_rows = grown(self.id_rows, roomier(number, number + 1))
        self.id_rows[number] = node.id
        self.places.add(node.configuration.x, node.configuration.y)
        self.ids.append(node.id)
        self.numbers[node.id] = number
        return number

    def pairs_near(self, first: int, radius_m: float) -> IntArray:
        """Return pairs of nodes; see `ExplorationMap.pairs_near`."""
        pairs = self.places.pairs(first, radius_m)
        ids = self.id_rows[pairs[:, 1]]
        return pairs[np.lexsort((ids[:, 1], ids[:, 0], pairs[:, 0]))]

    def in_window(self, x: float, y: float, half_width_m: float) -> tuple[Box, IntArray]:
        """Return a square window, and the nodes whose regions' boxes meet it, ordered by id."""
        window = (x - half_width_m, y - half_width_m, x + half_width_m, y + half_width_m)
        near = self.places.within(x, y, math.sqrt(2.0) * half_width_m + self.reach_m)
        near = self.rings.meeting(near, window)
        return window, np.array(sorted(near.tolist(), key=self.ids.__getitem__), np.int64)

    def known_space(self, x: float, y: float, half_width_m: float) -> KnownSpace:
        """Return the union of the regions inside a window, for bodies that move in it."""
        window, near = self.in_window(x, y, half_width_m)
        return KnownSpace(self.rings, near, window, self._border)

    def local_union(self, x: float, y: float, half_width_m: float) -> BaseGeometry:
        """Return the union of the regions inside a window, as a shapely geometry."""
        window, near = self.in_window(x, y, half_width_m)
        return union_on_grid(shapely.intersection(self._polygons(near), shapely.box(*window)))

    def _polygons(self, numbers: IntArray) -> NDArray[np.object_]:
        # The regions as shapely polygons, all made at once.
        if not len(numbers):
            return np.empty(0, np.object_)
        corners = [self.rings.ring(number) for number in numbers.tolist()]
        owners = np.repeat(np.arange(len(corners)), [len(ring) for ring in corners])
        rings = shapely.linearrings(np.concatenate(corners), indices=owners)
        return np.asarray(shapely.polygons(rings), np.object_)
