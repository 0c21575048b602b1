"""Runs for other people's tools: MCAP files for Foxglove and ROS 2, and files of rerun."""

from multisrt.exporting.export import export_run
from multisrt.exporting.options import ExportOptions

__all__ = ["ExportOptions", "export_run"]
