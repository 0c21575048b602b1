"""Helpers for explorers of your own: maps, paths, motions, messages and decisions.

Everything here runs on a robot: it is made from scans, messages and the robot's own place.

>>> from multisrt.robots.toolkit import FrontierMap, places_of
"""

from multisrt.robots.messages import Message
from multisrt.robots.toolkit.decisions import decided
from multisrt.robots.toolkit.frontier_map import Frontier, FrontierMap
from multisrt.robots.toolkit.places import places_of
from multisrt.robots.toolkit.roadmap import NodeRoadmap
from multisrt.robots.toolkit.trajectories import trajectory, trajectory_inside

__all__ = [
    "Frontier",
    "FrontierMap",
    "Message",
    "NodeRoadmap",
    "decided",
    "places_of",
    "trajectory",
    "trajectory_inside",
]
