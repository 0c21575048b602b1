"""Labels that say which robot an area belongs to: to one of them, to none, or to several.

Label 0 is outside, label 1 is of no robot, label 2 + r is robot r alone, and the last label is of
several robots.
"""

from __future__ import annotations

import numpy as np

from multisrt.analysis.explorable import EXPLORABLE
from multisrt.geometry.grids.strip_map import OUTSIDE
from multisrt.geometry.numerics.kernel import FloatArray, IntArray


def label_count(robots: int) -> int:
    """Return the number of labels for a team."""
    return robots + 3


def owner_tables(robots: int) -> IntArray:
    """Return the tables by which an area comes to belong to a robot as well.

    Parameters
    ----------
    robots : int
        Number of robots.

    Returns
    -------
    (robots + 1, robots + 3) array
        Row r: to robot r as well; the last row: to several robots.

    Examples
    --------
    >>> owner_tables(2).tolist()
    [[0, 2, 2, 4, 4], [0, 3, 4, 3, 4], [0, 4, 4, 4, 4]]
    """
    several = robots + 2
    tables = np.full((robots + 1, label_count(robots)), several)
    own = np.arange(robots)
    tables[own, EXPLORABLE] = tables[own, own + 2] = own + 2
    tables[:, OUTSIDE] = OUTSIDE
    return tables


def of_one(areas_m2: FloatArray) -> FloatArray:
    """Return the areas that belong to each robot alone, from those of all labels."""
    return areas_m2[..., 2:-1]
