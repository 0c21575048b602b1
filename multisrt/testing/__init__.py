"""The checker for new explorers."""

from multisrt.robots.defects import ExplorerDefect
from multisrt.testing.cases import CheckedRun
from multisrt.testing.check import CheckedExplorer, check_explorer, two_rooms

__all__ = ["CheckedExplorer", "CheckedRun", "ExplorerDefect", "check_explorer", "two_rooms"]
