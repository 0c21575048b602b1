"""The checker for new explorers."""

from multisrt.testing.cases import CheckedRun
from multisrt.testing.check import CheckedExplorer, check_explorer, two_rooms
from multisrt.testing.defects import ExplorerDefect

__all__ = ["CheckedExplorer", "CheckedRun", "ExplorerDefect", "check_explorer", "two_rooms"]
