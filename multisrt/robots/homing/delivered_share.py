"""The share of a robot's map that it has delivered, by which ``home="worth"`` decides.

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
from multisrt.robots.homing.known_by_other import KnownByOther
from multisrt.robots.knowledge import CountsByRobot, Entries, EntryKey


class DeliveredShare:
    """Share of a robot's known area that the base station has acknowledged.

    Areas are counted in the free cells of the robot's occupancy grid. Nodes that the base station
    has and the robot lacks do not count.

    Parameters
    ----------
    entries : Entries
        The nodes of the robot.
    raster : Occupancy
        Its occupancy grid, to which these have been added.

    Examples
    --------
    >>> delivered = DeliveredShare(Entries(), Occupancy(0.1, 0.25))
    >>> delivered.share({})  # nothing is known, so nothing is left to deliver
    1.0
    """

    def __init__(self, entries: Entries, raster: Occupancy) -> None:
        self._raster = raster
        self._delivered = KnownByOther(entries, raster)

    def delivered_m2(self, base_has: CountsByRobot, beyond: Collection[EntryKey] = ()) -> float:
        """Return the area of the nodes that the base station has, in square metres.

        Parameters
        ----------
        base_has : mapping of int to (nodes, closings)
            Number of nodes and closings that it has of each robot; never lower than in the last
            call.
        beyond : collection of EntryKey
            Entries that it has besides.
        """
        self._delivered.take(base_has, beyond)
        return self._area(self._delivered.raster)

    def share(self, base_has: CountsByRobot, beyond: Collection[EntryKey] = ()) -> float:
        """Return the share of the robot's known area that the base station has acknowledged.

        The parameters are those of `delivered_m2`.

        Returns
        -------
        float
            From 0 to 1.
        """
        delivered, whole = self.delivered_m2(base_has, beyond), self._area(self._raster)
        return 1.0 if whole <= delivered else delivered / whole

    @staticmethod
    def _area(raster: Occupancy) -> float:
        return float(np.count_nonzero(raster.cells == FREE)) * raster.cell_m**2
