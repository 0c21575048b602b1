"""The checker for new explorers."""

from multisrt.robots.defects import ExplorerDefect
from multisrt.testing.check import CheckedExplorer, check_explorer, two_rooms
from multisrt.testing.checked_run import CheckedRun
from multisrt.testing.unfinished import Unfinished

__all__ = [
    "CheckedExplorer",
    "CheckedRun",
    "ExplorerDefect",
    "Unfinished",
    "check_explorer",
    "two_rooms",
]
