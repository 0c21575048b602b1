"""The regions by which a run is judged, on the strips of what there is to explore.

The intervals of a region on strips take many times the memory of its corners, and a long run of a
large team has a hundred thousand regions. They are therefore computed in blocks.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from multisrt.geometry.grids.strip_map import StripMap
from multisrt.geometry.grids.strips import Runs, Strips, clipped, runs_of
from multisrt.geometry.numerics.kernel import FloatArray, IntArray

WHOLE, NOTHING = -1, -2
"""Masks of regions that count whole, and not at all; see `clipped`."""

MAX_REGIONS: Final = 256
"""Maximum number of regions whose intervals are held at once, about 100 kB each in large worlds."""


class ShownRegions:
    """Regions, as far as scans showed them.

    Parameters
    ----------
    cut : Strips
        The strips.
    corners : sequence of (k, 2) array
        The corners of each region in metres.
    masks : sequence of int
        For each region the index of the region to which it is clipped, or `WHOLE` or `NOTHING`.

    Examples
    --------
    Two boxes; the second counts as far as it lies in the first:

    >>> from multisrt.geometry.grids.strips import strips
    >>> cut = strips(np.array([(0.0, 0.0, 0.0, 1.0)]), 1.0)
    >>> boxes = [np.array([(x, 0), (x + 2, 0), (x + 2, 1), (x, 1)], float) for x in (0, 1)]
    >>> regions = ShownRegions(cut, boxes, [WHOLE, 0])
    >>> regions.relabel(StripMap(cut, 2), [[1, 1]], [1, 0])[:, 1].tolist()
    [1.0, 2.0]
    >>> regions.unshown_m2()
    1.0
    """

    def __init__(self, cut: Strips, corners: Sequence[FloatArray], masks: Sequence[int]) -> None:
        self._cut = cut
        self._corners = corners
        self._masks: IntArray = np.array(masks, np.int64)

    def relabel(
        self,
        plane: StripMap,
        tables: ArrayLike,
        regions: Sequence[int],
        which: Sequence[int] | None = None,
        *,
        measured: Callable[[FloatArray], FloatArray] = np.asarray,
    ) -> FloatArray:
        """Give the points of some regions new labels on a plane; see `StripMap.relabel`.

        Parameters
        ----------
        plane : StripMap
            The plane, on the same strips.
        tables, regions, which
            As for `StripMap.relabel`.
        measured : callable, optional
            Function applied to the areas ``(k, labels)`` of each block; by default all are kept.

        Returns
        -------
        (n, ...) array
            The measured values after each region.
        """
        history = []
        for first in range(0, max(1, len(regions)), MAX_REGIONS):
            some = slice(first, first + MAX_REGIONS)
            runs, table = self._runs(regions[some]), None if which is None else which[some]
            areas_m2 = plane.relabel(runs, tables, range(len(regions[some])), table)
            history.append(measured(areas_m2))
        return np.concatenate(history)

    def unshown_m2(self) -> float:
        """Return the area of all regions that does not count, in square metres."""
        parts = np.flatnonzero(self._masks != WHOLE).tolist()
        unshown = []
        for first in range(0, len(parts), MAX_REGIONS):
            some = parts[first : first + MAX_REGIONS]
            claimed = runs_of(self._cut, [self._corners[region] for region in some])
            unshown.append(self._area_m2(claimed, len(some)))
            unshown.append(-self._area_m2(self._runs(some), len(some)))
        return math.fsum(unshown)

    def _runs(self, regions: Sequence[int]) -> Runs:
        # The intervals of some regions, and behind them those of their masks.
        masks = self._masks[list(regions)]
        within = masks >= 0
        others = masks[within].tolist()
        corners = [self._corners[region] for region in (*regions, *others)]
        masks[within] = len(regions) + np.arange(len(others))
        masks = np.concatenate([masks, np.full(len(others), WHOLE)])
        return clipped(runs_of(self._cut, corners), masks)

    def _area_m2(self, runs: Runs, regions: int) -> float:
        own = slice(runs.starts[0], runs.starts[regions])
        lengths = runs.end[own] - runs.begin[own]
        return float((lengths * self._cut.heights[runs.strip[own]]).sum())
