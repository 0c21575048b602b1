"""Frontier groups: after every change as a full labelling has them."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import ndimage

from multisrt.geometry.grids.occupancy import Occupancy
from multisrt.geometry.grids.raster import OFFSET_X, OFFSET_Y
from multisrt.geometry.regions.boundary import GAP, OBSTACLE, RANGE

EIGHT = np.ones((3, 3), int)


def groups_from_nothing(seen, occupancy):
    labels, count = ndimage.label(seen.frontier(occupancy), EIGHT)
    cells = [np.argwhere(labels == k + 1) for k in range(count)]
    return sorted((seen.in_lattice(occupancy, c).tolist() for c in cells), key=lambda c: c[0])


def target_from_nothing(occupancy, cells):
    at = zip(*occupancy.indices_of(cells), strict=True)
    passable = [tuple(c) for c, index in zip(cells, at, strict=True) if occupancy.passable[index]]
    # In whole numbers, so that ties are exact.
    total = np.sum(cells, axis=0)
    return min(
        passable,
        key=lambda c: (sum(int(d) ** 2 for d in len(cells) * np.array(c) - total), c),
        default=None,
    )


def assert_groups_are_right(seen, occupancy):
    groups = occupancy.frontier_groups(0.0)
    assert [g.cells.tolist() for g in groups] == groups_from_nothing(seen, occupancy)
    for group in groups:
        assert group.target == target_from_nothing(occupancy, group.cells.tolist())


@st.composite
def stars(draw):
    """Draw the corners and tags of a star-shaped region."""
    n = draw(st.integers(3, 9))
    x, y = draw(st.floats(-6, 6)), draw(st.floats(-6, 6))
    radii = draw(st.lists(st.floats(0.05, 4), min_size=n, max_size=n))
    tags = draw(st.lists(st.sampled_from([OBSTACLE, RANGE, GAP]), min_size=n, max_size=n))
    angles = 0.1 + np.arange(n) * (2 * np.pi / n)
    boundary = np.array([x, y]) + np.array(radii)[:, None] * np.column_stack(
        [np.cos(angles), np.sin(angles)]
    )
    if draw(st.booleans()):
        boundary = np.round(boundary)
    return boundary, tags


@pytest.mark.slow
def test_groups_equal_those_of_a_full_labelling(worlds, views, seen):
    name, options = views
    occupancy = Occupancy(0.1, 0.2)
    for k, region in enumerate(seen.regions_of(worlds, name, 24, **options)):
        occupancy.add(region)
        # Sometimes after every region, sometimes after several.
        if k % 7 < 4:
            assert_groups_are_right(seen, occupancy)


@settings(max_examples=40)
@given(st.lists(stars(), min_size=1, max_size=7), st.sampled_from([0.25, 0.4, 1.0]))
def test_groups_of_any_regions_are_right_in_any_order(seen, outlines, cell):
    regions = [seen.hand_made(boundary, tags) for boundary, tags in outlines]
    forward, backward = Occupancy(cell, 0.5), Occupancy(cell, 0.5)
    for region in regions:
        before = np.count_nonzero(forward.cells)
        assert forward.add(region) == np.count_nonzero(forward.cells) - before
        assert_groups_are_right(seen, forward)
    for region in regions[::-1]:
        backward.add(region)
    assert seen.knowledge(forward) == seen.knowledge(backward)
    revision = forward.revision
    assert [forward.add(region) for region in regions] == [0] * len(regions)
    assert forward.revision == revision


def test_groups_are_right_after_many_changes(seen):
    regions = [seen.rectangle(k % 13, k // 13, k % 13 + 0.7, k // 13 + 0.7) for k in range(150)]
    occupancy = Occupancy(0.1, 0.2)
    for region in regions:
        occupancy.add(region)
    assert_groups_are_right(seen, occupancy)


def test_groups_far_from_a_change_stay_the_same_objects(seen):
    occupancy = Occupancy(0.1, 0.2)
    occupancy.add(seen.rectangle(0, 0, 2, 2))
    occupancy.add(seen.rectangle(10, 0, 12, 2))
    first, _ = occupancy.frontier_groups()
    occupancy.add(seen.rectangle(11, 1, 13, 3))
    occupancy.add(seen.rectangle(-30, -30, -29, -29))
    assert first in occupancy.frontier_groups()
    assert len(occupancy.frontier_groups()) == 3


def test_blocked_discs_do_not_affect_targets(seen):
    occupancy, other = Occupancy(0.1, 0.2), Occupancy(0.1, 0.2)
    for each in (occupancy, other):
        each.add(seen.rectangle(0, 0, 3, 3))
    with occupancy.blocked([(1.5, 1.5, 9.0)]):
        assert not occupancy.passable.any()
        assert occupancy.frontier_groups()[0].target is not None
    assert seen.knowledge(occupancy) == seen.knowledge(other)


def test_a_group_is_as_long_as_its_opening_is_wide(seen):
    def openings(angle):
        # A turned room with an opening of 1 m in the middle of one side.
        corners = np.array([(0, 0), (4, 0), (4, 3), (2.5, 3), (1.5, 3), (0, 3)], float)
        turn = np.radians(angle)
        turned = corners @ np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
        tags = [OBSTACLE] * 3 + [GAP] + [OBSTACLE] * 2
        occupancy = Occupancy(0.05, 0.2)
        occupancy.add(seen.hand_made(turned, tags))
        return occupancy

    for angle in (0.0, 30.0, 45.0, 71.0):
        occupancy = openings(angle)
        (group,) = occupancy.frontier_groups()
        assert group.size_m == pytest.approx(1.0, abs=0.16)
        x, y = occupancy.centre_of(*group.target)
        turn = np.radians(angle)
        middle = np.array(
            [2 * np.cos(turn) - 3 * np.sin(turn), 2 * np.sin(turn) + 3 * np.cos(turn)]
        )
        assert np.hypot(*(middle - (x, y))) < 0.15
        assert occupancy.frontier_groups(1.2) == []
        assert not group.cells.flags.writeable
    # An opening too narrow to pass is returned on request, but has no target.
    narrow = Occupancy(0.05, 0.6)
    narrow.add(
        seen.hand_made(
            [(0, 0), (4, 0), (4, 3), (2.5, 3), (1.5, 3), (0, 3)], [OBSTACLE] * 3 + [GAP] + [0, 0]
        )
    )
    assert narrow.frontier_groups() == []
    (group,) = narrow.frontier_groups(0.0)
    assert group.target is None


def test_a_group_exactly_as_wide_as_the_body_is_kept(seen):
    # Cells (3, 5) to (3, 8): four of 0.1 m for a body of 0.4 m.
    dx, dy = OFFSET_X * 0.1, OFFSET_Y * 0.1
    for count in (3, 4):
        occupancy = Occupancy(0.1, 0.2)
        occupancy.add(seen.rectangle(0.5 - dx, 0.3 - dy, 0.5 + 0.1 * count - dx, 0.4 - dy))
        cells = [g.cells.tolist() for g in occupancy.frontier_groups()]
        assert cells == ([[[3, 5], [3, 6], [3, 7], [3, 8]]] if count == 4 else [])
    # Its centroid lies between (3, 6) and (3, 7): the first is the target.
    assert occupancy.frontier_groups()[0].target == (3, 6)
