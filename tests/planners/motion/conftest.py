"""What tests of motions share: the boundary of a region as an array."""

from collections.abc import Callable

import numpy as np
import pytest
import shapely
from shapely.geometry.base import BaseGeometry


@pytest.fixture(scope="session")
def ring() -> Callable[[BaseGeometry], np.ndarray]:
    """Return the corners of a polygon without holes, with the region on their left."""

    def corners(polygon: BaseGeometry) -> np.ndarray:
        assert isinstance(polygon, shapely.Polygon)
        return np.asarray(shapely.orient_polygons(polygon).exterior.coords)[:-1].copy()

    return corners
