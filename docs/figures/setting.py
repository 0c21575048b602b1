"""Two worlds, a body and a range finder: the setting of all pictures of the algorithms."""

from __future__ import annotations

import shapely
from sketch import plan, wall

from multisrt.environments.environment import Environment
from multisrt.geometry.bodies.footprint import Footprint
from multisrt.geometry.configuration import Configuration
from multisrt.geometry.regions.edge_index import EdgeIndex
from multisrt.geometry.regions.safe_region import LocalSafeRegion, Shape, local_safe_region
from multisrt.geometry.regions.scan import take_scan

RANGE_M = 4.0
BODY = Footprint.disc(0.25)
FLAT = plan(
    "flat",
    wall(0.2, 0.2, 13.8, 8.2),
    [
        wall(7.0, 0.2, 7.25, 3.4),
        wall(7.0, 4.4, 7.25, 8.2),
        wall(4.6, 5.2, 5.3, 6.1),
        wall(9.6, 4.7, 13.8, 4.95),
        wall(1.6, 1.0, 2.4, 1.6),
        shapely.Point(10.4, 2.2).buffer(0.45),
    ],
)
FLOOR = plan(
    "floor",
    wall(0.2, 0.2, 17.8, 9.8),
    [
        wall(0.2, 4.0, 3.4, 4.2),
        wall(4.6, 4.0, 9.6, 4.2),
        wall(10.8, 4.0, 17.8, 4.2),
        wall(0.2, 6.0, 7.2, 6.2),
        wall(8.4, 6.0, 13.4, 6.2),
        wall(14.6, 6.0, 17.8, 6.2),
        wall(6.4, 0.2, 6.6, 4.0),
        wall(10.9, 6.2, 11.1, 9.8),
    ],
)


def region_at(
    environment: Environment, x: float, y: float, shape: Shape = "radial"
) -> LocalSafeRegion:
    """Return the local safe region of the exact scan at a place."""
    index = EdgeIndex(environment.edges, RANGE_M / 3.0)
    return local_safe_region(take_scan(index, Configuration(x, y), 0.0, RANGE_M), shape)
