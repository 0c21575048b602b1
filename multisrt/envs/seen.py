"""How much of a world the scans of a team have shown, scan by scan."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from multisrt.analysis.explorable import strips_of
from multisrt.environments.environment import Environment
from multisrt.geometry.configuration import Configuration
from multisrt.geometry.grids.strip_map import StripMap
from multisrt.geometry.grids.strips import runs_of
from multisrt.geometry.numerics.arrays import FloatArray

SEEN: Final = 1
"""The label of what a scan has shown."""

TABLE: Final = (SEEN, SEEN)
"""The new labels of what a scan shows: of what was outside, and of what was seen."""


class SeenArea:
    """The area that scans have shown so far, measured as `multisrt.measure` does.

    Parameters
    ----------
    environment : Environment
        The world.
    start : Configuration
        Where one of the robots starts.

    Attributes
    ----------
    area_m2 : float
        The area that at least one scan has shown, in square metres.

    Examples
    --------
    >>> import shapely
    >>> hall = Environment("hall", shapely.box(0, 0, 8, 4))
    >>> seen = SeenArea(hall, Configuration(1.0, 1.0))
    >>> square = np.array([(0.0, 0.0), (4.0, 0.0), (4.0, 4.0), (0.0, 4.0)])
    >>> seen.add([square, square + (2.0, 0.0)]).round(3).tolist()
    [16.0, 8.0]
    >>> round(seen.area_m2, 3)
    24.0
    """

    def __init__(self, environment: Environment, start: Configuration) -> None:
        component = environment.component(start.x, start.y)
        self._plane = StripMap(strips_of(environment, component), len(TABLE))
        self.area_m2 = 0.0

    def add(self, regions: Sequence[FloatArray]) -> FloatArray:
        """Add what scans have shown.

        Parameters
        ----------
        regions : sequence of (n, 2) array
            The corners of each region in metres.

        Returns
        -------
        (k,) array
            The area in square metres that each of them shows and none before it did.
        """
        if not regions:
            return np.zeros(0)
        history = self._plane.relabel(runs_of(self._plane.cut, regions), [TABLE])[:, SEEN]
        new: FloatArray = np.maximum(0.0, np.diff(history, prepend=self.area_m2))
        self.area_m2 = float(history[-1])
        return new
