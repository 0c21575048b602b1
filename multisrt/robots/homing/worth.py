"""Home when what a robot carries is worth it: the share of its map that the base station knows.

Source: J. de Hoog, Role-based multi-robot exploration, thesis, Oxford 2011, and the simulator
MRESim (exploration by frontiers with return by utility): a robot goes to the base station when
``known / (known + new)`` falls below a threshold, where *known* is what the base station knows and
*new* what the robot could tell it. Differs in: both are areas of regions, not counts; what the base
station knows is what it has acknowledged, and not a guess.
"""

from __future__ import annotations

from collections.abc import Collection

import numpy as np

from multisrt.geometry.grids.occupancy import Occupancy
from multisrt.geometry.grids.occupancy.layers import FREE
from multisrt.robots.homing.their_map import TheirMap
from multisrt.robots.knowledge import CountsByRobot, Entries, EntryKey


class NewsWorth:
    """The area that the base station knows, and that which a robot could tell it.

    Areas are counted in the cells of the robot's raster, as far as this robot knows of the nodes.

    Parameters
    ----------
    entries : Entries
        The nodes of the robot.
    raster : Occupancy
        Its raster, in which these are painted.

    Examples
    --------
    >>> worth = NewsWorth(Entries(), Occupancy(0.1, 0.25))
    >>> worth.ratio({})  # nothing is known: nothing is new
    1.0
    """

    def __init__(self, entries: Entries, raster: Occupancy) -> None:
        self._raster = raster
        self._theirs = TheirMap(entries, raster)

    def known_m2(self, base_has: CountsByRobot, beyond: Collection[EntryKey] = ()) -> float:
        """Return the area of the nodes that the base station has, in square metres.

        Parameters
        ----------
        base_has : mapping of int to (nodes, closings)
            What it has; counts never fall from call to call.
        beyond : collection of EntryKey
            What it has besides.
        """
        self._theirs.take(base_has, beyond)
        return self._area(self._theirs.raster)

    def ratio(self, base_has: CountsByRobot, beyond: Collection[EntryKey] = ()) -> float:
        """Return the share of what is known here that the base station knows, from 0 to 1.

        The parameters are those of `known_m2`.
        """
        known, whole = self.known_m2(base_has, beyond), self._area(self._raster)
        return 1.0 if whole <= known else known / whole

    @staticmethod
    def _area(raster: Occupancy) -> float:
        return float(np.count_nonzero(raster.cells == FREE)) * raster.cell_m**2
