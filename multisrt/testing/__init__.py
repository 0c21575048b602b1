"""The checker for new explorers."""

from multisrt.robots.defects import ExplorerDefect
from multisrt.testing.check import CheckedExplorer, check_explorer, two_rooms
from multisrt.testing.checked_run import CheckedRun

__all__ = ["CheckedExplorer", "CheckedRun", "ExplorerDefect", "check_explorer", "two_rooms"]
