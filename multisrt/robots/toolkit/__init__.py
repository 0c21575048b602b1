"""Helpers for explorers of your own: maps, paths, motions, messages and decisions.

Everything here runs on a robot: it uses only scans, messages and the robot's own place.
`multisrt strategy new` writes explorers that use it.

==================== ==============================================================================
`assignment`         a strategy made of a rule that assigns frontiers to robots of the frontier
                     family
`RegionExplorer`     an explorer that only chooses places in its map of local safe regions
`FrontierMap`        a raster of what a robot knows: frontiers, path lengths and paths
`NodeRoadmap`        straight paths between the nodes of an `ExplorationMap`, and paths over them
`trajectory`         the motion through places, for every kind of drive
`trajectory_inside`  the same, as far as the body stays in a region known to be free
`Message`            the base class of messages with custom content
`decided`            records a decision with custom text and numbers
`places_of`          an array of places that are given in any form
==================== ==============================================================================

>>> from multisrt.robots.toolkit import FrontierMap, places_of
"""

from multisrt.robots.messages import Message
from multisrt.robots.toolkit.assignment import assignment
from multisrt.robots.toolkit.decisions import decided
from multisrt.robots.toolkit.frontier_map import Frontier, FrontierMap
from multisrt.robots.toolkit.places import places_of
from multisrt.robots.toolkit.region_explorer import RegionExplorer, RegionOptions, Teammate
from multisrt.robots.toolkit.roadmap import NodeRoadmap
from multisrt.robots.toolkit.trajectories import trajectory, trajectory_inside

__all__ = [
    "Frontier",
    "FrontierMap",
    "Message",
    "NodeRoadmap",
    "RegionExplorer",
    "RegionOptions",
    "Teammate",
    "assignment",
    "decided",
    "places_of",
    "trajectory",
    "trajectory_inside",
]
