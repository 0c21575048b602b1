"""Sets of cells against shapely and numpy."""

import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st
from shapely import Polygon, box

from multisrt.geometry.regions.edge_index import EdgeIndex
from multisrt.informed.roadmap import edges_of
from multisrt.informed.views import Cells, Sensor, count, numbers_in

HALL = Polygon(box(0, 0, 12, 8).exterior, [box(4, 3, 6, 5).exterior])


def cells_of(range_m):
    sensor = Sensor(EdgeIndex(edges_of(HALL), 1.0), range_m, None)
    room = HALL.buffer(-0.25)
    return Cells(HALL.bounds, HALL.area, [(room, sensor)], []), sensor


def test_all_of_a_hall_can_be_seen():
    cells, _ = cells_of(4.0)
    assert count(cells.all()) == cells.count
    assert cells.count * cells.cell_m**2 == pytest.approx(HALL.area, rel=0.01)
    assert count(cells.none()) == 0


@pytest.mark.parametrize("place", [(1.0, 1.0), (3.0, 4.0), (11.0, 7.5)])
def test_what_a_sensor_sees_is_counted_by_area(place):
    cells, sensor = cells_of(4.0)
    region = sensor.region(*place)
    seen = cells.within(region)
    assert count(seen) * cells.cell_m**2 == pytest.approx(shapely.Polygon(region).area, rel=0.02)


def test_a_short_range_leaves_what_no_place_shows():
    # From the axis of a corridor that is too narrow for the body, nothing of it is seen.
    world = shapely.union(box(0, 0, 4, 4), box(4, 1.9, 10, 2.1))
    assert isinstance(world, Polygon)
    sensor = Sensor(EdgeIndex(edges_of(world), 1.0), 3.0, None)
    cells = Cells(world.bounds, world.area, [(box(0.25, 0.25, 3.75, 3.75), sensor)], [])
    assert 16.0 < cells.count * cells.cell_m**2 < 16.0 + 0.2 * 3.0


@given(st.sets(st.integers(0, 500)))
def test_numbers_in_a_set(numbers):
    bits = np.zeros(8 * 64, np.bool_)
    bits[sorted(numbers)] = True
    words = np.packbits(bits, bitorder="little").view(np.uint64)
    assert numbers_in(words).tolist() == sorted(numbers)
    assert count(words) == len(numbers)
