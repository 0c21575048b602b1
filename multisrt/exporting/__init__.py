"""Worlds as map files, and runs for other people's tools: Foxglove, ROS 2 and rerun."""

from multisrt.exporting.export import export_run
from multisrt.exporting.options import ExportOptions
from multisrt.exporting.worlds import save_environment

__all__ = ["ExportOptions", "export_run", "save_environment"]
