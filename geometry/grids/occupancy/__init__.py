"""A robot's knowledge of the world as a raster: free and occupied cells, and their frontier.

A cell is identified by its row and column in an infinite lattice, which the cell width alone
determines. These indices are independent of the window of cells that is stored, and two
occupancies of equal cell width mean the same place by the same indices.
"""

from multisrt.geometry.grids.occupancy.frontier_groups import FrontierGroup
from multisrt.geometry.grids.occupancy.layers import FREE, OCCUPIED, UNKNOWN
from multisrt.geometry.grids.occupancy.occupancy import Occupancy

__all__ = ["FREE", "OCCUPIED", "UNKNOWN", "FrontierGroup", "Occupancy"]
