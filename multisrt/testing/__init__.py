"""The checker for anyone's explorer."""

from multisrt.testing.check import CheckedExplorer, CheckedRun, check_explorer, two_rooms
from multisrt.testing.supervision import ExplorerDefect

__all__ = ["CheckedExplorer", "CheckedRun", "ExplorerDefect", "check_explorer", "two_rooms"]
