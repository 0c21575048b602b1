"""All planted defects by name, and the control without one."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Final

from benchmarks.mutants import of_robots, of_simulation
from benchmarks.mutants.mutant import Mutant

MUTANTS: Final[Mapping[str, Mutant]] = MappingProxyType(
    {mutant.name: mutant for mutant in (*of_simulation.MUTANTS, *of_robots.MUTANTS)}
)
"""The defects, in the order in which they are tried."""

CONTROL: Final = "control"
"""Name of the program without any defect, of which a campaign must find nothing."""
