"""Random small worlds for property tests of map files."""

import numpy as np
import shapely
from hypothesis import assume
from hypothesis import strategies as st

import multisrt as ms

places = st.floats(-1.0, 11.0).map(lambda value: round(value, 3))
sizes = st.floats(0.02, 4.0).map(lambda value: round(value, 3))


@st.composite
def polygons(draw) -> shapely.Polygon:
    """A box or a polygon around a point, of any turn; some are thin walls, some touch."""
    x, y, width, height = draw(places), draw(places), draw(sizes), draw(sizes)
    if draw(st.booleans()):
        return shapely.box(x, y, x + width, y + height)
    corners = draw(st.integers(3, 6))
    angles = np.linspace(0.0, 2.0 * np.pi, corners, endpoint=False) + draw(st.floats(0.0, 6.0))
    return shapely.Polygon(
        np.column_stack([x + width * np.cos(angles), y + height * np.sin(angles)])
    )


@st.composite
def small_worlds(draw) -> ms.Environment:
    """A world of 10 m x 8 m with up to six obstacles, in one component or several."""
    free = shapely.box(0.0, 0.0, 10.0, 8.0) - shapely.union_all(
        draw(st.lists(polygons(), max_size=6))
    )
    parts = [part for part in shapely.get_parts(free) if part.area > 0.5]
    assume(parts)
    moved = shapely.affinity.translate(shapely.MultiPolygon(parts), draw(places), draw(places))
    inside = [part.representative_point() for part in moved.geoms]
    return ms.Environment("drawn", moved, starts=[(point.x, point.y) for point in inside])


def area_of_difference(one: ms.Environment, other: ms.Environment) -> float:
    """The area of the symmetric difference of two worlds."""
    return float(one.free.symmetric_difference(other.free).area)
