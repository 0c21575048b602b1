"""Worlds, maps, trees and trajectories as files, and runs for Foxglove, ROS 2 and rerun."""

from multisrt.exporting.export import export_run
from multisrt.exporting.known_map import known_map
from multisrt.exporting.map_content import MapOptions
from multisrt.exporting.options import ExportOptions
from multisrt.exporting.trajectories import save_trajectories
from multisrt.exporting.trees import save_trees
from multisrt.exporting.worlds import save_environment, save_map, save_world

__all__ = [
    "ExportOptions",
    "MapOptions",
    "export_run",
    "known_map",
    "save_environment",
    "save_map",
    "save_trajectories",
    "save_trees",
    "save_world",
]
