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


class DistanceFields:
    """Distances from places, one field a place.

    Parameters
    ----------
    raster : Occupancy
        The raster whose passable cells the paths lead over.
    """

    def __init__(self, raster: Occupancy) -> None:
        self._raster = raster
        self._kept: dict[tuple[int, int], tuple[int, DistanceField]] = {}

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
        kept = self._kept.pop(cell, None)
        if kept is not None and kept[1].passable is raster.passable:
            revision, field = kept
            changed = raster.changed_since(revision)
            if changed is not None:
                field.repair(raster.window_of(changed))
        else:
            field = self.begin(raster.centre_of(*cell))
        self._kept[cell] = raster.revision, field
        if len(self._kept) > MAX_FIELDS:
            self._kept.pop(next(iter(self._kept)))
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
