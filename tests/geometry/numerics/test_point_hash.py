"""Points found by place, against brute force."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.numerics.point_hash import PointHash

# In micrometres: squares of far smaller numbers are 0, and brute force would find too many.
coordinate = st.integers(-20_000_000, 20_000_000).map(lambda n: n / 1e6)
places = st.lists(st.tuples(coordinate, coordinate), min_size=1, max_size=150)

Points = list[tuple[float, float]]


def hashed(points: Points, cell_m: float = 3.0) -> PointHash:
    result = PointHash(cell_m)
    for number, (x, y) in enumerate(points):
        assert result.add(x, y) == number
    return result


def within(points: Points, x: float, y: float, radius: float) -> list[int]:
    return [k for k, (a, b) in enumerate(points) if (a - x) ** 2 + (b - y) ** 2 <= radius**2]


@given(places, coordinate, coordinate, st.floats(0.0, 30.0))
def test_within_agrees_with_brute_force(points, x, y, radius):
    found = hashed(points).within(x, y, radius)
    assert found.tolist() == within(points, x, y, radius)


@given(places, st.data(), st.floats(0.0, 12.0))
def test_around_is_the_union_of_within(points: Points, data, radius):
    numbers = data.draw(st.lists(st.integers(0, len(points) - 1), min_size=1, max_size=8))
    around = [points[n] for n in numbers]
    expected = {k for x, y in around for k in within(points, x, y, radius)}
    found = hashed(points).around(np.array(numbers), radius)
    assert found.tolist() == sorted(expected)


@given(places, st.data(), st.floats(0.0, 12.0))
def test_pairs_agree_with_brute_force(points: Points, data, radius):
    first = data.draw(st.integers(0, len(points)))
    expected = [
        [later, earlier]
        for later in range(first, len(points))
        for earlier in within(points[:later], *points[later], radius)
    ]
    assert hashed(points).pairs(first, radius).tolist() == expected


def test_around_many_points_are_many():
    points = np.random.default_rng(1).uniform(0.0, 5.0, (400, 2)).tolist()
    known = hashed(points)
    assert len(known) == 400
    assert known.points.tolist() == points
    assert known.around(np.arange(0, 400, 3), 10.0).tolist() == list(range(400))


@pytest.mark.parametrize("cell", [0.0, -1.0, np.inf, np.nan])
def test_a_cell_is_a_positive_width(cell):
    with pytest.raises(InvalidInputError, match="positive width"):
        PointHash(cell)
