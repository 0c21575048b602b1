"""Lines of sight against shapely and answers by hand."""

import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st
from shapely import LineString, Polygon, box

from multisrt.geometry.regions.edge_index import EdgeIndex
from multisrt.geometry.regions.line_of_sight import line_of_sight


@pytest.mark.parametrize("name", ["rooms", "office", "clutter"])
def test_lines_of_sight_equal_shapely(worlds, name):
    free = worlds.WORLDS[name]()
    index = worlds.index(free)
    shapely.prepare(free)
    places = worlds.viewpoints(free, 400, clearance=0.05, seed=27)
    answers = {True: 0, False: 0}
    for a, b in zip(places[:200], places[200:], strict=True):
        b = a + (b - a) * min(1.0, 5.0 / np.hypot(*(b - a)))
        if not shapely.contains_xy(free, *b):
            continue
        truth = bool(free.covers(LineString([a, b])))
        assert line_of_sight(index, *a, *b) == truth
        assert line_of_sight(index, *b, *a) == truth
        answers[truth] += 1
    assert min(answers.values()) > 30


GRAZING = [
    # (obstacles, from, to, visible)
    ([box(4, 4, 6, 6)], (2, 2), (3.9, 3.9), True),  # ends before the corner
    ([box(4, 4, 6, 6)], (2, 6), (6, 2), True),  # touches the corner (4, 4)
    ([box(4, 4, 6, 6)], (2, 8), (8, 2), False),  # through two opposite corners
    ([box(4, 4, 6, 6)], (2, 2), (8, 8), False),
    ([box(4, 4, 6, 6)], (2, 4), (8, 4), True),  # along the lower side
    ([box(4, 4, 6, 6)], (8, 4), (2, 4), True),
    ([box(4, 4, 6, 6)], (2, 6), (8, 6), True),  # along the upper side
    ([box(4, 4, 6, 6)], (4, 1), (4, 9), True),  # along the left side
    ([box(4, 4, 6, 6)], (6, 9), (6, 1), True),  # along the right side
    ([box(4, 4, 6, 6)], (4, 4), (6, 4), True),  # the side itself
    ([box(4, 4, 6, 6)], (2, 4), (4, 4), True),  # ends at the corner
    ([box(4, 4, 6, 6)], (5, 4), (5, 2), True),  # leaves from the middle of a side
    ([box(4, 4, 6, 6)], (2, 5), (8, 5), False),
    ([box(2, 5, 4, 6), box(6, 4, 8, 5)], (1, 5), (9, 5), True),  # a wall left, then one right
    ([box(2, 5, 4, 6), box(6, 4, 8, 5)], (9, 5), (1, 5), True),
    ([box(2, 5, 4, 6), box(6, 4, 8, 5), box(8.5, 4, 8.7, 6)], (1, 5), (9, 5), False),
    ([box(2, 5, 4, 6), box(6, 5, 8, 7)], (1, 5), (9, 5), True),  # two walls on one side
    ([box(4, 4, 5, 5), box(5, 5, 6, 6)], (2, 8), (8, 2), True),  # between two that touch
    ([box(4, 4, 5, 5), box(5, 5, 6, 6)], (2, 2), (8, 8), False),
    ([box(4, 4, 5, 5), box(5, 5, 6, 6)], (2, 5), (8, 5), True),  # along both
    ([Polygon([(4, 4), (6, 4), (5, 6)])], (2, 6), (8, 6), True),  # touches the tip
    ([Polygon([(4, 4), (6, 4), (5, 6)])], (5, 1), (5, 9), False),  # through the tip
]


@pytest.mark.parametrize(("obstacles", "here", "there", "visible"), GRAZING)
def test_grazing_lines_of_sight_by_hand(worlds, obstacles, here, there, visible):
    free = box(0, 0, 10, 10).difference(shapely.union_all(obstacles))
    assert free.covers(LineString([here, there])) == visible
    for cell in (0.5, 1.3, 20.0):
        index = EdgeIndex(worlds.edges(free), cell)
        assert line_of_sight(index, *here, *there) == visible
        assert line_of_sight(index, *there, *here) == visible


def test_a_place_sees_itself(worlds):
    assert line_of_sight(worlds.index(worlds.hall()), 3.0, 3.0, 3.0, 3.0)


@given(
    st.lists(st.tuples(st.integers(0, 20), st.integers(0, 20)), min_size=2, max_size=2),
    st.integers(0, 5),
    st.sampled_from([1.0, 0.2, 0.6, 0.8]),
)
def test_lines_between_lattice_points_equal_shapely(worlds, ends, seed, scale):
    # Corners and ends on one lattice of halves: grazing is the rule here. On a finer lattice they
    # graze but for rounding.
    rng = np.random.default_rng(seed)
    lows = rng.integers(2, 16, (8, 2)) / 2
    sizes = rng.integers(1, 4, (8, 2)) / 2
    solid = shapely.union_all(
        [box(*low, *(low + size)) for low, size in zip(lows, sizes, strict=True)]
    )
    free = box(0, 0, 10, 10).difference(solid)
    (ax, ay), (bx, by) = ((x / 2, y / 2) for x, y in ends)
    inside = [shapely.contains_xy(free, ax, ay), shapely.contains_xy(free, bx, by)]
    if not all(inside):
        return
    line = LineString([(ax, ay), (bx, by)])
    truth = line.length == 0 or bool(free.covers(line))
    finer = shapely.transform(free, lambda corners: np.round(scale * corners, 3))
    ax, ay, bx, by = np.round(scale * np.array([ax, ay, bx, by]), 3).tolist()
    assert line_of_sight(worlds.index(finer), ax, ay, bx, by) == truth
    assert line_of_sight(worlds.index(finer), bx, by, ax, ay) == truth


@pytest.mark.parametrize(
    ("here", "there", "corners"),
    [
        ((6.0, 5.1), (3.9, 0.9), [(4.2, 1.5), (4.5, 2.1), (4.8, 1.5), (4.5, 0.9)]),
        ((0.0, 2.4), (2.2, 0.2), [(1.6, 0.8), (1.4, 1.0), (1.6, 1.2), (1.8, 1.0)]),
        ((0.8, 0.2), (1.4, 0.8), [(1.1, 0.1), (0.9, 0.3), (1.1, 0.5)]),
        ((3.6, 0.2), (0.0, 3.8), [(0.8, 3.0), (1.8, 2.8), (1.0, 2.8)]),
    ],
)
def test_lines_along_a_wall_but_for_rounding(worlds, here, there, corners):
    index = worlds.index(box(-9, -9, 9, 9).difference(Polygon(corners)))
    assert line_of_sight(index, *here, *there)
    assert line_of_sight(index, *there, *here)
