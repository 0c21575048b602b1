"""Local safe regions: what a robot takes as surely free around the place of a scan.

Three shapes, by how much of the readings they keep:

- *radial*: every reading in its own direction, so the whole visibility polygon;
- *star*: equal cones, each cut at its smallest reading;
- *ball*: a disc of the smallest reading.

Every piece of a region's boundary is tagged with why the region ends there: `OBSTACLE`, `RANGE`,
`GAP`, or `CUT` where a star or a ball leaves out space that the readings show to be free.

Source: Oriolo et al. 2004 (ball and star) and Espinoza et al. 2007 (radial), of which Multi-SRT,
section 3, compares star and radial. Differs in: the tag `CUT`, without which a star would see no
door narrower than a cone.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import shapely

from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.numerics.boxes import bounds_of
from multisrt.geometry.numerics.distances import inside
from multisrt.geometry.numerics.kernel import FloatArray, kernel
from multisrt.geometry.regions.beam_chords import boundary_from_beams
from multisrt.geometry.regions.beams import sure_reach
from multisrt.geometry.regions.boundary import TagArray, arc_divisions, arc_tolerance
from multisrt.geometry.regions.cones import Cones, cut_at_smallest_readings
from multisrt.geometry.regions.covered import with_covered
from multisrt.geometry.regions.scan import LaserScan, Scan
from multisrt.geometry.regions.shapes import CONTACT_TOLERANCE_M, MIN_CONES, Shape


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LocalSafeRegion:
    """A star-shaped polygon of surely free space around the place of a scan.

    Attributes
    ----------
    x, y : float
        The place of the scan in metres.
    range_m : float
        Range of the range finder in metres.
    boundary : (n, 2) array
        Corners in metres, counter-clockwise, not closed; read-only.
    tags : (n,) array of int8
        Why the region ends at the piece from corner i to corner i + 1; read-only.

    Examples
    --------
    >>> import numpy as np
    >>> from multisrt.geometry.regions.boundary import OBSTACLE
    >>> corners = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 3.0], [0.0, 3.0]])
    >>> tags = np.full(4, OBSTACLE, np.int8)
    >>> room = LocalSafeRegion(x=1.0, y=1.0, range_m=9.0, boundary=corners, tags=tags)
    >>> room.polygon().area
    12.0
    """

    x: float
    y: float
    range_m: float
    boundary: FloatArray
    tags: TagArray

    def __post_init__(self) -> None:
        # Kernels are compiled for read-only arrays once, and not for writable ones as well.
        if self.boundary.flags.writeable or self.boundary.dtype != np.float64:
            boundary = np.array(self.boundary, np.float64, order="C")
            boundary.setflags(write=False)
            object.__setattr__(self, "boundary", boundary)
        if self.tags.flags.writeable or self.tags.dtype != np.int8:
            tags = np.array(self.tags, np.int8)
            tags.setflags(write=False)
            object.__setattr__(self, "tags", tags)

    def polygon(self) -> shapely.Polygon:
        """Return the region as a shapely polygon."""
        return shapely.Polygon(self.boundary)

    def overlaps(self, other: LocalSafeRegion) -> bool:
        """Whether the region has a point in common with another one.

        Symmetric to the last bit: regions that only touch are compared in one order.
        """
        first, second = self.boundary, other.boundary
        if (other.x, other.y) < (self.x, self.y):
            first, second = second, first
        return bool(_have_common_points(first, second))


def local_safe_region(
    scan: Scan,
    shape: Shape,
    *,
    cones: int = 16,
    contact_tolerance_m: float = CONTACT_TOLERANCE_M,
) -> LocalSafeRegion:
    """Return the local safe region of a scan.

    Parameters
    ----------
    scan : ExactScan or LaserScan
        What the range finder measured.
    shape : {"ball", "star", "radial"}
        How much of the readings the region keeps.
    cones : int, default 16
        Number of equal cones of a star, at least 3.
    contact_tolerance_m : float, default 0.05
        The boundary of a star or a ball is obstacle where a reading ends at most this far behind
        it, in metres.

    Returns
    -------
    LocalSafeRegion
        In the frame of the scan.

    Raises
    ------
    InvalidInputError
        For an unknown shape, fewer than 3 cones or fewer than 5 beams.

    Notes
    -----
    From beams the region is conservative: between two beams it ends before the nearer of their
    readings, or before the range, by about half the beams' spacing there. It holds no point of
    an obstacle that is wider than the beams' spacing and has no corner sharper than 45 degrees
    (`MIN_CORNER_RAD`); what is thinner can stand between two beams unseen, as for any laser.
    What the body covers belongs to the region, of whatever shape (see `with_covered`), unless a
    reading ends inside the body.

    Examples
    --------
    The three shapes in a room of 4 x 3 m:

    >>> import numpy as np
    >>> from multisrt.geometry.configuration import Configuration
    >>> from multisrt.geometry.regions.edge_index import EdgeIndex
    >>> from multisrt.geometry.regions.scan import take_scan
    >>> corners = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 3.0], [0.0, 3.0]])
    >>> room = EdgeIndex(np.hstack([corners, np.roll(corners, -1, axis=0)]), 1.0)
    >>> scan = take_scan(room, Configuration(1.0, 1.0), time_s=0.0, range_m=9.0)
    >>> for shape in ("radial", "star", "ball"):
    ...     print(shape, round(local_safe_region(scan, shape).polygon().area, 1))
    radial 12.0
    star 9.7
    ball 3.1
    """
    reach = scan.range_m
    if isinstance(scan, LaserScan):
        boundary, tags = boundary_from_beams(scan)
        reach = sure_reach(scan.range_m, len(scan.ranges))
    else:
        boundary, tags = scan.boundary, scan.tags
    x, y, _ = scan.configuration
    if shape in ("star", "ball"):
        if cones < MIN_CONES:
            raise InvalidInputError(f"a star has at least {MIN_CONES} cones, not {cones}")
        count = cones if shape == "star" else 1
        parts = math.ceil(arc_divisions(scan.range_m, arc_tolerance(scan.range_m)) / count)
        boundary, tags = cut_at_smallest_readings(
            boundary, tags, Cones(x, y, reach, count, parts), contact_tolerance_m
        )
    elif shape != "radial":
        raise InvalidInputError(f"a safe region is ball, star or radial, not {shape!r}")
    if isinstance(scan, LaserScan):
        boundary, tags = with_covered(scan, boundary, tags)
    boundary.setflags(write=False)
    tags.setflags(write=False)
    return LocalSafeRegion(x=x, y=y, range_m=scan.range_m, boundary=boundary, tags=tags)


@kernel
def _have_common_points(a: FloatArray, b: FloatArray) -> bool:
    # Whether two borders cross or touch, or one polygon lies in the other.
    left, low, right, high = bounds_of(b)
    px, py = a[-1]
    for i in range(a.shape[0]):
        qx, qy = a[i]
        if (
            max(px, qx) >= left
            and min(px, qx) <= right
            and max(py, qy) >= low
            and min(py, qy) <= high
            and _meets_border(px, py, qx, qy, b)
        ):
            return True
        px, py = qx, qy
    return inside(a, b[0, 0], b[0, 1]) or inside(b, a[0, 0], a[0, 1])


@kernel
def _meets_border(px: float, py: float, qx: float, qy: float, ring: FloatArray) -> bool:
    # Whether the segment from p to q crosses or touches a ring's border.
    ex, ey = qx - px, qy - py
    ux, uy = ring[-1]
    side_u = ex * (uy - py) - ey * (ux - px)
    for j in range(ring.shape[0]):
        vx, vy = ring[j]
        side_v = ex * (vy - py) - ey * (vx - px)
        if (
            side_u * side_v <= 0.0
            and max(ux, vx) >= min(px, qx)
            and min(ux, vx) <= max(px, qx)
            and max(uy, vy) >= min(py, qy)
            and min(uy, vy) <= max(py, qy)
        ):
            fx, fy = vx - ux, vy - uy
            side_p = fx * (py - uy) - fy * (px - ux)
            if side_p * (fx * (qy - uy) - fy * (qx - ux)) <= 0.0:
                return True
        ux, uy, side_u = vx, vy, side_v
    return False
