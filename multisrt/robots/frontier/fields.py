"""Distance fields over the passable cells of a raster, kept and repaired as the raster changes."""

from __future__ import annotations

from multisrt.geometry.grids.distance_field import DistanceField
from multisrt.geometry.grids.occupancy import Occupancy
from multisrt.geometry.numerics.kernel import FloatArray, IntArray
from multisrt.robots.frontier.goal import Place

NEAR_BY_CELLS = 8
"""Bounds, in cells, how far from a robot's own cell its paths may begin."""

MAX_FIELDS = 16
"""Number of distance fields that are kept; the one not asked for longest is dropped."""

MAX_BYTES = 96 * 2**20
"""Memory of all distance fields that are kept, so that large maps keep fewer of them."""


class DistanceFields:
    """Distances from places, one field a place.

    Parameters
    ----------
    raster : Occupancy
        The raster whose passable cells the paths lead over.
    """

    def __init__(self, raster: Occupancy) -> None:
        self._raster = raster
        # The fields with the revisions of the raster that they are for.
        self._kept: dict[tuple[int, int], tuple[int, DistanceField]] = {}
        self._own: tuple[int, DistanceField] | None = None
        self._stands: tuple[Place, bytes] | None = None

    def field(self, x: float, y: float) -> DistanceField | None:
        """Return the distances from the passable cell nearest to a place.

        A field that is kept is repaired where the raster has changed since.

        Parameters
        ----------
        x, y : float
            The place in metres.

        Returns
        -------
        DistanceField or None
            None if no cell within `NEAR_BY_CELLS` is passable.
        """
        raster = self._raster
        cell = raster.passable_near(x, y, NEAR_BY_CELLS)
        if cell is None:
            return None
        field = self._repaired(self._kept.pop(cell, None)) or self.begin(raster.centre_of(*cell))
        self._kept[cell] = raster.revision, field
        while len(self._kept) > 1 and self._is_too_much():
            self._kept.pop(next(iter(self._kept)))
        return field

    def _is_too_much(self) -> bool:
        memory = sum(field.nbytes for _, field in self._kept.values())
        return len(self._kept) > MAX_FIELDS or memory > MAX_BYTES

    def own(self, source: Place, blocked: bytes) -> DistanceField:
        """Return the distances from exactly where the robot stands.

        A field is kept from its second request on, to save memory: a robot that drives requests
        each once. It is for the cells that are blocked now: ask for lengths while these are.

        Parameters
        ----------
        source : (x, y)
            The place in metres, in a passable cell.
        blocked : bytes
            Key of the discs that block cells now; another key gives a new field.

        Returns
        -------
        DistanceField
        """
        stands = source, blocked
        if stands != self._stands:
            self._stands, self._own = stands, None
            return self.begin(source)
        field = self._repaired(self._own) or self.begin(source)
        self._own = self._raster.revision, field
        return field

    def _repaired(self, kept: tuple[int, DistanceField] | None) -> DistanceField | None:
        """Return a field that was kept, as the raster is now; None if there is none to repair."""
        raster = self._raster
        if kept is None or kept[1].passable is not raster.passable:
            return None
        revision, field = kept
        changed = raster.changed_since(revision)
        if changed is not None:
            field.repair(raster.window_of(changed))
        return field

    def begin(self, source: Place) -> DistanceField:
        """Return a new field from a place, which is not kept."""
        raster = self._raster
        return DistanceField(raster.passable, raster.cell_m, [source], x0=raster.x0, y0=raster.y0)


def indices_of(raster: Occupancy, places: FloatArray) -> IntArray:
    """Return the indices of the cells of places in the arrays of a raster.

    Parameters
    ----------
    raster : Occupancy
        The raster.
    places : (k, 2) array
        Places in metres, inside its window.

    Returns
    -------
    (k, 2) array of int
        Row and column of each.
    """
    return raster.indices_at(places)
