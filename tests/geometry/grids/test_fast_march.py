"""The march to the bit, against one of a few plain lines."""

import math

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from multisrt.geometry.grids.distance_field import distance_field
from multisrt.geometry.grids.fast_march import EXACT_CELLS, EXACT_SLACK_CELLS
from multisrt.geometry.grids.sight import in_sight


def plain_field(free, x, y):
    """The values of a march from one source, accepted one by one from a dictionary."""
    front = {
        (r, c): float(np.hypot(c + 0.5 - x, r + 0.5 - y))
        for r, c in np.argwhere(free).tolist()
        if max(abs(r - int(y)), abs(c - int(x))) <= EXACT_CELLS and in_sight(free, x, y, c, r)
    }
    exact = set(front)
    values = np.pad(np.full(free.shape, np.inf), 2, constant_values=np.inf)
    passable = np.pad(free, 2)
    while front:
        r, c = min(front, key=lambda cell: (front[cell], cell))
        values[r + 2, c + 2] = front.pop((r, c))
        exact.discard((r, c))
        for cell in ((r, c + 1), (r, c - 1), (r + 1, c), (r - 1, c)):
            here = cell[0] + 2, cell[1] + 2
            if passable[here] and np.isinf(values[here]):
                value = upwind(values, *here)
                if value < front.get(cell, np.inf) - (EXACT_SLACK_CELLS if cell in exact else 0.0):
                    front[cell] = value
                    exact.discard(cell)
    return values[2:-2, 2:-2]


def upwind(values, r, c):
    """The value of a cell from its accepted neighbours, with a branch for every case."""
    base_x, weight_x = one_sided(values[r, c - 2 : c + 3].tolist())
    base_y, weight_y = one_sided(values[r - 2 : r + 3, c].tolist())
    if base_x < np.inf and base_y < np.inf:
        a = weight_x + weight_y
        b = weight_x * base_x + weight_y * base_y
        discriminant = b * b - a * (weight_x * base_x * base_x + weight_y * base_y * base_y - 1.0)
        if discriminant >= 0.0:
            value = (b + math.sqrt(discriminant)) / a
            if value >= max(base_x, base_y):
                return value
    return min(base_x + 1.0 / math.sqrt(weight_x), base_y + 1.0 / math.sqrt(weight_y))


def one_sided(line):
    """Base and weight of the difference along one axis."""
    nearest, second = (line[3], line[4]) if line[3] < line[1] else (line[1], line[0])
    if second <= nearest and second < np.inf:
        return (4.0 * nearest - second) / 3.0, 2.25
    return nearest, 1.0


@settings(max_examples=40)
@given(
    st.integers(0, 2**32 - 1),
    st.floats(0.0, 0.5),
    st.floats(0.0, 1.0, exclude_max=True),
    st.floats(0.0, 1.0, exclude_max=True),
)
def test_values_are_those_of_a_plain_march_to_the_bit(seed, blocked, x, y):
    rng = np.random.default_rng(seed)
    free = rng.random((20, 32)) >= blocked
    row, column = rng.integers(20), rng.integers(32)
    free[row, column] = True
    source = column + x, row + y
    expected = plain_field(free, *source)
    assert distance_field(free, 1.0, [source]).tobytes() == expected.tobytes()
