"""Runs for other people's tools: MCAP files for Foxglove and ROS 2, and files of rerun."""

from multisrt.exporting.export import FORMATS, export_run, require_format
from multisrt.exporting.options import ExportOptions

__all__ = ["FORMATS", "ExportOptions", "export_run", "require_format"]
