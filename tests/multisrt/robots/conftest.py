"""Maps of robots with a range of 3 m, and nodes by hand."""

from collections.abc import Callable, Iterable
from typing import Any

import numpy as np
import pytest

from multisrt.geometry.configuration import Configuration
from multisrt.geometry.regions.boundary import OBSTACLE, RANGE
from multisrt.geometry.regions.safe_region import LocalSafeRegion
from multisrt.robots.exploration_map import ExplorationMap, Node, NodeId

REACH_M = 3.0


def _node_of(serial: int, region: LocalSafeRegion, robot: int = 0) -> Node:
    return Node(
        id=NodeId(robot, serial),
        configuration=Configuration(region.x, region.y),
        region=region,
        parent=None if serial == 0 else NodeId(robot, serial - 1),
        time_s=float(serial),
    )


def _rectangle_node(
    serial: int, x0: float, y0: float, x1: float, y1: float, open_sides: str
) -> Node:
    sides = ("below", "right", "above", "left")
    region = LocalSafeRegion(
        x=(x0 + x1) / 2,
        y=(y0 + y1) / 2,
        range_m=REACH_M,
        boundary=np.array([(x0, y0), (x1, y0), (x1, y1), (x0, y1)]),
        tags=np.array([RANGE if side in open_sides else OBSTACLE for side in sides], np.int8),
    )
    return _node_of(serial, region)


def _new_map(**options: Any) -> ExplorationMap:
    return ExplorationMap(**{"reach_m": REACH_M, "min_arc_m": 0.5} | options)


def _map_of(nodes: Iterable[Node], **options: Any) -> ExplorationMap:
    known = _new_map(**options)
    for node in nodes:
        known.add(node)
    return known


@pytest.fixture(scope="session")
def node_of() -> Callable[..., Node]:
    """Build a node by its serial number and region; its parent is the node before it."""
    return _node_of


@pytest.fixture(scope="session")
def rectangle_node() -> Callable[..., Node]:
    """Build a node that sees a rectangle: its open sides are range, the others walls."""
    return _rectangle_node


@pytest.fixture(scope="session")
def new_map() -> Callable[..., ExplorationMap]:
    """Build an empty map of robots that are half a metre wide."""
    return _new_map


@pytest.fixture(scope="session")
def map_of() -> Callable[..., ExplorationMap]:
    """Build a map of nodes."""
    return _map_of
