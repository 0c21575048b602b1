"""Occupancies: changes, blocked discs, queries around a point, and what is refused."""

import numpy as np
import pytest

from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.grids.occupancy import FREE, UNKNOWN, Occupancy
from multisrt.geometry.grids.occupancy.change_log import MAX_CHANGES
from multisrt.geometry.regions.boundary import OBSTACLE


def hall_seen(seen, worlds, cell_m=0.1):
    occupancy = Occupancy(cell_m, 0.25)
    for region in seen.regions_of(worlds, "office", 5, clearance=0.3, seed=8):
        occupancy.add(region)
    return occupancy


def places_around(occupancy, count, seed):
    rng = np.random.default_rng(seed)
    rows, columns = occupancy.cells.shape
    low = np.array([occupancy.x0, occupancy.y0])
    size = np.array([columns, rows]) * occupancy.cell_m
    return (low - 1.0 + rng.random((count, 2)) * (size + 2.0)).tolist()


@pytest.mark.slow
def test_changes_are_reported_where_they_are(worlds, seen):
    regions = seen.regions_of(worlds, "office", MAX_CHANGES + 30, seed=63)
    occupancy = Occupancy(0.1, 0.2, (-3.0, -3.0, 25.0, 25.0))
    assert occupancy.changed_since(0) is None
    states = {0: (occupancy.cells.copy(), occupancy.passable.copy())}
    tight = 0
    for region in regions:
        occupancy.add(region)
        states[occupancy.revision] = occupancy.cells.copy(), occupancy.passable.copy()
        assert len(states) == occupancy.revision + 1
        for revision in range(0, occupancy.revision, 5):
            window = occupancy.changed_since(revision)
            assert window is not None
            differ = (states[revision][0] != occupancy.cells) | (
                states[revision][1] != occupancy.passable
            )
            rows, columns = np.nonzero(differ)
            rows, columns = rows + occupancy.row, columns + occupancy.column
            least = (rows.min(), rows.max() + 1, columns.min(), columns.max() + 1)
            assert window[0] <= least[0] <= least[1] <= window[1]
            assert window[2] <= least[2] <= least[3] <= window[3]
            tight += window == least
        assert occupancy.changed_since(occupancy.revision) is None
    assert tight > 200


def test_a_window_of_changes_survives_growing(seen):
    occupancy = Occupancy(0.5, 0.5)
    occupancy.add(seen.rectangle(0, 0, 2, 2))
    first = occupancy.changed_since(0)
    occupancy.add(seen.rectangle(-40, -40, -39, -39))
    second = occupancy.changed_since(1)
    assert first is not None
    assert second is not None
    assert occupancy.changed_since(0) == (second[0], first[1], second[2], first[3])


def test_the_oldest_changes_remain_in_the_merged_window(seen):
    occupancy = Occupancy(0.5, 0.5)
    occupancy.add(seen.rectangle(-40, -40, -38, -38))
    first = occupancy.changed_since(0)
    for k in range(MAX_CHANGES + 9):
        occupancy.add(seen.rectangle(k, 0, k + 2, 2))
    assert occupancy.revision == MAX_CHANGES + 10
    merged = occupancy.changed_since(0)
    recent = occupancy.changed_since(occupancy.revision - MAX_CHANGES)
    assert first is not None
    assert merged is not None
    assert recent is not None
    assert merged[::2] == first[::2]
    assert recent[0] > first[1]


def test_blocked_discs_are_restored_exactly(worlds, seen):
    occupancy = Occupancy(0.1, 0.2)
    for region in seen.regions_of(worlds, "office", 12):
        occupancy.add(region)
    before, groups = occupancy.passable.copy(), seen.knowledge(occupancy)[3]
    points = seen.centres(occupancy)
    outer = np.array([[5.0, 5.0, 1.0], [5.5, 5.0, 1.0], [-90.0, 0.0, 3.0], [0.0, 0.0, 0.0]])
    inner = np.array([[5.2, 5.4, 1.2], [14.0, 3.0, 25.0]])

    def without(discs):
        away = np.hypot(*(points[:, None] - discs[:, :2]).T) > discs[:, 2:]
        return before & away.all(axis=0).reshape(before.shape)

    revision = occupancy.revision
    with occupancy.blocked(outer):
        assert np.array_equal(occupancy.passable, without(outer))
        with occupancy.blocked(inner):
            assert np.array_equal(occupancy.passable, without(np.vstack([outer, inner])))
        assert np.array_equal(occupancy.passable, without(outer))
        assert seen.knowledge(occupancy)[3] == groups
        with pytest.raises(InvalidInputError, match="while discs are blocked"):
            occupancy.add(seen.rectangle(0, 0, 1, 1))
    assert np.array_equal(occupancy.passable, before)
    with occupancy.blocked(np.empty((0, 3))):
        assert np.array_equal(occupancy.passable, before)
    with pytest.raises(ZeroDivisionError), occupancy.blocked(outer):
        raise ZeroDivisionError
    assert np.array_equal(occupancy.passable, before)
    assert occupancy.revision == revision
    assert occupancy.add(seen.rectangle(-5, -5, -4, -4)) > 0


