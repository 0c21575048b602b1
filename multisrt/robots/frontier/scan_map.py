"""One robot's knowledge of the world: what it has seen, and what others have reported."""

from __future__ import annotations

from multisrt.geometry.bodies.footprint import Footprint
from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.grids.occupancy import Occupancy
from multisrt.geometry.numerics.kernel import FloatArray
from multisrt.geometry.regions.safe_region import LocalSafeRegion, local_safe_region
from multisrt.geometry.regions.scan import Scan
from multisrt.geometry.regions.shapes import Shape
from multisrt.robots.knowledge import Closing, Entries, Entry, Node, NodeId

CORNER_CELLS = 0.25
"""Added, in cells, to the distance that paths keep from walls, as driven paths cut corners."""


def raster_for(footprint: Footprint, cell_m: float, margin_m: float, robot: int) -> Occupancy:
    """Return an empty raster for the map of a robot.

    Parameters
    ----------
    footprint : Footprint
        Its body; paths over the raster have room for it in any heading.
    cell_m : float
        Width of a cell in metres.
    margin_m : float
        Distance in metres that the body keeps from what is not known to be free.
    robot : int
        Number of the robot, for the message of an error.

    Raises
    ------
    InvalidInputError
        If the cells are wider than the body.
    """
    if cell_m > footprint.width_m:
        raise InvalidInputError(
            f"cell_m is {cell_m:g}: cells are wider than the body of robot {robot}; "
            f"choose at most {footprint.width_m:g}"
        )
    keep_off_m = margin_m + CORNER_CELLS * cell_m
    return Occupancy(cell_m, footprint.circumscribed_radius_m + keep_off_m)


class ScanMap:
    """Scans as nodes, and the raster painted from them.

    Parameters
    ----------
    robot : int
        Number of the robot.
    raster : Occupancy
        Painted with the region of every node that is added.
    shape : {"ball", "star", "radial"}
        Shape of the regions.
    cones : int
        Number of equal cones of a star.

    Attributes
    ----------
    entries : Entries
        The nodes, of its own and from others.
    raster : Occupancy
        What is known of every cell.
    region : LocalSafeRegion or None
        The region of the last scan; None before the first.
    """

    def __init__(self, robot: int, raster: Occupancy, shape: Shape, cones: int) -> None:
        self.entries = Entries()
        self.raster = raster
        self.region: LocalSafeRegion | None = None
        self._robot = robot
        self._shape = shape
        self._cones = cones
        self._last: NodeId | None = None
        self._serial = 0

    @property
    def boundary(self) -> FloatArray:
        """Boundary of the region of the last scan, ``(n, 2)`` metres."""
        assert self.region is not None
        return self.region.boundary

    def view(self, scan: Scan) -> LocalSafeRegion:
        """Take a scan as the last one, without adding it to the map; return its region."""
        self.region = local_safe_region(scan, self._shape, cones=self._cones)
        return self.region

    def add(self, scan: Scan) -> Node | None:
        """Take a scan as the last one, and add it to the map.

        Returns
        -------
        Node or None
            The new node; None if the scan changed no cell. The first scan always makes one.
        """
        region = self.view(scan)
        before = self.raster.revision
        self.raster.add(region)
        # The revision also counts free cells that turn out to be occupied: others must hear of
        # these, or they would still drive there to look.
        if self.raster.revision == before and self._last is not None:
            return None
        node = Node(
            id=NodeId(self._robot, self._serial),
            configuration=scan.configuration,
            region=region,
            parent=self._last,
            time_s=scan.time_s,
        )
        self._serial += 1
        self.entries.add_node(node)
        self._last = node.id
        return node

    def merge(self, entries: tuple[Entry, ...]) -> tuple[NodeId, ...]:
        """Add what others sent; return the nodes that were new.

        Closings change no cell: they are kept for planners that go by arcs.
        """
        new = []
        for entry in entries:
            if isinstance(entry, Closing):
                self.entries.add_closing(entry)
            elif self.entries.add_node(entry):
                self.raster.add(entry.region)
                new.append(entry.id)
        return tuple(new)
