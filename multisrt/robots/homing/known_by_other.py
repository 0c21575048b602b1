"""What another robot, or the base station, is known to have of the nodes that this robot has."""

from __future__ import annotations

from collections.abc import Collection

from multisrt.geometry.grids.occupancy import Occupancy
from multisrt.robots.knowledge import CountsByRobot, Entries, EntryKey, NodeId


class KnownByOther:
    """Occupancy grid of the nodes that another robot, or the base station, is known to have.

    Parameters
    ----------
    entries : Entries
        The nodes of this robot.
    raster : Occupancy
        Occupancy grid of this robot, whose cell width and body radius are used.

    Attributes
    ----------
    raster : Occupancy
        The occupancy grid.

    Examples
    --------
    >>> known = KnownByOther(Entries(), Occupancy(0.1, 0.25))
    >>> known.take({0: (3, 0)})  # this robot has none of these nodes
    >>> known.raster.is_known(1.0, 1.0)
    False
    """

    def __init__(self, entries: Entries, raster: Occupancy) -> None:
        self.raster = Occupancy(raster.cell_m, raster.radius_m)
        self._entries = entries
        self._painted: dict[int, int] = {}
        self._painted_beyond: set[EntryKey] = set()

    def take(self, have: CountsByRobot, beyond: Collection[EntryKey] = ()) -> None:
        """Add the nodes that the other is known to have.

        Parameters
        ----------
        have : mapping of int to (nodes, closings)
            Number of nodes and closings that it has of each robot; never lower than in the last
            call.
        beyond : collection of EntryKey
            Entries that it has besides.
        """
        for robot, (count, _) in have.items():
            first = self._painted.get(robot, 0)
            for serial in range(first, count):
                node = self._entries.nodes.get(NodeId(robot, serial))
                if node is None:
                    # This robot lacks it; it is looked for again next time.
                    count = serial
                    break
                self.raster.add(node.region)
            self._painted[robot] = max(first, count)
        for key in sorted(set(beyond) - self._painted_beyond):
            robot, is_closing, serial = key
            node = None if is_closing else self._entries.nodes.get(NodeId(robot, serial))
            if node is not None:
                self.raster.add(node.region)
                self._painted_beyond.add(key)