def test_cells_and_centres_correspond(seen):
    occupancy = Occupancy(0.3, 0.2)
    for x, y in ((0.0, 0.0), (-3.71, 8.2), (5e5, 4.5e6)):
        cell = occupancy.cell_of(x, y)
        centre = occupancy.centre_of(*cell)
        assert np.abs(np.subtract(centre, (x, y))).max() <= 0.15 + 1e-9
        assert occupancy.centres_of([cell]).tolist() == [list(centre)]
    occupancy.add(seen.rectangle(-3, 2, -1, 7))
    row, column = occupancy.cell_of(-2.0, 5.0)
    at = occupancy.indices_of([(row, column)])
    assert occupancy.cells[at] == FREE
    assert occupancy.x0 + (at[1][0] + 0.5) * 0.3 == pytest.approx(
        occupancy.centre_of(row, column)[0]
    )
    assert occupancy.y0 + (at[0][0] + 0.5) * 0.3 == pytest.approx(
        occupancy.centre_of(row, column)[1]
    )
    with pytest.raises(InvalidInputError, match=r"cell \(500, 0\) is not in the window"):
        occupancy.indices_of([(row, column), (500, 0)])


def test_blocked_cells_are_passable_while_they_are_unblocked(seen):
    occupancy = Occupancy(0.1, 0.2)
    occupancy.add(seen.rectangle(0, 0, 3, 3))
    free = occupancy.passable.copy()
    # The second disc lies in part within the first.
    with occupancy.blocked([(1.0, 1.5, 0.5)]):
        once = occupancy.passable.copy()
        with occupancy.blocked([(1.4, 1.5, 0.5)]):
            twice = occupancy.passable.copy()
            with occupancy.unblocked():
                assert (occupancy.passable == free).all()
            assert (occupancy.passable == twice).all()
        assert (occupancy.passable == once).all()
        assert once.sum() < free.sum()
        assert twice.sum() < once.sum()
    with occupancy.unblocked():
        assert (occupancy.passable == free).all()
    assert (occupancy.passable == free).all()


def test_unblocked_cannot_be_nested():
    occupancy = Occupancy(0.1, 0.2)
    with (
        occupancy.unblocked(),
        pytest.raises(InvalidInputError, match="cannot be nested"),
        occupancy.unblocked(),
    ):
        pass
    # It can be used again.
    with occupancy.unblocked():
        pass


def test_refuses_lengths_that_are_not_positive():
    for cell in (0.0, -1.0, np.nan, np.inf):
        with pytest.raises(InvalidInputError, match="positive width"):
            Occupancy(cell, 1.0)
    for radius in (0.0, -1.0, np.nan, np.inf):
        with pytest.raises(InvalidInputError, match="positive radius"):
            Occupancy(0.1, radius)
    with pytest.raises(InvalidInputError, match=r"choose at most 0\.4 m"):
        Occupancy(0.41, 0.2)
    assert Occupancy(0.4, 0.2).cell_m == 0.4
    occupancy = Occupancy(0.1, 0.2)
    with pytest.raises(InvalidInputError, match="finite"), occupancy.blocked([(0.0, np.nan, 1.0)]):
        pass


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf, 1e19, -1e300])
@pytest.mark.parametrize("corner", range(4))
@pytest.mark.parametrize("axis", range(2))
def test_refuses_regions_that_are_not_finite(bad, corner, axis, seen):
    corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]
    occupancy = Occupancy(0.1, 0.25)
    occupancy.add(seen.hand_made(corners, [OBSTACLE] * 4))
    before = seen.knowledge(occupancy)
    corners[corner][axis] = bad
    with pytest.raises(InvalidInputError, match="finite numbers of metres"):
        occupancy.add(seen.hand_made(corners, [OBSTACLE] * 4))
    assert seen.knowledge(occupancy) == before


def test_refuses_to_grow_beyond_the_limit(seen):
    occupancy = Occupancy(0.01, 0.2)
    occupancy.add(seen.rectangle(0, 0, 1, 1))
    before = seen.knowledge(occupancy)
    with pytest.raises(InvalidInputError, match=r"choose cells wider than 0\.01 m"):
        occupancy.add(seen.rectangle(900, 900, 901, 901))
    assert seen.knowledge(occupancy) == before


def test_cells_of_agrees_with_cell_of(worlds, seen):
    occupancy = hall_seen(seen, worlds)
    places = places_around(occupancy, 200, seed=1)
    assert [*map(tuple, occupancy.cells_of(places).tolist())] == [
        occupancy.cell_of(x, y) for x, y in places
    ]
    assert occupancy.cells_of(np.empty((0, 2))).shape == (0, 2)
    centred = occupancy.centres_of(occupancy.cells_of(places))
    assert np.abs(centred - places).max() <= 0.05 + 1e-9


def test_a_window_holds_the_same_cells_after_growth(seen):
    occupancy = Occupancy(0.1, 0.2)
    occupancy.add(seen.rectangle(0, 0, 1, 2))
    window = occupancy.changed_since(0)
    assert window is not None
    r0, r1, c0, c1 = occupancy.window_of(window)
    before = occupancy.cells[r0:r1, c0:c1].copy()
    assert (before == FREE).any()
    occupancy.add(seen.rectangle(-6, -5, -5, -4))
    assert occupancy.window_of(window) != (r0, r1, c0, c1)
    r0, r1, c0, c1 = occupancy.window_of(window)
    assert (occupancy.cells[r0:r1, c0:c1] == before).all()


@pytest.mark.slow
def test_cells_are_known_unless_unknown(worlds, seen):
    occupancy = hall_seen(seen, worlds)
    cells = np.argwhere(np.ones(occupancy.cells.shape, bool))
    for (row, column), (x, y) in [
        *zip(cells.tolist(), seen.centres(occupancy).tolist(), strict=True)
    ][::7]:
        assert occupancy.is_known(x, y) == (occupancy.cells[row, column] != UNKNOWN)
    assert not occupancy.is_known(1e3, 0.0)
    assert not occupancy.is_known(0.0, -1e3)
    assert not Occupancy(0.1, 0.2).is_known(0.0, 0.0)


@pytest.mark.parametrize("within", [0, 1, 3, 8])
def test_the_nearest_passable_cell_is_found(worlds, within, seen):
    occupancy = hall_seen(seen, worlds)
    passable = seen.in_lattice(occupancy, np.argwhere(occupancy.passable))
    found_any = found_none = 0
    for x, y in places_around(occupancy, 150, seed=2 + within):
        near = passable[np.abs(passable - occupancy.cell_of(x, y)).max(axis=1) <= within]
        found = occupancy.passable_near(x, y, within)
        if not len(near):
            assert found is None
            found_none += 1
            continue
        found_any += 1
        assert found in map(tuple, near.tolist())
        gaps = np.hypot(*(occupancy.centres_of(near) - (x, y)).T)
        gap = np.hypot(*(np.array(occupancy.centre_of(*found)) - (x, y)))
        assert gap == pytest.approx(gaps.min())
    assert found_any
    assert found_none


def test_of_equally_near_cells_the_first_is_taken(seen):
    occupancy = Occupancy(0.1, 0.15)
    occupancy.add(seen.rectangle(0, 0, 2, 2))
    x, y = occupancy.centre_of(*occupancy.cell_of(1.0, 1.0))
    row, column = occupancy.cell_of(x, y)
    with occupancy.blocked([(x, y, 0.01)]):
        assert occupancy.passable_near(x, y, 0) is None
        assert occupancy.passable_near(x, y, 2) == (row - 1, column)
    assert occupancy.passable_near(x, y, 2) == (row, column)


@pytest.mark.slow
def test_passable_centres_are_those_in_the_square(worlds, seen):
    occupancy = hall_seen(seen, worlds)
    passable = seen.in_lattice(occupancy, np.argwhere(occupancy.passable))
    some = 0
    for (x, y), half in zip(
        places_around(occupancy, 40, seed=9), [0.0, 0.5, 2.0, 50.0] * 10, strict=True
    ):
        reach = round(half / occupancy.cell_m)
        around = passable[np.abs(passable - occupancy.cell_of(x, y)).max(axis=1) <= reach]
        given = occupancy.passable_centres(x, y, half)
        assert given.tolist() == occupancy.centres_of(around).tolist()
        some += 0 < len(given) < len(passable)
    assert some >= 3
    assert len(occupancy.passable_centres(1e3, 1e3, 1.0)) == 0


@pytest.mark.parametrize("radius", [0.04, 0.25, 1.0])
def test_frontier_is_near_if_a_cell_centre_is(worlds, radius, seen):
    occupancy = hall_seen(seen, worlds)
    open_at = occupancy.centres_of(
        seen.in_lattice(occupancy, np.argwhere(seen.frontier(occupancy)))
    )
    answers = []
    for x, y in [*places_around(occupancy, 150, seed=3), *(open_at[::9] + 0.02).tolist()]:
        gap = np.hypot(*(open_at - (x, y)).T).min()
        if abs(gap - radius) > 1e-9:
            answers.append(occupancy.has_frontier_near(x, y, radius))
            assert answers[-1] == (gap < radius)
    assert {*answers} == {True, False}


def test_the_diagonal_is_that_of_the_window(seen):
    occupancy = Occupancy(0.1, 0.2)
    assert occupancy.diagonal_m == 0.0
    occupancy.add(seen.rectangle(0, 0, 3, 4))
    rows, columns = occupancy.cells.shape
    assert occupancy.diagonal_m == pytest.approx(0.1 * (rows**2 + columns**2) ** 0.5)
    assert occupancy.diagonal_m >= 5.0
